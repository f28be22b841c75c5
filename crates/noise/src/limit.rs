//! A coefficient against the limit of a data sheet, its measurement uncertainty allowed for.

use crate::{ChannelAnalysis, InUnit, Sensor, Term, Verdict, in_units};
use proofmass_core::Error;
/// How a coefficient stands to a limit, its measurement uncertainty allowed for.
pub use proofmass_uncertainty::Judgement as Conformity;
use proofmass_uncertainty::Limits;
use serde::{Deserialize, Serialize};

/// The largest value a data sheet allows for a coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct NoiseLimit {
    /// Which coefficient; of a ramp the magnitude counts.
    pub term: Term,
    /// The largest value allowed.
    pub most: f64,
    /// Its unit: of [`in_units`], such as µg/√Hz, °/√h, µg, °/h, or that of the coefficient in SI.
    pub unit: String,
    /// `one-sided` (what data sheets give: √2 N) or `two-sided`; `floor` (0.664 B, what data sheets give) or `coefficient`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meaning: Option<String>,
    /// Channels it is for; all when empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<String>,
}

impl NoiseLimit {
    /// A limit for every channel.
    pub fn new(term: Term, most: f64, unit: impl Into<String>) -> Self {
        Self {
            term,
            most,
            unit: unit.into(),
            meaning: None,
            channels: Vec::new(),
        }
    }

    /// What the meaning of a limit may be called.
    pub const MEANINGS: &'static [&'static str] =
        &["one-sided", "two-sided", "floor", "coefficient"];

    /// Whether its unit is one of the coefficient, for that sensor, whatever is meant by it.
    pub fn has_unit(&self, sensor: Sensor) -> bool {
        !self.candidates(sensor, 1.0).is_empty()
    }

    /// What one SI unit of the coefficient is in the unit of the limit, with what is meant by it.
    ///
    /// Without a meaning it is that of data sheets, in SI units too: the one-sided density √2 N, and of B the floor 0.664 B. The two-sided
    /// root density is the coefficient N.
    ///
    /// **Errors** [`Error::OutOfRange`] for a limit that is not positive; `Ok(None)` for a unit or a meaning that this coefficient does
    /// not have.
    pub fn conversion(&self, sensor: Sensor, sample_rate: f64) -> Result<Option<InUnit>, Error> {
        proofmass_core::check::positive("limit", self.most)?;
        let all = self.candidates(sensor, sample_rate);
        let wanted: &[&str] = match self.meaning.as_deref() {
            None => &["one-sided", "floor"],
            Some("two-sided" | "coefficient") if self.term == Term::White => {
                &["two-sided", "coefficient"]
            }
            Some(meaning) => match Self::MEANINGS.iter().position(|m| *m == meaning) {
                Some(k) => &Self::MEANINGS[k..=k],
                None => return Ok(None),
            },
        };
        let found = all
            .iter()
            .find(|u| wanted.iter().any(|w| u.meaning.contains(w)))
            .cloned();
        Ok(match (&self.meaning, found) {
            (None, None) => all.into_iter().next(),
            (_, found) => found,
        })
    }

    /// A channel of an analysis against this limit; `None` where the limit is not for it: another channel, no coefficients, a unit
    /// or a meaning of another kind of sensor.
    ///
    /// # Errors
    /// As [`NoiseLimit::conversion`].
    pub fn check(
        &self,
        channel: &ChannelAnalysis,
        sample_rate: f64,
    ) -> Result<Option<ChannelCheck>, Error> {
        let named = self.channels.is_empty() || self.channels.contains(&channel.name);
        let (true, Some(sensor), Some(fit)) =
            (named, Sensor::of_unit(&channel.unit), &channel.whittle)
        else {
            return Ok(None);
        };
        let Some(conversion) = self.conversion(sensor, sample_rate)? else {
            return Ok(None);
        };
        let verdict = fit.get(self.term).map(|c| c.verdict);
        Ok(Some(ChannelCheck {
            meaning: conversion.meaning,
            found: verdict.and_then(|v| against_limit(&v, conversion.value, self.most)),
        }))
    }

    /// What may be meant by the unit of the limit.
    fn candidates(&self, sensor: Sensor, sample_rate: f64) -> Vec<InUnit> {
        let wanted = written(&self.unit);
        let mut all = in_units(self.term, 1.0, sensor, sample_rate);
        let in_si = |factor: f64, meaning: &str| InUnit {
            value: factor,
            unit: self.term.unit(sensor.unit()),
            meaning: meaning.to_owned(),
        };
        match self.term {
            Term::White => all.push(in_si(
                std::f64::consts::SQRT_2,
                "one-sided amplitude density",
            )),
            Term::Flicker => all.push(in_si(
                crate::model::FLICKER.sqrt(),
                "floor of the Allan deviation, 0.664 B",
            )),
            _ => {}
        }
        all.retain(|u| written(&u.unit) == wanted);
        all
    }
}

/// A unit without the differences of keyboards.
fn written(unit: &str) -> String {
    let mut text: String = unit
        .chars()
        .filter(|c| !c.is_whitespace() && !"()".contains(*c))
        .collect();
    for (from, to) in [
        ("μ", "µ"),
        ("ug", "µg"),
        ("sqrtHz", "√Hz"),
        ("sqrth", "√h"),
        ("sqrts", "√s"),
        ("rtHz", "√Hz"),
        ("deg", "°"),
        ("^2", "²"),
        ("s2", "s²"),
        ("hr", "h"),
    ] {
        text = text.replace(from, to);
    }
    text
}

/// A coefficient against a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LimitCheck {
    /// The value, its most likely one where it is not identifiable, in the unit of the limit.
    pub value: Option<f64>,
    /// Its interval there; from zero where it is not identifiable.
    pub interval: (f64, f64),
    /// The verdict.
    pub conformity: Conformity,
}

/// A channel against a limit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChannelCheck {
    /// What is meant by the unit of the limit.
    pub meaning: String,
    /// What was found; `None` where the fit has no such coefficient, or nothing is known of it.
    pub found: Option<LimitCheck>,
}

/// Decides on a coefficient with its interval as guard band.
///
/// Each end of the two-sided interval at probability p decides one question, so a unit beyond the limit passes with a probability of at
/// most (1 − p)/2, and one within it fails with at most that: 2.5 % at 95 %. **Source** `[JCGM106]`.
///
/// `None` for a coefficient of which nothing is known. `factor` converts to the unit of the limit `most`.
pub fn against_limit(verdict: &Verdict, factor: f64, most: f64) -> Option<LimitCheck> {
    let (low, high) = match *verdict {
        Verdict::Fixed { value } => (value.abs(), value.abs()),
        _ => match verdict.interval() {
            Some((a, b)) if a * b > 0.0 => (a.abs().min(b.abs()), a.abs().max(b.abs())),
            Some((a, b)) => (0.0, a.abs().max(b.abs())),
            None => (0.0, verdict.upper()?),
        },
    };
    let interval = (factor * low, factor * high);
    Some(LimitCheck {
        value: verdict.estimate().map(|v| factor * v.abs()),
        interval,
        conformity: Limits::below(most).ok()?.judge(interval),
    })
}
