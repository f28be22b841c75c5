//! From the samples of a run to its phasors, and whether the run is fit to be used.

use super::flat_top::lost;
use super::geometry::Configuration;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::sine::{Frequency, SineApproximation, dominant_frequency};
use proofmass_uncertainty::{Finding, Severity};
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
    /// Channels with a flat top below full scale, and the part of the fundamental that each has lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flattened: Vec<(usize, f64)>,
}

/// A tone beside the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedTone {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Peak amplitude in each channel, in the unit of its samples.
    pub amplitudes: Vec<f64>,
}

/// One run as it comes from the bench: phasors in volts, or the reference already in m/s².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunInput {
    /// Name of the run.
    pub run: String,
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
pub struct PhasorReading {
    /// Sampling frequency in Hz.
    pub sampling_frequency: f64,
    /// Known or common unknown frequency.
    pub frequency: Frequency,
    /// Highest harmonic fitted.
    pub harmonics: usize,
    /// Whether a linear drift is fitted.
    pub drift: bool,
    /// Full scale of the acquisition in V, where known.
    pub full_scale: Option<f64>,
}

/// Periods above which the strongest line of a record tells its frequency better than half a bin.
const SETTLED: f64 = 8.0;

impl PhasorReading {
    /// Common frequency, five harmonics (as many as fit below Nyquist), no drift.
    pub fn new(sampling_frequency: f64) -> Self {
        Self {
            sampling_frequency,
            frequency: Frequency::Common,
            harmonics: 5,
            drift: false,
            full_scale: None,
        }
    }

    /// Phasors of all channels of one run; the first is the reference.
    ///
    /// Tones that stand out beside the drive are fitted with it. A strongest line of the reference elsewhere than at the nominal frequency is reported and the fit is made
    /// at the nominal frequency all the same, for nothing is repaired in silence.
    ///
    /// # Errors
    /// As [`SineApproximation::fit`] and [`dominant_frequency`]; [`Error::TooFew`] without a channel.
    pub fn phasors(&self, frequency: f64, channels: &[&[f64]]) -> Result<Phasors, Error> {
        let Some(reference) = channels.first() else {
            return Err(Error::TooFew {
                name: "channels",
                needed: 1,
                got: 0,
            });
        };
        let found = dominant_frequency(self.sampling_frequency, reference)?;
        let resolution = self.sampling_frequency / reference.len() as f64;
        let elsewhere = (found - frequency).abs() > (2.0 * resolution).max(0.01 * frequency);
        let below_nyquist = (0.5 * self.sampling_frequency / frequency).ceil() as usize - 1;
        let mut approximation = SineApproximation::new(frequency);
        // Two crystals differ by 100 ppm, which in a long record is many bins. In a short one the strongest bin says
        // less than the generator.
        let periods = frequency * reference.len() as f64 / self.sampling_frequency;
        if !elsewhere && periods > SETTLED {
            approximation = approximation.start(found);
        }
        let fit = approximation
            .frequency(if elsewhere {
                Frequency::Known
            } else {
                self.frequency
            })
            .harmonics(self.harmonics.min(below_nyquist))
            .drift(self.drift)
            .tones(true)
            .fit(self.sampling_frequency, channels)?;
        let clipped = self.full_scale.map_or(vec![], |full| {
            // The last code on either side: a sample there may be any larger value.
            let limit = full * (1.0 - 1e-6);
            (0..channels.len())
                .filter(|&k| channels[k].iter().filter(|v| v.abs() >= limit).count() > 1)
                .collect()
        });
        let c = &fit.channels;
        Ok(Phasors {
            amplitudes: c.iter().map(|c| c.amplitude).collect(),
            covariances: c.iter().map(|c| c.covariance).collect(),
            measured_frequency: if elsewhere { found } else { fit.frequency },
            distortion: c[0].thd(),
            // A signal without any noise has the ratio that double precision can hold.
            signal_to_noise: c.iter().map(|c| c.snr_db().min(300.0)).collect(),
            frequency_uncertainty: fit.frequency_uncertainty.filter(|_| !elsewhere),
            resolution,
            flattened: (1..c.len())
                .filter(|k| !clipped.contains(k))
                .filter_map(|k| Some((k, lost(&c[k], &c[0], reference.len())?)))
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
        })
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
    /// Channels with a flat top, and the part of the fundamental that each has lost.
    pub flattened: Vec<(usize, f64)>,
}

impl Phasors {
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
            flattened: self.flattened.clone(),
        }
    }
}

/// Rules of a sound run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QualityLimits {
    /// Largest relative departure of the frequency.
    pub frequency: f64,
    /// Largest distortion of the excitation.
    pub distortion: f64,
    /// Smallest signal-to-noise ratio of the reference in dB.
    pub signal_to_noise: f64,
    /// Largest relative departure of the amplitude from its target.
    pub amplitude: f64,
}

impl Default for QualityLimits {
    /// 0.5 % of frequency, 5 % of distortion (ISO 16063-21), 40 dB, 10 % of amplitude.
    fn default() -> Self {
        Self {
            frequency: 0.005,
            distortion: 0.05,
            signal_to_noise: 40.0,
            amplitude: 0.10,
        }
    }
}

/// Channels of a triaxial run.
pub const CHANNELS: [&str; 4] = ["reference", "x", "y", "z"];

/// One run, for its assessment.
#[derive(Clone, Copy, Debug)]
pub struct Assessed<'a> {
    /// Name of the run.
    pub run: &'a str,
    /// Nominal frequency in Hz.
    pub frequency: f64,
    /// What the samples said.
    pub quality: &'a Quality,
    /// Names of its channels.
    pub channels: &'a [&'a str],
    /// Acceleration reached, m/s².
    pub amplitude: f64,
    /// Acceleration wanted, m/s².
    pub target: Option<f64>,
}

/// Findings about a single run.
pub fn assess(run: &Assessed<'_>, limits: &QualityLimits) -> Vec<Finding> {
    let mut findings = vec![];
    let (name, f, q) = (run.run, run.frequency, run.quality);
    let (amplitude, target) = (run.amplitude, run.target);
    if let Some(found) = q.measured_frequency
        && (found / f - 1.0).abs() > limits.frequency
        // In a record of few periods the frequency is not known as well as the limit.
        && (found - f).abs() > 5.0 * q.frequency_uncertainty.unwrap_or(0.0)
    {
        findings.push(
            Finding::new(
                Severity::Decision,
                "frequency-mismatch",
                format!("run {name} does not vibrate at the frequency of the table"),
            )
            .evidence(format!(
                "{f} Hz in the table, {found:.3} Hz in the recording"
            ))
            .advice("correct the table or leave the run out"),
        );
    }
    if !q.clipped.is_empty() {
        let channels: Vec<&str> = q
            .clipped
            .iter()
            .filter_map(|&k| run.channels.get(k).copied())
            .collect();
        findings.push(
            Finding::new(
                Severity::Decision,
                "clipped",
                format!("run {name} is clipped"),
            )
            .evidence(format!(
                "samples at full scale on channel {}",
                channels.join(", ")
            ))
            .advice("lower the gain and measure it again"),
        );
    }
    if let Some((k, part)) = q.flattened.first() {
        let channel = run.channels.get(*k).copied().unwrap_or("output");
        findings.push(
            Finding::new(
                Severity::Decision,
                "flat-topped",
                format!("channel {channel} of run {name} has a flat top"),
            )
            .evidence(format!(
                "third and fifth harmonic are those of a sine that is cut off; {:.2} % of the fundamental is lost, at {f} Hz",
                100.0 * part
            ))
            .advice("an amplifier gives out before the converter does: lower its gain or the drive, and measure it again"),
        );
    }
    if let Some(tone) = q.tones.first() {
        let largest = tone.amplitudes.iter().copied().fold(0.0, f64::max);
        findings.push(
            Finding::new(
                Severity::Note,
                "tone-beside-drive",
                format!("a tone beside the drive of run {name} was fitted with it"),
            )
            .evidence(format!(
                "{:.3} Hz beside {f} Hz, {largest:.2e} V at most; {} in all",
                tone.frequency,
                q.tones.len()
            ))
            .advice("near 50 or 60 Hz and their multiples it is hum: look for loops of the ground"),
        );
    }
    if let Some(d) = q.distortion.filter(|&d| d > limits.distortion) {
        findings.push(
            Finding::new(
                Severity::Warning,
                "distortion",
                format!("the excitation of run {name} is distorted"),
            )
            .evidence(format!(
                "{:.1} % at {f} Hz, {:.0} % admitted",
                100.0 * d,
                100.0 * limits.distortion
            ))
            .advice("lower the amplitude or look for a loose mounting"),
        );
    }
    if let Some(snr) = q
        .signal_to_noise
        .first()
        .filter(|&&snr| snr < limits.signal_to_noise)
    {
        findings.push(
            Finding::new(
                Severity::Warning,
                "low-signal",
                format!("the reference of run {name} is close to its noise"),
            )
            .evidence(format!(
                "{:.0} dB at {f} Hz, {:.0} dB wanted",
                snr, limits.signal_to_noise
            ))
            .advice("raise the amplitude or the gain, or record for longer"),
        );
    }
    if let Some(t) = target.filter(|t| (amplitude / t - 1.0).abs() > limits.amplitude) {
        findings.push(
            Finding::new(
                Severity::Warning,
                "amplitude-off-target",
                format!("run {name} was not driven at its target amplitude"),
            )
            .evidence(format!(
                "{amplitude:.3} m/s² reached, {t} m/s² wanted at {f} Hz"
            ))
            .advice("check the levelling; a linear device does not mind, its linearity does"),
        );
    }
    let limit = super::single_axis::transverse_limit(f);
    if let Some(t) = q.transverse.filter(|&t| t > limit) {
        findings.push(
            Finding::new(
                Severity::Warning,
                "transverse-motion",
                format!("run {name}: the transverse motion exceeds the limit of ISO 16063-21"),
            )
            .evidence(format!(
                "{:.1} % at {f} Hz, {:.0} % admitted",
                100.0 * t,
                100.0 * limit
            ))
            .advice("correct for the measured spurious motion, or leave the frequency out"),
        );
    }
    findings
}
