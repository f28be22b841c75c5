//! The recordings of a campaign as one series.

use super::{MultiPositionData, MultiPositionJob};
use crate::campaign::{GravityInput, MultiPositionCampaign};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_calibration::{Segment, Standstill};
use proofmass_core::{Error, Gravity, Watch};
use proofmass_io::{ColumnRef, Input, Recording, Unit};
use proofmass_uncertainty::Finding;

/// All recordings of a campaign, one after the other, in SI where their unit has a place in it.
#[derive(Clone, Debug)]
pub struct MultiPositionRecordings {
    outputs: [Vec<f64>; 3],
    time: Vec<f64>,
    rate: f64,
    breaks: Vec<usize>,
    unit: Unit,
    temperature: Option<Vec<f64>>,
    segments: Option<Vec<Segment>>,
    findings: Vec<Finding>,
    name: String,
    columns: [ColumnRef; 3],
    inputs: Vec<Input>,
    /// What a value in the file is multiplied with.
    factor: f64,
}

impl MultiPositionCampaign {
    /// Reads the recordings and the table of standstills.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown unit, recordings that do not fit together.
    pub fn load(&self, watch: &dyn Watch) -> Result<MultiPositionRecordings> {
        watch.step("reading", 0, 0)?;
        let recordings = self.read_recordings()?;
        let (segments, table) = self.given_segments(&recordings)?.unzip();
        let columns = &self.recording.columns;
        let mut all = MultiPositionRecordings::join(recordings)?;
        all.segments = segments;
        all.columns = [columns.x.clone(), columns.y.clone(), columns.z.clone()];
        all.inputs.insert(0, self.source.input.clone());
        all.inputs.extend(table);
        Ok(all)
    }

    fn given_segments(&self, recordings: &[Recording]) -> Result<Option<(Vec<Segment>, Input)>> {
        let given =
            match recordings {
                [only] => self.read_segments(only)?,
                _ if self.standstill.segments.is_some() => {
                    return Err(Trouble::request(
                        "given standstills need a campaign of one recording",
                    )
                    .with_hint("join the recordings into one file, or make one campaign of each"));
                }
                _ => None,
            };
        let segment = |s: proofmass_io::Segment| Segment {
            start: s.start,
            end: s.end,
            attitude: s.attitude,
            label: s.label,
        };
        Ok(given.map(|(all, table)| (all.into_iter().map(segment).collect(), table)))
    }

    /// The question of the campaign; a range in the unit of the file is brought to that of the data.
    ///
    /// # Errors
    /// A gravity that cannot be.
    pub fn job(&self, data: &MultiPositionRecordings) -> Result<MultiPositionJob> {
        let table = &self.standstill;
        let default = Standstill::default();
        let mut job = MultiPositionJob::new(gravity(&self.gravity)?);
        job.method = self.method.model;
        job.probability = self.method.confidence;
        job.search = Standstill {
            window: table.window_s.unwrap_or(default.window),
            minimum_duration: table.minimum_duration_s.unwrap_or(default.minimum_duration),
            threshold: table.threshold,
        };
        job.attitude_uncertainty = self.attitude.standard_uncertainty_deg.map(f64::to_radians);
        job.range = self.recording.range.map(|r| r.map(|v| v * data.factor));
        job.temperature = self.ambient.temperature_deg_c;
        Ok(job)
    }

    /// What the result is filed with.
    pub fn record(&self, data: &MultiPositionRecordings, date: Option<String>) -> Record {
        Record {
            title: self.title.clone(),
            device: self.device.clone(),
            ambient: self.ambient.clone(),
            date,
            inputs: data.inputs.clone(),
            ..Record::default()
        }
    }
}

impl MultiPositionRecordings {
    /// Puts recordings of one sensor one after the other.
    fn join(recordings: Vec<Recording>) -> Result<Self> {
        let Some(first) = recordings.first() else {
            return Err(Trouble::request("the campaign names no recording"));
        };
        let Some(file_unit) = first.columns[0].unit else {
            return Err(Trouble::request(format!(
                "{}: the unit of the outputs is not known",
                first.path.display()
            ))
            .with_hint("write it in the headings (acc_x_m/s2), or add `unit = \"count\"`, `\"m/s²\"` or `\"g\"` to [recording]"));
        };
        let (unit, factor) = file_unit.si();
        let names: Vec<String> = recordings
            .iter()
            .map(|r| r.path.display().to_string())
            .collect();
        let mut all = Self {
            outputs: Default::default(),
            time: Vec::new(),
            rate: first.time.rate_hz(),
            breaks: Vec::new(),
            unit,
            temperature: first.temperature.as_ref().map(|_| Vec::new()),
            segments: None,
            findings: Vec::new(),
            name: names.join(", "),
            columns: [1, 2, 3].map(ColumnRef::Index),
            inputs: Vec::new(),
            factor,
        };
        let mut offset = 0.0;
        for recording in recordings {
            offset = all.append(recording, offset)?;
        }
        Ok(all)
    }

    /// Appends a recording that begins at `offset`, s, and returns where it ends.
    fn append(&mut self, recording: Recording, offset: f64) -> Result<f64> {
        let rate = recording.time.rate_hz();
        if (rate / self.rate - 1.0).abs() > 0.01 {
            return Err(Trouble::data(format!(
                "{}: sampled at {rate:.3} Hz, the recording before at {:.3} Hz",
                recording.path.display(),
                self.rate
            ))
            .with_hint("calibrate recordings of different rates as separate campaigns"));
        }
        let start = self.outputs[0].len();
        if start > 0 {
            self.breaks.push(start);
        }
        let gaps = recording.time.gaps().iter();
        self.breaks
            .extend(gaps.map(|gap| start + gap.after_sample + 1));
        let recording = recording.into_si();
        for (all, column) in self.outputs.iter_mut().zip(&recording.columns) {
            if column.unit != Some(self.unit) {
                return Err(Trouble::data(format!(
                    "{}: column {:?} is not in the unit of the other columns",
                    recording.path.display(),
                    column.name
                ))
                .with_hint("x, y and z must share one unit"));
            }
            all.extend(&column.data);
        }
        match (&mut self.temperature, &recording.temperature) {
            (Some(all), Some(column)) => all.extend(&column.data),
            (all, _) => *all = None,
        }
        let first = recording.time.seconds(0);
        self.time
            .extend((0..recording.samples()).map(|i| offset + recording.time.seconds(i) - first));
        self.findings.extend(recording.findings().iter().cloned());
        self.inputs.push(recording.input());
        Ok(offset + recording.duration_s())
    }

    /// The data as the job wants them.
    pub fn data(&self) -> MultiPositionData<'_> {
        let [x, y, z] = &self.outputs;
        MultiPositionData {
            outputs: [x, y, z],
            time: Some(&self.time),
            rate: self.rate,
            breaks: &self.breaks,
            unit: self.unit,
            temperature: self.temperature.as_deref(),
            segments: self.segments.as_deref(),
            findings: &self.findings,
            name: &self.name,
            columns: Some(self.columns.clone()),
        }
    }

    /// Files it was read from.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }
}

fn gravity(input: &GravityInput) -> Result<Gravity, Error> {
    match *input {
        GravityInput::Given {
            value,
            standard_uncertainty,
        } => Gravity::given(value, standard_uncertainty),
        GravityInput::Place {
            latitude_deg,
            height_m,
            latitude_standard_uncertainty_deg,
            height_standard_uncertainty_m,
            standard_uncertainty,
        } => {
            let normal = Gravity::normal(
                latitude_deg,
                height_m,
                latitude_standard_uncertainty_deg.unwrap_or(0.0),
                height_standard_uncertainty_m.unwrap_or(0.0),
            )?;
            match standard_uncertainty {
                Some(u) => Gravity::given(normal.value(), u),
                None => Ok(normal),
            }
        }
    }
}
