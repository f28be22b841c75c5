//! Words of the field: what each means here and which command does it. `docs/glossary.md` is the one list.

use crate::Failure;
use serde::Serialize;
use std::fmt;

const PAGE: &str = include_str!("../GLOSSARY.md");

/// A row of the glossary.
#[derive(Debug, Serialize)]
pub(crate) struct Entry {
    /// The standard term, then other words for it.
    pub(crate) words: Vec<String>,
    /// What it is here.
    pub(crate) meaning: String,
    /// Commands that do it.
    pub(crate) commands: Vec<String>,
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.words.as_slice() {
            [term, others @ ..] if !others.is_empty() => {
                writeln!(f, "{term} (also: {})", others.join(", "))?;
            }
            words => writeln!(f, "{}", words.join(", "))?,
        }
        writeln!(f, "{}\n", self.meaning)?;
        for command in &self.commands {
            writeln!(f, "     command: {command}")?;
        }
        Ok(())
    }
}

/// Every row of the page.
pub(crate) fn entries() -> impl Iterator<Item = Entry> {
    let rows = PAGE.lines().filter_map(|line| line.strip_prefix("| "));
    rows.filter_map(|row| {
        let mut cells = row.trim_end_matches('|').split(" | ").map(str::trim);
        let (words, meaning, place) = (cells.next()?, cells.next()?, cells.next()?);
        (words != "term").then(|| Entry {
            words: without_anchor(words).split(", ").map(plain).collect(),
            meaning: plain(meaning),
            commands: between_ticks(place),
        })
    })
}

/// The rows that have a word, whatever its case, hyphens or plural.
pub(crate) fn explain(word: &str) -> Vec<Entry> {
    let has = |wanted: &str| -> Vec<Entry> {
        entries()
            .filter(|entry| entry.words.iter().any(|w| key(w) == wanted))
            .collect()
    };
    let wanted = key(word);
    let found = has(&wanted);
    match wanted.strip_suffix('s') {
        Some(one) if found.is_empty() => has(one),
        _ => found,
    }
}

/// Where a word leads that was typed as a command and is none, as far as the glossary or the name of a deeper command
/// tells it.
pub(crate) fn no_command(word: &str, root: &clap::Command) -> Option<Failure> {
    if word == "records" {
        // With the feature it is a command.
        return Some(
            Failure::new("this program was built without `records`")
                .hint("use a build with the feature records, or build it from the source with that feature"),
        );
    }
    let mut deeper = Vec::new();
    for command in root.get_subcommands() {
        let of = command.get_subcommands().filter(|c| c.get_name() == word);
        deeper.extend(of.map(|c| format!("proofmass {} {}", command.get_name(), c.get_name())));
    }
    let entries = explain(word);
    if deeper.is_empty() && entries.is_empty() {
        return None;
    }
    let mut failure = Failure::new(format!("`{word}` is not a command here"));
    for entry in entries {
        let term = entry.words.first().map_or("", String::as_str);
        failure = failure.detail(format!("{term}: {}", entry.meaning));
        for command in entry.commands {
            // The name of a deeper command says it already.
            if !deeper.iter().any(|known| command.starts_with(known)) {
                deeper.push(command);
            }
        }
    }
    deeper.dedup();
    Some(failure.hint(format!("use `{}`", deeper.join("` or `"))))
}

/// Letters and figures alone, in lower case.
fn key(word: &str) -> String {
    let kept = word.chars().filter(|c| c.is_alphanumeric());
    kept.flat_map(char::to_lowercase).collect()
}

/// A cell without the anchor before it, which other pages link.
fn without_anchor(cell: &str) -> &str {
    cell.split_once("</a>").map_or(cell, |(_, words)| words)
}

/// Without the marks of the page.
fn plain(text: &str) -> String {
    text.replace(['*', '`'], "")
}

/// What stands between ticks.
fn between_ticks(text: &str) -> Vec<String> {
    text.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_row_is_read_and_every_command_of_it_exists() {
        let rows = PAGE
            .lines()
            .filter(|l| l.starts_with("| ") && !l.starts_with("| term"));
        assert_eq!(entries().count(), rows.count());
        let root = crate::help::command();
        for entry in entries() {
            assert!(
                !entry.meaning.is_empty() && !entry.commands.is_empty(),
                "{entry:?}"
            );
            let known = entry.commands.iter();
            for line in known.filter(|line| crate::tests::is_built(line)) {
                let mut words = line.split(' ');
                assert_eq!(words.next(), Some("proofmass"), "{line}");
                let mut command = &root;
                for word in words {
                    match command.find_subcommand(word) {
                        Some(deeper) => command = deeper,
                        None => {
                            let a_word_for_a_command = word.starts_with(char::is_lowercase);
                            assert!(!a_word_for_a_command || word.len() == 1, "{line}: {word}");
                            if let Some(option) = word.strip_prefix("--") {
                                let known = command.get_arguments();
                                let mut known = known.filter_map(clap::Arg::get_long);
                                assert!(known.any(|long| long == option), "{line}: {word}");
                            }
                            break;
                        }
                    }
                }
                assert!(command.get_name() != "proofmass", "{line}");
            }
        }
    }

    #[test]
    fn law_every_row_has_the_anchor_of_its_term() {
        let anchor = |word: &String| {
            let parts = word.split(|c: char| !c.is_ascii_alphanumeric());
            let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
            parts.join("-").to_ascii_lowercase()
        };
        let rows = PAGE
            .lines()
            .filter(|l| l.starts_with("| ") && !l.starts_with("| term"));
        let mut known = std::collections::BTreeSet::new();
        for (row, entry) in rows.zip(entries()) {
            // χ² has no letter for an anchor: the next word of its row has.
            let mut anchors = entry.words.iter().map(anchor);
            let anchor = anchors.find(|a| !a.is_empty()).unwrap();
            let begins = format!("| <a id=\"{anchor}\"></a>");
            assert!(
                row.starts_with(&begins),
                "{row}\nhas to begin with {begins}"
            );
            assert!(known.insert(anchor), "{row}\nhas the anchor of another");
        }
    }

    #[test]
    fn known_words_of_the_field_lead_to_their_command() {
        let root = crate::help::command();
        for (word, command) in [
            ("allan", "proofmass noise RECORDING"),
            ("psd", "proofmass noise RECORDING"),
            ("srs", "proofmass test shock RECORDING"),
            ("frf", "proofmass test random RECORDING"),
            ("shock", "proofmass test shock"),
            ("complementary", "proofmass velocity compare RECORDING"),
            ("zupt", "proofmass bias RECORDING"),
            ("VRW", "proofmass noise RECORDING"),
            ("arw", "proofmass noise RECORDING"),
            ("cross-axis", "proofmass calibrate CAMPAIGN"),
            (
                "nonorthogonality",
                "proofmass test orthogonality CALIBRATION",
            ),
            ("static-interval", "proofmass calibrate RECORDING"),
            ("static_intervals", "proofmass calibrate RECORDING"),
            ("drift", "proofmass velocity drift"),
            ("tumble-test", "proofmass test tilt TABLE"),
            ("noise-density", "proofmass noise RECORDING"),
            ("bias-instability", "proofmass noise RECORDING"),
            ("tilt", "proofmass test tilt"),
            ("fem", "proofmass modes WEDGE"),
            ("gum", "proofmass uncertainty MODEL"),
        ] {
            let said = no_command(word, &root).map(|failure| failure.to_string());
            let said = said.unwrap_or_default();
            assert!(said.contains(&format!("`{command}")), "{word}: {said}");
        }
        assert!(no_command("xyzzy", &root).is_none());
    }
}
