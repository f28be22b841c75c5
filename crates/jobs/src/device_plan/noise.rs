//! How long a recording of noise has to be.

use super::needed::{Known, Needed, per_si_of_noise};
use super::{PROBABILITY, Way};
use crate::bias::AxisNoise;
use crate::data_sheet::{Characteristic, ReadLimit};
use crate::noise::noise_of;
use crate::trouble::{Result, Trouble};
use proofmass_documents::Device;
use proofmass_io::{Input, Source};
use proofmass_noise::{AskedOfRecord, Term, samples_for_limit};
use proofmass_report::scientific;
use serde::{Deserialize, Serialize};

/// Noise of a sensor, two-sided, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct SensorNoise {
    /// White noise N, (m/s²)/√Hz.
    pub white: f64,
    /// Bias instability B, m/s².
    pub flicker: f64,
    /// Random walk K, (m/s²)·√Hz.
    pub walk: f64,
}

impl SensorNoise {
    /// Of the noisiest channel of each kind in a result of `noise`.
    ///
    /// # Errors
    /// Another file; units that are no acceleration; a result without coefficients.
    pub fn of_result(source: Source) -> Result<(Self, Input, Device)> {
        let name = source.name().display().to_string();
        let (analysis, input, device) = noise_of(source)?;
        let mut noise = Self::default();
        for channel in &analysis.channels {
            let (fit, factor) = AxisNoise::fit_of(channel).map_err(|e| e.detail(name.clone()))?;
            noise.white = noise.white.max(factor * fit.model.white);
            noise.flicker = noise.flicker.max(factor * fit.model.flicker);
            noise.walk = noise.walk.max(factor * fit.model.random_walk);
        }
        if noise.white <= 0.0 {
            return Err(Trouble::data("the noise result states no white noise")
                .detail(name)
                .with_hint("analyse a recording that resolves the noise"));
        }
        Ok((noise, input, device))
    }

    /// The typical values of the limits of N, B and K; the largest where axes have several.
    pub(super) fn of_sheet(limits: &[ReadLimit]) -> Result<Option<Self>> {
        let mut noise = Self::default();
        for limit in limits {
            let (Characteristic::Noise(term), Some(typical)) =
                (limit.characteristic, limit.typical)
            else {
                continue;
            };
            let Some(factor) = per_si_of_noise(limit, 1.0)? else {
                continue;
            };
            let own = match term {
                Term::White => &mut noise.white,
                Term::Flicker => &mut noise.flicker,
                Term::RandomWalk => &mut noise.walk,
                _ => continue,
            };
            *own = own.max(typical / factor);
        }
        Ok((noise != Self::default()).then_some(noise))
    }

    pub(super) fn check(&self) -> Result<()> {
        let all = [
            ("white", self.white),
            ("flicker", self.flicker),
            ("walk", self.walk),
        ];
        match all.into_iter().find(|(_, v)| !(*v >= 0.0 && v.is_finite())) {
            None => Ok(()),
            Some((name, value)) => Err(Trouble::request(format!(
                "the noise of the sensor cannot be {name} = {value}"
            ))
            .with_hint("units are those of m, s and Hz; numbers from zero on")),
        }
    }

    pub(super) fn of(&self, term: Term) -> f64 {
        match term {
            Term::White => self.white,
            Term::Flicker => self.flicker,
            Term::RandomWalk => self.walk,
            _ => 0.0,
        }
    }

    /// Variance of the mean over a time, and of what is new in the next such mean: white noise, and the floor of flicker noise.
    pub(super) fn of_mean(&self, duration: f64) -> (f64, f64) {
        let floor = 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI;
        (
            self.white.powi(2) / duration,
            floor * self.flicker.powi(2) + self.walk.powi(2) * duration / 3.0,
        )
    }
}

impl Known<'_> {
    /// The recording after which a limit of the noise is decided.
    pub(super) fn recording(&self, limit: &ReadLimit, needed: &Needed) -> Result<Way> {
        let Characteristic::Noise(term) = limit.characteristic else {
            return Ok(Way::open());
        };
        let rate = self.given.rate.unwrap_or(1.0);
        let (Some(factor), Some(upper)) = (self.per_si_of_noise(limit)?, limit.limits.upper) else {
            return Ok(Way::open());
        };
        let mut model = self.model();
        let own = needed.typical.unwrap_or(0.0) / factor;
        match term {
            Term::Quantisation => model.quantisation = own,
            Term::White => model.white = own,
            Term::Flicker => model.flicker = own,
            Term::RandomWalk => model.random_walk = own,
            Term::Ramp => model.ramp = own,
            _ => {}
        }
        let longest = 3600.0 * self.given.longest;
        let asked = AskedOfRecord {
            decided: self.given.decided,
            r: self.r(),
            probability: PROBABILITY,
            most: (longest * rate).min(1e15) as usize,
        };
        if own > upper / factor {
            return Ok(Way::out_of_reach(
                "record at rest".to_owned(),
                format!(
                    "{} of {} {} lies beyond its limit: such a sensor fails",
                    term.symbol(),
                    scientific(needed.typical.unwrap_or(0.0), 3),
                    limit.unit
                ),
            ));
        }
        let told = match term {
            Term::White => "at rest",
            _ => "at rest, at one temperature",
        };
        Ok(
            match samples_for_limit(&model, term, upper / factor, rate, &asked)? {
                Some(samples) => {
                    let duration = rounded_up(samples as f64 / rate);
                    Way::of(
                        format!(
                            "record {told} for {} at {} Hz",
                            spoken(duration),
                            short(rate)
                        ),
                        Some(duration),
                    )
                }
                None => Way::out_of_reach(
                    format!("record {told} for more than {}", spoken(longest)),
                    format!(
                        "{} of {} {} is too near to its limit for a recording of {}",
                        term.symbol(),
                        scientific(needed.typical.unwrap_or(0.0), 3),
                        limit.unit,
                        spoken(longest)
                    ),
                ),
            },
        )
    }
}

/// A time, rounded up to two digits.
pub(super) fn rounded_up(seconds: f64) -> f64 {
    if !(seconds > 0.0) {
        return 0.0;
    }
    let step = 10f64.powf(seconds.log10().floor() - 1.0);
    let rounded = (seconds / step - 1e-9).ceil() * step;
    // Without the rounding of the powers of ten.
    format!("{rounded:.6e}").parse().unwrap_or(rounded)
}

/// A time in the unit in which people say it.
pub(super) fn spoken(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{} s", short(s)),
        s if s < 7200.0 => format!("{} min", short(s / 60.0)),
        s if s < 172_800.0 => format!("{} h", short(s / 3600.0)),
        s => format!("{} days", short(s / 86_400.0)),
    }
}

/// A number with three digits at most.
pub(super) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    rounded.to_string()
}
