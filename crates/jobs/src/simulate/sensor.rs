//! A digital sensor that records by itself beside the recording of the bench.

use super::Desk;
use crate::trouble::{Result, Trouble};
use proofmass_rig::bench::laboratory::PreparedRun;
use proofmass_rig::bench::sensor::DigitalSensor;
use proofmass_shaker::sample_clock::SampleClock;
use serde::Serialize;
use std::fmt::Write as _;

/// The device of the simulated bench with files of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sensor {
    clock: SampleClock,
    device: DigitalSensor,
}

/// What is true of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct SensorTruth {
    clock: SampleClock,
    /// Samples it takes in a second over those it says, less one, ppm.
    #[serde(rename = "clock_error_ppm")]
    error: f64,
    /// Delay of its samples.
    delay_s: f64,
    /// Counts per volt of S in this file.
    #[serde(rename = "counts_per_V")]
    counts_per_volt: f64,
}

impl Sensor {
    pub fn new(clock: SampleClock, duration: f64) -> Self {
        let device = DigitalSensor {
            own_clock: clock == SampleClock::Own,
            duration,
            ..DigitalSensor::default()
        };
        Self { clock, device }
    }

    pub fn counts_per_volt(&self) -> f64 {
        1.0 / self.device.lsb()
    }

    pub fn truth(&self) -> SensorTruth {
        SensorTruth {
            clock: self.clock,
            error: match self.clock {
                SampleClock::Own => 1e6 * self.device.clock_error,
                SampleClock::Shared => 0.0,
            },
            delay_s: self.device.delay,
            counts_per_volt: self.counts_per_volt(),
        }
    }

    /// Frequencies that it can sample.
    pub fn check(&self, frequencies: &[f64]) -> Result<()> {
        let most = 0.45 * self.device.rate;
        match frequencies.iter().find(|f| **f >= most) {
            Some(f) => Err(Trouble::request(format!(
                "the sensor samples at {} Hz, and {f} Hz is beyond it",
                self.device.rate
            ))
            .with_hint(format!("frequencies below {most} Hz"))),
            None => Ok(()),
        }
    }

    /// Writes the file of a run.
    pub fn record(
        &self,
        desk: &Desk<'_>,
        (run, seed): (usize, u64),
        name: &str,
        prepared: &PreparedRun,
    ) -> Result<()> {
        let record = self.device.record(run, seed, prepared);
        let [x, y, z] = &record.counts;
        let mut text = match self.clock {
            SampleClock::Own => "x,y,z\n".to_owned(),
            SampleClock::Shared => "time_s,x,y,z\n".to_owned(),
        };
        for i in 0..x.len() {
            if let Some(stamp) = record.stamps.get(i) {
                let _ = write!(text, "{stamp:.7},");
            }
            let _ = writeln!(text, "{},{},{}", x[i], y[i], z[i]);
        }
        desk.write(name, text.into_bytes())
    }

    /// `[output_recording]`.
    pub fn table(&self) -> String {
        let (clock, time) = match self.clock {
            SampleClock::Own => ("own", format!("sampling_rate_Hz = {}", self.device.rate)),
            SampleClock::Shared => ("shared", "time = \"time_s\"".to_owned()),
        };
        format!(
            "\n[output_recording]\nclock = \"{clock}\"\nunit = \"count\"\n{time}\nchannels = {{ x = \"x\", y = \"y\", z = \"z\" }}\n"
        )
    }
}
