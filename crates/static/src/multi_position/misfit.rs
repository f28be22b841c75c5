//! What the model leaves out: terms that would explain the residuals, each with a name and a size.

use super::scatter_forms::last_motion;
use super::{Model, Problem, Solved};
use crate::Triple;
use crate::added_terms::WeighedTerms;
use proofmass_core::STANDARD_GRAVITY;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Something the model does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum MisfitCause {
    /// Elements of K that are not free.
    LargerModel {
        /// The smallest model in which they are.
        model: Model,
    },
    /// Biases that change evenly with time; size: over the whole recording.
    Drift,
    /// Biases that settle as exp(−t/τ); size: at the start.
    WarmUp {
        /// τ, s.
        time_constant: f64,
    },
    /// Biases that follow the temperature; size: over the temperatures of the recording.
    Temperature {
        /// Highest less lowest, K.
        span: f64,
    },
    /// A term in the square of the acceleration of each axis; size: at 1 g.
    Quadratic,
    /// A term in the third power; size: at 1 g.
    Cubic,
    /// A bias with the sign of the last change of the acceleration of each axis: hysteresis, friction, play.
    LastMotion,
}

/// One tested cause.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Misfit {
    /// What was looked for.
    pub cause: MisfitCause,
    /// Size along x, y and z, mg (10⁻³ standard gravity); for elements of K the three of them at 1 g.
    pub amplitudes_mg: Triple,
    /// Probability of residuals that speak as loudly for it when it is not there.
    pub p_value: f64,
    /// Whether it counts as found.
    pub found: bool,
    /// Size on one axis alone that nine of ten recordings like this one show, mg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detectable_mg: Option<f64>,
}

impl Misfit {
    /// The largest of the three, without sign, mg.
    pub fn size_mg(&self) -> f64 {
        self.amplitudes_mg.iter().fold(0.0, |m, a| m.max(a.abs()))
    }
}

/// Probability of finding any one cause that is not there; the family of eight stays at 1 %.
const LEVEL: f64 = 0.00125;

impl fmt::Display for MisfitCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LargerModel { model } => write!(f, "elements of K that model {model} has free"),
            Self::Drift => f.write_str("biases that drift with time"),
            Self::WarmUp { time_constant } => {
                write!(
                    f,
                    "biases that settle with a time constant of {time_constant:.0} s"
                )
            }
            Self::Temperature { .. } => f.write_str("biases that follow the temperature"),
            Self::Quadratic => f.write_str("a quadratic term of each axis"),
            Self::Cubic => f.write_str("a cubic term of each axis"),
            Self::LastMotion => f.write_str("biases that follow the last motion"),
        }
    }
}

/// All causes that this recording can tell, what counts as found first.
///
/// The one that explains most is taken into the model before the others are tested again, so that a drift is not
/// told a second time as hysteresis. The residuals left over judge each ([`WeighedTerms`]).
pub(super) fn of(
    problem: &Problem<'_>,
    solved: &Solved,
    terms: &mut WeighedTerms<'_>,
) -> Vec<Misfit> {
    let Some(candidates) = candidates(problem, solved) else {
        return Vec::new();
    };
    let mut found: Vec<Misfit> = Vec::new();
    loop {
        let mut rest: Vec<(Misfit, &[Vec<f64>])> = Vec::new();
        for family in &candidates {
            if family
                .iter()
                .any(|(cause, _)| found.iter().any(|f| same_family(&f.cause, cause)))
            {
                continue;
            }
            let best = family
                .iter()
                .filter_map(|(cause, columns)| Some((cause, columns, terms.test(columns)?)))
                .min_by(|a, b| a.2.p_value.total_cmp(&b.2.p_value));
            let Some((cause, columns, test)) = best else {
                continue;
            };
            // The best of several shapes has had several chances.
            let p_value = (test.p_value * family.len() as f64).min(1.0);
            let amplitudes_mg = std::array::from_fn(|i| {
                1e3 * problem.gravity_share() * test.amplitudes.get(i).copied().unwrap_or(0.0)
            });
            let misfit = Misfit {
                cause: *cause,
                amplitudes_mg,
                p_value,
                found: p_value < LEVEL,
                detectable_mg: Some(
                    1e3 * problem.gravity_share() * test.found(LEVEL / family.len() as f64),
                )
                .filter(|size| size.is_finite()),
            };
            rest.push((misfit, columns));
        }
        let best = rest
            .iter()
            .filter(|(m, _)| m.found)
            .min_by(|a, b| a.0.p_value.total_cmp(&b.0.p_value));
        match best {
            Some((misfit, columns)) => {
                terms.accept(columns);
                found.push(*misfit);
            }
            None => {
                found.extend(rest.into_iter().map(|(m, _)| m));
                return found;
            }
        }
    }
}

fn same_family(a: &MisfitCause, b: &MisfitCause) -> bool {
    let of_time = |c: &MisfitCause| matches!(c, MisfitCause::Drift | MisfitCause::WarmUp { .. });
    std::mem::discriminant(a) == std::mem::discriminant(b) || (of_time(a) && of_time(b))
}

type Shape = (MisfitCause, Vec<Vec<f64>>);

/// Families of shapes; of each family one may be found.
fn candidates(problem: &Problem<'_>, solved: &Solved) -> Option<Vec<Vec<Shape>>> {
    let parameters = &solved.solution.parameters;
    let directions = problem.directions(parameters)?;
    let column = |error: &dyn Fn(usize) -> Triple| {
        problem.in_equations(parameters, &solved.weighting, error)
    };
    // One column per axis: an error of f(i, axis) of that axis.
    let per_axis = |f: &dyn Fn(usize, usize) -> f64| -> Option<Vec<Vec<f64>>> {
        (0..3)
            .map(|axis| {
                column(&|i| {
                    let mut error = [0.0; 3];
                    error[axis] = f(i, axis);
                    error
                })
            })
            .collect()
    };
    let mut families = Vec::new();
    if let Some(larger) = problem.model.larger(problem.attitudes.is_some()) {
        let free = problem.model.free_elements();
        let added = larger.free_elements().iter().filter(|e| !free.contains(e));
        let columns: Option<Vec<_>> = added
            .map(|&(row, of)| {
                column(&|i| {
                    let mut error = [0.0; 3];
                    error[row] = directions[i][of];
                    error
                })
            })
            .collect();
        families.push(vec![(MisfitCause::LargerModel { model: larger }, columns?)]);
    }
    let times: Option<Vec<f64>> = problem.poses.iter().map(|p| p.time).collect();
    if let Some((times, span)) = times.and_then(|t| span_of(&t).map(|s| (t, s))) {
        let start = times.iter().copied().fold(f64::INFINITY, f64::min);
        let mut shapes = vec![(
            MisfitCause::Drift,
            per_axis(&|i, _| (times[i] - start) / span - 0.5)?,
        )];
        for share in [16.0, 6.0, 2.5] {
            let time_constant = span / share;
            shapes.push((
                MisfitCause::WarmUp { time_constant },
                per_axis(&|i, _| (-(times[i] - start) / time_constant).exp())?,
            ));
        }
        families.push(shapes);
    }
    let temperatures: Option<Vec<f64>> = problem.poses.iter().map(|p| p.temperature).collect();
    if let Some((t, span)) = temperatures.and_then(|t| span_of(&t).map(|s| (t, s))) {
        let mean = t.iter().sum::<f64>() / t.len() as f64;
        families.push(vec![(
            MisfitCause::Temperature { span },
            per_axis(&|i, _| (t[i] - mean) / span)?,
        )]);
    }
    families.push(vec![(
        MisfitCause::Quadratic,
        per_axis(&|i, axis| directions[i][axis].powi(2))?,
    )]);
    families.push(vec![(
        MisfitCause::Cubic,
        per_axis(&|i, axis| directions[i][axis].powi(3))?,
    )]);
    if problem.poses.iter().all(|p| p.time.is_some()) {
        families.push(vec![(
            MisfitCause::LastMotion,
            per_axis(&|i, axis| last_motion(&directions, i, axis))?,
        )]);
    }
    Some(families)
}

fn span_of(values: &[f64]) -> Option<f64> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (high - low > 0.0).then_some(high - low)
}

impl Problem<'_> {
    /// Natural units are multiples of local gravity; sizes are told in those of standard gravity.
    pub(super) fn gravity_share(&self) -> f64 {
        self.gravity / STANDARD_GRAVITY
    }
}
