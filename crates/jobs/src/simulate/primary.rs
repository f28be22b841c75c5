//! A primary calibration by laser interferometry, with its truth.

use super::Desk;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_io::{Cell, Table, f32_bytes};
use proofmass_rig::{PrimaryBench, QuadratureInterferometer, device_response};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Mutex;

/// An accelerometer before a laser interferometer with quadrature outputs: campaign.toml, runs.csv, one recording of cosine, sine and
/// output per run, truth.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedPrimary {
    /// The same seed makes the same campaign on every machine
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().seed))]
    pub seed: u64,
    /// Drive frequencies, Hz
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "LIST",
            value_delimiter = ',',
            default_value = "10,20,40,80,160,315,630,1000,2000,5000,10000"
        )
    )]
    pub frequencies: Vec<f64>,
    /// Runs at every frequency
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().repeats))]
    pub repeats: u32,
    /// Sampling rate, Hz
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().rate, value_parser = crate::arguments::positive))]
    pub rate: f64,
    /// Shortest duration of a recording, s; it has twenty periods at least
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().duration, value_parser = crate::arguments::positive))]
    pub duration: f64,
    /// Velocity amplitude of the table, m/s; above 800 Hz the amplitude is the next one at a zero of J₁
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().velocity, value_parser = crate::arguments::positive))]
    pub velocity: f64,
    /// Noise of the quadrature signals, relative to their amplitude
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().noise))]
    pub noise: f64,
    /// Noise of the output, V rms
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().output_noise))]
    pub output_noise: f64,
    /// Hum in the output at 50 Hz, V
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().hum))]
    pub hum: f64,
    /// Vibration of the interferometer at 23 Hz, m
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().vibration))]
    pub vibration: f64,
    /// Drift of the interferometer, m/s
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().drift))]
    pub drift: f64,
    /// Relative standard uncertainty of the wavelength, from which its error is drawn
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().u_wavelength))]
    pub u_wavelength: f64,
    /// Relative standard uncertainty of the voltage calibration, from which its error is drawn
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedPrimary::default().u_voltage))]
    pub u_voltage: f64,
}

impl Default for SimulatedPrimary {
    fn default() -> Self {
        let bench = PrimaryBench::default();
        Self {
            seed: 1,
            frequencies: vec![
                10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0, 1000.0, 2000.0, 5000.0, 10_000.0,
            ],
            repeats: 3,
            rate: bench.rate,
            duration: 0.25,
            velocity: 0.012,
            noise: 5e-3,
            output_noise: bench.output_noise,
            hum: bench.hum[0],
            vibration: bench.interferometer.vibration[0],
            drift: bench.interferometer.drift,
            u_wavelength: 1.5e-6,
            u_voltage: 1e-4,
        }
    }
}

/// Nominal wavelength, m.
const WAVELENGTH: f64 = 632.8e-9;
/// Sensitivity (V/(m/s²)), natural frequency (Hz), damping ratio and lower corner (Hz) of the device.
const DEVICE: [f64; 4] = [0.01, 36e3, 0.02, 0.2];

#[derive(Serialize)]
struct Point {
    #[serde(rename = "frequency_Hz")]
    frequency: f64,
    modulus: f64,
    phase_deg: f64,
    #[serde(rename = "displacement_m")]
    displacement: f64,
    #[serde(rename = "acceleration_m/s2")]
    acceleration: f64,
}

#[derive(Serialize)]
struct TruthFile {
    scenario: &'static str,
    seed: u64,
    #[serde(rename = "wavelength_m")]
    wavelength: f64,
    voltage_error_relative: f64,
    #[serde(rename = "offset_V")]
    offset: [f64; 2],
    #[serde(rename = "amplitude_V")]
    amplitude: [f64; 2],
    quadrature_error_deg: f64,
    #[serde(rename = "S_V/(m/s2)")]
    sensitivity: Vec<Point>,
}

/// The sensitivity of the simulated device.
fn sensitivity(frequency: f64) -> Complex64 {
    let [s, natural, damping, corner] = DEVICE;
    s * device_response(frequency, natural, damping, corner)
}

impl SimulatedPrimary {
    fn check(&self) -> Result<()> {
        let refuse = |what: String, hint: &str| Err(Trouble::request(what).with_hint(hint));
        if self.frequencies.is_empty() || !(1..=1000).contains(&self.repeats) {
            return refuse(
                format!(
                    "{} frequencies, {} repeats: nothing to simulate",
                    self.frequencies.len(),
                    self.repeats
                ),
                "one frequency at least, and 1 to 1000 repeats",
            );
        }
        for (k, f) in self.frequencies.iter().enumerate() {
            if !(1.0..0.25 * self.rate).contains(f) {
                return refuse(
                    format!("{f} Hz cannot be simulated at {} Hz", self.rate),
                    "from 1 Hz to a quarter of the sampling rate",
                );
            }
            if self.frequencies[..k].contains(f) {
                return refuse(format!("{f} Hz stands twice"), "every frequency once");
            }
        }
        for (name, value) in [
            ("noise", self.noise),
            ("output noise", self.output_noise),
            ("hum", self.hum),
            ("vibration", self.vibration),
            ("drift", self.drift),
            ("uncertainty of the wavelength", self.u_wavelength),
            ("uncertainty of the voltage", self.u_voltage),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(
                    format!("{name} = {value} is out of range: it must not be negative"),
                    "give a number from zero up",
                );
            }
        }
        Ok(())
    }

    /// Displacement amplitude, m.
    fn displacement(&self, frequency: f64) -> f64 {
        let amplitude = self.velocity / (TAU * frequency);
        if frequency <= 800.0 {
            return amplitude;
        }
        // The zero of J₁ at or below, the first one at least.
        let turn = 4.0 * PI * amplitude / WAVELENGTH;
        let beta = ((turn / PI - 0.25).floor().max(1.0) + 0.25) * PI;
        (beta - 3.0 / (8.0 * beta)) * WAVELENGTH / (4.0 * PI)
    }

    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        self.check()?;
        let standard = PrimaryBench::default();
        let bench = PrimaryBench {
            interferometer: QuadratureInterferometer {
                wavelength: WAVELENGTH,
                noise: self.noise,
                vibration: [self.vibration, standard.interferometer.vibration[1]],
                drift: self.drift,
                ..standard.interferometer
            },
            rate: self.rate,
            output_noise: self.output_noise,
            hum: [self.hum, standard.hum[1]],
            ..standard
        };
        let bench = bench.drawn(self.u_wavelength, self.u_voltage, self.seed);
        let laser = &bench.interferometer;
        let mut table = Table::new(["run", "frequency_Hz", "file"]);
        let mut runs = Vec::new();
        for &frequency in &self.frequencies {
            for repeat in 1..=self.repeats {
                let name = format!("{frequency}-Hz-{repeat}");
                let file = format!("{name}.f32");
                table.push([
                    Cell::from(name.as_str()),
                    Cell::from(frequency),
                    Cell::from(file.as_str()),
                ])?;
                runs.push((frequency, file));
            }
        }
        let done = Mutex::new(0);
        runs.par_iter()
            .enumerate()
            .map(|(k, (frequency, file))| {
                let seed = self.seed.wrapping_mul(1_000_003).wrapping_add(k as u64 + 1);
                let duration = self.duration.max(20.0 / frequency);
                let amplitude = self.displacement(*frequency);
                let channels = bench.record(*frequency, amplitude, duration, sensitivity, seed);
                let views: [&[f64]; 3] = std::array::from_fn(|k| channels[k].as_slice());
                desk.write(file, f32_bytes(&views)?)?;
                desk.one_more("runs", &done, runs.len())?;
                Ok(())
            })
            .collect::<Result<()>>()?;
        desk.write("runs.csv", table.to_csv()?)?;
        desk.write("campaign.toml", self.campaign().into_bytes())?;
        let point = |&frequency: &f64| {
            let s = sensitivity(frequency);
            let displacement = self.displacement(frequency);
            Point {
                frequency,
                modulus: s.norm(),
                phase_deg: s.arg().to_degrees(),
                displacement,
                acceleration: displacement * (TAU * frequency).powi(2),
            }
        };
        desk.truth(&TruthFile {
            scenario: "primary",
            seed: self.seed,
            wavelength: laser.wavelength,
            voltage_error_relative: bench.voltage,
            offset: laser.offset,
            amplitude: laser.amplitude,
            quadrature_error_deg: laser.phase.to_degrees(),
            sensitivity: self.frequencies.iter().map(point).collect(),
        })
    }

    fn campaign(&self) -> String {
        format!(
            r#"# A primary calibration of a simulated bench (seed {seed}); its truth is in truth.json.
kind = "shaker-primary"
title = "Single-axis accelerometer, simulated primary calibration"

[device]
manufacturer = "proofmass"
model = "simulated accelerometer"
serial = "{seed}"

[runs]
file = "runs.csv"                  # run, frequency_Hz, file; target_m/s2 and transverse_% where they are known

[recording]
format = "f32"                     # or "wav", "text"
sampling_rate_Hz = {rate}
full_scale_V = 10
channels = {{ cosine = 1, sine = 2, output = 3 }}
# delays = {{ output = {{ delay_s = 0, u_s = 1e-8 }} }}

[interferometer]
wavelength_nm = 632.8              # in the air of the path
u_wavelength_relative = {wavelength:e}
motion = "along"                   # the phase grows while the surface moves along the axis of the device; or "against"

[[budget]]                         # what the samples do not show, alike in all runs
name = "voltage"
description = "calibration of the voltage measurement"
u_relative = {voltage:e}

# [[budget]]
# name = "disturbing-motion"
# description = "rocking and bending of the table"
# u_relative = 5e-4
# u_phase_deg = 0.02

[datasheet]
sensitivity = 10
tolerance = 1
unit = "mV/(m/s²)"
"#,
            seed = self.seed,
            rate = self.rate,
            wavelength = self.u_wavelength,
            voltage = self.u_voltage,
        )
    }
}
