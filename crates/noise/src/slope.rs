//! The least-squares slope of a record and what noise does to it.

use crate::NoiseModel;

/// Standard uncertainty of the least-squares slope under a noise model, U/s.
///
/// √∫ S |W|² df with the weights W of the slope; white noise gives 12N²/T³, a random walk 6K²/(5T).
pub(crate) fn slope_uncertainty(model: &NoiseModel, n: usize, sample_rate: f64) -> f64 {
    let t = n as f64 / sample_rate;
    // |W(f)|² of the continuous least-squares slope: 36/(π f T²)² · (sinc x − cos x)² with x = π f T, sinc x = sin x/x.
    let steps = 400;
    let (low, high) = (1e-3_f64.ln(), (0.5 * n as f64).max(2.0).ln());
    let width = (high - low) / steps as f64;
    let sum: f64 = (0..steps)
        .map(|i| {
            // Jittered by the golden ratio, so that the oscillation averages out.
            let jitter = (i as f64 * 0.618_033_988_749_895).fract();
            let cycles = (low + (i as f64 + jitter) * width).exp();
            let f = cycles / t;
            let x = std::f64::consts::PI * cycles;
            let shape = if x < 1e-2 {
                x * x / 3.0
            } else {
                x.sin() / x - x.cos()
            };
            let w = 6.0 / (x * t) * shape;
            model.density(f, sample_rate) * w * w * f * width
        })
        .sum();
    sum.sqrt()
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
