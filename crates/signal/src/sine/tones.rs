//! Tones beside the drive, such as hum of the mains: found in the data, and fitted with it.

use super::{Frequency, Residuals, SineApproximation, SineFit, State};
use num_complex::Complex64;
use proofmass_core::Error;
use std::f64::consts::TAU;

/// A tone beside the drive that was fitted with it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tone {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Complex peak amplitude in each channel, t = 0 at the first sample.
    pub amplitudes: Vec<Complex64>,
}

/// Bins on each side of the drive in which tones are looked for.
const BINS: isize = 12;
/// Power over the median of the bins from which a bin is a tone: noise reaches it once in 10¹⁷.
const STANDS_OUT: f64 = 60.0;
/// Tones that are fitted at most.
const MOST: usize = 3;
/// Rounds in which drive and tones are fitted in turn, each to what the others leave.
const ROUNDS: usize = 15;
/// Change of the amplitudes, in standard uncertainties, at which they agree.
const AGREED: f64 = 0.02;

impl SineApproximation {
    /// Fits drive and tones in turn until neither changes; nothing is done where no tone stands out.
    pub(super) fn with_tones(
        &self,
        sampling_frequency: f64,
        channels: &[&[f64]],
        first: (SineFit, State),
    ) -> Result<SineFit, Error> {
        let (mut fit, mut state) = first;
        let mut tones: Vec<Tone> = vec![];
        while tones.len() < MOST {
            let Some(start) = beside(&state, sampling_frequency) else {
                break;
            };
            let mut found = tones.clone();
            found.push(Tone {
                frequency: start,
                amplitudes: vec![Complex64::new(0.0, 0.0); channels.len()],
            });
            match self.together(sampling_frequency, channels, &fit, found) {
                Ok((next, of_next, fitted)) => (fit, state, tones) = (next, of_next, fitted),
                // What stood out is no steady tone.
                Err(Error::NotConverged { .. } | Error::OutOfRange { .. }) => break,
                Err(other) => return Err(other),
            }
        }
        fit.tones = tones;
        Ok(fit)
    }

    fn together(
        &self,
        sampling_frequency: f64,
        channels: &[&[f64]],
        first: &SineFit,
        mut tones: Vec<Tone>,
    ) -> Result<(SineFit, State, Vec<Tone>), Error> {
        let mut fit = first.clone();
        let mut answer = None;
        for _ in 0..ROUNDS {
            for k in 0..tones.len() {
                let left = without(sampling_frequency, channels, Some(&fit), &tones, Some(k));
                let left: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
                let own = SineApproximation::new(tones[k].frequency)
                    .frequency(Frequency::Common)
                    .residuals(Residuals::White)
                    .plain(sampling_frequency, &left)?
                    .0;
                tones[k] = Tone {
                    frequency: own.frequency,
                    amplitudes: own.channels.iter().map(|c| c.amplitude).collect(),
                };
            }
            let left = without(sampling_frequency, channels, None, &tones, None);
            let left: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
            let again = match self.frequency {
                Frequency::Common => self.clone().start(fit.frequency),
                Frequency::Known => self.clone(),
            };
            let (next, state) = again.plain(sampling_frequency, &left)?;
            let change = next.channels.iter().zip(&fit.channels).map(|(a, b)| {
                let u = (a.covariance[0] + a.covariance[2]).sqrt();
                (a.amplitude - b.amplitude).norm() / u.max(f64::MIN_POSITIVE)
            });
            let change = change.fold(0.0, f64::max);
            fit = next;
            answer = Some(state);
            if change < AGREED {
                break;
            }
        }
        match answer {
            Some(state) => Ok((fit, state, tones)),
            None => Err(Error::NotConverged {
                name: "drive and tones of the sine approximation",
                iterations: ROUNDS,
                step: f64::INFINITY,
            }),
        }
    }
}

/// Frequency in Hz of the bin beside the drive that stands out most, in whichever channel.
fn beside(state: &State, sampling_frequency: f64) -> Option<f64> {
    let tables = &state.tables;
    let periods = tables.omega * tables.samples as f64 / TAU;
    let mut most: Option<(f64, isize)> = None;
    let mut width = 0.0;
    for (channel, residue) in state.residues.iter().enumerate() {
        let blocks = residue.series.len();
        let reach = BINS.min((blocks / 2) as isize - 1);
        width = sampling_frequency / (blocks * tables.block) as f64;
        // Offset, mirror and harmonics are fitted, or may be.
        let free = |m: isize| {
            let place = m as f64 + periods;
            let beside = (place - periods * (place / periods).round()).abs();
            m.abs() >= 2 && place > 1.5 && beside > 1.5
        };
        let powers: Vec<(f64, isize)> = (-reach..=reach)
            .filter(|&m| free(m))
            .map(|m| (tables.bin(&residue.series, m).norm_sqr(), m))
            .collect();
        if powers.len() < 8 {
            continue;
        }
        let mut sorted: Vec<f64> = powers.iter().map(|p| p.0).collect();
        sorted.sort_by(f64::total_cmp);
        // Rounding of a record without noise is no tone.
        let size = state.fitted[channel].amplitudes[0].norm() + state.fitted[channel].offset.abs();
        let floor = (1e-10 * size * tables.samples as f64).powi(2);
        let median = sorted[sorted.len() / 2].max(floor);
        for (power, m) in powers {
            let stands = power / median.max(f64::MIN_POSITIVE);
            if stands > STANDS_OUT && most.is_none_or(|(largest, _)| stands > largest) {
                most = Some((stands, m));
            }
        }
    }
    let (_, m) = most?;
    Some(tables.omega * sampling_frequency / TAU + m as f64 * width)
}

/// The channels without the drive, where it is given, and without the tones but one.
fn without(
    sampling_frequency: f64,
    channels: &[&[f64]],
    drive: Option<&SineFit>,
    tones: &[Tone],
    but: Option<usize>,
) -> Vec<Vec<f64>> {
    let mut left: Vec<Vec<f64>> = channels.iter().map(|c| c.to_vec()).collect();
    for (j, x) in left.iter_mut().enumerate() {
        if let Some(fit) = drive {
            let c = &fit.channels[j];
            let middle = 0.5 * (x.len() - 1) as f64;
            for (i, v) in x.iter_mut().enumerate() {
                *v -= c.offset + c.drift * (i as f64 - middle) / sampling_frequency;
            }
            let harmonics = std::iter::once(&c.amplitude).chain(&c.harmonics);
            for (h, amplitude) in harmonics.enumerate() {
                subtract(
                    x,
                    *amplitude,
                    TAU * (h + 1) as f64 * fit.frequency / sampling_frequency,
                );
            }
        }
        for (k, tone) in tones.iter().enumerate() {
            if Some(k) != but {
                subtract(
                    x,
                    tone.amplitudes[j],
                    TAU * tone.frequency / sampling_frequency,
                );
            }
        }
    }
    left
}

/// x − Re(X e^{jωn}), with an exact phase every so many samples.
fn subtract(x: &mut [f64], amplitude: Complex64, omega: f64) {
    const EXACT: usize = 64;
    let step = Complex64::from_polar(1.0, omega);
    for (block, x) in x.chunks_mut(EXACT).enumerate() {
        let mut e = amplitude * Complex64::from_polar(1.0, omega * (block * EXACT) as f64);
        for v in x {
            *v -= e.re;
            e *= step;
        }
    }
}
