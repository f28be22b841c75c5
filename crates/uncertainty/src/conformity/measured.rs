//! What a measurement says of a measurand.

use super::Limits;
use crate::{DegreesOfFreedom, Quantity};
use proofmass_core::Error;
use statrs::function::beta::beta_reg;
use statrs::function::erf::erfc;

/// The distribution that a measurement leaves for its measurand where nothing else is known of the item.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    value: f64,
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Student's t about the value, scaled by u.
    Student { u: f64, dof: DegreesOfFreedom },
    /// Trials of a Monte Carlo calculation, in their order of size.
    Trials(Vec<f64>),
}

impl Measured {
    /// Student's t at the degrees of freedom of a quantity.
    pub fn of(quantity: &Quantity) -> Self {
        Self {
            value: quantity.value,
            shape: Shape::Student {
                u: quantity.standard_uncertainty,
                dof: quantity.dof,
            },
        }
    }

    /// The trials of a Monte Carlo calculation that states `value`.
    ///
    /// # Errors
    /// [`Error::TooFew`] without trials, [`Error::NotFinite`] for one that is not a finite number.
    pub fn of_trials(value: f64, mut trials: Vec<f64>) -> Result<Self, Error> {
        if trials.is_empty() {
            return Err(Error::TooFew {
                name: "trials",
                needed: 1,
                got: 0,
            });
        }
        proofmass_core::check::finite("trial", &trials)?;
        trials.sort_by(f64::total_cmp);
        Ok(Self {
            value,
            shape: Shape::Trials(trials),
        })
    }

    /// The estimate.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Probability between two values.
    pub(super) fn chance_between(&self, lower: f64, upper: f64) -> f64 {
        self.chance_within(&Limits {
            lower: Some(lower),
            upper: Some(upper),
        })
    }

    /// Probability within limits.
    pub(super) fn chance_within(&self, limits: &Limits) -> f64 {
        let chance = match &self.shape {
            Shape::Student { u, .. } if !(*u > 0.0) => {
                f64::from(u8::from(limits.contains(self.value)))
            }
            Shape::Student { u, dof } => {
                let below = limits.lower.map(|l| (self.value - l) / u);
                let above = limits.upper.map(|h| (h - self.value) / u);
                // Far to one side the difference of two tails keeps the digits that 1 − both would lose.
                match (below, above) {
                    (Some(b), Some(a)) if b < 0.0 => upper_tail(-b, *dof) - upper_tail(a, *dof),
                    (Some(b), Some(a)) if a < 0.0 => upper_tail(-a, *dof) - upper_tail(b, *dof),
                    _ => {
                        let tail = |t: Option<f64>| t.map_or(0.0, |t| upper_tail(t, *dof));
                        1.0 - tail(below) - tail(above)
                    }
                }
            }
            Shape::Trials(trials) => {
                let from = limits
                    .lower
                    .map_or(0, |l| trials.partition_point(|t| *t < l));
                let to = limits
                    .upper
                    .map_or(trials.len(), |h| trials.partition_point(|t| *t <= h));
                to.saturating_sub(from) as f64 / trials.len() as f64
            }
        };
        chance.clamp(0.0, 1.0)
    }
}

pub(super) fn normal_tail(z: f64) -> f64 {
    0.5 * erfc(z / std::f64::consts::SQRT_2)
}

/// P(T > t).
fn upper_tail(t: f64, dof: DegreesOfFreedom) -> f64 {
    let nu = dof.get();
    if nu > 1e6 {
        return normal_tail(t);
    }
    let two = beta_reg(0.5 * nu, 0.5, nu / (nu + t * t));
    if t >= 0.0 { 0.5 * two } else { 1.0 - 0.5 * two }
}
