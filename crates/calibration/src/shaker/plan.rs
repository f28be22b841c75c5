//! What a plan will achieve before anything is measured, and the best of the candidate configurations.

use super::budget::Budget;
use super::fit::complex;
use super::geometry::Configuration;
use super::matrix::{AXES, Matrix, row_times};
use super::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side};
use num_complex::Complex64;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// How well a set of directions determines three regressors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conditioning {
    /// Number of configurations.
    pub count: usize,
    /// Ratio of the largest to the smallest singular value of the directions.
    pub condition: f64,
    /// Correlation of the regressors a_x a_y, a_y a_z, a_z a_x, about zero.
    pub correlation: [f64; 3],
    /// D-efficiency 3 det(DᵀD/n)^{1/3}: one for directions that cover the sphere evenly.
    pub d_efficiency: f64,
    /// A-efficiency 9/(n tr (DᵀD)⁻¹): one likewise.
    pub a_efficiency: f64,
}

fn gram(plan: &[Configuration]) -> [[f64; 3]; 3] {
    let mut g = [[0.0; 3]; 3];
    for c in plan {
        let d = c.direction();
        for i in 0..3 {
            for j in 0..3 {
                g[i][j] += d[i] * d[j];
            }
        }
    }
    g
}

fn determinant(g: &[[f64; 3]; 3]) -> f64 {
    g[0][0] * (g[1][1] * g[2][2] - g[1][2] * g[2][1])
        - g[0][1] * (g[1][0] * g[2][2] - g[1][2] * g[2][0])
        + g[0][2] * (g[1][0] * g[2][1] - g[1][1] * g[2][0])
}

/// Condition number, correlations and efficiencies of a plan.
///
/// # Errors
/// [`Error::Unobservable`] when the directions do not span three dimensions.
///
/// ```
/// use proofmass_calibration::shaker::{geometry::published_plan, plan::conditioning};
/// let c = conditioning(&published_plan()).unwrap();
/// assert_eq!(c.count, 44);
/// assert!((c.condition - 1.291).abs() < 1e-3 && (c.d_efficiency - 0.970).abs() < 1e-3);
/// ```
pub fn conditioning(plan: &[Configuration]) -> Result<Conditioning, Error> {
    let g = gram(plan);
    let n = plan.len() as f64;
    let eigen = Mat::from_fn(3, 3, |i, j| g[i][j])
        .self_adjoint_eigenvalues(Side::Lower)
        .map_err(|_| Error::NotConverged {
            name: "eigenvalues of the plan",
            iterations: 0,
            step: f64::INFINITY,
        })?;
    let condition = (eigen[2] / eigen[0].max(0.0)).sqrt();
    if !(condition < 1e6) {
        return Err(Error::Unobservable {
            parameter: "sensitivity",
            condition,
        });
    }
    let correlation = |i: usize, j: usize| g[i][j] / (g[i][i] * g[j][j]).sqrt();
    Ok(Conditioning {
        count: plan.len(),
        condition,
        correlation: [correlation(0, 1), correlation(1, 2), correlation(2, 0)],
        d_efficiency: 3.0 * (eigen[0] * eigen[1] * eigen[2]).cbrt() / n,
        a_efficiency: 9.0 / (n * eigen.iter().map(|e| 1.0 / e).sum::<f64>()),
    })
}

/// Predicted uncertainty of one term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// Row and column as letters.
    pub term: String,
    /// Standard uncertainty of the real part over the mean main sensitivity.
    pub relative_real: f64,
    /// The same of the imaginary part.
    pub relative_imaginary: f64,
}

/// Uncertainties a plan will give with a budget, for a device of about this S, at one frequency.
///
/// A noise-free campaign is adjusted by [`complex`]: its covariance does not depend on the noise.
///
/// # Errors
/// As [`complex`].
pub fn predict(
    plan: &[Configuration],
    budget: &Budget,
    sensitivity: &Matrix,
    amplitude: f64,
) -> Result<Vec<Predicted>, Error> {
    let rows: Vec<PhasorRow> = plan
        .iter()
        .map(|&configuration| {
            let a = configuration
                .direction()
                .map(|d| Complex64::new(amplitude * d, 0.0));
            PhasorRow::new(
                "",
                1.0,
                configuration,
                Complex64::new(amplitude, 0.0),
                row_times(a, sensitivity),
            )
        })
        .collect();
    let fit = complex(&rows, &SpuriousTable::default(), budget)?;
    let covariance = fit.frequencies[0].estimate.covariance();
    let main = (0..3).map(|i| sensitivity[i][i].norm()).sum::<f64>() / 3.0;
    Ok((0..9)
        .map(|k| Predicted {
            term: format!("{}{}", AXES[k / 3], AXES[k % 3]),
            relative_real: covariance.standard_uncertainty(2 * k) / main,
            relative_imaginary: covariance.standard_uncertainty(2 * k + 1) / main,
        })
        .collect())
}

/// The best `count` of some candidates: the largest determinant of DᵀD, by greedy choice and exchange.
///
/// Exchange ends when no swap of a chosen for a free candidate raises the determinant; several starts guard
/// against a poor end. Returns indices of candidates in ascending order.
///
/// **Source** `[Fedorov1972]` 3.
///
/// # Errors
/// [`Error::TooFew`] for a count below three or above the candidates, [`Error::Unobservable`] when they do not
/// span.
pub fn best(candidates: &[Configuration], count: usize) -> Result<Vec<usize>, Error> {
    let m = candidates.len();
    if count < 3 || count > m {
        return Err(Error::TooFew {
            name: "configurations",
            needed: 3.max(count),
            got: m.min(count),
        });
    }
    let d: Vec<[f64; 3]> = candidates.iter().map(Configuration::direction).collect();
    let change = |g: &mut [[f64; 3]; 3], k: usize, sign: f64| {
        for i in 0..3 {
            for j in 0..3 {
                g[i][j] += sign * d[k][i] * d[k][j];
            }
        }
    };
    let mut champion: (f64, Vec<usize>) = (0.0, vec![]);
    for start in 0..m {
        // Greedy from each candidate, with a trace of identity until three are in.
        let mut g = [[0.0; 3]; 3];
        let mut chosen = vec![start];
        change(&mut g, start, 1.0);
        while chosen.len() < count {
            let ridge = if chosen.len() < 3 { 1e-3 } else { 0.0 };
            let gain = |k: usize| {
                let mut t = g;
                change(&mut t, k, 1.0);
                for (i, row) in t.iter_mut().enumerate() {
                    row[i] += ridge;
                }
                determinant(&t)
            };
            let Some(next) = (0..m)
                .filter(|k| !chosen.contains(k))
                .max_by(|&a, &b| gain(a).total_cmp(&gain(b)))
            else {
                break;
            };
            change(&mut g, next, 1.0);
            chosen.push(next);
        }
        loop {
            let now = determinant(&g);
            let mut swap = None;
            let mut highest = now * (1.0 + 1e-9);
            for (place, &out) in chosen.iter().enumerate() {
                for into in (0..m).filter(|k| !chosen.contains(k)) {
                    let mut t = g;
                    change(&mut t, out, -1.0);
                    change(&mut t, into, 1.0);
                    let value = determinant(&t);
                    if value > highest {
                        (highest, swap) = (value, Some((place, into)));
                    }
                }
            }
            let Some((place, into)) = swap else { break };
            change(&mut g, chosen[place], -1.0);
            change(&mut g, into, 1.0);
            chosen[place] = into;
        }
        let value = determinant(&g);
        if value > champion.0 * (1.0 + 1e-9) {
            champion = (value, chosen);
        }
    }
    if champion.0 < 1e-9 {
        return Err(Error::Unobservable {
            parameter: "sensitivity",
            condition: f64::INFINITY,
        });
    }
    champion.1.sort_unstable();
    Ok(champion.1)
}

/// What fewer configurations cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanCost {
    /// Conditioning of the best plan of this size.
    pub conditioning: Conditioning,
    /// Its configurations, as indices of the candidates.
    pub chosen: Vec<usize>,
    /// Largest relative standard uncertainty of a main term.
    pub main: f64,
    /// Largest relative standard uncertainty of a cross term.
    pub cross: f64,
}

/// The best plans of some sizes and the uncertainties they give.
///
/// # Errors
/// As [`best`] and [`predict`].
pub fn costs(
    candidates: &[Configuration],
    sizes: &[usize],
    budget: &Budget,
    sensitivity: &Matrix,
    amplitude: f64,
) -> Result<Vec<PlanCost>, Error> {
    sizes
        .iter()
        .map(|&size| {
            let chosen = best(candidates, size)?;
            let plan: Vec<Configuration> = chosen.iter().map(|&k| candidates[k]).collect();
            let predicted = predict(&plan, budget, sensitivity, amplitude)?;
            let largest = |main: bool| {
                predicted
                    .iter()
                    .enumerate()
                    .filter(|(k, _)| (k % 4 == 0) == main)
                    .map(|(_, p)| p.relative_real)
                    .fold(0.0, f64::max)
            };
            Ok(PlanCost {
                conditioning: conditioning(&plan)?,
                chosen,
                main: largest(true),
                cross: largest(false),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::geometry::published_plan;
    use super::*;

    #[test]
    fn law_three_orthogonal_directions_are_the_best_three() {
        let candidates = published_plan();
        let three = best(&candidates, 3).unwrap();
        let plan: Vec<_> = three.iter().map(|&k| candidates[k]).collect();
        let c = conditioning(&plan).unwrap();
        assert!((c.condition - 1.0).abs() < 1e-9 && (c.d_efficiency - 1.0).abs() < 1e-9);
    }

    #[test]
    fn crosscheck_exchange_against_every_subset() {
        // Ten candidates, four of them: 210 subsets, all tried.
        let candidates: Vec<Configuration> = published_plan()
            .into_iter()
            .skip(4)
            .step_by(3)
            .take(10)
            .collect();
        let m = candidates.len();
        assert_eq!(m, 10);
        let value = |s: &[usize]| {
            let plan: Vec<_> = s.iter().map(|&k| candidates[k]).collect();
            determinant(&gram(&plan))
        };
        let mut most: f64 = 0.0;
        for a in 0..m {
            for b in a + 1..m {
                for c in b + 1..m {
                    for d in c + 1..m {
                        most = most.max(value(&[a, b, c, d]));
                    }
                }
            }
        }
        assert!((value(&best(&candidates, 4).unwrap()) / most - 1.0).abs() < 1e-9);
    }

    #[test]
    fn law_fewer_configurations_cost() {
        let s: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| Complex64::new(if i == j { 0.01 } else { 1e-4 }, 0.0))
        });
        let mut budget = Budget::published_bench();
        budget.inputs.push(super::super::Input::new(
            "noise",
            super::super::Acts::OutputAdditive,
            5e-5,
            &[super::super::Key::Run, super::super::Key::Channel],
        ));
        let costs = costs(&published_plan(), &[6, 12, 20, 44], &budget, &s, 10.0).unwrap();
        for pair in costs.windows(2) {
            assert!(pair[1].main < pair[0].main && pair[1].cross < pair[0].cross);
        }
        // The reference calibration, 0.2 % common to all, is the floor of the main terms.
        assert!(costs[3].main > 0.002 && costs[3].main < 0.0026, "{costs:?}");
        for c in &costs {
            println!(
                "{} configurations: main {:.2e}, cross {:.2e}",
                c.conditioning.count, c.main, c.cross
            );
        }
    }

    #[test]
    fn refuses_a_plan_in_a_plane() {
        let flat = [
            Configuration::degrees(90.0, 0.0),
            Configuration::degrees(90.0, 90.0),
        ];
        assert!(matches!(
            conditioning(&flat),
            Err(Error::Unobservable { .. })
        ));
        assert!(matches!(best(&flat, 3), Err(Error::TooFew { .. })));
    }
}
