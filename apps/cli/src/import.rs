//! `proofmass import`: coefficients of other programs as a calibration.

use crate::{Failure, Outcome, console};
use proofmass::documents::{CoefficientForm, import_coefficients};
use proofmass::io::{AtomicFile, Source, Unit};
use std::path::PathBuf;

/// Make a calibration.json from the coefficients of another program.
///
/// It can be applied and exported. These files state no uncertainty, so the calibration has none; `proofmass calibrate`
/// on the same recording gives one.
#[derive(clap::Args)]
pub(crate) struct Import {
    /// File with the coefficients
    coefficients: PathBuf,
    /// Form of the file
    #[arg(long, value_enum)]
    form: Form,
    /// Unit of the outputs the coefficients apply to: count, m/s², g, mg, V, …
    #[arg(long)]
    unit: Unit,
    /// Unit of the corrected values of Magneto, that of the norm it was given
    #[arg(long, value_name = "UNIT", default_value = "m/s²")]
    corrected_unit: Unit,
    /// File to write, replaced if it is there
    #[arg(short, long, value_name = "FILE", default_value = "calibration.json")]
    output: PathBuf,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Form {
    /// Bias x, y, z and output units per m/s² of x, y, z
    SixParameters,
    /// Combined bias and A⁻¹
    Magneto,
    /// Misalignment, scale and bias of imu_tk
    ImuTk,
    /// JSON of imucal (Ferraris)
    Imucal,
    /// YAML of Kalibr (M of the accelerometers)
    Kalibr,
}

impl Import {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let form = match self.form {
            Form::SixParameters => CoefficientForm::SixParameters,
            Form::Magneto => CoefficientForm::Magneto,
            Form::ImuTk => CoefficientForm::ImuTk,
            Form::Imucal => CoefficientForm::Imucal,
            Form::Kalibr => CoefficientForm::Kalibr,
        };
        let source = Source::open(&self.coefficients)?;
        let file = import_coefficients(source, form, self.unit, self.corrected_unit)?;
        let mut output = AtomicFile::create(&self.output, &[self.coefficients.as_path()])?;
        output.write_all(&file.to_json()?)?;
        output.commit()?;
        console::note(format!("written: {}", self.output.display()));
        Ok(Outcome::Done)
    }
}
