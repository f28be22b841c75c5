//! One input of a model or budget, in the words of a laboratory.

use crate::{DegreesOfFreedom, Distribution, Evaluation, Input, Refusal};
use serde::{Deserialize, Serialize};

/// One `[[input]]`: a name, a unit, and one statement of what is known:
///
/// - `distribution`, `observations`, or `groups` of observations;
/// - `value` with `u`;
/// - `value` with `U` and `k` (a certificate), or `U`, `probability` and `dof`;
/// - `value` with `half_width` and perhaps `shape`;
/// - `value` with `accuracy` (a data sheet: percent of reading and of range);
/// - `value` with `resolution` (a display: rectangular, one digit wide);
/// - `value` alone: a constant.
///
/// `values` instead of `value` make it a vector. `file` with `column` takes readings, a vector or samples from a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
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
    /// Repeated observations in groups (days, operators, set-ups): the mean of the means of the groups, whose scatter
    /// tells u, with one degree of freedom less than there are groups. **Source** `[GUM] H.5`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups: Option<Vec<Vec<f64>>>,
    /// The estimate, with one of the statements below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The estimates of a vector; what is said beside them holds for each member by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// Standard uncertainties of the members of a vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_of_each: Option<Vec<f64>>,
    /// A table whose column holds the numbers, from the folder of the model file. Whoever reads the model file puts them
    /// in: [`InputEntry::fill`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Heading of the column of `file`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Heading of the column with the standard uncertainties of the members of a vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_column: Option<String>,
    /// What the column holds; readings when not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holds: Option<ColumnContent>,
    /// Standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Expanded uncertainty, as a certificate states it.
    #[serde(default, rename = "U", skip_serializing_if = "Option::is_none")]
    pub expanded: Option<f64>,
    /// Its coverage factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// Its probability, where no factor is stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Half-width of limits about the value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_width: Option<f64>,
    /// Shape between these limits: `rectangular` (as without it), `triangular`, `arcsine`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// Accuracy of an instrument after its data sheet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Smallest step of a display.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Inputs with the same word here were observed together: one covariance with one number of degrees of freedom.
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
    /// Standard uncertainty over frequency, in place of a distribution: pairs of frequency in Hz and u, ascending. Of a campaign on the
    /// shaker; equations need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_frequency: Option<Vec<[f64; 2]>>,
}

/// What a column of a file holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ColumnContent {
    /// Repeated observations of one quantity.
    #[default]
    Observations,
    /// The members of a vector.
    Values,
    /// Draws of one quantity, such as the states of a Markov chain.
    Samples,
}

/// Limits of error of an instrument as its data sheet states them: the sum of these parts, rectangular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Accuracy {
    /// Percent of the reading.
    pub reading_percent: f64,
    /// Percent of the range.
    pub range_percent: f64,
    /// The range, in the unit of the input.
    pub range: f64,
    /// A constant part, in the unit of the input.
    pub constant: f64,
}

impl Accuracy {
    /// Half-width of the limits at a reading.
    pub fn half_width(&self, reading: f64) -> f64 {
        (self.reading_percent * reading.abs() + self.range_percent * self.range.abs()) / 100.0
            + self.constant
    }

    /// The smallest of its parts.
    fn least(&self) -> f64 {
        self.reading_percent
            .min(self.range_percent)
            .min(self.constant)
    }
}

/// Members of a vector from a file at most: each is an input, and all have one covariance.
const MOST_MEMBERS: usize = 2000;

impl InputEntry {
    /// The input it describes.
    ///
    /// # Errors
    /// [`Refusal::Incomplete`] and [`Refusal::Contradiction`] for what does not make one statement,
    /// [`Refusal::Input`] for observations that do not do.
    pub fn input(&self) -> Result<Input, Refusal> {
        let mut input =
            Input::new(&self.name, &self.unit, self.known()?).varies_with(self.varies_with.clone());
        if let Some(text) = &self.description {
            input = input.description(text);
        }
        if let Some(dof) = self.dof {
            input = input.dof(dof);
        }
        if let Some(evaluation) = self.evaluation {
            input = input.evaluation(evaluation);
        }
        Ok(input)
    }

    /// Puts in the numbers of `file`: those of `column`, and of `u_column` where that is stated.
    ///
    /// # Errors
    /// [`Refusal::Contradiction`] where the numbers are stated beside it, or its keys do not go together.
    pub fn fill(&mut self, numbers: Vec<f64>, u: Option<Vec<f64>>) -> Result<(), Refusal> {
        let contradiction = |what| {
            Err(Refusal::Contradiction {
                name: self.name.clone(),
                what,
            })
        };
        let stated = self.observations.is_some()
            || self.groups.is_some()
            || self.value.is_some()
            || self.values.is_some()
            || self.u_of_each.is_some()
            || self.distribution.is_some();
        if stated {
            return contradiction("it is stated more than once: by its `file`, and beside it");
        }
        let content = self.holds.unwrap_or_default();
        if u.is_some() && content != ColumnContent::Values {
            return contradiction(
                "`u_column` belongs to the members of a vector: holds = \"values\"",
            );
        }
        if content == ColumnContent::Values && numbers.len() > MOST_MEMBERS {
            return contradiction(
                "a vector from a file has 2000 members at most; more rows are readings or samples",
            );
        }
        match content {
            ColumnContent::Observations => self.observations = Some(numbers),
            ColumnContent::Samples => {
                self.distribution = Some(Distribution::Samples { values: numbers });
            }
            ColumnContent::Values => (self.values, self.u_of_each) = (Some(numbers), u),
        }
        Ok(())
    }

    /// Members of a vector; absent for a single quantity.
    pub(super) fn length(&self) -> Option<usize> {
        self.values.as_ref().map(Vec::len)
    }

    /// One entry per number: itself, or the members of a vector as `x[1]`, `x[2]`, …
    pub(crate) fn members(&self) -> Result<Vec<Self>, Refusal> {
        let contradiction = |what| Refusal::Contradiction {
            name: self.name.clone(),
            what,
        };
        let Some(values) = &self.values else {
            return match self.u_of_each {
                Some(_) => Err(contradiction(
                    "`u_of_each` belongs to the `values` of a vector",
                )),
                None => Ok(vec![self.clone()]),
            };
        };
        let each = self.u_of_each.as_ref();
        if values.is_empty() || each.is_some_and(|u| u.len() != values.len()) {
            return Err(contradiction(
                "a vector needs at least one of `values`, and `u_of_each` as many as these",
            ));
        }
        if self.value.is_some() || (each.is_some() && self.u.is_some()) {
            return Err(contradiction(
                "it is stated more than once: `values` or `value`, `u_of_each` or `u`",
            ));
        }
        let member = |(k, &value): (usize, &f64)| Self {
            name: format!("{}[{}]", self.name, k + 1),
            value: Some(value),
            values: None,
            u: each.map_or(self.u, |u| u.get(k).copied()),
            u_of_each: None,
            ..self.clone()
        };
        Ok(values.iter().enumerate().map(member).collect())
    }

    /// Means of the groups of observations.
    pub(crate) fn means_of_groups(&self) -> Result<Option<Vec<f64>>, Refusal> {
        let Some(groups) = &self.groups else {
            return Ok(None);
        };
        if groups.len() < 2 || groups.iter().any(Vec::is_empty) {
            return Err(Refusal::Contradiction {
                name: self.name.clone(),
                what: "`groups` needs two groups at least, each with one observation at least",
            });
        }
        let mean = |group: &Vec<f64>| group.iter().sum::<f64>() / group.len() as f64;
        Ok(Some(groups.iter().map(mean).collect()))
    }

    /// The one statement, as a distribution.
    fn known(&self) -> Result<Distribution, Refusal> {
        let contradiction = |what| Refusal::Contradiction {
            name: self.name.clone(),
            what,
        };
        if self.file.is_none()
            && (self.column.is_some() || self.u_column.is_some() || self.holds.is_some())
        {
            return Err(contradiction(
                "`column`, `u_column` and `holds` belong to a table given by `file`",
            ));
        }
        let filled =
            self.observations.is_some() || self.value.is_some() || self.distribution.is_some();
        if self.file.is_some() && !filled {
            return Err(Refusal::Incomplete {
                name: self.name.clone(),
                needed: "the numbers of its `file`, which whoever reads the model file puts in,",
            });
        }
        let spreads = [
            self.u.is_some(),
            self.expanded.is_some(),
            self.half_width.is_some(),
            self.accuracy.is_some(),
            self.resolution.is_some(),
        ];
        let stated = spreads.iter().filter(|s| **s).count();
        if self.expanded.is_none() && (self.k.is_some() || self.probability.is_some()) {
            return Err(contradiction(
                "`k` and `probability` belong to an expanded uncertainty `U`",
            ));
        }
        if self.half_width.is_none() && self.shape.is_some() {
            return Err(contradiction(
                "`shape` belongs to limits given by `half_width`",
            ));
        }
        let means = self.means_of_groups()?;
        if means.is_some() && self.observations.is_some() {
            return Err(contradiction(
                "it is stated more than once: `observations` and `groups`",
            ));
        }
        let observations = means.as_ref().or(self.observations.as_ref());
        match (&self.distribution, observations, self.value) {
            (Some(distribution), None, None) if stated == 0 => Ok(distribution.clone()),
            (None, Some(values), None) if stated == 0 => Distribution::from_observations(values)
                .map_err(|source| Refusal::Input {
                    name: self.name.clone(),
                    source,
                }),
            (None, None, Some(value)) if stated <= 1 => self.about(value),
            (None, None, Some(_)) => Err(contradiction(
                "only one of `u`, `U`, `half_width`, `accuracy` and `resolution` can be its uncertainty; more are inputs \
                 of their own",
            )),
            (None, None, None) if stated > 0 => Err(Refusal::Incomplete {
                name: self.name.clone(),
                needed: "a `value`",
            }),
            (None, None, None) => Err(Refusal::Incomplete {
                name: self.name.clone(),
                needed: "a `distribution`, `observations`, `groups`, `values` or a `value` with its uncertainty",
            }),
            _ => Err(contradiction(
                "it is stated more than once: one of `distribution`, `observations` and `value` with its uncertainty",
            )),
        }
    }

    fn about(&self, value: f64) -> Result<Distribution, Refusal> {
        let spreads = [
            ("`u` must not be negative", self.u),
            ("`U` must not be negative", self.expanded),
            ("`half_width` must not be negative", self.half_width),
            ("`resolution` must not be negative", self.resolution),
            (
                "`accuracy` must not be negative",
                self.accuracy.as_ref().map(Accuracy::least),
            ),
        ];
        if let Some((what, _)) = spreads.iter().find(|(_, s)| s.is_some_and(|s| s < 0.0)) {
            return Err(Refusal::Contradiction {
                name: self.name.clone(),
                what,
            });
        }
        let limits = |half: f64| (value - half, value + half);
        if let Some(expanded) = self.expanded {
            let k = match (self.k, self.probability) {
                (Some(k), None) if k > 0.0 => k,
                (None, Some(p)) if p > 0.0 && p < 1.0 => self
                    .dof
                    .unwrap_or(DegreesOfFreedom::INFINITE)
                    .coverage_factor(p),
                _ => {
                    return Err(Refusal::Contradiction {
                        name: self.name.clone(),
                        what: "`U` needs its factor `k` above 0 or its `probability` between 0 and 1",
                    });
                }
            };
            return Ok(Distribution::Normal {
                mean: value,
                u: expanded / k,
            });
        }
        let (lower, upper) = match (self.half_width, &self.accuracy, self.resolution) {
            (Some(half), _, _) => limits(half),
            (_, Some(accuracy), _) => limits(accuracy.half_width(value)),
            (_, _, Some(step)) => limits(0.5 * step),
            _ => {
                return Ok(Distribution::Normal {
                    mean: value,
                    u: self.u.unwrap_or(0.0),
                });
            }
        };
        match self.shape.as_deref() {
            None | Some("rectangular") => Ok(Distribution::Rectangular { lower, upper }),
            Some("triangular") => Ok(Distribution::Triangular { lower, upper }),
            Some("arcsine") => Ok(Distribution::Arcsine { lower, upper }),
            Some(_) => Err(Refusal::Contradiction {
                name: self.name.clone(),
                what: "`shape` is one of rectangular, triangular and arcsine",
            }),
        }
    }
}
