//! Drift of calibration results over time, and when to calibrate again.

use super::drift::{DatedValue, Drift, DriftQuestion};
use crate::findings;
use proofmass_core::Error;
use proofmass_uncertainty::{Estimate, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// A calibration and the day it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct DatedEstimate {
    /// Days from any origin.
    pub day: f64,
    /// Its quantities with their uncertainty.
    pub estimate: Estimate,
    /// What it is called.
    pub name: String,
}

/// Days in a month, on average.
pub const MONTH: f64 = 30.4375;

/// Drift of each quantity by weighted least squares over the days, with the scatter between calibrations estimated.
///
/// ```text
/// y_i = y₀ + D (t_i − t̄),  var y_i = u_i² + τ²        (τ: reproducibility beyond the stated uncertainties)
/// ```
///
/// Uncertainties that all calibrations share (the same gravity) cancel in a drift; they are counted in each, which is
/// on the safe side.
///
/// **Accuracy** `coverage_stability`. **Source** the rule of [`BetweenScatter`](proofmass_uncertainty::BetweenScatter); intervals `[ILAC-G24]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Stability {
    /// Coverage probability.
    pub probability: f64,
    /// Largest change since the last calibration that is tolerated, by the name of a quantity (`bias.x`), in its unit.
    pub tolerances: Vec<(String, f64)>,
    /// Longest time between calibrations whatever the drift, months.
    pub longest_interval: f64,
}

impl Default for Stability {
    fn default() -> Self {
        Self {
            probability: 0.95,
            tolerances: Vec::new(),
            longest_interval: 12.0,
        }
    }
}

/// All quantities over time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StabilityFit {
    /// One for each quantity that all calibrations have.
    pub drifts: Vec<Drift>,
    /// Days after the last calibration until the next is due.
    pub due_in: f64,
    /// Day of the last calibration.
    pub last: f64,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl Stability {
    /// Drifts of everything the calibrations have in common.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than three calibrations, [`Error::Constant`] for one day only, [`Error::Unobservable`] where
    /// they have no quantity in common, [`Error::OutOfRange`].
    pub fn fit(&self, history: &[DatedEstimate]) -> Result<StabilityFit, Error> {
        if history.len() < 3 {
            return Err(Error::TooFew {
                name: "calibrations",
                needed: 3,
                got: history.len(),
            });
        }
        if let Some(index) = history.iter().position(|h| !h.day.is_finite()) {
            return Err(Error::NotFinite { name: "day", index });
        }
        super::readings::positive("longest interval, months", self.longest_interval)?;
        if !(0.5..1.0).contains(&self.probability) {
            return Err(Error::OutOfRange {
                name: "probability",
                value: self.probability,
                min: 0.5,
                max: 1.0,
            });
        }
        let mut history: Vec<&DatedEstimate> = history.iter().collect();
        history.sort_by(|a, b| a.day.total_cmp(&b.day));
        let days: Vec<f64> = history.iter().map(|h| h.day).collect();
        let (first, last) = (days[0], days[days.len() - 1]);
        if !(last - first >= 1.0) {
            return Err(Error::Constant {
                name: "day of the calibrations",
                value: first,
            });
        }
        let mut drifts = Vec::new();
        for component in history[0].estimate.components() {
            let values: Option<Vec<Quantity>> = history
                .iter()
                .map(|h| {
                    h.estimate
                        .get(&component.name)
                        .filter(|q| q.unit == component.unit)
                })
                .collect();
            let Some(values) = values.filter(|v| v.iter().all(|q| q.standard_uncertainty > 0.0))
            else {
                continue;
            };
            drifts.push(self.drift(&days, &values)?);
        }
        if drifts.is_empty() {
            return Err(Error::Unobservable {
                parameter: "a drift: the calibrations have no quantity with an uncertainty in common",
                condition: f64::INFINITY,
            });
        }
        let longest = self.longest_interval * MONTH;
        let due_in = drifts
            .iter()
            .filter_map(|d| d.due_in)
            .fold(longest, f64::min);
        let findings = self.findings(&drifts, due_in);
        Ok(StabilityFit {
            drifts,
            due_in,
            last,
            findings,
        })
    }

    fn drift(&self, days: &[f64], values: &[Quantity]) -> Result<Drift, Error> {
        let tolerance = self
            .tolerances
            .iter()
            .find(|(name, _)| *name == values[0].name);
        let question = DriftQuestion {
            probability: self.probability,
            tolerance: tolerance.map(|(_, tolerance)| *tolerance),
            longest_interval: self.longest_interval,
        };
        let dated = days.iter().zip(values);
        let dated: Vec<DatedValue> = dated
            .map(|(day, q)| DatedValue::new(*day, q.value, q.standard_uncertainty, q.dof))
            .collect();
        Drift::of(&values[0].name, &values[0].unit, &dated, &question)
    }

    fn findings(&self, drifts: &[Drift], due_in: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        // One in a hundred over all quantities together.
        let level = 1.0 - 0.01 / drifts.len() as f64;
        for d in drifts {
            let k = d.drift.dof.coverage_factor(level);
            if d.drift.value.abs() > k * d.drift.standard_uncertainty {
                findings.push(findings::calibration_drift(
                    &d.name,
                    d.drift.value,
                    d.drift.expanded(self.probability),
                    &d.unit,
                ));
            }
        }
        if due_in <= 0.0 {
            findings.push(findings::tolerance_exhausted());
        }
        findings
    }
}
