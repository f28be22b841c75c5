//! A step of the output that no temperature makes: was the sensor moved while its temperature changed?

use super::Blocks;
use super::correlated_noise::Noise;
use proofmass_uncertainty::adjustment::{cholesky, solve};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// The step of one axis that explains most beside temperature, attitudes and branches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OutputStep {
    /// When, s.
    pub time: f64,
    /// Its size, m/s².
    pub size: f64,
    /// What it would do to the mean slope, m/s² per K.
    pub slope: f64,
    /// Probability of one that speaks as loudly on any axis where there is none.
    pub p_value: f64,
}

/// Of the steps between any two neighbouring blocks of one stretch, the one with the largest F under this noise.
///
/// `columns`: the design without a step; `weights`: of its last columns (from `from` on) in the mean slope.
pub(super) fn largest(
    blocks: &Blocks,
    columns: &[Vec<f64>],
    y: &[f64],
    noise: &Noise,
    slope: (usize, &[f64]),
) -> Option<OutputStep> {
    let (n, p) = (y.len(), columns.len());
    let freedom = n.checked_sub(p + 2)?;
    let x: Vec<Vec<f64>> = columns.iter().map(|c| noise.whiten(c)).collect();
    let mut normal = vec![0.0; p * p];
    for a in 0..p {
        for b in 0..=a {
            normal[a * p + b] = product(&x[a], &x[b]);
        }
    }
    cholesky(&mut normal, p)?;
    let fitted = |v: &[f64]| {
        let mut right: Vec<f64> = x.iter().map(|c| product(c, v)).collect();
        solve(&normal, &mut right);
        right
    };
    let without = |v: &[f64], coefficients: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|i| v[i] - (0..p).map(|a| x[a][i] * coefficients[a]).sum::<f64>())
            .collect()
    };
    let white = noise.whiten(y);
    let residual = without(&white, &fitted(&white));
    let all = product(&residual, &residual);
    let mut tried = 0usize;
    let mut best: Option<(f64, OutputStep)> = None;
    for at in 1..n {
        if blocks.attitude[at] != blocks.attitude[at - 1]
            || blocks.stretch[at] != blocks.stretch[at - 1]
        {
            continue;
        }
        tried += 1;
        let end = (at..n)
            .find(|i| blocks.attitude[*i] != blocks.attitude[at])
            .unwrap_or(n);
        let mut step = vec![0.0; n];
        step[at..end].fill(1.0);
        let step = noise.whiten(&step);
        let coefficients = fitted(&step);
        let own = without(&step, &coefficients);
        let square = product(&own, &own);
        if !(square > 1e-6 * product(&step, &step)) {
            continue;
        }
        let size = product(&own, &residual) / square;
        let explained = size * size * square;
        let f = explained * freedom as f64 / (all - explained).max(f64::MIN_POSITIVE);
        if best.as_ref().is_none_or(|(b, _)| f > *b) {
            let (from, weights) = slope;
            let change: f64 = weights
                .iter()
                .zip(&coefficients[from..])
                .map(|(w, c)| w * c)
                .sum();
            best = Some((
                f,
                OutputStep {
                    time: 0.5 * (blocks.time[at - 1] + blocks.time[at]),
                    size,
                    slope: size * change,
                    p_value: 1.0,
                },
            ));
        }
    }
    let (f, mut step) = best?;
    let one = FisherSnedecor::new(1.0, freedom as f64).map_or(1.0, |d| d.sf(f));
    step.p_value = (one * (blocks.axes * tried) as f64).min(1.0);
    Some(step)
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
