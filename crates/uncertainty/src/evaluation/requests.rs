//! What is asked beside the outputs: conformity, sweeps of an input, target uncertainties, draws.

use super::{Evaluate, ModelResult, OutputResult, Statement, StatementMethod};
use crate::model::Prepared;
use crate::{
    Conformity, ConformityEntry, DegreesOfFreedom, Interval, Limits, Measured, Model, MonteCarlo,
    Progress, Quantity, Refusal, SweepEntry, TargetEntry, Trials, UncertaintyModel, propagate,
};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Whether an output conforms, from the distribution that states it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OutputConformity {
    /// Name of the output.
    pub output: String,
    /// The limits of the requirement.
    pub limits: Limits,
    /// The decision with its risks.
    pub decision: Conformity,
}

/// The outputs for several estimates of an input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Sweep {
    /// Name of the input.
    pub input: String,
    /// One per estimate, in their order.
    pub points: Vec<SweepPoint>,
}

/// The outputs for one estimate of an input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SweepPoint {
    /// The estimate.
    pub estimate: f64,
    /// The outputs as they are stated; none where the model cannot be evaluated.
    pub outputs: Vec<Statement>,
    /// Why it cannot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

/// Which u of each input alone would bring an output to an expanded uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Target {
    /// Name of the output.
    pub output: String,
    /// Expanded uncertainty that is wanted.
    pub wanted: f64,
    /// Expanded uncertainty as it is.
    pub expanded: f64,
    /// One per input that is uncertain, in the order of the model.
    pub inputs: Vec<TargetInput>,
}

/// The uncertainty of one input that would bring an output to its target, all others as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TargetInput {
    /// Name of the input; all members of a vector together.
    pub input: String,
    /// Its standard uncertainty as it is; of a vector the largest.
    pub standard_uncertainty: f64,
    /// The standard uncertainty that is needed; none where no value of it reaches the target.
    pub needed: Option<f64>,
    /// Expanded uncertainty of the output with it; where the target is not reached, with the value that comes nearest: an
    /// input that is known, or 1000 times as uncertain.
    pub expanded: f64,
}

/// Trials of one calculation of a sweep or a target that may choose their number.
const TRIALS: usize = 200_000;
/// Uncertainty of an input is multiplied by no less and no more than this.
const FACTORS: [f64; 2] = [1e-9, 1e3];

impl UncertaintyModel {
    /// Budget, linear result, terms of second order, Monte Carlo check and verdict, in one call; and what the model asks
    /// beside its outputs.
    ///
    /// No road can take the result of another away: where one fails a finding says so and the others stand.
    /// `progress` is told how far the trials have come and may stop them.
    ///
    /// # Errors
    /// [`Refusal`] for inputs or expressions that do not do, for a model that is finite neither at the estimates nor
    /// in enough trials, or when cancelled.
    pub fn evaluate(
        &self,
        options: &Evaluate,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<ModelResult, Refusal> {
        let mut result = self.evaluate_outputs(options, progress)?;
        for entry in &self.conformity {
            let conformity = self.conformity(entry, options, &result)?;
            result.conformity.push(conformity);
        }
        let fewer = Evaluate {
            trials: match options.trials {
                Trials::Adaptive { digits, max } => Trials::Adaptive {
                    digits,
                    max: max.min(TRIALS),
                },
                fixed => fixed,
            },
            effects: false,
            ..*options
        };
        for entry in &self.sweep {
            result.sweeps.push(self.swept(entry, &fewer, progress)?);
        }
        for entry in &self.target {
            let target = self.targeted(entry, &fewer, &result, progress)?;
            result.targets.push(target);
        }
        Ok(result)
    }

    /// Makes the trials behind a result again, some thousand at a time: one column per output, in their order. A trial in
    /// which a formula is no finite number has it as it is.
    ///
    /// ```
    /// use proofmass_uncertainty::{Evaluate, UncertaintyModel, Trials};
    /// use std::ops::ControlFlow;
    /// let model: UncertaintyModel = toml::from_str(r#"
    /// input = [{ name = "x", unit = "1", value = 3.0, u = 0.5 }]
    /// output = [{ name = "y", unit = "1", expression = "x^2" }]
    /// "#).unwrap();
    /// let options = Evaluate { trials: Trials::Fixed(20_000), ..Evaluate::default() };
    /// let mean = model.evaluate(&options, &mut |_| ControlFlow::Continue(()))?.outputs[0].monte_carlo.as_ref().unwrap().mean;
    /// let (mut sum, mut count) = (0.0, 0);
    /// model.draws(&options, 20_000, &mut |columns| {
    ///     sum += columns[0].iter().sum::<f64>();
    ///     count += columns[0].len();
    ///     ControlFlow::Continue(())
    /// })?;
    /// assert!(count == 20_000 && (sum / 20_000.0 - mean).abs() < 1e-12);
    /// # Ok::<(), proofmass_uncertainty::Refusal>(())
    /// ```
    ///
    /// # Errors
    /// As [`UncertaintyModel::evaluate`]; [`Refusal::Cancelled`] where `each` breaks off.
    pub fn draws(
        &self,
        options: &Evaluate,
        trials: usize,
        each: &mut dyn FnMut(&[Vec<f64>]) -> ControlFlow<()>,
    ) -> Result<(), Refusal> {
        let Prepared {
            joint, equations, ..
        } = self.prepare()?;
        MonteCarlo::new(options.seed)
            .probability(options.probability)
            .draws(&equations, &joint, trials, each)
    }

    fn conformity(
        &self,
        entry: &ConformityEntry,
        options: &Evaluate,
        result: &ModelResult,
    ) -> Result<OutputConformity, Refusal> {
        let named = |error: Error| Refusal::Equation {
            name: entry.label(),
            what: error.to_string(),
        };
        let (place, output) = output(result, &entry.output)?;
        let stated = &output.stated;
        let measured = match (stated.method, stated.standard_uncertainty) {
            (StatementMethod::MonteCarlo, _) | (_, None) => {
                let mut trials = Vec::with_capacity(result.trials);
                self.draws(options, result.trials, &mut |columns| {
                    trials.extend(columns[place].iter().filter(|y| y.is_finite()));
                    ControlFlow::Continue(())
                })?;
                Measured::of_trials(stated.value, trials).map_err(named)?
            }
            (_, Some(u)) => Measured::of(&Quantity {
                name: stated.name.clone(),
                unit: stated.unit.clone(),
                value: stated.value,
                standard_uncertainty: u,
                dof: stated.dof.unwrap_or(DegreesOfFreedom::INFINITE),
            }),
        };
        let limits = entry.limits()?;
        let expanded = reach(stated.value, stated.interval);
        let decision = limits
            .decide(&measured, expanded, entry.rule()?, entry.prior.as_ref())
            .map_err(named)?;
        Ok(OutputConformity {
            output: entry.output.clone(),
            limits,
            decision,
        })
    }

    fn swept(
        &self,
        entry: &SweepEntry,
        options: &Evaluate,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Sweep, Refusal> {
        let mut points = Vec::with_capacity(entry.steps);
        for estimate in entry.estimates() {
            let model = self.with_estimate(&entry.input, estimate)?;
            let (outputs, refused) = match model.evaluate_outputs(options, progress) {
                Ok(result) => (result.outputs.into_iter().map(|o| o.stated).collect(), None),
                Err(Refusal::Cancelled) => return Err(Refusal::Cancelled),
                Err(refusal) => (Vec::new(), Some(refusal.to_string())),
            };
            points.push(SweepPoint {
                estimate,
                outputs,
                refused,
            });
        }
        Ok(Sweep {
            input: entry.input.clone(),
            points,
        })
    }

    fn targeted(
        &self,
        entry: &TargetEntry,
        options: &Evaluate,
        result: &ModelResult,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Target, Refusal> {
        let (_, output) = output(result, &entry.output)?;
        let linear = output.stated.method == StatementMethod::LawOfPropagation;
        let mut inputs = Vec::new();
        for (place, input) in self.input.iter().enumerate() {
            let mut u: f64 = 0.0;
            for member in input.members()? {
                u = u.max(member.input()?.distribution.standard_uncertainty());
            }
            if !(u > 0.0 && u.is_finite()) {
                continue;
            }
            let mut model = self.bare();
            let mut at = |factor: f64, fully: bool| -> Result<f64, Refusal> {
                model.input[place] = input.with_uncertainty_times(factor);
                if linear && !fully {
                    return model.expanded(&entry.output, options);
                }
                let result = model.evaluate_outputs(options, progress)?;
                let stated = &self::output(&result, &entry.output)?.1.stated;
                Ok(reach(stated.value, stated.interval))
            };
            let found = search(entry.expanded, |factor| at(factor, false))?;
            let expanded = at(found.factor, true)?;
            inputs.push(TargetInput {
                input: input.name.clone(),
                standard_uncertainty: u,
                needed: found.reached.then_some(u * found.factor),
                expanded,
            });
        }
        Ok(Target {
            output: entry.output.clone(),
            wanted: entry.expanded,
            expanded: reach(output.stated.value, output.stated.interval),
            inputs,
        })
    }

    /// U of an output by the law of propagation.
    fn expanded(&self, output: &str, options: &Evaluate) -> Result<f64, Refusal> {
        let Prepared {
            joint, equations, ..
        } = self.prepare()?;
        let names = equations.outputs();
        let place = names.iter().position(|(name, _)| name == output);
        let only: Vec<usize> = place.into_iter().collect();
        let linear = propagate(&equations.only(&only), &joint)?;
        let quantity = linear.get(output).ok_or_else(|| Refusal::Unknown {
            what: "output",
            name: output.to_owned(),
        })?;
        let k = options
            .coverage_factor
            .unwrap_or_else(|| quantity.coverage_factor(options.probability));
        Ok(k * quantity.standard_uncertainty)
    }
}

/// A factor of the uncertainty of an input, and whether it brings the output to the target.
struct Found {
    factor: f64,
    reached: bool,
}

/// Finds the factor with which U is the target, by bisection of a U that grows with it.
fn search(
    target: f64,
    mut expanded: impl FnMut(f64) -> Result<f64, Refusal>,
) -> Result<Found, Refusal> {
    let [mut low, mut high] = FACTORS;
    for (end, beyond) in [(low, true), (high, false)] {
        let there = expanded(end)?;
        if (there > target) == beyond {
            return Ok(Found {
                factor: end,
                reached: false,
            });
        }
    }
    // Twelve decades in steps of their logarithm, to six digits.
    while high / low > 1.0 + 1e-6 {
        let middle = (low * high).sqrt();
        if expanded(middle)? > target {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Found {
        factor: (low * high).sqrt(),
        reached: true,
    })
}

/// The longer side of an interval about the value: U where it is value ± U.
fn reach(value: f64, interval: Interval) -> f64 {
    (interval.upper - value).max(value - interval.lower)
}

/// An output with its place.
fn output<'a>(result: &'a ModelResult, name: &str) -> Result<(usize, &'a OutputResult), Refusal> {
    let mut outputs = result.outputs.iter().enumerate();
    outputs
        .find(|(_, output)| output.name == name)
        .ok_or_else(|| Refusal::Unknown {
            what: "output",
            name: name.to_owned(),
        })
}
