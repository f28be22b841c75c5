//! `proofmass convert`: a recording in another format.

use crate::console::Progress;
use crate::written_file::{WrittenFile, read};
use crate::{Failure, Outcome, console};
use proofmass::io::{Input, Source};
use proofmass::jobs::convert::{ConvertData, ConvertJob, Opening};
use proofmass::jobs::{Destination, Job, Outcome as _};
use std::path::{Path, PathBuf};

/// Write recordings in another format: CSV, npy, WAV or UFF 58b.
///
/// Numbers stay in their units. Every column of numbers is written where --columns names none. Several recordings that continue each
/// other become one. They are read more than once, in blocks: memory is that of a block. What the format has no place for is refused
/// until it is said what becomes of it, and what is lost is listed.
#[derive(clap::Args)]
pub(crate) struct Convert {
    /// Recordings, in the order of their times
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    file: WrittenFile,
    #[command(flatten)]
    job: ConvertJob,
}

impl Convert {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        // Before anything is read.
        self.job.target(Some(&self.file.output))?;
        self.recordings
            .iter()
            .try_for_each(|path| readable_again(path))?;
        let replacement = self.file.begin()?;
        let inputs: Vec<&Path> = self.recordings.iter().map(PathBuf::as_path).collect();
        let beside = |recordings: &[Input], sha256: &str| {
            let read = recordings.to_vec();
            self.file.write_beside(&replacement, &inputs, read, sha256)
        };
        let open = |path| move || Source::open(path);
        let recordings: Vec<_> = inputs.iter().copied().map(open).collect();
        let data = ConvertData::new(
            recordings.iter().map(|open| open as &Opening<'_>).collect(),
            Destination::File {
                path: &self.file.output,
                inputs: &inputs,
                beside: &beside,
            },
        );
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
