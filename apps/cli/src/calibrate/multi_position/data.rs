//! The samples of a campaign as one series.

use crate::Failure;
use proofmass::calibration::Samples;
use proofmass::core::Error;
use proofmass::io::{Input, Recording, Unit};
use proofmass::jobs::campaign::MultiPositionCampaign;

/// All recordings of the campaign, one after the other, in SI where their unit has a place in it.
pub(super) struct Data {
    pub(super) recordings: Vec<Recording>,
    pub(super) columns: [Vec<f64>; 3],
    pub(super) temperature: Option<Vec<f64>>,
    /// Samples before which time jumps: gaps and the seams between recordings.
    pub(super) breaks: Vec<usize>,
    pub(super) rate: f64,
    pub(super) unit: Unit,
    /// What a value in the file is multiplied with.
    pub(super) factor: f64,
}

impl Data {
    pub(super) fn read(campaign: &MultiPositionCampaign) -> Result<Self, Failure> {
        let recordings = campaign.read_recordings()?;
        let Some(first) = recordings.first() else {
            return Err(Failure::new("the campaign names no recording"));
        };
        let Some(file_unit) = first.columns[0].unit else {
            return Err(Failure::new(format!(
                "{}: the unit of the outputs is not known",
                first.path.display()
            ))
            .hint("write it in the headings (acc_x_m/s2), or add `unit = \"count\"`, `\"m/s²\"` or `\"g\"` to [recording]"));
        };
        let (unit, factor) = file_unit.si();
        let rate = first.time.rate_hz();
        let mut data = Self {
            columns: Default::default(),
            temperature: first.temperature.as_ref().map(|_| Vec::new()),
            breaks: Vec::new(),
            rate,
            unit,
            factor,
            recordings: Vec::new(),
        };
        for recording in recordings {
            let other = recording.time.rate_hz();
            if (other / rate - 1.0).abs() > 0.01 {
                return Err(Failure::new(format!(
                    "{}: sampled at {other:.3} Hz, the recording before at {rate:.3} Hz",
                    recording.path.display()
                ))
                .hint("calibrate recordings of different rates as separate campaigns"));
            }
            let start = data.columns[0].len();
            if start > 0 {
                data.breaks.push(start);
            }
            let gaps = recording
                .time
                .gaps()
                .iter()
                .map(|gap| start + gap.after_sample + 1);
            data.breaks.extend(gaps);
            let recording = recording.into_si();
            for (all, column) in data.columns.iter_mut().zip(&recording.columns) {
                if column.unit != Some(unit) {
                    return Err(Failure::new(format!(
                        "{}: column {:?} is not in the unit of the other columns",
                        recording.path.display(),
                        column.name
                    ))
                    .hint("x, y and z must share one unit"));
                }
                all.extend(&column.data);
            }
            match (&mut data.temperature, &recording.temperature) {
                (Some(all), Some(column)) => all.extend(&column.data),
                (all, _) => *all = None,
            }
            data.recordings.push(recording);
        }
        Ok(data)
    }

    pub(super) fn samples(&self) -> Result<Samples<'_>, Error> {
        let [x, y, z] = &self.columns;
        Samples::new(x, y, z)
    }

    pub(super) fn names(&self) -> String {
        let names: Vec<String> = self
            .recordings
            .iter()
            .map(|r| r.path.display().to_string())
            .collect();
        names.join(", ")
    }

    pub(super) fn is_acceleration(&self) -> bool {
        self.unit.is_acceleration()
    }

    /// Time of every sample; recordings follow one another without pause.
    pub(super) fn time(&self) -> Vec<f64> {
        let mut time = Vec::with_capacity(self.columns[0].len());
        let mut offset = 0.0;
        for recording in &self.recordings {
            let start = recording.time.seconds(0);
            time.extend(
                (0..recording.samples()).map(|i| offset + recording.time.seconds(i) - start),
            );
            offset += recording.duration_s();
        }
        time
    }

    pub(super) fn inputs(&self, campaign: &MultiPositionCampaign) -> Vec<Input> {
        let mut inputs = vec![campaign.source.input.clone()];
        inputs.extend(self.recordings.iter().map(Recording::input));
        if let Some(Ok(segments)) = campaign.segments_file().map(|path| Input::of(&path)) {
            inputs.push(segments);
        }
        inputs
    }
}
