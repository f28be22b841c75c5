//! Doubt about a standard deviation: a random factor about the estimate.

use crate::input::Doubt;
use proofmass_core::Error;
use rand::RngExt;
use rand_distr::{ChiSquared, Distribution as _};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A random factor about the estimate.
pub(super) enum Stretch {
    Chi(ChiSquared<f64>, f64),
    Limits(f64),
}

impl Stretch {
    pub fn new(doubt: Doubt) -> Result<Option<Self>, Error> {
        Ok(match doubt {
            Doubt::None => None,
            Doubt::Scale(dof) => Some(Self::Chi(chi_squared(dof)?, dof)),
            Doubt::Limits(share) => Some(Self::Limits(share)),
        })
    }

    pub fn draw(&self, rng: &mut Xoshiro256PlusPlus) -> f64 {
        match self {
            Self::Chi(chi_squared, dof) => (dof / chi_squared.sample(rng)).sqrt(),
            Self::Limits(share) => 1.0 + share * (2.0 * rng.random::<f64>() - 1.0),
        }
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
