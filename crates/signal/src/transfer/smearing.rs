//! What window and estimator make of a response: the estimate that is expected where a resonance is narrow against the lines.

use super::{Estimator, in_both};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Steps to a line in which a window is looked at.
const STEPS: usize = 4;

/// The expected estimate of a response under a stationary input whose density is even over a few lines.
///
/// Over windowed segments E Gxy = Gxx Σ_m q_m H(f + mΔ/4) and E Gyy = Gxx Σ_m q_m |H(f + mΔ/4)|², Δ the distance of lines and
/// q_m ∝ |W(mΔ/4)|² the power of the window at quarters of lines, Σ q_m = 1; H₁, H₂ and Hv follow from these. Sums in steps of Δ/4 are
/// exact for a response to an impulse that has decayed within three segments; in steps of Δ/2, within one.
///
/// **Source** `[BendatPiersol2010] 9.1.3` for the bias, here without its expansion in powers of Δ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Smearing {
    pub(super) estimator: Estimator,
    /// Hz.
    pub(super) line: f64,
    /// q₀, q₁, …
    pub(super) weights: Vec<f64>,
}

impl Smearing {
    /// E Gxy/Gxx at a frequency (Hz) of the response S: what H₁ is expected to be, linear in S.
    pub fn cross(&self, frequency: f64, s: impl Fn(f64) -> Complex64) -> Complex64 {
        self.sums(frequency, s).0
    }

    /// The expected estimate at a frequency (Hz) of the response S.
    pub fn expected(&self, frequency: f64, s: impl Fn(f64) -> Complex64) -> Complex64 {
        let (cross, power) = self.sums(frequency, s);
        match self.estimator {
            Estimator::H1 => cross,
            Estimator::H2 => power / cross.conj(),
            Estimator::Hv { noise_ratio } => {
                in_both(1.0, power, cross, noise_ratio, f64::INFINITY).0
            }
        }
    }

    /// E Gxy and E Gyy over Gxx.
    fn sums(&self, frequency: f64, s: impl Fn(f64) -> Complex64) -> (Complex64, f64) {
        let mut cross = Complex64::new(0.0, 0.0);
        let mut power = 0.0;
        for (m, q) in self.weights.iter().enumerate() {
            let away = m as f64 * self.line / STEPS as f64;
            for f in [frequency - away, frequency + away]
                .into_iter()
                .take(if m == 0 { 1 } else { 2 })
            {
                // A response to a real input is conjugate at negative frequencies.
                let h = if f < 0.0 { s(-f).conj() } else { s(f) };
                cross += *q * h;
                power += *q * h.norm_sqr();
            }
        }
        (cross, power)
    }
}

impl Smearing {
    /// Variance of an estimate, had it come out as `expected` instead of `found`, over the variance that was stated with it.
    ///
    /// The variance that H₂ and Hv state grows with the modulus they find, by [(ρ + |Ĥ|²)/(ρ + |H|²)]², ρ the ratio of the noises
    /// (0 for H₂, ∞ for H₁): readings that came out low would weigh more than those that came out high.
    pub fn variance_ratio(&self, expected: Complex64, found: Complex64) -> f64 {
        let ratio = match self.estimator {
            Estimator::H1 => return 1.0,
            Estimator::H2 => 0.0,
            Estimator::Hv { noise_ratio } => noise_ratio,
        };
        let (due, is) = (ratio + expected.norm_sqr(), ratio + found.norm_sqr());
        if due > 0.0 && is > 0.0 {
            (due / is).powi(2)
        } else {
            1.0
        }
    }
}

/// q_m of a window, up to the last above 10⁻⁶ of the first.
pub(super) fn weights(window: &[f64]) -> Vec<f64> {
    let mut long = window.to_vec();
    long.resize(STEPS * window.len(), 0.0);
    let spectrum = crate::fourier::forward_owned(long);
    let mut powers: Vec<f64> = spectrum
        .iter()
        .map(|w| w.norm_sqr())
        .take(32 * STEPS)
        .collect();
    let first = powers.first().copied().unwrap_or(1.0);
    let last = powers.iter().rposition(|p| *p > 1e-6 * first).unwrap_or(0);
    powers.truncate(last + 1);
    let sum = 2.0 * powers.iter().sum::<f64>() - first;
    powers.iter_mut().for_each(|p| *p /= sum);
    powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;

    #[test]
    fn known_hann_window_at_quarters_of_lines() {
        let q = weights(&Window::Hann.weights(4096));
        // sinc(u)/(1 − u²) squared over its sum, 6; whole and half lines are every other one.
        for (m, due) in [
            1.0,
            0.720_506,
            0.25,
            0.028_820,
            0.0,
            0.000_588_2,
            0.0,
            0.000_065_36,
        ]
        .into_iter()
        .enumerate()
        {
            assert!((q[2 * m] - due / 6.0).abs() < 1e-5, "{m} {}", q[2 * m]);
        }
        // Its second moment is twice the sixth that multiplies a second difference.
        let moment: f64 = (1..q.len())
            .map(|m| 2.0 * q[m] * (m as f64 / STEPS as f64).powi(2))
            .sum();
        assert!((moment - 1.0 / 3.0).abs() < 1e-3, "{moment}");
    }
}
