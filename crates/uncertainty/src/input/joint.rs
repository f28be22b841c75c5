//! The draws of a set of observations, with their joint covariance.

use super::{Input, Inputs};
use crate::{Covariance, Refusal};
use proofmass_core::Error;
use std::collections::HashMap;

/// One random draw: an input at one combination of the values of its keys.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Draw {
    /// `reference[frequency=10]`, or the bare name of an input that varies with nothing.
    pub name: String,
    /// Position of the input.
    pub input: usize,
    /// Keys and their values.
    pub(crate) labels: Vec<(String, String)>,
    /// Estimate.
    pub estimate: f64,
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
}

/// Inputs connected by correlation, with what connects them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cluster {
    /// Draws, ascending.
    pub(crate) draws: Vec<usize>,
    /// Inputs, ascending.
    pub(crate) inputs: Vec<usize>,
    /// Correlation matrix of the draws; `None` when they are independent of each other.
    pub(crate) correlation: Option<Covariance>,
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

    pub(super) fn new(
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

    /// The same inputs with every standard uncertainty taken as known.
    #[cfg(feature = "model")]
    pub(crate) fn known(&self) -> Self {
        let mut known = self.clone();
        for input in &mut known.inputs {
            input.dof = crate::DegreesOfFreedom::INFINITE;
        }
        known
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

    /// Covariance of quantities with these derivatives by the draws, a row for each: as fast as the derivatives are sparse.
    #[cfg(feature = "model")]
    pub(crate) fn seen_in(&self, jacobian: &[f64]) -> Covariance {
        let n = self.draws.len().max(1);
        let m = jacobian.len() / n;
        let mut covariance = Covariance::zeros(m);
        // Quantities that a draw acts on, and how much.
        let effects: Vec<Vec<(usize, f64)>> = (0..self.draws.len())
            .map(|d| {
                let u = self.draws[d].standard_uncertainty;
                let effect = |k: usize| (k, jacobian[k * n + d] * u);
                (0..m).map(effect).filter(|(_, e)| *e != 0.0).collect()
            })
            .collect();
        let mut add = |a: usize, b: usize, r: f64| {
            for &(i, x) in &effects[a] {
                for &(j, y) in &effects[b] {
                    covariance.set(i, j, covariance[(i, j)] + r * x * y);
                }
            }
        };
        for cluster in &self.clusters {
            for (a, &i) in cluster.draws.iter().enumerate() {
                match &cluster.correlation {
                    None => add(i, i, 1.0),
                    Some(r) => {
                        for (b, &j) in cluster.draws.iter().enumerate() {
                            add(i, j, r[(a, b)]);
                        }
                    }
                }
            }
        }
        covariance
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
