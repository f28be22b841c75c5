//! Does an item conform? Decisions with an uncertainty, their guard bands and their risks.

use crate::quantile::normal_quantile;
use crate::{DegreesOfFreedom, Quantity};
use proofmass_core::{Error, check};
use serde::{Deserialize, Serialize};
use statrs::function::beta::beta_reg;
use statrs::function::erf::erfc;

/// The values that a requirement permits: two limits, or one.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, Limits, DecisionRule, Quantity};
/// let q = Quantity {
///     name: "V".into(), unit: "V".into(), value: 4.96, standard_uncertainty: 0.02, dof: DegreesOfFreedom::INFINITE,
/// };
/// let limits = Limits::above(4.90)?;
/// assert!((limits.probability(&q) - 0.99865).abs() < 1e-5); // Φ(3)
/// // With a guard band of U = 2 u the acceptance limit is 4.94.
/// let decision = limits.decide(&q, DecisionRule::GuardBand { factor: 1.0, probability: 0.9545 });
/// assert!(decision.accepted && (decision.acceptance.lower.unwrap() - 4.94).abs() < 1e-5);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// **Source** `[JCGM106]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
    /// guarded rejection), with U at a coverage probability. **Source** `[JCGM106] 8.3`.
    GuardBand {
        /// w/U.
        factor: f64,
        /// Coverage probability of U.
        probability: f64,
    },
    /// The probability of conformity reaches a least value.
    LeastProbability(f64),
}

/// A decision about one item.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conformity {
    /// Probability that the item conforms.
    pub probability: f64,
    /// Whether it is accepted.
    pub accepted: bool,
    /// Probability that the decision is wrong: the specific risk of the consumer where it is accepted, of the producer
    /// where it is rejected.
    pub risk: f64,
    /// Limits between which the estimate is accepted; those of the requirement where the rule is a probability.
    pub acceptance: Limits,
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

impl Limits {
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

    /// Probability that the measurand lies within them: Student's t at the degrees of freedom of the quantity.
    ///
    /// **Source** `[JCGM106] 7`.
    pub fn probability(&self, q: &Quantity) -> f64 {
        let u = q.standard_uncertainty;
        if !(u > 0.0) {
            return f64::from(u8::from(self.contains(q.value)));
        }
        let outside = self
            .lower
            .map_or(0.0, |l| upper_tail((q.value - l) / u, q.dof))
            + self
                .upper
                .map_or(0.0, |h| upper_tail((h - q.value) / u, q.dof));
        (1.0 - outside).clamp(0.0, 1.0)
    }

    /// Decides about one item.
    pub fn decide(&self, q: &Quantity, rule: DecisionRule) -> Conformity {
        let probability = self.probability(q);
        let (accepted, acceptance) = match rule {
            DecisionRule::SimpleAcceptance => (self.contains(q.value), *self),
            DecisionRule::GuardBand {
                factor,
                probability,
            } => {
                let narrowed = self.narrowed(factor * q.expanded(probability));
                (narrowed.contains(q.value), narrowed)
            }
            DecisionRule::LeastProbability(least) => (probability >= least, *self),
        };
        Conformity {
            probability,
            accepted,
            risk: if accepted {
                1.0 - probability
            } else {
                probability
            },
            acceptance,
        }
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
    /// **Source** `[JCGM106] 8.3.2`.
    pub fn guard_band(u: f64, risk: f64) -> f64 {
        u * normal_quantile(1.0 - risk)
    }

    /// Risks over a production of items that are normal about `mean` with `sd`, measured with u, accepted within
    /// `acceptance`.
    ///
    /// **Accuracy** 1e-8, by Simpson's rule with 4000 steps over ± 9 standard deviations.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless both standard deviations are above zero.
    pub fn global_risk(
        &self,
        acceptance: &Self,
        mean: f64,
        sd: f64,
        u: f64,
    ) -> Result<GlobalRisk, Error> {
        for (name, value) in [
            ("standard deviation of the items", sd),
            ("standard uncertainty", u),
        ] {
            check::positive(name, value)?;
        }
        let accepted = |x: f64| {
            let below = acceptance.lower.map_or(0.0, |l| normal_tail((x - l) / u));
            let above = acceptance.upper.map_or(0.0, |h| normal_tail((h - x) / u));
            (1.0 - below - above).clamp(0.0, 1.0)
        };
        let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        // Over each stretch between the limits, so that no step falls within one.
        let end = 9.0;
        let mut cuts = vec![-end, end];
        cuts.extend(
            [self.lower, self.upper]
                .iter()
                .flatten()
                .map(|l| ((l - mean) / sd).clamp(-end, end)),
        );
        cuts.sort_by(f64::total_cmp);
        let mut risk = GlobalRisk {
            consumer: 0.0,
            producer: 0.0,
        };
        for pair in cuts.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let conforms = self.contains(mean + sd * 0.5 * (from + to));
            let share = |z: f64| {
                let p = accepted(mean + sd * z);
                density(z) * if conforms { 1.0 - p } else { p }
            };
            let part = simpson(share, from, to);
            if conforms {
                risk.producer += part;
            } else {
                risk.consumer += part;
            }
        }
        Ok(risk)
    }
}

fn simpson(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let n = 4000;
    let h = (to - from) / f64::from(n);
    let inner: f64 = (1..n)
        .map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * f(from + h * f64::from(i)))
        .sum();
    h / 3.0 * (f(from) + inner + f(to))
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

fn normal_tail(z: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(value: f64, u: f64, nu: f64) -> Quantity {
        Quantity {
            name: "y".into(),
            unit: "1".into(),
            value,
            standard_uncertainty: u,
            dof: DegreesOfFreedom::new(nu).unwrap(),
        }
    }

    #[test]
    fn law_probability_is_that_of_the_interval() {
        // Limits at y ± U hold the measurand with the probability of U.
        for nu in [2.0, 7.5, f64::INFINITY] {
            let q = quantity(3.0, 0.2, nu);
            let half = q.expanded(0.9);
            let limits = Limits::between(3.0 - half, 3.0 + half).unwrap();
            assert!((limits.probability(&q) - 0.9).abs() < 1e-10, "{nu}");
            assert!((Limits::above(3.0).unwrap().probability(&q) - 0.5).abs() < 1e-12);
        }
        assert!(Limits::between(1.0, 1.0).is_err());
    }

    /// Without guard band and with a flat production the risks at one limit are alike; all shares sum to one.
    #[test]
    fn law_global_risks() {
        let limits = Limits::between(-1.0, 1.0).unwrap();
        let (sd, u) = (0.6, 0.2);
        let risk = limits.global_risk(&limits, 0.0, sd, u).unwrap();
        // Observed values are normal with √(sd² + u²): accepted = conforming − producer + consumer.
        let inside = |s: f64| 1.0 - 2.0 * normal_tail(1.0 / s);
        let accepted = inside(sd) - risk.producer + risk.consumer;
        assert!((accepted - inside(sd.hypot(u))).abs() < 1e-9);
        let guarded = limits.narrowed(Limits::guard_band(u, 0.05));
        let tighter = limits.global_risk(&guarded, 0.0, sd, u).unwrap();
        assert!(tighter.consumer < risk.consumer && tighter.producer > risk.producer);
        // One limit at the mean: P(accepted, not conforming) = atan(u/sd)/(2π).
        let half = Limits::above(0.0).unwrap();
        let risk = half.global_risk(&half, 0.0, sd, u).unwrap();
        let exact = (u / sd).atan() / std::f64::consts::TAU;
        assert!((risk.consumer - exact).abs() < 1e-8 && (risk.producer - exact).abs() < 1e-8);
    }
}
