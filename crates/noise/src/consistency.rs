//! Whether the density and the Allan curve of one record tell the same story.

use crate::model::allan_response;
use crate::{BandUse, DeviationCurve, FrontEnd, NoiseModel, Statistic};
use proofmass_signal::Density;
use serde::{Deserialize, Serialize};

/// The Allan variance at one τ, directly and through the density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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
#[non_exhaustive]
pub struct FittedPoint {
    /// Averaging time in s.
    pub tau: f64,
    /// Allan deviation of the model as it comes through the front end that was found, U.
    pub deviation: f64,
    /// Whether it lies within the limits of the curve.
    pub inside: bool,
    /// Whether the averaging is long enough for the band that model and front end describe: τ ≥ 1/f.
    pub in_band: bool,
}

/// The fitted model at every τ of an Allan curve; empty for other statistics.
pub(crate) fn fitted(
    model: &NoiseModel,
    band: &BandUse,
    curve: &DeviationCurve,
) -> Vec<FittedPoint> {
    if !matches!(
        curve.statistic,
        Statistic::Allan | Statistic::OverlappingAllan
    ) {
        return Vec::new();
    }
    let rate = curve.sample_rate;
    let highest = band.described_to.max(band.highest_frequency);
    // At half the sample rate the whole curve is in the band.
    let whole = highest > 0.4999 * rate;
    curve
        .points
        .iter()
        .map(|p| {
            let lost = band
                .front_end
                .map_or(0.0, |shape| lost(model, shape, highest, p.factor, rate));
            let variance = model.sampled_allan_variance(p.factor, rate) - lost;
            let deviation = variance.max(0.0).sqrt();
            FittedPoint {
                tau: p.tau,
                deviation,
                inside: p
                    .interval
                    .is_some_and(|(low, high)| low <= deviation && deviation <= high),
                in_band: whole || p.tau * highest >= 1.0,
            }
        })
        .collect()
}

/// Lobes of the response that are integrated one by one; beyond, sin⁴ is its mean of 3/8.
const LOBES: usize = 64;

/// Points in a lobe.
const POINTS: usize = 48;

/// Allan variance at factor m that a front end takes off: ∫ S (1 − |H|²) |A|² df, |A|² as [`allan_response`].
///
/// Beyond the frequency up to which it is `known` it takes off what it does there. Quantisation arises behind it; the sizes of ramp and sinusoids are those of the record.
fn lost(model: &NoiseModel, shape: FrontEnd, known: f64, m: usize, rate: f64) -> f64 {
    let front = NoiseModel {
        quantisation: 0.0,
        ..model.clone()
    };
    let taken = |f: f64| front.density(f, rate) * (1.0 - shape.response(f.min(known), rate));
    // A lobe of sin⁴(πmf/rate) is rate/m wide; half the rate holds m/2 of them.
    let nyquist = 0.5 * rate;
    let end = f64::min(nyquist, LOBES as f64 * rate / m as f64);
    let count = (POINTS as f64 * (end * m as f64 / rate)).ceil().max(64.0);
    let step = end / count;
    let near: f64 = (0..count as usize)
        .map(|k| {
            let f = (k as f64 + 0.5) * step;
            taken(f) * allan_response(m, f, rate) * step
        })
        .sum();
    if end >= nyquist {
        return near;
    }
    // The rest in equal steps of the logarithm.
    let steps = 512;
    let width = (nyquist / end).ln() / f64::from(steps);
    let rest: f64 = (0..steps)
        .map(|k| {
            let f = end * ((f64::from(k) + 0.5) * width).exp();
            let x = m as f64 * (std::f64::consts::PI * f / rate).sin();
            taken(f) * 0.75 / (x * x) * f * width
        })
        .sum();
    near + rest
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LowPass;

    /// White noise as the mean of two neighbours: the differences of means of m hold 2m − 2 samples with the weight of one and two
    /// with that of a half.
    #[test]
    fn known_allan_variance_of_averaged_white_noise() {
        let model = NoiseModel {
            white: 1.0,
            ..NoiseModel::default()
        };
        let shape = FrontEnd::Overlap { loss: 1.0 };
        for m in [1_usize, 2, 5, 100, 1000, 20_000] {
            let mf = m as f64;
            let exact = (2.0 * mf - 1.5) / (2.0 * mf * mf);
            let variance = model.sampled_allan_variance(m, 1.0) - lost(&model, shape, 0.5, m, 1.0);
            assert!(
                (variance / exact - 1.0).abs() < 2e-4,
                "{m}: {variance} {exact}"
            );
        }
    }

    /// What a filter of first order leaves of white noise, against the sum over its covariance.
    #[test]
    fn crosscheck_filtered_white_noise() {
        let model = NoiseModel {
            white: 1.0,
            ..NoiseModel::default()
        };
        let corner = 0.05;
        let shape = FrontEnd::butterworth(LowPass { order: 1, corner }, 1.0);
        // (1 + z)/(1 − φz) with w = tan(πf_c): variance of a sum of n samples from the covariance φ^k.
        let w = (std::f64::consts::PI * corner).tan();
        let (gain, phi) = (w / (1.0 + w), (1.0 - w) / (1.0 + w));
        let covariance = |k: usize| {
            let plain = |k: i64| phi.powi(k.unsigned_abs() as i32) / (1.0 - phi * phi);
            let k = k as i64;
            gain * gain * (2.0 * plain(k) + plain(k - 1) + plain(k + 1))
        };
        for m in [1_usize, 3, 30, 300] {
            let weight = |i: usize| if i < m { -1.0 } else { 1.0 };
            let mut exact = 0.0;
            for i in 0..2 * m {
                for j in 0..2 * m {
                    exact += weight(i) * weight(j) * covariance(i.abs_diff(j));
                }
            }
            exact /= 2.0 * (m as f64).powi(2);
            let variance = model.sampled_allan_variance(m, 1.0) - lost(&model, shape, 0.5, m, 1.0);
            assert!(
                (variance / exact - 1.0).abs() < 2e-3,
                "{m}: {variance} {exact}"
            );
        }
    }
}
