//! The uncertainty that a limit needs, and what has to be known to plan for it.

use super::{DevicePlanJob, PROBABILITY, PlanConditions, SensorNoise};
use crate::certificate::RuleWord;
use crate::data_sheet::{Characteristic, Measurement, ReadLimit, SheetDecision, unit};
use crate::trouble::{Result, Trouble};
use proofmass_noise::{NoiseModel, Sensor, Term};
use proofmass_uncertainty::normal_quantile;
use serde::Serialize;

/// What a limit needs so that a device with the typical value is decided.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Needed {
    /// The typical value, where one is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) typical: Option<f64>,
    /// From it to the nearer limit.
    pub(super) margin: f64,
    /// Largest expanded uncertainty.
    #[serde(rename = "expanded_uncertainty")]
    pub(super) expanded: f64,
    /// Tolerance-to-uncertainty ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ratio: Option<f64>,
}

#[cfg(test)]
impl Needed {
    pub(super) fn nothing() -> Self {
        Self {
            typical: None,
            margin: 0.0,
            expanded: 0.0,
            ratio: None,
        }
    }
}

/// What a limit is of, in SI: what one unit of it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum What {
    /// Bias, m/s².
    Bias,
    /// Scale, relative.
    Scale,
    /// Angle between axes, rad.
    Angle,
}

/// Everything that is known, so that every limit can be planned for.
pub(super) struct Known<'a> {
    pub(super) given: &'a PlanConditions,
    pub(super) decision: SheetDecision,
    pub(super) noise: Option<SensorNoise>,
    pub(super) limits: &'a [ReadLimit],
}

impl<'a> Known<'a> {
    /// # Errors
    /// Everything that is not known, in one.
    pub(super) fn of(job: &'a DevicePlanJob, limits: &'a [ReadLimit]) -> Result<Self> {
        if let Some(noise) = &job.noise {
            noise.check()?;
        }
        for limit in limits {
            per_si_of_noise(limit, 1.0)?;
        }
        let noise = match job.noise {
            Some(noise) => Some(noise),
            None => SensorNoise::of_sheet(limits)?,
        };
        let known = Self {
            given: &job.given,
            decision: job.sheet.decision,
            noise,
            limits,
        };
        known.ask(job.noise.is_some())?;
        Ok(known)
    }

    /// Refuses a plan for which something is not known.
    fn ask(&self, measured: bool) -> Result<()> {
        let given = self.given;
        if given.axes == 1
            && let Some((k, limit)) = self
                .limits
                .iter()
                .enumerate()
                .find(|(_, l)| l.is_between_axes())
        {
            let name = limit.characteristic.name();
            return Err(Trouble::request(format!(
                "limit {} ({name}) is between two axes, and the device has one",
                k + 1
            ))
            .with_hint("take the limit out of the sheet, or plan for three: --axes 3"));
        }
        let mut missing: Vec<(&str, String)> = Vec::new();
        let mut ask = |what: &'static str, how: String| {
            if !missing.iter().any(|(w, h)| *w == what && *h == how) {
                missing.push((what, how));
            }
        };
        let no_noise = self.noise.is_none_or(|n| n.white <= 0.0);
        for (k, limit) in self.limits.iter().enumerate() {
            let name = limit.characteristic.name();
            let shown_by = limit.characteristic.shown_by(limit.frequency.is_some());
            let one_sided = limit.limits.lower.is_none() || limit.limits.upper.is_none();
            let from_result = measured && matches!(shown_by, Measurement::Noise);
            if one_sided && limit.typical.is_none() && !from_result {
                ask(
                    "the value that a device typically has",
                    format!("typical = … in limit {} ({name}) of the sheet", k + 1),
                );
            }
            if no_noise && shown_by.needs_noise() {
                ask(
                    "the white noise of the sensor",
                    "--noise-result result.json of `proofmass noise`, or a [[limit]] of term = \"N\" with typical".to_owned(),
                );
            }
            if shown_by == Measurement::Noise && given.rate.is_none() {
                ask("the sampling rate", "--rate HZ".to_owned());
            }
            if shown_by == Measurement::Positions && given.gravity_uncertainty.is_none() {
                ask(
                    "the uncertainty of gravity",
                    "--gravity-uncertainty M_PER_S2 (0.0001 from a map, 0.03 without a place)"
                        .to_owned(),
                );
            }
            if shown_by == Measurement::Positions
                && given.axes == 1
                && given.fixture_angle.is_none()
            {
                ask(
                    "the uncertainty of the angles of the fixture",
                    "--fixture-angle DEG (1 where it was set by eye)".to_owned(),
                );
            }
            if shown_by.needs_reference() && given.reference_uncertainty.is_none() {
                ask(
                    "the standard uncertainty of the reference",
                    "--reference-uncertainty PERCENT".to_owned(),
                );
            }
            if shown_by == Measurement::Temperature
                && limit.temperature.is_none()
                && given.temperature_range.is_none()
            {
                ask(
                    "the range of temperatures",
                    "--temperature-range=LOW,HIGH, or temperature_degC in the limit".to_owned(),
                );
            }
            if shown_by == Measurement::Levels && given.acceleration.is_none() {
                ask(
                    "the largest acceleration of the levels",
                    "--acceleration M_PER_S2".to_owned(),
                );
            }
            if name.starts_with("bias") && self.si_of_bias(limit).is_none() {
                ask(
                    "the scale that brings the bias to an acceleration",
                    "a [[limit]] of characteristic = \"scale\" with nominal in the sheet"
                        .to_owned(),
                );
            }
        }
        match &missing[..] {
            [] => Ok(()),
            all => {
                let what: Vec<&str> = all.iter().map(|(what, _)| *what).collect();
                let mut distinct = what.clone();
                distinct.dedup();
                let mut trouble = Trouble::request(format!(
                    "the plan needs {} that nobody stated: {}",
                    match distinct.len() {
                        1 => "one thing".to_owned(),
                        n => format!("{n} things"),
                    },
                    distinct.join(", ")
                ));
                for (what, how) in all {
                    trouble = trouble.detail(format!("{what}: {how}"));
                }
                let how: Vec<&str> = all.iter().map(|(_, how)| how.as_str()).collect();
                Err(trouble.with_hint(format!("add {}", how.join("; "))))
            }
        }
    }

    /// r of the guard band; none without one.
    pub(super) fn r(&self) -> f64 {
        match self.decision.rule {
            RuleWord::GuardBand => self.decision.r,
            RuleWord::Simple => 0.0,
        }
    }

    /// What a limit needs: r U + z u within the margin, z the normal quantile of the share that is to be decided.
    ///
    /// Without a typical value the ratio of half the tolerance to U is that of the request.
    ///
    /// # Errors
    /// A unit that the noise of an accelerometer does not have.
    pub(super) fn needed(&self, limit: &ReadLimit) -> Result<Needed> {
        let normal = normal_quantile(0.5 + 0.5 * PROBABILITY);
        let spread = self.r() + normal_quantile(self.given.decided) / normal;
        let typical = match (limit.typical, limit.characteristic) {
            (Some(t), _) => Some(t),
            (None, Characteristic::Noise(term)) => self.typical_noise(limit, term)?,
            (None, _) => None,
        };
        let (lower, upper) = (limit.limits.lower, limit.limits.upper);
        let half = lower.zip(upper).map(|(l, u)| 0.5 * (u - l));
        let (margin, expanded) = match (typical, half) {
            (Some(t), _) => {
                let away = [lower.map(|l| t - l), upper.map(|u| u - t)];
                let margin = away.into_iter().flatten().fold(f64::INFINITY, f64::min);
                (margin.max(0.0), margin.max(0.0) / spread)
            }
            (None, Some(half)) => {
                let expanded = half / self.given.ratio;
                (spread * expanded, expanded)
            }
            (None, None) => (0.0, 0.0),
        };
        Ok(Needed {
            typical,
            margin,
            expanded,
            ratio: (expanded > 0.0).then(|| half.unwrap_or(margin) / expanded),
        })
    }

    /// The value of the noise result in the unit of a limit.
    fn typical_noise(&self, limit: &ReadLimit, term: Term) -> Result<Option<f64>> {
        let Some(noise) = self.noise else {
            return Ok(None);
        };
        let si = noise.of(term);
        Ok(self.per_si_of_noise(limit)?.map(|factor| factor * si))
    }

    /// How many units of the limit one SI unit of the coefficient is.
    pub(super) fn per_si_of_noise(&self, limit: &ReadLimit) -> Result<Option<f64>> {
        per_si_of_noise(limit, self.given.rate.unwrap_or(1.0))
    }

    /// What one unit of a limit of the bias, its change with temperature or time, is in m/s², m/s²/K or m/s²/month.
    pub(super) fn si_of_bias(&self, limit: &ReadLimit) -> Option<f64> {
        let (per, plain) = match limit.characteristic.name() {
            "bias-temperature" => ("/K", "m/s²/K"),
            "bias-drift" => ("/month", "m/s²/month"),
            _ => ("", "m/s²"),
        };
        if let Some(factor) = unit::ratio(&limit.unit, plain) {
            return Some(factor);
        }
        // In the unit of the output: by the scale that the sheet states.
        let scale = self
            .limits
            .iter()
            .find(|l| l.characteristic.name() == "scale" && l.frequency.is_none())?;
        let size = size_of(scale);
        let factor = unit::ratio(&limit.unit, &format!("(m/s²)·({}){per}", scale.unit))?;
        (size > 0.0).then(|| factor / size)
    }

    /// What a limit of positions is of, and what one unit of it is in SI.
    pub(super) fn in_si(&self, limit: &ReadLimit) -> (What, f64) {
        match limit.characteristic.name() {
            "bias" => (What::Bias, self.si_of_bias(limit).unwrap_or(1.0)),
            "scale" => (What::Scale, 1.0 / size_of(limit)),
            _ => (What::Angle, unit::ratio(&limit.unit, "rad").unwrap_or(1.0)),
        }
    }

    /// Whether nothing is known of noise slower than white, and something of the plan rests on it.
    pub(super) fn slow_noise_unknown(&self) -> bool {
        let rests_on_it = self.limits.iter().any(|l| {
            let shown_by = l.characteristic.shown_by(l.frequency.is_some());
            shown_by.needs_noise()
        });
        rests_on_it
            && self
                .noise
                .is_some_and(|n| n.flicker <= 0.0 && n.walk <= 0.0)
    }

    /// The noise of the sensor; where nobody stated any, none.
    pub(super) fn model(&self) -> NoiseModel {
        let noise = self.noise.unwrap_or_default();
        NoiseModel {
            white: noise.white,
            flicker: noise.flicker,
            random_walk: noise.walk,
            ..NoiseModel::default()
        }
    }
}

/// How many units of a limit of noise one SI unit of its coefficient is; `None` of another limit.
///
/// # Errors
/// A unit that the noise of an accelerometer does not have.
pub(super) fn per_si_of_noise(limit: &ReadLimit, rate: f64) -> Result<Option<f64>> {
    let Some(noise) = limit.noise() else {
        return Ok(None);
    };
    match noise.conversion(Sensor::Accelerometer, rate)? {
        Some(conversion) => Ok(Some(conversion.value)),
        None => Err(Trouble::request(format!(
            "{:?} is no unit of {} of an accelerometer",
            limit.unit,
            limit.characteristic.name()
        ))
        .with_hint("plans are those of accelerometers: write N in µg/√Hz, B in µg, K in µg/√s")),
    }
}

/// Size of a scale: its typical value, the middle of its limits, or the one that there is.
pub(super) fn size_of(limit: &ReadLimit) -> f64 {
    let middle = match (limit.limits.lower, limit.limits.upper) {
        (Some(l), Some(u)) if l + u != 0.0 => 0.5 * (l + u),
        (Some(l), Some(u)) => l.abs().max(u.abs()),
        (Some(one), None) | (None, Some(one)) => one,
        (None, None) => 1.0,
    };
    limit.typical.filter(|t| *t != 0.0).unwrap_or(middle).abs()
}

impl Measurement {
    /// Whether its length rests on the noise of the sensor.
    fn needs_noise(self) -> bool {
        matches!(
            self,
            Self::Noise | Self::Positions | Self::Temperature | Self::Levels | Self::Calibrations
        )
    }

    /// Whether accelerations of a reference stand behind it.
    fn needs_reference(self) -> bool {
        matches!(self, Self::Shaker | Self::Levels)
    }

    /// Whether one measurement shows all its limits.
    pub(super) fn is_one_for_all(self) -> bool {
        matches!(
            self,
            Self::Noise | Self::Positions | Self::Temperature | Self::Levels
        )
    }
}
