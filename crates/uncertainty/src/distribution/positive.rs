//! Distributions above a limit, between two limits with a slope, and of counts.

use super::Distribution;
use crate::quantile::{chi_squared_quantile, f_quantile};
use crate::student::standard_normal_quantile;
use proofmass_core::Error;
use statrs::function::gamma::gamma_ur;

/// The least double: no lower limit.
pub(super) fn lowest() -> f64 {
    f64::MIN
}

/// The largest double: no upper limit.
pub(super) fn highest() -> f64 {
    f64::MAX
}

/// One.
pub(super) fn one() -> f64 {
    1.0
}

/// Mean and standard deviation; zeros for kinds that are not of this family.
pub(super) fn moments(distribution: &Distribution) -> (f64, f64) {
    match distribution {
        Distribution::Exponential { lower, mean } => (*mean, mean - lower),
        Distribution::Gamma {
            lower,
            shape,
            scale,
        } => (lower + shape * scale, shape.sqrt() * scale),
        Distribution::Lognormal {
            lower,
            median,
            sigma,
        } => {
            let mean = median * (0.5 * sigma * sigma).exp();
            (lower + mean, mean * (sigma * sigma).exp_m1().sqrt())
        }
        Distribution::Beta {
            lower,
            upper,
            alpha,
            beta,
        } => {
            let (width, sum) = (upper - lower, alpha + beta);
            (
                lower + width * alpha / sum,
                width / sum * (alpha * beta / (sum + 1.0)).sqrt(),
            )
        }
        Distribution::Poisson { lower, scale, mean } => (lower + scale * mean, scale * mean.sqrt()),
        Distribution::Discrete {
            values,
            weights: given,
        } => {
            let weights = weights(values, given);
            let mean: f64 = values.iter().zip(&weights).map(|(v, w)| v * w).sum();
            let squares = values.iter().zip(&weights);
            let variance: f64 = squares.map(|(v, w)| w * (v - mean).powi(2)).sum();
            (mean, variance.sqrt())
        }
        _ => (0.0, 0.0),
    }
}

/// The value that is exceeded with probability 1 − `p`.
pub(super) fn quantile(distribution: &Distribution, p: f64) -> f64 {
    match distribution {
        Distribution::Exponential { lower, mean } => lower - (mean - lower) * (-p).ln_1p(),
        Distribution::Gamma {
            lower,
            shape,
            scale,
        } => lower + 0.5 * scale * chi_squared_quantile(p, 2.0 * shape),
        Distribution::Lognormal {
            lower,
            median,
            sigma,
        } => lower + median * (sigma * standard_normal_quantile(p)).exp(),
        Distribution::Beta {
            lower,
            upper,
            alpha,
            beta,
        } => {
            let ratio = f_quantile(p, 2.0 * alpha, 2.0 * beta) * alpha / beta;
            let share = if ratio.is_finite() {
                ratio / (1.0 + ratio)
            } else {
                1.0
            };
            lower + (upper - lower) * share
        }
        Distribution::Poisson { lower, scale, mean } => lower + scale * events(*mean, p),
        Distribution::Discrete {
            values,
            weights: given,
        } => {
            let weights = weights(values, given);
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            let mut below = 0.0;
            for &i in &order {
                below += weights[i];
                if p <= below {
                    return values[i];
                }
            }
            order.last().map_or(0.0, |&i| values[i])
        }
        _ => 0.0,
    }
}

/// The least number of events n with P(N ≤ n) ≥ p.
fn events(mean: f64, p: f64) -> f64 {
    if mean == 0.0 {
        return 0.0;
    }
    let up_to = |n: f64| {
        if n < 0.0 {
            0.0
        } else {
            gamma_ur(n + 1.0, mean)
        }
    };
    let mut n = (mean + mean.sqrt() * standard_normal_quantile(p))
        .round()
        .clamp(0.0, 1e18);
    while n > 0.0 && up_to(n - 1.0) >= p {
        n -= 1.0;
    }
    while up_to(n) < p && n < 2e18 {
        n += 1.0;
    }
    n
}

/// Weights that sum to one.
pub(crate) fn weights(values: &[f64], given: &[f64]) -> Vec<f64> {
    if given.is_empty() {
        return vec![1.0 / values.len().max(1) as f64; values.len()];
    }
    let total: f64 = given.iter().sum();
    given.iter().map(|w| w / total).collect()
}

/// Values with weights of which one at least is above zero.
pub(super) fn check_discrete(values: &[f64], weights: &[f64]) -> Result<(), Error> {
    if values.is_empty() {
        return Err(Error::TooFew {
            name: "values",
            needed: 1,
            got: 0,
        });
    }
    if !weights.is_empty() && weights.len() != values.len() {
        return Err(Error::Length {
            name: "weights",
            expected: values.len(),
            got: weights.len(),
        });
    }
    for (name, numbers) in [("values", values), ("weights", weights)] {
        proofmass_core::check::finite(name, numbers)?;
    }
    let total: f64 = weights.iter().sum();
    let least = weights.iter().copied().fold(0.0, f64::min);
    let impossible = !(total > 0.0 && total.is_finite());
    if least < 0.0 || (impossible && !weights.is_empty()) {
        let (name, value, min) = if least < 0.0 {
            ("weights", least, 0.0)
        } else {
            ("sum of the weights", total, f64::MIN_POSITIVE)
        };
        return Err(Error::OutOfRange {
            name,
            value,
            min,
            max: f64::MAX,
        });
    }
    Ok(())
}
