//! Parameters that make a distribution.

use super::{Distribution, mean_and_variance, positive};
use proofmass_core::Error;
use proofmass_core::check::within;

impl Distribution {
    /// Whether the parameters name a distribution.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`], [`Error::TooFew`] for the first rule broken.
    pub fn check(&self) -> Result<(), Error> {
        let finite = |values: &[(&'static str, f64)]| match values.iter().find(|v| !v.1.is_finite())
        {
            Some(&(name, value)) => Err(Error::OutOfRange {
                name,
                value,
                min: f64::MIN,
                max: f64::MAX,
            }),
            None => Ok(()),
        };
        match self {
            Self::Normal { mean, u } => {
                finite(&[("mean", *mean), ("u", *u)])?;
                within("u", *u, 0.0, f64::MAX)
            }
            Self::StudentT {
                location,
                scale,
                dof,
            } => {
                finite(&[("location", *location), ("scale", *scale), ("dof", *dof)])?;
                within("scale", *scale, 0.0, f64::MAX)?;
                // One observation more than parameters gives 1; pooled values may fall a little below.
                within("dof", *dof, 0.5, f64::MAX)
            }
            Self::Rectangular { lower, upper }
            | Self::Triangular { lower, upper }
            | Self::Arcsine { lower, upper } => {
                finite(&[("lower", *lower), ("upper", *upper)])?;
                within("upper", *upper, *lower, f64::MAX)
            }
            Self::Trapezoidal { lower, upper, beta } => {
                finite(&[("lower", *lower), ("upper", *upper), ("beta", *beta)])?;
                within("upper", *upper, *lower, f64::MAX)?;
                within("beta", *beta, 0.0, 1.0)
            }
            Self::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => {
                finite(&[
                    ("lower", *lower),
                    ("upper", *upper),
                    ("inexactness", *inexactness),
                ])?;
                within("upper", *upper, *lower, f64::MAX)?;
                within("inexactness", *inexactness, 0.0, 0.5 * (upper - lower))
            }
            Self::TruncatedNormal {
                mean,
                sd,
                lower,
                upper,
            } => {
                finite(&[
                    ("mean", *mean),
                    ("sd", *sd),
                    ("lower", *lower),
                    ("upper", *upper),
                ])?;
                within("sd", *sd, f64::MIN_POSITIVE, f64::MAX)?;
                within("upper", *upper, *lower, f64::MAX)?;
                // Farther out than 30 standard deviations the normal has no double left to truncate.
                within("lower", *lower, f64::MIN, mean + 30.0 * sd)?;
                within("upper", *upper, mean - 30.0 * sd, f64::MAX)
            }
            Self::Exponential { lower, mean } => {
                finite(&[("lower", *lower), ("mean", *mean)])?;
                within("mean", *mean, *lower, f64::MAX)
            }
            Self::Gamma {
                lower,
                shape,
                scale,
            } => {
                finite(&[("lower", *lower), ("shape", *shape), ("scale", *scale)])?;
                within("shape", *shape, 1e-3, 1e12)?;
                within("scale", *scale, 0.0, f64::MAX)
            }
            Self::Lognormal {
                lower,
                median,
                sigma,
            } => {
                finite(&[("lower", *lower), ("median", *median), ("sigma", *sigma)])?;
                within("median", *median, 0.0, f64::MAX)?;
                // Beyond, the standard deviation leaves the range of doubles.
                within("sigma", *sigma, 0.0, 15.0)
            }
            Self::Beta {
                lower,
                upper,
                alpha,
                beta,
            } => {
                finite(&[
                    ("lower", *lower),
                    ("upper", *upper),
                    ("alpha", *alpha),
                    ("beta", *beta),
                ])?;
                within("upper", *upper, *lower, f64::MAX)?;
                within("alpha", *alpha, 1e-2, 1e9)?;
                within("beta", *beta, 1e-2, 1e9)
            }
            Self::Poisson { lower, scale, mean } => {
                finite(&[("lower", *lower), ("scale", *scale), ("mean", *mean)])?;
                within("scale", *scale, 0.0, f64::MAX)?;
                within("mean", *mean, 0.0, 1e15)
            }
            Self::Discrete { values, weights } => positive::check_discrete(values, weights),
            Self::Samples { values } => mean_and_variance("samples", values).map(|_| ()),
        }
    }
}
