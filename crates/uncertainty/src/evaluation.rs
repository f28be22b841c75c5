//! Everything a person expects of an uncertainty machine, from one model file.

use crate::{
    BudgetLine, Covariance, Estimate, Finding, MonteCarlo, Progress, Quantity, Refusal, Region,
    SampledOutput, SecondOrder, Severity, Trials, UncertaintyModel, Validation, Verdict,
    propagate_second_order, scientific,
};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// What to compute.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluate {
    /// Coverage probability.
    pub probability: f64,
    /// Significant digits of u that are printed, and that the validation asks for.
    pub digits: u32,
    /// Seed of the Monte Carlo check.
    pub seed: u64,
    /// Trials of the Monte Carlo check.
    pub trials: Trials,
}

impl Default for Evaluate {
    fn default() -> Self {
        Self {
            probability: 0.95,
            digits: 2,
            seed: 1,
            trials: Trials::Adaptive {
                digits: 2,
                max: 2_000_000,
            },
        }
    }
}

/// Result for one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputResult {
    /// Value, standard uncertainty and degrees of freedom by the law of propagation.
    pub quantity: Quantity,
    /// Formula, as in the file.
    pub expression: String,
    /// Coverage factor.
    pub coverage_factor: f64,
    /// Expanded uncertainty.
    pub expanded_uncertainty: f64,
    /// Budget, largest contribution first.
    pub budget: Vec<BudgetLine>,
    /// Terms of second order.
    pub second_order: SecondOrder,
    /// Monte Carlo mean, u, intervals and histogram.
    pub monte_carlo: SampledOutput,
    /// Whether the linear result stands.
    pub validation: Validation,
}

/// Result of a model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelResult {
    /// Title of the model.
    pub title: String,
    /// What was asked.
    pub options: Evaluate,
    /// One result per output.
    pub outputs: Vec<OutputResult>,
    /// All outputs with their joint covariance, by the law of propagation.
    pub estimate: Estimate,
    /// Trials made.
    pub trials: usize,
    /// Joint covariance by Monte Carlo.
    pub monte_carlo_covariance: Covariance,
    /// Joint coverage region by Monte Carlo.
    pub region: Option<Region>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl UncertaintyModel {
    /// Says which output is not finite, by its name.
    fn name_output(&self, refusal: Refusal, inputs: usize) -> Refusal {
        let Refusal::Core(Error::NotFinite { name, index }) = refusal else {
            return refusal;
        };
        let (index, what) = match name {
            "model output" => (index, "not a finite number at the estimates of the inputs"),
            "model output in a trial" => (
                index,
                "not a finite number for some values that the distributions of the inputs allow",
            ),
            _ => (
                index / inputs.max(1),
                "no finite derivative at the estimates of the inputs",
            ),
        };
        match self.output.get(index) {
            Some(output) => Refusal::Output {
                name: output.name.clone(),
                what,
            },
            None => refusal,
        }
    }

    /// Budget, linear result, terms of second order, Monte Carlo check and verdict, in one call.
    ///
    /// `progress` is told how far the trials have come and may stop them.
    ///
    /// # Errors
    /// [`Refusal`] for inputs or expressions that do not do, for a model that is not finite, or when cancelled.
    pub fn evaluate(
        &self,
        options: &Evaluate,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<ModelResult, Refusal> {
        let joint = self.inputs()?.single()?;
        let equations = self.equations()?;
        let name_output = |refusal| self.name_output(refusal, joint.draws().len());
        let linear =
            propagate_second_order(&equations, &joint).map_err(|e| name_output(e.into()))?;
        let monte_carlo = MonteCarlo::new(options.seed)
            .probability(options.probability)
            .trials(options.trials)
            .run_with(&equations, &joint, progress)
            .map_err(name_output)?;
        let validations = monte_carlo.validate(&linear, options.digits);
        let mut findings = linear.findings().to_vec();
        findings.extend(monte_carlo.findings);
        let mut outputs = Vec::new();
        let sampled = monte_carlo
            .outputs
            .into_iter()
            .zip(validations)
            .zip(&self.output);
        for (k, ((sampled, validation), entry)) in sampled.enumerate() {
            let (Some(quantity), Some(budget)) =
                (linear.get(&entry.name), linear.budget(&entry.name))
            else {
                return Err(Refusal::Unknown {
                    what: "output",
                    name: entry.name.clone(),
                });
            };
            // An end of a normal 95 % interval from n trials scatters by 2.7 u/√n; `[S1] 8.2` wants it well below δ.
            let scatter = 2.7 * sampled.standard_uncertainty / (monte_carlo.trials as f64).sqrt();
            let blurred = scatter > 0.5 * validation.tolerance;
            if validation.verdict == Verdict::NotValidated {
                findings.push(
                    Finding::new(
                        Severity::Decision,
                        "linear-result-not-validated",
                        format!(
                            "the linear and the Monte Carlo interval of {} differ",
                            entry.name
                        ),
                    )
                    .evidence(format!(
                        "by {} and {} {unit} at the ends; {} is allowed for {} digits of u",
                        scientific(validation.lower, 2),
                        scientific(validation.upper, 2),
                        scientific(validation.tolerance, 2),
                        options.digits,
                        unit = if entry.unit == "1" { "" } else { &entry.unit },
                    ))
                    .advice(if blurred {
                        "allow more trials: the ends of the Monte Carlo interval scatter by more than is allowed"
                    } else {
                        "report the Monte Carlo interval"
                    }),
                );
            }
            outputs.push(OutputResult {
                coverage_factor: quantity.coverage_factor(options.probability),
                expanded_uncertainty: quantity.expanded(options.probability),
                quantity,
                expression: entry.expression.clone(),
                budget: budget.to_vec(),
                second_order: linear.second_order()[k],
                monte_carlo: sampled,
                validation,
            });
        }
        Ok(ModelResult {
            title: self.title.clone(),
            options: *options,
            outputs,
            estimate: linear.estimate().clone(),
            trials: monte_carlo.trials,
            monte_carlo_covariance: monte_carlo.covariance,
            region: monte_carlo.region,
            findings,
        })
    }
}
