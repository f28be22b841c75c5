//! The smooth part of a record, its straight line and its bend, and what noise does to them.

use crate::NoiseModel;

/// Standard uncertainty of the least-squares slope under a noise model, U/s.
///
/// √∫ S |W|² df with the weights W of the slope; white noise gives 12N²/T³, a random walk 6K²/(5T).
pub(crate) fn slope_uncertainty(model: &NoiseModel, n: usize, sample_rate: f64) -> f64 {
    let t = n as f64 / sample_rate;
    // |W(f)|² of the continuous least-squares slope: 36/(π f T²)² · (sinc x − cos x)² with x = π f T, sinc x = sin x/x.
    let variance = spectral_mean(model, n, sample_rate, |x| {
        let shape = if x < 1e-2 {
            x * x / 3.0
        } else {
            x.sin() / x - x.cos()
        };
        6.0 / (x * t) * shape
    });
    variance.sqrt()
}

/// ∫ S(f) W(πfT)² df over the frequencies of a record of n samples.
fn spectral_mean(
    model: &NoiseModel,
    n: usize,
    sample_rate: f64,
    weight: impl Fn(f64) -> f64,
) -> f64 {
    let t = n as f64 / sample_rate;
    let steps = 400;
    let (low, high) = (1e-3_f64.ln(), (0.5 * n as f64).max(2.0).ln());
    let width = (high - low) / steps as f64;
    (0..steps)
        .map(|i| {
            // Jittered by the golden ratio, so that the oscillation averages out.
            let jitter = (i as f64 * 0.618_033_988_749_895).fract();
            let cycles = (low + (i as f64 + jitter) * width).exp();
            let f = cycles / t;
            let w = weight(std::f64::consts::PI * cycles);
            model.density(f, sample_rate) * w * w * f * width
        })
        .sum()
}

/// A bend of the record that its noise does not explain.
pub(crate) struct Bend {
    /// Degree of the Legendre polynomial, 2 or 3.
    pub(crate) degree: usize,
    /// Root mean square of that polynomial over the record, U.
    pub(crate) size: f64,
    /// Its standard uncertainty under the noise, U.
    pub(crate) uncertainty: f64,
    /// Standard uncertainties that chance exceeds at the stated rate.
    pub(crate) threshold: f64,
}

/// Seeks drift that bends, as temperature makes it, beside the noise of a model.
///
/// c_d = ⟨y √(2d+1) P_d⟩ over the record has the variance ∫ S (2d+1) j_d(πfT)² df, j_d the spherical Bessel
/// function. The larger of d = 2 and 3 is judged; with random walk and flicker at their upper limits the stated rate is
/// kept even where a walk is too weak to be identified.
pub(crate) fn bend(
    rate: &[f64],
    sample_rate: f64,
    upper: &NoiseModel,
    false_alarm_rate: f64,
) -> Option<Bend> {
    let n = rate.len() as f64;
    let t = n / sample_rate;
    let threshold = crate::whittle::normal_quantile(1.0 - 0.25 * false_alarm_rate);
    (2..=3)
        .filter_map(|degree| {
            let norm = (2.0 * degree as f64 + 1.0).sqrt();
            let mean: f64 = rate
                .iter()
                .enumerate()
                .map(|(k, y)| {
                    let x = (2.0 * k as f64 + 1.0) / n - 1.0;
                    y * match degree {
                        2 => 1.5 * x * x - 0.5,
                        _ => (2.5 * x * x - 1.5) * x,
                    }
                })
                .sum::<f64>()
                / n;
            let variance = spectral_mean(upper, rate.len(), sample_rate, |x| {
                norm * spherical_bessel(degree, x)
            });
            let (size, uncertainty) = ((norm * mean).abs(), variance.sqrt());
            (size > threshold * uncertainty && t > 0.0).then_some(Bend {
                degree,
                size,
                uncertainty,
                threshold,
            })
        })
        .max_by(|a, b| (a.size / a.uncertainty).total_cmp(&(b.size / b.uncertainty)))
}

/// j_2 or j_3. **Source** `[AS] 10.1.11`.
fn spherical_bessel(degree: usize, x: f64) -> f64 {
    let (sin, cos) = x.sin_cos();
    match degree {
        // The first term of the series, where the closed form cancels.
        2 if x < 0.03 => x * x / 15.0,
        2 => (3.0 / (x * x) - 1.0) * sin / x - 3.0 * cos / (x * x),
        _ if x < 0.1 => x.powi(3) / 105.0,
        _ => {
            let x2 = x * x;
            (15.0 / x2 - 6.0) * sin / x2 - (15.0 / x2 - 1.0) * cos / x
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Least squares on white noise has the slope variance 12N²/T³, on a random walk 6K²/(5T); the jittered grid is
    /// good to some percent of a standard uncertainty.
    #[test]
    fn law_slope_variances() {
        let (n, rate) = (10_000, 10.0);
        let t = n as f64 / rate;
        let white = NoiseModel {
            white: 2.0,
            ..Default::default()
        };
        let walk = NoiseModel {
            random_walk: 3.0,
            ..Default::default()
        };
        let expected_white = 2.0 * (12.0 / t.powi(3)).sqrt();
        let expected_walk = 3.0 * (1.2 / t).sqrt();
        let relative = |model: &NoiseModel, expected: f64| {
            (slope_uncertainty(model, n, rate) / expected - 1.0).abs()
        };
        assert!(relative(&white, expected_white) < 0.03);
        assert!(relative(&walk, expected_walk) < 0.03);
    }
}
