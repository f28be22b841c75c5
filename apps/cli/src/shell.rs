//! What a shell and a system of manual pages are given: completions and pages, from the declaration of the commands.

use crate::{Failure, Outcome, commands, console};
use clap_complete::Shell;
use std::path::PathBuf;

/// Name of the program, as a shell knows it.
const NAME: &str = "proofmass";

/// Print the completions of a shell: commands, options and their values.
///
/// bash: `proofmass completions bash > ~/.local/share/bash-completion/completions/proofmass`
///
/// zsh: `proofmass completions zsh > FOLDER/_proofmass`, with FOLDER in fpath
///
/// fish: `proofmass completions fish > ~/.config/fish/completions/proofmass.fish`
///
/// PowerShell: `proofmass completions powershell | Out-String | Invoke-Expression`
#[derive(clap::Args)]
pub(crate) struct Completions {
    /// Shell that completes
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut commands(), NAME, &mut text);
        console::print(&String::from_utf8_lossy(&text))?;
        Ok(Outcome::Done)
    }
}

/// Write a manual page of each command.
///
/// The files `proofmass.1`, `proofmass-calibrate.1`, … belong into a folder `man1` of the MANPATH.
#[derive(clap::Args)]
pub(crate) struct Manual {
    /// Folder for the pages, which must not be there yet
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

impl Manual {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = &self.output;
        std::fs::create_dir(folder).map_err(|e| {
            Failure::new(format!("{} cannot be made: {e}", folder.display()))
                .hint("name a folder that is not there, beside which you may write")
        })?;
        let pages = clap_mangen::generate_to(commands(), folder)
            .and_then(|()| Ok(std::fs::read_dir(folder)?.count()))
            .map_err(|e| {
                Failure::new(format!("{} cannot be written: {e}", folder.display()))
                    .hint("make room, and try again with another folder")
            })?;
        console::note(format!("written: {pages} pages in {}", folder.display()));
        Ok(Outcome::Done)
    }
}
