//! `proofmass init`: a commented campaign from a recording.

use crate::draft_arguments::DraftArguments;
use crate::{Failure, Outcome, console};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Write a commented campaign.toml for a recording.
///
/// Columns, time and unit are filled in as far as the recording states them; the rest stands there as comments. An
/// existing campaign is never replaced.
#[derive(clap::Args)]
pub(crate) struct Init {
    /// Recording with static intervals in many positions
    recording: PathBuf,
    #[command(flatten)]
    about: DraftArguments,
}

impl Init {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let text = self.about.draft().text(&self.recording)?;
        let folder = self.recording.parent().unwrap_or(Path::new(""));
        let place = folder.join("campaign.toml");
        let create = std::fs::OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&place);
        let written = create.and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|error| {
            Failure::new(format!("{}: {error}", place.display()))
                .hint("an existing campaign is never replaced: move it away, or copy the recording into a folder of its own")
        })?;
        console::note(format!(
            "written: {}; look at what it says of unit and place, then: proofmass calibrate {}",
            place.display(),
            if folder.as_os_str().is_empty() {
                "."
            } else {
                folder.to_str().unwrap_or(".")
            }
        ));
        Ok(Outcome::Done)
    }
}
