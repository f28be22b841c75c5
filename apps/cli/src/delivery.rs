//! Where the results of a command go: a folder, standard output, the exit code.

use crate::{Failure, Outcome, console};
use proofmass::io::OutputFolder;
use proofmass::jobs::AnyResult;
use proofmass::report::{Report, html};
use proofmass::uncertainty::Finding;
use std::path::{Path, PathBuf};

/// Options that every command with results has.
#[derive(clap::Args)]
pub(crate) struct Delivery {
    /// Folder for result.json, report.html and tables [default: none is written]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Write into a folder with other files or results of another kind; files of the same name are replaced, others kept
    #[arg(long)]
    force: bool,
    /// Print result.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Exit with code 3 when a finding needs a decision
    #[arg(long)]
    strict: bool,
}

/// What a command found, in every form it is asked for.
pub(crate) struct Results<'a> {
    /// Contents of result.json.
    pub(crate) json: Vec<u8>,
    /// What is printed.
    pub(crate) summary: &'a dyn Fn() -> Report,
    /// What stands in report.html.
    pub(crate) report: &'a dyn Fn() -> Report,
    /// Further files of the folder, by name.
    pub(crate) files: Vec<(&'static str, Vec<u8>)>,
    /// Doubts, which `--strict` turns into an exit code.
    pub(crate) findings: &'a [Finding],
}

impl Delivery {
    /// Begins the folder, where one is asked for: a place that is taken is refused before the work, not after it.
    pub(crate) fn begin(&self, inputs: &[&Path]) -> Result<Option<OutputFolder>, Failure> {
        match &self.output {
            Some(path) => self.begin_at(path.clone(), inputs).map(Some),
            None => Ok(None),
        }
    }

    /// Begins the folder of a command that always writes one. The inputs are never replaced.
    pub(crate) fn begin_at(
        &self,
        place: PathBuf,
        inputs: &[&Path],
    ) -> Result<OutputFolder, Failure> {
        let mut folder = OutputFolder::create(place, self.force)?;
        folder.protect(inputs.iter().copied());
        for litter in folder.swept() {
            console::note(format!(
                "removed what an interrupted run had left: {}",
                litter.display()
            ));
        }
        Ok(folder)
    }

    /// Writes every file of an outcome, prints what is asked for and says how it ended.
    pub(crate) fn deliver(
        &self,
        folder: Option<OutputFolder>,
        filed: &dyn AnyResult,
    ) -> Result<Outcome, Failure> {
        let mut place = None;
        if let Some(folder) = folder {
            for (name, bytes) in filed.files()? {
                folder.write(&name, bytes)?;
            }
            place = Some(folder.commit()?);
        }
        if self.json {
            console::print_json(&filed.to_json()?)?;
        } else {
            console::show(&filed.summary())?;
        }
        if let Some(place) = place {
            console::note(format!("written: {}", place.display()));
        }
        Ok(Outcome::of(self.strict, filed.findings()))
    }

    /// Writes the folder, prints what is asked for and says how it ended.
    pub(crate) fn hand_over(
        &self,
        folder: Option<OutputFolder>,
        results: &Results<'_>,
    ) -> Result<Outcome, Failure> {
        let mut place = None;
        if let Some(folder) = folder {
            folder.write("result.json", &results.json)?;
            folder.write("report.html", html::render(&(results.report)())?)?;
            for (name, bytes) in &results.files {
                folder.write(name, bytes)?;
            }
            place = Some(folder.commit()?);
        }
        if self.json {
            console::print_json(&results.json)?;
        } else {
            console::show(&(results.summary)())?;
        }
        if let Some(place) = place {
            console::note(format!("written: {}", place.display()));
        }
        Ok(Outcome::of(self.strict, results.findings))
    }
}
