//! What a model file asks beside its outputs: conformity, sweeps of an input, target uncertainties.

use super::{OutputEntry, UncertaintyModel};
use crate::{DecisionRule, Distribution, Limits, Refusal};
use serde::{Deserialize, Serialize};

/// One `[[conformity]]`: whether an output is within limits, for one decision rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ConformityEntry {
    /// Name of the output.
    pub output: String,
    /// Lower limit, in the unit of the output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Upper limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
    /// r of the guard band w = r U; none is simple acceptance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_band: Option<f64>,
    /// Least probability of conformity, instead of a guard band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_probability: Option<f64>,
    /// Distribution of the items that are measured, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<Distribution>,
}

/// One `[[sweep]]`: the outputs for several estimates of an input, all else as it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweepEntry {
    /// Name of the input, or of a member of a vector, `x[2]`.
    pub input: String,
    /// First estimate.
    pub from: f64,
    /// Last estimate.
    pub to: f64,
    /// Number of estimates, both ends counted.
    pub steps: usize,
}

/// One `[[target]]`: which u of each input alone would bring an output to an expanded uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TargetEntry {
    /// Name of the output.
    pub output: String,
    /// Expanded uncertainty that is wanted.
    #[serde(rename = "U")]
    pub expanded: f64,
}

/// Estimates of a sweep at most: each is a calculation of its own.
const MOST_STEPS: usize = 1000;

impl ConformityEntry {
    /// What its refusals call it.
    pub fn label(&self) -> String {
        format!("conformity of {}", self.output)
    }

    /// Its limits.
    pub(crate) fn limits(&self) -> Result<Limits, Refusal> {
        let limits = match (self.lower, self.upper) {
            (Some(lower), Some(upper)) => Limits::between(lower, upper),
            (Some(lower), None) => Limits::above(lower),
            (None, Some(upper)) => Limits::below(upper),
            (None, None) => {
                return Err(refuse(
                    self.label(),
                    "a `lower` or an `upper` limit is needed",
                ));
            }
        };
        limits.map_err(|error| refuse(self.label(), &error.to_string()))
    }

    /// Its rule.
    pub(crate) fn rule(&self) -> Result<DecisionRule, Refusal> {
        match (self.guard_band, self.least_probability) {
            (None, None) => Ok(DecisionRule::SimpleAcceptance),
            (Some(factor), None) if factor.is_finite() => Ok(DecisionRule::GuardBand { factor }),
            (None, Some(least)) if least > 0.0 && least < 1.0 => {
                Ok(DecisionRule::LeastProbability(least))
            }
            (Some(_), Some(_)) => Err(refuse(
                self.label(),
                "the rule is stated more than once: `guard_band` or `least_probability`",
            )),
            _ => Err(refuse(
                self.label(),
                "`guard_band` is a number, r of w = r U; `least_probability` lies between 0 and 1",
            )),
        }
    }
}

impl SweepEntry {
    /// What its refusals call it.
    pub fn label(&self) -> String {
        format!("sweep of {}", self.input)
    }

    /// The estimates.
    pub(crate) fn estimates(&self) -> impl Iterator<Item = f64> + '_ {
        let last = (self.steps - 1) as f64;
        (0..self.steps).map(move |k| {
            let share = k as f64 / last;
            self.from * (1.0 - share) + self.to * share
        })
    }
}

impl TargetEntry {
    /// What its refusals call it.
    pub fn label(&self) -> String {
        format!("target for {}", self.output)
    }
}

impl UncertaintyModel {
    /// Whether what is asked beside the outputs can be answered.
    pub(super) fn check_requests(&self, outputs: &[OutputEntry]) -> Result<(), Refusal> {
        let known = |name: &str, label: String| {
            if outputs.iter().any(|o| o.name == name) {
                return Ok(());
            }
            let names: Vec<&str> = outputs.iter().map(|o| o.name.as_str()).collect();
            let what = format!(
                "no output is called {name}; there are: {}",
                names.join(", ")
            );
            Err(refuse(label, &what))
        };
        for entry in &self.conformity {
            known(&entry.output, entry.label())?;
            entry.limits()?;
            entry.rule()?;
            if let Some(prior) = &entry.prior {
                let checked = prior.check();
                checked.map_err(|e| refuse(entry.label(), &format!("`prior`: {e}")))?;
            }
        }
        for entry in &self.target {
            known(&entry.output, entry.label())?;
            if !(entry.expanded > 0.0 && entry.expanded.is_finite()) {
                return Err(refuse(entry.label(), "`U` is a number above 0"));
            }
        }
        for entry in &self.sweep {
            if !(2..=MOST_STEPS).contains(&entry.steps) {
                let what = format!("`steps` is a number from 2 to {MOST_STEPS}");
                return Err(refuse(entry.label(), &what));
            }
            if !(entry.from.is_finite() && entry.to.is_finite() && entry.from != entry.to) {
                let what = "`from` and `to` are two different finite numbers";
                return Err(refuse(entry.label(), what));
            }
            self.with_estimate(&entry.input, entry.from)?;
        }
        Ok(())
    }

    /// The model without what it asks beside its outputs.
    pub(crate) fn bare(&self) -> Self {
        Self {
            conformity: Vec::new(),
            sweep: Vec::new(),
            target: Vec::new(),
            ..self.clone()
        }
    }

    /// The model with another estimate of an input, whose uncertainty moves with it.
    ///
    /// # Errors
    /// [`Refusal::Equation`] for an input that is not there, or a vector as a whole.
    pub(crate) fn with_estimate(&self, name: &str, estimate: f64) -> Result<Self, Refusal> {
        let label = || format!("sweep of {name}");
        let (input, member) = match name.split_once('[') {
            Some((input, rest)) => (input, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (name, None),
        };
        let mut model = self.bare();
        let Some(entry) = model.input.iter_mut().find(|i| i.name == input) else {
            let names: Vec<&str> = self.input.iter().map(|i| i.name.as_str()).collect();
            let what = format!("no input is called {name}; there are: {}", names.join(", "));
            return Err(refuse(label(), &what));
        };
        if let Some(values) = &mut entry.values {
            let count = values.len();
            let member = member.and_then(|k| values.get_mut(k.checked_sub(1)?));
            let Some(value) = member else {
                let what =
                    format!("{input} is a vector: name a member, {input}[1] to {input}[{count}]");
                return Err(refuse(label(), &what));
            };
            *value = estimate;
            return Ok(model);
        }
        if input != name {
            return Err(refuse(label(), &format!("{input} is no vector")));
        }
        entry.move_to(estimate)?;
        Ok(model)
    }
}

fn refuse(name: String, what: &str) -> Refusal {
    Refusal::Equation {
        name,
        what: what.to_owned(),
    }
}
