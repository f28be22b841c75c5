//! Random draws for Monte Carlo: every input of a trial, with its correlations.

use crate::propagation::square_root;
use crate::ziggurat::StudentZiggurat;
use crate::{Distribution, JointInputs};
use proofmass_core::Error;
use rand::{Rng, RngExt};
use rand_distr::{ChiSquared, Distribution as _, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Trials drawn at a time: they stay in the first-level cache.
pub(crate) const STRIP: usize = 256;

/// How the draws of one set of inputs are made.
enum Plan {
    /// Draws that depend on nothing else.
    Alone { draw: usize, source: Source },
    /// Draws of Student t that share the one estimate of σ: draw, location, scale.
    SharedScale {
        draws: Vec<(usize, f64, f64)>,
        chi_squared: ChiSquared<f64>,
        dof: f64,
    },
    /// Multivariate normal or t (one chi-square for all), or a normal copula for other marginals.
    Correlated {
        draws: Vec<usize>,
        root: Vec<f64>,
        marginals: Vec<Distribution>,
        shared: Option<(ChiSquared<f64>, f64)>,
    },
}

enum Source {
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
    Samples(Vec<f64>),
}

/// Draws all inputs of a trial.
pub(crate) struct Sampler {
    plans: Vec<Plan>,
    size: usize,
    /// Names of correlated inputs whose marginals are not normal: their joint distribution is a choice.
    pub copula: Vec<String>,
}

impl Sampler {
    pub fn new(inputs: &JointInputs) -> Result<Self, Error> {
        let mut plans = Vec::new();
        let mut copula = Vec::new();
        for cluster in &inputs.clusters {
            let distribution = |d: usize| inputs.inputs[inputs.draws[d].input].drawn_from();
            if let Some(r) = &cluster.correlation {
                let marginals: Vec<Distribution> =
                    cluster.draws.iter().map(|&d| distribution(d)).collect();
                let common = common_dof(&marginals);
                let normal = marginals
                    .iter()
                    .all(|m| matches!(m, Distribution::Normal { .. }));
                if common.is_none() && !normal {
                    copula.extend(cluster.draws.iter().map(|&d| inputs.draws[d].name.clone()));
                }
                plans.push(Plan::Correlated {
                    draws: cluster.draws.clone(),
                    root: square_root(r)?,
                    marginals,
                    shared: match common {
                        Some(dof) => Some((chi_squared(dof)?, dof)),
                        None => None,
                    },
                });
                continue;
            }
            // Several draws without correlation: of one input, or of inputs that were observed together.
            let marginals: Vec<Distribution> =
                cluster.draws.iter().map(|&d| distribution(d)).collect();
            match common_dof(&marginals) {
                Some(dof) if marginals.len() > 1 => plans.push(Plan::SharedScale {
                    draws: cluster
                        .draws
                        .iter()
                        .zip(&marginals)
                        .filter_map(|(&draw, marginal)| match marginal {
                            Distribution::StudentT {
                                location, scale, ..
                            } => Some((draw, *location, *scale)),
                            _ => None,
                        })
                        .collect(),
                    chi_squared: chi_squared(dof)?,
                    dof,
                }),
                _ => {
                    for (&draw, marginal) in cluster.draws.iter().zip(&marginals) {
                        plans.push(Plan::Alone {
                            draw,
                            source: Source::new(marginal)?,
                        });
                    }
                }
            }
        }
        Ok(Self {
            plans,
            size: inputs.draws.len(),
            copula,
        })
    }

    /// Fills [`STRIP`] trials, each a row of n draws.
    pub fn fill(&self, rows: &mut [f64], rng: &mut Xoshiro256PlusPlus) {
        let n = self.size.max(1);
        let mut strip = [0.0; STRIP];
        let mut z = Vec::new();
        for plan in &self.plans {
            match plan {
                Plan::Alone { draw, source } => {
                    source.fill(&mut strip, rng);
                    for (row, x) in rows.chunks_exact_mut(n).zip(&strip) {
                        row[*draw] = *x;
                    }
                }
                Plan::SharedScale {
                    draws,
                    chi_squared,
                    dof,
                } => {
                    for row in rows.chunks_exact_mut(n) {
                        let stretch = (dof / chi_squared.sample(rng)).sqrt();
                        for (d, location, scale) in draws {
                            row[*d] =
                                location + scale * stretch * rng.sample::<f64, _>(StandardNormal);
                        }
                    }
                }
                Plan::Correlated {
                    draws,
                    root,
                    marginals,
                    shared,
                } => {
                    let m = draws.len();
                    for row in rows.chunks_exact_mut(n) {
                        z.clear();
                        z.extend((0..m).map(|_| rng.sample::<f64, _>(StandardNormal)));
                        let stretch = shared.as_ref().map_or(1.0, |(chi_squared, dof)| {
                            (dof / chi_squared.sample(rng)).sqrt()
                        });
                        for (a, &d) in draws.iter().enumerate() {
                            let g: f64 = root[a * m..(a + 1) * m]
                                .iter()
                                .zip(&z)
                                .map(|(r, z)| r * z)
                                .sum();
                            row[d] = match &marginals[a] {
                                Distribution::Normal { mean, u } => mean + u * g,
                                Distribution::StudentT {
                                    location, scale, ..
                                } if shared.is_some() => location + scale * stretch * g,
                                other => other.quantile(normal_probability(g)),
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

fn chi_squared(dof: f64) -> Result<ChiSquared<f64>, Error> {
    ChiSquared::new(dof).map_err(|_| Error::OutOfRange {
        name: "degrees of freedom",
        value: dof,
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    })
}

fn common_dof(marginals: &[Distribution]) -> Option<f64> {
    let mut common = None;
    for marginal in marginals {
        match (marginal, common) {
            (Distribution::StudentT { dof, .. }, None) => common = Some(*dof),
            (Distribution::StudentT { dof, .. }, Some(nu)) if *dof == nu => {}
            _ => return None,
        }
    }
    common
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
            Distribution::Samples { values } => Self::Samples(values.clone()),
        })
    }

    /// One draw of a strip of trials.
    fn fill(&self, column: &mut [f64; STRIP], rng: &mut Xoshiro256PlusPlus) {
        match self {
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
            Self::Samples(values) => {
                for x in column {
                    *x = values[rng.random_range(0..values.len())];
                }
            }
        }
    }
}
