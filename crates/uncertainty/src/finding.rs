//! Findings: what to doubt in an answer that could be computed.

use serde::{Deserialize, Serialize};
use std::fmt;

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
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
/// ```
/// use proofmass_uncertainty::{Finding, Severity};
///
/// let finding = Finding::new(Severity::Warning, "excess-residuals", "the residuals exceed the noise of the means")
///     .evidence("χ² = 311.2 with 105 degrees of freedom")
///     .advice("check that the sensor stood still; the covariance was scaled by 2.96");
/// assert_eq!(finding.code(), "excess-residuals");
/// ```
#[doc(alias("warning", "diagnostic"))]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    severity: Severity,
    code: String,
    what: String,
    evidence: String,
    advice: String,
}

impl Finding {
    /// A finding with a stable kebab-case code and one sentence (no capital, no full stop) that says what is doubtful.
    pub fn new(severity: Severity, code: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            severity,
            code: code.into(),
            what: what.into(),
            evidence: String::new(),
            advice: String::new(),
        }
    }

    /// Adds the numbers that speak for it.
    #[must_use]
    pub fn evidence(mut self, evidence: impl Into<String>) -> Self {
        self.evidence = evidence.into();
        self
    }

    /// Adds what to do next.
    #[must_use]
    pub fn advice(mut self, advice: impl Into<String>) -> Self {
        self.advice = advice.into();
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
