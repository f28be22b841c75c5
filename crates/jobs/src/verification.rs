//! Is a result, and everything it came from, what it was?

use crate::trouble::{Result, Trouble};
use proofmass_io::{Fate, Verification, VerifyingKey};
use proofmass_report::{Cell, Column, Report, Section, Table};
use std::collections::BTreeSet;
use std::path::Path;

/// Whether every file is what it was, and its list signed by one of the keys where keys are given.
///
/// # Errors
/// The first file that is not, or why the signatures do not do.
pub fn judge(chain: &Verification, keys: &[VerifyingKey]) -> Result<()> {
    let changed = |l: &&proofmass_io::Link| l.fate != Fate::Unchanged;
    let Some(first) = chain.links.iter().find(changed) else {
        return match chain.distrust(keys) {
            None => Ok(()),
            Some(why) => Err(Trouble::data(why)
                .with_hint("ask whoever made the results, and compare the key with theirs")),
        };
    };
    let place = first.found.as_ref().map(|p| p.display().to_string());
    let hint = match &first.elsewhere {
        Some(whole) => format!(
            "{} is unchanged: if that is the one that belongs here, name its folder with --data",
            whole.display()
        ),
        None => "fetch the original files, or name their folder with --data".to_owned(),
    };
    Err(Trouble::data(format!(
        "{} of {} files are not what they were; the first is {}",
        chain.links.iter().filter(changed).count(),
        chain.links.len(),
        place.unwrap_or_else(|| first.name.clone())
    ))
    .with_hint(hint))
}

/// The chain as a page: every file with what names it, its state and its digest, who signed and what wrote.
pub fn page(result: &Path, chain: &Verification) -> Report {
    let table = Table::new(
        "",
        [
            Column::text("file"),
            Column::text("named by"),
            Column::text("state"),
            Column::text("read"),
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
            Cell::text(match &link.found {
                Some(place) => place.display().to_string(),
                None => String::new(),
            }),
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
    let mut files = Section::new("Files").table(table);
    if !chain.foreign.is_empty() {
        let names: Vec<String> = chain
            .foreign
            .iter()
            .map(|p| p.display().to_string())
            .collect();
        files = files.paragraph(format!(
            "No list names these, and nothing is known of them: {}.",
            names.join(", ")
        ));
    }
    Report::new(format!("Verification of {}", result.display()))
        .meta("signed", signed)
        .meta("written by", written.join(", "))
        .section(files)
}
