//! The catalogue of every finding: what each room declares, in one list, as text and as a page.

pub mod filing;
mod kinds;

pub(crate) use kinds::*;

use crate::{Result, Trouble};
use proofmass_documents::CalibrationFile;
use proofmass_uncertainty::{Finding, FindingKind, Severity};
use serde::Serialize;
use std::fmt::{self, Write as _};

/// Every kind of finding with the room that declares it.
pub fn catalogue() -> Vec<(&'static str, &'static FindingKind)> {
    let rooms: [(&str, &'static [FindingKind]); 12] = [
        ("uncertainty", proofmass_uncertainty::CATALOGUE),
        ("io", proofmass_io::CATALOGUE),
        ("documents", proofmass_documents::CATALOGUE),
        ("noise", proofmass_noise::CATALOGUE),
        ("static", proofmass_static::CATALOGUE),
        ("shaker", proofmass_shaker::findings::CATALOGUE),
        ("dynamic", proofmass_dynamic::findings::CATALOGUE),
        ("motion", proofmass_motion::CATALOGUE),
        ("odometry", proofmass_odometry::CATALOGUE),
        ("fixture", proofmass_fixture::CATALOGUE),
        ("jobs", CATALOGUE),
        ("records", filing::CATALOGUE),
    ];
    rooms
        .into_iter()
        .flat_map(|(room, kinds)| kinds.iter().map(move |kind| (room, kind)))
        .collect()
}

/// What a calibration follows, where it is taken at its reference.
pub(crate) fn taken_at_reference(file: &CalibrationFile) -> Vec<Finding> {
    let thermal = file
        .temperature
        .iter()
        .map(|block| temperature_not_followed(block.reference));
    let around = file.environment.iter().map(|block| {
        environment_not_followed(
            &block.name,
            &format!("{:.4} {}", block.reference, block.unit),
        )
    });
    thermal.chain(around).collect()
}

/// What the catalogue says of one code. Numbers are shown by their names, `⟨like this⟩`.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Explanation {
    /// Stable name of the kind.
    pub code: &'static str,
    /// The room that declares it.
    pub room: &'static str,
    /// The severities it may have; the first is the usual one.
    pub severities: &'static [Severity],
    /// What it means.
    pub meaning: String,
    /// What is doubtful.
    pub what: String,
    /// The numbers that speak for it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub evidence: String,
    /// What to do next.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub advice: String,
    /// Names of the values in `evidence_fields` of such a finding.
    pub evidence_fields: &'static [&'static str],
    /// How often it is found in healthy data, where that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_alarms: Option<&'static str>,
}

/// What stands in the place of an advice that the call chooses.
const ELSEWHERE: &str = "the result states what to do";

/// Whether a line is one name alone, and says nothing by itself.
fn is_open(line: &str) -> bool {
    let bare = line.strip_prefix("the ").unwrap_or(line);
    let name = bare.strip_prefix('⟨').and_then(|l| l.strip_suffix('⟩'));
    name.is_some_and(|name| !name.contains('⟨'))
}

impl Explanation {
    fn of((room, kind): (&'static str, &'static FindingKind)) -> Self {
        Self {
            code: kind.code,
            room,
            severities: kind.severities,
            meaning: kind.meaning_line(),
            what: match kind.what_line() {
                line if is_open(&line) => kind.meaning_line().trim_end_matches('.').to_owned(),
                line => line,
            },
            evidence: kind.evidence_line(),
            // There are several, and the call that found it chooses.
            advice: match kind.advice_line() {
                line if is_open(&line) => ELSEWHERE.to_owned(),
                line => line.replace("⟨remedy⟩", ELSEWHERE),
            },
            evidence_fields: kind.evidence_fields,
            false_alarms: kind.false_alarms,
        }
    }

    /// Label and text of each line that a reader is shown.
    fn lines(&self) -> Vec<(&'static str, String)> {
        let severities: Vec<String> = self.severities.iter().map(Severity::to_string).collect();
        let lines = [
            ("severity", severities.join(", or ")),
            ("sentence", self.what.clone()),
            ("evidence", self.evidence.clone()),
            ("advice", self.advice.clone()),
            (
                "false alarms",
                self.false_alarms.unwrap_or_default().to_owned(),
            ),
        ];
        lines
            .into_iter()
            .filter(|(_, text)| !text.is_empty())
            .collect()
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({})\n{}\n", self.code, self.room, self.meaning)?;
        for (label, text) in self.lines() {
            writeln!(f, "{label:>12}: {text}")?;
        }
        Ok(())
    }
}

/// Every kind, explained, in the order of the catalogue.
pub fn explanations() -> Vec<Explanation> {
    catalogue().into_iter().map(Explanation::of).collect()
}

/// What a code means.
///
/// # Errors
/// No finding has this code; the hint names the nearest one.
pub fn explain(code: &str) -> Result<Explanation> {
    let all = catalogue();
    if let Some(found) = all.iter().find(|(_, kind)| kind.code == code) {
        return Ok(Explanation::of(*found));
    }
    let near = proofmass_io::spelling::nearest(code, all.iter().map(|(_, kind)| kind.code));
    Err(
        Trouble::request(format!("no finding has the code `{code}`")).with_hint(match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`proofmass explain` without a code lists all of them".to_owned(),
        }),
    )
}

/// The page `docs/findings.md`.
pub fn page() -> String {
    let mut page = String::from(
        "# Findings\n\n\
         A finding is a doubt about an answer that could be computed: what, the evidence in numbers, and what to do next.\n\
         `proofmass explain CODE` shows an entry of this page. Numbers are shown by their names, ⟨like this⟩; the same names\n\
         are the keys of `evidence_fields` of a finding in `result.json`. A *note* is worth knowing, a *warning* is a reservation,\n\
         and a *decision* has to be made before the result is used (exit code 3 under `--strict`). Words are explained in the\n\
         [glossary](glossary.md).\n\n\
         This page is made from the catalogue: `cargo run -p proofmass-jobs --example pages`.\n",
    );
    let mut room = "";
    for kind in explanations() {
        if kind.room != room {
            room = kind.room;
            let _ = write!(page, "\n## {room}\n");
        }
        let _ = write!(page, "\n### `{}`\n\n{}\n\n", kind.code, kind.meaning);
        for (label, text) in kind.lines() {
            let _ = writeln!(page, "- {label}: {text}");
        }
    }
    page
}
