//! Whether the density and the Allan curve of one record tell the same story.

use crate::model::allan_response;
use crate::{DeviationCurve, NoiseModel, Statistic};
use proofmass_signal::Density;
use serde::{Deserialize, Serialize};

/// The Allan variance at one τ, directly and through the density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConsistencyPoint {
    /// Averaging time in s.
    pub tau: f64,
    /// Allan variance of the record.
    pub allan_variance: f64,
    /// ∫ S |H|² df.
    pub from_density: f64,
    /// Standard uncertainty of the ratio of the two, from the degrees of freedom of the curve.
    pub relative_uncertainty: f64,
}

impl ConsistencyPoint {
    /// Ratio of the variance from the density to the direct one.
    pub fn ratio(&self) -> f64 {
        self.from_density / self.allan_variance
    }
}

/// The fitted model beside the curve at one τ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedPoint {
    /// Averaging time in s.
    pub tau: f64,
    /// Allan deviation of the model, U.
    pub deviation: f64,
    /// Whether it lies within the limits of the curve.
    pub inside: bool,
    /// Whether the averaging is long enough for the band that was fitted: τ ≥ 1/f_max.
    pub in_band: bool,
}

/// The model at every τ of an Allan curve; empty for other statistics.
pub(crate) fn fitted(
    model: &NoiseModel,
    curve: &DeviationCurve,
    highest_frequency: f64,
) -> Vec<FittedPoint> {
    if !matches!(
        curve.statistic,
        Statistic::Allan | Statistic::OverlappingAllan
    ) {
        return Vec::new();
    }
    // At half the sample rate the whole curve is in the band.
    let whole = highest_frequency > 0.4999 * curve.sample_rate;
    curve
        .points
        .iter()
        .map(|p| {
            let deviation = model
                .sampled_allan_variance(p.factor, curve.sample_rate)
                .sqrt();
            FittedPoint {
                tau: p.tau,
                deviation,
                inside: p
                    .interval
                    .is_some_and(|(low, high)| low <= deviation && deviation <= high),
                in_band: whole || p.tau * highest_frequency >= 1.0,
            }
        })
        .collect()
}

/// σ²(τ) = 2 ∫ S₁(f) sin⁴(πfτ)/(πfτ)² df for every τ the density resolves, beside the directly computed one.
///
/// S₁ is one-sided (twice the two-sided density, for which the factor is 4); the sampled form of the response is used.
/// The density's bins limit the longest τ: at τ = 1/(8 Δf) the response still spans many bins.
///
/// Empty for a curve of another statistic.
pub fn consistency(density: &Density, curve: &DeviationCurve) -> Vec<ConsistencyPoint> {
    if !matches!(
        curve.statistic,
        Statistic::Allan | Statistic::OverlappingAllan
    ) {
        return Vec::new();
    }
    let rate = curve.sample_rate;
    curve
        .points
        .iter()
        .filter(|p| p.tau * density.bin_width <= 0.125)
        .map(|p| {
            let last = density.frequency.len() - 1;
            let sum: f64 = density
                .frequency
                .iter()
                .zip(&density.density)
                .enumerate()
                .skip(1)
                .map(|(k, (&f, &s))| {
                    // The response is averaged over the bin, at three points of equal weight (Gauss).
                    let half = 0.5 * density.bin_width;
                    let node = half * 0.774_596_669_241_483;
                    let h = (5.0 * allan_response(p.factor, f - node, rate)
                        + 8.0 * allan_response(p.factor, f, rate)
                        + 5.0 * allan_response(p.factor, f + node, rate))
                        / 18.0;
                    // Only half of the last bin lies below the Nyquist frequency.
                    s * h * if k == last { 0.5 } else { 1.0 }
                })
                .sum();
            ConsistencyPoint {
                tau: p.tau,
                allan_variance: p.deviation * p.deviation,
                from_density: sum * density.bin_width,
                relative_uncertainty: p.edf.map_or(1.0, |nu| (2.0 / nu).sqrt()),
            }
        })
        .collect()
}
