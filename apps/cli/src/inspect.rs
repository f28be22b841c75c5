//! `proofmass inspect`: what is in a file.

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use proofmass::io::{AtomicFile, Source};
use proofmass::jobs::inspect::{InspectData, InspectJob};
use proofmass::jobs::{Job, Record, RecordingReading, StoredResult};
use std::path::PathBuf;

/// Show what is in a recording: columns, units, rate, gaps, ranges, statistics.
#[derive(clap::Args)]
pub(crate) struct Inspect {
    /// Delimited text or a format that `proofmass formats` lists, plain or packed with gzip or zstd; `-` is standard input
    file: PathBuf,
    /// List every damaged place, up to ten thousand, instead of the first
    #[arg(long)]
    damage: bool,
    /// Write a page with a picture of the signals, a panel for each unit
    #[arg(long, value_name = "FILE.html")]
    plot: Option<PathBuf>,
    /// Replace the file of --plot
    #[arg(long, requires = "plot")]
    force: bool,
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
        job.plot = self.plot.is_some();
        let plot = self.plot.as_deref();
        plot.map_or(Ok(()), |path| console::keep(path, self.force))?;
        let data = InspectData::new(Source::open(&self.file)?);
        let outcome = job.evaluate(&data, &Progress::new())?;
        if let Some(path) = plot {
            let page = StoredResult::new(Record::default(), &outcome)?.html()?;
            let mut file = AtomicFile::create(path, &[&self.file])?;
            file.write_all(page.as_bytes())?;
            file.commit()?;
        }
        if self.json {
            let json = serde_json::to_vec_pretty(outcome.inspection())
                .map_err(|e| Failure::new(format!("the inspection cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::show_result(&StoredResult::new(Record::default(), &outcome)?)?;
        }
        if let Some(path) = plot {
            console::note(format!("written: {}", path.display()));
        }
        Ok(Outcome::Done)
    }
}
