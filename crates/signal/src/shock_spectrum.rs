//! Shock response spectrum: the extremes of oscillators that a record of acceleration drives.

mod kernel;
#[cfg(test)]
mod tests;

use crate::oscillator::{Oscillator, Reading};
use proofmass_core::check::positive;
use proofmass_core::{Error, Unwatched, Watch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// What of an oscillator on the moving base is looked at. x is the displacement of its mass relative to the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Response {
    /// Acceleration of the mass in space, −ω²x − 2ζω x′; U for a record in U.
    #[default]
    AbsoluteAcceleration,
    /// x; U·s².
    RelativeDisplacement,
    /// x′; U·s.
    RelativeVelocity,
    /// ωx; U·s.
    PseudoVelocity,
    /// ω²x, the acceleration that would deflect the spring as far at rest; U.
    PseudoAcceleration,
}

impl Response {
    /// Every response.
    pub const ALL: [Self; 5] = [
        Self::AbsoluteAcceleration,
        Self::RelativeDisplacement,
        Self::RelativeVelocity,
        Self::PseudoVelocity,
        Self::PseudoAcceleration,
    ];

    fn reading(self, oscillator: &Oscillator) -> Reading {
        let omega = oscillator.pole.norm();
        let (x, v) = match self {
            // 2ζω = −2 Re λ.
            Self::AbsoluteAcceleration => (-omega * omega, 2.0 * oscillator.pole.re),
            Self::RelativeDisplacement => (1.0, 0.0),
            Self::RelativeVelocity => (0.0, 1.0),
            Self::PseudoVelocity => (omega, 0.0),
            Self::PseudoAcceleration => (omega * omega, 0.0),
        };
        oscillator.reading(x, v)
    }
}

/// Where extremes are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Peaks {
    /// At the samples, as ISO 18431-4 has it: low by up to ½(πf/f_s)² of the peak at natural frequency f.
    #[default]
    AtSamples,
    /// Also between them: the exact extremes of the response to the record joined by straight lines.
    BetweenSamples,
}

/// A shock response spectrum by ramp-invariant filters.
///
/// Oscillators x″ + 2ζω x′ + ω² x = −a at rest before the record; between samples a runs straight. **Primary** is what
/// happens until the shock ends, **residual** what follows: the rest of the record, then the free motion, whose extremes
/// are known in closed form and need no samples.
///
/// **Units** record in U, rate and frequencies in Hz.
///
/// **Assumes** the record begins at rest; an offset is a step for every oscillator, so remove it first, by name.
///
/// **Errors** [`Error::OutOfRange`] for a rate or a frequency that is not positive, a damping ratio outside [0, 1), a shock
/// that ends beyond the record; [`Error::TooFew`] without frequencies or below two samples; [`Error::NotFinite`];
/// [`Error::Cancelled`].
///
/// **Accuracy** the extremes of a half-sine's response agree with the analytic ones to 1e-9 at 4000 samples per pulse
/// (`known_half_sine_response`), and with an integration of high order to 1e-10 (`law_between_samples`).
///
/// **Source** `[ISO18431-4]`; the exact step is that of `[Nigam1969]`.
///
/// ```
/// use proofmass_signal::{Response, ShockSpectrum};
/// // 50 g for 11 ms, half-sine, Q = 10.
/// let rate = 100e3;
/// let pulse: Vec<f64> = (0..=1100).map(|n| 50.0 * (std::f64::consts::PI * n as f64 / 1100.0).sin()).collect();
/// let spectrum = ShockSpectrum::new(vec![30.0, 80.0, 140.0], 10.0).evaluate(&pulse, rate).unwrap();
/// let maximax: Vec<String> = spectrum.extremes.iter().map(|e| format!("{:.1}", e.maximax())).collect();
/// assert_eq!(maximax, ["55.4", "82.4", "70.2"]);
/// ```
#[doc(alias("SRS", "response spectrum"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShockSpectrum {
    /// Natural frequencies in Hz, in any order.
    pub frequencies: Vec<f64>,
    /// Damping ratio ζ = 1/(2Q).
    pub damping: f64,
    /// What of the oscillators is looked at.
    pub response: Response,
    /// Where extremes are looked for.
    pub peaks: Peaks,
    /// The first sample after the shock, from which on the response is residual; the end of the record when `None`.
    pub shock_end: Option<usize>,
}

/// Least and greatest values of a response; zero, the rest before the record, is always among them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extremes {
    /// During the shock, [least, greatest].
    pub primary: [f64; 2],
    /// In what is recorded after it.
    pub recorded: [f64; 2],
    /// In the free motion after the record.
    pub free: [f64; 2],
}

impl Extremes {
    /// After the shock, [least, greatest]: in the rest of the record and in the free motion.
    pub fn residual(&self) -> [f64; 2] {
        merge(self.recorded, self.free)
    }

    /// Within the record, [least, greatest].
    pub fn in_record(&self) -> [f64; 2] {
        merge(self.primary, self.recorded)
    }

    /// Greatest value at any time.
    pub fn max(&self) -> f64 {
        self.all()[1]
    }

    /// Least value at any time.
    pub fn min(&self) -> f64 {
        self.all()[0]
    }

    /// Greatest absolute value at any time.
    pub fn maximax(&self) -> f64 {
        absolute(self.all())
    }

    /// Greatest absolute value during the shock.
    pub fn primary_maximax(&self) -> f64 {
        absolute(self.primary)
    }

    /// Greatest absolute value after the shock.
    pub fn residual_maximax(&self) -> f64 {
        absolute(self.residual())
    }

    /// Greatest absolute value within the record.
    pub fn recorded_maximax(&self) -> f64 {
        absolute(self.in_record())
    }

    fn all(&self) -> [f64; 2] {
        merge(self.in_record(), self.free)
    }
}

fn merge(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

fn absolute([low, high]: [f64; 2]) -> f64 {
    high.max(-low)
}

/// Extremes at each natural frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ResponseSpectrum {
    /// Natural frequencies in Hz, as asked for.
    pub frequency: Vec<f64>,
    /// Damping ratio.
    pub damping: f64,
    /// What was looked at.
    pub response: Response,
    /// One per frequency.
    pub extremes: Vec<Extremes>,
}

impl ResponseSpectrum {
    /// A figure per frequency.
    pub fn curve(&self, figure: impl Fn(&Extremes) -> f64) -> Vec<f64> {
        self.extremes.iter().map(figure).collect()
    }
}

impl ShockSpectrum {
    /// Absolute acceleration at these natural frequencies, in Hz, with quality factor Q.
    pub fn new(frequencies: Vec<f64>, quality: f64) -> Self {
        Self {
            frequencies,
            damping: 0.5 / quality,
            response: Response::AbsoluteAcceleration,
            peaks: Peaks::AtSamples,
            shock_end: None,
        }
    }

    /// The spectrum of a record sampled at `rate`.
    ///
    /// # Errors
    /// Those of the type.
    pub fn evaluate(&self, record: &[f64], rate: f64) -> Result<ResponseSpectrum, Error> {
        self.evaluate_watched(record, rate, &Unwatched)
    }

    /// [`Self::evaluate`] under the eyes of somebody who may stop it.
    ///
    /// # Errors
    /// Those of the type.
    pub fn evaluate_watched(
        &self,
        record: &[f64],
        rate: f64,
        watch: &dyn Watch,
    ) -> Result<ResponseSpectrum, Error> {
        self.check(record, rate)?;
        let end = self.shock_end.unwrap_or(record.len());
        let oscillators: Vec<Oscillator> = self
            .frequencies
            .iter()
            .map(|f| Oscillator::new(*f, self.damping, 1.0 / rate))
            .collect();
        let task = kernel::Task {
            record,
            end,
            peaks: self.peaks,
            settles: self.response != Response::RelativeVelocity,
        };
        // A frequency is stepped alike in whatever company it is asked for.
        let (slow, fast): (Vec<usize>, Vec<usize>) =
            (0..oscillators.len()).partition(|k| kernel::slow(&oscillators[*k]));
        let blocks: Vec<&[usize]> = slow
            .chunks(kernel::LANES)
            .chain(fast.chunks(kernel::LANES))
            .collect();
        let (done, total) = (Mutex::new(0), blocks.len() as u64);
        let told = |more: u64| {
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            *done += more;
            watch.step("response spectrum", *done, total)
        };
        let parts: Vec<Vec<Extremes>> = blocks
            .par_iter()
            .map(|indices| {
                let block: Vec<Oscillator> = indices.iter().map(|k| oscillators[*k]).collect();
                let kappas: Vec<Reading> = block.iter().map(|o| self.response.reading(o)).collect();
                let extremes = kernel::extremes(&block, &kappas, &task, &|| told(0))?;
                told(1).map(|()| extremes)
            })
            .collect::<Result<_, _>>()?;
        let mut extremes = vec![Extremes::default(); oscillators.len()];
        for (indices, part) in blocks.iter().zip(parts) {
            for (k, e) in indices.iter().zip(part) {
                extremes[*k] = e;
            }
        }
        Ok(ResponseSpectrum {
            frequency: self.frequencies.clone(),
            damping: self.damping,
            response: self.response,
            extremes,
        })
    }

    fn check(&self, record: &[f64], rate: f64) -> Result<(), Error> {
        positive("sample rate", rate)?;
        if self.frequencies.is_empty() {
            return Err(Error::TooFew {
                name: "natural frequencies",
                needed: 1,
                got: 0,
            });
        }
        for f in &self.frequencies {
            positive("natural frequency", *f)?;
        }
        if !(0.0..1.0).contains(&self.damping) {
            return Err(Error::OutOfRange {
                name: "damping ratio",
                value: self.damping,
                min: 0.0,
                max: 1.0,
            });
        }
        if record.len() < 2 {
            return Err(Error::TooFew {
                name: "samples",
                needed: 2,
                got: record.len(),
            });
        }
        proofmass_core::check::finite("record", record)?;
        if let Some(end) = self
            .shock_end
            .filter(|end| *end > record.len() || *end == 0)
        {
            return Err(Error::OutOfRange {
                name: "end of the shock",
                value: end as f64,
                min: 1.0,
                max: record.len() as f64,
            });
        }
        Ok(())
    }
}

/// Frequencies from `low` to at least `high` with `per_octave` equal ratios to the octave.
///
/// ```
/// let f = proofmass_signal::octaves(10.0, 80.0, 1);
/// assert_eq!(f.len(), 4);
/// assert!((f[3] - 80.0).abs() < 1e-12);
/// ```
pub fn octaves(low: f64, high: f64, per_octave: u32) -> Vec<f64> {
    if !(low > 0.0 && high >= low && high.is_finite()) || per_octave == 0 {
        return Vec::new();
    }
    // A rounding below the last step does not make one more.
    let steps = (f64::from(per_octave) * (high / low).log2() - 1e-9).ceil() as u32;
    (0..=steps)
        .map(|k| low * (f64::from(k) / f64::from(per_octave)).exp2())
        .collect()
}
