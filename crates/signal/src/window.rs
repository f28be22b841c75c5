//! Windows, with their equivalent noise bandwidth.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Weights from one exact cosine to the next.
const STRIDE: usize = 64;

/// A window function, periodic (as a discrete Fourier transform sees it).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// No window.
    Rectangular,
    /// Hann: the usual choice for densities.
    #[default]
    Hann,
    /// Hamming.
    Hamming,
    /// Blackman–Harris, four terms, side lobes below −92 dB.
    BlackmanHarris,
    /// Flat top, five terms: amplitudes of lines to 0.01 dB.
    FlatTop,
}

impl Window {
    /// Coefficients a_j of w(z) = Σ (−1)^j a_j cos(2π j z).
    ///
    /// **Source** `[Heinzel2002] appendix C`; flat top with the five coefficients of SciPy and Matlab.
    fn cosines(self) -> &'static [f64] {
        match self {
            Self::Rectangular => &[1.0],
            Self::Hann => &[0.5, 0.5],
            Self::Hamming => &[0.54, 0.46],
            Self::BlackmanHarris => &[0.35875, 0.48829, 0.14128, 0.01168],
            Self::FlatTop => &[
                0.215_578_95,
                0.416_631_58,
                0.277_263_158,
                0.083_578_947,
                0.006_947_368,
            ],
        }
    }

    /// The n weights.
    pub fn weights(self, n: usize) -> Vec<f64> {
        let turn = |k: usize| (2.0 * PI * k as f64 / n as f64).sin_cos();
        // cos(φ + ψ) from exact sines and cosines of a few φ and ψ: two roundings more than its own.
        let within: Vec<(f64, f64)> = (0..STRIDE).map(turn).collect();
        let half = n.min(n / 2 + 1);
        let mut weights = Vec::with_capacity(n);
        for start in (0..half).step_by(STRIDE) {
            let (sine, cosine) = turn(start);
            for (s, c) in &within[..STRIDE.min(half - start)] {
                // (−1)^j cos jφ is the Chebyshev polynomial T_j at −cos φ: one cosine for all terms, summed from the last on.
                let x = sine * s - cosine * c;
                let (mut sum, mut before) = (0.0, 0.0);
                for a in self.cosines().iter().skip(1).rev() {
                    (sum, before) = (a + 2.0 * x * sum - before, sum);
                }
                weights.push(self.cosines()[0] + x * sum - before);
            }
        }
        // The other half is its mirror image.
        for k in half..n {
            weights.push(weights[n - k]);
        }
        weights
    }
}

/// Equivalent noise bandwidth of weights in bins: n Σw²/(Σw)².
///
/// ```
/// use proofmass_signal::{Window, equivalent_noise_bandwidth};
/// let bins = equivalent_noise_bandwidth(&Window::Hann.weights(64));
/// assert!((bins - 1.5).abs() < 1e-12);
/// ```
pub fn equivalent_noise_bandwidth(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    weights.len() as f64 * squares / (sum * sum)
}
