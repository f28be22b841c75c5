//! What is known about one input, as a probability distribution.

mod check;
mod positive;
mod quantile;
mod scaled;

#[cfg(feature = "monte-carlo")]
pub(crate) use positive::weights as discrete_weights;

use crate::DegreesOfFreedom;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// The state of knowledge of an input. **Source** `[S1] 6.4`, table 1.
///
/// ```
/// use proofmass_uncertainty::Distribution;
/// let resolution = Distribution::Rectangular { lower: -0.5, upper: 0.5 };
/// assert!((resolution.standard_uncertainty() - 0.288_675).abs() < 1e-6); // a/√3, `[GUM]` 4.3.7
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Distribution {
    /// A value with a standard uncertainty, known well.
    Normal {
        /// Estimate.
        mean: f64,
        /// Standard uncertainty.
        u: f64,
    },
    /// A mean of observations: location, s/√n, n − 1. The standard uncertainty is the scale, as in the GUM; the
    /// standard deviation of the distribution is larger by √(ν/(ν − 2)), which Monte Carlo shows.
    StudentT {
        /// Estimate.
        location: f64,
        /// Scale: experimental standard deviation of the mean.
        scale: f64,
        /// Degrees of freedom.
        dof: f64,
    },
    /// Anywhere between two limits alike.
    Rectangular {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// Sum of two rectangular ones of equal width.
    Triangular {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// Sum of two rectangular ones; β is top over base width.
    Trapezoidal {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
        /// Top width over base width, 0 (triangular) to 1 (rectangular).
        beta: f64,
    },
    /// Rectangular whose limits are themselves known only to ± `inexactness`.
    CurvilinearTrapezoid {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
        /// Half-width of the doubt about each limit.
        inexactness: f64,
    },
    /// A sinusoid of unknown phase between two limits.
    Arcsine {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// Normal, known to lie between two limits, or on one side of one of them.
    TruncatedNormal {
        /// Mean before truncation.
        mean: f64,
        /// Standard deviation before truncation.
        sd: f64,
        /// Lower limit; without it the least double.
        #[serde(default = "positive::lowest")]
        lower: f64,
        /// Upper limit; without it the largest double.
        #[serde(default = "positive::highest")]
        upper: f64,
    },
    /// Above a limit, of which only the mean is known. **Source** `[S1] 6.4.10`.
    Exponential {
        /// Lower limit.
        #[serde(default)]
        lower: f64,
        /// Mean.
        mean: f64,
    },
    /// Above a limit. A count of q events leaves shape q + 1 and scale 1 for its expectation. **Source** `[S1] 6.4.11`.
    Gamma {
        /// Lower limit.
        #[serde(default)]
        lower: f64,
        /// Shape α.
        shape: f64,
        /// Scale θ; the mean above the limit is α θ.
        scale: f64,
    },
    /// Above a limit, with a normal logarithm.
    Lognormal {
        /// Lower limit.
        #[serde(default)]
        lower: f64,
        /// Median above the limit.
        median: f64,
        /// Standard deviation of the logarithm; for small ones the relative standard uncertainty.
        sigma: f64,
    },
    /// Between two limits, of any slope.
    Beta {
        /// Lower limit.
        #[serde(default)]
        lower: f64,
        /// Upper limit.
        #[serde(default = "positive::one")]
        upper: f64,
        /// α: weight near the upper limit.
        alpha: f64,
        /// β: weight near the lower limit.
        beta: f64,
    },
    /// A number of independent events, times a scale.
    Poisson {
        /// Value of no event.
        #[serde(default)]
        lower: f64,
        /// Value of each event.
        #[serde(default = "positive::one")]
        scale: f64,
        /// Expected number of events.
        mean: f64,
    },
    /// One of several values.
    Discrete {
        /// The values.
        values: Vec<f64>,
        /// Their weights, in any unit; equal without them.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        weights: Vec<f64>,
    },
    /// Samples of another Monte Carlo calculation, drawn with replacement.
    Samples {
        /// The samples.
        values: Vec<f64>,
    },
}

/// Kind and parameters, for a reader: `rectangular from 9.5e-6 to 1.35e-5`.
impl std::fmt::Display for Distribution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = self.name();
        match self {
            Self::Normal { mean, u } => write!(f, "{name}, mean {mean:?}, u {u:?}"),
            Self::StudentT {
                location,
                scale,
                dof,
            } => write!(
                f,
                "{name}, location {location:?}, scale {scale:?}, ν = {dof}"
            ),
            Self::Rectangular { lower, upper }
            | Self::Triangular { lower, upper }
            | Self::Arcsine { lower, upper } => write!(f, "{name} from {lower:?} to {upper:?}"),
            Self::Trapezoidal { lower, upper, beta } => {
                write!(f, "{name} from {lower:?} to {upper:?}, β = {beta}")
            }
            Self::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => write!(
                f,
                "{name} from {lower:?} to {upper:?}, limits ± {inexactness:?}"
            ),
            Self::TruncatedNormal {
                mean,
                sd,
                lower,
                upper,
            } => {
                write!(f, "{name}, mean {mean:?}, standard deviation {sd:?}")?;
                if *lower > f64::MIN {
                    write!(f, ", not below {lower:?}")?;
                }
                if *upper < f64::MAX {
                    write!(f, ", not above {upper:?}")?;
                }
                Ok(())
            }
            Self::Exponential { lower, mean } => {
                write!(f, "{name} above {lower:?}, mean {mean:?}")
            }
            Self::Gamma {
                lower,
                shape,
                scale,
            } => write!(f, "{name} above {lower:?}, shape {shape}, scale {scale:?}"),
            Self::Lognormal {
                lower,
                median,
                sigma,
            } => write!(
                f,
                "{name} above {lower:?}, median {median:?}, σ of the logarithm {sigma}"
            ),
            Self::Beta {
                lower,
                upper,
                alpha,
                beta,
            } => write!(
                f,
                "{name} from {lower:?} to {upper:?}, α = {alpha}, β = {beta}"
            ),
            Self::Poisson { lower, scale, mean } => {
                write!(f, "{name}, {mean} events of {scale:?} above {lower:?}")
            }
            Self::Discrete { values, .. } => write!(f, "{name}, {} values", values.len()),
            Self::Samples { values } => write!(f, "{} {name}", values.len()),
        }
    }
}

impl Distribution {
    /// From observations repeated under the same conditions: Student t of their mean.
    ///
    /// # Errors
    /// [`Error::TooFew`] below two observations, [`Error::NotFinite`].
    ///
    /// **Source** `[GUM] 4.2`, `[S1] 6.4.9.2`.
    pub fn from_observations(observations: &[f64]) -> Result<Self, Error> {
        let (mean, variance) = mean_and_variance("observations", observations)?;
        let n = observations.len() as f64;
        Ok(Self::StudentT {
            location: mean,
            scale: (variance / n).sqrt(),
            dof: n - 1.0,
        })
    }

    /// The word a budget prints.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Normal { .. } => "normal",
            Self::StudentT { .. } => "Student t",
            Self::Rectangular { .. } => "rectangular",
            Self::Triangular { .. } => "triangular",
            Self::Trapezoidal { .. } => "trapezoidal",
            Self::CurvilinearTrapezoid { .. } => "curvilinear trapezoid",
            Self::Arcsine { .. } => "arcsine",
            Self::TruncatedNormal { .. } => "truncated normal",
            Self::Exponential { .. } => "exponential",
            Self::Gamma { .. } => "gamma",
            Self::Lognormal { .. } => "lognormal",
            Self::Beta { .. } => "beta",
            Self::Poisson { .. } => "Poisson",
            Self::Discrete { .. } => "discrete",
            Self::Samples { .. } => "samples",
        }
    }

    /// The estimate: the mean of the distribution.
    pub fn estimate(&self) -> f64 {
        match self {
            Self::Normal { mean, .. } => *mean,
            Self::StudentT { location, .. } => *location,
            Self::Rectangular { lower, upper }
            | Self::Triangular { lower, upper }
            | Self::Trapezoidal { lower, upper, .. }
            | Self::CurvilinearTrapezoid { lower, upper, .. }
            | Self::Arcsine { lower, upper } => 0.5 * (lower + upper),
            Self::TruncatedNormal { .. } => self.truncated_moments().0,
            other @ (Self::Exponential { .. }
            | Self::Gamma { .. }
            | Self::Lognormal { .. }
            | Self::Beta { .. }
            | Self::Poisson { .. }
            | Self::Discrete { .. }) => positive::moments(other).0,
            Self::Samples { values } => {
                mean_and_variance("samples", values).map_or(0.0, |(mean, _)| mean)
            }
        }
    }

    /// The standard uncertainty.
    pub fn standard_uncertainty(&self) -> f64 {
        match self {
            Self::Normal { u, .. } => *u,
            Self::StudentT { scale, .. } => *scale,
            Self::Rectangular { lower, upper } => 0.5 * (upper - lower) / 3f64.sqrt(),
            Self::Triangular { lower, upper } => 0.5 * (upper - lower) / 6f64.sqrt(),
            Self::Trapezoidal { lower, upper, beta } => {
                0.5 * (upper - lower) * ((1.0 + beta * beta) / 6.0).sqrt()
            }
            Self::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => ((upper - lower).powi(2) / 12.0 + inexactness * inexactness / 9.0).sqrt(),
            Self::Arcsine { lower, upper } => 0.5 * (upper - lower) / 2f64.sqrt(),
            Self::TruncatedNormal { .. } => self.truncated_moments().1,
            other @ (Self::Exponential { .. }
            | Self::Gamma { .. }
            | Self::Lognormal { .. }
            | Self::Beta { .. }
            | Self::Poisson { .. }
            | Self::Discrete { .. }) => positive::moments(other).1,
            // All of a distribution, not a sample of it: n, not n − 1.
            Self::Samples { values } => {
                mean_and_variance("samples", values).map_or(0.0, |(_, v)| {
                    let n = values.len() as f64;
                    (v * (n - 1.0) / n).sqrt()
                })
            }
        }
    }

    /// Whether it has two limits, which a finite number of degrees of freedom puts in doubt.
    pub fn is_bounded(&self) -> bool {
        matches!(
            self,
            Self::Rectangular { .. }
                | Self::Triangular { .. }
                | Self::Trapezoidal { .. }
                | Self::CurvilinearTrapezoid { .. }
                | Self::Arcsine { .. }
                | Self::TruncatedNormal { .. }
                | Self::Beta { .. }
        )
    }

    /// Degrees of freedom: finite for Student t, infinite otherwise.
    pub fn dof(&self) -> DegreesOfFreedom {
        match self {
            Self::StudentT { dof, .. } => {
                DegreesOfFreedom::new(*dof).unwrap_or(DegreesOfFreedom::INFINITE)
            }
            _ => DegreesOfFreedom::INFINITE,
        }
    }

    /// Mean and standard deviation of the truncated normal.
    fn truncated_moments(&self) -> (f64, f64) {
        let Self::TruncatedNormal {
            mean,
            sd,
            lower,
            upper,
        } = self
        else {
            return (0.0, 0.0);
        };
        // Gauss–Legendre would do; midpoints of 2000 equal shares of probability are exact enough for the mean
        // only, so integrate the density instead: Simpson over the part within 9 standard deviations.
        let (a, b) = ((lower - mean) / sd, (upper - mean) / sd);
        let near = if a > 0.0 {
            a
        } else if b < 0.0 {
            b
        } else {
            0.0
        };
        let (low, high) = (a.max(near - 9.0), b.min(near + 9.0));
        let n = 2000;
        let h = (high - low) / f64::from(n);
        let (mut s0, mut s1, mut s2) = (0.0, 0.0, 0.0);
        for i in 0..=n {
            let weight = if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            let z = low + h * f64::from(i);
            let f = weight * (-0.5 * (z * z - near * near)).exp();
            let d = z - near;
            s0 += f;
            s1 += f * d;
            s2 += f * d * d;
        }
        let m = s1 / s0;
        (
            mean + sd * (near + m),
            sd * (s2 / s0 - m * m).max(0.0).sqrt(),
        )
    }
}

fn mean_and_variance(name: &'static str, values: &[f64]) -> Result<(f64, f64), Error> {
    if values.len() < 2 {
        return Err(Error::TooFew {
            name,
            needed: 2,
            got: values.len(),
        });
    }
    proofmass_core::check::finite(name, values)?;
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Ok((mean, variance))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and standard deviation from the quantile function, ∫₀¹ Q(p) dp by midpoints.
    #[test]
    fn law_quantiles_have_the_stated_moments() {
        let n = 100_000;
        for d in [
            Distribution::Normal { mean: 2.0, u: 0.5 },
            Distribution::Rectangular {
                lower: 1.0,
                upper: 4.0,
            },
            Distribution::Triangular {
                lower: 1.0,
                upper: 4.0,
            },
            Distribution::Trapezoidal {
                lower: 1.0,
                upper: 4.0,
                beta: 0.3,
            },
            Distribution::CurvilinearTrapezoid {
                lower: 1.0,
                upper: 4.0,
                inexactness: 0.6,
            },
            Distribution::Arcsine {
                lower: 1.0,
                upper: 4.0,
            },
            Distribution::TruncatedNormal {
                mean: 0.0,
                sd: 1.0,
                lower: -0.5,
                upper: 3.0,
            },
            Distribution::TruncatedNormal {
                mean: 0.0,
                sd: 1.0,
                lower: 5.0,
                upper: 9.0,
            },
            Distribution::TruncatedNormal {
                mean: 1.0,
                sd: 2.0,
                lower: 0.0,
                upper: f64::MAX,
            },
            Distribution::Exponential {
                lower: 1.0,
                mean: 3.0,
            },
            Distribution::Gamma {
                lower: 0.5,
                shape: 7.0,
                scale: 0.3,
            },
            Distribution::Lognormal {
                lower: 0.0,
                median: 2.0,
                sigma: 0.3,
            },
            Distribution::Beta {
                lower: 1.0,
                upper: 4.0,
                alpha: 2.0,
                beta: 3.5,
            },
            Distribution::Poisson {
                lower: 0.0,
                scale: 1.0,
                mean: 4.2,
            },
            Distribution::Discrete {
                values: vec![3.0, 1.0, 7.0],
                weights: vec![1.0, 2.0, 1.0],
            },
        ] {
            d.check().unwrap();
            let (mean, u) = (d.estimate(), d.standard_uncertainty());
            let (mut s1, mut s2) = (0.0, 0.0);
            for i in 0..n {
                let x = d.quantile((i as f64 + 0.5) / n as f64) - mean;
                s1 += x;
                s2 += x * x;
            }
            assert!((s1 / n as f64).abs() < 1e-4 * u, "{d:?}");
            assert!(((s2 / n as f64).sqrt() / u - 1.0).abs() < 3e-4, "{d:?}");
        }
    }

    #[test]
    fn refuses_impossible_parameters() {
        assert!(
            Distribution::Rectangular {
                lower: 2.0,
                upper: 1.0
            }
            .check()
            .is_err()
        );
        assert!(
            Distribution::Normal {
                mean: f64::NAN,
                u: 1.0
            }
            .check()
            .is_err()
        );
        assert!(
            Distribution::StudentT {
                location: 0.0,
                scale: 1.0,
                dof: 0.0
            }
            .check()
            .is_err()
        );
        assert!(Distribution::from_observations(&[1.0]).is_err());
    }
}
