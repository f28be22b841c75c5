//! Everything a person expects of an uncertainty machine, from one model file.

use crate::{
    BudgetLine, CorrelationEntry, Covariance, Estimate, Finding, MonteCarlo, OutputEntry, Progress,
    Quantity, Refusal, Region, SampledOutput, SecondOrder, Severity, Trials, UncertaintyModel,
    Validation, Verdict, numerical_tolerance, propagate_second_order, scientific,
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
                max: 5_000_000,
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
    /// Correlations of the inputs, given or observed.
    pub input_correlations: Vec<CorrelationEntry>,
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
        let tolerances: Vec<f64> = linear
            .estimate()
            .quantities()
            .iter()
            .map(|q| numerical_tolerance(q.standard_uncertainty, options.digits))
            .collect();
        let monte_carlo = MonteCarlo::new(options.seed)
            .probability(options.probability)
            .trials(options.trials)
            .run_resolving(&equations, &joint, &tolerances, progress)
            .map_err(name_output)?;
        let validations = monte_carlo.validate(&linear, options.digits);
        let mut findings = self.doubtful_inputs();
        findings.extend(linear.findings().iter().cloned());
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
            findings.extend(verdict(&validation, entry, options));
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
            input_correlations: joint
                .correlations()
                .into_iter()
                .map(|(a, b, coefficient)| CorrelationEntry {
                    between: [a.to_owned(), b.to_owned()],
                    coefficient,
                })
                .collect(),
            region: monte_carlo.region,
            findings,
        })
    }
}

impl UncertaintyModel {
    /// What a careful reader would ask about the inputs themselves.
    fn doubtful_inputs(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for input in &self.input {
            let Some(values) = &input.observations else {
                continue;
            };
            if values.windows(2).all(|pair| pair[0] == pair[1]) {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "no-scatter",
                        format!("the observations of {} are all the same", input.name),
                    )
                    .evidence(format!("{} times {}", values.len(), values[0]))
                    .advice("add an input for the resolution of the instrument: rectangular, one digit wide"),
                );
            } else if values.len() < 4 {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "no-standard-deviation",
                        format!("{} has so few observations that its distribution has no standard deviation", input.name),
                    )
                    .evidence(format!("Student's t with ν = {}", values.len() - 1))
                    .advice("ignore the Monte Carlo u, which has no limit; the intervals stand. Better: four observations or more"),
                );
            }
        }
        findings
    }
}

/// What the verdict asks of the reader.
fn verdict(validation: &Validation, entry: &OutputEntry, options: &Evaluate) -> Option<Finding> {
    let unit = match entry.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let evidence = format!(
        "by {} and {}{unit} at the ends; {}{unit} is allowed for {} digits of u",
        scientific(validation.lower, 2),
        scientific(validation.upper, 2),
        scientific(validation.tolerance, 1),
        options.digits,
    );
    match validation.verdict {
        Verdict::Validated => None,
        Verdict::NotValidated => Some(
            Finding::new(
                Severity::Decision,
                "linear-result-not-validated",
                format!(
                    "the linear and the Monte Carlo interval of {} differ",
                    entry.name
                ),
            )
            .evidence(evidence)
            .advice("report the Monte Carlo interval"),
        ),
        Verdict::Undecided => Some(
            Finding::new(
                Severity::Warning,
                "monte-carlo-undecided",
                format!(
                    "the trials do not tell whether the linear interval of {} stands",
                    entry.name
                ),
            )
            .evidence(format!(
                "{evidence}, and the ends of the Monte Carlo interval scatter by {}{unit}",
                scientific(validation.scatter, 1)
            ))
            .advice("allow more trials, or ask for fewer digits"),
        ),
    }
}
