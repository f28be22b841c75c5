//! What a fit that failed says to the person who recorded the runs.

use super::ShakerTriaxialData;
use crate::trouble::Trouble;
use proofmass_core::Error;
use proofmass_shaker::diagnosis::strangest;
use proofmass_shaker::{ShakerCampaign, SpuriousTable, diagnose, observations};
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
    let mut runs = vec![];
    if let Ok(seen) = observations(campaign) {
        findings.extend(seen.findings);
        let none = SpuriousTable::default();
        let tables = campaign.corrections.iter().map(|c| &c.table);
        let best = tables.max_by_key(|t| t.entries.len()).unwrap_or(&none);
        if let Ok((_, doubts)) = diagnose(&seen.rows, best, &seen.budget, campaign.plan.as_deref())
        {
            findings.extend(doubts);
        }
        if matches!(error, Error::NotConverged { .. }) {
            runs = strangest(&seen.rows, best, &seen.budget);
        }
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings.retain(|f| f.severity() != Severity::Note);
    // What was read wrongly throughout is the cause, and that the fit fails its consequence.
    let cause = findings
        .iter()
        .find(|f| matches!(f.code(), "phases-not-measured" | "radians-as-degrees"))
        .cloned();
    if let Some(cause) = cause {
        return Trouble::data(cause.what().to_owned())
            .detail(data.name)
            .detail(cause.evidence_text().to_owned())
            .with_hint(cause.advice_text().to_owned());
    }
    let mut trouble = match error {
        // None is left, which says nothing of how many there were.
        Error::TooFew {
            name: "configurations at a frequency",
            got: 0,
            ..
        } => Trouble::data(
            "no frequency has enough configurations: three whose directions span space are needed",
        ),
        _ => Trouble::from(error),
    }
    .detail(data.name);
    if !runs.is_empty() {
        let names = runs.iter().map(|(run, f)| format!("run {run} ({f} Hz)"));
        let names: Vec<String> = names.take(9).collect();
        trouble = trouble.detail(format!(
            "farthest from what most runs agree about: {}",
            names.join(", ")
        ));
    }
    for finding in findings.iter().take(6) {
        trouble = trouble.detail(format!("{} ({})", finding.what(), finding.evidence_text()));
    }
    match findings.first().map(Finding::advice_text) {
        Some(advice) if !advice.is_empty() => trouble.with_hint(advice),
        _ => trouble.with_hint(match error {
            Error::NotConverged { .. } => {
                "the runs contradict each other or the budget: look at the runs that are named (exclude in [runs] leaves them out), else at the phases and at the units of the headings"
            }
            Error::Unobservable { parameter, .. } if parameter.contains("clock of its own") => {
                "mount it on wedges between 0° and 90° too, where two axes move together; or stamp both files by one clock (clock = \"shared\")"
            }
            _ => "S needs at least three configurations that span space at every frequency: check inclination, rotation and frequency in the table of runs",
        }),
    }
}
