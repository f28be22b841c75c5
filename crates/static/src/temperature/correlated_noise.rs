//! A grid of stationary noises, white plus first-order Gauss–Markov, each as the factor of its correlation matrix.

use proofmass_uncertainty::adjustment::cholesky;

/// One noise: R_ij = η δ_ij + (1 − η) exp(−|t_i − t_j|/τ), as its Cholesky factor.
pub(super) struct Noise {
    /// L of R = L Lᵀ, lower triangle by rows.
    factor: Vec<f64>,
    n: usize,
    /// ln |R|.
    pub(crate) log_determinant: f64,
    /// n²/Σ R_ij²: independent values that tell the variance as well as these n.
    pub(crate) effective: f64,
}

/// Correlation times in blocks, up to half the record, and shares of white noise.
const WHITE: [f64; 4] = [0.0, 0.5, 0.8, 0.95];

/// White noise first, then the correlated ones.
pub(super) fn grid(time: &[f64], block: f64) -> Vec<Noise> {
    let n = time.len();
    let length = (time[n - 1] - time[0]).max(block) / block;
    let mut noises = vec![Noise::white(n)];
    let mut tau = 1.0;
    while tau < 0.5 * length {
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
            effective: n as f64,
        }
    }

    fn new(time: &[f64], tau: f64, white: f64) -> Option<Self> {
        let n = time.len();
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                factor[i * n + j] = (1.0 - white) * (-(time[i] - time[j]) / tau).exp();
            }
            factor[i * n + i] = 1.0;
        }
        let below: f64 = (0..n)
            .map(|i| factor[i * n..i * n + i].iter().map(|r| r * r).sum::<f64>())
            .sum();
        let effective = (n * n) as f64 / (n as f64 + 2.0 * below);
        cholesky(&mut factor, n)?;
        let log_determinant = (0..n).map(|i| 2.0 * factor[i * n + i].ln()).sum();
        Some(Self {
            factor,
            n,
            log_determinant,
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
