//! One quantity taken alone, with its coverage factor and its density.

use crate::DegreesOfFreedom;
use serde::{Deserialize, Serialize};

/// How a cause of uncertainty was evaluated. **Source** `[GUM] 4.2, 4.3`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Evaluation {
    /// By statistical analysis of observations.
    A,
    /// By other means: certificates, specifications, judgement.
    B,
}

/// One quantity taken alone: value, standard uncertainty, degrees of freedom. Its correlation stays behind in
/// the estimate it came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Quantity {
    /// Dotted name.
    pub name: String,
    /// Unit as printed.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Standard uncertainty u.
    pub standard_uncertainty: f64,
    /// Effective degrees of freedom.
    pub dof: DegreesOfFreedom,
}

impl Quantity {
    /// Coverage factor k for a probability, from Student's t at the effective degrees of freedom.
    pub fn coverage_factor(&self, probability: f64) -> f64 {
        self.dof.coverage_factor(probability)
    }

    /// Expanded uncertainty U = k u for a probability.
    pub fn expanded(&self, probability: f64) -> f64 {
        self.coverage_factor(probability) * self.standard_uncertainty
    }

    /// Density of the state of knowledge at a value: Student's t at the effective degrees of freedom, scaled by u
    /// and moved to the estimate; `None` without uncertainty.
    ///
    /// ```
    /// use proofmass_uncertainty::{DegreesOfFreedom, Quantity};
    /// let q = Quantity {
    ///     name: "y".into(), unit: "1".into(), value: 3.0, standard_uncertainty: 2.0, dof: DegreesOfFreedom::INFINITE,
    /// };
    /// assert!((q.density(3.0).unwrap() - 0.199_471).abs() < 1e-6); // 1/(2 √(2π))
    /// ```
    pub fn density(&self, at: f64) -> Option<f64> {
        let u = self.standard_uncertainty;
        if !(u > 0.0 && u.is_finite()) {
            return None;
        }
        let (t, nu) = ((at - self.value) / u, self.dof.get());
        // Above this ν the two curves are one, and the difference of the gamma functions loses its digits.
        let ln_density = if nu > 1e6 {
            -0.5 * (t * t + std::f64::consts::TAU.ln())
        } else {
            crate::student::ln_pdf_factor(nu) - 0.5 * (nu + 1.0) * (t * t / nu).ln_1p()
        };
        Some(ln_density.exp() / u)
    }
}
