//! The files of a digital sensor beside the recordings of the bench.

use super::Lines;
use crate::campaign::{CampaignFile, OutputRecording};
use crate::trouble::{Result, Trouble};
use proofmass_io::WaveformOptions;
use proofmass_shaker::recording::Phasors;
use proofmass_shaker::sample_clock::SampleClock;

/// The files of a sensor that records by itself.
pub(crate) struct SensorFiles<'a> {
    pub(crate) settings: &'a OutputRecording,
    pub(crate) options: WaveformOptions,
    /// All channels of a run, in their order; those of the sensor are in `options`.
    pub(crate) names: Vec<&'a str>,
}

impl<'a> SensorFiles<'a> {
    /// Of a campaign with a table `[output_recording]`.
    ///
    /// # Errors
    /// As [`OutputRecording::options`].
    pub(crate) fn of(
        source: &CampaignFile,
        settings: Option<&'a OutputRecording>,
        names: &[&'a str],
    ) -> Result<Option<Self>> {
        let Some(settings) = settings else {
            return Ok(None);
        };
        Ok(Some(Self {
            settings,
            options: settings.options(source, names)?,
            names: names.to_vec(),
        }))
    }
}

/// One set of phasors from the recording of the bench and the file of the sensor, channels in the order of all names, and
/// the error of the sensor's clock.
pub(super) fn together(
    sensor: &SensorFiles<'_>,
    (bench, mut reference): (&Lines, Phasors),
    (own, mut seen): (&Lines, Phasors),
) -> Result<(Phasors, (f64, f64))> {
    let relative = |p: &Phasors| p.frequency_uncertainty.unwrap_or(0.0) / p.measured_frequency;
    let error = reference.measured_frequency / seen.measured_frequency - 1.0;
    let parts = [
        relative(&reference),
        relative(&seen),
        bench.rate_uncertainty,
        own.rate_uncertainty,
    ];
    let u = parts.iter().map(|u| u * u).sum::<f64>().sqrt();
    if sensor.settings.clock == SampleClock::Shared {
        // One instant for both, in the middle of what the sensor saw: there the frequencies turn nothing.
        let middle = own.begin + seen.begin + 0.5 * seen.duration;
        let far = middle - (bench.begin + reference.begin + 0.5 * reference.duration);
        if far.abs() > 0.5 * (reference.duration + seen.duration) {
            return Err(Trouble::data(format!(
                "{}: by its times the sensor was recorded {:.3} s {} the bench",
                own.input.path,
                far.abs(),
                if far > 0.0 { "after" } else { "before" }
            ))
            .with_hint("clock = \"shared\" counts the times of both files from one zero; with other zeros write clock = \"own\""));
        }
        reference = reference.about(middle - bench.begin);
        seen = seen.about(middle - own.begin);
    }
    let order: Vec<usize> = sensor
        .names
        .iter()
        .map(|name| {
            let place = sensor.options.channels.iter().position(|c| c.0 == *name);
            let bench = sensor.names.iter().take_while(|n| n != &name);
            let before = bench.filter(|n| !sensor.options.channels.iter().any(|c| c.0 == **n));
            place.map_or(before.count(), |k| reference.amplitudes.len() + k)
        })
        .collect();
    Ok((reference.beside(seen, &order), (error, u)))
}

/// Relative departure of a frequency that the oscillator of a sensor may make, by whose clock it is.
pub(super) fn tolerance(clock: SampleClock) -> f64 {
    match clock {
        SampleClock::Own => 0.1,
        SampleClock::Shared => 0.01,
    }
}

/// Whether the file of a sensor holds another frequency than the drive, by more than its clock may be off.
pub(super) fn elsewhere(sensor: &SensorFiles<'_>, frequency: f64, seen: &Phasors) -> bool {
    let off = (seen.measured_frequency - frequency).abs();
    off > (tolerance(sensor.settings.clock) * frequency).max(2.0 * seen.resolution)
}
