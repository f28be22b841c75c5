//! Inputs, the keys they vary with, and the joint covariance that follows from them.

use crate::{Covariance, DegreesOfFreedom, Distribution, Evaluation, Refusal};
use proofmass_core::Error;
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

    /// Degrees of freedom that can be drawn from, and one number of them per set that was estimated as a whole.
    fn check_degrees_of_freedom(&self) -> Result<(), Refusal> {
        for input in &self.inputs {
            // One observation more than parameters gives 1; pooled values may fall a little below.
            if input.dof.get() < 0.5 {
                return Err(Refusal::Input {
                    name: input.name.clone(),
                    source: Error::OutOfRange {
                        name: "dof",
                        value: input.dof.get(),
                        min: 0.5,
                        max: f64::MAX,
                    },
                });
            }
        }
        for set in &self.rows {
            let name = |i: usize| self.inputs[i].name.as_str();
            let inside = |other: &str| set.iter().any(|&i| name(i) == other);
            let mixed = self
                .correlations
                .iter()
                .find(|(a, b, _)| inside(a) != inside(b));
            if let Some((a, b, _)) = mixed {
                return Err(Refusal::Contradiction {
                    name: if inside(a) { a.clone() } else { b.clone() },
                    what: "samples drawn together say their correlation themselves; none with another input can be added",
                });
            }
            if let Some(&i) = set.iter().find(|&&i| {
                !self.inputs[i].dof.is_infinite() || !self.inputs[i].varies_with.is_empty()
            }) {
                return Err(Refusal::Contradiction {
                    name: name(i).to_owned(),
                    what: "samples drawn together have neither `dof` nor `varies_with`",
                });
            }
        }
        for set in &self.together {
            let first = set.first().map(|&i| self.inputs[i].dof);
            if let Some(&other) = set.iter().find(|&&i| Some(self.inputs[i].dof) != first) {
                return Err(Refusal::Incomplete {
                    name: self.inputs[other].name.clone(),
                    needed: "the same number of degrees of freedom as the inputs it was observed together with",
                });
            }
        }
        Ok(())
    }

    /// Coefficients by draw; a bare input name pairs the draws with equal labels.
    fn resolve(&self, draws: &[Draw]) -> Result<Vec<(usize, usize, f64)>, Refusal> {
        let mut resolved = Vec::new();
        for (k, (first, second, r)) in self.correlations.iter().enumerate() {
            let same = |(a, b, _): &(String, String, f64)| {
                (a == first && b == second) || (a == second && b == first)
            };
            let what = if !(-1.0..=1.0).contains(r) {
                Some("lies outside −1 to 1")
            } else if first == second {
                Some("is that of a quantity with itself, which is 1")
            } else if self.correlations[..k].iter().any(same) {
                Some("is given twice")
            } else {
                None
            };
            if let Some(what) = what {
                return Err(Refusal::Pair {
                    first: first.clone(),
                    second: second.clone(),
                    coefficient: *r,
                    what,
                });
            }
            let matching = |name: &str| -> Result<Vec<usize>, Refusal> {
                let found: Vec<usize> = (0..draws.len())
                    .filter(|&d| draws[d].name == name || self.inputs[draws[d].input].name == name)
                    .collect();
                let absent = found.is_empty()
                    && !self.inputs.iter().any(|i| {
                        name == i.name
                            || name
                                .strip_prefix(&i.name)
                                .is_some_and(|rest| rest.starts_with('['))
                    });
                if absent {
                    return Err(Refusal::Unknown {
                        what: "input",
                        name: name.to_owned(),
                    });
                }
                Ok(found)
            };
            let (a, b) = (matching(first)?, matching(second)?);
            let named_draws = first.contains('[') || second.contains('[');
            for &i in &a {
                for &j in &b {
                    if i != j && (named_draws || draws[i].labels == draws[j].labels) {
                        resolved.push((i, j, *r));
                    }
                }
            }
        }
        Ok(resolved)
    }
}

fn deviations_of(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn draw_name(input: &str, labels: &[(String, String)]) -> String {
    if labels.is_empty() {
        return input.to_owned();
    }
    let inside: Vec<String> = labels.iter().map(|(k, v)| format!("{k}={v}")).collect();
    format!("{input}[{}]", inside.join(","))
}

/// One random draw: an input at one combination of the values of its keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// `reference[frequency=10]`, or the bare name of an input that varies with nothing.
    pub name: String,
    /// Position of the input.
    pub input: usize,
    /// Keys and their values.
    pub labels: Vec<(String, String)>,
    /// Estimate.
    pub estimate: f64,
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
}

/// Inputs connected by correlation, with what connects them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cluster {
    /// Draws, ascending.
    pub draws: Vec<usize>,
    /// Inputs, ascending.
    pub inputs: Vec<usize>,
    /// Correlation matrix of the draws; `None` when they are independent of each other.
    pub correlation: Option<Covariance>,
}

/// All draws of a set of observations, with their joint covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct JointInputs {
    pub(crate) inputs: Vec<Input>,
    pub(crate) together: Vec<Vec<usize>>,
    /// Inputs of which whole rows of samples are drawn.
    pub(crate) rows: Vec<Vec<usize>>,
    pub(crate) draws: Vec<Draw>,
    pub(crate) clusters: Vec<Cluster>,
    index: Vec<usize>,
}

impl JointInputs {
    /// Correlations between draws that are not zero, each pair once.
    pub fn correlations(&self) -> Vec<(&str, &str, f64)> {
        let mut pairs = Vec::new();
        for cluster in &self.clusters {
            let Some(r) = &cluster.correlation else {
                continue;
            };
            for a in 0..cluster.draws.len() {
                for b in 0..a {
                    if r[(a, b)] != 0.0 {
                        let name = |k: usize| self.draws[cluster.draws[k]].name.as_str();
                        pairs.push((name(b), name(a), r[(a, b)]));
                    }
                }
            }
        }
        pairs
    }

    fn new(
        inputs: &Inputs,
        draws: Vec<Draw>,
        index: Vec<usize>,
        correlations: Vec<(usize, usize, f64)>,
    ) -> Result<Self, Refusal> {
        // Connected components of inputs: a small union-find without ranks.
        let mut parent: Vec<usize> = (0..inputs.inputs.len()).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        let edges = correlations
            .iter()
            .map(|&(i, j, _)| (draws[i].input, draws[j].input))
            .chain(
                inputs
                    .together
                    .iter()
                    .flat_map(|set| set.windows(2).map(|w| (w[0], w[1]))),
            );
        for (a, b) in edges {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b)] = a.min(b);
        }
        let mut clusters: Vec<Cluster> = Vec::new();
        let mut of_root: HashMap<usize, usize> = HashMap::new();
        for i in 0..inputs.inputs.len() {
            let r = root(&mut parent, i);
            let k = *of_root.entry(r).or_insert_with(|| {
                clusters.push(Cluster {
                    draws: vec![],
                    inputs: vec![],
                    correlation: None,
                });
                clusters.len() - 1
            });
            clusters[k].inputs.push(i);
        }
        let mut place = vec![0; draws.len()];
        for (d, draw) in draws.iter().enumerate() {
            let k = of_root[&root(&mut parent, draw.input)];
            place[d] = clusters[k].draws.len();
            clusters[k].draws.push(d);
        }
        for (k, cluster) in clusters.iter_mut().enumerate() {
            let own: Vec<_> = correlations
                .iter()
                .filter(|(i, _, _)| of_root[&root(&mut parent, draws[*i].input)] == k)
                .collect();
            if own.is_empty() {
                continue;
            }
            let n = cluster.draws.len();
            let mut r = vec![0.0; n * n];
            (0..n).for_each(|i| r[i * n + i] = 1.0);
            for &&(i, j, coefficient) in &own {
                let (a, b) = (place[i], place[j]);
                r[a * n + b] = coefficient;
                r[b * n + a] = coefficient;
            }
            let named = |error| match error {
                Error::NotPositiveDefinite {
                    row, column, value, ..
                } => Refusal::Correlation {
                    first: draws[cluster.draws[row]].name.clone(),
                    second: draws[cluster.draws[column]].name.clone(),
                    coefficient: value,
                },
                other => Refusal::Core(other),
            };
            cluster.correlation = Some(Covariance::try_from_rows(n, &r).map_err(named)?);
        }
        Ok(Self {
            inputs: inputs.inputs.clone(),
            together: inputs.together.clone(),
            rows: inputs.rows.clone(),
            draws,
            clusters,
            index,
        })
    }

    /// Whose estimate of σ a draw shares: the first input of its set, else its own input.
    pub(crate) fn estimated_with(&self, draw: usize) -> usize {
        let input = self.draws[draw].input;
        let set = self.together.iter().find(|set| set.contains(&input));
        set.and_then(|set| set.first().copied()).unwrap_or(input)
    }

    /// Draws that one trial takes; correlated ones count as the sums they are made of.
    #[cfg(feature = "model")]
    pub(crate) fn draws_per_trial(&self) -> usize {
        let of = |cluster: &Cluster| match (&cluster.correlation, cluster.draws.len()) {
            (None, n) => n,
            (Some(_), n) => n * (2 + n / 8),
        };
        self.clusters.iter().map(of).sum()
    }

    /// Name of an input by its position.
    #[cfg(feature = "monte-carlo")]
    pub(crate) fn input_name(&self, input: usize) -> &str {
        &self.inputs[input].name
    }

    /// The draws in order.
    pub fn draws(&self) -> &[Draw] {
        &self.draws
    }

    /// Position of the draw that one observation uses for one input.
    ///
    /// `None` when either does not exist.
    pub fn index_of(&self, observation: usize, input: &str) -> Option<usize> {
        let i = self.inputs.iter().position(|x| x.name == input)?;
        self.index.get(observation * self.inputs.len() + i).copied()
    }

    /// Estimates of the draws.
    pub fn estimates(&self) -> Vec<f64> {
        self.draws.iter().map(|d| d.estimate).collect()
    }

    /// Joint covariance of all draws, n × n.
    pub fn covariance(&self) -> Covariance {
        let u: Vec<f64> = self.draws.iter().map(|d| d.standard_uncertainty).collect();
        let n = u.len();
        let mut c = Covariance::from_standard_uncertainties(&u).unwrap_or(Covariance::zeros(n));
        for cluster in &self.clusters {
            if let Some(r) = &cluster.correlation {
                for (a, &i) in cluster.draws.iter().enumerate() {
                    for (b, &j) in cluster.draws.iter().enumerate() {
                        if a != b {
                            c.set(i, j, r[(a, b)] * u[i] * u[j]);
                        }
                    }
                }
            }
        }
        c
    }

    /// Covariance of one quantity per observation, each the linear combination of its inputs with these
    /// sensitivity coefficients.
    ///
    /// **Shapes** `sensitivities.len() == observations × inputs`, observations outer.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn observation_covariance(&self, sensitivities: &[f64]) -> Result<Covariance, Refusal> {
        if sensitivities.len() != self.index.len() {
            return Err(Error::Length {
                name: "sensitivities",
                expected: self.index.len(),
                got: sensitivities.len(),
            }
            .into());
        }
        let (m, n) = (self.inputs.len().max(1), self.draws.len());
        let mut jacobian = vec![0.0; self.index.len() / m * n];
        for (k, (&draw, &c)) in self.index.iter().zip(sensitivities).enumerate() {
            jacobian[k / m * n + draw] += c;
        }
        Ok(self.covariance().propagate(&jacobian)?)
    }
}
