//! `proofmass validate`: does a calibration hold on new standstills?

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::positive;
use crate::{Failure, Outcome, clock, console};
use proofmass::core::Gravity;
use proofmass::io::Source;
use proofmass::jobs::validation::{ValidationJob, ValidationOutcome, ValidationRecording};
use proofmass::jobs::{Job, Outcome as _, RecordingReading, StoredResult};
use std::path::{Path, PathBuf};

/// Check a calibration on a recording it was not made from.
///
/// In each static interval of the recording ‖a‖ must be g: within 0.1 % each, and all together within what the
/// covariance of the calibration allows (χ²). A sensor of one axis rests with its axis up or down.
#[derive(clap::Args)]
pub(crate) struct Validate {
    /// calibration.json, or a result.json that holds it
    calibration: PathBuf,
    /// Recording with static intervals in any positions (up and down of one axis)
    recording: PathBuf,
    /// Local gravity in m/s² where the recording was made [default: that of the calibration]
    #[arg(long, value_name = "M_PER_S2", requires = "gravity_uncertainty")]
    gravity: Option<f64>,
    /// Its standard uncertainty in m/s²
    #[arg(long, value_name = "M_PER_S2", requires = "gravity")]
    gravity_uncertainty: Option<f64>,
    /// Table of static intervals (columns start, end) instead of searching for them
    #[arg(long, value_name = "FILE")]
    segments: Option<PathBuf>,
    /// Largest windowed variance of a static interval, in multiples of the noise floor
    #[arg(long, default_value_t = 6.0, allow_negative_numbers = true)]
    threshold: f64,
    /// Nominal output per m/s² of an uncompensated sensor, in the unit of its outputs: what "before" is held against [default: the mean of
    /// the three axes]
    #[arg(long, value_name = "VALUE", value_parser = positive)]
    nominal_sensitivity: Option<f64>,
    /// Its output at no acceleration
    #[arg(
        long,
        value_name = "VALUE",
        requires = "nominal_sensitivity",
        allow_negative_numbers = true,
        default_value_t = 0.0
    )]
    nominal_zero: f64,
    /// Read the recording as a stream, in bounded memory [default: above some 20 million rows, or 48 MiB through a pipe]
    ///
    /// Of more than a million rows means stand for them, as long as these take no more than a quarter of a second.
    #[arg(long, conflicts_with = "segments")]
    stream: bool,
    #[command(flatten)]
    reading: RecordingReading,
    #[command(flatten)]
    delivery: Delivery,
}

/// Rows above which a recording is not held in memory.
const MOST_IN_MEMORY: u64 = 20_000_000;

impl Validate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut inputs: Vec<&Path> = vec![&self.calibration, &self.recording];
        inputs.extend(self.segments.as_deref());
        let folder = self.delivery.begin(ValidationOutcome::KIND, &inputs)?;
        let watch = Progress::new();
        let calibration = Source::open(&self.calibration)?;
        let mut recorded = Source::open(&self.recording)?;
        let stream =
            self.stream || self.segments.is_none() && recorded.is_longer_than(MOST_IN_MEMORY)?;
        let recording = if stream {
            ValidationRecording::stream(calibration, recorded, &self.reading, &watch)?
        } else {
            let segments = self.segments.as_deref().map(Source::open);
            let segments = segments.transpose()?;
            ValidationRecording::read(calibration, recorded, &self.reading, segments)?
        };
        let mut job = ValidationJob::default();
        job.threshold = self.threshold;
        job.nominal = self.nominal_sensitivity.map(|s| [s, self.nominal_zero]);
        if let (Some(value), Some(u)) = (self.gravity, self.gravity_uncertainty) {
            job.gravity = Some(Gravity::given(value, u)?);
        }
        let record = recording.record(Some(clock::today()));
        let outcome = job.answer(&recording.data(), &record.inputs, &watch)?;
        let standstills = outcome.validation().attitudes.len();
        let ending = if standstills == 1 { "" } else { "s" };
        console::note(format!("{standstills} standstill{ending} found"));
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}
