//! Estimates put together, and functions of them.

use super::{Component, Effect, Estimate, Influence};
use crate::{Model, Refusal};
use proofmass_core::Error;

impl Estimate {
    /// The same estimate with causes of its own, whose keys begin with this word: declares it independent of every other
    /// that names the same causes.
    #[must_use]
    pub fn independent(&self, word: &str) -> Self {
        let renamed = |key: &String| format!("{word}: {key}");
        let mut result = self.clone();
        for influence in &mut result.influences {
            influence.key = renamed(&influence.key);
            if let Effect::Correlated { members, .. } = &mut influence.effect {
                members.iter_mut().for_each(|m| m.key = renamed(&m.key));
            }
        }
        result
    }

    /// The same estimate with another name for each component.
    #[must_use]
    pub fn renamed(&self, name: impl Fn(&str) -> String) -> Self {
        let mut result = self.clone();
        for component in &mut result.components {
            component.name = name(&component.name);
        }
        result
    }

    /// The components of both with their joint covariance: causes with the same key are one cause, so that estimates of
    /// different days have the correlation they share. Causes that only have the same name are told apart before, by
    /// [`Estimate::independent`].
    ///
    /// ```
    /// use proofmass_uncertainty::*;
    /// /// A scale factor: the reference is common, the repeatability is that of its day.
    /// fn measured(day: &str) -> Result<Estimate, Refusal> {
    ///     let cause = |key: &str, u: f64| Influence {
    ///         key: key.into(), description: key.into(), evaluation: Evaluation::B, distribution: "normal".into(),
    ///         dof: DegreesOfFreedom::INFINITE,
    ///         effect: Effect::Scalar { value: 0.0, unit: "V".into(), standard_uncertainty: u, sensitivity: vec![1.0] },
    ///     };
    ///     let repeatability = format!("repeatability of {day}");
    ///     Ok(Estimate::new(vec![Component::new(day, "V", 5.0)], vec![cause("reference", 0.03), cause(&repeatability, 0.01)])?)
    /// }
    /// let both = measured("monday")?.beside(&measured("tuesday")?)?;
    /// assert!((both.covariance().correlation(0, 1).unwrap() - 0.9).abs() < 1e-12);
    ///
    /// /// What the reference does is gone from the difference.
    /// struct Difference;
    /// impl Model for Difference {
    ///     fn outputs(&self) -> Vec<(String, String)> { vec![("difference".into(), "V".into())] }
    ///     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) { y[0] = x[1] - x[0]; }
    /// }
    /// let difference = both.through(&Difference)?.get("difference").unwrap();
    /// assert!((difference.standard_uncertainty - 0.01 * 2f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal::Duplicate`] for a component that both have; [`Refusal::Equation`] for a cause that both name and that
    /// cannot be the same: of another u, or one that acts as a whole (its covariance with itself in the other is not known).
    pub fn beside(&self, other: &Self) -> Result<Self, Refusal> {
        if let Some(twice) = other
            .components
            .iter()
            .find(|c| self.index_of(&c.name).is_some())
        {
            return Err(Refusal::Duplicate {
                name: twice.name.clone(),
            });
        }
        let (n, m) = (self.components.len(), other.components.len());
        let mut influences: Vec<Influence> = Vec::new();
        for influence in &self.influences {
            influences.push(Influence {
                effect: influence.effect.widened(n, 0, m)?,
                ..influence.clone()
            });
        }
        for influence in &other.influences {
            let effect = influence.effect.widened(m, n, 0)?;
            match influences.iter_mut().find(|i| i.key == influence.key) {
                None => influences.push(Influence {
                    effect,
                    ..influence.clone()
                }),
                Some(known) => {
                    if known.dof == influence.dof && known.effect.joined(&effect) {
                        continue;
                    }
                    return Err(Refusal::Equation {
                        name: influence.key.clone(),
                        what: "both estimates name this cause, but not with the same u, or as one that acts as a whole; tell \
                               them apart with `independent`"
                            .to_owned(),
                    });
                }
            }
        }
        let components: Vec<Component> = self
            .components
            .iter()
            .chain(&other.components)
            .cloned()
            .collect();
        Ok(Self::new(components, influences)?)
    }

    /// A function of the components, differentiated automatically: the components are its inputs, in their order. Every
    /// cause is carried over.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a value or derivative that is not.
    pub fn through<M: Model>(&self, model: &M) -> Result<Self, Error> {
        let x: Vec<f64> = self.components.iter().map(|c| c.value).collect();
        let (y, jacobian) = crate::jacobian(model, &x)?;
        let outputs = model.outputs().into_iter().zip(y);
        let components = outputs.map(|((name, unit), y)| Component::new(name, unit, y));
        self.propagate(components.collect(), &jacobian)
    }
}

impl Effect {
    /// The same on more components: zeros before and after the n it has.
    fn widened(&self, n: usize, before: usize, after: usize) -> Result<Self, Error> {
        let total = before + n + after;
        let mut jacobian = vec![0.0; total * n];
        (0..n).for_each(|i| jacobian[(before + i) * n + i] = 1.0);
        self.propagate(&jacobian, n)
    }

    /// Adds what the same cause does elsewhere; whether it can be the same.
    fn joined(&mut self, other: &Self) -> bool {
        let add = |to: &mut Vec<f64>, from: &[f64]| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        };
        match (self, other) {
            (
                Self::Scalar {
                    standard_uncertainty: u,
                    unit,
                    sensitivity,
                    ..
                },
                Self::Scalar {
                    standard_uncertainty: v,
                    unit: other_unit,
                    sensitivity: other,
                    ..
                },
            ) if same(*u, *v) && unit == other_unit => {
                add(sensitivity, other);
                true
            }
            (
                Self::Correlated {
                    members,
                    correlation,
                },
                Self::Correlated {
                    members: others,
                    correlation: other,
                },
            ) if correlation == other
                && members.len() == others.len()
                && members.iter().zip(others).all(|(a, b)| {
                    a.key == b.key && same(a.standard_uncertainty, b.standard_uncertainty)
                }) =>
            {
                for (member, other) in members.iter_mut().zip(others) {
                    add(&mut member.sensitivity, &other.sensitivity);
                }
                true
            }
            _ => false,
        }
    }
}

/// Equal but for the rounding of a file.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}
