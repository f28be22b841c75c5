//! Coefficients as they are reported: with an interval, or with the reason why there is none.

use crate::profile::Profile;
use crate::{
    Course, FrontEnd, GaussMarkov, NoiseModel, Sinusoid, SlowMisfit, TemperatureSensitivity, Term,
};
use proofmass_core::Error;
use proofmass_uncertainty::normal_quantile;
use proofmass_uncertainty::{Covariance, Figure, Finding};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why a coefficient is not given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
#[non_exhaustive]
pub enum Reason {
    /// Zero lies in the interval: the likelihood falls too little without the term.
    NoSupport {
        /// Twice the loss of log-likelihood without the term, zero when its best value is zero.
        gain: f64,
        /// The loss at which the interval would not reach zero.
        needed: f64,
    },
    /// A model without it describes the data; no limit was found.
    OtherTermsSuffice,
    /// Temperature and ramp have the same course in this record.
    Collinear,
    /// The output follows the temperature with a lag for which the record is too short.
    LagOpen {
        /// Lower limit of the lag, s.
        at_least: f64,
    },
    /// Only the band below a filter was used, in which the term has no share.
    BeyondBand {
        /// Highest frequency used, Hz.
        highest_frequency: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSupport { gain, needed } => write!(
                f,
                "the likelihood loses {gain:.1} without it, {needed:.1} are needed to exclude zero"
            ),
            Self::OtherTermsSuffice => f.write_str("the other terms describe the data without it"),
            Self::Collinear => {
                f.write_str("the temperature changes like a ramp: the two cannot be separated")
            }
            Self::LagOpen { at_least } => write!(
                f,
                "the output follows with a lag above {} s, for which the record is too short",
                figure(*at_least)
            ),
            Self::BeyondBand { highest_frequency } => write!(
                f,
                "cannot be separated from the shape of the upper spectrum (used from 0 to {} Hz)",
                figure(*highest_frequency)
            ),
        }
    }
}

/// Four significant digits as a person writes them: 31.67, 0.0042, 1.34×10⁻⁵.
pub(crate) fn figure(value: f64) -> String {
    Figure(value).to_string()
}

/// What is known of one coefficient.
///
/// The words differ, the interval does not: it is computed with every term in the model, whether zero lies in it or not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "verdict")]
pub enum Verdict {
    /// The interval excludes zero, and the term gains more than chance brings at the stated false-alarm rate.
    Identified {
        /// The coefficient.
        value: f64,
        /// Half the interval over its coverage factor.
        standard_uncertainty: f64,
        /// Lower and upper limit at the probability of the fit.
        interval: (f64, f64),
        /// Twice the loss of log-likelihood without the term.
        gain: f64,
    },
    /// The interval excludes zero; chance does that in up to one record of 1/(1 − probability).
    Present {
        /// The coefficient.
        value: f64,
        /// Half the interval over its coverage factor.
        standard_uncertainty: f64,
        /// Lower and upper limit at the probability of the fit.
        interval: (f64, f64),
        /// Twice the loss of log-likelihood without the term.
        gain: f64,
    },
    /// The caller asked for it, and zero lies in the interval ([`FitOptions::forced`]).
    Reported {
        /// The coefficient.
        value: f64,
        /// Half the interval over its coverage factor.
        standard_uncertainty: f64,
        /// Lower and upper limit at the probability of the fit.
        interval: (f64, f64),
        /// Twice the loss of log-likelihood without the term.
        gain: f64,
    },
    /// The data do not tell the term from none.
    NotIdentifiable {
        /// Why not.
        reason: Reason,
        /// Its most likely value, often zero: what a filter or a simulation should take, not a result.
        estimate: Option<f64>,
        /// The coefficient is below this (its interval at the probability of the fit ends there).
        upper_limit: Option<f64>,
    },
    /// The caller gave it.
    Fixed {
        /// The coefficient.
        value: f64,
    },
}

impl Verdict {
    /// The value, when there is one to report.
    pub fn value(&self) -> Option<f64> {
        match *self {
            Self::Identified { value, .. }
            | Self::Present { value, .. }
            | Self::Reported { value, .. }
            | Self::Fixed { value } => Some(value),
            Self::NotIdentifiable { .. } => None,
        }
    }

    /// The interval, when it excludes zero or was asked for.
    pub fn interval(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Identified { interval, .. }
            | Self::Present { interval, .. }
            | Self::Reported { interval, .. } => Some(interval),
            Self::NotIdentifiable { .. } | Self::Fixed { .. } => None,
        }
    }

    /// Standard uncertainty, when there is a value.
    pub fn standard_uncertainty(&self) -> Option<f64> {
        match *self {
            Self::Identified {
                standard_uncertainty,
                ..
            }
            | Self::Present {
                standard_uncertainty,
                ..
            }
            | Self::Reported {
                standard_uncertainty,
                ..
            } => Some(standard_uncertainty),
            Self::NotIdentifiable { .. } | Self::Fixed { .. } => None,
        }
    }

    /// What the coefficient cannot exceed: the upper end of its interval, or the limit.
    pub fn upper(&self) -> Option<f64> {
        match *self {
            Self::Identified { interval, .. }
            | Self::Present { interval, .. }
            | Self::Reported { interval, .. } => Some(interval.1.abs().max(interval.0.abs())),
            Self::NotIdentifiable { upper_limit, .. } => upper_limit,
            Self::Fixed { value } => Some(value.abs()),
        }
    }

    /// The most likely value, reported or not.
    pub fn estimate(&self) -> Option<f64> {
        match *self {
            Self::NotIdentifiable { estimate, .. } => estimate,
            _ => self.value(),
        }
    }

    /// What a filter should take: the most likely value, or the upper limit (`true`) where that is zero. `None` without either.
    pub fn for_filters(&self) -> Option<(f64, bool)> {
        match self.estimate() {
            Some(value) if value > 0.0 => Some((value, false)),
            _ => self.upper().map(|limit| (limit, true)),
        }
    }

    /// Whether it stands out of chance at the stated false-alarm rate.
    pub fn is_identified(&self) -> bool {
        matches!(self, Self::Identified { .. })
    }
}

/// From a profile to a verdict.
pub(crate) struct Limits {
    /// Gain for "identified".
    pub(crate) needed: f64,
    /// Gain at which the interval excludes zero.
    pub(crate) excludes_zero: f64,
    /// Whether the caller asked for the term whatever its interval.
    pub(crate) forced: bool,
    pub(crate) probability: f64,
}

impl Limits {
    pub(crate) fn verdict(&self, profile: &Profile) -> Verdict {
        let Profile {
            best: value,
            interval,
            gain,
        } = *profile;
        let standard_uncertainty = self.standard_uncertainty(profile);
        if gain > self.needed.max(self.excludes_zero) {
            Verdict::Identified {
                value,
                standard_uncertainty,
                interval,
                gain,
            }
        } else if gain > self.excludes_zero {
            Verdict::Present {
                value,
                standard_uncertainty,
                interval,
                gain,
            }
        } else if self.forced {
            Verdict::Reported {
                value,
                standard_uncertainty,
                interval,
                gain,
            }
        } else {
            Verdict::NotIdentifiable {
                reason: Reason::NoSupport {
                    gain,
                    needed: self.excludes_zero,
                },
                estimate: Some(value),
                upper_limit: Some(interval.0.abs().max(interval.1.abs())),
            }
        }
    }

    pub(crate) fn standard_uncertainty(&self, profile: &Profile) -> f64 {
        let k = normal_quantile(0.5 * (1.0 + self.probability));
        0.5 * (profile.interval.1 - profile.interval.0) / k
    }
}

/// One coefficient with its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Coefficient {
    /// Which process.
    pub term: Term,
    /// Unit of the coefficient.
    pub unit: String,
    /// Number with interval, or reason.
    pub verdict: Verdict,
    /// Correlation time in s (Gauss–Markov) or frequency in Hz (sinusoid).
    pub parameter: Option<TermParameter>,
}

/// The second number of a term that has two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TermParameter {
    /// Its value.
    pub value: f64,
    /// Its limits at the probability of the fit, where they are computed.
    pub interval: Option<(f64, f64)>,
}

/// The band of the spectrum a fit rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BandUse {
    /// Highest frequency used, Hz.
    pub highest_frequency: f64,
    /// Whether the spectrum does not follow the terms alone up to half the sample rate: part of it was left out, or a front end is part
    /// of the fit.
    pub cut: bool,
    /// What shapes the noise in front of the converter, where something simple does: part of the fit.
    #[serde(default)]
    pub front_end: Option<FrontEnd>,
    /// Up to which frequency terms and front end together describe the spectrum, Hz: not below `highest_frequency`.
    #[serde(default)]
    pub(crate) described_to: f64,
}

/// A fitted noise model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CoefficientFit {
    /// Probability of the intervals.
    pub probability: f64,
    /// Probability at which a term that is not there is called identified.
    pub false_alarm_rate: f64,
    /// One entry per term of the model, in the order of [`Term`]; several for Gauss–Markov processes and sinusoids.
    pub coefficients: Vec<Coefficient>,
    /// The most likely model: every term at its best value, identified or not; the ramp only when zero is excluded.
    pub model: NoiseModel,
    /// Covariance of the coefficients given as values, in their order.
    pub covariance: Covariance,
    /// Relative root mean square departure of the spectrum from the model beyond its scatter, zero when chance explains it.
    pub discrepancy: f64,
    /// What part of the spectrum was used.
    pub band: BandUse,
    /// How the output follows the temperature, where one was recorded beside it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<TemperatureSensitivity>,
    /// Courses beside noise that were found: they are taken out of all coefficients.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub courses: Vec<Course>,
    /// Where the slowest cycles do not follow the noise of the whole band: K is that of the lowest frequencies, its interval that of both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slow_misfit: Option<SlowMisfit>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl CoefficientFit {
    /// The first coefficient of a term, if it was sought.
    pub fn get(&self, term: Term) -> Option<&Coefficient> {
        self.coefficients.iter().find(|c| c.term == term)
    }

    /// One-sided density of the fitted noise behind the front end that was found, U²/Hz, without ramp and sinusoids.
    ///
    /// Beyond the frequency up to which the front end is known it takes off what it does there.
    pub fn density(&self, frequency: f64, sample_rate: f64) -> f64 {
        let all = self.model.density(frequency, sample_rate);
        let Some(shape) = self.band.front_end else {
            return all;
        };
        let behind = self.model.quantisation.powi(2)
            * crate::model::term_density(Term::Quantisation, frequency, sample_rate);
        let known = frequency.min(self.band.described_to);
        behind + (all - behind) * shape.response(known, sample_rate)
    }

    /// The most likely random walk, or its upper limit (`true`) where that is zero.
    pub fn random_walk_or_limit(&self) -> (f64, bool) {
        let verdict = self.get(Term::RandomWalk).map(|c| c.verdict);
        let limit = verdict.and_then(|v| v.for_filters());
        limit.unwrap_or((self.model.random_walk, false))
    }

    /// Value of a term, if there is one to report.
    pub fn value(&self, term: Term) -> Option<f64> {
        self.get(term).and_then(|c| c.verdict.value())
    }
}

/// Which terms are in the model, and what is called identified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FitOptions {
    /// Terms of the model. Gauss–Markov processes and sinusoids are sought when named.
    pub terms: Vec<Term>,
    /// Terms reported with a value whatever the data say of zero.
    pub forced: Vec<Term>,
    /// Coefficients that are known: held at their value.
    pub fixed: Vec<(Term, f64)>,
    /// Probability of the intervals.
    pub probability: f64,
    /// Probability at which a term that is not there may be called identified, each term by itself.
    pub false_alarm_rate: f64,
    /// Unit of the rate, for the units of the coefficients.
    pub unit: String,
    /// Highest frequency used, Hz; `None` seeks the highest one below which no filter shows.
    pub highest_frequency: Option<f64>,
    /// How many samples of the sensor were averaged into each of the record, whose spectrum differs for it.
    pub averaged: usize,
    /// First-order lag of the output behind the thermometer, s; `None` seeks it.
    pub temperature_lag: Option<f64>,
    /// Whether courses beside noise are sought: settling after the start, a lasting step, the cycle of the day.
    pub courses: bool,
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
            forced: Vec::new(),
            fixed: Vec::new(),
            probability: 0.95,
            false_alarm_rate: 0.002,
            unit: "m/s²".to_owned(),
            highest_frequency: None,
            averaged: 1,
            temperature_lag: None,
            courses: true,
        }
    }
}

/// Refuses a false-alarm rate outside (0, 1), under its own name.
pub(crate) fn check_false_alarm_rate(value: f64) -> Result<(), Error> {
    if value > 0.0 && value < 1.0 {
        return Ok(());
    }
    Err(Error::OutOfRange {
        name: "false-alarm rate",
        value,
        min: 0.0,
        max: 1.0,
    })
}

impl FitOptions {
    pub(crate) fn seeks(&self, term: Term) -> bool {
        self.terms.contains(&term)
    }

    /// The value a term is held at.
    pub(crate) fn fixed(&self, term: Term) -> Option<f64> {
        self.fixed.iter().find(|f| f.0 == term).map(|f| f.1)
    }

    /// Refuses what no fit can follow.
    pub(crate) fn check(&self, sample_rate: f64) -> Result<(), Error> {
        proofmass_core::check::probability(self.probability)?;
        check_false_alarm_rate(self.false_alarm_rate)?;
        proofmass_core::check::not_negative(
            "lag behind the temperature in s",
            self.temperature_lag.unwrap_or(0.0),
        )?;
        let nyquist = 0.5 * sample_rate;
        match self.highest_frequency {
            Some(f) if !(f > 0.0 && f <= nyquist * (1.0 + 1e-12)) => Err(Error::OutOfRange {
                name: "highest frequency in Hz",
                value: f,
                min: 0.0,
                max: nyquist,
            }),
            _ => match self
                .fixed
                .iter()
                .find(|f| !f.1.is_finite() || (f.1 < 0.0 && f.0 != Term::Ramp))
            {
                Some(f) => Err(Error::OutOfRange {
                    name: "fixed coefficient",
                    value: f.1,
                    min: 0.0,
                    max: f64::MAX,
                }),
                None => Ok(()),
            },
        }
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
