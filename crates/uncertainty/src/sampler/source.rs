//! Draws of one input by itself.

use super::stretch::Stretch;
use super::strips::{Words, fill_words, fraction};
use crate::Distribution;
use crate::ziggurat::StudentZiggurat;
use proofmass_core::Error;
use rand::RngExt;
use rand_distr::{Beta, Distribution as _, Exp1, Gamma, Poisson, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

pub(super) enum Source {
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

/// A parameter that the sampler cannot use.
fn beyond(name: &'static str, value: f64) -> Error {
    Error::OutOfRange {
        name,
        value,
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    }
}

impl Source {
    pub fn new(distribution: &Distribution) -> Result<Self, Error> {
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
    pub fn fill(&self, column: &mut [f64], words: &mut Words, rng: &mut Xoshiro256PlusPlus) {
        let count = column.len();
        match self {
            Self::Stretched {
                inner,
                middle,
                stretch,
            } => {
                inner.fill(column, words, rng);
                for x in column {
                    *x = middle + stretch.draw(rng) * (*x - middle);
                }
            }
            Self::Constant(value) => column.fill(*value),
            // The generator is copied out and back, so that its state stays in registers.
            Self::Normal { mean, u } => {
                let mut state = rng.clone();
                for x in column {
                    let z: f64 = StandardNormal.sample(&mut state);
                    *x = mean + u * z;
                }
                *rng = state;
            }
            Self::StudentT { location, scale, t } => {
                fill_words(&mut words.first[..count], rng);
                for (x, word) in column.iter_mut().zip(&words.first) {
                    *x = location + scale * t.shape(*word, rng);
                }
            }
            Self::Rectangular { lower, width } => {
                fill_words(&mut words.first[..count], rng);
                for (x, word) in column.iter_mut().zip(&words.first) {
                    *x = lower + width * fraction(*word);
                }
            }
            // Sum of two rectangular variables. `[S1]` 6.4.4.3
            Self::Trapezoidal { lower, top, slope } => {
                words.fill(count, rng);
                for ((x, a), b) in column.iter_mut().zip(&words.first).zip(&words.second) {
                    *x = lower + top * fraction(*a) + slope * fraction(*b);
                }
            }
            // The lower limit is drawn first and mirrored about the middle. `[S1]` 6.4.3.4
            Self::Curvilinear { lower, span, d } => {
                words.fill(count, rng);
                for ((x, a), b) in column.iter_mut().zip(&words.first).zip(&words.second) {
                    let a = lower + 2.0 * d * fraction(*a);
                    *x = a + (span - 2.0 * a) * fraction(*b);
                }
            }
            // The cosine of a uniform angle from a point in the unit disc: cos 2θ = (a² − b²)/(a² + b²). Points
            // outside are overwritten by the next one, which costs less than a branch that goes either way.
            Self::Arcsine { middle, half } => {
                let mut filled = 0;
                while filled < column.len() {
                    words.fill(count, rng);
                    for (a, b) in words.first[..count].iter().zip(&words.second) {
                        let (a, b) = (2.0 * fraction(*a) - 1.0, fraction(*b));
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
