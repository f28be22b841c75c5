//! What the innovations speak against.

use super::{AxisTrack, RestMean};
use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{Finding, Severity};

/// Ratio above which the result needs a decision.
const GRAVE: f64 = 2.0;
/// Departure in g of a rest that is no bias any more.
const TURNED: f64 = 0.05;

/// Rests that deviate, innovations that are too large, too small or correlated.
pub(super) fn findings(axes: &[AxisTrack; 3], means: &[RestMean]) -> Vec<Finding> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let mut found = Vec::new();
    for (axis, name) in axes.iter().zip(AXES) {
        let consistency = &axis.consistency;
        if let Some(worst) = consistency
            .deviating
            .iter()
            .max_by(|a, b| a.innovation.abs().total_cmp(&b.innovation.abs()))
        {
            let turned = worst.innovation.abs() > TURNED * STANDARD_GRAVITY;
            let at = means
                .iter()
                .find(|m| m.rest == worst.rest)
                .map_or(0.0, |m| m.time);
            let kind = if turned {
                findings::rest_in_another_attitude
            } else {
                findings::rest_out_of_line
            };
            found.push(kind(
                name,
                worst.rest + 1,
                at,
                worst.innovation,
                worst.normalised.abs(),
                consistency.deviating.len(),
            ));
        }
        if let Some(ratio) = consistency.departure() {
            let [low, high] = consistency.limits;
            let kind = if ratio > 1.0 {
                findings::innovations_too_large
            } else {
                findings::innovations_too_small
            };
            let finding = kind(name, ratio, low, high, consistency.updates);
            found.push(if ratio > GRAVE {
                finding.at(Severity::Decision)
            } else {
                finding
            });
        }
        if let Some(r) = consistency.coloured() {
            let [statistic, limit] = consistency.whiteness.unwrap_or_default();
            let finding = proofmass_uncertainty::findings::innovations_correlated(
                "the bias moves otherwise than its model",
                &format!(
                    "correlation up to {r:.2}; Ljung–Box {statistic:.1}, {limit:.1} by chance"
                ),
                "the filter follows too slowly (positive) or too fast (negative): compare the model of the bias with a longer noise recording, and look at the temperature; the stated uncertainty is a lower bound",
            );
            found.push(finding.of_part(name));
        }
    }
    found.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    found
}
