//! A recording with rests as files have it, and the noise result of its sensor.

use super::{AxisNoise, BiasData};
use crate::multi_position::{pauses, segment};
use crate::noise::noise_of;
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_io::{Input, RecordedColumn, Recording, SegmentRow, Source};
use proofmass_static::Segment;
use proofmass_uncertainty::Finding;

/// Outputs in m/s² with their time, rests where they are given, noise where a result is given.
#[derive(Clone, Debug)]
pub struct BiasRecording {
    outputs: [Vec<f64>; 3],
    time: Vec<f64>,
    rate: f64,
    breaks: Vec<usize>,
    segments: Option<Vec<Segment>>,
    noise: Option<[AxisNoise; 3]>,
    findings: Vec<Finding>,
    name: String,
    record: Record,
}

impl BiasRecording {
    /// Reads the recording, the table of rests and the noise result.
    ///
    /// # Errors
    /// A file that cannot be read; columns that are not named or are no accelerations; a noise result that does not fit.
    pub fn read(
        mut recording: Source,
        reading: &RecordingReading,
        segments: Option<Source>,
        noise: Option<Source>,
    ) -> Result<Self> {
        let name = recording.name().display().to_string();
        let options = reading.options_alone(&mut recording)?;
        let recording = Recording::from_source(recording, &options)?;
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Trouble::data("three columns are needed").detail(name));
        };
        let unit = reading
            .common_unit(&recording)
            .map_err(|e| e.detail(name.clone()))?;
        let (si, factor) = unit.si();
        if !si.is_acceleration() {
            return Err(Trouble::data(format!(
                "the outputs are in {unit}, which is no acceleration"
            ))
            .detail(name)
            .with_hint("turn them into accelerations with `proofmass apply` first"));
        }
        let mut inputs = vec![recording.input()];
        let (noise, of_noise) = noise
            .map(|source| of_result(source, [&x.name, &y.name, &z.name]))
            .transpose()?
            .unzip();
        let mut record = Record::default();
        if let Some((input, device)) = of_noise {
            inputs.push(input);
            record.device = device;
        }
        let given = segments.map(|source| SegmentRow::from_source(source, &recording));
        let (rows, of_segments) = given.transpose()?.unzip();
        inputs.extend(of_segments);
        record.inputs = inputs;
        let in_si = |c: &RecordedColumn| c.data.iter().map(|v| v * factor).collect();
        Ok(Self {
            outputs: [x, y, z].map(in_si),
            time: (0..recording.samples())
                .map(|i| recording.time.seconds(i))
                .collect(),
            rate: recording.time.rate_hz(),
            breaks: pauses(&recording),
            segments: rows.map(|rows| rows.into_iter().map(segment).collect()),
            noise,
            findings: recording.findings().to_vec(),
            name,
            record,
        })
    }

    /// Noise of the three axes, from the result that was given.
    pub fn noise(&self) -> Option<&[AxisNoise; 3]> {
        self.noise.as_ref()
    }

    /// For the job.
    pub fn data(&self) -> BiasData<'_> {
        let [x, y, z] = &self.outputs;
        BiasData {
            outputs: [x, y, z],
            time: &self.time,
            rate: self.rate,
            breaks: &self.breaks,
            segments: self.segments.as_deref(),
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        Record {
            date,
            ..self.record.clone()
        }
    }
}

type OfNoise = ([AxisNoise; 3], (Input, proofmass_documents::Device));

fn of_result(source: Source, columns: [&str; 3]) -> Result<OfNoise> {
    let name = source.name().display().to_string();
    let (analysis, input, device) = noise_of(source)?;
    let noise = AxisNoise::of(&analysis, columns).map_err(|e| e.detail(name))?;
    Ok((noise, (input, device)))
}
