//! A recording over temperature as files have it.

use super::TemperatureData;
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_io::{CalibrationFile, ColumnRef, Input, Recording, Source, Unit};

/// Outputs and temperature of a resting sensor, with the calibration that is to get the coefficients.
#[derive(Clone, Debug)]
pub struct TemperatureRecording {
    recording: Recording,
    temperature: Vec<f64>,
    unit: Unit,
    calibration: Option<CalibrationFile>,
    name: String,
    inputs: Vec<Input>,
}

impl TemperatureRecording {
    /// Reads the recording, and the calibration where one is given.
    ///
    /// # Errors
    /// A file that cannot be read, columns that neither the reading nor the calibration names, units that differ.
    pub fn read(
        source: Source,
        temperature: ColumnRef,
        reading: &RecordingReading,
        calibration: Option<Source>,
    ) -> Result<Self> {
        let name = source.name().display().to_string();
        let calibration = calibration.map(CalibrationFile::from_source).transpose()?;
        let mut options = match &calibration {
            Some((file, _)) => reading.options(file)?,
            None => reading.options_of_axes()?,
        };
        options.temperature = Some(temperature);
        let recording = Recording::from_source(source, &options)?;
        let unit = reading.common_unit(&recording);
        let Some(column) = &recording.temperature else {
            return Err(Trouble::data("the recording has no temperature").detail(name));
        };
        let (calibration, of_calibration) = calibration.unzip();
        Ok(Self {
            temperature: column.data.clone(),
            unit: unit.map_err(|e| e.detail(name.clone()))?,
            inputs: std::iter::once(recording.input())
                .chain(of_calibration)
                .collect(),
            calibration,
            name,
            recording,
        })
    }

    /// For the job.
    pub fn data(&self) -> TemperatureData<'_> {
        TemperatureData {
            outputs: self
                .recording
                .columns
                .iter()
                .map(|c| c.data.as_slice())
                .collect(),
            unit: self.unit,
            temperature: &self.temperature,
            rate: self.recording.time.rate_hz(),
            calibration: self.calibration.as_ref(),
            findings: self.recording.findings(),
            name: &self.name,
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        let device = self.calibration.as_ref().map(|c| c.device.clone());
        Record {
            device: device.unwrap_or_default(),
            date,
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}
