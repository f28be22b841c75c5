//! What a recording itself gives reason to doubt: clipped samples, temperature that drifts.

use crate::{PoseResidual, Samples, Segment, findings};
use proofmass_uncertainty::{Finding, Severity};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Samples at the limits of the declared range, per axis; limits in output units.
pub fn clipping(samples: &Samples<'_>, range: (f64, f64), segments: &[Segment]) -> Vec<Finding> {
    let (low, high) = range;
    let clipped = |v: f64| v <= low || v >= high;
    samples
        .columns()
        .into_iter()
        .zip(AXES)
        .filter_map(|(column, axis)| {
            let count = column.iter().filter(|v| clipped(**v)).count();
            let first = column.iter().position(|v| clipped(*v))?;
            let used = segments
                .iter()
                .any(|s| column[s.start..s.end].iter().any(|v| clipped(*v)));
            let (place, severity, consequence) = match used {
                true => ("inside a standstill", Severity::Decision, "the mean of that standstill is wrong"),
                false => ("between the standstills", Severity::Note, "the standstills are not affected"),
            };
            Some(
                proofmass_uncertainty::findings::clipped(
                    &format!("output {axis} is clipped"),
                    &format!("{place}: {count} samples at the limits {low} and {high}, the first is sample {first}"),
                    consequence,
                )
                .at(severity),
            )
        })
        .collect()
}

/// An output that stays at one value while another one moves: a dead channel, a stuck converter, a lost column.
pub fn frozen(samples: &Samples<'_>) -> Vec<Finding> {
    // A quantised output at rest repeats itself too, but then all rest.
    const RUN: usize = 50;
    const MOVED: f64 = 0.3;
    let columns = samples.columns();
    let span = |values: &[f64]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - low
    };
    (0..3)
        .filter_map(|axis| {
            let column = columns[axis];
            let (mut start, mut longest) = (0, (0, 0));
            for i in 1..=column.len() {
                if i == column.len() || column[i] != column[start] {
                    if i - start > longest.1 - longest.0 {
                        longest = (start, i);
                    }
                    start = i;
                }
            }
            let (start, end) = longest;
            let others = (0..3).filter(|other| *other != axis);
            let moved = others
                .clone()
                .any(|other| span(&columns[other][start..end]) > MOVED * span(columns[other]));
            (end - start >= RUN && moved).then(|| {
                proofmass_uncertainty::findings::frozen(
                    &format!("output {}", AXES[axis]),
                    &format!(
                        "{} from sample {start} to {end}, {:.0} % of the recording, while the others move",
                        column[start],
                        1e2 * (end - start) as f64 / column.len() as f64
                    ),
                    "look for a dead channel or a converter that stuck, and record again",
                )
            })
        })
        .collect()
}

/// Temperature that changes across the standstills, with the slope of the residuals against it.
///
/// `temperature` in °C per sample. Nothing is said below 2 K, where 200 ppm/K and 0.1 mg/K stay under 1 mg.
pub fn temperature_drift(
    temperature: &[f64],
    segments: &[Segment],
    residuals: &[PoseResidual],
) -> Option<Finding> {
    const NEGLIGIBLE: f64 = 2.0;
    let means: Vec<f64> = segments
        .iter()
        .filter(|s| s.end <= temperature.len() && !s.is_empty())
        .map(|s| temperature[s.start..s.end].iter().sum::<f64>() / s.len() as f64)
        .collect();
    let low = means.iter().copied().fold(f64::INFINITY, f64::min);
    let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !(high - low > NEGLIGIBLE) {
        return None;
    }
    let n = means.len() as f64;
    let centre = means.iter().sum::<f64>() / n;
    let sxx: f64 = means.iter().map(|t| (t - centre).powi(2)).sum();
    let mean_residual = residuals.iter().map(|r| r.magnitude_residual).sum::<f64>() / n;
    let slope = means
        .iter()
        .zip(residuals)
        .map(|(t, r)| (t - centre) * (r.magnitude_residual - mean_residual))
        .sum::<f64>()
        / sxx;
    let severity = if high - low > 10.0 {
        Severity::Decision
    } else {
        Severity::Warning
    };
    let finding = findings::temperature_dependence(
        "the temperature changed across the standstills",
        &format!(
            "{low:.1} to {high:.1} °C; residual slope {:+.3} mm/s² per kelvin",
            1e3 * slope
        ),
    );
    Some(finding.at(severity))
}
