//! `proofmass verify`: whether a result and everything it came from are unchanged.

use crate::{Failure, Outcome, console};
use proofmass::io::{Fate, Verification, VerifyingKey};
use proofmass::report::{Cell, Column, Report, Section, Table};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Check by digests that a result, and the files it was computed from, are unchanged.
///
/// From a folder of results, a result.json, a calibration.json or a recording that `proofmass apply` wrote, back to the raw
/// recordings as far as they are found. Ends with exit code 1 where a file was changed or is missing, a signature does not hold,
/// or, with --key, a list of files is not signed by one of the keys.
#[derive(clap::Args)]
pub(crate) struct Verify {
    /// Folder of results, result.json, calibration.json or compensated recording
    result: PathBuf,
    /// Folder in which inputs are looked for that are not where they were
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Public key that must have signed every list of files (PEM, Ed25519); may be given several times
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let keys = self
            .key
            .iter()
            .map(|path| VerifyingKey::read(path))
            .collect::<Result<Vec<_>, _>>()?;
        let chain = Verification::of(&self.result, self.data.as_deref())?;
        if self.json {
            let json = serde_json::to_vec_pretty(&chain)
                .map_err(|e| Failure::new(format!("the verification cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::show(&report(&self.result.display().to_string(), &chain))?;
        }
        let bad: Vec<_> = chain
            .links
            .iter()
            .filter(|l| l.fate != Fate::Unchanged)
            .collect();
        match bad.first() {
            None => match chain.distrust(&keys) {
                None => Ok(Outcome::Done),
                Some(why) => Err(Failure::new(why)
                    .hint("ask whoever made the results, and compare the key with theirs")),
            },
            Some(first) => Err(Failure::new(format!(
                "{} of {} files are not what they were; the first is {}",
                bad.len(),
                chain.links.len(),
                first
                    .found
                    .as_ref()
                    .map_or(first.name.clone(), |p| p.display().to_string())
            ))
            .hint("fetch the original files, or name their folder with --data")),
        }
    }
}

fn report(name: &str, chain: &Verification) -> Report {
    let table = Table::new(
        "",
        [
            Column::text("file"),
            Column::text("named by"),
            Column::text("state"),
            Column::text("SHA-256"),
        ],
    );
    let table = chain.links.iter().fold(table, |table, link| {
        let state = match link.fate {
            Fate::Unchanged => "unchanged",
            Fate::Changed => "CHANGED",
            Fate::Missing => "MISSING",
        };
        let by = link
            .named_by
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        table.row([
            Cell::text(link.name.clone()),
            Cell::text(by.into_owned()),
            Cell::text(state),
            Cell::text(format!("{}…", link.sha256.get(..12).unwrap_or_default())),
        ])
    });
    let written: Vec<String> = chain.software.iter().map(|s| s.to_string()).collect();
    let signers: BTreeSet<&str> = chain
        .lists
        .iter()
        .filter(|l| l.holds)
        .filter_map(|l| l.key.as_deref())
        .collect();
    let signed = match chain.lists.iter().filter(|l| l.holds).count() {
        0 => "by nobody".to_owned(),
        n => format!(
            "{n} of {} lists, by {}",
            chain.lists.len(),
            signers.into_iter().collect::<Vec<_>>().join(", ")
        ),
    };
    Report::new(format!("Verification of {name}"))
        .meta("signed", signed)
        .meta("written by", written.join(", "))
        .section(Section::new("Files").table(table))
}
