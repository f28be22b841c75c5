//! `proofmass export`: a calibration for firmware and for other programs.

use crate::{Failure, Outcome, console};
use proofmass::io::{
    AtomicFile, CalibrationFile, ExportForm, ExportNumber, ExportOptions, Source, export,
};
use std::path::PathBuf;

/// Write a calibration as a constant of Rust, a C header, a Python module, imu.yaml or plain JSON.
///
/// K⁻¹ is in it, so that nothing is inverted at start-up, and so are temperature and curvature where the calibration has
/// them. Each of Rust, C and Python checks itself: it holds outputs with the accelerations that were computed here.
#[derive(clap::Args)]
pub(crate) struct Export {
    /// calibration.json written by `proofmass calibrate`
    calibration: PathBuf,
    #[command(flatten)]
    form: Form,
    /// Numbers of Rust and C
    #[arg(long, value_enum, default_value_t = Number::Float)]
    number: Number,
    /// Smallest and largest number out of the converter, for `--number fixed`
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    outputs: Option<[i32; 2]>,
    /// Name of the constant or function [default: from the device]
    #[arg(long)]
    name: Option<String>,
    /// File to write, replaced if it is there [default: standard output]
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

impl Export {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let (file, input) = CalibrationFile::from_source(Source::open(&self.calibration)?)?;
        let form = match self.form {
            Form { rust: true, .. } => ExportForm::Rust,
            Form { c: true, .. } => ExportForm::C,
            Form { python: true, .. } => ExportForm::Python,
            Form { imu_yaml: true, .. } => ExportForm::ImuYaml,
            _ => ExportForm::Json,
        };
        let mut options = ExportOptions::default();
        options.name = self.name;
        options.outputs = self.outputs;
        options.source = Some(input);
        options.number = match self.number {
            Number::Float => ExportNumber::Float,
            Number::Double => ExportNumber::Double,
            Number::Fixed => ExportNumber::Fixed,
        };
        let text = export(&file, form, &options)?;
        match self.output {
            None => console::print(&text)?,
            Some(path) => {
                let mut output = AtomicFile::create(&path, &[self.calibration.as_path()])?;
                output.write_all(text.as_bytes())?;
                output.commit()?;
                console::note(format!("written: {}", path.display()));
            }
        }
        Ok(Outcome::Done)
    }
}
