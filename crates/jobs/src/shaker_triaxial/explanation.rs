//! What a fit that failed says to the person who recorded the runs.

use super::ShakerTriaxialData;
use crate::trouble::Trouble;
use proofmass_calibration::shaker::{ShakerCampaign, SpuriousTable, diagnose, observations};
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};

/// The error with every doubt about the runs that may have caused it.
pub(super) fn explain(
    error: Error,
    campaign: &ShakerCampaign,
    data: &ShakerTriaxialData<'_>,
) -> Trouble {
    if error.is_cancelled() {
        return error.into();
    }
    let mut findings: Vec<Finding> = data.findings.to_vec();
    if let Ok(seen) = observations(campaign) {
        findings.extend(seen.findings);
        let none = SpuriousTable::default();
        if let Ok((_, doubts)) = diagnose(&seen.rows, &none, &seen.budget, campaign.plan.as_deref())
        {
            findings.extend(doubts);
        }
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings.retain(|f| f.severity() != Severity::Note);
    let mut trouble = Trouble::from(error).detail(data.name);
    for finding in findings.iter().take(6) {
        trouble = trouble.detail(format!("{} ({})", finding.what(), finding.evidence_text()));
    }
    match findings.first().map(Finding::advice_text) {
        Some(advice) if !advice.is_empty() => trouble.with_hint(advice),
        _ => trouble.with_hint(match error {
            Error::NotConverged { .. } => {
                "the runs contradict each other or the budget: look at the phases and at the units of the headings"
            }
            Error::Unobservable { parameter, .. } if parameter.contains("clock of its own") => {
                "mount it on wedges between 0° and 90° too, where two axes move together; or stamp both files by one clock (clock = \"shared\")"
            }
            _ => "S needs at least three configurations that span space at every frequency: check inclination, rotation and frequency in the table of runs",
        }),
    }
}
