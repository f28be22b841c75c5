//! The correlation of normal scores that gives two distributions the product-moment correlation that is stated.
//!
//! X = F⁻¹(Φ(g)) is expanded in Hermite polynomials of g, X = Σ aₙ hₙ(g); for two with scores of correlation ρ the covariance
//! is Σ aₙ bₙ ρⁿ, which grows with ρ. What the series leaves at ρ = ± 1 is known from X itself.
//!
//! **Source** `[Cario1997]`.

use super::normal_probability;
use crate::input::Doubt;
use crate::{Covariance, Distribution, JointInputs, Refusal};
use proofmass_core::Error;
use std::collections::HashMap;

/// Terms of the series, and points of the integrals over g in ± `END`.
const TERMS: usize = 300;
const POINTS: usize = 4096;
const END: f64 = 8.5;

/// A distribution as a function of its normal score, brought to mean 0 and standard deviation 1.
pub(super) struct Scores {
    values: Vec<f64>,
    coefficients: Vec<f64>,
}

/// The score at a point of the integral, and its weight.
fn point(k: usize) -> (f64, f64) {
    let step = 2.0 * END / POINTS as f64;
    let z = -END + (k as f64 + 0.5) * step;
    (
        z,
        step * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt(),
    )
}

/// The correlation of the normal scores of draws that are to have this correlation themselves; `None` where all are normal.
///
/// What degrees of freedom stretch is correlated before it is stretched.
pub(super) fn of_draws(
    inputs: &JointInputs,
    draws: &[usize],
    correlation: &Covariance,
    drawn: &[(Distribution, Doubt)],
) -> Result<Option<Covariance>, Refusal> {
    let n = draws.len();
    let shapes: Vec<Distribution> = drawn.iter().map(|d| super::unstretched(d).0).collect();
    let is_normal = |d: &Distribution| matches!(d, Distribution::Normal { .. });
    if shapes.iter().all(is_normal) {
        return Ok(None);
    }
    let name = |a: usize| inputs.draws[draws[a]].name.clone();
    // Many inputs have one distribution, and many pairs one coefficient.
    let mut kinds: Vec<(&Distribution, Option<Scores>)> = Vec::new();
    let mut known: HashMap<(usize, usize, u64), f64> = HashMap::new();
    let mut of: Vec<usize> = Vec::with_capacity(n);
    for shape in &shapes {
        let same = kinds.iter().position(|(d, _)| *d == shape);
        of.push(same.unwrap_or(kinds.len()));
        if same.is_none() {
            kinds.push((shape, Scores::of_distribution(shape)));
        }
    }
    let mut elements = vec![0.0; n * n];
    for a in 0..n {
        elements[a * n + a] = 1.0;
        for b in 0..a {
            let r = correlation[(a, b)];
            if r == 0.0 || (is_normal(&shapes[a]) && is_normal(&shapes[b])) {
                (elements[a * n + b], elements[b * n + a]) = (r, r);
                continue;
            }
            let key = (of[a].min(of[b]), of[a].max(of[b]), r.to_bits());
            let rho = match (known.get(&key), &kinds[of[a]].1, &kinds[of[b]].1) {
                (Some(&rho), ..) => rho,
                (None, Some(first), Some(second)) => {
                    let unreachable = |(least, most)| Refusal::Unreachable {
                        first: name(b),
                        second: name(a),
                        coefficient: r,
                        least,
                        most,
                    };
                    first.correlation(second, r).map_err(unreachable)?
                }
                // A constant has no correlation.
                _ => 0.0,
            };
            known.insert(key, rho);
            (elements[a * n + b], elements[b * n + a]) = (rho, rho);
        }
    }
    let joint = Covariance::try_from_rows(n, &elements).map_err(|error| match error {
        Error::NotPositiveDefinite { row, column, .. } => Refusal::Correlation {
            first: name(row),
            second: name(column),
            coefficient: correlation[(row, column)],
        },
        other => Refusal::Core(other),
    })?;
    Ok(Some(joint))
}

impl Scores {
    fn of_distribution(distribution: &Distribution) -> Option<Self> {
        match distribution {
            Distribution::Normal { .. } => Some(Self::normal()),
            Distribution::Samples { values } => {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                let last = sorted.len().checked_sub(1)?;
                Self::of(|p| sorted[((p * sorted.len() as f64) as usize).min(last)])
            }
            other => Self::of(|p| other.quantile(p)),
        }
    }

    /// Of a distribution by its quantile; `None` without a standard deviation.
    fn of(quantile: impl Fn(f64) -> f64) -> Option<Self> {
        let mut values: Vec<f64> = (0..POINTS)
            .map(|k| quantile(normal_probability(point(k).0)))
            .collect();
        let mean =
            |f: &dyn Fn(usize) -> f64| -> f64 { (0..POINTS).map(|k| point(k).1 * f(k)).sum() };
        let middle = mean(&|k| values[k]);
        let sd = mean(&|k| (values[k] - middle).powi(2)).sqrt();
        if !(sd > 0.0 && sd.is_finite()) {
            return None;
        }
        values.iter_mut().for_each(|v| *v = (*v - middle) / sd);
        let mut coefficients = vec![0.0; TERMS];
        for (k, value) in values.iter().enumerate() {
            let (z, weight) = point(k);
            // Hermite polynomials of norm 1.
            let (mut before, mut here) = (0.0, 1.0);
            for (n, c) in coefficients.iter_mut().enumerate() {
                let next = (z * here - (n as f64).sqrt() * before) / ((n + 1) as f64).sqrt();
                (before, here) = (here, next);
                *c += weight * value * here;
            }
        }
        Some(Self {
            values,
            coefficients,
        })
    }

    /// Of a normal distribution.
    fn normal() -> Self {
        let mut coefficients = vec![0.0; TERMS];
        coefficients[0] = 1.0;
        Self {
            values: (0..POINTS).map(|k| point(k).0).collect(),
            coefficients,
        }
    }

    /// The least and the largest correlation that the two can have.
    fn reachable(&self, other: &Self) -> (f64, f64) {
        let sum = |turned: bool| -> f64 {
            let terms = self.values.iter().enumerate().map(|(k, x)| {
                let y = other.values[if turned { POINTS - 1 - k } else { k }];
                point(k).1 * x * y
            });
            terms.sum()
        };
        (sum(true), sum(false))
    }

    /// The correlation of scores at which the two have this correlation.
    ///
    /// # Errors
    /// The reachable range, where it lies outside.
    fn correlation(&self, other: &Self, wanted: f64) -> Result<f64, (f64, f64)> {
        let (least, most) = self.reachable(other);
        // The integrals over steps of a distribution have a few 10⁻⁴.
        let rounding = 1e-3 * (most - least) * if wanted.abs() > 0.999 { 1.0 } else { 1e-3 };
        if wanted > most + rounding || wanted < least - rounding {
            return Err((least, most));
        }
        let products: Vec<f64> = self
            .coefficients
            .iter()
            .zip(&other.coefficients)
            .map(|(a, b)| a * b)
            .collect();
        let series = |rho: f64| rho * products.iter().rev().fold(0.0, |sum, c| sum * rho + c);
        let (below, above) = (least - series(-1.0), most - series(1.0));
        let correlation = |rho: f64| {
            let rest = if rho > 0.0 { above } else { below };
            series(rho) + rest * rho.abs().powi(TERMS as i32 + 1)
        };
        let (mut low, mut high) = (-1.0, 1.0);
        if wanted >= most - 1e-9 {
            return Ok(1.0);
        }
        if wanted <= least + 1e-9 {
            return Ok(-1.0);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if correlation(middle) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn scores(distribution: &Distribution) -> Scores {
        Scores::of(|p| distribution.quantile(p)).unwrap()
    }

    /// Rectangular pairs: r = 6/π arcsin(ρ/2); rectangular with normal: r = ρ √(3/π); lognormal pairs:
    /// r = (exp(ρσ²) − 1)/(exp(σ²) − 1); two values of equal weight: r = 2/π arcsin ρ.
    #[test]
    fn published_correlations_of_scores() {
        let rectangular = scores(&Distribution::Rectangular {
            lower: 2.0,
            upper: 5.0,
        });
        let lognormal = scores(&Distribution::Lognormal {
            lower: 0.0,
            median: 3.0,
            sigma: 0.8,
        });
        let coin = scores(&Distribution::Discrete {
            values: vec![1.0, 4.0],
            weights: vec![1.0, 1.0],
        });
        let s = 0.64f64;
        for rho in [-0.95, -0.5, -0.1, 0.3, 0.8, 0.99] {
            let check = |a: &Scores, b: &Scores, r: f64, allowed: f64| {
                let found = a.correlation(b, r).unwrap();
                assert!((found - rho).abs() < allowed, "{found} is not {rho}");
            };
            check(
                &rectangular,
                &rectangular,
                6.0 / PI * (rho / 2.0f64).asin(),
                1e-6,
            );
            check(
                &rectangular,
                &Scores::normal(),
                rho * (3.0 / PI).sqrt(),
                1e-6,
            );
            let lognormal_r = ((rho * s).exp() - 1.0) / (s.exp() - 1.0);
            check(&lognormal, &lognormal, lognormal_r, 1e-6);
            check(&coin, &coin, 2.0 / PI * rho.asin(), 2e-3);
        }
        // Not every coefficient can be had.
        let (least, most) = lognormal.reachable(&lognormal);
        assert!(
            (least - ((-s).exp() - 1.0) / (s.exp() - 1.0)).abs() < 1e-9
                && (most - 1.0).abs() < 1e-9
        );
        assert!(lognormal.correlation(&lognormal, -0.7).is_err());
        assert_eq!(rectangular.correlation(&rectangular, 1.0), Ok(1.0));
        assert!(rectangular.correlation(&Scores::normal(), 0.99).is_err());
    }
}
