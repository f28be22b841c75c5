//! Whether the output has settled at each temperature before it counts.

use super::coefficients::TemperatureFit;
use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_core::numeric::median;
use proofmass_uncertainty::{DegreesOfFreedom, Finding};

const MG: f64 = 1e3 / STANDARD_GRAVITY;

/// Share of the fastest rate of the temperature below which it rests.
const RESTING: f64 = 0.05;
/// Fewest blocks of a rest.
const FEWEST: usize = 6;
/// Fewest rests.
const RESTS: usize = 3;
/// Two-sided probability of a healthy recording, all axes together.
const FALSE_ALARM: f64 = 0.005;
/// Smallest effect on a mean slope that is worth words, as a share of its expanded uncertainty.
const WORTH: f64 = 0.3;

/// A stretch at one temperature.
struct Rest {
    first: usize,
    end: usize,
    /// +1 where it was reached from below, −1 from above.
    from: f64,
}

/// What still goes on at the temperatures: the residuals of the second half of each rest less those of the first, with the sign of the
/// way there.
///
/// The test is that of Student over the rests, which assumes nothing of the noise but that one rest knows little of the next. A lag
/// that the fit could tell is not in the residuals.
pub(super) fn of(fit: &TemperatureFit, probability: f64) -> Option<Finding> {
    let rests = rests(fit);
    if rests.len() < RESTS {
        return None;
    }
    let n = rests.len() as f64;
    let level = FALSE_ALARM / fit.axes.len() as f64;
    let limit = DegreesOfFreedom::new(n - 1.0)?.coverage_factor(1.0 - level);
    let span = fit.range[1] - fit.range[0];
    let told: Vec<String> = fit
        .named_axes()
        .enumerate()
        .filter_map(|(k, (name, axis))| {
            let moved: Vec<f64> = rests
                .iter()
                .map(|rest| {
                    let middle = rest.first + (rest.end - rest.first) / 2;
                    let mean = |from: usize, to: usize| {
                        axis.residuals[from..to].iter().sum::<f64>() / (to - from) as f64
                    };
                    rest.from * (mean(middle, rest.end) - mean(rest.first, middle))
                })
                .collect();
            let mean = moved.iter().sum::<f64>() / n;
            let scatter = moved.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let slope = fit.slope(k)?;
            let worth = WORTH * slope.expanded(probability) * span;
            (mean.abs() > limit * (scatter / n).sqrt() && mean.abs() > worth)
                .then(|| format!("{name}: {:+.3} mg", mean * MG))
        })
        .collect();
    if told.is_empty() {
        return None;
    }
    let mut lengths: Vec<f64> = rests
        .iter()
        .map(|r| (r.end - r.first) as f64 * fit.blocks.duration / 60.0)
        .collect();
    let typical = median(&mut lengths).unwrap_or(0.0);
    Some(findings::soak_too_short(
        rests.len(),
        typical,
        &told.join("; "),
    ))
}

fn rests(fit: &TemperatureFit) -> Vec<Rest> {
    let (blocks, n) = (&fit.blocks, fit.blocks.len());
    // Over the neighbours on both sides, so that the noise of the thermometer makes no rate.
    let rate = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
        (blocks.temperature[b] - blocks.temperature[a]) / (blocks.time[b] - blocks.time[a])
    };
    let fastest = (0..n).map(|i| rate(i).abs()).fold(0.0, f64::max);
    let span = fit.range[1] - fit.range[0];
    let still = |i: usize| rate(i).abs() <= RESTING * fastest;
    let mut found = Vec::new();
    let mut i = 0;
    while i < n {
        let first = i;
        while i < n && still(i) && blocks.attitude[i] == blocks.attitude[first] {
            i += 1;
        }
        if i - first >= FEWEST && first > 0 {
            let here = blocks.temperature[first];
            // The last temperature that was another one.
            let before = (0..first).rev().map(|k| blocks.temperature[k]);
            let before = before.into_iter().find(|t| (t - here).abs() > 0.02 * span);
            if let Some(before) = before {
                found.push(Rest {
                    first,
                    end: i,
                    from: (here - before).signum(),
                });
            }
        }
        i = i.max(first + 1);
    }
    found
}
