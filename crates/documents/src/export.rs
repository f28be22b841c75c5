//! A calibration in the languages of those who use it: constants of Rust, a C header, Python, `imu.yaml`, plain JSON.
//!
//! What is written holds K⁻¹, so that nothing is inverted at start-up, and vectors that it can check itself with: a
//! handful of outputs with the accelerations the desk computed for them.

mod c;
mod c_fixed;
mod chain;
mod firmware;
mod imu;
mod json;
mod memory;
mod python;
mod rust;
mod vectors;

use crate::CalibrationFile;
pub use chain::{LowPassBehind, export_chain};
pub use firmware::{FirmwareBlock, LONGEST_AVERAGE, export_block};
pub(crate) use memory::unit_from;
use proofmass_core::FixedRange;
use proofmass_io::{Error, ErrorKind, Input, Result, Unit};
use proofmass_signal::AnyCompensation;
pub use vectors::SelfCheck;

/// A language or form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportForm {
    /// A constant for `proofmass-core`, with a test.
    Rust,
    /// A C99 header without dependencies or allocation.
    C,
    /// A Python module without dependencies, for floats and for arrays.
    Python,
    /// The IMU intrinsics of Kalibr.
    ImuYaml,
    /// Coefficients, units, uncertainty and vectors, for any other program.
    Json,
    /// A C99 header that reads the calibration memories of [`export_memory`], for any device.
    MemoryReader,
}

/// The numbers the exported code computes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportNumber {
    /// Single precision.
    #[default]
    Float,
    /// Double precision.
    Double,
    /// Integers in Q formats chosen for the range of the converter, with a bound on their error. C only.
    Fixed,
}

/// How a calibration is to be written.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ExportOptions {
    /// Name of the constant, function or module [default: from the device].
    pub name: Option<String>,
    /// Numbers of Rust and C.
    pub number: ExportNumber,
    /// Smallest and largest number out of the converter, for integers.
    pub outputs: Option<[i32; 2]>,
    /// The file it comes from.
    pub source: Option<Input>,
    /// Further lines of the heading: what holds for it, and what is to be done beside it.
    pub notes: Vec<String>,
}

/// Writes a calibration in another form.
///
/// ```
/// use proofmass_documents::{CalibrationFile, ExportForm, ExportOptions, export};
/// use proofmass_io::Unit;
/// use proofmass_uncertainty::Estimate;
///
/// let k = [[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [0.0, 0.0, 414.0]];
/// let estimate = Estimate::new(vec![], vec![]).unwrap();
/// let file = CalibrationFile::new("triangular", Unit::Count, k, [33_120.0, 33_271.0, 32_366.0], estimate);
/// let header = export(&file, ExportForm::C, &ExportOptions::default())?;
/// assert!(header.contains("static inline void accelerometer_apply(const float output[3], float acceleration[3])"));
/// # Ok::<(), proofmass_io::Error>(())
/// ```
///
/// # Errors
/// A calibration that cannot be applied; one that follows other quantities of the surroundings than the temperature
/// ([`CalibrationFile::at_environment`]); a form that cannot hold it (integers for outputs that are no counts, `imu.yaml` for raw outputs); a name that is no identifier.
pub fn export(file: &CalibrationFile, form: ExportForm, options: &ExportOptions) -> Result<String> {
    let plan = Plan::of(file, options)?;
    match (form, options.number) {
        (ExportForm::Rust, ExportNumber::Fixed) => Err(unable(
            "integers are written for C only",
            "add --number float or --number double; or --c in place of --rust",
        )),
        (ExportForm::Rust, number) => Ok(rust::text(&plan, number)),
        (ExportForm::C, ExportNumber::Fixed) => c_fixed::text(&plan, fixed_range(file, options)?),
        (ExportForm::C, number) => Ok(c::text(&plan, number)),
        (ExportForm::Python, _) => Ok(python::text(&plan)),
        (ExportForm::ImuYaml, _) => imu::text(&plan),
        (ExportForm::Json, _) => json::text(&plan),
        (ExportForm::MemoryReader, _) => memory::reader(&plan),
    }
}

/// The image of a calibration for the memory of a sensor module, a [`proofmass_core::CalibrationMemory`] in bytes.
///
/// # Errors
/// A calibration that cannot be applied; outputs in a unit without a code; a serial number of more than twenty bytes; a coefficient
/// beyond single precision.
pub fn export_memory(file: &CalibrationFile, options: &ExportOptions) -> Result<Vec<u8>> {
    memory::image(&Plan::of(file, options)?)
}

/// What every form is written from.
struct Plan<'a> {
    file: &'a CalibrationFile,
    model: AnyCompensation,
    check: SelfCheck,
    name: String,
    source: Option<&'a Input>,
    notes: &'a [String],
}

impl<'a> Plan<'a> {
    fn of(file: &'a CalibrationFile, options: &'a ExportOptions) -> Result<Self> {
        file.at_one_environment()?;
        let model = file.compensation()?;
        let check = SelfCheck::of(file, &model);
        let largest = model.bias().into_iter().chain(model.k_inverse().concat());
        let single = largest.fold(0.0f64, |m, v| m.max(v.abs())) < f64::from(f32::MAX)
            || options.number == ExportNumber::Double;
        if !(check.double_bound.is_finite() && single) {
            return Err(unable(
                "a coefficient is beyond the numbers of a chip",
                "look at K and b of the calibration, and calibrate again",
            ));
        }
        Ok(Self {
            file,
            check,
            model,
            name: name(file, options)?,
            source: options.source.as_ref(),
            notes: &options.notes,
        })
    }

    /// What a reader of the text must know, line by line.
    fn heading(&self) -> Vec<String> {
        let device = &self.file.device;
        let named: Vec<&str> = [&device.manufacturer, &device.model, &device.serial]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        let mut lines = vec![format!(
            "Calibration of {} by {}.",
            if named.is_empty() {
                "an accelerometer".to_owned()
            } else {
                named.join(" ")
            },
            self.file.software
        )];
        if let Some(source) = self.source {
            lines.push(format!("From {}, SHA-256 {}.", source.path, source.sha256));
        }
        lines.push(format!(
            "Input: {}; output: m/s^2.",
            self.file.input_unit.ascii()
        ));
        if let Some(block) = &self.file.temperature {
            let [low, high] = block.range;
            lines.push(format!(
                "Temperature in degC, measured from {low:?} to {high:?}; beyond that the coefficients do not hold."
            ));
        }
        if let Some(block) = &self.file.curvature {
            lines.push(format!("Curvature measured up to {:?} m/s^2.", block.reach));
        }
        lines.extend(self.notes.iter().cloned());
        plain_lines(&lines)
    }

    fn needs_temperature(&self) -> bool {
        self.file.temperature.is_some()
    }
}

/// Nothing of a file may end the comment it stands in, or begin another line.
fn plain_lines(lines: &[String]) -> Vec<String> {
    lines
        .iter()
        .map(|line| {
            let plain = line.replace("*/", "* /").replace("/*", "/ *");
            plain.chars().filter(|c| !c.is_control()).collect()
        })
        .collect()
}

fn unable(what: &str, hint: &str) -> Error {
    Error::new(ErrorKind::Configuration, what).with_hint(hint)
}

fn fixed_range(file: &CalibrationFile, options: &ExportOptions) -> Result<FixedRange> {
    if file.input_unit != Unit::Count {
        return Err(unable(
            &format!(
                "integers need outputs in counts, the calibration takes {}",
                file.input_unit.ascii()
            ),
            "calibrate the numbers as they come out of the converter",
        ));
    }
    let Some(outputs) = options.outputs else {
        return Err(unable(
            "the range of the converter is not known",
            "add its smallest and largest number: --outputs -32768,32767",
        ));
    };
    Ok(FixedRange {
        outputs: [outputs; 3],
        temperature: file.temperature.as_ref().map_or([0.0; 2], |t| t.range),
    })
}

/// A name that programs can have.
fn identifier(name: &str) -> Result<String> {
    let mut letters = name.chars();
    let begins = letters
        .next()
        .is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if begins && letters.all(|c| c.is_ascii_alphanumeric() || c == '_') && name.len() <= 60 {
        return Ok(name.to_owned());
    }
    Err(unable(
        &format!("{name:?} is no name in a program"),
        "letters, digits and _ without a digit at the beginning, 60 at most",
    ))
}

/// An identifier: the one asked for, or one from the device.
fn name(file: &CalibrationFile, options: &ExportOptions) -> Result<String> {
    if let Some(name) = &options.name {
        return identifier(name);
    }
    let device = &file.device;
    let words: Vec<&str> = [&device.model, &device.serial]
        .into_iter()
        .flatten()
        .map(String::as_str)
        .collect();
    let mut plain: String = words
        .join("_")
        .chars()
        .take(60)
        .map(|c| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        })
        .collect();
    if plain.chars().all(|c| c == '_') {
        plain = "accelerometer".to_owned();
    }
    if plain.starts_with(|c: char| c.is_ascii_digit()) {
        plain.insert_str(0, "sensor_");
    }
    Ok(plain)
}

/// A number with as many digits as bring back the same single or double.
fn literal(value: f64, single: bool) -> String {
    if single {
        format!("{:e}", value as f32)
    } else {
        format!("{value:e}")
    }
}
