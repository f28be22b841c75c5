//! Random draws for Monte Carlo: every input of a trial, with its correlations.

use crate::input::Doubt;
use crate::propagation::square_root;
use crate::ziggurat::StudentZiggurat;
use crate::{Distribution, JointInputs};
use proofmass_core::Error;
use rand::{Rng, RngExt};
use rand_distr::{Beta, ChiSquared, Distribution as _, Exp1, Gamma, Poisson, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Trials drawn at a time: they stay in the first-level cache.
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

/// A random factor about the estimate.
enum Stretch {
    Chi(ChiSquared<f64>, f64),
    Limits(f64),
}

impl Stretch {
    fn new(doubt: Doubt) -> Result<Option<Self>, Error> {
        Ok(match doubt {
            Doubt::None => None,
            Doubt::Scale(dof) => Some(Self::Chi(chi_squared(dof)?, dof)),
            Doubt::Limits(share) => Some(Self::Limits(share)),
        })
    }

    fn draw(&self, rng: &mut Xoshiro256PlusPlus) -> f64 {
        match self {
            Self::Chi(chi_squared, dof) => (dof / chi_squared.sample(rng)).sqrt(),
            Self::Limits(share) => 1.0 + share * (2.0 * rng.random::<f64>() - 1.0),
        }
    }
}

enum Source {
    /// Another source, stretched about its estimate.
    Stretched {
        inner: Box<Source>,
        middle: f64,
        stretch: Stretch,
    },
    Constant(f64),
    Normal {
        mean: f64,
        u: f64,
    },
    StudentT {
        location: f64,
        scale: f64,
        t: Box<StudentZiggurat>,
    },
    Rectangular {
        lower: f64,
        width: f64,
    },
    Trapezoidal {
        lower: f64,
        top: f64,
        slope: f64,
    },
    Curvilinear {
        lower: f64,
        span: f64,
        d: f64,
    },
    Arcsine {
        middle: f64,
        half: f64,
    },
    Truncated(Distribution),
    Exponential {
        lower: f64,
        scale: f64,
    },
    Gamma {
        lower: f64,
        shape: Gamma<f64>,
    },
    Lognormal {
        lower: f64,
        median: f64,
        sigma: f64,
    },
    Beta {
        lower: f64,
        width: f64,
        shape: Beta<f64>,
    },
    Poisson {
        lower: f64,
        scale: f64,
        events: Poisson<f64>,
    },
    /// Values, and the share of all up to each.
    Discrete(Vec<f64>, Vec<f64>),
    Samples(Vec<f64>),
}

/// Draws all inputs of a trial.
pub(crate) struct Sampler {
    plans: Vec<Plan>,
    size: usize,
    /// Names of correlated inputs whose marginals are not normal: their joint distribution is a choice.
    pub copula: Vec<String>,
    /// Whether an input has no standard deviation.
    pub heavy: bool,
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
    pub fn new(inputs: &JointInputs) -> Result<Self, Error> {
        let mut result = Self {
            plans: Vec::new(),
            size: inputs.draws.len(),
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
                    result.correlated(inputs, &cluster.draws, square_root(r)?, &drawn, &groups)?
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

    /// Fills [`STRIP`] trials, each a row of n draws.
    pub fn fill(&self, rows: &mut [f64], rng: &mut Xoshiro256PlusPlus) {
        let n = self.size.max(1);
        let mut strip = [0.0; STRIP];
        let mut factors = [1.0; STRIP];
        let mut z = Vec::new();
        let mut common = Vec::new();
        for plan in &self.plans {
            match plan {
                Plan::Alone { draw, source } => {
                    source.fill(&mut strip, rng);
                    for (row, x) in rows.chunks_exact_mut(n).zip(&strip) {
                        row[*draw] = *x;
                    }
                }
                Plan::Rows { draws, columns } => {
                    let most = columns.first().map_or(0, Vec::len);
                    if most == 0 {
                        continue;
                    }
                    for row in rows.chunks_exact_mut(n) {
                        let k = rng.random_range(0..most);
                        for (&d, column) in draws.iter().zip(columns) {
                            row[d] = column[k];
                        }
                    }
                }
                Plan::SharedScale { draws, stretch } => {
                    factors.fill_with(|| stretch.draw(rng));
                    for (d, source, middle) in draws {
                        source.fill(&mut strip, rng);
                        let trials = rows.chunks_exact_mut(n).zip(&strip).zip(&factors);
                        for ((row, x), factor) in trials {
                            row[*d] = middle + factor * (x - middle);
                        }
                    }
                }
                Plan::Correlated {
                    draws,
                    root,
                    marginals,
                    stretches,
                } => {
                    let m = draws.len();
                    for row in rows.chunks_exact_mut(n) {
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
                            row[d] = match &marginal.shape {
                                Shape::Normal(mean, u) => mean + u * factor * g,
                                Shape::Samples(sorted, middle) => {
                                    let place = normal_probability(g) * sorted.len() as f64;
                                    let x = sorted[(place as usize).min(sorted.len() - 1)];
                                    middle + factor * (x - middle)
                                }
                                Shape::Quantile(distribution, middle) => {
                                    let x = distribution.quantile(normal_probability(g));
                                    middle + factor * (x - middle)
                                }
                            };
                        }
                    }
                }
            }
        }
    }
}

/// A strip of random words. The generator is copied out and back, so that its state stays in registers.
fn words(rng: &mut Xoshiro256PlusPlus) -> [u64; STRIP] {
    let mut state = rng.clone();
    let mut words = [0; STRIP];
    for word in &mut words {
        *word = state.next_u64();
    }
    *rng = state;
    words
}

/// The upper 53 bits as a number in [0, 1).
fn fraction(word: u64) -> f64 {
    // Through the signed type, whose conversion is one instruction.
    (word >> 11) as i64 as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A parameter that the sampler cannot use.
fn beyond(name: &'static str, value: f64) -> Error {
    Error::OutOfRange {
        name,
        value,
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    }
}

fn chi_squared(dof: f64) -> Result<ChiSquared<f64>, Error> {
    ChiSquared::new(dof).map_err(|_| Error::OutOfRange {
        name: "degrees of freedom",
        value: dof,
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    })
}

/// Φ(z) kept strictly inside (0, 1), so that quantiles stay finite.
fn normal_probability(z: f64) -> f64 {
    use statrs::function::erf::erfc;
    (0.5 * erfc(-z / 2f64.sqrt())).clamp(1e-300, 1.0 - 1e-16)
}

impl Source {
    fn new(distribution: &Distribution) -> Result<Self, Error> {
        if distribution.standard_uncertainty() == 0.0 {
            return Ok(Self::Constant(distribution.estimate()));
        }
        let trapezoid = |lower: f64, upper: f64, beta: f64| Self::Trapezoidal {
            lower,
            top: 0.5 * (upper - lower) * (1.0 + beta),
            slope: 0.5 * (upper - lower) * (1.0 - beta),
        };
        Ok(match distribution {
            Distribution::Normal { mean, u } => Self::Normal { mean: *mean, u: *u },
            // Beyond 10⁶ t and normal differ by less than a millionth of u: no number of trials can see it.
            Distribution::StudentT {
                location,
                scale,
                dof,
            } if *dof >= 1e6 => Self::Normal {
                mean: *location,
                u: *scale,
            },
            Distribution::StudentT {
                location,
                scale,
                dof,
            } => Self::StudentT {
                location: *location,
                scale: *scale,
                t: Box::new(StudentZiggurat::new(*dof)),
            },
            Distribution::Rectangular { lower, upper } => Self::Rectangular {
                lower: *lower,
                width: upper - lower,
            },
            Distribution::Triangular { lower, upper } => trapezoid(*lower, *upper, 0.0),
            Distribution::Trapezoidal { lower, upper, beta } => trapezoid(*lower, *upper, *beta),
            Distribution::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => Self::Curvilinear {
                lower: lower - inexactness,
                span: lower + upper,
                d: *inexactness,
            },
            Distribution::Arcsine { lower, upper } => Self::Arcsine {
                middle: 0.5 * (lower + upper),
                half: 0.5 * (upper - lower),
            },
            truncated @ Distribution::TruncatedNormal { .. } => Self::Truncated(truncated.clone()),
            Distribution::Exponential { lower, mean } => Self::Exponential {
                lower: *lower,
                scale: mean - lower,
            },
            Distribution::Gamma {
                lower,
                shape,
                scale,
            } => Self::Gamma {
                lower: *lower,
                shape: Gamma::new(*shape, *scale).map_err(|_| beyond("shape", *shape))?,
            },
            Distribution::Lognormal {
                lower,
                median,
                sigma,
            } => Self::Lognormal {
                lower: *lower,
                median: *median,
                sigma: *sigma,
            },
            Distribution::Beta {
                lower,
                upper,
                alpha,
                beta,
            } => Self::Beta {
                lower: *lower,
                width: upper - lower,
                shape: Beta::new(*alpha, *beta).map_err(|_| beyond("alpha", *alpha))?,
            },
            Distribution::Poisson { lower, scale, mean } => Self::Poisson {
                lower: *lower,
                scale: *scale,
                events: Poisson::new(*mean).map_err(|_| beyond("mean", *mean))?,
            },
            Distribution::Discrete { values, weights } => {
                let mut below = 0.0;
                let shares = crate::distribution::discrete_weights(values, weights);
                let up_to = shares.iter().map(|w| {
                    below += w;
                    below
                });
                Self::Discrete(values.clone(), up_to.collect())
            }
            Distribution::Samples { values } => Self::Samples(values.clone()),
        })
    }

    /// One draw of a strip of trials.
    fn fill(&self, column: &mut [f64; STRIP], rng: &mut Xoshiro256PlusPlus) {
        match self {
            Self::Stretched {
                inner,
                middle,
                stretch,
            } => {
                inner.fill(column, rng);
                for x in column {
                    *x = middle + stretch.draw(rng) * (*x - middle);
                }
            }
            Self::Constant(value) => *column = [*value; STRIP],
            Self::Normal { mean, u } => {
                for x in column {
                    *x = mean + u * rng.sample::<f64, _>(StandardNormal);
                }
            }
            Self::StudentT { location, scale, t } => {
                for (x, word) in column.iter_mut().zip(words(rng)) {
                    *x = location + scale * t.shape(word, rng);
                }
            }
            Self::Rectangular { lower, width } => {
                for (x, word) in column.iter_mut().zip(words(rng)) {
                    *x = lower + width * fraction(word);
                }
            }
            // Sum of two rectangular variables. `[S1]` 6.4.4.3
            Self::Trapezoidal { lower, top, slope } => {
                for ((x, a), b) in column.iter_mut().zip(words(rng)).zip(words(rng)) {
                    *x = lower + top * fraction(a) + slope * fraction(b);
                }
            }
            // The lower limit is drawn first and mirrored about the middle. `[S1]` 6.4.3.4
            Self::Curvilinear { lower, span, d } => {
                for ((x, a), b) in column.iter_mut().zip(words(rng)).zip(words(rng)) {
                    let a = lower + 2.0 * d * fraction(a);
                    *x = a + (span - 2.0 * a) * fraction(b);
                }
            }
            // The cosine of a uniform angle from a point in the unit disc: cos 2θ = (a² − b²)/(a² + b²). Points
            // outside are overwritten by the next one, which costs less than a branch that goes either way.
            Self::Arcsine { middle, half } => {
                let mut filled = 0;
                while filled < STRIP {
                    for (a, b) in words(rng).into_iter().zip(words(rng)) {
                        let (a, b) = (2.0 * fraction(a) - 1.0, fraction(b));
                        let (a, b) = (a * a, b * b);
                        let Some(x) = column.get_mut(filled) else {
                            break;
                        };
                        *x = middle + half * (a - b) / (a + b);
                        filled += usize::from(a + b <= 1.0 && a + b > 0.0);
                    }
                }
            }
            Self::Truncated(distribution) => {
                for x in column {
                    *x = distribution.quantile(rng.random::<f64>());
                }
            }
            Self::Exponential { lower, scale } => {
                for x in column {
                    *x = lower + scale * rng.sample::<f64, _>(Exp1);
                }
            }
            Self::Gamma { lower, shape } => {
                for x in column {
                    *x = lower + shape.sample(rng);
                }
            }
            Self::Lognormal {
                lower,
                median,
                sigma,
            } => {
                for x in column {
                    *x = lower + median * (sigma * rng.sample::<f64, _>(StandardNormal)).exp();
                }
            }
            Self::Beta {
                lower,
                width,
                shape,
            } => {
                for x in column {
                    *x = lower + width * shape.sample(rng);
                }
            }
            Self::Poisson {
                lower,
                scale,
                events,
            } => {
                for x in column {
                    *x = lower + scale * events.sample(rng);
                }
            }
            Self::Discrete(values, up_to) => {
                for x in column {
                    let p = rng.random::<f64>();
                    let place = up_to.partition_point(|share| *share < p);
                    *x = values[place.min(values.len() - 1)];
                }
            }
            Self::Samples(values) => {
                for x in column {
                    *x = values[rng.random_range(0..values.len())];
                }
            }
        }
    }
}
