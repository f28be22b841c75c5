//! Numbers that carry their uncertainty and its causes through arithmetic.

mod arithmetic;
mod complex;
mod matrix;

pub use complex::UncertainComplex;
pub use matrix::UncertainMatrix;

use crate::{
    BudgetLine, DegreesOfFreedom, Dual, Effect, Estimate, Evaluation, Quantity, welch_satterthwaite,
};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A value with its uncertainty, as a sum of independent causes that have names.
///
/// Arithmetic follows the law of propagation to first order. Two numbers that name the same cause share it, also when one
/// of them was computed, filed and read again on another day: what is common cancels or adds as it should.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, Uncertain};
/// let reference = Uncertain::new("reference", 10.0, 0.03)?;
/// let monday = &reference * 2.0 + Uncertain::new("monday", 0.0, 0.01)?;
/// let text = serde_json::to_string(&monday).unwrap(); // filed …
/// let filed: Uncertain = serde_json::from_str(&text).unwrap(); // … and read again
/// let tuesday = reference * 2.0 + Uncertain::new("tuesday", 0.0, 0.01)?;
/// let difference = tuesday - filed;
/// assert!((difference.standard_uncertainty() - 0.01 * 2f64.sqrt()).abs() < 1e-15); // the reference cancels
///
/// let v = Uncertain::new("V", 5.0, 0.01)?.dof(DegreesOfFreedom::new(4.0).unwrap());
/// let i = Uncertain::new("I", 0.02, 0.0001)?;
/// let r = v / i;
/// assert!((r.value() - 250.0).abs() < 1e-12 && (r.standard_uncertainty() - 1.346_291).abs() < 1e-6);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// It prints itself as value(u), and `{:#}` as value ± U at 95 %:
///
/// ```
/// # use proofmass_uncertainty::Uncertain;
/// let r = Uncertain::new("V", 5.0, 0.01)? / Uncertain::new("I", 0.02, 0.0001)?;
/// assert_eq!(r.to_string(), "250.0(1.3)");
/// assert_eq!(r.in_unit("Ω").to_string(), "250.0(1.3) Ω");
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// **Source** `[GUM] 5.1, 5.2`; effective degrees of freedom `[GUM] G.4`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Uncertain {
    value: f64,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    causes: BTreeMap<String, Cause>,
}

/// What one cause does to a number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Cause {
    /// Change of the value when the cause changes by its standard uncertainty.
    contribution: f64,
    #[serde(default = "infinite", skip_serializing_if = "is_infinite")]
    dof: DegreesOfFreedom,
    /// Causes with one name here share one estimate of their scatter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ensemble: Option<String>,
}

fn infinite() -> DegreesOfFreedom {
    DegreesOfFreedom::INFINITE
}

impl fmt::Display for Uncertain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.in_unit("").fmt(f)
    }
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_infinite(nu: &DegreesOfFreedom) -> bool {
    nu.is_infinite()
}

impl Uncertain {
    /// A number with one cause of uncertainty, by the name of that cause.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a negative u.
    pub fn new(cause: impl Into<String>, value: f64, u: f64) -> Result<Self, Error> {
        for (index, (name, x)) in [("value", value), ("standard uncertainty", u)]
            .into_iter()
            .enumerate()
        {
            if !x.is_finite() {
                return Err(Error::NotFinite { name, index });
            }
        }
        if u < 0.0 {
            return Err(Error::OutOfRange {
                name: "standard uncertainty",
                value: u,
                min: 0.0,
                max: f64::MAX,
            });
        }
        let cause_of = Cause {
            contribution: u,
            dof: DegreesOfFreedom::INFINITE,
            ensemble: None,
        };
        Ok(Self {
            value,
            causes: BTreeMap::from([(cause.into(), cause_of)]),
        })
    }

    /// A number without uncertainty.
    pub fn exact(value: f64) -> Self {
        Self {
            value,
            causes: BTreeMap::new(),
        }
    }

    /// Degrees of freedom of every cause it has so far; meant for a number just made.
    #[must_use]
    pub fn dof(mut self, dof: DegreesOfFreedom) -> Self {
        self.causes.values_mut().for_each(|c| c.dof = dof);
        self
    }

    /// A component of an estimate with all of its causes. Components of one estimate keep their correlation.
    ///
    /// Correlated inputs with degrees of freedom of their own are taken as one estimate with the least of them.
    pub fn of(estimate: &Estimate, component: &str) -> Option<Self> {
        let i = estimate.index_of(component)?;
        let n = estimate.components().len();
        let mut result = Self::exact(estimate.components()[i].value);
        for influence in estimate.influences() {
            if let Effect::Scalar {
                standard_uncertainty,
                sensitivity,
                ..
            } = &influence.effect
            {
                let contribution = sensitivity.get(i)? * standard_uncertainty;
                result.add_cause(influence.key.clone(), contribution, influence.dof, None);
                continue;
            }
            // Independent standard parts of a joint effect: the columns of a root of its covariance.
            let covariance = influence.effect.covariance(n).ok()?;
            let root = crate::propagation::square_root(&covariance).ok()?;
            for column in 0..n {
                let contribution = root[i * n + column];
                if contribution != 0.0 {
                    let name = format!("{} [{}]", influence.key, column + 1);
                    result.add_cause(
                        name,
                        contribution,
                        influence.dof,
                        Some(influence.key.clone()),
                    );
                }
            }
        }
        Some(result)
    }

    /// The causes: name, change of the value when the cause changes by its standard uncertainty, degrees of freedom.
    pub fn causes(&self) -> impl Iterator<Item = (&str, f64, DegreesOfFreedom)> {
        let causes = self.causes.iter();
        causes.map(|(name, cause)| (name.as_str(), cause.contribution, cause.dof))
    }

    /// The same number with what one more cause, or more of one that it has, contributes.
    #[must_use]
    pub fn with_cause(
        mut self,
        name: impl Into<String>,
        contribution: f64,
        dof: DegreesOfFreedom,
    ) -> Self {
        self.add_cause(name.into(), contribution, dof, None);
        self
    }

    fn add_cause(
        &mut self,
        name: String,
        contribution: f64,
        dof: DegreesOfFreedom,
        ensemble: Option<String>,
    ) {
        let cause = self.causes.entry(name).or_insert(Cause {
            contribution: 0.0,
            dof,
            ensemble,
        });
        cause.contribution += contribution;
    }

    /// The same number with causes of its own, under names that begin with this word: declares it independent of every
    /// number that names the same causes.
    #[must_use]
    pub fn independent(&self, word: &str) -> Self {
        let rename = |name: &String| format!("{word}: {name}");
        let causes = self.causes.iter().map(|(name, cause)| {
            let cause = Cause {
                ensemble: cause.ensemble.as_ref().map(rename),
                ..cause.clone()
            };
            (rename(name), cause)
        });
        Self {
            value: self.value,
            causes: causes.collect(),
        }
    }

    /// The value.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Standard uncertainty.
    pub fn standard_uncertainty(&self) -> f64 {
        let causes = || self.causes.values().map(|c| c.contribution);
        let square: f64 = causes().map(|c| c.powi(2)).sum();
        if square.is_nan() || (1e-280..1e280).contains(&square) {
            return square.sqrt();
        }
        // Squares leave the range of numbers long before their root does.
        let scale = causes().fold(0.0, |a: f64, c| a.max(c.abs()));
        match scale > 0.0 && scale.is_finite() {
            true => scale * causes().map(|c| (c / scale).powi(2)).sum::<f64>().sqrt(),
            false => scale,
        }
    }

    /// Effective degrees of freedom.
    pub fn effective_dof(&self) -> DegreesOfFreedom {
        let mut groups: BTreeMap<&str, (f64, DegreesOfFreedom)> = BTreeMap::new();
        // Fourth powers are to stay within the range of numbers.
        let scale = match self.standard_uncertainty() {
            u if (1e-60..1e60).contains(&u) || u == 0.0 => 1.0,
            u => u,
        };
        for (name, cause) in &self.causes {
            let key = cause.ensemble.as_deref().unwrap_or(name);
            let group = groups.entry(key).or_insert((0.0, cause.dof));
            group.0 += (cause.contribution / scale).powi(2);
        }
        let parts: Vec<_> = groups.values().map(|(v, nu)| (v.sqrt(), *nu)).collect();
        welch_satterthwaite(&parts)
    }

    /// Covariance with another number, through the causes that both name.
    pub fn covariance(&self, other: &Self) -> f64 {
        let common = self.causes.iter().filter_map(|(name, cause)| {
            let theirs = other.causes.get(name)?;
            Some(cause.contribution * theirs.contribution)
        });
        common.sum()
    }

    /// Correlation coefficient; `None` where one of them is exact.
    pub fn correlation(&self, other: &Self) -> Option<f64> {
        let (ours, theirs) = (self.standard_uncertainty(), other.standard_uncertainty());
        let scale = ours * theirs;
        if (1e-280..1e280).contains(&scale) {
            return Some((self.covariance(other) / scale).clamp(-1.0, 1.0));
        }
        (ours > 0.0 && theirs > 0.0).then(|| {
            let common = self.causes.iter().filter_map(|(name, cause)| {
                let other = other.causes.get(name)?;
                Some(cause.contribution / ours * (other.contribution / theirs))
            });
            common.sum::<f64>().clamp(-1.0, 1.0)
        })
    }

    /// The number with its unit, as it prints itself.
    pub fn in_unit(&self, unit: impl Into<String>) -> Quantity {
        self.quantity("", unit)
    }

    /// Expanded uncertainty for a coverage probability, with Student's t at the effective degrees of freedom.
    pub fn expanded(&self, probability: f64) -> f64 {
        self.in_unit("").expanded(probability)
    }

    /// With name and unit, to be printed and stated.
    pub fn quantity(&self, name: impl Into<String>, unit: impl Into<String>) -> Quantity {
        Quantity {
            name: name.into(),
            unit: unit.into(),
            value: self.value,
            standard_uncertainty: self.standard_uncertainty(),
            dof: self.effective_dof(),
        }
    }

    /// The causes, largest contribution first.
    pub fn budget(&self) -> Vec<BudgetLine> {
        let variance = self.standard_uncertainty().powi(2);
        let mut lines: Vec<BudgetLine> = self
            .causes
            .iter()
            .map(|(name, cause)| BudgetLine {
                key: name.clone(),
                description: name.clone(),
                evaluation: if cause.dof.is_infinite() {
                    Evaluation::B
                } else {
                    Evaluation::A
                },
                distribution: String::new(),
                dof: cause.dof,
                input: None,
                contribution: cause.contribution.abs(),
                share: if variance > 0.0 {
                    cause.contribution.powi(2) / variance
                } else {
                    0.0
                },
            })
            .collect();
        lines.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        lines
    }

    /// A function of several numbers, differentiated automatically.
    ///
    /// ```
    /// use proofmass_uncertainty::{Number, Uncertain};
    /// let (a, b) = (Uncertain::new("a", 3.0, 0.1)?, Uncertain::new("b", 4.0, 0.1)?);
    /// let c = Uncertain::function([&a, &b], |[a, b]| (a * a + b * b).sqrt());
    /// assert!((c.value() - 5.0).abs() < 1e-15 && (c.standard_uncertainty() - 0.1).abs() < 1e-15);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    pub fn function<const N: usize>(
        arguments: [&Self; N],
        f: impl Fn([Dual<f64, N>; N]) -> Dual<f64, N>,
    ) -> Self {
        let y = f(std::array::from_fn(|i| {
            Dual::variable(arguments[i].value, i)
        }));
        let mut result = Self::exact(y.real);
        for (argument, slope) in arguments.iter().zip(y.partials) {
            result.accumulate(argument, slope);
        }
        result
    }

    /// Adds the causes of another number, each times a factor.
    fn accumulate(&mut self, other: &Self, factor: f64) {
        for (name, cause) in &other.causes {
            self.add_cause(
                name.clone(),
                factor * cause.contribution,
                cause.dof,
                cause.ensemble.clone(),
            );
        }
    }

    /// A function of one number, with its derivative.
    fn map(&self, f: impl Fn(Dual<f64, 1>) -> Dual<f64, 1>) -> Self {
        Self::function([self], |[x]| f(x))
    }
}
