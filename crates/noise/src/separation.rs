//! The noise of each of three sensors (or clocks) that see the same: what they share cancels.

use crate::deviation::curve_of;
use crate::steps::Steps;
use crate::{DeviationOptions, NoiseRecord, Statistic, groslambert_covariance};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Variances of three sensors by themselves at one τ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SeparatedPoint {
    /// Averaging factor m.
    pub factor: usize,
    /// Averaging time in s.
    pub tau: f64,
    /// Allan variance of each; below zero by chance where a sensor is much quieter than the others.
    pub variances: [f64; 3],
    /// Their standard uncertainties.
    pub uncertainties: [f64; 3],
}

impl SeparatedPoint {
    /// Allan deviation of a sensor; `None` where its variance came out below zero.
    pub fn deviation(&self, sensor: usize) -> Option<f64> {
        let v = self.variances.get(sensor)?;
        (*v > 0.0).then(|| v.sqrt())
    }
}

/// Separates the Allan variances of three sensors recorded side by side, or of three clocks.
///
/// σ₁² is the Groslambert covariance of the differences 1 − 2 and 1 − 3. Formed from the same samples it is the three-cornered hat,
/// ½(σ₁₂² + σ₁₃² − σ₂₃²), term by term. What all three share (motion, temperature) is in none of the differences. Of clocks only differences
/// exist: with y₁ − y₃, y₂ − y₃ and zeros, σ₃² is that of the third.
///
/// The standard uncertainty is √((σ₁₂² σ₁₃² + σ₁⁴)/ν), ν the degrees of freedom of σ₁₂² at that τ.
///
/// **Units** rates in U at `sample_rate` in Hz; variances in U². **Errors** as [`deviation`](crate::deviation); [`Error::Length`] for records of different
/// length. **Accuracy** variances within four of their uncertainties (`law_three_sensors_are_separated`).
/// **Source** `[Groslambert1981]`, `[SP1065] 10.13`.
pub fn separated_deviations(
    rates: [&[f64]; 3],
    sample_rate: f64,
    options: &DeviationOptions,
) -> Result<Vec<SeparatedPoint>, Error> {
    separated(rates, sample_rate, options, &Steps::unwatched())
}

/// [`separated_deviations`] that may be stopped.
pub(crate) fn separated(
    rates: [&[f64]; 3],
    sample_rate: f64,
    options: &DeviationOptions,
    steps: &Steps<'_>,
) -> Result<Vec<SeparatedPoint>, Error> {
    for rate in rates {
        if rate.len() != rates[0].len() {
            return Err(Error::Length {
                name: "rate",
                expected: rates[0].len(),
                got: rate.len(),
            });
        }
    }
    let difference = |a: usize, b: usize| -> Vec<f64> {
        rates[a].iter().zip(rates[b]).map(|(x, y)| x - y).collect()
    };
    let pairs = [difference(0, 1), difference(0, 2), difference(1, 2)];
    let curve = curve_of(
        &[NoiseRecord::Rate(&pairs[0])],
        sample_rate,
        Statistic::OverlappingAllan,
        options,
        None,
        steps,
    )?;
    let phases = pairs.map(|d| {
        let mut x = vec![0.0];
        let mut sum = 0.0;
        x.extend(d.iter().map(|y| {
            sum += y / sample_rate;
            sum
        }));
        x
    });
    curve
        .points
        .iter()
        .map(|p| {
            steps.check()?;
            let shared = |a: usize, b: usize| {
                groslambert_covariance(&phases[a], &phases[b], p.factor, sample_rate)
            };
            let (v12, v13, v23) = (shared(0, 0)?, shared(1, 1)?, shared(2, 2)?);
            // 2 − 1 against 2 − 3, and 3 − 1 against 3 − 2: one sign is turned, then two.
            let variances = [shared(0, 1)?, -shared(0, 2)?, shared(1, 2)?];
            let nu = p.edf.unwrap_or(1.0).max(1.0);
            let u = |a: f64, b: f64, c: f64| ((a * b + c * c) / nu).sqrt();
            Ok(SeparatedPoint {
                factor: p.factor,
                tau: p.tau,
                variances,
                uncertainties: [
                    u(v12, v13, variances[0]),
                    u(v12, v23, variances[1]),
                    u(v13, v23, variances[2]),
                ],
            })
        })
        .collect()
}
