//! `proofmass init`: a commented campaign from a recording, or an example of any kind.

use crate::console::Progress;
use crate::draft_arguments::DraftArguments;
use crate::{Failure, Outcome, console};
use clap::builder::PossibleValuesParser;
use proofmass::io::OutputFolder;
use proofmass::jobs::campaign::{KINDS, example};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Write a commented campaign.toml for a recording, or an example of any kind.
///
/// Columns, time and unit are filled in as far as the recording states them; the rest stands there as comments. An
/// existing campaign is never replaced. With --kind, a folder gets a full example of that kind with its tables.
#[derive(clap::Args)]
pub(crate) struct Init {
    /// Recording with static intervals in many positions
    #[arg(required_unless_present = "kind")]
    recording: Option<PathBuf>,
    /// Write an example of this kind instead, with its tables, into the folder of --output
    #[arg(
        long,
        value_name = "KIND",
        value_parser = PossibleValuesParser::new(KINDS),
        requires = "output",
        conflicts_with = "recording"
    )]
    kind: Option<String>,
    /// Folder for the example
    #[arg(short, long, value_name = "FOLDER", requires = "kind")]
    output: Option<PathBuf>,
    #[command(flatten)]
    about: DraftArguments,
}

impl Init {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match (&self.recording, &self.kind, self.output) {
            (Some(_), _, Some(_)) => Err(Failure::new(
                "the campaign of a recording is written beside it, not into the folder of --output",
            )
            .hint("leave --output out, or copy the recording into a folder of its own")),
            (Some(recording), _, None) => draft(recording, &self.about),
            (None, Some(kind), Some(place)) => write_example(kind, place),
            _ => Err(Failure::new("neither a recording nor a kind is named")
                .hint("proofmass init RECORDING, or proofmass init --kind KIND -o FOLDER")),
        }
    }
}

fn write_example(kind: &str, place: PathBuf) -> Result<Outcome, Failure> {
    let folder = OutputFolder::create(place, false)?;
    example(kind, &folder, &Progress::new())?;
    let place = folder.commit()?;
    console::note(format!(
        "written: {0}; put your own numbers and files in their place, then: proofmass calibrate {0}",
        place.display()
    ));
    Ok(Outcome::Done)
}

fn draft(recording: &Path, about: &DraftArguments) -> Result<Outcome, Failure> {
    let text = about.draft().text(recording)?;
    let folder = recording.parent().unwrap_or(Path::new(""));
    let place = folder.join("campaign.toml");
    let create = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&place);
    let written = create.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| {
        let why = match error.kind() {
            std::io::ErrorKind::AlreadyExists => "is there already".to_owned(),
            _ => format!("cannot be written: {error}"),
        };
        Failure::new(format!("{} {why}", place.display()))
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
