//! Self-heating: the sensor warms above its thermometer after it was switched on.

use super::Blocks;
use super::averaged;
use super::correlated_noise::Noise;
use serde::Serialize;

/// Time constants that are tried.
const TRIED: usize = 8;
/// Share of a column that the rest of the model must leave unexplained.
pub(super) const LEAST: f64 = 0.02;
/// Weight from which a time constant counts as possible.
const POSSIBLE: f64 = 0.05;

/// What self-heating does to the output of one axis: A e^{−t/τ} from the beginning of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SelfHeating {
    /// A, m/s².
    pub amplitude: f64,
    /// Its standard uncertainty, m/s².
    pub standard_uncertainty: f64,
    /// τ by evidence, s.
    pub time_constant: f64,
    /// Part of the decay that temperature, attitudes and branches do not explain, 0 to 1.
    pub own_part: f64,
    /// Whether that part suffices to tell self-heating from temperature.
    pub determined: bool,
}

/// Decays over the blocks, and their time constants.
pub(super) struct WarmUp {
    pub(crate) times: Vec<f64>,
    pub(crate) decays: Vec<Vec<f64>>,
}

impl WarmUp {
    /// From three blocks to the longest time constant that is possible, s, or half of the recording.
    pub fn of(blocks: &Blocks, longest: f64) -> Self {
        let n = blocks.len();
        let start = blocks.time.first().copied().unwrap_or(0.0) - 0.5 * blocks.duration;
        let end = blocks.time.last().copied().unwrap_or(0.0) + 0.5 * blocks.duration;
        let shortest = 3.0 * blocks.duration;
        let longest = longest.min(0.5 * (end - start)).max(1.5 * shortest);
        let times: Vec<f64> = (0..TRIED)
            .map(|k| shortest * (longest / shortest).powf(k as f64 / (TRIED - 1) as f64))
            .collect();
        let decay = |tau: &f64| -> Vec<f64> {
            (0..n)
                .map(|i| (-(blocks.time[i] - start) / tau).exp())
                .collect()
        };
        Self {
            decays: times.iter().map(decay).collect(),
            times,
        }
    }

    /// What was found; `designs` hold the decays at `at`.
    pub fn found(
        &self,
        amplitude: f64,
        standard_uncertainty: f64,
        weights: &[f64],
        designs: &[Vec<Vec<f64>>],
        at: usize,
    ) -> SelfHeating {
        let logarithms = self.times.iter().zip(weights);
        let time_constant = logarithms.map(|(t, w)| w * t.ln()).sum::<f64>().exp();
        let possible = designs.iter().zip(weights).filter(|(_, w)| **w > POSSIBLE);
        let own_part = possible
            .map(|(columns, _)| own_part(columns, at))
            .fold(1.0, f64::min);
        SelfHeating {
            amplitude,
            standard_uncertainty,
            time_constant,
            own_part,
            determined: own_part > LEAST,
        }
    }
}

/// Root of the share of the sum of squares of a column, about its mean, that the others leave.
pub(super) fn own_part(columns: &[Vec<f64>], at: usize) -> f64 {
    let column = &columns[at];
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let about: f64 = column.iter().map(|v| (v - mean).powi(2)).sum();
    if about > 0.0 {
        (unexplained(columns, at) / about).sqrt()
    } else {
        0.0
    }
}

/// Sum of squares of a column that the others leave.
pub(super) fn unexplained(columns: &[Vec<f64>], at: usize) -> f64 {
    let column = &columns[at];
    let others: Vec<Vec<f64>> = columns
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != at)
        .map(|(_, c)| c.clone())
        .collect();
    let white = [Noise::white(column.len())];
    let Ok(fit) = averaged::fit(std::slice::from_ref(&others), column, &white) else {
        return 0.0;
    };
    (0..column.len())
        .map(|i| {
            let model: f64 = others
                .iter()
                .zip(&fit.estimate)
                .map(|(c, e)| c[i] * e)
                .sum();
            (column[i] - model).powi(2)
        })
        .sum()
}
