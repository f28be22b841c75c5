//! E_n: do two results agree within what their uncertainties allow.

#[cfg(feature = "estimate")]
use crate::Estimate;
use crate::Quantity;
use proofmass_core::{Error, check};
use serde::{Deserialize, Serialize};

/// Normalised error of two results of the same quantity.
///
/// ```text
/// E_n = (x₁ − x₂) / √(U₁² + U₂² − 2 k₁ k₂ u(x₁, x₂))
/// ```
///
/// Two results agree when |E_n| ≤ 1. What both share (the same reference standard) does not make them differ, so
/// its covariance is taken out; leaving it in would make every comparison look better than it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct En {
    /// x₁ − x₂.
    pub difference: f64,
    /// Expanded uncertainty of the difference.
    pub expanded: f64,
    /// E_n.
    pub value: f64,
}

impl En {
    /// E_n of two quantities with a known covariance u(x₁, x₂) of their common inputs; zero when independent.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] when the covariance leaves the difference no positive uncertainty or the
    /// probability is not inside (0, 1).
    ///
    /// ```
    /// use proofmass_uncertainty::{DegreesOfFreedom, En, Quantity};
    /// let q = |value, u| Quantity {
    ///     name: "s".into(), unit: "V".into(), value, standard_uncertainty: u, dof: DegreesOfFreedom::INFINITE,
    /// };
    /// let independent = En::new(&q(10.5, 0.3), &q(10.0, 0.4), 0.0, 0.9545)?;
    /// assert!((independent.value - 0.5).abs() < 1e-4); // 0.5 / (2.00 · 0.5)
    /// let shared = En::new(&q(10.5, 0.3), &q(10.0, 0.4), 0.09, 0.9545)?; // 0.3² of it is common
    /// assert!((shared.value - 0.945).abs() < 1e-3); // 0.5 / (2.00 · √0.07)
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// **Source** `[ISO13528] 9.7`, with the covariance of `[GUM] 5.2.2`.
    pub fn new(
        first: &Quantity,
        second: &Quantity,
        covariance: f64,
        probability: f64,
    ) -> Result<Self, Error> {
        check::probability(probability)?;
        let (k1, k2) = (
            first.coverage_factor(probability),
            second.coverage_factor(probability),
        );
        let (u1, u2) = (first.standard_uncertainty, second.standard_uncertainty);
        let variance = (k1 * u1).powi(2) + (k2 * u2).powi(2) - 2.0 * k1 * k2 * covariance;
        if !(variance > 0.0 && variance.is_finite()) || covariance.abs() > u1 * u2 * (1.0 + 1e-12) {
            return Err(Error::OutOfRange {
                name: "covariance of the two results",
                value: covariance,
                min: -u1 * u2,
                max: u1 * u2,
            });
        }
        let difference = first.value - second.value;
        let expanded = variance.sqrt();
        Ok(Self {
            difference,
            expanded,
            value: difference / expanded,
        })
    }

    /// |E_n| ≤ 1.
    pub fn agrees(&self) -> bool {
        self.value.abs() <= 1.0
    }
}

#[cfg(feature = "estimate")]
impl Estimate {
    /// E_n of two components of this estimate, with the correlation they have here.
    ///
    /// `None` when a name is unknown.
    ///
    /// # Errors
    /// As [`En::new`].
    pub fn en(&self, first: &str, second: &str, probability: f64) -> Option<Result<En, Error>> {
        let (i, j) = (self.index_of(first)?, self.index_of(second)?);
        Some(En::new(
            &self.get(first)?,
            &self.get(second)?,
            self.covariance()[(i, j)],
            probability,
        ))
    }
}
