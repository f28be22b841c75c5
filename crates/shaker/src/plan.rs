//! What a plan will achieve before anything is measured, and the best of the candidate configurations.

use super::budget::Budget;
use super::excitation::directions;
use super::fit::complex;
use super::geometry::Configuration;
use super::matrix::{AXES, Matrix, row_times};
use super::observation::{PhasorRow, Spurious, SpuriousTable};
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::{Error, Matrix3, dot};
use proofmass_uncertainty::algebra::symmetric_eigenvalues;

/// How well a set of directions determines three regressors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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

/// The spurious motion that a plan is to expect at its frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExpectedSpurious {
    /// An entry for every inclination of the plan.
    pub table: SpuriousTable,
    /// The frequency that was measured nearest, Hz.
    pub at: f64,
    /// Candidates whose inclination was not measured.
    pub missing: usize,
    /// Root mean square standard uncertainty of the parts of a ratio where it is known least.
    pub root: f64,
}

impl ExpectedSpurious {
    /// What a measurement says of a frequency: of its nearest frequency, and of an inclination that it does not have as little as of
    /// the one it knows least. `None` of an empty table.
    pub fn of(
        measured: &SpuriousTable,
        frequency: f64,
        candidates: &[Configuration],
    ) -> Option<Self> {
        let entries = &measured.entries;
        let far = |e: &Spurious| (e.frequency / frequency).ln().abs();
        let nearest = entries.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
        let at = nearest.frequency;
        let mut table = SpuriousTable::new(
            entries
                .iter()
                .filter(|e| e.frequency == at)
                .cloned()
                .collect(),
        );
        for e in &mut table.entries {
            e.frequency = frequency;
        }
        let size = |e: &Spurious| e.covariance.iter().map(|c| c[0] + c[2]).sum::<f64>();
        let worst = table
            .entries
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .cloned();
        let mut missing = 0;
        for c in candidates {
            if table.get(c.inclination, frequency).is_none()
                && let Some(worst) = &worst
            {
                missing += 1;
                table.entries.push(Spurious {
                    inclination: c.inclination,
                    ratio: [Complex64::new(0.0, 0.0); 3],
                    ..worst.clone()
                });
            }
        }
        let root = (worst.as_ref().map_or(0.0, size) / 6.0).sqrt();
        Some(Self {
            table,
            at,
            missing,
            root,
        })
    }
}

/// Equal main terms and cross terms of 1 %: what a sound device has.
pub fn sound_matrix(main: f64) -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| Complex64::new(main * if i == j { 1.0 } else { 0.01 }, 0.0))
    })
}

/// Numbers of configurations worth comparing, up to all candidates.
pub fn usual_sizes(count: usize) -> Vec<usize> {
    let mut sizes: Vec<usize> = [4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 60, 100]
        .into_iter()
        .filter(|&n| n < count)
        .collect();
    sizes.push(count);
    sizes
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

/// Condition number, correlations and efficiencies of a plan.
///
/// # Errors
/// [`Error::Unobservable`] when the directions do not span three dimensions.
///
/// ```
/// use proofmass_shaker::geometry::published_plan;
/// use proofmass_shaker::plan::conditioning;
/// let c = conditioning(&published_plan()).unwrap();
/// assert_eq!(c.count, 44);
/// assert!((c.condition - 1.291).abs() < 1e-3 && (c.d_efficiency - 0.970).abs() < 1e-3);
/// ```
pub fn conditioning(plan: &[Configuration]) -> Result<Conditioning, Error> {
    let g = gram(plan);
    let n = plan.len() as f64;
    let eigen = symmetric_eigenvalues(
        &Mat::from_fn(3, 3, |i, j| g[i][j]),
        "eigenvalues of the plan",
    )?;
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
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Predicted {
    /// Row and column as letters.
    pub term: String,
    /// Standard uncertainty of the real part over the mean main sensitivity.
    pub relative_real: f64,
    /// The same of the imaginary part.
    pub relative_imaginary: f64,
}

/// What a plan is reckoned with: the budget, the spurious motion as it will be known, a device of about this S.
#[derive(Clone, Copy, Debug)]
pub struct Expected<'a> {
    /// What will be uncertain.
    pub budget: &'a Budget,
    /// Spurious motion at the inclinations and the frequency, with its uncertainty; empty for none.
    pub spurious: &'a SpuriousTable,
    /// S in V/(m/s²).
    pub sensitivity: &'a Matrix,
    /// Acceleration in m/s².
    pub amplitude: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Session of each configuration; all are of one session where it is empty.
    pub sessions: &'a [String],
}

/// Uncertainties a plan will give, at one frequency.
///
/// A noise-free campaign is adjusted by [`complex`]: its covariance does not depend on the noise.
///
/// # Errors
/// As [`complex`]; [`Error::Length`] for sessions of some configurations alone.
pub fn predict(plan: &[Configuration], expected: &Expected<'_>) -> Result<Vec<Predicted>, Error> {
    let named = expected.sessions.len();
    if named != 0 && named != plan.len() {
        return Err(Error::Length {
            name: "sessions of a plan",
            expected: plan.len(),
            got: named,
        });
    }
    let amplitude = Complex64::new(expected.amplitude, 0.0);
    let mut rows: Vec<PhasorRow> = plan
        .iter()
        .enumerate()
        .map(|(k, &configuration)| {
            let nothing = [Complex64::new(0.0, 0.0); 3];
            let row = PhasorRow::new("", expected.frequency, configuration, amplitude, nothing);
            PhasorRow {
                session: Some(expected.sessions.get(k).cloned().unwrap_or_default()),
                ..row
            }
        })
        .collect();
    let seen = directions(&rows, expected.spurious);
    for (row, d) in rows.iter_mut().zip(seen) {
        row.outputs = row_times(d.map(|d| d * amplitude), expected.sensitivity);
    }
    let fit = complex(&rows, expected.spurious, expected.budget)?;
    let covariance = fit.frequencies[0].estimate.covariance();
    let s = expected.sensitivity;
    let main = (0..3).map(|i| s[i][i].norm()).sum::<f64>() / 3.0;
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
/// against a poor end: every candidate up to 64 of them, then fewer, so that the time grows with their number only.
/// Of equals the first is taken. Returns indices of candidates in ascending order.
///
/// **Equation** det(G − aaᵀ + bbᵀ) = det G ((1 − aᵀG⁻¹a)(1 + bᵀG⁻¹b) + (aᵀG⁻¹b)²)
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
    let starts = if m <= 64 { m } else { (4096 / m).max(4) };
    let mut champion: (f64, Vec<usize>) = (0.0, vec![]);
    for start in 0..starts {
        let mut choice = Choice::new(&d, start * m / starts);
        while choice.chosen.len() < count && choice.add() {}
        while choice.exchange() {}
        let value = Matrix3(choice.g).determinant();
        if value > champion.0 * (1.0 + 1e-9) {
            champion = (value, choice.chosen);
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

/// By how much a value must be larger than another to be larger on every machine.
const LARGER: f64 = 1.0 + 1e-12;

/// A choice of candidates in the making.
struct Choice<'a> {
    d: &'a [[f64; 3]],
    chosen: Vec<usize>,
    taken: Vec<bool>,
    /// DᵀD of the chosen.
    g: [[f64; 3]; 3],
}

impl<'a> Choice<'a> {
    fn new(d: &'a [[f64; 3]], first: usize) -> Self {
        let mut choice = Self {
            d,
            chosen: vec![first],
            taken: vec![false; d.len()],
            g: [[0.0; 3]; 3],
        };
        choice.change(first, 1.0);
        choice
    }

    fn change(&mut self, k: usize, sign: f64) {
        self.taken[k] = sign > 0.0;
        let d = self.d[k];
        for i in 0..3 {
            for j in 0..3 {
                self.g[i][j] += sign * d[i] * d[j];
            }
        }
    }

    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.d.len()).filter(|&k| !self.taken[k])
    }

    /// Takes the candidate that raises the determinant most; with a trace of identity until three are in.
    fn add(&mut self) -> bool {
        let ridge = if self.chosen.len() < 3 { 1e-3 } else { 0.0 };
        let inverse = adjoint(&self.g, ridge);
        let mut most: Option<(f64, usize)> = None;
        for k in self.free() {
            // det(G + bbᵀ) − det G = bᵀ adj(G) b, also where G has no inverse.
            let gain = dot(self.d[k], times(&inverse, self.d[k]));
            if most.is_none_or(|(value, _)| gain > value * LARGER) {
                most = Some((gain, k));
            }
        }
        if let Some((_, k)) = most {
            self.change(k, 1.0);
            self.chosen.push(k);
        }
        most.is_some()
    }

    /// Swaps the pair that raises the determinant most; `false` where none does.
    fn exchange(&mut self) -> bool {
        let whole = Matrix3(self.g).determinant();
        if !(whole > 0.0) {
            return false;
        }
        let inverse = adjoint(&self.g, 0.0).map(|row| row.map(|v| v / whole));
        let free: Vec<(usize, f64)> = self
            .free()
            .map(|k| (k, dot(self.d[k], times(&inverse, self.d[k]))))
            .collect();
        let mut swap = None;
        let mut highest = 1.0 + 1e-9;
        for (place, &out) in self.chosen.iter().enumerate() {
            let v = times(&inverse, self.d[out]);
            let kept = 1.0 - dot(self.d[out], v);
            for &(into, own) in &free {
                let both = dot(self.d[into], v);
                let value = kept * (1.0 + own) + both * both;
                if value > highest {
                    (highest, swap) = (value * LARGER, Some((place, into)));
                }
            }
        }
        if let Some((place, into)) = swap {
            self.change(self.chosen[place], -1.0);
            self.change(into, 1.0);
            self.chosen[place] = into;
        }
        swap.is_some()
    }
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v))
}

/// Adjoint of a symmetric matrix with something added to its diagonal.
fn adjoint(g: &[[f64; 3]; 3], ridge: f64) -> [[f64; 3]; 3] {
    let mut g = *g;
    for (i, row) in g.iter_mut().enumerate() {
        row[i] += ridge;
    }
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            let (c, d) = ((j + 1) % 3, (j + 2) % 3);
            g[a][c] * g[b][d] - g[a][d] * g[b][c]
        })
    })
}

/// What fewer configurations cost.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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

/// The best plans of some sizes and the uncertainties they give; `sessions` are those of the candidates.
///
/// # Errors
/// As [`best`] and [`predict`].
pub fn costs(
    candidates: &[Configuration],
    sizes: &[usize],
    expected: &Expected<'_>,
) -> Result<Vec<PlanCost>, Error> {
    sizes
        .iter()
        .map(|&size| {
            let chosen = best(candidates, size)?;
            let plan: Vec<Configuration> = chosen.iter().map(|&k| candidates[k]).collect();
            let sessions = expected.sessions;
            let sessions: Vec<String> = chosen
                .iter()
                .filter_map(|&k| sessions.get(k).cloned())
                .collect();
            let expected = &Expected {
                sessions: &sessions,
                ..*expected
            };
            let predicted = predict(&plan, expected)?;
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
            Matrix3(gram(&plan)).determinant()
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
    fn law_many_candidates_end_where_no_swap_helps() {
        // A hemisphere of 2000 directions, of which an even cover has nearly the efficiency of the whole sphere.
        let candidates: Vec<Configuration> = (0..2000)
            .map(|k| {
                let z = (f64::from(k) + 0.5) / 2000.0;
                let turn = 137.507_764 * f64::from(k);
                Configuration::degrees(z.acos().to_degrees(), turn % 360.0)
            })
            .collect();
        let chosen = best(&candidates, 24).unwrap();
        let plan: Vec<_> = chosen.iter().map(|&k| candidates[k]).collect();
        assert_eq!(plan.len(), 24);
        // Eight times three orthogonal directions have efficiency one.
        assert!(conditioning(&plan).unwrap().d_efficiency > 1.0 - 1e-4);
        let whole = Matrix3(gram(&plan)).determinant();
        for &out in chosen.iter().step_by(5) {
            for into in (0..2000).step_by(7).filter(|k| !chosen.contains(k)) {
                let other: Vec<_> = chosen
                    .iter()
                    .map(|&k| candidates[if k == out { into } else { k }])
                    .collect();
                assert!(Matrix3(gram(&other)).determinant() < whole * (1.0 + 1e-8));
            }
        }
    }

    #[test]
    fn law_fewer_configurations_cost() {
        let s: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| Complex64::new(if i == j { 0.01 } else { 1e-4 }, 0.0))
        });
        let mut budget = Budget::published_bench();
        budget.inputs.push(super::super::ShakerInput::new(
            "noise",
            super::super::Acts::OutputAdditive,
            5e-5,
            &[super::super::Key::Run, super::super::Key::Channel],
        ));
        let expected = Expected {
            budget: &budget,
            spurious: &SpuriousTable::default(),
            sensitivity: &s,
            amplitude: 10.0,
            frequency: 160.0,
            sessions: &[],
        };
        let costs = costs(&published_plan(), &[6, 12, 20, 44], &expected).unwrap();
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
