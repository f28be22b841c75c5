//! Recordings of input and output as files have them.

use super::ResponseData;
use crate::channels::{ChannelReading, RecordedChannels, WantedChannel};
use crate::trouble::{Result, Trouble};
use proofmass_io::{Input, Source};
use proofmass_uncertainty::Finding;

/// Input and output of one or several recordings, sampled alike.
#[derive(Clone, Debug)]
pub struct ResponseRecordings {
    recordings: Vec<RecordedChannels>,
    rate: f64,
    findings: Vec<Finding>,
    name: String,
}

impl ResponseRecordings {
    /// Reads input and output of every recording.
    ///
    /// # Errors
    /// As [`ChannelReading::read`]; no recording, recordings of different rates.
    pub fn read(
        sources: impl IntoIterator<Item = Source>,
        reading: &ChannelReading,
        columns: &[WantedChannel; 2],
    ) -> Result<Self> {
        let recordings = sources
            .into_iter()
            .map(|source| reading.read(source, columns))
            .collect::<Result<Vec<_>>>()?;
        let Some(first) = recordings.first() else {
            return Err(Trouble::request("no recording was given"));
        };
        let rate = first.rate;
        let other = recordings
            .iter()
            .find(|r| (r.rate / rate - 1.0).abs() > 1e-6);
        if let Some(other) = other {
            return Err(Trouble::data(format!(
                "{} has {} samples/s, {} has {rate}",
                other.name, other.rate, first.name
            ))
            .with_hint("impacts that are averaged need one sampling rate"));
        }
        let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
        Ok(Self {
            rate,
            findings: recordings.iter().flat_map(|r| r.findings.clone()).collect(),
            name: names.join(", "),
            recordings,
        })
    }

    /// For the job.
    pub fn data(&self) -> ResponseData<'_> {
        let pairs = self.recordings.iter();
        ResponseData {
            recordings: pairs
                .filter_map(|r| match r.channels.as_slice() {
                    [input, output] => Some([input.view(), output.view()]),
                    _ => None,
                })
                .collect(),
            rate: self.rate,
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// What they are called together.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Files with their digests.
    pub fn inputs(&self) -> Vec<Input> {
        self.recordings.iter().map(|r| r.input.clone()).collect()
    }
}
