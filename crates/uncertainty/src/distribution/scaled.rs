//! A quantity in other units.

use super::Distribution;

impl Distribution {
    /// The distribution of `factor` × x + `offset`, for a positive factor: another unit, or an error about zero.
    ///
    /// ```
    /// use proofmass_uncertainty::Distribution;
    /// let degrees = Distribution::Rectangular { lower: -0.1, upper: 0.1 };
    /// let radians = degrees.scaled(1f64.to_radians(), 0.0);
    /// assert!((radians.standard_uncertainty() - 0.1f64.to_radians() / 3f64.sqrt()).abs() < 1e-18);
    /// ```
    #[must_use]
    pub fn scaled(&self, factor: f64, offset: f64) -> Self {
        let at = |x: f64| factor * x + offset;
        match self {
            Self::Normal { mean, u } => Self::Normal {
                mean: at(*mean),
                u: factor * u,
            },
            Self::StudentT {
                location,
                scale,
                dof,
            } => Self::StudentT {
                location: at(*location),
                scale: factor * scale,
                dof: *dof,
            },
            Self::Rectangular { lower, upper } => Self::Rectangular {
                lower: at(*lower),
                upper: at(*upper),
            },
            Self::Triangular { lower, upper } => Self::Triangular {
                lower: at(*lower),
                upper: at(*upper),
            },
            Self::Trapezoidal { lower, upper, beta } => Self::Trapezoidal {
                lower: at(*lower),
                upper: at(*upper),
                beta: *beta,
            },
            Self::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => Self::CurvilinearTrapezoid {
                lower: at(*lower),
                upper: at(*upper),
                inexactness: factor * inexactness,
            },
            Self::Arcsine { lower, upper } => Self::Arcsine {
                lower: at(*lower),
                upper: at(*upper),
            },
            Self::TruncatedNormal {
                mean,
                sd,
                lower,
                upper,
            } => Self::TruncatedNormal {
                mean: at(*mean),
                sd: factor * sd,
                lower: at(*lower).max(f64::MIN),
                upper: at(*upper).min(f64::MAX),
            },
            Self::Exponential { lower, mean } => Self::Exponential {
                lower: at(*lower),
                mean: at(*mean),
            },
            Self::Gamma {
                lower,
                shape,
                scale,
            } => Self::Gamma {
                lower: at(*lower),
                shape: *shape,
                scale: factor * scale,
            },
            Self::Lognormal {
                lower,
                median,
                sigma,
            } => Self::Lognormal {
                lower: at(*lower),
                median: factor * median,
                sigma: *sigma,
            },
            Self::Beta {
                lower,
                upper,
                alpha,
                beta,
            } => Self::Beta {
                lower: at(*lower),
                upper: at(*upper),
                alpha: *alpha,
                beta: *beta,
            },
            Self::Poisson { lower, scale, mean } => Self::Poisson {
                lower: at(*lower),
                scale: factor * scale,
                mean: *mean,
            },
            Self::Discrete { values, weights } => Self::Discrete {
                values: values.iter().map(|v| at(*v)).collect(),
                weights: weights.clone(),
            },
            Self::Samples { values } => Self::Samples {
                values: values.iter().map(|v| at(*v)).collect(),
            },
        }
    }
}
