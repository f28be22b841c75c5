//! What the accelerometer's own record says about its noise, and how many readings are really new.

use crate::whiteness::spectrum_correlation;
use proofmass_signal::{Detrend, Welch};

/// Longest segment of the spectrum, samples.
const SEGMENT: usize = 256;
/// Lines of a block of which the mean is taken.
const BLOCK: usize = 8;

/// Variance of an acceleration sample by the quietest part of its spectrum: white noise has it everywhere.
///
/// Welch's estimate with Hann windows of min(256, n/8) samples, half overlapping, a line removed from each; the
/// lowest mean of eight neighbouring lines above a tenth of the lines, times half the rate. White noise: 0.92 to 0.99 of
/// the true standard deviation. Zero for a channel that never changes; `None` below 128 samples.
///
/// **Source** `[Welch1967]`.
pub(crate) fn noise_floor(acceleration: &[f64]) -> Option<f64> {
    let n = acceleration.len();
    let m = SEGMENT.min(n / 8);
    if m < 2 * BLOCK {
        return None;
    }
    let welch = Welch {
        detrend: Detrend::Linear,
        ..Welch::new(m)
    };
    // One-sided density times half the rate.
    let density = welch.density(acceleration, 2.0).ok()?;
    let lines = density.density;
    let low = (0.1 * lines.len() as f64).ceil() as usize;
    // The last line is half the rate's, or next to it: its degrees of freedom are fewer.
    let high = lines.len() - 1;
    let lowest = lines[low.min(high)..high]
        .rchunks_exact(BLOCK)
        .map(|b| b.iter().sum::<f64>() / BLOCK as f64)
        .fold(f64::INFINITY, f64::min);
    lowest.is_finite().then_some(lowest)
}

/// Biased variance of a record.
pub(crate) fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n
}

/// Number of readings whose rounding is new.
///
/// Where whole samples make a period of the motion, rounding repeats with it and poses as gain and latency. The first
/// lag beyond twenty at which the whitened residuals are alike again is the period; every repetition counts for as
/// much as it repeats.
pub(crate) fn effective_readings(whitened: &[f64]) -> f64 {
    let n = whitened.len();
    if n < 100 {
        return n as f64;
    }
    let Some(rho) = spectrum_correlation(whitened) else {
        return n as f64;
    };
    const FIRST: usize = 20;
    let half = n / 2;
    let highest = rho[FIRST..half].iter().copied().fold(0.0f64, f64::max);
    let threshold = (6.0 / (half as f64).sqrt()).max(0.7 * highest);
    let Some(mut period) = (FIRST..half).find(|&l| rho[l] > threshold) else {
        return n as f64;
    };
    while period + 1 < half && rho[period + 1] > rho[period] {
        period += 1;
    }
    // A shorter period of which it is a multiple.
    if let Some(part) = (2..=5)
        .rev()
        .map(|m| (period as f64 / f64::from(m)).round() as usize)
        .find(|&l| l > 2 && rho[l] > threshold)
    {
        period = part;
    }
    let mut repeated = 0.0;
    let mut lag = period;
    while lag < n {
        repeated += (1.0 - lag as f64 / n as f64) * rho[lag].max(0.0);
        lag += period;
    }
    n as f64 / (1.0 + 2.0 * repeated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn normal(n: usize, seed: u64) -> Vec<f64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    /// By an independent programme, printed to eight digits.
    #[test]
    fn crosscheck_floor_of_a_short_record() {
        let a: Vec<f64> = (0..200)
            .map(|i| {
                -0.9 * (0.03 * f64::from(i)).sin()
                    + 0.05
                    + 0.02 * (f64::from((7919 * i) % 101) - 50.0) / 50.0
            })
            .collect();
        let q = noise_floor(&a).unwrap();
        assert!((q / 2.001_103_7e-4 - 1.0).abs() < 1e-7, "{q:e}");
        assert!((variance(&a) / 0.423_099_09 - 1.0).abs() < 1e-7);
    }

    #[test]
    fn law_motion_does_not_raise_the_floor() {
        for seed in 0..5 {
            let a: Vec<f64> = normal(15_000, seed)
                .iter()
                .enumerate()
                .map(|(k, e)| 0.02 * e + 30.0 * (0.03 * k as f64).sin())
                .collect();
            let ratio = noise_floor(&a).unwrap().sqrt() / 0.02;
            assert!((0.88..1.02).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn law_repeated_rounding_counts_once() {
        let once = normal(200, 3);
        let n = effective_readings(&(0..5000).map(|k| once[k % 200]).collect::<Vec<_>>());
        assert!((n / 200.0 - 1.0).abs() < 0.1, "{n}");
        let n = effective_readings(&normal(5000, 4));
        assert_eq!(n, 5000.0);
    }
}
