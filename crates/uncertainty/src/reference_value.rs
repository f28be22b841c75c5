//! Reference value of several laboratories, and how far each of them is from it.

use crate::Covariance;
use crate::algebra::{Cholesky, cholesky};
use crate::quantile::chi_squared_chance;
use faer::Mat;
use faer::linalg::solvers::LltError;
use proofmass_core::{Error, check};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// Weighted mean of independent results of one quantity of n components, and each result's deviation from it.
///
/// ```text
/// x_ref = C Σ V_i⁻¹ x_i,   C = (Σ V_i⁻¹)⁻¹,   χ² = Σ (x_i − x_ref)ᵀ V_i⁻¹ (x_i − x_ref),   d_i = x_i − x_ref,   V(d_i) = V_i − C
/// ```
///
/// **Assumes** results that have nothing in common. **Source** procedure A of `[Cox02]`, for vectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WeightedMean {
    /// x_ref.
    pub value: Vec<f64>,
    /// C.
    pub covariance: Covariance,
    /// χ² of the deviations.
    pub chi_square: f64,
    /// n (N − 1) for N results.
    pub freedom: usize,
    /// Chance of a χ² as large or larger.
    pub chance: f64,
    /// d_i of every result.
    pub deviations: Vec<Deviation>,
}

/// Degree of equivalence of one result: its deviation from the reference value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Deviation {
    /// d_i.
    pub value: Vec<f64>,
    /// Its covariance.
    pub covariance: Covariance,
}

impl WeightedMean {
    /// Chance below which the results do not agree with each other, and their weighted mean is not to be used.
    pub const CONSISTENT: f64 = 0.05;

    /// The mean.
    ///
    /// **Shapes** every result has as many components as the first, its covariance as many rows.
    ///
    /// ```
    /// use proofmass_uncertainty::{Covariance, WeightedMean};
    /// let u = |u: f64| Covariance::from_standard_uncertainties(&[u]);
    /// let mean = WeightedMean::of(&[vec![10.1], vec![9.9], vec![10.0]], &[u(0.1)?, u(0.1)?, u(0.2)?])?;
    /// assert!((mean.value[0] - 10.0).abs() < 1e-12);
    /// // 1/(100 + 100 + 25)
    /// assert!((mean.covariance[(0, 0)] - 1.0 / 225.0).abs() < 1e-15);
    /// assert!((mean.chi_square - 2.0).abs() < 1e-12 && mean.freedom == 2);
    /// // V₃ − C = 0.04 − 0.00444
    /// assert!((mean.deviations[2].covariance[(0, 0)] - (0.04 - 1.0 / 225.0)).abs() < 1e-15);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::TooFew`] below two results, [`Error::Length`], [`Error::NotFinite`], [`Error::NotPositiveDefinite`] for a result
    /// whose covariance is singular.
    pub fn of(results: &[Vec<f64>], covariances: &[Covariance]) -> Result<Self, Error> {
        let n = check(results, covariances)?;
        let mut inverses = Vec::with_capacity(results.len());
        for covariance in covariances {
            inverses.push(inverse(covariance.elements(), n)?);
        }
        let mut sum = vec![0.0; n * n];
        let mut weighted = vec![0.0; n];
        for (x, w) in results.iter().zip(&inverses) {
            for i in 0..n {
                for j in 0..n {
                    sum[n * i + j] += w[n * i + j];
                    weighted[i] += w[n * i + j] * x[j];
                }
            }
        }
        let c = inverse(&sum, n)?;
        let value: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| c[n * i + j] * weighted[j]).sum())
            .collect();
        let (mut chi_square, mut deviations) = (0.0, Vec::with_capacity(results.len()));
        for ((x, w), v) in results.iter().zip(&inverses).zip(covariances) {
            let d: Vec<f64> = x.iter().zip(&value).map(|(x, r)| x - r).collect();
            for i in 0..n {
                for j in 0..n {
                    chi_square += d[i] * w[n * i + j] * d[j];
                }
            }
            deviations.push(Deviation {
                covariance: less(v, &c)?,
                value: d,
            });
        }
        let freedom = n * (results.len() - 1);
        Ok(Self {
            value,
            covariance: Covariance::try_from_rows(n, &c)?,
            chi_square,
            freedom,
            chance: chi_squared_chance(chi_square, freedom as f64),
            deviations,
        })
    }

    /// Whether the results agree with each other: by chance, one comparison in twenty does not.
    pub fn is_consistent(&self) -> bool {
        self.chance >= Self::CONSISTENT
    }
}

/// Median of independent results, component by component, by Monte Carlo: what a result that is off hardly draws along.
///
/// **Accuracy** 95 % intervals of five results hold in 94 %; those of four beside a fifth that is far off in 90 %, since it moves the
/// median to one side (`coverage_of_deviations_from_mean_and_median`).
///
/// **Source** procedure B of `[Cox02]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MedianValue {
    /// Mean of the trials' medians.
    pub value: Vec<f64>,
    /// Their standard deviation.
    pub uncertainty: Vec<f64>,
    /// Deviation of every result, by component: value, and limits of the shortest interval of the probability.
    pub deviations: Vec<Vec<MedianDeviation>>,
}

/// Deviation of one component of one result from the median.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MedianDeviation {
    /// Deviation.
    pub value: f64,
    /// Lower limit.
    pub lower: f64,
    /// Upper limit.
    pub upper: f64,
}

impl MedianValue {
    /// The median, by so many trials of the results as normal distributions.
    ///
    /// # Errors
    /// As [`WeightedMean::of`]; [`Error::TooFew`] below a hundred trials, [`Error::OutOfRange`] for a probability outside (0, 1).
    pub fn of(
        results: &[Vec<f64>],
        covariances: &[Covariance],
        probability: f64,
        trials: usize,
        seed: u64,
    ) -> Result<Self, Error> {
        let n = check(results, covariances)?;
        if trials < 100 {
            return Err(Error::TooFew {
                name: "trials of the median",
                needed: 100,
                got: trials,
            });
        }
        check::probability(probability)?;
        let roots = covariances
            .iter()
            .map(|c| Ok(factors(c.elements(), n)?.lower().to_owned()))
            .collect::<Result<Vec<Mat<f64>>, Error>>()?;
        let count = results.len();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut medians = vec![Vec::with_capacity(trials); n];
        let mut apart = vec![vec![Vec::with_capacity(trials); n]; count];
        let mut drawn = vec![vec![0.0; count]; n];
        let mut normal = vec![0.0; n];
        for _ in 0..trials {
            for (i, (x, l)) in results.iter().zip(&roots).enumerate() {
                normal
                    .iter_mut()
                    .for_each(|z| *z = StandardNormal.sample(&mut rng));
                for k in 0..n {
                    let shift: f64 = (0..=k).map(|j| l[(k, j)] * normal[j]).sum();
                    drawn[k][i] = x[k] + shift;
                }
            }
            for k in 0..n {
                let mut sorted = drawn[k].clone();
                sorted.sort_by(f64::total_cmp);
                let half = count / 2;
                let median = match count % 2 {
                    0 => 0.5 * (sorted[half - 1] + sorted[half]),
                    _ => sorted[half],
                };
                medians[k].push(median);
                for i in 0..count {
                    apart[i][k].push(drawn[k][i] - median);
                }
            }
        }
        let moments = |list: &[f64]| {
            let mean = list.iter().sum::<f64>() / list.len() as f64;
            let square: f64 = list.iter().map(|x| (x - mean).powi(2)).sum();
            (mean, (square / (list.len() - 1) as f64).sqrt())
        };
        let (value, uncertainty): (Vec<f64>, Vec<f64>) = medians.iter().map(|m| moments(m)).unzip();
        let deviations = apart.into_iter().zip(results).map(|(components, x)| {
            let each = components.into_iter().enumerate();
            each.map(|(k, list)| {
                let (lower, upper) = shortest(list, probability);
                MedianDeviation {
                    value: x[k] - value[k],
                    lower,
                    upper,
                }
            })
            .collect()
        });
        Ok(Self {
            deviations: deviations.collect(),
            value,
            uncertainty,
        })
    }
}

/// Limits of the shortest interval that holds this share of the values.
fn shortest(mut list: Vec<f64>, probability: f64) -> (f64, f64) {
    list.sort_by(f64::total_cmp);
    let held = ((probability * list.len() as f64).ceil() as usize).clamp(1, list.len());
    let starts = 0..=list.len() - held;
    let width = |at: usize| list[at + held - 1] - list[at];
    let at = starts
        .min_by(|a, b| width(*a).total_cmp(&width(*b)))
        .unwrap_or(0);
    (list[at], list[at + held - 1])
}

/// Number of components, where all results have it.
fn check(results: &[Vec<f64>], covariances: &[Covariance]) -> Result<usize, Error> {
    if results.len() < 2 {
        return Err(Error::TooFew {
            name: "results to be compared",
            needed: 2,
            got: results.len(),
        });
    }
    let n = results[0].len();
    let length = |name, expected, got| Error::Length {
        name,
        expected,
        got,
    };
    if covariances.len() != results.len() {
        return Err(length(
            "covariances of the results",
            results.len(),
            covariances.len(),
        ));
    }
    for (index, (x, v)) in results.iter().zip(covariances).enumerate() {
        if x.len() != n {
            return Err(length("components of a result", n, x.len()));
        }
        if v.dimension() != n {
            return Err(length("covariance of a result", n, v.dimension()));
        }
        if x.iter().any(|x| !x.is_finite()) {
            return Err(Error::NotFinite {
                name: "results to be compared",
                index,
            });
        }
    }
    Ok(n)
}

/// V − C, rounding below zero taken for zero.
fn less(v: &Covariance, c: &[f64]) -> Result<Covariance, Error> {
    let n = v.dimension();
    let mut rows: Vec<f64> = v.elements().iter().zip(c).map(|(v, c)| v - c).collect();
    for i in 0..n {
        // A result that has all the weight is the reference itself.
        let rounding = 1e-12 * v[(i, i)];
        if rows[n * i + i] <= rounding {
            for j in 0..n {
                (rows[n * i + j], rows[n * j + i]) = (0.0, 0.0);
            }
        }
    }
    Covariance::try_from_rows(n, &rows)
}

/// Cholesky's factors, of a covariance that is not singular to fourteen digits.
fn factors(v: &[f64], n: usize) -> Result<Cholesky, Error> {
    let refused = |row: usize| Error::NotPositiveDefinite {
        name: "covariance of a result",
        row,
        column: row,
        value: v[n * row + row],
    };
    let factors = cholesky(&Mat::from_fn(n, n, |i, j| v[n * i + j]))
        .map_err(|LltError::NonPositivePivot { index }| refused(index))?;
    let l = factors.lower();
    match (0..n).find(|&i| !(l[(i, i)].powi(2) > 1e-14 * v[n * i + i])) {
        Some(row) => Err(refused(row)),
        None => Ok(factors),
    }
}

/// Inverse of a covariance.
fn inverse(v: &[f64], n: usize) -> Result<Vec<f64>, Error> {
    let w = factors(v, n)?.inverse();
    Ok((0..n * n)
        .map(|at| 0.5 * (w[(at / n, at % n)] + w[(at % n, at / n)]))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_deviations(u: &[f64]) -> Vec<Covariance> {
        let one = |u: &f64| Covariance::from_standard_uncertainties(&[*u]).unwrap();
        u.iter().map(one).collect()
    }

    /// Against matrix inverses by LAPACK.
    #[test]
    fn crosscheck_weighted_mean_of_vectors() {
        let v = [
            [4.0, 1.0, 1.0, 2.0],
            [1.0, -0.5, -0.5, 3.0],
            [2.0, 0.0, 0.0, 1.0],
        ]
        .map(|rows| Covariance::try_from_rows(2, &rows).unwrap());
        let mean = WeightedMean::of(&[vec![1.0, 2.0], vec![2.0, 1.0], vec![0.0, 3.0]], &v).unwrap();
        let expected = REFERENCE;
        for (ours, theirs) in mean
            .value
            .iter()
            .chain(mean.covariance.elements())
            .zip(&expected)
        {
            assert!((ours - theirs).abs() < 1e-14, "{ours} {theirs}");
        }
        assert!((mean.chi_square - expected[6]).abs() < 1e-13);
        assert!((mean.chance - expected[7]).abs() < 1e-12);
    }

    const REFERENCE: [f64; 8] = [
        1.2093023255813953,
        2.4186046511627914,
        0.5330948121645797,
        -0.010733452593917716,
        -0.010733452593917716,
        0.5169946332737031,
        2.1627906976744184,
        0.7058469573709357,
    ];

    /// Deviations from the mean hold the truth as stated; so do those from the median, with and without a result that is off.
    #[test]
    fn coverage_of_deviations_from_mean_and_median() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let u = [0.1, 0.2, 0.15, 0.1, 0.3];
        let covariances = of_deviations(&u);
        let rounds = 400;
        let (mut mean, mut median, mut beside, mut consistent) = (0, 0, 0, 0);
        for round in 0..rounds {
            let normal: [f64; 5] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            let results: Vec<Vec<f64>> = u
                .iter()
                .zip(normal)
                .map(|(u, z)| vec![5.0 + u * z])
                .collect();
            let a = WeightedMean::of(&results, &covariances).unwrap();
            consistent += usize::from(a.is_consistent());
            // All true deviations are zero.
            for d in &a.deviations {
                mean += usize::from(d.value[0].abs() < 1.959_964 * d.covariance[(0, 0)].sqrt());
            }
            let b = MedianValue::of(&results, &covariances, 0.95, 1000, round).unwrap();
            for d in &b.deviations {
                median += usize::from(d[0].lower < 0.0 && d[0].upper > 0.0);
            }
            let mut off = results.clone();
            off[0][0] += 2.0;
            let b = MedianValue::of(&off, &covariances, 0.95, 1000, round).unwrap();
            for d in &b.deviations[1..] {
                beside += usize::from(d[0].lower < 0.0 && d[0].upper > 0.0);
            }
            assert!(b.deviations[0][0].lower > 1.0);
        }
        println!(
            "mean {mean}, median {median} of 2000, beside one that is off {beside} of 1600, consistent {consistent} of 400"
        );
        // Five of one round share their mean: bounds of three deviations of 400 rounds.
        assert!((1868..1932).contains(&mean), "{mean}");
        assert!((1850..1950).contains(&median), "{median}");
        // One of five that is off moves the median to the third of the other four: 0.9 of the intervals hold then.
        assert!((1390..1490).contains(&beside), "{beside}");
        // Binomial about 380 of 400.
        assert!((366..394).contains(&consistent), "{consistent}");
    }

    #[test]
    fn refuses_one_result_and_singular_covariances() {
        let u = of_deviations(&[0.1, 0.0]);
        assert!(WeightedMean::of(&[vec![1.0]], &u[..1]).is_err());
        assert!(WeightedMean::of(&[vec![1.0], vec![1.0]], &u).is_err());
        assert!(
            WeightedMean::of(&[vec![1.0], vec![f64::NAN]], &of_deviations(&[0.1, 0.1])).is_err()
        );
    }
}
