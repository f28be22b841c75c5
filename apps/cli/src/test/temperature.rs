//! `proofmass test temperature`.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::recording_arguments::RecordingArguments;
use crate::{Failure, Outcome, clock};
use proofmass::io::{CalibrationFile, ColumnRef, Input, Recording};
use proofmass::jobs::temperature::{TemperatureData, TemperatureJob, TemperatureOutcome};
use proofmass::jobs::{Filed, Job, Outcome as _, Record};
use std::path::PathBuf;

/// Temperature coefficients of a resting accelerometer, from plateaus or a continuous sweep.
///
/// Slopes and polynomials per axis with one joint covariance; hysteresis where the sensor was heated and cooled; an attitude
/// that changed on the way is found, and where it leaves nothing to conclude from, that is said. With --calibration, the
/// result holds that calibration with the coefficients in it.
#[derive(clap::Args)]
pub(super) struct Temperature {
    /// Recording with outputs and temperature
    recording: PathBuf,
    /// Column of the temperature in °C, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    temperature: String,
    /// Calibration at one temperature that is to get the coefficients
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Reference temperature in °C [default: that of the calibration, else the middle of the range]
    #[arg(long, value_name = "DEG_C", allow_negative_numbers = true)]
    reference: Option<f64>,
    /// Largest power of the temperature
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    order: u8,
    #[command(flatten)]
    reading: RecordingArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Temperature {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut protected = vec![self.recording.as_path()];
        protected.extend(self.calibration.as_deref());
        let folder = self.delivery.begin(TemperatureOutcome::KIND, &protected)?;
        let calibration = self
            .calibration
            .as_deref()
            .map(CalibrationFile::read)
            .transpose()?;
        let reading = self.reading.reading();
        let mut options = match &calibration {
            Some(calibration) => reading.options(calibration)?,
            None => reading.options_alone()?,
        };
        options.temperature = Some(ColumnRef::from_word(&self.temperature));
        let recording = Recording::read(&self.recording, &options)?;
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Failure::new("three columns are needed"));
        };
        let Some(temperature) = &recording.temperature else {
            return Err(Failure::new("the recording has no temperature"));
        };
        let name = self.recording.display().to_string();
        let unit = reading
            .common_unit([x, y, z])
            .map_err(|e| e.detail(name.clone()))?;
        let mut job = TemperatureJob::default();
        job.sweep.largest_order = usize::from(self.order);
        job.sweep.reference = self.reference;
        let outcome = job.evaluate(
            &TemperatureData {
                outputs: [&x.data, &y.data, &z.data],
                unit,
                temperature: &temperature.data,
                rate: recording.time.rate_hz(),
                calibration: calibration.as_ref(),
                findings: recording.findings(),
                name: &name,
            },
            &Progress::new(),
        )?;
        let mut inputs = vec![recording.input()];
        if let Some(path) = &self.calibration {
            inputs.push(Input::of(path)?);
        }
        let record = Record {
            device: calibration.map(|c| c.device).unwrap_or_default(),
            date: Some(clock::today()),
            inputs,
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}
