//! Where the results of a command go: a folder, standard output, the exit code.

use crate::console::Shown;
use crate::{Failure, Outcome, console, host};
use proofmass::io::{LARGEST_DOCUMENT, OutputFolder, SigningKey, Source};
use proofmass::jobs::{RESULT, StoredResult};
use std::path::{Path, PathBuf};

/// Options that every command with results has.
#[derive(clap::Args)]
pub(crate) struct Delivery {
    /// Folder for result.json, report.html and tables [default: none is written]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Write into a folder that holds other files: those of the same name are replaced, others kept
    #[arg(long)]
    force: bool,
    /// Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
    /// Print result.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Print every table of the summary, not the opening alone
    #[arg(long, hide_short_help = true, conflicts_with = "json")]
    details: bool,
    /// Exit with code 3 when a finding needs a decision
    #[arg(long)]
    strict: bool,
}

impl Delivery {
    /// Whether the list of what is written is signed.
    pub(crate) fn signs(&self) -> bool {
        self.sign.is_some()
    }

    /// Refuses to replace a file beside the folder that nobody said may go.
    pub(crate) fn keep(&self, file: &Path) -> Result<(), Failure> {
        console::keep(file, self.force)
    }

    /// Begins the folder, where one is asked for: a place that is taken, or that holds results of another kind, is
    /// refused before the work, not after it.
    pub(crate) fn begin(
        &self,
        kind: &str,
        inputs: &[&Path],
    ) -> Result<Option<OutputFolder>, Failure> {
        match &self.output {
            Some(path) => self.begin_at(path.clone(), kind, inputs).map(Some),
            None if self.sign.is_some() => Err(Failure::new(
                "there is nothing to sign: no folder is written",
            )
            .hint("name one with -o FOLDER")),
            None => {
                console::reading(inputs);
                Ok(None)
            }
        }
    }

    /// Begins the folder of a command that always writes one. The inputs are never replaced.
    pub(crate) fn begin_at(
        &self,
        place: PathBuf,
        kind: &str,
        inputs: &[&Path],
    ) -> Result<OutputFolder, Failure> {
        keep_released(&place)?;
        let mut folder = OutputFolder::create(place, self.force)?;
        folder.expect_kind(kind)?;
        if let Some(key) = &self.sign {
            folder.sign_with(SigningKey::read(key)?);
        }
        folder.protect(inputs.iter().copied());
        if let Some(key) = folder.unsigns() {
            console::unsigned(
                &folder.target().display().to_string(),
                &key,
                self.sign.is_some(),
            );
        }
        for litter in folder.swept() {
            console::note(format!(
                "removed what an interrupted run had left: {}",
                litter.display()
            ));
        }
        console::reading(inputs);
        Ok(folder)
    }

    /// Writes every file of an outcome, prints what is asked for and says how it ended.
    pub(crate) fn deliver(
        &self,
        folder: Option<OutputFolder>,
        result: &StoredResult,
    ) -> Result<Outcome, Failure> {
        let mut place = None;
        if let Some(folder) = folder {
            for (name, bytes) in result.files()? {
                folder.write(&name, bytes)?;
            }
            host::go_on()?;
            place = Some(folder.commit()?);
        }
        if self.json {
            console::print_json(&result.to_json()?)?;
        } else {
            let shown = Shown {
                filed: place.is_some(),
                details: self.details,
            };
            console::show_result(result, shown)?;
        }
        if let Some(place) = place {
            console::note(format!("written: {}", place.display()));
        }
        Ok(Outcome::of(self.strict, result.findings()))
    }
}

/// Refuses a folder with a certificate that was released: it is never overwritten.
fn keep_released(place: &Path) -> Result<(), Failure> {
    let file = place.join(RESULT);
    if !file.is_file() {
        return Ok(());
    }
    let (bytes, _) = Source::open(&file)?.into_bytes(LARGEST_DOCUMENT)?;
    let Ok(result) = StoredResult::from_json(&bytes) else {
        return Ok(());
    };
    let number = result
        .section("certificate")
        .and_then(|c| c.get("number")?.as_str());
    match number {
        None => Ok(()),
        Some(number) => Err(Failure::new(format!(
            "{} holds the certificate {number}, which was released and is never overwritten",
            place.display()
        ))
        .hint("name another folder; a certificate that is wrong is replaced by a new one: `proofmass certificate release --replaces`")),
    }
}
