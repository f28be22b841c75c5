//! `proofmass inspect`: what is in a file.

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use proofmass::io::Source;
use proofmass::jobs::inspect::{InspectData, InspectJob};
use proofmass::jobs::{Job, Record, RecordingReading, StoredResult};
use std::path::PathBuf;

/// Show what is in a recording: columns, units, rate, gaps, ranges, statistics.
#[derive(clap::Args)]
pub(crate) struct Inspect {
    /// Delimited text of any common shape, plain or packed with gzip or zstd; `-` is standard input
    file: PathBuf,
    /// List every damaged place, up to ten thousand, instead of the first
    #[arg(long)]
    damage: bool,
    #[command(flatten)]
    reading: RecordingReading,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut job = match self.damage {
            true => InspectJob::damage(),
            false => InspectJob::default(),
        };
        job.reading = self.reading;
        let data = InspectData::new(Source::open(&self.file)?);
        let outcome = job.evaluate(&data, &Progress::new())?;
        if self.json {
            let json = serde_json::to_vec_pretty(outcome.inspection())
                .map_err(|e| Failure::new(format!("the inspection cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::show(&StoredResult::new(Record::default(), &outcome)?.summary())?;
        }
        Ok(Outcome::Done)
    }
}
