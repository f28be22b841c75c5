//! From the samples of a run to its phasors, and whether the run is fit to be used.

mod drive;
mod mains;
mod soundness;

pub use drive::{Drive, Line};
pub use soundness::{Assessed, CHANNELS, QualityLimits, assess};

use super::flat_top::lost;
use super::geometry::Configuration;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::saturation::rails;
use proofmass_signal::sine::{
    Frequency, Residuals, SineApproximation, SineFit, dominant_frequency,
};
use serde::{Deserialize, Serialize};

/// What the samples say about a run beside its phasors; every entry is optional for tables of ready phasors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Frequency the reference was found at, Hz.
    pub measured_frequency: Option<f64>,
    /// Total harmonic distortion of the reference.
    pub distortion: Option<f64>,
    /// Signal-to-noise ratio of the channels in dB, the reference first; empty for ready phasors.
    pub signal_to_noise: Vec<f64>,
    /// Channels with samples at full scale: 0 is the reference.
    pub clipped: Vec<usize>,
    /// Transverse motion relative to the excitation.
    pub transverse: Option<f64>,
    /// Standard uncertainty of the measured frequency, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_uncertainty: Option<f64>,
    /// One over the duration of the record, Hz: lines nearer than that cannot be told apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Tones beside the drive, such as hum, that were fitted with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tones: Vec<RecordedTone>,
    /// Lines of the mains far from the drive that were listened for, with amplitude zero where none stands out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mains: Vec<RecordedTone>,
    /// Channels with a flat top below full scale, and the part of the fundamental that each has lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flattened: Vec<(usize, f64)>,
    /// Error of the sensor's own clock by this run, relative, and its standard uncertainty: positive where it takes more
    /// samples than it says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_error: Option<(f64, f64)>,
}

/// A tone beside the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedTone {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Peak amplitude in each channel, in the unit of its samples.
    pub(crate) amplitudes: Vec<f64>,
}

/// One run as it comes from the bench: phasors in volts, or the reference already in m/s².
#[derive(Clone, Debug, PartialEq)]
pub struct RunInput {
    /// Name of the run.
    pub run: String,
    /// Session in which it was measured.
    pub session: Option<String>,
    /// Nominal frequency in Hz.
    pub frequency: f64,
    /// Mounting.
    pub configuration: Configuration,
    /// Reference, V or m/s², peak.
    pub reference: Complex64,
    /// Outputs x, y, z in V, peak.
    pub outputs: [Complex64; 3],
    /// Covariance `[rr, ri, ii]` of reference and outputs.
    pub covariance: [[f64; 3]; 4],
    /// What the samples said.
    pub quality: Quality,
}

/// How a recording becomes phasors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PhasorReading {
    /// Sampling frequency in Hz.
    pub sampling_frequency: f64,
    /// Known or common unknown frequency.
    pub frequency: Frequency,
    /// Highest harmonic fitted.
    pub harmonics: usize,
    /// Whether a linear drift is fitted.
    pub drift: bool,
    /// Full scale of the acquisition in the unit of the samples, where known.
    pub full_scale: Option<f64>,
    /// Relative departure of the strongest line from the nominal frequency up to which it is the drive: that of two
    /// crystals and of a slip of a table, or of a sensor's own oscillator.
    pub tolerance: f64,
    /// Whether the first channel is the reference; else the strongest one tells the frequency, and no channel is
    /// searched for a flat top.
    pub with_reference: bool,
    /// Whether hum of the mains is listened for far from the drive too, which takes a spectrum of each channel.
    pub mains: bool,
}

/// Periods above which the strongest line of a record tells its frequency better than half a bin.
const SETTLED: f64 = 8.0;
/// Samples from which on the noise beside the line can be told from that elsewhere, and those that a term of the fit needs.
const COLOUR: usize = 128;
const SAMPLES_PER_TERM: usize = 4;
/// Tolerance beyond which a frequency is not that of the table but that of another clock.
const OWN_CLOCK: f64 = 0.02;
/// Effect of uneven stamps, in standard uncertainties of a phasor, from which on they count.
const MATTERS: f64 = 0.1;
/// Ratio of the residuals, and gain of the logarithm of their likelihood, by which samples are known to be even although
/// their stamps are not.
const EVEN: (f64, f64) = (1.02, 20.0);

impl PhasorReading {
    /// Common frequency, five harmonics (as many as fit below Nyquist), no drift; the first channel is the reference.
    pub fn new(sampling_frequency: f64) -> Self {
        Self {
            sampling_frequency,
            frequency: Frequency::Common,
            harmonics: 5,
            drift: false,
            full_scale: None,
            tolerance: 0.01,
            with_reference: true,
            mains: true,
        }
    }

    /// Phasors of all channels of one run; the first is the reference.
    ///
    /// Tones that stand out beside the drive are fitted with it. Records of less than 128 samples are too short to tell the
    /// noise beside the line from that elsewhere: it counts as white there, and no more harmonics are fitted than four
    /// samples a term allow. A strongest line of the reference elsewhere than at the
    /// nominal frequency is reported and the fit is made at the nominal frequency all the same, for nothing is repaired
    /// in silence.
    ///
    /// # Errors
    /// As [`SineApproximation::fit`] and [`dominant_frequency`]; [`Error::TooFew`] without a channel.
    pub fn phasors(&self, frequency: f64, channels: &[&[f64]]) -> Result<Phasors, Error> {
        self.phasors_at(frequency, &[], channels)
    }

    /// The same for samples that were stamped `late` seconds after their places in an even grid; none, where they have no
    /// stamps.
    ///
    /// Where that matters the sine is fitted at the stamps, unless the residuals say that the samples were even and only
    /// the stamps are not.
    ///
    /// # Errors
    /// As [`PhasorReading::phasors`] and [`SineApproximation::fit_at`].
    pub fn phasors_at(
        &self,
        frequency: f64,
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<Phasors, Error> {
        let lead = self.lead(channels)?;
        let samples = channels[lead].len();
        let found = dominant_frequency(self.sampling_frequency, channels[lead])?;
        let resolution = self.sampling_frequency / samples as f64;
        let elsewhere =
            (found - frequency).abs() > (2.0 * resolution).max(self.tolerance * frequency);
        let mut approximation = self.approximation(frequency, self.harmonics);
        if samples < COLOUR {
            let terms = samples / SAMPLES_PER_TERM;
            let affordable = terms.saturating_sub(1 + usize::from(self.drift)) / 2;
            approximation = self
                .approximation(frequency, self.harmonics.min(affordable.max(1)))
                .residuals(Residuals::White);
        }
        // Two crystals differ by 100 ppm, which in a long record is many bins. In a short one the strongest bin says
        // less than the generator.
        let periods = frequency * samples as f64 / self.sampling_frequency;
        let own_clock = self.tolerance > OWN_CLOCK && (found - frequency).abs() > resolution;
        if !elsewhere && (periods > SETTLED || own_clock) {
            approximation = approximation.start(found);
        }
        if elsewhere {
            approximation = approximation.frequency(Frequency::Known);
        }
        let approximation = approximation.tones(true);
        let (fit, stamps) = self.fitted(&approximation, late, channels, lead)?;
        let mut phasors = self.told(&fit, channels, resolution);
        phasors.stamps = stamps;
        if self.mains {
            phasors.mains = mains::listen(self.sampling_frequency, channels, fit.frequency);
        }
        if elsewhere {
            phasors.measured_frequency = found;
            phasors.frequency_uncertainty = None;
        }
        Ok(phasors)
    }

    /// The channel that tells the frequency.
    fn lead(&self, channels: &[&[f64]]) -> Result<usize, Error> {
        let power = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
            x.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()
        };
        let strongest = || {
            let powers: Vec<f64> = channels.iter().map(|x| power(x)).collect();
            (0..powers.len()).max_by(|&a, &b| powers[a].total_cmp(&powers[b]))
        };
        let lead = if self.with_reference {
            (!channels.is_empty()).then_some(0)
        } else {
            strongest()
        };
        lead.ok_or(Error::TooFew {
            name: "channels",
            needed: 1,
            got: 0,
        })
    }

    /// A fit near a frequency, of as many harmonics as there are below Nyquist.
    fn approximation(&self, frequency: f64, harmonics: usize) -> SineApproximation {
        let below_nyquist =
            ((0.5 * self.sampling_frequency / frequency).ceil() as usize).saturating_sub(1);
        SineApproximation::new(frequency)
            .frequency(self.frequency)
            .harmonics(harmonics.min(below_nyquist))
            .drift(self.drift)
    }

    /// At the stamps where they matter and are those of the samples, else on the even grid.
    fn fitted(
        &self,
        approximation: &SineApproximation,
        late: &[f64],
        channels: &[&[f64]],
        lead: usize,
    ) -> Result<(SineFit, Option<UnevenStamps>), Error> {
        let even = approximation.fit(self.sampling_frequency, channels)?;
        if late.iter().all(|t| *t == 0.0) {
            return Ok((even, None));
        }
        let at = approximation.fit_at(self.sampling_frequency, late, channels)?;
        let effect = at
            .channels
            .iter()
            .zip(&even.channels)
            .map(|(a, b)| {
                let u = (0.5 * (a.covariance[0] + a.covariance[2])).sqrt();
                (a.amplitude - b.amplitude).norm()
                    / u.max(1e-12 * a.modulus()).max(f64::MIN_POSITIVE)
            })
            .fold(0.0, f64::max);
        let residuals = [
            at.channels[lead].residual_rms,
            even.channels[lead].residual_rms,
        ];
        let n = late.len() as f64;
        // A fit that got smaller residuals by its noise alone would differ from the other by nothing like this.
        let gain = if residuals[0] > residuals[1] * EVEN.0 {
            n * (residuals[0] / residuals[1].max(f64::MIN_POSITIVE)).ln()
        } else {
            0.0
        };
        let worse = residuals[1] > residuals[0] * EVEN.0;
        if effect < MATTERS && !worse {
            return Ok((even, None));
        }
        let used = gain <= EVEN.1;
        let stamps = UnevenStamps {
            scatter: (late.iter().map(|t| t * t).sum::<f64>() / n).sqrt(),
            effect,
            residuals,
            used,
        };
        Ok((if used { at } else { even }, Some(stamps)))
    }

    /// Whether samples of a channel stand at the declared full scale: at the last code on either side, where a sample may be any
    /// larger value.
    pub fn at_full_scale(&self, channel: &[f64]) -> bool {
        let limit = self.full_scale.map(|full| full * (1.0 - 1e-6));
        limit.is_some_and(|limit| channel.iter().filter(|v| v.abs() >= limit).count() > 1)
    }

    /// What a fit of all channels tells.
    fn told(&self, fit: &SineFit, channels: &[&[f64]], resolution: f64) -> Phasors {
        // An amplifier may saturate before the converter does.
        let cut = |channel: &[f64]| self.at_full_scale(channel) || !rails(channel).is_empty();
        let clipped: Vec<usize> = (0..channels.len()).filter(|&k| cut(channels[k])).collect();
        let c = &fit.channels;
        let outputs = if self.with_reference {
            1..c.len()
        } else {
            0..0
        };
        Phasors {
            amplitudes: c.iter().map(|c| c.amplitude).collect(),
            covariances: c.iter().map(|c| c.covariance).collect(),
            measured_frequency: fit.frequency,
            distortion: c[0].thd(),
            // A signal without any noise has the ratio that double precision can hold.
            signal_to_noise: c.iter().map(|c| c.snr_db().min(300.0)).collect(),
            frequency_uncertainty: fit.frequency_uncertainty,
            resolution,
            flattened: outputs
                .filter(|k| !clipped.contains(k))
                .filter_map(|k| Some((k, lost(&c[k], &c[0], channels[k].len())?)))
                .collect(),
            clipped,
            tones: fit
                .tones
                .iter()
                .map(|t| RecordedTone {
                    frequency: t.frequency,
                    amplitudes: t.amplitudes.iter().map(|a| a.norm()).collect(),
                })
                .collect(),
            mains: vec![],
            begin: 0.0,
            duration: 1.0 / resolution,
            stamps: None,
        }
    }

    /// Phasors of reference, x, y, z of one run.
    ///
    /// # Errors
    /// As [`PhasorReading::phasors`].
    pub fn observe(
        &self,
        run: &str,
        frequency: f64,
        configuration: Configuration,
        channels: [&[f64]; 4],
    ) -> Result<RunInput, Error> {
        let p = self.phasors(frequency, &channels)?;
        let a = &p.amplitudes;
        Ok(RunInput {
            run: run.to_owned(),
            session: None,
            frequency,
            configuration,
            reference: a[0],
            outputs: [a[1], a[2], a[3]],
            covariance: std::array::from_fn(|k| p.covariances[k]),
            quality: p.quality(None),
        })
    }
}

/// What the samples of a run give, channel by channel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Phasors {
    /// Complex peak amplitudes.
    pub amplitudes: Vec<Complex64>,
    /// Covariance `[rr, ri, ii]` of each.
    pub covariances: Vec<[f64; 3]>,
    /// Frequency the first channel was found at, Hz.
    pub measured_frequency: f64,
    /// Total harmonic distortion of the first channel.
    pub distortion: Option<f64>,
    /// Signal-to-noise ratios in dB.
    pub signal_to_noise: Vec<f64>,
    /// Channels with samples at full scale.
    pub clipped: Vec<usize>,
    /// Standard uncertainty of the measured frequency, Hz.
    pub frequency_uncertainty: Option<f64>,
    /// One over the duration, Hz.
    pub resolution: f64,
    /// Tones beside the drive that were fitted with it.
    pub tones: Vec<RecordedTone>,
    /// Lines of the mains far from the drive that were listened for; amplitude zero where none stands out.
    pub mains: Vec<RecordedTone>,
    /// Channels with a flat top, and the part of the fundamental that each has lost.
    pub flattened: Vec<(usize, f64)>,
    /// When the stretch began that was fitted, s after the first sample: the origin of the phases.
    pub begin: f64,
    /// How long it is, s.
    pub duration: f64,
    /// Time stamps that are not even, where that matters.
    pub stamps: Option<UnevenStamps>,
}

/// Time stamps that are not even.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnevenStamps {
    /// Root mean square of their departure from the even grid, s.
    pub scatter: f64,
    /// Largest change of a phasor that they make, in its standard uncertainty.
    pub effect: f64,
    /// Residuals, root mean square, of the fit at the stamps and of that on the grid.
    pub residuals: [f64; 2],
    /// Whether the phasors are those at the stamps.
    pub used: bool,
}

impl Phasors {
    /// The same with the origin of the phases at another instant, s after the first sample of the record. What the
    /// frequency is not known by turns the phases by the distance from the middle of the stretch.
    #[must_use]
    pub fn about(mut self, instant: f64) -> Self {
        let omega = std::f64::consts::TAU * self.measured_frequency;
        let turn = Complex64::from_polar(1.0, omega * (instant - self.begin));
        let far = instant - self.begin - 0.5 * self.duration;
        let u = std::f64::consts::TAU * self.frequency_uncertainty.unwrap_or(0.0) * far;
        for (z, v) in self.amplitudes.iter_mut().zip(&mut self.covariances) {
            *z *= turn;
            *v = multiplied(*v, turn);
            // Along j z.
            let along = Complex64::new(0.0, u) * *z;
            v[0] += along.re * along.re;
            v[1] += along.re * along.im;
            v[2] += along.im * along.im;
        }
        self.begin = instant;
        self
    }

    /// Turns the phasor of a channel by an angle in radians.
    pub fn turn(&mut self, channel: usize, angle: f64) {
        let turn = Complex64::from_polar(1.0, angle);
        self.amplitudes[channel] *= turn;
        self.covariances[channel] = multiplied(self.covariances[channel], turn);
    }

    /// With the channels of another recording of the same run: the channels of both are put in `order`, those of the
    /// other counted after the own ones. Frequency, distortion, tones and flat tops are the own ones.
    #[must_use]
    pub fn beside(mut self, other: Self, order: &[usize]) -> Self {
        let own = self.amplitudes.len();
        let clipped: Vec<usize> = self
            .clipped
            .iter()
            .copied()
            .chain(other.clipped.iter().map(|k| own + k))
            .collect();
        let place = |k: usize| order.iter().position(|o| *o == k);
        self.amplitudes.extend(other.amplitudes);
        self.covariances.extend(other.covariances);
        self.signal_to_noise.extend(other.signal_to_noise);
        self.amplitudes = order.iter().map(|k| self.amplitudes[*k]).collect();
        self.covariances = order.iter().map(|k| self.covariances[*k]).collect();
        self.signal_to_noise = order.iter().map(|k| self.signal_to_noise[*k]).collect();
        self.clipped = clipped.into_iter().filter_map(place).collect();
        let flattened = self.flattened.iter();
        self.flattened = flattened
            .filter_map(|(k, part)| Some((place(*k)?, *part)))
            .collect();
        let stamps = [self.stamps, other.stamps].into_iter().flatten();
        self.stamps = stamps.max_by(|a, b| a.effect.total_cmp(&b.effect));
        self
    }

    /// What they say about the run; `transverse` is the transverse motion, where it was measured.
    pub fn quality(&self, transverse: Option<f64>) -> Quality {
        Quality {
            measured_frequency: Some(self.measured_frequency),
            distortion: self.distortion,
            signal_to_noise: self.signal_to_noise.clone(),
            clipped: self.clipped.clone(),
            transverse,
            frequency_uncertainty: self.frequency_uncertainty,
            resolution: Some(self.resolution),
            tones: self.tones.clone(),
            mains: self.mains.clone(),
            flattened: self.flattened.clone(),
            clock_error: None,
        }
    }
}

/// Covariance `[rr, ri, ii]` of a complex number that is multiplied by a factor.
pub fn multiplied([rr, ri, ii]: [f64; 3], factor: Complex64) -> [f64; 3] {
    let (c, s) = (factor.re, factor.im);
    [
        c * c * rr - 2.0 * c * s * ri + s * s * ii,
        c * s * (rr - ii) + (c * c - s * s) * ri,
        s * s * rr + 2.0 * c * s * ri + c * c * ii,
    ]
}
