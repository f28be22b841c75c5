//! A real quantity as a result states it.

use proofmass_uncertainty::{DegreesOfFreedom, Quantity};
use serde::{Deserialize, Serialize};

/// Probability of every expanded uncertainty, but where a coverage factor was asked for.
pub const PROBABILITY: f64 = 0.95;

/// A real quantity with its expanded uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Expanded {
    /// Dotted name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
    /// Expanded uncertainty U = k u.
    pub expanded: f64,
    /// Coverage factor.
    pub coverage_factor: f64,
    /// Probability that value ± U holds the measurand: 95 %, or what a stated factor gives.
    #[serde(default = "usual")]
    pub probability: f64,
    /// Effective degrees of freedom; `None` when infinite.
    pub dof: Option<f64>,
    /// Coverage interval where it is not value ± U: a modulus ends at zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
}

fn usual() -> f64 {
    PROBABILITY
}

impl Expanded {
    /// A quantity stated at 95 %, or with a coverage factor.
    pub fn of(quantity: Quantity, coverage_factor: Option<f64>) -> Self {
        let mut stated = Self::from(quantity);
        if let Some(k) = coverage_factor {
            stated.state_with(k);
        }
        stated
    }

    /// States U = k u with the probability that it then has by the effective degrees of freedom.
    pub fn state_with(&mut self, k: f64) {
        let dof = self.dof.and_then(DegreesOfFreedom::new);
        self.coverage_factor = k;
        self.expanded = k * self.standard_uncertainty;
        self.probability = dof
            .unwrap_or(DegreesOfFreedom::INFINITE)
            .coverage_probability(k);
        if self.interval.is_some() {
            self.interval =
                (self.value < self.expanded).then_some([0.0, self.value + self.expanded]);
        }
    }
}

impl From<Quantity> for Expanded {
    fn from(q: Quantity) -> Self {
        Self {
            coverage_factor: q.coverage_factor(PROBABILITY),
            probability: PROBABILITY,
            expanded: q.expanded(PROBABILITY),
            dof: (!q.dof.is_infinite()).then(|| q.dof.get()),
            value: q.value,
            standard_uncertainty: q.standard_uncertainty,
            name: q.name,
            unit: q.unit,
            interval: None,
        }
    }
}
