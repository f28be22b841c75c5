//! Whether a run is fit to be used.

use super::Quality;
use crate::findings;
use crate::single_axis::transverse_limit;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Rules of a sound run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
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
    let mut doubts = vec![];
    let (name, f, q) = (run.run, run.frequency, run.quality);
    let (amplitude, target) = (run.amplitude, run.target);
    if let Some(found) = q.measured_frequency
        && (found / f - 1.0).abs() > limits.frequency
        // In a record of few periods the frequency is not known as well as the limit.
        && (found - f).abs() > 5.0 * q.frequency_uncertainty.unwrap_or(0.0)
    {
        doubts.push(findings::frequency_mismatch(name, f, found));
    }
    if !q.clipped.is_empty() {
        let channels: Vec<&str> = q
            .clipped
            .iter()
            .filter_map(|&k| run.channels.get(k).copied())
            .collect();
        doubts.push(proofmass_uncertainty::findings::clipped(
            &format!("run {name} is clipped"),
            &format!("samples at full scale on channel {}", channels.join(", ")),
            "amplitude and phase of the run are wrong",
        ));
    }
    if let Some((k, part)) = q.flattened.first() {
        let channel = run.channels.get(*k).copied().unwrap_or("output");
        doubts.push(findings::flat_topped(channel, name, 100.0 * part, f));
    }
    if let Some(tone) = q.tones.first() {
        let largest = tone.amplitudes.iter().copied().fold(0.0, f64::max);
        doubts.push(findings::tone_beside_drive(
            name,
            tone.frequency,
            f,
            largest,
            q.tones.len(),
        ));
    }
    if let Some(d) = q.distortion.filter(|&d| d > limits.distortion) {
        doubts.push(findings::distortion(
            name,
            100.0 * d,
            f,
            100.0 * limits.distortion,
        ));
    }
    if let Some(snr) = q
        .signal_to_noise
        .first()
        .filter(|&&snr| snr < limits.signal_to_noise)
    {
        doubts.push(findings::low_signal(name, *snr, f, limits.signal_to_noise));
    }
    if let Some(t) = target.filter(|t| (amplitude / t - 1.0).abs() > limits.amplitude) {
        doubts.push(findings::amplitude_off_target(name, amplitude, t, f));
    }
    let limit = transverse_limit(f);
    if let Some(t) = q.transverse.filter(|&t| t > limit) {
        doubts.push(findings::transverse_motion(
            name,
            100.0 * t,
            f,
            100.0 * limit,
        ));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::super::RecordedTone;
    use super::*;

    fn sound() -> Quality {
        Quality {
            measured_frequency: Some(160.0),
            distortion: Some(0.01),
            signal_to_noise: vec![60.0; 4],
            transverse: Some(0.0),
            ..Quality::default()
        }
    }

    /// Codes of a run of 10 m/s² at 160 Hz.
    fn codes(change: impl FnOnce(&mut Quality), target: Option<f64>) -> Vec<String> {
        let mut quality = sound();
        change(&mut quality);
        let run = Assessed {
            run: "r",
            frequency: 160.0,
            quality: &quality,
            channels: &CHANNELS,
            amplitude: 10.0,
            target,
        };
        let found = assess(&run, &QualityLimits::default());
        found.iter().map(|f| f.code().to_owned()).collect()
    }

    #[test]
    fn known_faults_of_a_run_have_their_names_and_a_sound_run_has_none() {
        assert!(codes(|_| (), Some(10.0)).is_empty());
        assert_eq!(codes(|_| (), Some(20.0)), ["amplitude-off-target"]);
        assert_eq!(codes(|q| q.distortion = Some(0.1), None), ["distortion"]);
        assert_eq!(codes(|q| q.signal_to_noise[0] = 30.0, None), ["low-signal"]);
        assert_eq!(codes(|q| q.clipped.push(2), None), ["clipped"]);
        assert_eq!(
            codes(|q| q.flattened.push((1, 0.02)), None),
            ["flat-topped"]
        );
        assert_eq!(
            codes(|q| q.transverse = Some(0.9), None),
            ["transverse-motion"]
        );
        assert_eq!(
            codes(|q| q.measured_frequency = Some(170.0), None),
            ["frequency-mismatch"]
        );
        let tone = RecordedTone {
            frequency: 50.0,
            amplitudes: vec![1e-4],
        };
        assert_eq!(codes(|q| q.tones.push(tone), None), ["tone-beside-drive"]);
    }
}
