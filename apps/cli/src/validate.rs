//! `proofmass validate`: does a calibration hold on new standstills?

use crate::delivery::{Delivery, Results};
use crate::plural::count;
use crate::recording_arguments::RecordingArguments;
use crate::{Failure, Outcome, clock, console};
use proofmass::calibration::{
    Calibrated, MeanNoise, Samples, Segment, Standstill, Validation, WindowedVariance,
};
use proofmass::core::{Gravity, Matrix3, SensorModel};
use proofmass::io::{CalibrationFile, Input, OutputFolder, Recording, ResultDocument, Software};
use proofmass::report::ValidationReport;
use proofmass::uncertainty::{Finding, Severity};
use std::path::PathBuf;

/// Check a calibration on a recording it was not made from.
///
/// Each standstill of the recording must read ‖a‖ = g: within 0.1 % each, and all together within what the
/// covariance of the calibration allows (χ²).
#[derive(clap::Args)]
pub(crate) struct Validate {
    /// calibration.json written by `proofmass calibrate`
    calibration: PathBuf,
    /// Recording with standstills in attitudes of any kind
    recording: PathBuf,
    /// Local gravity in m/s² where the recording was made [default: that of the calibration]
    #[arg(long, value_name = "M_PER_S2", requires = "gravity_uncertainty")]
    gravity: Option<f64>,
    /// Its standard uncertainty in m/s²
    #[arg(long, value_name = "M_PER_S2", requires = "gravity")]
    gravity_uncertainty: Option<f64>,
    /// Table of standstills (columns start, end) instead of searching for them
    #[arg(long, value_name = "FILE")]
    segments: Option<PathBuf>,
    /// Largest windowed variance of a standstill in multiples of the noise floor
    #[arg(long, default_value_t = 6.0, allow_negative_numbers = true)]
    threshold: f64,
    #[command(flatten)]
    reading: RecordingArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Validate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(&[&self.calibration, &self.recording])?;
        let file = CalibrationFile::read(&self.calibration)?;
        let sensor = SensorModel::new(Matrix3(file.k), file.b)?;
        let mut recording = Recording::read(&self.recording, &self.reading.options(&file)?)?;
        for column in &mut recording.columns {
            let factor = self
                .reading
                .factor(&file, &column.name, column.unit)
                .map_err(|failure| failure.detail(self.recording.display().to_string()))?;
            column.data.iter_mut().for_each(|v| *v *= factor);
        }
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Failure::new("three columns are needed"));
        };
        let samples = Samples::new(&x.data, &y.data, &z.data)?;
        let segments = self.find(&recording, &samples)?;
        if segments.is_empty() {
            return Err(Failure::new("no standstill was found")
                .detail(self.recording.display().to_string())
                .hint(
                    "a standstill takes two seconds or more; raise --threshold, or give --segments",
                ));
        }
        let noise = MeanNoise::estimate(&samples, &segments)?;
        let gravity = self.gravities(&file)?;
        let calibrated = Calibrated {
            sensor: &sensor,
            estimate: &file.estimate,
            gravity: gravity.0,
            repeatability: file.repeatability.unwrap_or(0.0),
            nominal_sensitivity: file.input_unit.is_acceleration().then_some(1.0),
        };
        let validation =
            Validation::run(&calibrated, gravity.1, &noise.poses(&samples, &segments))?;
        console::note(format!("{} found", count(segments.len(), "standstill")));
        self.write(folder, &file, &recording, &validation)
    }

    fn find(&self, recording: &Recording, samples: &Samples<'_>) -> Result<Vec<Segment>, Failure> {
        if let Some(path) = &self.segments {
            let given = proofmass::io::Segment::read(path, recording)?;
            let segments = given.into_iter().map(|s| Segment {
                start: s.start,
                end: s.end,
                attitude: s.attitude,
                label: s.label,
            });
            return Ok(segments.collect());
        }
        if !(self.threshold > 1.0 && self.threshold.is_finite()) {
            return Err(Failure::new(format!(
                "--threshold {} must be larger than 1",
                self.threshold
            )));
        }
        let breaks: Vec<usize> = recording
            .time
            .gaps()
            .iter()
            .map(|g| g.after_sample + 1)
            .collect();
        let search = Standstill::default();
        let windowed =
            WindowedVariance::new(samples, recording.time.rate_hz(), &breaks, &search)
                .map_err(|e| Failure::from(e).detail(self.recording.display().to_string()))?;
        Ok(windowed.segments(self.threshold))
    }

    /// Gravity of the calibration, and that of the validation where it is another.
    fn gravities(&self, file: &CalibrationFile) -> Result<(Gravity, Option<Gravity>), Failure> {
        let here = match (self.gravity, self.gravity_uncertainty) {
            (Some(value), Some(u)) => Some(Gravity::given(value, u)?),
            _ => None,
        };
        let there = match (&file.gravity, here) {
            (Some(q), _) => Gravity::given(q.value, q.standard_uncertainty)?,
            (None, Some(here)) => here,
            (None, None) => {
                return Err(Failure::new(
                    "the calibration does not say which gravity it was made with",
                )
                .hint("add --gravity and --gravity-uncertainty"));
            }
        };
        Ok((there, here))
    }

    fn write(
        &self,
        folder: Option<OutputFolder>,
        file: &CalibrationFile,
        recording: &Recording,
        validation: &Validation,
    ) -> Result<Outcome, Failure> {
        let mut findings = recording.findings().to_vec();
        findings.extend(validation.findings.iter().cloned());
        let inputs = [Input::of(&self.calibration)?, recording.input()];
        if file.inputs.iter().any(|i| i.sha256 == recording.sha256) {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "same-recording",
                    "the calibration was made from this very recording: agreement proves nothing",
                )
                .advice("record new standstills and validate with them"),
            );
        }
        let mut document = ResultDocument::new("validation")
            .device(&file.device)
            .model(file.model.clone())
            .findings(&findings);
        for input in &inputs {
            document = document.input(input.clone());
        }
        let json = document
            .section("date", &clock::today())?
            .section("validation", validation)?
            .to_json()?;
        let text = ValidationReport {
            title: "Validation of a calibration".to_owned(),
            meta: vec![("Evaluated on".to_owned(), clock::today())],
            inputs: inputs.into_iter().map(|i| (i.path, i.sha256)).collect(),
            findings: &findings,
            footer: Software::default().to_string(),
        };
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.summary(validation),
                report: &|| text.full(validation),
                files: vec![],
                findings: &findings,
            },
        )
    }
}
