//! When to calibrate again: the rules by which an interval is set.

use super::stability::MONTH;
use serde::{Deserialize, Serialize};

/// A rule for the time to the next calibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "rule")]
#[non_exhaustive]
pub enum RecalibrationRule {
    /// Always the same interval.
    Fixed {
        /// The interval, months.
        months: f64,
    },
    /// Until the drift, with its uncertainty, may have used up the tolerance; the control-chart method of `[ILAC-G24]`.
    Drift {
        /// Longest interval, months; it also holds until there are three calibrations.
        longest: f64,
    },
    /// The staircase method of `[ILAC-G24]`: the interval grows by a quarter after a change within 80 % of the tolerance, and halves
    /// after one beyond the tolerance.
    Staircase {
        /// First interval, months.
        first: f64,
        /// Longest interval, months.
        longest: f64,
    },
}

impl Default for RecalibrationRule {
    fn default() -> Self {
        Self::Fixed { months: 12.0 }
    }
}

/// Share of the tolerance within which the staircase lengthens the interval.
const WITHIN: f64 = 0.8;
/// What it lengthens and shortens by.
const STEPS: [f64; 2] = [1.25, 0.5];
/// Share of the interval after which a calibration counts for a longer one.
const EARLY: f64 = 0.5;
/// Shortest interval of the staircase, months.
const SHORTEST: f64 = 1.0;

impl RecalibrationRule {
    /// Days from the last calibration to the next, and why, for changes between successive calibrations, the oldest first: days between the two
    /// and the change as a share of the tolerance (the largest of all quantities), and the days after which the drift may have used up a tolerance.
    pub fn days(&self, changes: &[(f64, f64)], drift: Option<f64>) -> (f64, String) {
        match *self {
            Self::Fixed { months } => (months * MONTH, format!("fixed: {months} months")),
            Self::Drift { longest } => {
                let most = longest * MONTH;
                match drift {
                    Some(days) if days < most => (
                        days,
                        format!(
                            "drift against tolerance: {days:.0} days, at most {longest} months"
                        ),
                    ),
                    Some(_) => (
                        most,
                        format!(
                            "drift against tolerance: longer than {longest} months, which is the most"
                        ),
                    ),
                    None => (
                        most,
                        format!("{longest} months: fewer than three calibrations, or no tolerance"),
                    ),
                }
            }
            Self::Staircase { first, longest } => {
                let mut months = first.min(longest);
                for (days, change) in changes {
                    months *= match change {
                        // A calibration long before it was due says nothing of a longer interval.
                        c if *c <= WITHIN && *days < EARLY * months * MONTH => 1.0,
                        c if *c <= WITHIN => STEPS[0],
                        c if *c > 1.0 => STEPS[1],
                        _ => 1.0,
                    };
                    months = months.clamp(SHORTEST.min(longest), longest);
                }
                let last = changes.last().map_or(String::new(), |(_, c)| {
                    format!(", the last of {:.0} % of the tolerance", 1e2 * c)
                });
                (
                    months * MONTH,
                    format!(
                        "staircase: {months:.1} months after {} changes{last}",
                        changes.len()
                    ),
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_intervals_of_the_rules() {
        let months = |rule: RecalibrationRule, changes: &[f64], drift| {
            let yearly: Vec<(f64, f64)> = changes.iter().map(|c| (365.0, *c)).collect();
            rule.days(&yearly, drift).0 / MONTH
        };
        let fixed = RecalibrationRule::Fixed { months: 6.0 };
        assert!((months(fixed, &[5.0], Some(1.0)) - 6.0).abs() < 1e-12);
        let stair = RecalibrationRule::Staircase {
            first: 12.0,
            longest: 24.0,
        };
        assert!((months(stair, &[0.1, 0.9, 2.0], None) - 7.5).abs() < 1e-12);
        assert!((months(stair, &[0.1; 9], None) - 24.0).abs() < 1e-12);
        // Monthly calibrations lengthen nothing, and a change beyond the tolerance shortens as ever.
        let monthly = [(30.0, 0.1), (30.0, 0.1), (30.0, 2.0)];
        assert!((stair.days(&monthly, None).0 / MONTH - 6.0).abs() < 1e-12);
        let drift = RecalibrationRule::Drift { longest: 12.0 };
        assert!((months(drift, &[], Some(3.0 * MONTH)) - 3.0).abs() < 1e-12);
        assert!((months(drift, &[], None) - 12.0).abs() < 1e-12);
    }
}
