//! Propagation against Monte Carlo: does the stated interval hold for each term of S?

mod draws;
mod envelope;
mod estimator;
mod lanes;

use super::adjustment::Adjustment;
use super::budget::Budget;
use super::campaign::ShakerMethod;
use super::fit::{FrequencyFit, Supported, declared, frequency_fits};
use super::matrix::{AXES, row_times};
use super::observation::{PhasorRow, SpuriousTable, ascending};
use draws::Errors;
use estimator::Estimator;
use proofmass_core::Error;
use proofmass_uncertainty::findings;
use proofmass_uncertainty::{
    Finding, MonteCarlo, Progress, Quantity, Refusal, Severity, Trial, Trials, Validation, Verdict,
};
use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// One component of S in the comparison.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ComponentCheck {
    /// Component, such as `xx.re`.
    pub component: String,
    /// Standard uncertainty that is stated.
    pub linear: f64,
    /// Standard deviation of the trials; absent where it does not settle.
    pub monte_carlo: Option<f64>,
    /// 95 % interval that is stated, about the estimate.
    pub linear_interval: [f64; 2],
    /// Probabilistically symmetric 95 % interval of the trials, about the estimate.
    pub interval: [f64; 2],
    /// Numerical tolerance δ, what the ends differ by, how well the trials know them, and the verdict.
    pub validation: Validation,
}

/// Verdicts at one frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrequencyCheck {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Trials.
    pub trials: u64,
    /// One verdict for each of the 18 reals of S.
    pub components: Vec<ComponentCheck>,
}

impl FrequencyCheck {
    /// Components with a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        let same = |c: &&ComponentCheck| c.validation.verdict == verdict;
        self.components.iter().filter(same).count()
    }
}

/// How the check is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CheckOptions {
    /// Trials.
    pub trials: u64,
    /// Significant digits of u that the comparison is about.
    pub digits: u32,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for CheckOptions {
    /// 10 000 trials, one digit, seed 1.
    fn default() -> Self {
        Self {
            trials: 10_000,
            digits: 1,
            seed: 1,
        }
    }
}

/// Verdict of the Supplement 1 to the GUM, clause 8, for the 18 components of S at each frequency.
///
/// A method is first applied to the campaign; then, in every trial, a campaign of the S it found is made with an error
/// of every input of the budget, drawn from its distribution by the general engine with what shares it, with an error
/// of the measured spurious motion and of the sine approximations. Angles go through sines, products through products.
/// The estimator of the method is applied to it anew, until what is left of its steps is below 0.2 % of u. So the curvature of the model
/// and of the estimator, the shapes of the distributions and their degrees of freedom are all in the result.
///
/// Uncertainties are those that the runs support, as in the result, with the degrees of freedom that are declared: how well
/// the runs tell them is in the stated interval and not in the trials.
///
/// The interval of that budget is compared with that of the trials; δ is half a unit of the last of `digits` significant digits
/// of u, and a verdict that the number of trials cannot tell is left open.
///
/// **Accuracy** The weights of the runs are those of the expectation, and the derivatives by S follow the spurious motion
/// as a trial finds it, where the fit takes it as measured: a single trial ends within 0.1 u of the fit of its campaign,
/// within 0.01 u without the two.
///
/// **Source** `[S1]` 7.9.2, 8.
///
/// # Errors
/// As [`super::complex`]; [`Error::TooFew`] below 10⁴ trials, [`Error::OutOfRange`] for the published method, which has no
/// budget of this kind; [`Refusal::Cancelled`].
pub fn validate(
    method: ShakerMethod,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    options: &CheckOptions,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<FrequencyCheck>, Refusal> {
    if options.trials < 10_000 {
        return Err(Error::TooFew {
            name: "Monte Carlo trials",
            needed: 10_000,
            got: options.trials as usize,
        }
        .into());
    }
    match method {
        ShakerMethod::Joint => together(rows, spurious, budget, options, progress),
        ShakerMethod::Complex => {
            let frequencies = ascending(rows.iter().map(|r| r.frequency));
            let count = frequencies.len();
            let mut checks = vec![];
            for (index, f) in frequencies.into_iter().enumerate() {
                let here = rows.iter().filter(|r| r.frequency == f);
                let here: Vec<PhasorRow> = here.cloned().collect();
                let mut part = |p: Progress| {
                    progress(Progress {
                        done: index * p.most + p.done,
                        most: count * p.most,
                    })
                };
                checks.extend(together(&here, spurious, budget, options, &mut part)?);
            }
            Ok(checks)
        }
        ShakerMethod::PublishedMagnitude => Err(Error::OutOfRange {
            name: "method of the Monte Carlo check: the published one has no such budget",
            value: 0.0,
            min: 1.0,
            max: 2.0,
        }
        .into()),
    }
}

/// One adjustment of all these rows.
fn together(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    options: &CheckOptions,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<FrequencyCheck>, Refusal> {
    let (supported, stated) = propagated(rows, spurious, budget)?;
    let simulation = Simulation::new(
        &supported.rows,
        &supported.spurious,
        &supported.budget,
        &stated,
    )?;
    let sampled = MonteCarlo::new(options.seed)
        .trials(Trials::Fixed(options.trials as usize))
        .run_with(&simulation, simulation.errors.inputs(), progress)?;
    let trials = sampled.trials as u64;
    stated
        .iter()
        .map(|stated| {
            let quantities: Vec<Quantity> = stated
                .estimate
                .quantities()
                .into_iter()
                .enumerate()
                .map(|(p, q)| Quantity {
                    name: name(stated.frequency, p),
                    value: 0.0,
                    ..q
                })
                .collect();
            let us = quantities.iter().map(|q| q.standard_uncertainty);
            let largest = us.fold(0.0, f64::max);
            let validations = sampled.validate_quantities(&quantities, options.digits);
            let mut components = vec![];
            for (p, q) in quantities.iter().enumerate() {
                let Some(validation) = validations.iter().find(|v| v.name == q.name) else {
                    continue;
                };
                let Some(trials) = sampled.get(&q.name) else {
                    continue;
                };
                let half = q.expanded(super::derived::PROBABILITY);
                // The imaginary part of the term that phases are counted from is zero, and nothing is uncertain about it.
                let nothing = q.standard_uncertainty < 1e-5 * largest;
                let verdict = if nothing {
                    Verdict::Validated
                } else {
                    validation.verdict
                };
                components.push(ComponentCheck {
                    component: component(p),
                    linear: q.standard_uncertainty,
                    monte_carlo: trials.standard_uncertainty,
                    linear_interval: [-half, half],
                    interval: [trials.symmetric.lower, trials.symmetric.upper],
                    validation: Validation {
                        name: component(p),
                        verdict,
                        ..validation.clone()
                    },
                });
            }
            Ok(FrequencyCheck {
                frequency: stated.frequency,
                trials,
                components,
            })
        })
        .collect()
}

fn component(p: usize) -> String {
    let part = if p.is_multiple_of(2) { "re" } else { "im" };
    format!("{}{}.{part}", AXES[p / 6], AXES[p / 2 % 3])
}

fn name(frequency: f64, p: usize) -> String {
    format!("{frequency} Hz {}", component(p))
}

/// The result with the uncertainties that the runs support as if they were declared, and the runs with their budget.
fn propagated(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<(Supported, Vec<FrequencyFit>), Error> {
    let (declared, spurious) = declared(rows, spurious, budget)?;
    let supported = Supported::new(&declared, rows, &spurious, budget)?.taken_as_declared();
    let adjustment = supported.adjusted()?.unwrap_or(declared);
    let stated = frequency_fits(&adjustment, &supported)?;
    Ok((supported, stated))
}

/// Errors of a trial, then the estimator.
struct Simulation {
    errors: Errors,
    estimator: Estimator,
}

impl Simulation {
    /// Trials about the expectation: a noise-free campaign of the S that was found.
    fn new(
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
        fits: &[FrequencyFit],
    ) -> Result<Self, Refusal> {
        let exact: Vec<PhasorRow> = rows
            .iter()
            .map(|r| {
                let ratio = spurious
                    .get(r.configuration.inclination, r.frequency)
                    .map_or([num_complex::Complex64::new(0.0, 0.0); 3], |s| s.ratio);
                let m = r.configuration.matrix();
                let seen: [num_complex::Complex64; 3] = std::array::from_fn(|i| {
                    r.reference
                        * (m[i][2]
                            + (0..3)
                                .map(|k| m[i][k] * ratio[k])
                                .sum::<num_complex::Complex64>())
                });
                let fit = fits.iter().find(|f| f.frequency == r.frequency);
                fit.map_or_else(
                    || r.clone(),
                    |f| PhasorRow {
                        outputs: row_times(seen, &f.sensitivity),
                        ..r.clone()
                    },
                )
            })
            .collect();
        let adjustment = Adjustment::new(&exact, spurious, budget)?;
        Ok(Self {
            errors: Errors::new(&exact, spurious, budget)?,
            estimator: Estimator::new(&adjustment, &exact, spurious, budget)?,
        })
    }
}

impl Trial for Simulation {
    fn names(&self) -> Vec<(String, String)> {
        let of = |f: &f64| {
            (0..18)
                .map(|p| (name(*f, p), "V/(m/s²)".to_owned()))
                .collect::<Vec<_>>()
        };
        self.estimator.frequencies().iter().flat_map(of).collect()
    }

    fn trial(&self, x: &[f64], y: &mut [f64]) {
        let x: Vec<&[f64]> = x.chunks(1).collect();
        let mut y: Vec<&mut [f64]> = y.chunks_mut(1).collect();
        self.trials(&x, &mut y);
    }

    fn trials(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        pulp::Arch::new().dispatch(Batch {
            simulation: self,
            x,
            y,
        });
    }
}

/// Trials that are made side by side.
struct Batch<'a, 'y> {
    simulation: &'a Simulation,
    x: &'a [&'a [f64]],
    y: &'a mut [&'y mut [f64]],
}

impl WithSimd for Batch<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Simulation { errors, estimator } = self.simulation;
        let count = self.y.first().map_or(0, |y| y.len());
        for first in (0..count).step_by(S::F64_LANES) {
            let last = count.min(first + S::F64_LANES);
            let mut y: Vec<&mut [f64]> = self.y.iter_mut().map(|y| &mut y[first..last]).collect();
            let mut observed = Vec::new();
            for (row, s) in estimator.truths().enumerate() {
                observed.push(errors.observe(simd, row, self.x, first, s));
            }
            estimator.change(simd, observed, &mut y);
        }
    }
}

/// What the verdicts ask of the reader: where the stated interval does not hold the trials' is the result.
pub fn findings(checks: &[FrequencyCheck], digits: u32) -> Vec<Finding> {
    let with = |verdict: Verdict| -> Vec<(f64, &ComponentCheck)> {
        checks
            .iter()
            .flat_map(|c| c.components.iter().map(|v| (c.frequency, v)))
            .filter(|(_, v)| v.validation.verdict == verdict)
            .collect()
    };
    let total: usize = checks.iter().map(|c| c.components.len()).sum();
    let departure = |v: &ComponentCheck| v.validation.lower.max(v.validation.upper) / v.linear;
    let worst = |list: &[(f64, &ComponentCheck)]| {
        list.iter()
            .max_by(|a, b| departure(a.1).total_cmp(&departure(b.1)))
            .map_or(String::new(), |(f, v)| {
                format!(
                    "by {:.2} u at an end of S.{} at {f} Hz, where {:.2} u is allowed for {digits} digits of u",
                    departure(v),
                    v.component,
                    v.validation.tolerance / v.linear
                )
            })
    };
    let mut found = vec![];
    let wrong = with(Verdict::NotValidated);
    if !wrong.is_empty() {
        found.push(
            findings::linear_result_not_validated(
                &format!("{} of {total} components of S", wrong.len()),
                "the Monte Carlo interval",
                &format!("{}; monte-carlo.csv has both", worst(&wrong)),
            )
            .at(Severity::Decision),
        );
    }
    let open = with(Verdict::Undecided);
    if !open.is_empty() {
        found.push(findings::too_few_trials(
            &format!(
                "to check the linear interval of {} of {total} components of S",
                open.len()
            ),
            &worst(&open),
        ));
    }
    found
}

#[cfg(test)]
mod tests;
