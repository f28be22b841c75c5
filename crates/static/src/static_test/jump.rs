//! A jump between two calibrations, beside a drift.

use super::drift::{DatedValue, SharedErrors};
use super::stability::MONTH;
use crate::findings;
use proofmass_core::Error;
use proofmass_uncertainty::{BetweenScatter, DegreesOfFreedom, Finding, NoiseDof};
use serde::{Deserialize, Serialize};

/// Chance of a false jump in a history.
const LEVEL: f64 = 0.01;
/// Calibrations on each side of a jump at least.
const SIDE: usize = 3;

/// The largest jump of a history, where there is one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Jump {
    /// Day of the last calibration before it.
    pub after: f64,
    /// Day of the first calibration behind it.
    pub before: f64,
    /// Its height, in the unit of the quantity.
    pub height: f64,
    /// Standard uncertainty of the height.
    pub standard_uncertainty: f64,
}

impl Jump {
    /// The jump with the largest ratio to its uncertainty among all places with three calibrations on each side; `None` where none exceeds
    /// what chance gives one history in a hundred.
    ///
    /// ```text
    /// y_i = y₀ + D t_i + J [t_i > t_k] + c_g + e_i,   |J| > k(1 − 0.01/m) u(J) at one of m places
    /// ```
    ///
    /// The drift is part of the model, so that a steady drift is no jump.
    ///
    /// **Accuracy** false at most 1 % of histories; found in the share of docs/records.md (`--example history_map`).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an uncertainty that is not positive, [`Error::Singular`] for days that do not tell a drift.
    pub fn of(values: &[DatedValue]) -> Result<Option<Self>, Error> {
        let n = values.len();
        if n < 2 * SIDE {
            return Ok(None);
        }
        let mut values: Vec<&DatedValue> = values.iter().collect();
        values.sort_by(|a, b| a.day.total_cmp(&b.day));
        let middle = values.iter().map(|v| v.day).sum::<f64>() / n as f64;
        let months: Vec<f64> = values.iter().map(|v| (v.day - middle) / MONTH).collect();
        let reach = months.iter().map(|m| m.abs()).fold(0.0, f64::max);
        if !(reach > 0.0) {
            return Ok(None);
        }
        let parts = SharedErrors::of(&values);
        let variances = parts.own_variances(&values);
        let pedestal = values[0].value;
        let y: Vec<f64> = values.iter().map(|v| v.value - pedestal).collect();
        let least = values
            .iter()
            .map(|v| v.dof)
            .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a });
        // Two calibrations of one day have no jump between them.
        let places: Vec<usize> = (SIDE..=n - SIDE)
            .filter(|k| values[*k].day > values[k - 1].day)
            .collect();
        let limit = least.coverage_factor(1.0 - LEVEL / places.len().max(1) as f64);
        let mut largest: Option<(f64, Self)> = None;
        for k in places {
            let jacobian: Vec<f64> = months
                .iter()
                .enumerate()
                .flat_map(|(i, m)| [1.0, m / reach, if i < k { 0.0 } else { 1.0 }])
                .collect();
            let (x, scatter) =
                BetweenScatter::linear(&jacobian, &y, &variances, NoiseDof::Known, 0.95)?;
            let common = parts.common(&scatter.gain[2 * n..]);
            let u = scatter.with_common(2, &common).standard_uncertainty;
            let ratio = (x[2] / u).abs();
            if ratio > limit && largest.is_none_or(|(before, _)| ratio > before) {
                let jump = Self {
                    after: values[k - 1].day,
                    before: values[k].day,
                    height: x[2],
                    standard_uncertainty: u,
                };
                largest = Some((ratio, jump));
            }
        }
        Ok(largest.map(|(_, jump)| jump))
    }

    /// As a finding of a quantity; `when` says where the jump is, as dates.
    pub fn finding(&self, quantity: &str, unit: &str, when: &str) -> Finding {
        findings::calibration_jump(
            quantity,
            when,
            self.height,
            1.96 * self.standard_uncertainty,
            unit,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_jump_is_found_where_it_is_and_a_drift_is_none() {
        let values = |jump: f64| -> Vec<DatedValue> {
            let noise = [0.3, -0.8, 0.5, 0.1, -0.4, 0.9, -0.6, 0.2, 0.4, -0.7];
            (0..10)
                .map(|k| {
                    let y = 0.5 * k as f64 + 0.1 * noise[k] + if k < 6 { 0.0 } else { jump };
                    DatedValue::new(365.0 * k as f64, y, 0.1, DegreesOfFreedom::INFINITE)
                })
                .collect()
        };
        assert_eq!(Jump::of(&values(0.0)).unwrap(), None);
        let jump = Jump::of(&values(0.8)).unwrap().unwrap();
        assert_eq!([jump.after, jump.before], [5.0 * 365.0, 6.0 * 365.0]);
        assert!((jump.height - 0.8).abs() < 3.0 * jump.standard_uncertainty);
        let finding = jump.finding("S", "V", "between 2020 and 2021");
        assert_eq!(finding.code(), "calibration-jump");
    }

    /// Chance that the best test of 1 % finds a jump of 4 u in the middle of `n` yearly values of known u beside an unknown drift, were
    /// its place known: what `docs/records.md` holds the found shares against.
    #[test]
    fn known_bound_for_jumps_beside_a_drift() {
        let bound = |n: usize| -> f64 {
            let x = |i: usize| i as f64 - (n as f64 - 1.0) / 2.0;
            let across: f64 = (0..n).map(|i| x(i).abs() / 2.0).sum();
            let along: f64 = (0..n).map(|i| x(i).powi(2)).sum();
            // What a line leaves of a step of 4 u, in u.
            let left = 16.0 * (n as f64 / 4.0 - across.powi(2) / along);
            // Φ of a distance, by the chi-squared distribution with one degree of freedom.
            let distance = left.sqrt() - 2.5758;
            let tail = 0.5 * proofmass_uncertainty::chi_squared_chance(distance.powi(2), 1.0);
            if distance > 0.0 { 1.0 - tail } else { tail }
        };
        for (n, percent) in [(8, 57.3), (12, 80.3), (20, 97.0)] {
            assert!(
                (100.0 * bound(n) - percent).abs() < 0.1,
                "{n}: {}",
                bound(n)
            );
        }
    }
}
