//! Random draws for Monte Carlo: every input of a trial, with its correlations.

mod normal_scores;
mod source;
mod stretch;
mod strips;

pub(crate) use strips::Strips;

use crate::input::Doubt;
use crate::propagation::square_root;
use crate::{Distribution, JointInputs, Refusal};
use proofmass_core::Error;
use rand::RngExt;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use source::Source;
use stretch::Stretch;

/// Trials drawn at a time at most: they stay in the first-level cache.
pub(crate) const STRIP: usize = 256;

/// How the draws of one set of inputs are made.
enum Plan {
    /// Draws that depend on nothing else.
    Alone { draw: usize, source: Source },
    /// Independent draws that share the one estimate of their σ: draw, source, estimate.
    SharedScale {
        draws: Vec<(usize, Source, f64)>,
        stretch: Stretch,
    },
    /// Whole rows of joint samples: draws and their columns.
    Rows {
        draws: Vec<usize>,
        columns: Vec<Vec<f64>>,
    },
    /// Multivariate normal, stretched to Student t by one χ² per estimate of σ, or a normal copula for other marginals.
    Correlated {
        draws: Vec<usize>,
        root: Vec<f64>,
        marginals: Vec<Marginal>,
        stretches: Vec<Stretch>,
    },
}

/// One correlated draw.
struct Marginal {
    shape: Shape,
    /// Position of its stretch.
    stretch: Option<usize>,
}

enum Shape {
    /// Middle and scale of a normal.
    Normal(f64, f64),
    /// Samples in ascending order, and their mean.
    Samples(Vec<f64>, f64),
    /// By its quantile, and its estimate.
    Quantile(Distribution, f64),
}

/// Draws all inputs of a trial.
pub(crate) struct Sampler {
    plans: Vec<Plan>,
    /// Names of correlated inputs whose marginals are not normal: their joint distribution is a choice.
    pub(crate) copula: Vec<String>,
    /// Whether an input has no standard deviation.
    pub(crate) heavy: bool,
}

/// A Student t as a normal with a stretch, anything else as it is.
fn unstretched(drawn: &(Distribution, Doubt)) -> (Distribution, Doubt) {
    match drawn {
        (
            Distribution::StudentT {
                location,
                scale,
                dof,
            },
            _,
        ) => (
            Distribution::Normal {
                mean: *location,
                u: *scale,
            },
            Doubt::Scale(*dof),
        ),
        other => other.clone(),
    }
}

impl Sampler {
    /// # Errors
    /// [`Refusal::Unreachable`], [`Refusal::Correlation`] for coefficients that inputs of these distributions cannot have.
    pub fn new(inputs: &JointInputs) -> Result<Self, Refusal> {
        let mut result = Self {
            plans: Vec::new(),
            copula: Vec::new(),
            heavy: false,
        };
        for cluster in &inputs.clusters {
            let drawn: Vec<(Distribution, Doubt)> = cluster
                .draws
                .iter()
                .map(|&d| inputs.inputs[inputs.draws[d].input].drawn_from())
                .collect();
            result.heavy |= drawn.iter().any(|d| match d {
                (Distribution::StudentT { dof, scale, .. }, _) => *dof <= 2.0 && *scale > 0.0,
                (_, Doubt::Scale(dof)) => *dof <= 2.0,
                _ => false,
            });
            // Draws by the estimate of σ that they share.
            let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
            for (a, &d) in cluster.draws.iter().enumerate() {
                let key = inputs.estimated_with(d);
                match groups.iter_mut().find(|(k, _)| *k == key) {
                    Some((_, members)) => members.push(a),
                    None => groups.push((key, vec![a])),
                }
            }
            if inputs.rows.contains(&cluster.inputs) {
                let columns = drawn.into_iter().filter_map(|(d, _)| match d {
                    Distribution::Samples { values } => Some(values),
                    _ => None,
                });
                result.plans.push(Plan::Rows {
                    draws: cluster.draws.clone(),
                    columns: columns.collect(),
                });
                continue;
            }
            match &cluster.correlation {
                Some(r) => {
                    let scores = normal_scores::of_draws(inputs, &cluster.draws, r, &drawn)?;
                    let root = square_root(scores.as_ref().unwrap_or(r))?;
                    result.correlated(inputs, &cluster.draws, root, &drawn, &groups)?;
                }
                None => {
                    for (_, members) in &groups {
                        result.independent(&cluster.draws, members, &drawn)?;
                    }
                }
            }
        }
        Ok(result)
    }

    fn independent(
        &mut self,
        draws: &[usize],
        members: &[usize],
        drawn: &[(Distribution, Doubt)],
    ) -> Result<(), Error> {
        let several = members.len() > 1;
        if let (true, Some(stretch)) = (
            several,
            Stretch::new(
                members
                    .first()
                    .map_or(Doubt::None, |&a| unstretched(&drawn[a]).1),
            )?,
        ) {
            let draws = members.iter().map(|&a| {
                let (distribution, _) = unstretched(&drawn[a]);
                let middle = distribution.estimate();
                Ok((draws[a], Source::new(&distribution)?, middle))
            });
            self.plans.push(Plan::SharedScale {
                draws: draws.collect::<Result<_, Error>>()?,
                stretch,
            });
            return Ok(());
        }
        for &a in members {
            let (distribution, doubt) = &drawn[a];
            let inner = Source::new(distribution)?;
            let source = match Stretch::new(*doubt)? {
                Some(stretch) => Source::Stretched {
                    inner: Box::new(inner),
                    middle: distribution.estimate(),
                    stretch,
                },
                None => inner,
            };
            self.plans.push(Plan::Alone {
                draw: draws[a],
                source,
            });
        }
        Ok(())
    }

    fn correlated(
        &mut self,
        inputs: &JointInputs,
        draws: &[usize],
        root: Vec<f64>,
        drawn: &[(Distribution, Doubt)],
        groups: &[(usize, Vec<usize>)],
    ) -> Result<(), Error> {
        let mut stretches = Vec::new();
        let mut marginals: Vec<Marginal> = Vec::with_capacity(draws.len());
        let mut of_group = vec![None; draws.len()];
        for (_, members) in groups {
            let doubt = members
                .first()
                .map_or(Doubt::None, |&a| unstretched(&drawn[a]).1);
            if let Some(stretch) = Stretch::new(doubt)? {
                members
                    .iter()
                    .for_each(|&a| of_group[a] = Some(stretches.len()));
                stretches.push(stretch);
            }
        }
        for (a, drawn) in drawn.iter().enumerate() {
            let shape = match unstretched(drawn).0 {
                Distribution::Normal { mean, u } => Shape::Normal(mean, u),
                other => {
                    self.copula.push(inputs.draws[draws[a]].name.clone());
                    let middle = other.estimate();
                    match other {
                        Distribution::Samples { mut values } => {
                            values.sort_by(f64::total_cmp);
                            Shape::Samples(values, middle)
                        }
                        other => Shape::Quantile(other, middle),
                    }
                }
            };
            marginals.push(Marginal {
                shape,
                stretch: of_group[a],
            });
        }
        self.plans.push(Plan::Correlated {
            draws: draws.to_vec(),
            root,
            marginals,
            stretches,
        });
        Ok(())
    }

    /// Fills all trials of the strips.
    pub fn fill(&self, strips: &mut Strips, rng: &mut Xoshiro256PlusPlus) {
        let mut factors = [1.0; STRIP];
        let trials = strips.trials;
        let mut z = Vec::new();
        let mut common = Vec::new();
        for plan in &self.plans {
            match plan {
                Plan::Alone { draw, source } => {
                    strips.fill(*draw, |column, words| source.fill(column, words, rng));
                }
                Plan::Rows { draws, columns } => {
                    let most = columns.first().map_or(0, Vec::len);
                    if most == 0 {
                        continue;
                    }
                    for trial in 0..trials {
                        let k = rng.random_range(0..most);
                        for (&d, column) in draws.iter().zip(columns) {
                            strips.set(d, trial, column[k]);
                        }
                    }
                }
                Plan::SharedScale { draws, stretch } => {
                    factors[..trials].fill_with(|| stretch.draw(rng));
                    for (d, source, middle) in draws {
                        strips.fill(*d, |column, words| {
                            source.fill(column, words, rng);
                            for (x, factor) in column.iter_mut().zip(&factors) {
                                *x = middle + factor * (*x - middle);
                            }
                        });
                    }
                }
                Plan::Correlated {
                    draws,
                    root,
                    marginals,
                    stretches,
                } => {
                    let m = draws.len();
                    for trial in 0..trials {
                        z.clear();
                        z.extend((0..m).map(|_| rng.sample::<f64, _>(StandardNormal)));
                        common.clear();
                        common.extend(stretches.iter().map(|s| s.draw(rng)));
                        for (a, (&d, marginal)) in draws.iter().zip(marginals).enumerate() {
                            let g: f64 = root[a * m..(a + 1) * m]
                                .iter()
                                .zip(&z)
                                .map(|(r, z)| r * z)
                                .sum();
                            let factor = marginal.stretch.map_or(1.0, |s| common[s]);
                            strips.set(d, trial, marginal.shape.at(g, factor));
                        }
                    }
                }
            }
        }
    }
}

impl Shape {
    /// The value whose place in the distribution is that of g in the standard normal, stretched about the estimate.
    fn at(&self, g: f64, factor: f64) -> f64 {
        match self {
            Self::Normal(mean, u) => mean + u * factor * g,
            Self::Samples(sorted, middle) => {
                let place = normal_probability(g) * sorted.len() as f64;
                let x = sorted[(place as usize).min(sorted.len() - 1)];
                middle + factor * (x - middle)
            }
            Self::Quantile(distribution, middle) => {
                let x = distribution.quantile(normal_probability(g));
                middle + factor * (x - middle)
            }
        }
    }
}

/// Φ(z) kept strictly inside (0, 1), so that quantiles stay finite.
fn normal_probability(z: f64) -> f64 {
    use statrs::function::erf::erfc;
    (0.5 * erfc(-z / 2f64.sqrt())).clamp(1e-300, 1.0 - 1e-16)
}
