//! Doubts about a campaign as a whole.

use super::MethodResult;
use crate::observation::{Correction, PhasorRow};
use proofmass_uncertainty::{Finding, Severity};

/// Places of the campaign that a correction says nothing about.
pub(super) fn gaps(correction: &Correction, rows: &[PhasorRow]) -> Option<Finding> {
    if correction.table.entries.is_empty() {
        return None;
    }
    let mut missing: Vec<String> = vec![];
    for row in rows {
        let inclination = row.configuration.inclination;
        if correction.table.get(inclination, row.frequency).is_none() {
            let place = format!("{:.4}° at {} Hz", inclination.to_degrees(), row.frequency);
            if !missing.contains(&place) {
                missing.push(place);
            }
        }
    }
    let first = missing.first()?;
    Some(
        Finding::new(
            Severity::Warning,
            "correction-incomplete",
            format!(
                "the correction \"{}\" does not cover the whole campaign",
                correction.label
            ),
        )
        .evidence(format!(
            "{} inclinations and frequencies have no entry and were not corrected, the first is {first}",
            missing.len()
        ))
        .advice("measure the spurious motion there too, or check the angles and frequencies of its table"),
    )
}

/// A rise that announces a resonance, and adhesive where it begins to count.
pub(super) fn high_frequencies(results: &[MethodResult]) -> Vec<Finding> {
    let mut findings = vec![];
    let Some(result) = results.iter().find(|r| r.frequencies.len() > 2) else {
        return findings;
    };
    let Some(highest) = result.frequencies.last() else {
        return findings;
    };
    for k in [0, 4, 8] {
        let mut low: Vec<f64> = result.frequencies[..result.frequencies.len() - 1]
            .iter()
            .map(|f| f.sensitivity[k].modulus.value)
            .collect();
        low.sort_by(f64::total_cmp);
        let (median, term) = (low[low.len() / 2], &highest.sensitivity[k]);
        let rise = term.modulus.value / median - 1.0;
        if rise > 0.03 && rise * median > term.modulus.expanded {
            // |S|/S₀ = 1/(1 − (f/f₀)²) below resonance.
            let resonance = highest.frequency / (1.0 - 1.0 / (1.0 + rise)).sqrt();
            findings.push(
                Finding::new(
                    Severity::Note,
                    "resonance-onset",
                    format!("S_{} rises towards a resonance", term.name),
                )
                .evidence(format!(
                    "{:.1} % above its median at {} Hz; an undamped resonance near {resonance:.0} Hz would do that",
                    100.0 * rise,
                    highest.frequency
                ))
                .advice("do not use the sensitivity of lower frequencies there"),
            );
        }
    }
    if highest.frequency > 1000.0 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "adhesive-mounting",
                "above 1 kHz an adhesive mounting changes the sensitivity",
            )
            .evidence(format!(
                "highest frequency {} Hz; published: −0.9 % at 2 kHz and −1.9 % at 3 kHz against a stud",
                highest.frequency
            ))
            .advice("mount by a stud, or state the mounting with the result"),
        );
    }
    findings
}

/// Main sensitivities that the datasheet does not know, at the frequency nearest to 160 Hz, where datasheets are made.
pub(super) fn off_datasheet(results: &[MethodResult]) -> Option<Finding> {
    let of_reference = |f: f64| (f / 160.0).ln().abs();
    let result = results
        .first()?
        .frequencies
        .iter()
        .min_by(|a, b| of_reference(a.frequency).total_cmp(&of_reference(b.frequency)))?;
    let off: Vec<String> = result
        .datasheet
        .iter()
        .filter(|d| d.e_n.abs() > 1.0)
        .map(|d| format!("{} {:+.1} %", d.axis, 100.0 * d.relative))
        .collect();
    (!off.is_empty()).then(|| {
        Finding::new(
            Severity::Warning,
            "off-datasheet",
            format!(
                "the sensitivity at {} Hz is not that of the datasheet",
                result.frequency
            ),
        )
        .evidence(format!(
            "{}, beyond tolerance and U together",
            off.join(", ")
        ))
        .advice("check gains, cables and the unit of the datasheet")
    })
}
