//! Whether a run is fit to be used.

use super::Quality;
use crate::single_axis::transverse_limit;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

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
    let limit = transverse_limit(f);
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
