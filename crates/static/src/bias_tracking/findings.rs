//! What the innovations speak against.

use super::{AxisTrack, RestMean};
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{Finding, Severity};

/// Ratio above which the result needs a decision.
const GRAVE: f64 = 2.0;
/// Departure in g of a rest that is no bias any more.
const TURNED: f64 = 0.05;

/// Rests that deviate, innovations that are too large, too small or correlated.
pub(super) fn findings(axes: &[AxisTrack; 3], means: &[RestMean]) -> Vec<Finding> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let mut findings = Vec::new();
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
            findings.push(
                Finding::new(
                    if turned { Severity::Decision } else { Severity::Warning },
                    if turned { "rest-in-another-attitude" } else { "rest-out-of-line" },
                    if turned {
                        format!("{name}: what a rest reads is not the known acceleration and a bias")
                    } else {
                        format!("{name}: a rest lies further from the prediction than noise and motion of the bias explain")
                    },
                )
                .evidence(format!(
                    "rest {} at {at:.1} s: {:.4} m/s² off, {:.1} standard deviations; {} of the rests in all",
                    worst.rest + 1,
                    worst.innovation,
                    worst.normalised.abs(),
                    consistency.deviating.len()
                ))
                .advice(if turned {
                    "was the sensor turned? state the attitude of every rest in a table of segments"
                } else {
                    "look for motion during that rest, a step of the bias (shock, temperature, switching), or take a wider initial uncertainty"
                }),
            );
        }
        if let Some(ratio) = consistency.departure() {
            let large = ratio > 1.0;
            findings.push(
                Finding::new(
                    if ratio > GRAVE { Severity::Decision } else { Severity::Warning },
                    if large { "innovations-too-large" } else { "innovations-too-small" },
                    format!(
                        "{name}: the innovations are {} than the stated noise lets expect",
                        if large { "larger" } else { "smaller" }
                    ),
                )
                .evidence(format!(
                    "{ratio:.2} times their standard deviation, {:.2} to {:.2} by chance over {} means",
                    consistency.limits[0], consistency.limits[1], consistency.updates
                ))
                .advice(if large {
                    "the intervals are too narrow: take the noise in the state in which this was recorded (mounted, running), or leave rests out that are none"
                } else {
                    "the intervals are too wide: the noise result is of another sensor, bandwidth or state"
                }),
            );
        }
        if let Some(r) = consistency.coloured() {
            let [statistic, limit] = consistency.whiteness.unwrap_or_default();
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "innovations-correlated",
                    format!("{name}: the innovations are correlated: the bias moves otherwise than its model"),
                )
                .evidence(format!(
                    "correlation up to {r:.2}; Ljung–Box {statistic:.1}, {limit:.1} by chance"
                ))
                .advice("the filter follows too slowly (positive) or too fast (negative): compare the model of the bias with a longer noise recording, and look at the temperature"),
            );
        }
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings
}
