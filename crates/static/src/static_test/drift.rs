//! Drift of one quantity over the days, with errors that some of its calibrations share.

use super::stability::MONTH;
use proofmass_core::Error;
use proofmass_uncertainty::{BetweenScatter, CommonErrors, DegreesOfFreedom, NoiseDof, Quantity};
use serde::{Deserialize, Serialize};

/// A calibration of one quantity.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DatedValue {
    /// Days from any origin.
    pub day: f64,
    /// The value.
    pub value: f64,
    /// Standard uncertainty, with what is shared.
    pub standard_uncertainty: f64,
    /// Its degrees of freedom.
    pub dof: DegreesOfFreedom,
    /// The error it shares with others: a number that these have in common (a certificate of the reference), and its standard uncertainty.
    pub shared: Option<(u64, f64)>,
}

impl DatedValue {
    /// A value that shares no error with another.
    pub fn new(day: f64, value: f64, standard_uncertainty: f64, dof: DegreesOfFreedom) -> Self {
        Self {
            day,
            value,
            standard_uncertainty,
            dof,
            shared: None,
        }
    }

    /// Shares an error with standard uncertainty `u` with every other value of the same number.
    #[must_use]
    pub fn sharing(mut self, with: u64, u: f64) -> Self {
        self.shared = Some((with, u));
        self
    }
}

/// One quantity over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Drift {
    /// Name of the quantity.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Drift per month.
    pub drift: Quantity,
    /// Value at the mean day.
    pub level: f64,
    /// Day of `level`.
    pub mean_day: f64,
    /// Standard deviation between calibrations beyond their stated uncertainty.
    pub excess: f64,
    /// Day, value and standard uncertainty of each calibration.
    pub values: Vec<[f64; 3]>,
    /// Limits of the control chart at each day: where the next calibration of such uncertainty lies.
    pub limits: Vec<[f64; 3]>,
    /// Days after the last calibration until the change may exceed the tolerance, where one is given.
    pub due_in: Option<f64>,
}

/// What is asked of the drift of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftQuestion {
    /// Coverage probability.
    pub probability: f64,
    /// Largest change since the last calibration that is tolerated, in the unit of the quantity.
    pub tolerance: Option<f64>,
    /// Longest time between calibrations whatever the drift, months.
    pub longest_interval: f64,
}

impl Drift {
    /// Weighted regression over the days, with the scatter between calibrations estimated.
    ///
    /// ```text
    /// y_i = y₀ + D (t_i − t̄) + c_g + e_i,   var e_i = u_i² − s_i² + τ²,   u(c_g) = s   (g: the reference of calibration i)
    /// ```
    ///
    /// What all calibrations share cancels in D and stays in the level: it counts by its sum over the gain of the regression. An error
    /// that one calibration alone has is part of e.
    ///
    /// **Accuracy** `coverage_drift_with_a_shared_reference`, and the table in docs/records.md. **Source** the rule of [`BetweenScatter`].
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than three values, [`Error::Constant`] for one day only, [`Error::OutOfRange`] for an uncertainty that
    /// is not positive, or shared errors larger than all.
    pub fn of(
        name: &str,
        unit: &str,
        values: &[DatedValue],
        question: &DriftQuestion,
    ) -> Result<Self, Error> {
        let n = values.len();
        if n < 3 {
            return Err(Error::TooFew {
                name: "calibrations",
                needed: 3,
                got: n,
            });
        }
        let mut values: Vec<&DatedValue> = values.iter().collect();
        values.sort_by(|a, b| a.day.total_cmp(&b.day));
        let mean_day = values.iter().map(|v| v.day).sum::<f64>() / n as f64;
        let months: Vec<f64> = values.iter().map(|v| (v.day - mean_day) / MONTH).collect();
        let reach = months.iter().map(|m| m.abs()).fold(0.0, f64::max);
        if !(reach > 0.0) {
            return Err(Error::Constant {
                name: "day of the calibrations",
                value: mean_day,
            });
        }
        let jacobian: Vec<f64> = months.iter().flat_map(|m| [1.0, m / reach]).collect();
        let parts = SharedErrors::of(&values);
        let each: Vec<DegreesOfFreedom> = values.iter().map(|q| q.dof).collect();
        let pedestal = values[0].value;
        let y: Vec<f64> = values.iter().map(|q| q.value - pedestal).collect();
        let (x, scatter) = BetweenScatter::linear(
            &jacobian,
            &y,
            &parts.own_variances(&values),
            NoiseDof::Each(each),
            question.probability,
        )?;
        let (own, k, dof) = (
            scatter.standard_uncertainty(1),
            scatter.coverage_factor,
            scatter.dof,
        );
        let (u_drift, k_drift, dof) = match parts.groups.is_empty() {
            true => (own, k, dof),
            false => {
                let whole = scatter.with_common(1, &parts.common(&scatter.gain[n..2 * n]));
                (whole.standard_uncertainty, whole.coverage_factor, whole.dof)
            }
        };
        let drift = Quantity {
            name: format!("drift.{name}"),
            unit: format!("{unit}/month"),
            value: x[1] / reach,
            standard_uncertainty: u_drift / reach,
            dof,
        };
        let (c00, c01, c11) = (
            scatter.covariance[0],
            scatter.covariance[1],
            scatter.covariance[3],
        );
        let limit = |m: f64, own: f64| {
            let z = m / reach;
            let variance = c00 + 2.0 * z * c01 + z * z * c11 + own * own + scatter.excess_variance;
            let centre = pedestal + x[0] + x[1] * z;
            let half = scatter.coverage_factor * variance.sqrt();
            (centre, half)
        };
        let limits = values
            .iter()
            .zip(&months)
            .map(|(q, m)| {
                let (centre, half) = limit(*m, q.standard_uncertainty);
                [q.day, centre - half, centre + half]
            })
            .collect();
        let own = values[n - 1].standard_uncertainty;
        let due_in = question.tolerance.map(|tolerance| {
            // Change since the last calibration: drift times time, its own uncertainty and the reproducibility.
            let fixed = scatter.coverage_factor.powi(2) * (own * own + scatter.excess_variance);
            let grows = |m: f64| {
                let u = k_drift * drift.standard_uncertainty * m;
                (drift.value * m).abs() + (fixed + u * u).sqrt()
            };
            let (mut low, mut high) = (0.0, 12.0 * question.longest_interval);
            if grows(low) >= tolerance {
                return 0.0;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if grows(middle) < tolerance {
                    low = middle
                } else {
                    high = middle
                }
            }
            low * MONTH
        });
        Ok(Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            drift,
            level: pedestal + x[0],
            mean_day,
            excess: scatter.excess_variance.sqrt(),
            values: values
                .iter()
                .map(|q| [q.day, q.value, q.standard_uncertainty])
                .collect(),
            limits,
            due_in,
        })
    }
}

/// Which values share an error with others, and how large it is.
pub(super) struct SharedErrors {
    /// For each number that two or more values have: their places with the standard uncertainty.
    groups: Vec<Vec<(usize, f64)>>,
}

impl SharedErrors {
    pub(super) fn of(values: &[&DatedValue]) -> Self {
        let mut groups: std::collections::BTreeMap<u64, Vec<(usize, f64)>> = Default::default();
        for (i, value) in values.iter().enumerate() {
            if let Some((with, u)) = value.shared {
                groups.entry(with).or_default().push((i, u));
            }
        }
        Self {
            groups: groups.into_values().filter(|g| g.len() > 1).collect(),
        }
    }

    /// Variance of each value without what it shares. The most that may be shared is all but a millionth.
    pub(super) fn own_variances(&self, values: &[&DatedValue]) -> Vec<f64> {
        let mut own: Vec<f64> = values
            .iter()
            .map(|v| v.standard_uncertainty.powi(2))
            .collect();
        for &(i, u) in self.groups.iter().flatten() {
            own[i] = (own[i] - u * u).max(1e-6 * own[i]);
        }
        own
    }

    /// What the shared errors do to a parameter with this row of gains.
    pub(super) fn common(&self, gain: &[f64]) -> CommonErrors {
        self.groups
            .iter()
            .fold(CommonErrors::new(), |common, group| {
                let effect: f64 = group.iter().map(|(i, u)| gain[*i] * u).sum();
                common.with(effect.abs(), DegreesOfFreedom::INFINITE)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const QUESTION: DriftQuestion = DriftQuestion {
        probability: 0.95,
        tolerance: None,
        longest_interval: 12.0,
    };

    #[test]
    fn law_what_all_calibrations_share_cancels_in_the_drift() {
        let at = |k: usize, y: f64| {
            DatedValue::new(365.0 * k as f64, y, 0.5, DegreesOfFreedom::INFINITE)
        };
        let y = [1.0, 1.2, 1.1, 1.4, 1.3];
        let shared: Vec<DatedValue> = (0..5).map(|k| at(k, y[k]).sharing(7, 0.49)).collect();
        let own = (0.5_f64.powi(2) - 0.49 * 0.49).sqrt();
        let alone: Vec<DatedValue> = (0..5)
            .map(|k| DatedValue::new(365.0 * k as f64, y[k], own, DegreesOfFreedom::INFINITE))
            .collect();
        let [with, without] = [shared, alone].map(|v| Drift::of("S", "V", &v, &QUESTION).unwrap());
        assert!((with.drift.value - without.drift.value).abs() < 1e-12);
        let (a, b) = (
            with.drift.standard_uncertainty,
            without.drift.standard_uncertainty,
        );
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn coverage_drift_with_a_shared_reference() {
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
        let mut covered = 0;
        let trials = 1000;
        for trial in 0..trials {
            let n = 3 + trial % 28;
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let references: Vec<f64> = (0..10).map(|_| 0.3 * normal()).collect();
            let values: Vec<DatedValue> = (0..n)
                .map(|k| {
                    let own = 0.1 * normal();
                    let y = 5.0 + 0.01 * 12.0 * k as f64 + references[k / 4] + own;
                    DatedValue::new(
                        365.25 * k as f64,
                        y,
                        0.1_f64.hypot(0.3),
                        DegreesOfFreedom::INFINITE,
                    )
                    .sharing(k as u64 / 4, 0.3)
                })
                .collect();
            let drift = Drift::of("S", "V", &values, &QUESTION).unwrap().drift;
            covered += usize::from((drift.value - 0.01).abs() <= drift.expanded(0.95));
        }
        let share = covered as f64 / trials as f64;
        // Nominal 95 %, and three standard deviations of a thousand trials.
        assert!(share > 0.929, "{share}");
    }
}
