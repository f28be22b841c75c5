//! A recording over temperature as files have it.

use super::{EnvironmentalColumn, EnvironmentalRequest, TemperatureData};
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_documents::CalibrationFile;
use proofmass_io::{ColumnRef, Input, Recording, Source, Unit};

/// Outputs and temperature of a resting sensor, with the calibration that is to get the coefficients.
#[derive(Clone, Debug)]
pub struct TemperatureRecording {
    recording: Recording,
    temperature: Vec<f64>,
    environment: Vec<EnvironmentalColumn>,
    unit: Unit,
    calibration: Option<CalibrationFile>,
    name: String,
    inputs: Vec<Input>,
}

impl TemperatureRecording {
    /// Reads the recording with the quantities of the surroundings that are asked for, and the calibration where one is given.
    ///
    /// # Errors
    /// A file that cannot be read, columns that neither the reading nor the calibration names, units that differ.
    pub fn read(
        mut source: Source,
        temperature: ColumnRef,
        environment: &[EnvironmentalRequest],
        reading: &RecordingReading,
        calibration: Option<Source>,
    ) -> Result<Self> {
        let name = source.name().display().to_string();
        let calibration = calibration.map(CalibrationFile::from_source).transpose()?;
        let mut options = match &calibration {
            Some((file, _)) => reading.options(file)?,
            None => reading.options_of_axes(&mut source)?,
        };
        options.temperature = Some(temperature);
        options.surroundings = environment.iter().map(|e| e.column.clone()).collect();
        let mut recording = Recording::from_source(source, &options)?;
        let unit = reading.common_unit(&recording);
        let Some(column) = &recording.temperature else {
            return Err(Trouble::data("the recording has no temperature").detail(name));
        };
        let temperature = column.data.clone();
        let requests = environment;
        let environment = requests.iter().zip(&recording.surroundings);
        let environment: Vec<EnvironmentalColumn> = environment
            .map(|(request, column)| request.of(column).map_err(|e| e.detail(name.clone())))
            .collect::<Result<_>>()?;
        let said = requests.iter().zip(&environment);
        let said = said.map(|(r, e)| {
            (
                &r.column,
                e.name.as_str(),
                e.unit.as_str(),
                r.unit.is_some(),
            )
        });
        recording.say_surroundings(&said.collect::<Vec<_>>())?;
        let (calibration, of_calibration) = calibration.unzip();
        Ok(Self {
            temperature,
            environment,
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
            environment: &self.environment,
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
