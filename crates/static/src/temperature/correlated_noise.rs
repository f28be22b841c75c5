//! A grid of noises, white plus first-order Gauss–Markov or a random walk, each as the factor of its covariance.

use proofmass_uncertainty::adjustment::cholesky;

/// One noise: R_ij = η δ_ij + (1 − η) exp(−|t_i − t_j|/τ), or a walk in place of the exponential, as its Cholesky factor.
pub(super) struct Noise {
    /// L of R = L Lᵀ, lower triangle by rows.
    factor: Vec<f64>,
    n: usize,
    /// ln |R|.
    pub(crate) log_determinant: f64,
    /// Weight before the data, any unit.
    pub(crate) weight: f64,
    /// n²/Σ R_ij²: independent values that tell the variance as well as these n.
    pub(crate) effective: f64,
}

/// Correlation times end at this share of the record: what is slower is told from a walk by nothing.
const SLOWEST: f64 = 0.15;
/// Shares of white noise beside a Gauss–Markov process.
const WHITE: [f64; 4] = [0.0, 0.5, 0.8, 0.95];

/// Variance of a walk at the end of the recording over that of white noise.
const WALKS: [f64; 8] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4];

/// Weights of white noise and of each walk, where each Gauss–Markov process has 1: the three kinds weigh alike, or nearly.
const WEIGHT_OF_WHITE: f64 = 16.0;
const WEIGHT_OF_WALK: f64 = 4.0;

/// White noise first, then the correlated ones.
pub(super) fn grid(time: &[f64], block: f64) -> Vec<Noise> {
    let mut noises = stationary(time, block, SLOWEST);
    noises.extend(
        WALKS
            .iter()
            .filter_map(|ratio| Noise::walk(time, block, *ratio)),
    );
    noises
}

/// White noise and Gauss–Markov processes with correlation times up to a share of the record.
pub(super) fn stationary(time: &[f64], block: f64, slowest: f64) -> Vec<Noise> {
    let n = time.len();
    let length = (time[n - 1] - time[0]).max(block) / block;
    let mut noises = vec![Noise::white(n)];
    let mut tau = 1.0;
    while tau < slowest * length {
        noises.extend(
            WHITE
                .iter()
                .filter_map(|white| Noise::new(time, tau * block, *white)),
        );
        tau *= 2.0;
    }
    noises
}

impl Noise {
    /// White noise over n values.
    pub fn white(n: usize) -> Self {
        Self {
            factor: Vec::new(),
            n,
            log_determinant: 0.0,
            weight: WEIGHT_OF_WHITE,
            effective: n as f64,
        }
    }

    fn new(time: &[f64], tau: f64, white: f64) -> Option<Self> {
        let n = time.len();
        let wander = |i: usize, j: usize| (1.0 - white) * (-(time[i] - time[j]) / tau).exp();
        let below: f64 = (0..n)
            .map(|i| (0..i).map(|j| wander(i, j).powi(2)).sum::<f64>())
            .sum();
        let effective = (n * n) as f64 / (n as f64 + 2.0 * below);
        Self::of(n, effective, |i, j| match i == j {
            true => 1.0,
            false => wander(i, j),
        })
    }

    /// White noise of variance 1 and a walk of this variance at the end; its increments are as independent as the values of
    /// white noise.
    fn walk(time: &[f64], block: f64, ratio: f64) -> Option<Self> {
        let n = time.len();
        let span = (time[n - 1] - time[0]).max(block) + block;
        let mut noise = Self::of(n, n as f64, |i, j| {
            let white = if i == j { 1.0 } else { 0.0 };
            white + ratio * (time[i.min(j)] - time[0] + block) / span
        })?;
        noise.weight = WEIGHT_OF_WALK;
        Some(noise)
    }

    /// From the lower triangle of R.
    fn of(n: usize, effective: f64, element: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                factor[i * n + j] = element(i, j);
            }
        }
        cholesky(&mut factor, n)?;
        let log_determinant = (0..n).map(|i| 2.0 * factor[i * n + i].ln()).sum();
        Some(Self {
            factor,
            n,
            log_determinant,
            weight: 1.0,
            effective,
        })
    }

    /// L⁻¹ v.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        let mut out = v.to_vec();
        if self.factor.is_empty() {
            return out;
        }
        for i in 0..self.n {
            let row = &self.factor[i * self.n..i * self.n + i];
            let sum: f64 = row.iter().zip(&out).map(|(l, x)| l * x).sum();
            out[i] = (out[i] - sum) / self.factor[i * self.n + i];
        }
        out
    }
}
