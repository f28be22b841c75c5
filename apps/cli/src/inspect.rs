//! `proofmass inspect`: what is in a file.

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use proofmass::documents::{MemoryContent, is_calibration_memory};
use proofmass::io::{AtomicFile, Source};
use proofmass::jobs::inspect::{InspectData, InspectJob};
use proofmass::jobs::{Job, Record, RecordingReading, StoredResult};
use std::io::Read;
use std::path::PathBuf;

/// Show what is in a recording: columns, units, rate, gaps, ranges, statistics.
///
/// Of the calibration memory of a device, as `export --memory` writes it, it shows the coefficients.
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
        if let Some(bytes) = self.memory() {
            return self.show_memory(&bytes);
        }
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
            console::show_result(
                &StoredResult::new(Record::default(), &outcome)?,
                console::Shown::WHOLE,
            )?;
        }
        if let Some(path) = plot {
            console::note(format!("written: {}", path.display()));
        }
        Ok(Outcome::Done)
    }

    /// The bytes of the file where it is a calibration memory; none is as large as what is read of it.
    fn memory(&self) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        let file = std::fs::File::open(&self.file).ok()?;
        if !file.metadata().ok()?.is_file() {
            return None;
        }
        file.take(1 << 16).read_to_end(&mut bytes).ok()?;
        is_calibration_memory(&bytes).then_some(bytes)
    }

    fn show_memory(&self, bytes: &[u8]) -> Result<Outcome, Failure> {
        if self.plot.is_some() {
            return Err(Failure::new("a calibration memory has no signals to draw")
                .detail(self.file.display().to_string())
                .hint("leave out --plot"));
        }
        let content = MemoryContent::read(bytes).map_err(|e| e.at(&self.file))?;
        if self.json {
            let json = serde_json::to_vec_pretty(&content)
                .map_err(|e| Failure::new(format!("the content cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::print(&content.text())?;
        }
        Ok(Outcome::Done)
    }
}
