//! Standstills in which an output is cut off, where the range of the converter was not told.

use proofmass_signal::saturation::rails;
use proofmass_static::{Samples, Segment};
use proofmass_uncertainty::{Figure, Finding, findings};

const AXES: [&str; 3] = ["x", "y", "z"];
/// Values from which a rest shows the noise of the sensor and not the steps of its converter.
const FINE: usize = 5;
/// Share of the samples of such a rest that do not stand at one extreme of it by themselves.
const MANY: f64 = 0.2;

/// A finding for each output that is cut off at an extreme of its record within standstills. What is cut off between them changes no
/// mean.
pub(super) fn saturated_rests(samples: &Samples<'_>, segments: &[Segment]) -> Vec<Finding> {
    let columns = AXES.into_iter().zip(samples.columns());
    columns
        .filter_map(|(axis, column)| {
            let ends = [f64::min, f64::max].map(|f| column.iter().copied().fold(f64::NAN, f));
            let rests = || segments.iter().map(|s| &column[s.start..s.end]);
            // A converter whose steps hide the noise makes rests of few values, many of them at the last.
            let noisy = rests().filter(|rest| takes(rest, FINE)).count();
            let cut = |rest: &[f64]| {
                let at = |end: &f64| rest.iter().filter(|v| *v == end).count();
                let many = |end: &&f64| at(end) as f64 > MANY * rest.len() as f64;
                match ends.iter().find(many) {
                    Some(end) => (2 * noisy > segments.len()).then(|| {
                        (
                            *end,
                            format!("{} of {} samples at {}", at(end), rest.len(), Figure(*end)),
                        )
                    }),
                    None => rails(rest)
                        .iter()
                        .find(|r| ends.contains(&r.level))
                        .map(|r| (r.level, r.evidence())),
                }
            };
            let found: Vec<(usize, (f64, String))> = rests()
                .enumerate()
                .filter_map(|(k, rest)| Some((k, cut(rest)?)))
                .collect();
            let (first, (level, evidence)) = found.first()?;
            let side = if *level == ends[1] { "upper" } else { "lower" };
            Some(findings::clipped(
                &format!(
                    "output {axis} is cut off at the {side} end of its range inside a standstill"
                ),
                &format!(
                    "in {} of {} standstills; in the first, from sample {}, {evidence}",
                    found.len(),
                    segments.len(),
                    segments[*first].start
                ),
                "the mean of that standstill is wrong",
            ))
        })
        .collect()
}

/// Whether a rest takes at least so many different values.
fn takes(rest: &[f64], values: usize) -> bool {
    let mut seen: Vec<f64> = Vec::with_capacity(values);
    for v in rest {
        if !seen.contains(v) {
            seen.push(*v);
        }
        if seen.len() >= values {
            return true;
        }
    }
    false
}
