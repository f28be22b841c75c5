//! `proofmass validate`: does a calibration hold on new standstills?

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::recording_arguments::RecordingArguments;
use crate::{Failure, Outcome, clock, console};
use proofmass::calibration::Segment;
use proofmass::core::Gravity;
use proofmass::io::{CalibrationFile, Input, Recording, Source};
use proofmass::jobs::multi_position::{Stamps, segment};
use proofmass::jobs::validation::{ValidationData, ValidationJob, ValidationOutcome};
use proofmass::jobs::{Filed, Job, Outcome as _, Record};
use std::path::{Path, PathBuf};

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
        let mut inputs: Vec<&Path> = vec![&self.calibration, &self.recording];
        inputs.extend(self.segments.as_deref());
        let folder = self.delivery.begin(ValidationOutcome::KIND, &inputs)?;
        let (file, calibration) = CalibrationFile::from_source(Source::open(&self.calibration)?)?;
        let reading = self.reading.reading();
        let mut recording = Recording::read(&self.recording, &reading.options(&file)?)?;
        for column in &mut recording.columns {
            let factor = reading
                .factor(file.input_unit, &column.name, column.unit)
                .map_err(|trouble| trouble.detail(self.recording.display().to_string()))?;
            column.data.iter_mut().for_each(|v| *v *= factor);
        }
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Failure::new("three columns are needed"));
        };
        let (segments, given) = self.given(&recording)?.unzip();
        let mut job = ValidationJob::default();
        job.threshold = self.threshold;
        if let (Some(value), Some(u)) = (self.gravity, self.gravity_uncertainty) {
            job.gravity = Some(Gravity::given(value, u)?);
        }
        let stamps = Stamps::of(&recording);
        let name = self.recording.display().to_string();
        let data = ValidationData {
            calibration: &file,
            outputs: [&x.data, &y.data, &z.data],
            rate: stamps.rate,
            breaks: &stamps.breaks,
            segments: segments.as_deref(),
            findings: recording.findings(),
            sha256: Some(&recording.sha256),
            name: &name,
        };
        let outcome = job.evaluate(&data, &Progress::new())?;
        let standstills = outcome.validation().attitudes.len();
        let ending = if standstills == 1 { "" } else { "s" };
        console::note(format!("{standstills} standstill{ending} found"));
        let record = Record {
            device: file.device.clone(),
            date: Some(clock::today()),
            inputs: [calibration, recording.input()]
                .into_iter()
                .chain(given)
                .collect(),
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }

    fn given(&self, recording: &Recording) -> Result<Option<(Vec<Segment>, Input)>, Failure> {
        let Some(path) = &self.segments else {
            return Ok(None);
        };
        let (given, input) =
            proofmass::io::SegmentRow::from_source(Source::open(path)?, recording)?;
        Ok(Some((given.into_iter().map(segment).collect(), input)))
    }
}
