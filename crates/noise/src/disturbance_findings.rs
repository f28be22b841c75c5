//! What disturbances mean for the curve, in words.

use crate::coefficients::figure;
use crate::findings;
use crate::{AnalysisOptions, Disturbance, DisturbanceKind, JointInfluence};
use proofmass_uncertainty::{Finding, Severity};

/// Spikes everywhere are a property of the sensor; what moves the curve needs a decision, the rest a look. Whether the curve
/// moves is asked of all of them together, not only of each.
pub(crate) fn disturbance_findings(
    found: &[Disturbance],
    joint: Option<JointInfluence>,
    options: &AnalysisOptions,
) -> Vec<Finding> {
    let quiet_spike = |d: &&Disturbance| d.kind == DisturbanceKind::Spike && d.displacement < 3.0;
    let spikes = found.iter().filter(quiet_spike).count();
    let mut findings = Vec::new();
    let together = joint.map_or(String::new(), |j| {
        format!(
            "; all disturbances together raise the Allan deviation at {} s by {:.1} %, {:.1} times its standard uncertainty",
            figure(j.tau),
            100.0 * (1.0 / (1.0 - j.influence.clamp(0.0, 0.99)).sqrt() - 1.0),
            j.displacement.max(0.0)
        )
    });
    let moved = joint.is_some_and(|j| j.displacement >= 3.0);
    if moved && found.iter().all(|d| d.displacement < 3.0) {
        findings.push(findings::disturbances_together(found.len(), &together));
    }
    if spikes > 0 {
        findings.push(
            findings::isolated_spikes(spikes, &together).at(if spikes > 3 {
                Severity::Note
            } else {
                Severity::Warning
            }),
        );
    }
    let mut rest: Vec<&Disturbance> = found.iter().filter(|d| !quiet_spike(d)).collect();
    rest.sort_by(|a, b| b.displacement.total_cmp(&a.displacement));
    let Some(worst) = rest.first() else {
        return findings;
    };
    let decisive = worst.displacement >= 3.0;
    findings.push(
        findings::disturbance(
            if decisive {
                "and it changes the Allan curve"
            } else {
                "and it changes the Allan curve by less than three of its standard uncertainties"
            },
            rest.len(),
            match worst.kind {
                DisturbanceKind::Step => "step",
                DisturbanceKind::Burst => "burst",
                DisturbanceKind::Lull => "lull",
                DisturbanceKind::Spike => "spike",
            },
            worst.seconds.0,
            worst.seconds.1,
            worst.strength,
            worst.threshold,
            1.0 / options.disturbance_false_alarm_rate,
            100.0 * worst.influence,
            worst.displacement,
        )
        .at(if decisive {
            Severity::Decision
        } else {
            Severity::Warning
        }),
    );
    findings
}
