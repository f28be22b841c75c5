//! Noise of standstill means when samples are correlated and quantised.

use crate::{Pose, Samples, Segment, Triple};
use proofmass_core::Error;
use proofmass_core::numeric::median;
use proofmass_uncertainty::DegreesOfFreedom;

/// The noise common to all standstills of one recording.
///
/// The covariance of a mean of N correlated samples is (1/N) Σ_k (1 − |k|/N) Γ_k. The autocovariances Γ_k are
/// pooled over the standstills and tapered with Parzen's lag window, whose positive spectral window keeps the
/// result positive semi-definite; its width follows Andrews' rule for the measured lag-one correlation.
///
/// Standstills with more than twice the median variance (a hand that trembles) are left out of the pool; their
/// own means get the pooled covariance times their variance ratio.
///
/// **Assumes** that the other standstills have the same noise spectrum and that correlation dies out within a
/// standstill. Slower wander (flicker, temperature) is not in the samples of one standstill: it shows as excess
/// of the fit residuals.
///
/// **Source** `[Andrews1991]` eq. 6.2 and 6.4, `[Priestley1981]` 6.2.3.
#[doc(alias("standard error of the mean", "long-run variance"))]
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeanNoise {
    /// Γ_k with the lag window applied, k = 0, 1, …
    autocovariance: Vec<[Triple; 3]>,
    dof: DegreesOfFreedom,
    quantum: [Option<f64>; 3],
    /// Median variance of the samples of a standstill per axis.
    typical: Triple,
}

/// Variance in multiples of the median beyond which a standstill does not belong to the pool.
const RESTLESS: f64 = 2.0;

impl MeanNoise {
    /// Estimates the noise from the samples inside the segments.
    ///
    /// # Errors
    /// [`Error::TooFew`] when no segment has two samples; [`Error::OutOfRange`] for a segment beyond the end.
    pub fn estimate(samples: &Samples<'_>, segments: &[Segment]) -> Result<Self, Error> {
        if let Some(segment) = segments
            .iter()
            .find(|s| s.end > samples.len() || s.start >= s.end)
        {
            return Err(Error::OutOfRange {
                name: "end of a segment",
                value: segment.end as f64,
                min: segment.start as f64 + 1.0,
                max: samples.len() as f64,
            });
        }
        let mut centred: Vec<[Vec<f64>; 3]> = segments
            .iter()
            .map(|s| {
                let mean = samples.mean(s.start, s.end);
                let columns = samples.columns();
                [0, 1, 2].map(|axis| {
                    columns[axis][s.start..s.end]
                        .iter()
                        .map(|v| v - mean[axis])
                        .collect()
                })
            })
            .collect();
        let variances: Vec<Triple> = centred
            .iter()
            .map(|c| [0, 1, 2].map(|axis| variance(&c[axis])))
            .collect();
        let typical = [0, 1, 2].map(|axis| {
            let mut column: Vec<f64> = variances.iter().map(|v| v[axis]).collect();
            median(&mut column).unwrap_or(0.0)
        });
        let mut variance = variances.iter();
        centred.retain(|_| {
            variance
                .next()
                .is_some_and(|v| excess_ratio(v, &typical) <= RESTLESS)
        });
        let total: usize = centred.iter().map(|c| c[0].len()).sum();
        let count = centred.len();
        if total < count + 2 {
            return Err(Error::TooFew {
                name: "samples in the standstills",
                needed: count + 2,
                got: total,
            });
        }
        let width = parzen_width(&centred, total);
        let lags = (width.floor() as usize).min(total / count.max(1) / 2);
        let mut autocovariance = Vec::with_capacity(lags + 1);
        let mut weight_sum = 0.0;
        for lag in 0..=lags {
            let weight = parzen(lag as f64 / width.max(1.0));
            weight_sum += if lag == 0 { weight } else { 2.0 * weight };
            let gamma = lagged_products(&centred, lag);
            autocovariance.push(gamma.map(|row| row.map(|v| v * weight / total as f64)));
        }
        // Removing each segment's mean takes out W/N of the long-run variance: N − 1 for white noise.
        let mean_length = total as f64 / count as f64;
        let correction = 1.0 / (1.0 - (weight_sum / mean_length).min(0.5));
        for gamma in &mut autocovariance {
            *gamma = gamma.map(|row| row.map(|v| v * correction));
        }
        // ∫ Parzen² = 0.539 on each unit of width; white noise (width < 1) keeps N − count.
        let dof = (total - count) as f64 / (0.539_285 * width).max(1.0);
        Ok(Self {
            autocovariance,
            dof: DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE),
            quantum: samples.columns().map(quantum),
            typical,
        })
    }

    /// Degrees of freedom of the estimated noise.
    pub fn dof(&self) -> DegreesOfFreedom {
        self.dof
    }

    /// Standard deviation of single samples per axis.
    pub fn deviation(&self) -> Triple {
        [0, 1, 2].map(|axis| self.autocovariance[0][axis][axis].max(0.0).sqrt())
    }

    /// How many times the variance of a long mean exceeds that of uncorrelated samples, per axis.
    pub fn variance_inflation(&self) -> Triple {
        [0, 1, 2].map(|axis| {
            let white = self.autocovariance[0][axis][axis];
            let all: f64 = self.autocovariance[1..]
                .iter()
                .map(|g| 2.0 * g[axis][axis])
                .sum();
            if white > 0.0 { 1.0 + all / white } else { 1.0 }
        })
    }

    /// Covariance of the mean of `n` samples, the resolution of the output included.
    ///
    /// Samples rounded to a step q with noise σ keep, after averaging, an error of variance
    /// Σ_k (q/(√2 π k))² exp(−(2π k σ/q)²): q²/12 without noise, nothing once σ exceeds the step.
    /// **Source** `[WidrowKollar2008]` ch. 4 (characteristic function of the quantiser).
    pub fn of_mean(&self, n: usize) -> [Triple; 3] {
        let mut covariance = [[0.0; 3]; 3];
        for (lag, gamma) in self.autocovariance.iter().enumerate().take(n) {
            let share = (1.0 - lag as f64 / n as f64) / n as f64;
            for i in 0..3 {
                for j in 0..3 {
                    covariance[i][j] += share
                        * if lag == 0 {
                            gamma[i][j]
                        } else {
                            gamma[i][j] + gamma[j][i]
                        };
                }
            }
        }
        let deviation = self.deviation();
        for axis in 0..3 {
            if let Some(q) = self.quantum[axis] {
                covariance[axis][axis] += quantisation_variance(q, deviation[axis]);
            }
        }
        covariance
    }

    /// Reduces segments to poses.
    pub fn poses(&self, samples: &Samples<'_>, segments: &[Segment]) -> Vec<Pose> {
        segments
            .iter()
            .map(|segment| {
                let mean = samples.mean(segment.start, segment.end);
                let columns = samples.columns();
                let deviation = [0, 1, 2].map(|axis| {
                    let sum: f64 = columns[axis][segment.start..segment.end]
                        .iter()
                        .map(|v| (v - mean[axis]).powi(2))
                        .sum();
                    (sum / (segment.len().max(2) - 1) as f64).sqrt()
                });
                let ratio = excess_ratio(&deviation.map(|d| d * d), &self.typical);
                let factor = if ratio > RESTLESS { ratio } else { 1.0 };
                Pose {
                    mean,
                    covariance: Some(
                        self.of_mean(segment.len())
                            .map(|row| row.map(|v| v * factor)),
                    ),
                    deviation: Some(deviation),
                    time: samples
                        .time()
                        .map(|t| 0.5 * (t[segment.start] + t[segment.end - 1])),
                    temperature: samples.mean_temperature(segment.start, segment.end),
                    segment: segment.clone(),
                }
            })
            .collect()
    }
}

/// Largest ratio of the variances of one standstill to the typical ones.
fn excess_ratio(variance: &Triple, typical: &Triple) -> f64 {
    (0..3)
        .filter(|axis| typical[*axis] > 0.0)
        .map(|axis| variance[axis] / typical[axis])
        .fold(0.0, f64::max)
}

/// Variance of centred samples.
fn variance(centred: &[f64]) -> f64 {
    centred.iter().map(|v| v * v).sum::<f64>() / (centred.len().max(2) - 1) as f64
}

/// Sum over all segments of x_i(t + lag) x_j(t).
fn lagged_products(centred: &[[Vec<f64>; 3]], lag: usize) -> [Triple; 3] {
    let mut sum = [[0.0; 3]; 3];
    for segment in centred {
        let n = segment[0].len();
        if lag >= n {
            continue;
        }
        for i in 0..3 {
            for j in 0..3 {
                sum[i][j] += segment[i][lag..]
                    .iter()
                    .zip(&segment[j][..n - lag])
                    .map(|(a, b)| a * b)
                    .sum::<f64>();
            }
        }
    }
    sum
}

/// Parzen's lag window.
fn parzen(x: f64) -> f64 {
    if x <= 0.5 {
        1.0 - 6.0 * x * x + 6.0 * x * x * x
    } else if x <= 1.0 {
        2.0 * (1.0 - x).powi(3)
    } else {
        0.0
    }
}

/// Width of the lag window: 2.6614 (α(2) N)^{1/5} with α(2) for first-order autoregressions, axes weighted alike.
fn parzen_width(centred: &[[Vec<f64>; 3]], total: usize) -> f64 {
    let gamma0 = lagged_products(centred, 0);
    let gamma1 = lagged_products(centred, 1);
    let mut numerator = 0.0;
    let mut denominator = 0.0;
    for axis in 0..3 {
        if gamma0[axis][axis] > 0.0 {
            let rho = (gamma1[axis][axis] / gamma0[axis][axis]).clamp(-0.97, 0.97);
            // White noise leaves |ρ| up to 2/√N: below that, no correlation is claimed.
            let rho = if rho.abs() < 2.0 / (total as f64).sqrt() {
                0.0
            } else {
                rho
            };
            numerator += 4.0 * rho * rho / (1.0 - rho).powi(8);
            denominator += 1.0 / (1.0 - rho).powi(4);
        }
    }
    if denominator > 0.0 {
        2.6614 * (numerator / denominator * total as f64).powf(0.2)
    } else {
        0.0
    }
}

/// Step of a quantised column: the smallest change between neighbours, when every change is a multiple of it.
fn quantum(column: &[f64]) -> Option<f64> {
    let changes = || {
        column
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .filter(|change| *change > 0.0)
    };
    let smallest = changes().fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return None;
    }
    // Only small multiples can tell: decimal text leaves some 0.2 % of rounding on a step, so the twentieth
    // multiple may be off by 0.04 of a step, while changes of a smooth column fall anywhere.
    let near = || {
        changes()
            .map(|change| change / smallest)
            .filter(|steps| *steps < 20.5)
    };
    let off = near()
        .filter(|steps| (steps - steps.round()).abs() > 0.1)
        .count();
    let multiples = near().filter(|steps| *steps > 1.5).count();
    (multiples > 10 && off == 0).then_some(smallest)
}

/// Variance that rounding to a step leaves in a mean of samples with this noise.
fn quantisation_variance(step: f64, deviation: f64) -> f64 {
    use std::f64::consts::{PI, SQRT_2};
    (1..=40)
        .map(|k| {
            let k = f64::from(k);
            let amplitude = step / (SQRT_2 * PI * k);
            let damping = (-(2.0 * PI * k * deviation / step).powi(2)).exp();
            amplitude * amplitude * damping
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn segments(count: usize, length: usize) -> Vec<Segment> {
        (0..count)
            .map(|i| Segment {
                start: i * length,
                end: (i + 1) * length,
                attitude: None,
                force_uncertainty: None,
                label: None,
            })
            .collect()
    }

    fn autoregression(rho: f64, n: usize, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let mut x = 0.0;
        (0..n)
            .map(|_| {
                let w: f64 = StandardNormal.sample(rng);
                x = rho * x + (1.0 - rho * rho).sqrt() * w;
                x
            })
            .collect()
    }

    #[test]
    fn law_variance_of_the_mean_of_an_autoregression() {
        // Long-run variance of AR(1) with unit variance: (1 + ρ)/(1 − ρ). 40 × 400 samples leave a relative
        // standard deviation of √(2/dof); four of them, and the smoothing bias of the lag window (< 4 %).
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        for rho in [0.0, 0.3, 0.7] {
            let (count, length) = (40, 400);
            let data: [Vec<f64>; 3] =
                std::array::from_fn(|_| autoregression(rho, count * length, &mut rng));
            let samples = Samples::new(&data[0], &data[1], &data[2]).unwrap();
            let noise = MeanNoise::estimate(&samples, &segments(count, length)).unwrap();
            let expected = (1.0 + rho) / (1.0 - rho) / length as f64;
            let got = noise.of_mean(length)[0][0];
            let bound = 4.0 * (2.0 / noise.dof().get()).sqrt() + 0.04;
            assert!(
                (got / expected - 1.0).abs() < bound,
                "ρ = {rho}: {got} against {expected}"
            );
        }
    }

    #[test]
    fn known_quantisation_without_noise_is_a_twelfth() {
        assert!((quantisation_variance(2.0, 0.0) * 12.0 / 4.0 - 1.0).abs() < 0.02);
        assert!(quantisation_variance(1.0, 1.0) < 1e-15);
    }

    #[test]
    fn known_step_is_found_and_none_is_invented() {
        let counts: Vec<f64> = (0..500)
            .map(|i| f64::from((i * i * 7 + i) % 23) * 0.06)
            .collect();
        assert!((quantum(&counts).unwrap() - 0.06).abs() < 1e-12);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let smooth = autoregression(0.0, 500, &mut rng);
        assert_eq!(quantum(&smooth), None);
        assert_eq!(quantum(&[1.0; 50]), None);
    }
}
