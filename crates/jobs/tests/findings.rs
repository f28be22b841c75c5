//! The catalogue of findings: codes, sentences, the page, and that a test fires each of them.

use proofmass_jobs::findings::{catalogue, explain, page};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn codes_are_unique_and_in_kebab_case() {
    let mut seen = BTreeMap::new();
    for (room, kind) in catalogue() {
        let words = kind.code.split('-');
        let lower = |w: &str| {
            !w.is_empty()
                && w.chars()
                    .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        assert!(words.clone().all(lower), "{room}: {}", kind.code);
        if let Some(other) = seen.insert(kind.code, room) {
            panic!("{} is declared in {other} and in {room}", kind.code);
        }
    }
}

#[test]
fn no_two_kinds_share_sentence_and_advice() {
    let mut seen = BTreeMap::new();
    for (_, kind) in catalogue() {
        if let Some(other) = seen.insert((kind.what, kind.advice), kind.code) {
            panic!("{other} and {} say one thing", kind.code);
        }
    }
}

#[test]
fn severities_are_stated_once() {
    for (_, kind) in catalogue() {
        let distinct: BTreeSet<_> = kind.severities.iter().collect();
        assert!(
            !distinct.is_empty() && distinct.len() == kind.severities.len(),
            "{}",
            kind.code
        );
    }
}

#[test]
fn the_page_of_units_is_that_of_the_units() {
    let written =
        std::fs::read_to_string(workspace().join("docs/units.md")).expect("the page is there");
    assert!(
        written == proofmass_jobs::units::page(),
        "docs/units.md is not that of the units: run `cargo run -p proofmass-jobs --example pages`"
    );
}

#[test]
fn the_page_of_errors_is_that_of_their_codes() {
    let written =
        std::fs::read_to_string(workspace().join("docs/errors.md")).expect("the page is there");
    assert!(
        written == proofmass_jobs::errors_page(),
        "docs/errors.md is not that of the codes: run `cargo run -p proofmass-jobs --example pages`"
    );
}

#[test]
fn the_page_is_that_of_the_catalogue() {
    let written =
        std::fs::read_to_string(workspace().join("docs/findings.md")).expect("the page is there");
    assert!(
        written == page(),
        "docs/findings.md is not that of the catalogue: run `cargo run -p proofmass-jobs --example pages`"
    );
}

#[test]
fn a_code_is_explained_and_a_misspelt_one_refused_with_the_nearest() {
    let found = explain("gaps-in-record").expect("a code of the catalogue");
    assert_eq!((found.code, found.room), ("gaps-in-record", "uncertainty"));
    let refused = explain("gap-in-record").expect_err("no such code");
    assert_eq!(refused.hint(), Some("did you mean `gaps-in-record`?"));
}

/// Every code stands in an assertion that it is found, in some test of the workspace.
#[test]
fn every_finding_is_fired() {
    let sources = test_sources();
    let fired = |code: &str| sources.iter().any(|source| asserts(source, code));
    let missing: BTreeSet<&str> = catalogue()
        .iter()
        .map(|(_, kind)| kind.code)
        .filter(|code| !fired(code))
        .collect();
    assert!(
        missing.is_empty(),
        "no test asserts that these are found: {missing:#?}"
    );
}

/// Whether a statement of the source asserts that the code is found.
///
/// A statement reaches from the semicolon or brace before the quoted code to the semicolon after it, so that the body of a loop
/// over codes belongs to it. It counts when it asserts, itself or by a helper, or takes the finding out, and negates nothing.
fn asserts(source: &str, code: &str) -> bool {
    let quoted = format!("\"{code}\"");
    source.match_indices(&quoted).any(|(at, _)| {
        let start = source[..at].rfind([';', '{', '}']).map_or(0, |i| i + 1);
        let end = source[at..].find(';').map_or(source.len(), |i| at + i);
        let statement: String = source[start..end].split_whitespace().collect();
        let positive = ["assert", ".find(", ".position(", "insist(", ".named("];
        let negative = [
            "assert!(!",
            "assert_ne!",
            "!=",
            "is_none()",
            "||!",
            "&&!",
            ".all(",
            "(!",
            "[],",
            ".retain(",
        ];
        positive.iter().any(|form| statement.contains(form))
            && !negative.iter().any(|form| statement.contains(form))
    })
}

/// Texts of all tests of the workspace but this one: `tests/`, `tests.rs` and the parts under `#[cfg(test)]`.
fn test_sources() -> Vec<String> {
    let mut sources = Vec::new();
    let mut folders = vec![workspace().join("crates"), workspace().join("apps")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the workspace") {
            let path = entry.expect("an entry of the folder").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs")
                && !path.ends_with("jobs/tests/findings.rs")
            {
                let text = std::fs::read_to_string(&path).expect("a source in UTF-8");
                let whole = path.components().any(|c| c.as_os_str() == "tests")
                    || path.ends_with("tests.rs");
                sources.push(match whole {
                    true => text,
                    false => text
                        .split_once("#[cfg(test)]")
                        .map_or(String::new(), |(_, tests)| tests.to_owned()),
                });
            }
        }
    }
    sources
}
