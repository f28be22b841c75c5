//! Does an item conform? Decisions with an uncertainty, their guard bands and their risks.

mod measured;
mod prior;

pub use measured::Measured;

use crate::Distribution;
use crate::quantile::normal_quantile;
use prior::Cells;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// The values that a requirement permits: two limits, or one.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, DecisionRule, Distribution, Limits, Measured, Quantity};
/// // A Zener diode may break down at −5.40 V at most; it was measured at −5.47 V with u = 0.05 V (7.4, example 1).
/// let diode = Measured::of(&Quantity {
///     name: "V".into(), unit: "V".into(), value: -5.47, standard_uncertainty: 0.05, dof: DegreesOfFreedom::INFINITE,
/// });
/// let limits = Limits::below(-5.40)?;
/// assert!((limits.probability(&diode) - 0.92).abs() < 0.005);
/// // With a guard band of U = 0.1 V it is accepted up to −5.50 V, and this one is not.
/// let decision = limits.decide(&diode, 0.1, DecisionRule::GuardBand { factor: 1.0 }, None)?;
/// assert!(!decision.accepted && decision.acceptance.upper == Some(-5.50));
///
/// // Ball bearings whose radial error motion is a gamma distribution may have 2 µm at most (9.5.4): measured with
/// // u = 0.25 µm, 0.8 % of all are accepted wrongly, and 0.1 % with a guard band of 0.33 µm.
/// let bearings = Distribution::Gamma { lower: 0.0, shape: 4.0, scale: 0.25 };
/// let bearing = Measured::of(&Quantity {
///     name: "e".into(), unit: "µm".into(), value: 1.0, standard_uncertainty: 0.25, dof: DegreesOfFreedom::INFINITE,
/// });
/// let limits = Limits::below(2.0)?;
/// let simple = limits.global_risk(&limits, &bearings, &bearing)?;
/// let guarded = limits.global_risk(&limits.narrowed(0.33), &bearings, &bearing)?;
/// assert!((simple.consumer - 0.008).abs() < 0.0005 && (guarded.consumer - 0.001).abs() < 0.0005);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// **Source** `[JCGM106]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Limits {
    /// Lower limit.
    pub lower: Option<f64>,
    /// Upper limit.
    pub upper: Option<f64>,
}

/// When an item is accepted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DecisionRule {
    /// The estimate lies within the limits. **Source** `[JCGM106] 8.2`.
    SimpleAcceptance,
    /// The estimate lies within limits that a guard band w = factor × U narrows (a negative factor widens them:
    /// guarded rejection). **Source** `[JCGM106] 8.3`.
    GuardBand {
        /// r = w/U.
        factor: f64,
    },
    /// The probability of conformity reaches a least value.
    LeastProbability(f64),
}

/// A decision about one item.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Conformity {
    /// Probability that the item conforms.
    pub probability: f64,
    /// Whether it is accepted.
    pub accepted: bool,
    /// Probability that the decision is wrong: the specific risk of the consumer where it is accepted, of the producer
    /// where it is rejected.
    pub risk: f64,
    /// Guard band w; none where the rule is a probability.
    pub guard_band: Option<f64>,
    /// Limits between which the estimate is accepted; those of the requirement where the rule is a probability.
    pub acceptance: Limits,
    /// Risks over the whole production, where one is stated and the rule is a pair of limits.
    pub global: Option<GlobalRisk>,
}

/// Risks over a whole production. **Source** `[JCGM106] 9.5`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GlobalRisk {
    /// Probability that an item is accepted and does not conform.
    pub consumer: f64,
    /// Probability that an item is rejected and conforms.
    pub producer: f64,
}

/// What a whole interval says about limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The whole interval lies within the limits.
    Pass,
    /// The whole interval lies beyond a limit.
    Fail,
    /// A limit lies in the interval.
    Undecided,
}

impl Limits {
    /// Judges with the interval as guard band on either side: guarded acceptance, guarded rejection, and what is neither.
    ///
    /// With a two-sided interval at probability p an item beyond a limit passes with a probability of at most (1 − p)/2, and
    /// one within the limits fails with at most that: 2.5 % at 95 %.
    ///
    /// ```
    /// use proofmass_uncertainty::{Judgement, Limits};
    /// let limits = Limits::below(2.0)?;
    /// assert_eq!(limits.judge((1.2, 1.8)), Judgement::Pass);
    /// assert_eq!(limits.judge((1.8, 2.4)), Judgement::Undecided);
    /// assert_eq!(limits.judge((2.1, 2.7)), Judgement::Fail);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// **Source** `[JCGM106] 8.3`.
    pub fn judge(&self, (low, high): (f64, f64)) -> Judgement {
        if self.contains(low) && self.contains(high) {
            Judgement::Pass
        } else if self.lower.is_some_and(|l| high < l) || self.upper.is_some_and(|u| low > u) {
            Judgement::Fail
        } else {
            Judgement::Undecided
        }
    }

    /// Between two limits.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless lower < upper, both finite.
    pub fn between(lower: f64, upper: f64) -> Result<Self, Error> {
        if !(lower < upper && lower.is_finite() && upper.is_finite()) {
            return Err(Error::OutOfRange {
                name: "upper limit",
                value: upper,
                min: lower,
                max: f64::MAX,
            });
        }
        Ok(Self {
            lower: Some(lower),
            upper: Some(upper),
        })
    }

    /// Not below a limit.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn above(lower: f64) -> Result<Self, Error> {
        finite(lower)?;
        Ok(Self {
            lower: Some(lower),
            upper: None,
        })
    }

    /// Not above a limit.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn below(upper: f64) -> Result<Self, Error> {
        finite(upper)?;
        Ok(Self {
            lower: None,
            upper: Some(upper),
        })
    }

    /// Whether they contain a value.
    pub fn contains(&self, x: f64) -> bool {
        self.lower.is_none_or(|l| x >= l) && self.upper.is_none_or(|u| x <= u)
    }

    /// Probability that the measurand lies within them, where nothing but the measurement speaks of the item.
    ///
    /// **Source** `[JCGM106] 7`.
    pub fn probability(&self, measured: &Measured) -> f64 {
        measured.chance_within(self)
    }

    /// Probability that the measurand lies within them, where it also is one of a production with this distribution:
    /// by Bayes' rule.
    ///
    /// **Accuracy** 1e-5 where u is a hundredth of the spread of the production or more.
    /// **Source** `[JCGM106] 6, 7`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a production that is not a continuous distribution, or among which the measured item
    /// cannot be.
    pub fn probability_among(
        &self,
        production: &Distribution,
        measured: &Measured,
    ) -> Result<f64, Error> {
        let (mut within, mut all) = (0.0, 0.0);
        for cell in Cells::of(production, self)?.iter() {
            // What the measurement says of the cell, over its width, is the likelihood of the item there.
            let share = measured.chance_between(cell.from, cell.to);
            let weight = cell.mass * share / (cell.to - cell.from);
            all += weight;
            if self.contains(cell.middle) {
                within += weight;
            }
        }
        if all > 0.0 && all.is_finite() {
            Ok((within / all).clamp(0.0, 1.0))
        } else {
            Err(Error::OutOfRange {
                name: "measured value among the production",
                value: measured.value(),
                min: production.quantile(1e-9),
                max: production.quantile(1.0 - 1e-9),
            })
        }
    }

    /// Decides about one item; `expanded` is its U, and `production` the distribution that items have, where that is
    /// known.
    ///
    /// # Errors
    /// As [`Limits::probability_among`].
    pub fn decide(
        &self,
        measured: &Measured,
        expanded: f64,
        rule: DecisionRule,
        production: Option<&Distribution>,
    ) -> Result<Conformity, Error> {
        let probability = match production {
            None => self.probability(measured),
            Some(production) => self.probability_among(production, measured)?,
        };
        let (accepted, guard_band) = match rule {
            DecisionRule::SimpleAcceptance => (self.contains(measured.value()), Some(0.0)),
            DecisionRule::GuardBand { factor } => {
                let w = factor * expanded;
                (self.narrowed(w).contains(measured.value()), Some(w))
            }
            DecisionRule::LeastProbability(least) => (probability >= least, None),
        };
        let acceptance = self.narrowed(guard_band.unwrap_or(0.0));
        let global = match (production, guard_band) {
            (Some(production), Some(_)) => {
                Some(self.global_risk(&acceptance, production, measured)?)
            }
            _ => None,
        };
        Ok(Conformity {
            probability,
            accepted,
            risk: if accepted {
                1.0 - probability
            } else {
                probability
            },
            guard_band,
            acceptance,
            global,
        })
    }

    /// Limits with a guard band w.
    #[must_use]
    pub fn narrowed(&self, guard: f64) -> Self {
        Self {
            lower: self.lower.map(|l| l + guard),
            upper: self.upper.map(|u| u - guard),
        }
    }

    /// Guard band that keeps the specific risk of the consumer at one limit below `risk` for normal distributions.
    ///
    /// ```
    /// // Speeding is certain to 99.9 % where a speedometer with u = 2 % shows 107 km/h and the limit is 100 km/h (8.3.3).
    /// let w = proofmass_uncertainty::Limits::guard_band(2.14, 0.001);
    /// assert!((w - 6.6).abs() < 0.05);
    /// ```
    ///
    /// **Source** `[JCGM106] 8.3.2`.
    pub fn guard_band(u: f64, risk: f64) -> f64 {
        u * normal_quantile(1.0 - risk)
    }

    /// Risks over a production with this distribution, each item measured with the error that `measured` has, accepted
    /// within `acceptance`.
    ///
    /// **Accuracy** 1e-8 where u is a hundredth of the spread of the production or more.
    /// **Source** `[JCGM106] 9.5`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a production that is not a continuous distribution.
    pub fn global_risk(
        &self,
        acceptance: &Self,
        production: &Distribution,
        measured: &Measured,
    ) -> Result<GlobalRisk, Error> {
        let mut risk = GlobalRisk {
            consumer: 0.0,
            producer: 0.0,
        };
        for cell in Cells::of(production, self)?.iter() {
            let accepted = cell.integral(|item| {
                // The estimate of an item is its value less the error of a draw: within A where the draw is within this.
                let moved = |limit: f64| measured.value() + item - limit;
                measured.chance_within(&Self {
                    lower: acceptance.upper.map(moved),
                    upper: acceptance.lower.map(moved),
                })
            });
            if self.contains(cell.middle) {
                risk.producer += cell.integral(|_| 1.0) - accepted;
            } else {
                risk.consumer += accepted;
            }
        }
        Ok(risk)
    }
}

fn finite(limit: f64) -> Result<(), Error> {
    if limit.is_finite() {
        Ok(())
    } else {
        Err(Error::NotFinite {
            name: "limit",
            index: 0,
        })
    }
}

#[cfg(test)]
mod tests;
