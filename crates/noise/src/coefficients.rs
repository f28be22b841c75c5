//! Coefficients as they are reported: with an interval, or with the reason why there is none.

use crate::{GaussMarkov, NoiseModel, Sinusoid, Term};
use proofmass_uncertainty::{Covariance, Finding};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::fmt;

/// How coefficients were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Maximum likelihood on the multitaper spectrum (Whittle).
    Whittle,
    /// Regression on the overlapping Allan variance with the covariance between averaging times.
    AllanRegression,
}

/// Why a coefficient is not given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Reason {
    /// Adding the term does not improve the likelihood enough to exclude chance.
    NoSupport {
        /// Twice the gain in log-likelihood with the term, zero when its best value is zero.
        gain: f64,
        /// The gain that chance exceeds at the stated false-alarm rate.
        needed: f64,
    },
    /// A simpler combination of other terms describes the data better than any with this one.
    OtherTermsSuffice,
    /// The trend is compatible with the other noise: its standard uncertainty under the fitted model.
    WithinNoise {
        /// The slope that was found, absolute.
        slope: f64,
        /// Its standard uncertainty.
        standard_uncertainty: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSupport { gain, needed } => write!(
                f,
                "the likelihood gains {gain:.1} with it, {needed:.1} are needed to exclude chance"
            ),
            Self::OtherTermsSuffice => f.write_str("the other terms describe the data without it"),
            Self::WithinNoise {
                slope,
                standard_uncertainty,
            } => write!(
                f,
                "the slope {} lies within its uncertainty of {} from the noise",
                figure(*slope),
                figure(*standard_uncertainty)
            ),
        }
    }
}

/// Four significant digits as a person writes them: 31.67, 0.0042, 1.34×10⁻⁵.
pub(crate) fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let rounded = format!("{value:.3e}");
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    match exponent.parse::<i32>() {
        Ok(e @ -3..=5) => format!("{value:.*}", usize::try_from(3 - e).unwrap_or(0)),
        _ => {
            let digit = |c: char| match c {
                '-' => '⁻',
                '0' => '⁰',
                '1' => '¹',
                '2' => '²',
                '3' => '³',
                _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
            };
            format!(
                "{mantissa}×10{}",
                exponent.chars().map(digit).collect::<String>()
            )
        }
    }
}

/// What is known of one coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "verdict")]
pub enum Verdict {
    /// The data support the term.
    Identified {
        /// The coefficient.
        value: f64,
        /// Its standard uncertainty.
        standard_uncertainty: f64,
        /// Lower and upper limit at the probability of the fit.
        interval: (f64, f64),
        /// Twice the loss of log-likelihood without the term.
        gain: f64,
    },
    /// The data do not support the term: no number is given.
    NotIdentifiable {
        /// Why not.
        reason: Reason,
        /// The coefficient is below this at the probability of the fit (one-sided), where that could be found.
        upper_limit: Option<f64>,
    },
}

impl Verdict {
    /// The value, when identified.
    pub fn value(&self) -> Option<f64> {
        match *self {
            Self::Identified { value, .. } => Some(value),
            Self::NotIdentifiable { .. } => None,
        }
    }

    /// The interval, when identified.
    pub fn interval(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Identified { interval, .. } => Some(interval),
            Self::NotIdentifiable { .. } => None,
        }
    }
}

/// One coefficient with its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficient {
    /// Which process.
    pub term: Term,
    /// Unit of the coefficient.
    pub unit: String,
    /// Number with interval, or reason.
    pub verdict: Verdict,
    /// Correlation time in s (Gauss–Markov) or frequency in Hz (sinusoid).
    pub parameter: Option<f64>,
}

/// A fitted noise model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoefficientFit {
    /// How it was found.
    pub method: Method,
    /// Probability of the intervals.
    pub probability: f64,
    /// Probability that white noise alone makes this fit report any further term.
    pub false_alarm_rate: f64,
    /// One entry per term sought, in the order of [`Term`]; several for sinusoids.
    pub coefficients: Vec<Coefficient>,
    /// The identified terms as a model.
    pub model: NoiseModel,
    /// Covariance of the identified coefficients, in their order.
    pub covariance: Covariance,
    /// Relative standard departure of the data from the model beyond their scatter, zero when the model describes them.
    pub discrepancy: f64,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl CoefficientFit {
    /// The first coefficient of a term, if it was sought.
    pub fn get(&self, term: Term) -> Option<&Coefficient> {
        self.coefficients.iter().find(|c| c.term == term)
    }

    /// Value of a term, if identified.
    pub fn value(&self, term: Term) -> Option<f64> {
        self.get(term).and_then(|c| c.verdict.value())
    }
}

/// What is sought, and how strictly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitOptions {
    /// Terms that may enter.
    pub terms: Vec<Term>,
    /// Probability of the intervals.
    pub probability: f64,
    /// Probability that a record without a process is reported to have one of those sought, all terms together.
    pub false_alarm_rate: f64,
    /// Unit of the rate, for the units of the coefficients.
    pub unit: String,
    /// Highest frequency used by the spectral fit, as a share of the Nyquist frequency. Sensors with a filter in
    /// front of the converter follow no power law near it.
    pub highest_frequency: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            terms: vec![
                Term::Quantisation,
                Term::White,
                Term::Flicker,
                Term::RandomWalk,
                Term::Ramp,
            ],
            probability: 0.95,
            false_alarm_rate: 1e-4,
            unit: "m/s²".to_owned(),
            highest_frequency: 1.0,
        }
    }
}

impl FitOptions {
    /// Twice the gain in log-likelihood a term must bring.
    ///
    /// A coefficient that cannot be negative has under the null hypothesis a gain of zero half of the time and χ²
    /// of one degree of freedom otherwise; the false-alarm rate is shared among the terms.
    pub(crate) fn needed_gain(&self) -> f64 {
        let per_term = self.false_alarm_rate / self.terms.len().max(1) as f64;
        chi_square_one(1.0 - 2.0 * per_term)
    }

    pub(crate) fn seeks(&self, term: Term) -> bool {
        self.terms.contains(&term)
    }
}

fn chi_square_one(p: f64) -> f64 {
    ChiSquared::new(1.0).map_or(f64::INFINITY, |d| d.inverse_cdf(p))
}

/// An identified coefficient c = √v from the estimate of its square v with variance `u2`.
///
/// v is a positive quadratic form: ν v̂/v is taken as χ² with ν = 2v²/u², which keeps the lower limit positive.
pub(crate) fn identified(v: f64, u2: f64, gain: f64, probability: f64) -> Verdict {
    let value = v.sqrt();
    let u = 0.5 * u2.sqrt() / value;
    let nu = 2.0 * v * v / u2;
    let interval = crate::chi_square_interval(value, nu, probability)
        .unwrap_or((value - 2.0 * u, value + 2.0 * u));
    Verdict::Identified {
        value,
        standard_uncertainty: u,
        interval,
        gain,
    }
}

impl NoiseModel {
    /// Sets the coefficient of a power law.
    pub(crate) fn set(&mut self, term: Term, value: f64) {
        match term {
            Term::Quantisation => self.quantisation = value,
            Term::White => self.white = value,
            Term::Flicker => self.flicker = value,
            Term::RandomWalk => self.random_walk = value,
            Term::Ramp => self.ramp = value,
            Term::GaussMarkov | Term::Sinusoid => {}
        }
    }

    /// Adds a Gauss–Markov process.
    pub(crate) fn push_markov(&mut self, standard_deviation: f64, correlation_time: f64) {
        self.gauss_markov.push(GaussMarkov {
            standard_deviation,
            correlation_time,
        });
    }

    /// Adds a sinusoid.
    pub(crate) fn push_line(&mut self, amplitude: f64, frequency: f64, phase: f64) {
        self.sinusoids.push(Sinusoid {
            amplitude,
            frequency,
            phase,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_are_for_people() {
        for (value, text) in [
            (31.67, "31.67"),
            (0.0042, "0.004200"),
            (1.34e-5, "1.340×10⁻⁵"),
            (-2.5e12, "-2.500×10¹²"),
            (123_456.0, "123456"),
            (0.0, "0"),
        ] {
            assert_eq!(figure(value), text);
        }
    }
}
