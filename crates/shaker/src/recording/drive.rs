//! Several frequencies in one recording: all at once, or one after another.

use super::{PhasorReading, Phasors};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_dynamic::sine_steps::{NoSteps, Plateau, plateaus};
use proofmass_signal::sine::{Frequency, SineFit};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How the shaker is driven while a recording is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    /// One frequency from the first sample to the last.
    #[default]
    Sine,
    /// Several frequencies at once.
    MultiSine,
    /// Several frequencies one after another.
    Stepped,
}

/// What a recording of several frequencies says at one of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// Its phasors.
    Found(Box<Phasors>),
    /// No tone, or no step, of this frequency stands out; why.
    Missing(String),
    /// Nearer to another tone of the list than the record tells apart: that one, Hz.
    Unresolved(f64),
}

/// Resolutions (one over the duration) that two tones need between them.
const APART: f64 = 2.0;
/// Standard uncertainties of its amplitude by which a tone stands out.
const STANDS_OUT: f64 = 8.0;
/// Rounds in which the tones are fitted in turn, each to what the others leave.
const ROUNDS: usize = 40;
/// Change of the amplitudes, in standard uncertainties, at which they agree.
const AGREED: f64 = 0.01;
/// Share of a step, from its beginning, that is left to the device to settle, and at its end.
const SETTLING: (f64, f64) = (0.3, 0.03);
/// Periods that a step must have left.
const PERIODS: f64 = 6.0;
/// Samples below which the noise beside the line cannot be told.
const FEW: usize = 128;

impl PhasorReading {
    /// Phasors at each of several frequencies, in their order; `late` as for [`PhasorReading::phasors_at`].
    ///
    /// Of a multi-sine all tones are fitted to the whole record, each to what the others leave, until none changes. Tones
    /// that stand at harmonics of others are lines like all others: at its frequency the ratio of two channels is the same
    /// whatever drives them, so no harmonics are fitted and no distortion is told. Of a stepped sine the steps are
    /// found in the strongest channel, and 30 % of each are left to the device to settle.
    ///
    /// # Errors
    /// As [`PhasorReading::phasors_at`]. A tone or step that is not there is no error.
    pub fn lines(
        &self,
        drive: Drive,
        frequencies: &[f64],
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<Vec<Line>, Error> {
        match drive {
            Drive::Sine => frequencies
                .iter()
                .map(|f| Ok(Line::Found(Box::new(self.phasors_at(*f, late, channels)?))))
                .collect(),
            Drive::MultiSine => self.tones(frequencies, late, channels),
            Drive::Stepped => self.steps(frequencies, late, channels),
        }
    }

    fn tones(
        &self,
        frequencies: &[f64],
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<Vec<Line>, Error> {
        let lead = self.lead(channels)?;
        let resolution = self.sampling_frequency / channels[lead].len().max(1) as f64;
        let mut lines: Vec<Option<Line>> = frequencies
            .iter()
            .map(|f| {
                let mut others = frequencies.iter().filter(|g| *g != f);
                let near = others.find(|g| (*g - f).abs() < APART * resolution);
                near.map(|g| Line::Unresolved(*g))
            })
            .collect();
        // Those that cannot be told apart are fitted as one, so that they do not disturb the others.
        let mut wanted: Vec<usize> = vec![];
        for (i, f) in frequencies.iter().enumerate() {
            let apart = |k: &usize| (frequencies[*k] - f).abs() >= APART * resolution;
            if wanted.iter().all(apart) {
                wanted.push(i);
            }
        }
        let mut fits: Vec<Option<SineFit>> = vec![None; frequencies.len()];
        for _ in 0..ROUNDS {
            let mut change = 0.0f64;
            for &i in &wanted {
                let others = fits.iter().enumerate().filter(|(k, _)| *k != i);
                let others: Vec<&SineFit> = others.filter_map(|(_, f)| f.as_ref()).collect();
                let left = without(self.sampling_frequency, late, channels, &others);
                let views: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
                let start = match &fits[i] {
                    Some(fit) => fit.frequency,
                    None => self.near(
                        frequencies[i],
                        &wanted_of(frequencies, &wanted),
                        views[lead],
                    ),
                };
                let next = self.tone(frequencies[i], start, late, &views, lead)?;
                change = change.max(changed(fits[i].as_ref(), &next));
                fits[i] = Some(next);
            }
            if change < AGREED {
                break;
            }
        }
        for &i in &wanted {
            if lines[i].is_some() {
                continue;
            }
            let Some(fit) = &fits[i] else { continue };
            let c = &fit.channels[lead];
            let u = (0.5 * (c.covariance[0] + c.covariance[2])).sqrt();
            let off = (fit.frequency / frequencies[i] - 1.0).abs();
            lines[i] = Some(if c.modulus() < STANDS_OUT * u {
                Line::Missing(format!(
                    "an amplitude of {:.2e} with a standard uncertainty of {u:.1e}",
                    c.modulus()
                ))
            } else if off > self.tolerance && off * frequencies[i] > 2.0 * resolution {
                Line::Missing(format!("the nearest tone is at {:.4} Hz", fit.frequency))
            } else {
                let mut phasors = self.told(fit, channels, resolution);
                phasors.distortion = None;
                phasors.flattened = vec![];
                // What all tones together leave is the noise; clipping is seen in the sum.
                Line::Found(Box::new(phasors))
            });
        }
        Ok(lines
            .into_iter()
            .map(|l| l.unwrap_or_else(|| Line::Missing("no tone".to_owned())))
            .collect())
    }

    /// One tone in what the others leave; at its nominal frequency where no line is.
    fn tone(
        &self,
        nominal: f64,
        start: f64,
        late: &[f64],
        left: &[&[f64]],
        lead: usize,
    ) -> Result<SineFit, Error> {
        let approximation = self.approximation(nominal, 1);
        let free = self.fitted(&approximation.clone().start(start), late, left, lead);
        let fit = match free {
            Err(Error::NotConverged { .. } | Error::OutOfRange { .. }) => {
                self.fitted(&approximation.frequency(Frequency::Known), late, left, lead)
            }
            other => other,
        };
        fit.map(|(fit, _)| fit)
    }

    /// The strongest line near a frequency, no farther than half way to the next tone.
    fn near(&self, frequency: f64, all: &[f64], x: &[f64]) -> f64 {
        let n = x.len() as f64;
        let resolution = self.sampling_frequency / n;
        let gap = all
            .iter()
            .filter(|f| **f != frequency)
            .map(|f| 0.5 * (f - frequency).abs())
            .fold(f64::INFINITY, f64::min);
        let reach = (self.tolerance * frequency).min(gap);
        let steps = (2.0 * reach / resolution).ceil().min(2000.0);
        let power = |f: f64| -> f64 {
            let step = Complex64::from_polar(1.0, -TAU * f / self.sampling_frequency);
            let (mut z, mut sum) = (Complex64::new(1.0, 0.0), Complex64::new(0.0, 0.0));
            for (i, v) in x.iter().enumerate() {
                // A Hann window: neighbours that are not subtracted yet do not reach this far.
                let w = 0.5 - 0.5 * (TAU * i as f64 / n).cos();
                sum += z * (w * v);
                z *= step;
            }
            sum.norm_sqr()
        };
        let mut best = (power(frequency), frequency);
        if steps < 2.0 {
            return frequency;
        }
        for k in 0..=steps as usize {
            let f = frequency - reach + 2.0 * reach * k as f64 / steps;
            let here = power(f);
            if here > best.0 {
                best = (here, f);
            }
        }
        best.1
    }

    fn steps(
        &self,
        frequencies: &[f64],
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<Vec<Line>, Error> {
        let lead = self.lead(channels)?;
        let found = match plateaus(channels[lead], self.sampling_frequency)? {
            Ok(found) => found,
            Err(none) => {
                let why = match none {
                    NoSteps::Sweep { periods, .. } => format!(
                        "the frequency never stays in {periods} periods: a sweep gives no steady amplitude"
                    ),
                    NoSteps::NoSine { periods, .. } => {
                        format!("no steady sine in {periods} periods")
                    }
                };
                return Ok(vec![Line::Missing(why); frequencies.len()]);
            }
        };
        frequencies
            .iter()
            .map(|&f| self.step(f, frequencies, &found, late, channels))
            .collect()
    }

    /// The longest step of a frequency, without what it takes to settle.
    fn step(
        &self,
        frequency: f64,
        all: &[f64],
        found: &[Plateau],
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<Line, Error> {
        // The instants of a few periods tell a frequency to a per cent or two.
        let tolerance = self.tolerance.max(0.03);
        let nearest = |p: &&Plateau| {
            let off = |f: f64| (p.frequency / f).ln().abs();
            off(frequency) < tolerance && all.iter().all(|g| off(frequency) <= off(*g))
        };
        let Some(step) = found.iter().filter(nearest).max_by_key(|p| p.to - p.from) else {
            let there: Vec<String> = found
                .iter()
                .map(|p| format!("{:.4}", p.frequency))
                .collect();
            return Ok(Line::Missing(format!(
                "steps were found at {} Hz",
                there.join(", ")
            )));
        };
        let length = (step.to - step.from) as f64;
        let from = step.from + (SETTLING.0 * length).ceil() as usize;
        let to = step
            .to
            .saturating_sub((SETTLING.1 * length).ceil() as usize);
        let left = to.saturating_sub(from);
        let periods = left as f64 * frequency / self.sampling_frequency;
        if left < FEW || periods < PERIODS {
            return Ok(Line::Missing(format!(
                "of its step {left} samples, {periods:.1} periods, are left after settling; {FEW} and {PERIODS} are needed"
            )));
        }
        let views: Vec<&[f64]> = channels.iter().map(|x| &x[from..to]).collect();
        let late = if late.is_empty() {
            late
        } else {
            &late[from..to]
        };
        let mut phasors = self.phasors_at(frequency, late, &views)?;
        phasors.begin += from as f64 / self.sampling_frequency;
        Ok(Line::Found(Box::new(phasors)))
    }
}

fn wanted_of(frequencies: &[f64], wanted: &[usize]) -> Vec<f64> {
    wanted.iter().map(|i| frequencies[*i]).collect()
}

/// Largest change of an amplitude in its standard uncertainty.
fn changed(before: Option<&SineFit>, after: &SineFit) -> f64 {
    let Some(before) = before else {
        return f64::INFINITY;
    };
    let pairs = after.channels.iter().zip(&before.channels);
    pairs
        .map(|(a, b)| {
            let u = (0.5 * (a.covariance[0] + a.covariance[2])).sqrt();
            (a.amplitude - b.amplitude).norm() / u.max(1e-13 * a.modulus()).max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max)
}

/// The channels without some tones.
fn without(
    sampling_frequency: f64,
    late: &[f64],
    channels: &[&[f64]],
    tones: &[&SineFit],
) -> Vec<Vec<f64>> {
    channels
        .iter()
        .enumerate()
        .map(|(k, x)| {
            let mut left = x.to_vec();
            for tone in tones {
                let omega = TAU * tone.frequency;
                let amplitude = tone.channels[k].amplitude;
                let step = Complex64::from_polar(1.0, omega / sampling_frequency);
                let mut z = amplitude;
                for (i, v) in left.iter_mut().enumerate() {
                    if i % 64 == 0 {
                        let t = i as f64 / sampling_frequency;
                        z = amplitude * Complex64::from_polar(1.0, omega * t);
                    }
                    let wave = match late.get(i) {
                        Some(late) if *late != 0.0 => z * Complex64::from_polar(1.0, omega * late),
                        _ => z,
                    };
                    *v -= wave.re;
                    z *= step;
                }
            }
            left
        })
        .collect()
}
