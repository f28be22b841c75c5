//! The budget file: inputs, their distributions and keys, and for a model of one's own the equations.

mod place;

use crate::{
    DegreesOfFreedom, Distribution, Evaluation, Expression, Input, Inputs, Model, Number, Refusal,
};
use place::Place;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// `budget.toml`: the inputs of a campaign.
///
/// ```
/// use proofmass_uncertainty::Budget;
/// let budget = Budget::parse(r#"
/// [[input]]
/// name = "reference"
/// unit = "1"
/// description = "calibration of the reference standard"
/// distribution = { kind = "normal", mean = 0.0, u = 0.003 }
/// varies_with = ["frequency"]
/// "#)?;
/// assert_eq!(budget.inputs()?.inputs().len(), 1);
///
/// let wrong = Budget::parse("[[input]]\nname = \"a\"\nunit = \"1\"\ncolour = \"red\"\n").unwrap_err();
/// assert!(wrong.to_string().starts_with("line 4: unknown field `colour`"));
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Title for the report.
    #[serde(default)]
    pub title: String,
    /// `[[input]]`
    #[serde(default, rename = "input")]
    pub input: Vec<InputEntry>,
    /// `[[correlation]]`
    #[serde(default, rename = "correlation")]
    pub correlation: Vec<CorrelationEntry>,
}

/// One `[[input]]`: a distribution, or observations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputEntry {
    /// Name, as in the equations.
    pub name: String,
    /// Unit; `1` for a pure number.
    pub unit: String,
    /// What it is, for a reader of the budget.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// What is known about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Repeated observations instead of a distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observations: Option<Vec<f64>>,
    /// Inputs with observations and the same word here were read together: their correlation counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub together: Option<String>,
    /// Keys of which each distinct value has its own draw.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub varies_with: Vec<String>,
    /// Degrees of freedom, when not those of the distribution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<DegreesOfFreedom>,
    /// Type A or B, when not as the distribution suggests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluation: Option<Evaluation>,
    /// What an error of it does to an observation, in the words of the kind of campaign; equations need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acts: Option<String>,
}

/// One `[[correlation]]` between two inputs or two draws of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrelationEntry {
    /// Two names, such as `["V", "I"]` or `["reference[frequency=10]", "reference[frequency=20]"]`.
    #[serde(deserialize_with = "two_names")]
    pub between: [String; 2],
    /// Correlation coefficient.
    pub coefficient: f64,
}

impl Budget {
    /// Reads a budget file.
    ///
    /// # Errors
    /// [`Refusal::File`] with line and field.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let budget: Self = read(text)?;
        // Distributions are judged here, where the line is still known.
        budget
            .inputs()
            .and_then(|inputs| inputs.single())
            .map_err(|refusal| {
                Place::of(&refusal, &budget.input, &budget.correlation, &[]).explain(text, refusal)
            })?;
        Ok(budget)
    }

    /// The inputs it describes.
    ///
    /// # Errors
    /// [`Refusal::File`] for an input with neither or both of distribution and observations,
    /// [`Refusal::Input`] for observations that do not do.
    pub fn inputs(&self) -> Result<Inputs, Refusal> {
        inputs(&self.input, &self.correlation)
    }
}

/// `MODEL.toml`: a budget with the equations of one measurement.
///
/// ```
/// use proofmass_uncertainty::{UncertaintyModel, Evaluate, Trials};
/// let model = UncertaintyModel::parse(r#"
/// title = "Density of a sphere"
/// [[input]]
/// name = "m"
/// unit = "kg"
/// distribution = { kind = "normal", mean = 0.0327, u = 0.00001 }
/// [[input]]
/// name = "d"
/// unit = "m"
/// observations = [0.02001, 0.02000, 0.02002, 0.02001]
/// [[intermediate]]
/// name = "V"
/// expression = "pi / 6 * d^3"
/// [[output]]
/// name = "rho"
/// unit = "kg/m³"
/// expression = "m / V"
/// "#)?;
/// let options = Evaluate { trials: Trials::Fixed(20_000), ..Evaluate::default() };
/// let result = model.evaluate(&options, &mut |_| std::ops::ControlFlow::Continue(()))?;
/// assert_eq!(result.outputs[0].quantity.to_string(), "7794.9(5.3) kg/m³");
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UncertaintyModel {
    /// Title for the report.
    #[serde(default)]
    pub title: String,
    /// `[[input]]`
    #[serde(default, rename = "input")]
    pub input: Vec<InputEntry>,
    /// `[[correlation]]`
    #[serde(default, rename = "correlation")]
    pub correlation: Vec<CorrelationEntry>,
    /// `[[intermediate]]`, each may use the ones above it.
    #[serde(default, rename = "intermediate")]
    pub intermediate: Vec<IntermediateEntry>,
    /// `[[output]]`, each may use the ones above it.
    #[serde(rename = "output")]
    pub output: Vec<OutputEntry>,
}

/// One `[[intermediate]]`: a part of the equations with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntermediateEntry {
    /// Name.
    pub name: String,
    /// Formula.
    pub expression: String,
}

/// One `[[output]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputEntry {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Formula.
    pub expression: String,
}

impl UncertaintyModel {
    /// Reads a model file.
    ///
    /// # Errors
    /// [`Refusal::File`] with line and field, also for an expression that cannot be read.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let model: Self = read(text)?;
        model
            .inputs()
            .and_then(|inputs| inputs.single())
            .and_then(|_| model.equations())
            .map_err(|refusal| model.explain(text, refusal))?;
        Ok(model)
    }

    /// A refusal of this model with the line of its text that it speaks of.
    pub fn explain(&self, text: &str, refusal: Refusal) -> Refusal {
        Place::of(&refusal, &self.input, &self.correlation, &self.formulas()).explain(text, refusal)
    }

    /// The inputs it describes.
    ///
    /// # Errors
    /// As [`Budget::inputs`].
    pub fn inputs(&self) -> Result<Inputs, Refusal> {
        inputs(&self.input, &self.correlation)
    }

    /// Every formula in the order of evaluation.
    fn formulas(&self) -> Vec<Formula<'_>> {
        let formula = |table, number, name, text| Formula {
            table,
            number,
            name,
            text,
        };
        let intermediate = self.intermediate.iter().enumerate();
        let output = self.output.iter().enumerate();
        intermediate
            .map(|(k, i)| formula("intermediate", k, i.name.as_str(), i.expression.as_str()))
            .chain(output.map(|(k, o)| formula("output", k, &o.name, &o.expression)))
            .collect()
    }

    /// The equations as a [`Model`], inputs in the order of the file.
    ///
    /// # Errors
    /// [`Refusal::Expression`], [`Refusal::Duplicate`].
    pub fn equations(&self) -> Result<Equations, Refusal> {
        let mut names: Vec<String> = self.input.iter().map(|i| i.name.clone()).collect();
        let formulas = self.formulas();
        let mut all = names
            .iter()
            .map(String::as_str)
            .chain(formulas.iter().map(|f| f.name));
        all.try_for_each(Expression::check_name)?;
        let mut steps = Vec::new();
        for formula in &formulas {
            if names.iter().any(|name| name == formula.name) {
                return Err(Refusal::Duplicate {
                    name: formula.name.to_owned(),
                });
            }
            steps.push(Expression::parse(formula.text, &names)?);
            names.push(formula.name.to_owned());
        }
        Ok(Equations {
            outputs: self
                .output
                .iter()
                .map(|o| (o.name.clone(), o.unit.clone()))
                .collect(),
            inputs: self.input.len(),
            steps,
        })
    }
}

/// One formula and where it stands in the file.
struct Formula<'a> {
    table: &'static str,
    number: usize,
    name: &'a str,
    text: &'a str,
}

/// Equations read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    outputs: Vec<(String, String)>,
    inputs: usize,
    steps: Vec<Expression>,
}

/// Names up to this many live on the stack during an evaluation.
const NAMES: usize = 24;

impl Model for Equations {
    fn outputs(&self) -> Vec<(String, String)> {
        self.outputs.clone()
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let total = self.inputs + self.steps.len();
        let mut near = [T::from(0.0); NAMES];
        let mut far = Vec::new();
        let values: &mut [T] = if total <= NAMES {
            &mut near[..total]
        } else {
            far.resize(total, T::from(0.0));
            &mut far
        };
        values[..self.inputs].copy_from_slice(&x[..self.inputs]);
        for (k, step) in self.steps.iter().enumerate() {
            let place = self.inputs + k;
            values[place] = step.evaluate(&values[..place]);
        }
        y.copy_from_slice(&values[total - y.len()..]);
    }
}

/// Exactly two: a third name would be passed over by the derived reader.
fn two_names<'de, D: serde::Deserializer<'de>>(reader: D) -> Result<[String; 2], D::Error> {
    let names = Vec::<String>::deserialize(reader)?;
    let count = names.len();
    names.try_into().map_err(|_| {
        serde::de::Error::custom(format!("two names are needed in `between`, not {count}"))
    })
}

fn read<'de, T: Deserialize<'de>>(text: &'de str) -> Result<T, Refusal> {
    toml::from_str(text).map_err(|error| Refusal::File {
        line: error.span().map(|span| place::line_at(text, span.start)),
        reason: error.message().to_owned(),
    })
}

fn inputs(entries: &[InputEntry], correlations: &[CorrelationEntry]) -> Result<Inputs, Refusal> {
    let mut inputs = Inputs::new();
    let mut order: Vec<Input> = Vec::new();
    for entry in entries {
        let distribution = match (&entry.distribution, &entry.observations) {
            (Some(distribution), None) => distribution.clone(),
            (None, Some(values)) => {
                Distribution::from_observations(values).map_err(|source| Refusal::Input {
                    name: entry.name.clone(),
                    source,
                })?
            }
            _ => {
                return Err(Refusal::Incomplete {
                    name: entry.name.clone(),
                    needed: "either `distribution` or `observations`, and not both,",
                });
            }
        };
        let mut input = Input::new(&entry.name, &entry.unit, distribution)
            .varies_with(entry.varies_with.clone());
        if let Some(text) = &entry.description {
            input = input.description(text);
        }
        if let Some(dof) = entry.dof {
            input = input.dof(dof);
        }
        if let Some(evaluation) = entry.evaluation {
            input = input.evaluation(evaluation);
        }
        order.push(input);
    }
    let mut words: Vec<&String> = entries.iter().filter_map(|e| e.together.as_ref()).collect();
    words.sort();
    words.dedup();
    for input in order {
        inputs = inputs.add(input);
    }
    for word in words {
        let set: Vec<usize> = (0..entries.len())
            .filter(|&i| entries[i].together.as_ref() == Some(word))
            .collect();
        let mut columns: Vec<&[f64]> = Vec::new();
        for &i in &set {
            let Some(values) = entries[i].observations.as_deref() else {
                return Err(Refusal::Incomplete {
                    name: entries[i].name.clone(),
                    needed: "beside `together`, `observations`",
                });
            };
            let expected = columns.first().map_or(values.len(), |c| c.len());
            if values.len() != expected {
                return Err(Refusal::Input {
                    name: entries[i].name.clone(),
                    source: Error::Length {
                        name: "observations read together with another input",
                        expected,
                        got: values.len(),
                    },
                });
            }
            columns.push(values);
        }
        inputs = inputs.observe_together(&set, &columns)?;
    }
    for entry in correlations {
        let [a, b] = &entry.between;
        inputs = inputs.correlate(a, b, entry.coefficient);
    }
    Ok(inputs)
}
