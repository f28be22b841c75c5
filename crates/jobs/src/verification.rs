//! Is a result, and everything it came from, what it was?

use crate::certificate::DIGITAL;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{Fate, Link, Verification};
use proofmass_io::VerifyingKey;
use proofmass_report::{Cell, Column, Report, Section, Table};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Whether every file is what it was, and its list signed by one of the keys where keys are given.
///
/// # Errors
/// How many files are not, and the first of them, or why the signatures do not do.
pub fn judge(chain: &Verification, keys: &[VerifyingKey]) -> Result<()> {
    let Some(first) = chain
        .links
        .iter()
        .find(|l| l.fate != Fate::Unchanged && !is_kept_back(l))
    else {
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
        "{}; the first is {}",
        state(chain),
        place.unwrap_or_else(|| first.name.clone())
    ))
    .with_hint(hint))
}

/// Whether it is what a certificate was made of and is not here: a laboratory hands over the certificate, which has the result inside.
fn is_kept_back(link: &Link) -> bool {
    link.fate == Fate::Missing && link.named_by.with_file_name(DIGITAL).is_file()
}

/// What became of the files, in a sentence without its full stop.
fn state(chain: &Verification) -> String {
    let here = || chain.links.iter().filter(|l| !is_kept_back(l));
    let count = |fate| files(here().filter(|l| l.fate == fate));
    let (changed, missing, all) = (count(Fate::Changed), count(Fate::Missing), files(here()));
    let said = said(changed, missing, all);
    match chain.links.iter().any(is_kept_back) {
        false => said,
        true => format!("{said}; what the certificate was made of is not here"),
    }
}

/// Files that the links name, each once though several lists name it.
fn files<'a>(links: impl Iterator<Item = &'a Link>) -> usize {
    let place = |l: &'a Link| l.found.as_deref().unwrap_or(Path::new(&l.name));
    links.map(place).collect::<BTreeSet<_>>().len()
}

fn said(changed: usize, missing: usize, all: usize) -> String {
    let are = |n: usize| if n == 1 { "is" } else { "are" };
    let were = |n: usize| if n == 1 { "was" } else { "were" };
    match (changed, missing, all) {
        (0, 0, 1) => "the one file that is named is unchanged".to_owned(),
        (0, 0, _) => format!("all {all} files that are named are unchanged"),
        (n, 0, _) => format!("{n} of {all} files {} changed", were(n)),
        (0, n, _) => format!("{n} of {all} files {} missing", are(n)),
        (n, m, _) => format!(
            "{n} of {all} files {} changed, and {m} {} missing",
            were(n),
            are(m)
        ),
    }
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
            Fate::Missing if is_kept_back(link) => "not here",
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
    let broken = chain.lists.iter().any(|l| l.key.is_some() && !l.holds);
    let signed = match chain.lists.iter().filter(|l| l.holds).count() {
        _ if broken => "a signature does not hold".to_owned(),
        0 => "by nobody".to_owned(),
        n => format!(
            "{n} of {} lists, by {}",
            chain.lists.len(),
            signers.into_iter().collect::<Vec<_>>().join(", ")
        ),
    };
    let mut files = Section::new("Files").table(table);
    let named = |paths: &[PathBuf]| {
        let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
        names.join(", ")
    };
    if !chain.unlisted.is_empty() {
        files = files.paragraph(format!(
            "No list names these, so that nobody says whether they are as they were computed: {}.",
            named(&chain.unlisted)
        ));
    }
    if !chain.foreign.is_empty() {
        files = files.paragraph(format!(
            "No list names these, and nothing is known of them: {}.",
            named(&chain.foreign)
        ));
    }
    let mut said = state(chain);
    said[..1].make_ascii_uppercase();
    Report::new(format!("Verification of {}", result.display()))
        .subtitle(format!("{said}."))
        .meta("signed", signed)
        .meta("written by", written.join(", "))
        .section(files)
}
