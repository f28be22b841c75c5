//! `proofmass export` and `proofmass filter`: calibrations, filters and gains for firmware and for other programs.

use crate::at_arguments::AtArguments;
use crate::chain_arguments::ChainArguments;
use crate::number_arguments::positive;
use crate::{Failure, Outcome, console};
use proofmass::documents::{
    AnyCalibration, CalibrationFile, ExportForm, ExportNumber, ExportOptions, FirmwareBlock,
    export, export_block, export_chain, export_memory, is_calibration_memory,
};
use proofmass::io::{AtomicFile, LARGEST_DOCUMENT, Source};
use proofmass::jobs::StoredResult;
use proofmass::jobs::apply::calibration_of_band;
use proofmass::jobs::firmware::{GainsOf, firmware};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Write a calibration as source code (C, Rust, Python), imu.yaml, JSON or the image of a memory.
///
/// Of a result of `bias`, `velocity tune` or `velocity map` it writes the filter, the gains or the encoder map.
///
/// Of a calibration over frequency, such as that of a shaker, it writes the constant matrix of a band with its stated error (--band).
///
/// K⁻¹ is in it, so that nothing is inverted at start-up, and so are temperature and curvature where the calibration has
/// them. Each of Rust, C and Python checks itself: it holds outputs with the accelerations that were computed here.
#[derive(clap::Args)]
pub(crate) struct Export {
    /// calibration.json, or result.json of a test of one axis, of `bias`, `velocity tune` or `velocity map`, or the folder that holds it
    calibration: PathBuf,
    #[command(flatten)]
    form: Form,
    /// Numbers of Rust and C
    #[arg(long, value_enum, default_value_t = Number::Float)]
    number: Number,
    /// Calibration over frequency: the constant real matrix of this band in hertz; one frequency twice is that alone
    #[arg(long, value_name = "LOW,HIGH", value_parser = crate::number_arguments::band_or_frequency)]
    band: Option<[f64; 2]>,
    #[command(flatten)]
    at: AtArguments,
    #[command(flatten)]
    chain: ChainArguments,
    /// Sampling rate in hertz, for --low-pass
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "low_pass")]
    rate: Option<f64>,
    /// Which gains of `velocity tune` [default: kalman]
    #[arg(long, value_enum)]
    method: Option<GainsOf>,
    /// Smallest and largest number out of the converter, for `--number fixed`
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    outputs: Option<[i32; 2]>,
    /// Name of the constant or function [default: from the device]
    #[arg(long)]
    name: Option<String>,
    /// File to write, replaced if proofmass wrote it [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Form {
    /// Constant for the crate proofmass-core
    #[arg(long)]
    rust: bool,
    /// C99 header without dependencies
    #[arg(long)]
    c: bool,
    /// Python module without dependencies
    #[arg(long)]
    python: bool,
    /// IMU intrinsics of Kalibr (calibrations of outputs in m/s²)
    #[arg(long)]
    imu_yaml: bool,
    /// Coefficients, units, covariance and check vectors
    #[arg(long)]
    json: bool,
    /// Image for the memory of the device, with serial number and checksum; needs -o
    #[arg(long, requires = "output")]
    memory: bool,
    /// C99 header that reads such images, of any device
    #[arg(long)]
    memory_reader: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Number {
    /// Single precision
    Float,
    /// Double precision
    Double,
    /// Integers, with a bound on their error (C)
    Fixed,
}

fn range(text: &str) -> Result<[i32; 2], String> {
    let numbers = text
        .split_once(',')
        .and_then(|(low, high)| Some([low.trim().parse().ok()?, high.trim().parse().ok()?]));
    match numbers {
        Some([low, high]) if low < high => Ok([low, high]),
        _ => Err("two whole numbers are needed, such as -32768,32767".to_owned()),
    }
}

impl Form {
    fn chosen(&self) -> ExportForm {
        match self {
            Self { rust: true, .. } => ExportForm::Rust,
            Self { c: true, .. } => ExportForm::C,
            Self { python: true, .. } => ExportForm::Python,
            Self { imu_yaml: true, .. } => ExportForm::ImuYaml,
            Self {
                memory_reader: true,
                ..
            } => ExportForm::MemoryReader,
            _ => ExportForm::Json,
        }
    }
}

impl From<Number> for ExportNumber {
    fn from(number: Number) -> Self {
        match number {
            Number::Float => Self::Float,
            Number::Double => Self::Double,
            Number::Fixed => Self::Fixed,
        }
    }
}

/// Whether what stands there was exported: every form names the program near its beginning.
fn is_ours(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = std::fs::File::open(path).map(|file| file.take(1 << 16).read_to_end(&mut head));
    read.is_ok()
        && (is_calibration_memory(&head) || String::from_utf8_lossy(&head).contains("proofmass"))
}

/// To the file that was named, or to standard output.
fn write(bytes: &[u8], output: Option<&Path>, inputs: &[&Path]) -> Result<Outcome, Failure> {
    match output {
        None => console::print(&String::from_utf8_lossy(bytes))?,
        Some(path) => {
            if console::stands(path) && !console::may_replace(path, is_ours(path)) {
                return Err(Failure::new(format!(
                    "{} is there, and was not written by `proofmass`",
                    path.display()
                ))
                .hint("name another file, or remove it"));
            }
            let mut output = AtomicFile::create(path, inputs)?;
            output.write_all(bytes)?;
            output.commit()?;
            console::note(format!("written: {}", path.display()));
        }
    }
    Ok(Outcome::Done)
}

impl Export {
    pub(crate) fn run(mut self) -> Result<Outcome, Failure> {
        self.calibration = StoredResult::calibration_place(&self.calibration);
        let name = self.calibration.display().to_string();
        let (bytes, input) = Source::open(&self.calibration)?.into_bytes(LARGEST_DOCUMENT)?;
        let form = self.form.chosen();
        let mut options = ExportOptions::default();
        options.name = self.name.clone();
        options.outputs = self.outputs;
        console::doubt(&input);
        options.source = Some(input);
        options.number = self.number.into();
        let calibration = AnyCalibration::from_json(&bytes);
        let text = if calibration.is_err() && proofmass::documents::is_result(&bytes) {
            if !self.chain.chain()?.0.is_empty() {
                return Err(
                    Failure::new("steps follow a calibration, and this is another result")
                        .detail(name)
                        .hint("export the calibration with them, and this result by itself"),
                );
            }
            if !self.at.at.is_empty() {
                return Err(Failure::new(
                    "--at is about a calibration, and this is another result",
                )
                .detail(name)
                .hint("leave --at out"));
            }
            let found = firmware(&bytes, self.method.unwrap_or_default());
            let found = found.map_err(|e| e.detail(name.clone()))?;
            options.notes = found.notes;
            if self.form.memory {
                return Err(Failure::new(
                    "a memory keeps a calibration, and this is another result",
                )
                .detail(name)
                .hint("--c, --rust and --json write it for the chip"));
            }
            export_block(&found.block, form, &options)?.into_bytes()
        } else {
            if self.method.is_some() {
                return Err(Failure::new("a calibration has no gains to choose from")
                    .hint("--method belongs to a result of `proofmass velocity tune`"));
            }
            if let Ok(calibration) = &calibration {
                let held = self.at.words(calibration);
                options
                    .notes
                    .extend(held.iter().map(|w| format!("Holds {w}.")));
            }
            let calibration = calibration
                .and_then(|c| c.at_environment(&self.at.at))
                .map_err(|e| e.at(&self.calibration))?;
            match (calibration, self.band) {
                (AnyCalibration::Constant(file), None) => self.chained(*file, form, options)?,
                (AnyCalibration::FrequencyResponse(_), None) => {
                    return Err(Failure::new(
                        "the calibration is one over frequency: no single matrix stands for all of it",
                    )
                    .detail(name)
                    .hint("add --band LOW,HIGH for the constant matrix of a band, which states its error"));
                }
                (calibration, Some(band)) => {
                    let (file, notes) =
                        calibration_of_band(&calibration, band).map_err(|e| e.detail(name))?;
                    options.notes.extend(notes);
                    self.chained(file, form, options)?
                }
                _ => {
                    return Err(
                        Failure::new("this kind of calibration cannot be written out")
                            .hint("`proofmass apply` uses it on recordings"),
                    );
                }
            }
        };
        let mut inputs = vec![self.calibration.as_path()];
        inputs.extend(self.chain.mounting());
        write(&text, self.output.as_deref(), &inputs)
    }
}

impl Export {
    /// A calibration with what follows it: the rotation within its matrix, low-pass and decimation behind it.
    fn chained(
        &self,
        file: CalibrationFile,
        form: ExportForm,
        mut options: ExportOptions,
    ) -> Result<Vec<u8>, Failure> {
        let (chain, mounting) = self.chain.chain()?;
        let turned = mounting.map(|i| format!("Turned by {}, SHA-256 {}.", i.path, i.sha256));
        options.notes.extend(turned);
        let name = self.calibration.display().to_string();
        chain
            .check(file.axes())
            .map_err(|e| e.detail(name.clone()))?;
        options.notes.extend(chain.notes());
        let file = match &chain.rotation {
            Some(rotation) => file
                .turned(&rotation.matrix()?)
                .map_err(|e| e.at(&self.calibration))?,
            None => file,
        };
        if self.form.memory && chain.low_pass.is_some() {
            return Err(Failure::new("a memory keeps a calibration, and no low-pass")
                .detail(name)
                .hint("leave out --low-pass and --decimate; `proofmass filter` writes the filter by itself"));
        }
        let Some(low_pass) = chain.low_pass else {
            return Ok(match self.form.memory {
                true => export_memory(&file, &options)?,
                false => export(&file, form, &options)?.into_bytes(),
            });
        };
        let Some(rate) = self.rate else {
            return Err(Failure::new(
                "a low-pass needs the sampling rate, which a calibration does not state",
            )
            .detail(name)
            .hint("add --rate HZ"));
        };
        let behind = chain.behind(low_pass, rate)?;
        if let Some(finding) = chain.folds(rate)? {
            console::finding(&finding);
        }
        Ok(export_chain(&file, &behind, form, &options)?.into_bytes())
    }
}

/// Design a low-pass filter and write it as source code (C, Rust) or JSON.
///
/// A Butterworth low-pass of second order or a moving average, with its group delay.
#[derive(clap::Args)]
pub(crate) struct Filter {
    #[command(flatten)]
    kind: FilterKind,
    /// Sampling rate in hertz
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: f64,
    #[command(flatten)]
    form: FilterForm,
    /// Numbers of Rust and C
    #[arg(long, value_enum, default_value_t = Real::Float)]
    number: Real,
    /// Name of the constant or function [default: from the filter]
    #[arg(long)]
    name: Option<String>,
    /// File to write, replaced if proofmass wrote it [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct FilterKind {
    /// Butterworth of second order with this corner in hertz (−3.01 dB)
    #[arg(long, value_name = "HZ", value_parser = positive)]
    low_pass: Option<f64>,
    /// Mean of this many samples
    #[arg(long, value_name = "N")]
    mean: Option<usize>,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct FilterForm {
    /// Constant for the crate proofmass-core
    #[arg(long)]
    rust: bool,
    /// C99 header without dependencies
    #[arg(long)]
    c: bool,
    /// Coefficients, group delay and check vectors
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Real {
    /// Single precision
    Float,
    /// Double precision
    Double,
}

impl Filter {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let rate = self.rate;
        let block = match (self.kind.low_pass, self.kind.mean) {
            (Some(corner), _) => FirmwareBlock::LowPass { corner, rate },
            (None, samples) => FirmwareBlock::MovingAverage {
                samples: samples.unwrap_or_default(),
                rate,
            },
        };
        let form = match self.form {
            FilterForm { rust: true, .. } => ExportForm::Rust,
            FilterForm { c: true, .. } => ExportForm::C,
            _ => ExportForm::Json,
        };
        let mut options = ExportOptions::default();
        options.name = self.name;
        options.number = match self.number {
            Real::Float => ExportNumber::Float,
            Real::Double => ExportNumber::Double,
        };
        let text = export_block(&block, form, &options)?;
        write(text.as_bytes(), self.output.as_deref(), &[])
    }
}
