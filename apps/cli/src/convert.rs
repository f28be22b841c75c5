//! `proofmass convert`: a recording in another format.

use crate::console::Progress;
use crate::written_file::{WrittenFile, read};
use crate::{Failure, Outcome, console};
use proofmass::io::{Input, Source};
use proofmass::jobs::convert::{ConvertData, ConvertJob, DeviceTable, Opening};
use proofmass::jobs::{Destination, Job, Outcome as _};
use std::path::{Path, PathBuf};

/// Write recordings in another format: CSV, npy, WAV, UFF 58b or Parquet.
///
/// Numbers stay in their units. Every column of numbers is written where --columns names none. Several recordings that continue each
/// other become one; with --devices, recordings of many devices become one table with columns of serial number and batch. They are
/// read more than once, in blocks: memory is that of a block, for Parquet that of two million numbers. What the format has no place for
/// is refused until it is said what becomes of it, and what is lost is listed.
#[derive(clap::Args)]
pub(crate) struct Convert {
    /// Recordings, in the order of their times
    #[arg(required_unless_present = "devices", value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Table (columns file, serial, batch) of recordings of many devices, its names relative to its folder: they become one Parquet
    /// table with columns of these
    #[arg(long, value_name = "TABLE", conflicts_with = "recordings")]
    devices: Option<PathBuf>,
    #[command(flatten)]
    file: WrittenFile,
    #[command(flatten)]
    job: ConvertJob,
}

impl Convert {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        // Before anything is read.
        self.job.target(Some(&self.file.output))?;
        let devices = self.devices.as_deref().map(Source::open).transpose()?;
        let devices = devices.map(DeviceTable::read).transpose()?;
        let recordings = match (&devices, &self.devices) {
            (Some(table), Some(path)) => {
                let folder = path.parent().unwrap_or(Path::new(""));
                let files = table.devices.iter().map(|d| folder.join(&d.file));
                files.collect()
            }
            _ => self.recordings.clone(),
        };
        recordings
            .iter()
            .try_for_each(|path| readable_again(path))?;
        let read_files = self.devices.iter().chain(&recordings);
        let inputs: Vec<&Path> = read_files.map(PathBuf::as_path).collect();
        let replacement = self.file.begin(&inputs)?;
        let beside = |recordings: &[Input], sha256: &str, steps: &[String]| {
            let read = recordings.to_vec();
            self.file
                .write_beside(&replacement, &inputs, read, (sha256, steps))
        };
        let open = |path| move || Source::open(path);
        let openings: Vec<_> = recordings.iter().map(open).collect();
        let to = Destination::File {
            path: &self.file.output,
            inputs: &inputs,
            beside: &beside,
        };
        let openings = openings.iter().map(|open| open as &Opening<'_>).collect();
        let mut data = ConvertData::new(openings, to);
        if let Some(devices) = &devices {
            data = data.with_devices(devices);
        }
        let outcome = self.job.evaluate(&data, &Progress::new())?;
        outcome.recordings().iter().for_each(read);
        outcome.findings().iter().for_each(console::finding);
        console::note(format!(
            "written: {} ({})",
            self.file.output.display(),
            outcome.statement()
        ));
        for line in outcome.lost() {
            console::note(format!("lost: {line}"));
        }
        for line in outcome.notes() {
            console::note(format!("note: {line}"));
        }
        Ok(Outcome::Done)
    }
}

/// Refuses what is gone once it was read.
fn readable_again(path: &Path) -> Result<(), Failure> {
    let standard_input = path == Path::new("-");
    let passes = || std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
    if !(standard_input || passes()) {
        return Ok(());
    }
    let what = match standard_input {
        true => "standard input".to_owned(),
        false => format!("{} is a pipe or a device, which", path.display()),
    };
    Err(Failure::new(format!(
        "{what} can be read only once, and a recording to be converted is read more often"
    ))
    .hint("write it to a file first (`cat > recording.csv`), and name that"))
}
