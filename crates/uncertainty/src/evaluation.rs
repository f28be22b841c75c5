//! Everything a person expects of an uncertainty machine, from one model: three roads, each by itself, and one result.

mod doubts;
mod passed;
mod requests;
mod statement;

pub use requests::{OutputConformity, Sweep, SweepPoint, Target, TargetInput};
pub use statement::{Method, Statement, StatementMethod};

use crate::model::Prepared;
use crate::{
    BudgetLine, CauseEffect, CorrelationEntry, Covariance, DegreesOfFreedom, Equations, Estimate,
    Finding, JointInputs, Linear, Model, MonteCarlo, OutputEntry, Progress, Quantity, Refusal,
    Region, Sampled, SampledOutput, SecondOrder, TrialTable, Trials, UncertaintyModel, Validation,
    Verdict, numerical_tolerance, propagate, propagate_second_order,
};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use statement::Roads;
use std::ops::ControlFlow;

/// What to compute.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Evaluate {
    /// By which road results are stated, where the model does not say or another is wanted. All roads are gone in any case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Coverage probability.
    pub probability: f64,
    /// A coverage factor to state results with, instead of the one that the probability and the degrees of freedom give: 2,
    /// where a customer or a standard asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage_factor: Option<f64>,
    /// Significant digits of u that are printed.
    pub digits: u32,
    /// Significant digits of u to which the linear and the Monte Carlo interval must agree. **Source** `[S1] 8.1`.
    pub check_digits: u32,
    /// Seed of the Monte Carlo check.
    pub seed: u64,
    /// Trials of the Monte Carlo check.
    pub trials: Trials,
    /// Whether the budget by Monte Carlo is made for every output, not only for those whose linear result does not stand.
    #[serde(skip_serializing_if = "is_false")]
    pub effects: bool,
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_false(value: &bool) -> bool {
    !value
}

impl Default for Evaluate {
    fn default() -> Self {
        Self {
            method: None,
            probability: 0.95,
            coverage_factor: None,
            digits: 2,
            check_digits: 1,
            seed: 1,
            trials: Trials::Adaptive {
                digits: 2,
                max: 5_000_000,
            },
            effects: false,
        }
    }
}

/// Trials of the budget by Monte Carlo, and evaluations of the model it may take.
const EFFECT_TRIALS: usize = 40_960;
const EFFECT_EVALUATIONS: usize = 8_000_000;

/// Inputs beyond which terms of second order are left out: their cost grows with the square.
const SECOND_ORDER: usize = 200;

/// One output by the law of propagation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LinearOutput {
    /// Value, standard uncertainty and degrees of freedom.
    pub quantity: Quantity,
    /// Coverage factor for the probability, from Student's t.
    pub coverage_factor: f64,
    /// Expanded uncertainty with it.
    pub expanded_uncertainty: f64,
    /// Budget, largest contribution first.
    pub budget: Vec<BudgetLine>,
    /// Terms of second order, where they exist.
    pub second_order: Option<SecondOrder>,
}

/// Result for one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OutputResult {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Formula, as in the model.
    pub expression: String,
    /// The result, by the road that was asked for.
    pub stated: Statement,
    /// By the law of propagation; absent where the model has no value or derivative at the estimates.
    pub linear: Option<LinearOutput>,
    /// By Monte Carlo; absent where the model is a number in almost no trial.
    pub monte_carlo: Option<SampledOutput>,
    /// Whether both agree; absent where there are not both.
    pub validation: Option<Validation>,
    /// Budget by Monte Carlo, largest total share first, where the linear one does not stand or it was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<CauseEffect>,
}

/// Result of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ModelResult {
    /// Title of the model.
    pub title: String,
    /// What was asked.
    pub options: Evaluate,
    /// One result per output.
    pub outputs: Vec<OutputResult>,
    /// All outputs with their joint covariance, by the law of propagation.
    pub estimate: Option<Estimate>,
    /// All outputs as they are stated, with their joint covariance and the causes behind them: what another calculation may
    /// take. Absent where an output has no standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stated: Option<Estimate>,
    /// Trials of the outputs, where one is not stated by the law of propagation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TrialTable>,
    /// Trials made.
    pub trials: usize,
    /// Joint covariance by Monte Carlo, of the outputs that have a Monte Carlo result.
    pub monte_carlo_covariance: Option<Covariance>,
    /// Correlations of the inputs, given or observed.
    pub input_correlations: Vec<CorrelationEntry>,
    /// Joint coverage region by Monte Carlo.
    pub region: Option<Region>,
    /// Whether outputs conform, where that was asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conformity: Vec<OutputConformity>,
    /// The outputs for several estimates of an input, where that was asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sweeps: Vec<Sweep>,
    /// Uncertainties of inputs for a wanted one of an output, where that was asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<Target>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl ModelResult {
    /// One output by name.
    pub fn get(&self, name: &str) -> Option<&OutputResult> {
        self.outputs.iter().find(|o| o.name == name)
    }
}

impl UncertaintyModel {
    /// The outputs, by three roads.
    fn evaluate_outputs(
        &self,
        options: &Evaluate,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<ModelResult, Refusal> {
        let options = &Evaluate {
            method: Some(options.method.unwrap_or(self.method)),
            ..*options
        };
        let Prepared {
            joint,
            equations,
            outputs: entries,
            findings: of_fits,
        } = self.prepare()?;
        let name_output = |refusal| name_output(&entries, refusal, joint.draws().len());
        let mut findings = self.doubtful_units();
        findings.extend(self.doubtful_inputs());
        let draws = joint.draws().iter();
        findings.extend(
            draws.filter_map(|d| doubts::resolution(&d.name, d.estimate, d.standard_uncertainty)),
        );
        findings.extend(of_fits);
        let (linear, refused) = linear_of_the_finite(&equations, &joint)?;
        let tolerances: Vec<f64> = entries
            .iter()
            .map(|o| {
                let quantity = linear.as_ref().and_then(|l| l.get(&o.name));
                let u = quantity.map_or(0.0, |q| q.standard_uncertainty);
                let z = crate::normal_quantile(0.5 * (1.0 + options.probability));
                numerical_tolerance(u, options.check_digits).min(crate::ENDS * z * u)
            })
            .collect();
        // What trials run: the same distributions with as few draws as they need.
        let reduced = equations.reduced(&joint)?;
        let (fewer, drawn) = match &reduced {
            Some((equations, joint)) => (equations, joint),
            None => (&equations, &joint),
        };
        let trials = match options.trials {
            Trials::Adaptive { digits, max } => Trials::Adaptive {
                digits,
                max: fewer.affordable(max, drawn.draws_per_trial()),
            },
            fixed => fixed,
        };
        let sampled = MonteCarlo::new(options.seed)
            .probability(options.probability)
            .trials(trials)
            .run_resolving(fewer, drawn, &tolerances, progress);
        let sampled = match sampled {
            Ok(sampled) => Ok(sampled),
            Err(Refusal::Core(error @ Error::NotFinite { .. })) => Err(name_output(error.into())),
            Err(other) => return Err(other),
        };
        let refused: Vec<Refusal> = refused.into_iter().map(|e| name_output(e.into())).collect();
        if let (None, Some(refusal), Err(_)) = (&linear, refused.first(), &sampled) {
            return Err(refusal.clone());
        }
        findings.extend(
            refused
                .iter()
                .map(|why| crate::findings::no_linear_result(&why.to_string())),
        );
        findings.extend(
            sampled
                .as_ref()
                .err()
                .map(|why| crate::findings::no_monte_carlo_result(&why.to_string())),
        );
        let sampled = sampled.ok();
        findings.extend(linear.iter().flat_map(|l| l.findings().iter().cloned()));
        let of_trials = sampled.iter().flat_map(|s| s.findings.iter().cloned());
        let (unstable, of_trials): (Vec<Finding>, Vec<Finding>) =
            of_trials.partition(|f| f.code() == "too-few-trials");
        findings.extend(of_trials);
        let validations = match (&linear, &sampled) {
            (Some(linear), Some(sampled)) => {
                let judged = sampled.validate(linear, options.check_digits);
                of_few_degrees(judged, linear, fewer, drawn, sampled.trials, options)?
            }
            _ => Vec::new(),
        };
        let mut outputs = Vec::new();
        for entry in &entries {
            let linear = linear
                .as_ref()
                .and_then(|l| linear_output(l, &entry.name, options));
            let monte_carlo = sampled.as_ref().and_then(|s| s.get(&entry.name)).cloned();
            let validation = validations.iter().find(|v| v.name == entry.name).cloned();
            let roads = Roads {
                linear: linear.as_ref(),
                sampled: monte_carlo.as_ref(),
                validation: validation.as_ref(),
                trials: sampled.as_ref().map_or(0, |s| s.trials),
            };
            let Some(stated) = roads.decide(entry, options) else {
                return Err(Refusal::Output {
                    name: entry.name.clone(),
                    what: match options.method {
                        Some(Method::Auto) | None => {
                            "not a finite number at the estimates nor in enough trials"
                        }
                        _ => "without a result by the method that is asked for",
                    },
                });
            };
            findings.extend(linear.as_ref().and_then(|l| {
                let q = &l.quantity;
                let u = q.standard_uncertainty;
                // What is left of contributions that cancel is rounding itself.
                let parts = l.budget.iter().map(|line| line.contribution.abs());
                let whole = u > 1e-6 * parts.fold(0.0, f64::max);
                doubts::resolution(&entry.name, q.value, u).filter(|_| whole)
            }));
            findings.extend(
                validation
                    .as_ref()
                    .and_then(|v| doubts::verdict(v, entry, options)),
            );
            outputs.push(OutputResult {
                name: entry.name.clone(),
                unit: entry.unit.clone(),
                expression: entry.expression.clone(),
                stated,
                linear,
                monte_carlo,
                validation,
                effects: Vec::new(),
            });
        }
        findings.extend(
            outputs
                .iter()
                .filter_map(|o| doubts::second_order(o, options)),
        );
        findings.extend(doubts::too_few(unstable.first(), &outputs, options));
        self.effects(&joint, &equations, options, &mut outputs, progress)?;
        let (stated, table) = passed::on(
            &mut outputs,
            linear.as_ref(),
            (&equations, &joint),
            (fewer, drawn),
            options,
        )?;
        let Sampled {
            trials,
            covariance,
            region,
            ..
        } = match sampled {
            Some(sampled) => sampled,
            None => Sampled::none(options.probability),
        };
        Ok(ModelResult {
            title: self.title.clone(),
            options: *options,
            outputs,
            estimate: linear.map(|l| l.estimate().clone()),
            stated,
            table,
            trials,
            monte_carlo_covariance: (covariance.dimension() > 0).then_some(covariance),
            input_correlations: joint
                .correlations()
                .into_iter()
                .map(|(a, b, coefficient)| CorrelationEntry {
                    between: [a.to_owned(), b.to_owned()],
                    coefficient,
                })
                .collect(),
            region,
            conformity: Vec::new(),
            sweeps: Vec::new(),
            targets: Vec::new(),
            findings,
        })
    }
}

impl UncertaintyModel {
    /// The budget by Monte Carlo, for the outputs whose shares of variance the linear one cannot tell.
    fn effects(
        &self,
        joint: &JointInputs,
        equations: &Equations,
        options: &Evaluate,
        outputs: &mut [OutputResult],
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<(), Refusal> {
        let wanted: Vec<usize> = (0..outputs.len())
            .filter(|&k| {
                let output = &outputs[k];
                let variance = |s: &SampledOutput| s.standard_uncertainty.is_some_and(|u| u > 0.0);
                let stands =
                    output.stated.method == StatementMethod::LawOfPropagation && !options.effects;
                !stands && output.monte_carlo.as_ref().is_some_and(variance)
            })
            .collect();
        let per_trial = 2 + 2 * joint.draws().len();
        // A set of draws serves all evaluations of its trial.
        let evaluations = equations.affordable(EFFECT_EVALUATIONS, 0);
        let trials = EFFECT_TRIALS.min(evaluations / per_trial);
        // Fewer would not tell one cause from another.
        if wanted.is_empty() || trials < 4096 {
            return Ok(());
        }
        let found =
            MonteCarlo::new(options.seed).effects(&equations.only(&wanted), joint, trials)?;
        for (k, effects) in wanted.into_iter().zip(found) {
            outputs[k].effects = effects.causes;
        }
        match progress(Progress {
            done: trials,
            most: trials,
        }) {
            ControlFlow::Break(()) => Err(Refusal::Cancelled),
            ControlFlow::Continue(()) => Ok(()),
        }
    }
}

/// Refuted linear results, looked at again with every standard uncertainty taken as known: where both roads agree then, only
/// the few degrees of freedom keep them apart, which Monte Carlo gives to Student's t of each input and the law of propagation to
/// that of the result.
fn of_few_degrees(
    mut judged: Vec<Validation>,
    linear: &Linear,
    equations: &Equations,
    joint: &JointInputs,
    trials: usize,
    options: &Evaluate,
) -> Result<Vec<Validation>, Refusal> {
    // Also where the difference would only matter to whoever reads the result.
    let refuted = |v: &Validation| v.refutes() || !v.passes_on();
    let doubtful = joint.inputs.iter().any(|i| !i.dof.is_infinite());
    let places: Vec<usize> = (0..equations.outputs().len())
        .filter(|&k| {
            let name = &equations.outputs()[k].0;
            judged.iter().any(|v| refuted(v) && v.name == *name)
        })
        .collect();
    if places.is_empty() || !doubtful {
        return Ok(judged);
    }
    let sampled = MonteCarlo::new(options.seed)
        .probability(options.probability)
        .trials(Trials::Fixed(trials))
        .run(&equations.only(&places), &joint.known());
    let sampled = match sampled {
        Ok(sampled) => sampled,
        Err(Refusal::Core(_)) => return Ok(judged),
        Err(other) => return Err(other),
    };
    let known: Vec<Quantity> = places
        .iter()
        .filter_map(|&k| linear.get(&equations.outputs()[k].0))
        .map(|q| Quantity {
            dof: DegreesOfFreedom::INFINITE,
            ..q
        })
        .collect();
    for again in sampled.validate_quantities(&known, options.check_digits) {
        for first in judged.iter_mut().filter(|v| v.name == again.name) {
            first.few_degrees_of_freedom =
                first.verdict != Verdict::Validated && again.verdict != Verdict::NotValidated;
            first.curvature = Some(again.relative);
        }
    }
    Ok(judged)
}

/// Says which output is not finite, by its name.
fn name_output(entries: &[OutputEntry], refusal: Refusal, inputs: usize) -> Refusal {
    let Refusal::Core(Error::NotFinite { name, index }) = refusal else {
        return refusal;
    };
    let (index, what) = match name {
        "model output" => (index, "not a finite number at the estimates of the inputs"),
        "model output in a trial" => (
            index,
            "not a finite number for almost all values that the distributions of the inputs allow",
        ),
        _ => (
            index / inputs.max(1),
            "no finite derivative at the estimates of the inputs",
        ),
    };
    match entries.get(index) {
        Some(output) => Refusal::Output {
            name: output.name.clone(),
            what,
        },
        None => refusal,
    }
}

/// The law of propagation for every output that has a value and derivatives at the estimates, and why the others
/// have none.
fn linear_of_the_finite(
    equations: &Equations,
    joint: &JointInputs,
) -> Result<(Option<Linear>, Vec<Error>), Refusal> {
    let inputs = joint.draws().len().max(1);
    let mut kept: Vec<usize> = (0..equations.outputs().len()).collect();
    let mut refused = Vec::new();
    while !kept.is_empty() {
        let part = equations.only(&kept);
        let linear = if joint.draws().len() <= SECOND_ORDER {
            propagate_second_order(&part, joint)
        } else {
            propagate(&part, joint)
        };
        match linear {
            Ok(linear) => return Ok((Some(linear), refused)),
            Err(Error::NotFinite { name, index }) => {
                // The place within the part, as one within the whole.
                let value = name == "model output";
                let which = if value { index } else { index / inputs };
                if which >= kept.len() {
                    return Err(Error::NotFinite { name, index }.into());
                }
                let output = kept.remove(which);
                refused.push(Error::NotFinite {
                    name,
                    index: if value { output } else { output * inputs },
                });
            }
            Err(other) => return Err(other.into()),
        }
    }
    Ok((None, refused))
}

fn linear_output(linear: &Linear, name: &str, options: &Evaluate) -> Option<LinearOutput> {
    let quantity = linear.get(name)?;
    let k = linear.estimate().index_of(name)?;
    Some(LinearOutput {
        coverage_factor: quantity.coverage_factor(options.probability),
        expanded_uncertainty: quantity.expanded(options.probability),
        quantity,
        budget: linear.budget(name)?.to_vec(),
        second_order: linear.second_order().get(k).copied().flatten(),
    })
}
