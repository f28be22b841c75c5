//! A measurement model and a budget as plain data: inputs, what is known of them, and the equations.

mod compile;
mod curve;
mod earlier;
mod entries;
mod equations;
mod fit;
mod input_entry;
mod prepared;
mod reduced;
mod requests;
mod solve;
mod units;
mod varied;

pub use earlier::EarlierEntry;
pub use entries::{FitEntry, FitScatter, FitWeights, IntermediateEntry, OutputEntry, SolveEntry};
pub use equations::Equations;
pub use input_entry::{Accuracy, ColumnContent, InputEntry};
pub(crate) use prepared::Prepared;
pub use requests::{ConformityEntry, SweepEntry, TargetEntry};
pub use units::UnitRule;

use crate::{Distribution, Inputs, JointReadings, Method, Refusal};
use serde::{Deserialize, Serialize};

/// The inputs of a campaign: `budget.toml`, as data.
///
/// ```
/// use proofmass_uncertainty::BudgetEntries;
/// let budget: BudgetEntries = toml::from_str(r#"
/// [[input]]
/// name = "reference"
/// unit = "1"
/// description = "calibration of the reference standard"
/// distribution = { kind = "normal", mean = 0.0, u = 0.003 }
/// varies_with = ["frequency"]
/// "#).unwrap();
/// assert_eq!(budget.inputs()?.inputs().len(), 1);
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct BudgetEntries {
    /// Title for the report.
    #[serde(default)]
    pub(crate) title: String,
    /// `[[input]]`
    #[serde(default, rename = "input")]
    pub input: Vec<InputEntry>,
    /// `[[correlation]]`
    #[serde(default, rename = "correlation")]
    pub correlation: Vec<CorrelationEntry>,
}

/// One `[[correlation]]` between two inputs or two draws of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct CorrelationEntry {
    /// Two names, such as `["V", "I"]` or `["reference[frequency=10]", "reference[frequency=20]"]`.
    #[serde(deserialize_with = "two_names")]
    pub between: [String; 2],
    /// Correlation coefficient.
    pub coefficient: f64,
}

impl BudgetEntries {
    /// The inputs it describes.
    ///
    /// # Errors
    /// [`Refusal::Incomplete`] for an input of which nothing or too much is said, [`Refusal::Input`] for observations
    /// or a distribution that do not do.
    pub fn inputs(&self) -> Result<Inputs, Refusal> {
        inputs(&self.input, &self.correlation, JointReadings::Gum)
    }
}

/// The equations of one measurement with what is known of its inputs: `MODEL.toml`, as data.
///
/// ```
/// use proofmass_uncertainty::{UncertaintyModel, Evaluate, Trials};
/// let model: UncertaintyModel = toml::from_str(r#"
/// title = "Density of a sphere"
/// [[input]]
/// name = "m"
/// unit = "kg"
/// value = 0.0327
/// U = 0.00002
/// k = 2
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
/// "#).unwrap();
/// let options = Evaluate { trials: Trials::Fixed(20_000), ..Evaluate::default() };
/// let result = model.evaluate(&options, &mut |_| std::ops::ControlFlow::Continue(()))?;
/// let rho = result.outputs[0].linear.as_ref().unwrap();
/// assert_eq!(rho.quantity.to_string(), "7794.9(5.3) kg/m³");
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct UncertaintyModel {
    /// Title for the report.
    #[serde(default)]
    pub title: String,
    /// By which road results are stated.
    #[serde(default, skip_serializing_if = "is_default")]
    pub method: Method,
    /// How readings made together are stated.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) joint_readings: JointReadings,
    /// Whether units are converted.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) units: UnitRule,
    /// `[[input]]`
    #[serde(default, rename = "input")]
    pub input: Vec<InputEntry>,
    /// `[[correlation]]`
    #[serde(default, rename = "correlation")]
    pub correlation: Vec<CorrelationEntry>,
    /// `[[earlier]]`: quantities of earlier results.
    #[serde(default, rename = "earlier", skip_serializing_if = "Vec::is_empty")]
    pub earlier: Vec<EarlierEntry>,
    /// `[[intermediate]]`, each may use the others as long as none needs itself.
    #[serde(
        default,
        rename = "intermediate",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub intermediate: Vec<IntermediateEntry>,
    /// `[[solve]]`: equations to solve.
    #[serde(default, rename = "solve", skip_serializing_if = "Vec::is_empty")]
    pub solve: Vec<SolveEntry>,
    /// `[[fit]]`: least squares.
    #[serde(default, rename = "fit", skip_serializing_if = "Vec::is_empty")]
    pub fit: Vec<FitEntry>,
    /// `[[output]]`, each may use the ones above it.
    #[serde(rename = "output")]
    pub output: Vec<OutputEntry>,
    /// `[[conformity]]`: whether outputs are within limits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conformity: Vec<ConformityEntry>,
    /// `[[sweep]]`: the outputs for several estimates of an input.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sweep: Vec<SweepEntry>,
    /// `[[target]]`: which u of each input would bring an output to a U.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub target: Vec<TargetEntry>,
}

impl UncertaintyModel {
    /// The inputs it describes.
    ///
    /// # Errors
    /// As [`BudgetEntries::inputs`]; also for what only the budget of a campaign may say.
    pub fn inputs(&self) -> Result<Inputs, Refusal> {
        let odd = self
            .input
            .iter()
            .find(|i| !i.varies_with.is_empty() || i.acts.is_some() || i.over_frequency.is_some());
        if let Some(input) = odd {
            return Err(Refusal::Contradiction {
                name: input.name.clone(),
                what: "`varies_with`, `acts` and `over_frequency` belong to the budget of a campaign; in a model of one \
                       measurement they would be ignored",
            });
        }
        let entries = self.scalar_inputs()?;
        let earlier = earlier::Earlier::of(&self.earlier, &entries)?;
        // Coefficients may also name the causes of earlier results.
        let mut all = inputs(&entries, &[], self.joint_readings)?;
        all = earlier.beside(all)?;
        for entry in &self.correlation {
            let [a, b] = &entry.between;
            all = all.correlate(a, b, entry.coefficient);
        }
        Ok(all)
    }

    /// The equations as a [`Model`](crate::Model), inputs in the order of the model. Fits and equations to solve need
    /// their inputs: [`UncertaintyModel::prepared`].
    ///
    /// # Errors
    /// [`Refusal::Expression`], [`Refusal::Duplicate`], [`Refusal::Name`], [`Refusal::Equation`].
    pub fn equations(&self) -> Result<Equations, Refusal> {
        Ok(self.compiled()?.equations())
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Exactly two: a third name would be passed over by the derived reader.
fn two_names<'de, D: serde::Deserializer<'de>>(reader: D) -> Result<[String; 2], D::Error> {
    let names = Vec::<String>::deserialize(reader)?;
    let count = names.len();
    names.try_into().map_err(|_| {
        serde::de::Error::custom(format!("two names are needed in `between`, not {count}"))
    })
}

fn inputs(
    entries: &[InputEntry],
    correlations: &[CorrelationEntry],
    rule: JointReadings,
) -> Result<Inputs, Refusal> {
    let mut inputs = Inputs::new();
    for entry in entries {
        inputs = inputs.add(entry.input()?);
    }
    let mut words: Vec<&String> = entries.iter().filter_map(|e| e.together.as_ref()).collect();
    words.sort();
    words.dedup();
    for word in words {
        let set: Vec<usize> = (0..entries.len())
            .filter(|&i| entries[i].together.as_ref() == Some(word))
            .collect();
        if let [lonely] = set[..] {
            return Err(Refusal::Contradiction {
                name: entries[lonely].name.clone(),
                what: "no other input has its word in `together`: is it misspelt?",
            });
        }
        let columns: Vec<Option<&[f64]>> = set
            .iter()
            .map(|&i| entries[i].observations.as_deref())
            .collect();
        let sampled =
            |&i: &usize| matches!(entries[i].distribution, Some(Distribution::Samples { .. }));
        if set.iter().all(sampled) {
            inputs = inputs.sampled_together(&set)?;
            continue;
        }
        if columns.iter().all(Option::is_none) {
            let names: Vec<&str> = set.iter().map(|&i| entries[i].name.as_str()).collect();
            inputs = inputs.ensemble(&names)?;
            continue;
        }
        let mut readings: Vec<&[f64]> = Vec::new();
        for (&i, column) in set.iter().zip(columns) {
            let Some(values) = column else {
                return Err(Refusal::Incomplete {
                    name: entries[i].name.clone(),
                    needed: "with `together`, `observations` as of the others",
                });
            };
            let expected = readings.first().map_or(values.len(), |c| c.len());
            if values.len() != expected {
                return Err(Refusal::Input {
                    name: entries[i].name.clone(),
                    source: proofmass_core::Error::Length {
                        name: "observations read together with another input",
                        expected,
                        got: values.len(),
                    },
                });
            }
            readings.push(values);
        }
        inputs = inputs.observe_together(rule, &set, &readings)?;
    }
    for entry in correlations {
        let [a, b] = &entry.between;
        inputs = inputs.correlate(a, b, entry.coefficient);
    }
    Ok(inputs)
}
