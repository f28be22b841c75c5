//! What a fit that failed says to the person who recorded the runs.

use super::Data;
use crate::Failure;
use proofmass::calibration::shaker::{SpuriousTable, diagnose, observations};
use proofmass::core::Error;
use proofmass::uncertainty::{Finding, Severity};

/// The error with every doubt about the runs that may have caused it.
pub(super) fn explain(error: Error, data: &Data) -> Failure {
    let mut findings: Vec<Finding> = data.observed.findings.clone();
    if let Ok(seen) = observations(&data.stated) {
        findings.extend(seen.findings);
        let none = SpuriousTable::default();
        if let Ok((_, doubts)) =
            diagnose(&seen.rows, &none, &seen.budget, data.stated.plan.as_deref())
        {
            findings.extend(doubts);
        }
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings.retain(|f| f.severity() != Severity::Note);
    let mut failure = Failure::new(error.to_string()).detail(data.table.path.display().to_string());
    for finding in findings.iter().take(6) {
        failure = failure.detail(format!("{} ({})", finding.what(), finding.evidence_text()));
    }
    match findings.first().map(Finding::advice_text) {
        Some(advice) if !advice.is_empty() => failure.hint(advice),
        _ => failure.hint(match error {
            Error::NotConverged { .. } => {
                "the runs contradict each other or the budget: look at the phases and at the units of the headings"
            }
            _ => "S needs at least three configurations that span space at every frequency: check inclination, rotation and frequency in the table of runs",
        }),
    }
}
