//! Inputs, the keys they vary with, and the joint covariance that follows from them.

mod check;
mod joint;

pub(crate) use joint::Cluster;
pub use joint::{Draw, JointInputs};

use crate::{DegreesOfFreedom, Distribution, Evaluation, Refusal};
use proofmass_core::Error;
use proofmass_core::numeric::dot;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};

/// One input quantity: what is known about it and what it varies with.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) description: String,
    pub(crate) evaluation: Evaluation,
    pub(crate) distribution: Distribution,
    pub(crate) dof: DegreesOfFreedom,
    pub(crate) varies_with: Vec<String>,
}

impl Input {
    /// An input that varies with nothing: one draw for the whole campaign.
    pub fn new(
        name: impl Into<String>,
        unit: impl Into<String>,
        distribution: Distribution,
    ) -> Self {
        let evaluation = match distribution {
            Distribution::StudentT { .. } => Evaluation::A,
            _ => Evaluation::B,
        };
        let name = name.into();
        Self {
            description: name.clone(),
            name,
            unit: unit.into(),
            evaluation,
            dof: distribution.dof(),
            distribution,
            varies_with: Vec::new(),
        }
    }

    /// One independent draw per distinct value of these keys.
    #[must_use]
    pub fn varies_with<K: Into<String>>(mut self, keys: impl IntoIterator<Item = K>) -> Self {
        self.varies_with = keys.into_iter().map(Into::into).collect();
        self
    }

    /// Degrees of freedom of the standard uncertainty, when they are not those of the distribution (a
    /// rectangular width that is itself doubtful: `[GUM] G.4.2`).
    #[must_use]
    pub fn dof(mut self, dof: DegreesOfFreedom) -> Self {
        self.dof = dof;
        self
    }

    /// What it is, for a reader of the budget.
    #[must_use]
    pub fn description(mut self, description: impl Into<String>) -> Self {
        self.description = description.into();
        self
    }

    /// Type A or type B; by default A for Student t, B otherwise.
    #[must_use]
    pub fn evaluation(mut self, evaluation: Evaluation) -> Self {
        self.evaluation = evaluation;
        self
    }

    /// Its estimate.
    pub fn estimate(&self) -> f64 {
        self.distribution.estimate()
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What a trial draws, and what its finite degrees of freedom add to that.
    ///
    /// A normal or Student t is a Student t with the degrees of freedom of the input. **Source** `[S1] 6.4.9.7`.
    /// Doubtful limits are those of the curvilinear trapezoid: half-widths anywhere within a (1 ± √(3/(2ν))), for which
    /// ν = ½ (Δu/u)⁻². **Source** `[S1] 6.4.3`, `[GUM] G.4.2`.
    #[cfg(feature = "monte-carlo")]
    pub(crate) fn drawn_from(&self) -> (Distribution, Doubt) {
        let nu = self.dof.get();
        match (&self.distribution, self.dof.is_infinite()) {
            (
                Distribution::StudentT {
                    location, scale, ..
                },
                true,
            ) => (
                Distribution::Normal {
                    mean: *location,
                    u: *scale,
                },
                Doubt::None,
            ),
            (
                Distribution::Normal {
                    mean: location,
                    u: scale,
                }
                | Distribution::StudentT {
                    location, scale, ..
                },
                false,
            ) => (
                Distribution::StudentT {
                    location: *location,
                    scale: *scale,
                    dof: nu,
                },
                Doubt::None,
            ),
            (other, true) => (other.clone(), Doubt::None),
            // The same doubt, stated already.
            (other @ Distribution::CurvilinearTrapezoid { inexactness, .. }, _)
                if *inexactness > 0.0 =>
            {
                (other.clone(), Doubt::None)
            }
            (other, false) if other.is_bounded() => {
                (other.clone(), Doubt::Limits((1.5 / nu).sqrt().min(1.0)))
            }
            (other, false) => (other.clone(), Doubt::Scale(nu)),
        }
    }
}

/// What finite degrees of freedom do to a draw that is no Student t: it is stretched about its estimate.
#[cfg(feature = "monte-carlo")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Doubt {
    /// Nothing.
    None,
    /// By √(ν/χ²_ν), as the normal becomes Student t.
    Scale(f64),
    /// By a factor anywhere in 1 ± this.
    Limits(f64),
}

/// How the joint covariance of quantities that were read together n times is stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum JointReadings {
    /// Scatter over n − 1, and ν = n − 1 for the covariance as a whole. **Source** `[GUM] H.2`.
    #[default]
    Gum,
    /// Scatter over n − N for N quantities, and ν = n − N: the multivariate t of the Bayesian analysis. **Source**
    /// `[S2] 5.3.2`.
    #[serde(rename = "jcgm-102")]
    Jcgm102,
}

/// The values of the keys for one observation: frequency, channel, run, …
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels(BTreeMap<String, String>);

impl Labels {
    /// No key has a value.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the value of one key.
    #[must_use]
    pub fn with(mut self, key: impl Into<String>, value: impl ToString) -> Self {
        self.0.insert(key.into(), value.to_string());
        self
    }
}

/// The inputs of a campaign and the correlations between them.
///
/// One independent draw exists per distinct value of the keys an input varies with; observations that share the
/// values share the draw. Everything about correlation follows from that.
///
/// ```
/// use proofmass_uncertainty::{Distribution, Input, Inputs, Labels};
///
/// let inputs = Inputs::new()
///     .add(Input::new("reference", "1", Distribution::Normal { mean: 1.0, u: 0.003 }).varies_with(["frequency"]))
///     .add(Input::new("reading", "1", Distribution::Normal { mean: 0.0, u: 0.004 }).varies_with(["frequency", "run"]));
/// let runs = [
///     Labels::new().with("frequency", 10).with("run", 1),
///     Labels::new().with("frequency", 10).with("run", 2),
///     Labels::new().with("frequency", 20).with("run", 1),
/// ];
/// let joint = inputs.joint(&runs)?;
/// assert_eq!(joint.draws().len(), 2 + 3);
///
/// // Each observation is reference + reading: the reference is common to the two runs at 10 Hz.
/// let c = joint.observation_covariance(&[1.0; 6])?;
/// assert!((c[(0, 1)] - 9e-6).abs() < 1e-18);
/// assert!((c[(0, 0)] - 25e-6).abs() < 1e-18);
/// assert_eq!(c[(0, 2)], 0.0);
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    inputs: Vec<Input>,
    correlations: Vec<(String, String, f64)>,
    /// Inputs whose covariance was observed as a whole; positions in `inputs`.
    together: Vec<Vec<usize>>,
    /// Those of them that are samples of which whole rows are drawn.
    rows: Vec<Vec<usize>>,
}

impl Inputs {
    /// No inputs yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one input.
    #[allow(clippy::should_implement_trait)] // a builder verb, not arithmetic
    #[must_use]
    pub fn add(mut self, input: Input) -> Self {
        self.inputs.push(input);
        self
    }

    /// A correlation coefficient between two inputs, or between two of their draws.
    ///
    /// A bare input name (`V`) stands for every draw of it, paired with the draws of the other input that have
    /// the same labels; a draw is named with its labels in the order of `varies_with`:
    /// `reference[frequency=10]`.
    #[must_use]
    pub fn correlate(
        mut self,
        first: impl Into<String>,
        second: impl Into<String>,
        coefficient: f64,
    ) -> Self {
        self.correlations
            .push((first.into(), second.into(), coefficient));
        self
    }

    /// Adds quantities that were read together n times: means, their covariance s_ij/n, and ν = n − 1 for the
    /// covariance as a whole. **Source** `[GUM] H.2.2`.
    ///
    /// # Errors
    /// [`Error::TooFew`] below two observations, [`Error::Length`] when the columns differ, [`Error::NotFinite`].
    pub fn observed(self, columns: &[(&str, &str, &[f64])]) -> Result<Self, Error> {
        self.observed_by(JointReadings::Gum, columns)
    }

    /// As [`Inputs::observed`], by the rule of one's choice.
    ///
    /// # Errors
    /// As [`Inputs::observed`]; [`Error::TooFew`] for [`JointReadings::Jcgm102`] unless n > N.
    pub fn observed_by(
        mut self,
        rule: JointReadings,
        columns: &[(&str, &str, &[f64])],
    ) -> Result<Self, Error> {
        let start = self.inputs.len();
        for (name, unit, values) in columns {
            let distribution = Distribution::from_observations(values)?;
            self.inputs.push(Input::new(*name, *unit, distribution));
        }
        let set: Vec<usize> = (start..start + columns.len()).collect();
        let values: Vec<&[f64]> = columns.iter().map(|(_, _, values)| *values).collect();
        self.observe_together(rule, &set, &values)
    }

    /// States that the covariance of these inputs was estimated as a whole, with one number of degrees of freedom
    /// that all of them have: readings made together of which only means, uncertainties and correlations are
    /// known. They then behave as the readings themselves would.
    ///
    /// ```
    /// use proofmass_uncertainty::*;
    /// // `[GUM] H.2` from its table H.3.
    /// let nu = DegreesOfFreedom::new(4.0).unwrap();
    /// let input = |name: &str, mean, u| Input::new(name, "1", Distribution::Normal { mean, u }).dof(nu);
    /// let joint = Inputs::new()
    ///     .add(input("V", 4.9990, 0.0032))
    ///     .add(input("I", 19.6610e-3, 0.0095e-3))
    ///     .add(input("phi", 1.04446, 0.00075))
    ///     .correlate("V", "I", -0.36).correlate("V", "phi", 0.86).correlate("I", "phi", -0.65)
    ///     .ensemble(&["V", "I", "phi"])?
    ///     .single()?;
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal::Unknown`] for a name that no input has.
    pub fn ensemble(mut self, names: &[&str]) -> Result<Self, Refusal> {
        let place = |name: &&str| {
            let found = self.inputs.iter().position(|i| i.name == *name);
            found.ok_or_else(|| Refusal::Unknown {
                what: "input",
                name: (*name).to_owned(),
            })
        };
        let set = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        self.together.push(set);
        Ok(self)
    }

    /// Joins inputs that are samples of one joint distribution, such as the states of a Markov chain: row k of one belongs
    /// to row k of the others, and Monte Carlo draws whole rows.
    ///
    /// # Errors
    /// [`Error::Length`] when the columns differ, [`Refusal::Unknown`] for an input that is not samples.
    pub(crate) fn sampled_together(mut self, set: &[usize]) -> Result<Self, Refusal> {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for &i in set {
            let input = &self.inputs[i];
            let Distribution::Samples { values } = &input.distribution else {
                return Err(Refusal::Unknown {
                    what: "column of samples",
                    name: input.name.clone(),
                });
            };
            let expected = columns.first().map_or(values.len(), Vec::len);
            if values.len() != expected {
                return Err(Refusal::Input {
                    name: input.name.clone(),
                    source: Error::Length {
                        name: "samples drawn together with another input",
                        expected,
                        got: values.len(),
                    },
                });
            }
            columns.push(values.clone());
        }
        let deviations: Vec<Vec<f64>> = columns.iter().map(|c| deviations_of(c)).collect();
        self.correlate_by(set, &deviations);
        self.together.push(set.to_vec());
        self.rows.push(set.to_vec());
        Ok(self)
    }

    /// Correlation coefficients from the deviations of joint readings.
    fn correlate_by(&mut self, set: &[usize], deviations: &[Vec<f64>]) {
        for i in 0..set.len() {
            for j in 0..i {
                let (a, b) = (&deviations[i], &deviations[j]);
                let scale = (dot(a, a) * dot(b, b)).sqrt();
                if scale > 0.0 {
                    self.correlations.push((
                        self.inputs[set[i]].name.clone(),
                        self.inputs[set[j]].name.clone(),
                        (dot(a, b) / scale).clamp(-1.0, 1.0),
                    ));
                }
            }
        }
    }

    /// Joins inputs that are already here by the correlation of their observations.
    pub(crate) fn observe_together(
        mut self,
        rule: JointReadings,
        set: &[usize],
        columns: &[&[f64]],
    ) -> Result<Self, Error> {
        let n = columns.first().map_or(0, |c| c.len());
        if let Some(other) = columns.iter().find(|c| c.len() != n) {
            return Err(Error::Length {
                name: "column of observations",
                expected: n,
                got: other.len(),
            });
        }
        let deviations: Vec<Vec<f64>> = columns.iter().map(|c| deviations_of(c)).collect();
        if rule == JointReadings::Jcgm102 {
            let Some(dof) = n.checked_sub(set.len()).filter(|nu| *nu > 0) else {
                return Err(Error::TooFew {
                    name: "observations read together by JCGM 102",
                    needed: set.len() + 1,
                    got: n,
                });
            };
            let nu = dof as f64;
            for (&i, d) in set.iter().zip(&deviations) {
                let input = &mut self.inputs[i];
                input.distribution = Distribution::StudentT {
                    location: input.distribution.estimate(),
                    scale: (dot(d, d) / (n as f64 * nu)).sqrt(),
                    dof: nu,
                };
                input.dof = input.distribution.dof();
            }
        }
        self.correlate_by(set, &deviations);
        self.together.push(set.to_vec());
        Ok(self)
    }

    /// The inputs in order.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// The joint inputs of one single measurement: one draw per input.
    ///
    /// # Errors
    /// As [`Inputs::joint`].
    pub fn single(&self) -> Result<JointInputs, Refusal> {
        let mut labels = Labels::new();
        for key in self.inputs.iter().flat_map(|i| &i.varies_with) {
            labels = labels.with(key.clone(), "");
        }
        let mut joint = self.joint(&[labels])?;
        for draw in &mut joint.draws {
            draw.name.clone_from(&self.inputs[draw.input].name);
        }
        Ok(joint)
    }

    /// The draws that these observations need, with their joint covariance.
    ///
    /// # Errors
    /// [`Refusal::Duplicate`] and [`Refusal::Unknown`] for names and keys, [`Refusal::Input`] for an impossible
    /// distribution, [`Refusal::Correlation`] when the coefficients contradict each other.
    pub fn joint(&self, observations: &[Labels]) -> Result<JointInputs, Refusal> {
        let mut names = HashSet::new();
        for input in &self.inputs {
            if !names.insert(input.name.as_str()) {
                return Err(Refusal::Duplicate {
                    name: input.name.clone(),
                });
            }
            input
                .distribution
                .check()
                .map_err(|source| Refusal::Input {
                    name: input.name.clone(),
                    source,
                })?;
        }
        self.check_degrees_of_freedom()?;
        let mut draws: Vec<Draw> = Vec::new();
        let mut known: HashMap<(usize, Vec<&str>), usize> = HashMap::new();
        let mut index = Vec::with_capacity(observations.len() * self.inputs.len());
        let mut columns: Vec<Vec<usize>> = Vec::new();
        for (i, input) in self.inputs.iter().enumerate() {
            let estimate = input.distribution.estimate();
            let u = input.distribution.standard_uncertainty();
            let mut column = Vec::with_capacity(observations.len());
            for observation in observations {
                let values =
                    input
                        .varies_with
                        .iter()
                        .map(|key| {
                            observation.0.get(key).map(String::as_str).ok_or_else(|| {
                                Refusal::Unknown {
                                    what: "key of an observation",
                                    name: key.clone(),
                                }
                            })
                        })
                        .collect::<Result<Vec<&str>, _>>()?;
                let draw = *known.entry((i, values)).or_insert_with_key(|(_, values)| {
                    let labels: Vec<(String, String)> = input
                        .varies_with
                        .iter()
                        .cloned()
                        .zip(values.iter().map(|v| (*v).to_owned()))
                        .collect();
                    draws.push(Draw {
                        name: draw_name(&input.name, &labels),
                        input: i,
                        labels,
                        estimate,
                        standard_uncertainty: u,
                    });
                    draws.len() - 1
                });
                column.push(draw);
            }
            columns.push(column);
        }
        for k in 0..observations.len() {
            index.extend(columns.iter().map(|column| column[k]));
        }
        let correlations = self.resolve(&draws)?;
        JointInputs::new(self, draws, index, correlations)
    }
}

fn deviations_of(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}

fn draw_name(input: &str, labels: &[(String, String)]) -> String {
    if labels.is_empty() {
        return input.to_owned();
    }
    let inside: Vec<String> = labels.iter().map(|(k, v)| format!("{k}={v}")).collect();
    format!("{input}[{}]", inside.join(","))
}
