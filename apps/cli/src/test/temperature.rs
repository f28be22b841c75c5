//! `proofmass test temperature`.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::positive;
use crate::{Failure, Outcome, clock};
use proofmass::io::{ColumnRef, Source};
use proofmass::jobs::temperature::{
    EnvironmentalRequest, TemperatureJob, TemperatureOutcome, TemperatureRecording,
};
use proofmass::jobs::{Job, Outcome as _, RecordingReading, StoredResult};
use std::path::PathBuf;

/// Temperature coefficients of a resting accelerometer.
///
/// From plateaus or a continuous sweep: slopes and polynomials per axis with one joint covariance, and hysteresis where the
/// sensor was heated and cooled. A change of position during the sweep is reported, and refused where it leaves nothing to
/// conclude from. With --calibration, the
/// result holds that calibration with the coefficients in it.
#[derive(clap::Args)]
pub(super) struct Temperature {
    /// Recording with outputs and temperature
    recording: PathBuf,
    /// Column of the temperature in °C, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    temperature: ColumnRef,
    /// Column of another quantity of the surroundings (humidity, pressure, supply voltage), with its unit where the heading does not say it,
    /// and the value at which its coefficients change nothing [default: the middle]; more than once
    #[arg(long, value_name = "COLUMN[:UNIT][=REFERENCE]")]
    environment: Vec<EnvironmentalRequest>,
    /// Calibration at one temperature that is to get the coefficients
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Reference temperature in °C [default: that of the calibration, else the middle of the range]
    #[arg(long, value_name = "DEG_C", allow_negative_numbers = true)]
    reference: Option<f64>,
    /// Largest power of the temperature
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    order: u8,
    /// The sensor was switched on when the recording began: fit its self-heating, with a time constant up to this many
    /// seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    warm_up: Option<f64>,
    /// Where the recording was interrupted while the temperature changed: standard uncertainty, in degrees, of how the
    /// sensor was kept in its attitude [default: any tilt that the outputs leave possible]
    #[arg(long, value_name = "DEG", value_parser = positive)]
    tilt: Option<f64>,
    #[command(flatten)]
    reading: RecordingReading,
    #[command(flatten)]
    delivery: Delivery,
}

impl Temperature {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut protected = vec![self.recording.as_path()];
        protected.extend(self.calibration.as_deref());
        let folder = self.delivery.begin(TemperatureOutcome::KIND, &protected)?;
        let calibration = self.calibration.as_deref().map(Source::open);
        let recording = TemperatureRecording::read(
            Source::open(&self.recording)?,
            self.temperature,
            &self.environment,
            &self.reading,
            calibration.transpose()?,
        )?;
        let mut job = TemperatureJob::default();
        job.sweep.largest_order = usize::from(self.order);
        job.sweep.reference = self.reference;
        job.sweep.warm_up = self.warm_up;
        job.sweep.tilt = self.tilt.map(f64::to_radians);
        let record = recording.record(Some(clock::today()));
        let outcome = job.answer(&recording.data(), &record.inputs, &Progress::new())?;
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}
