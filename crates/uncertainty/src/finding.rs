//! Findings: what to doubt in an answer that could be computed.

mod catalogue;
mod evidence;

pub use catalogue::FindingKind;
pub use evidence::{EvidenceValue, Figure};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Worth knowing; the result stands.
    Note,
    /// The result stands with a reservation that a reader must see.
    Warning,
    /// Somebody has to decide before the result is used.
    Decision,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Decision => "decision needed",
        })
    }
}

/// A doubt about a computed answer: what, the evidence in numbers, and what to do next.
///
/// Nothing is clipped, repaired or dropped in silence anywhere in the project: what would tempt one to is said
/// here instead, and the number stands beside it. An answer that cannot be given at all is an
/// [`Error`](proofmass_core::Error), not a finding.
///
/// Its kind (code, sentences, advice) is declared once, with [`findings!`](macro@crate::findings).
#[doc(alias("warning", "diagnostic"))]
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// How grave it is.
    severity: Severity,
    /// Code of the kind, by which `proofmass explain` and docs/findings.md know it.
    code: String,
    /// What is doubted.
    what: String,
    /// On what evidence, in numbers.
    evidence: String,
    /// What to do.
    advice: String,
    /// The evidence by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    evidence_fields: BTreeMap<String, EvidenceValue>,
    /// Severities that the kind admits; unknown once a finding was read back.
    #[serde(skip)]
    admitted: Option<&'static [Severity]>,
}

/// Two findings are equal when they say the same; where they come from does not count.
impl PartialEq for Finding {
    fn eq(&self, other: &Self) -> bool {
        self.severity == other.severity
            && self.code == other.code
            && self.what == other.what
            && self.evidence == other.evidence
            && self.advice == other.advice
            && self.evidence_fields == other.evidence_fields
    }
}

impl Eq for Finding {}

impl Finding {
    /// A finding of a declared kind; called by [`findings!`](macro@crate::findings) alone.
    #[doc(hidden)]
    pub fn of<const N: usize>(
        kind: &'static FindingKind,
        sentences: [String; 3],
        values: [EvidenceValue; N],
    ) -> Self {
        let [what, evidence, advice] = sentences;
        let names = kind.evidence_fields.iter().map(|n| (*n).to_owned());
        Self {
            severity: kind.usual_severity(),
            code: kind.code.to_owned(),
            what,
            evidence,
            advice,
            evidence_fields: names.zip(values).collect(),
            admitted: Some(kind.severities),
        }
    }

    /// The same finding with another of the severities that its kind admits.
    #[must_use]
    pub fn at(mut self, severity: Severity) -> Self {
        debug_assert!(
            self.admitted.is_none_or(|s| s.contains(&severity)),
            "the kind `{}` does not list the severity `{severity}`",
            self.code
        );
        self.severity = severity;
        self
    }

    /// The same finding of one part of the answer: the sentence begins with its name and a colon.
    #[must_use]
    pub fn of_part(mut self, part: impl fmt::Display) -> Self {
        self.what = format!("{part}: {}", self.what);
        self
    }

    /// The same finding with other evidence in words, made from that it has.
    #[must_use]
    pub fn with_evidence(mut self, evidence: impl FnOnce(&str) -> String) -> Self {
        self.evidence = evidence(&self.evidence);
        self
    }

    /// The same finding of several things: this is the first, the others have these names.
    #[must_use]
    pub fn likewise(mut self, others: &[&str]) -> Self {
        self.what = format!("{}; {} others likewise", self.what, others.len());
        self.evidence = format!("{}; the others: {}", self.evidence, others.join(", "));
        self
    }

    /// How much it weighs.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// Stable name of this kind of finding, for machines.
    pub fn code(&self) -> &str {
        &self.code
    }

    /// What is doubtful, in one sentence.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// The numbers that speak for it; empty when the sentence carries them.
    pub fn evidence_text(&self) -> &str {
        &self.evidence
    }

    /// The numbers and names of the evidence one by one, for machines.
    pub fn evidence_fields(&self) -> &BTreeMap<String, EvidenceValue> {
        &self.evidence_fields
    }

    /// What to do next; empty when nothing is to be done.
    pub fn advice_text(&self) -> &str {
        &self.advice
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.severity, self.what)?;
        if !self.evidence.is_empty() {
            write!(f, " ({})", self.evidence)?;
        }
        if !self.advice.is_empty() {
            write!(f, "; {}", self.advice)?;
        }
        Ok(())
    }
}
