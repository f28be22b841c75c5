//! A driven axis with an encoder and an accelerometer.

use super::Desk;
use crate::trouble::{Result, Trouble};
use proofmass_io::{Cell, Table};
use proofmass_rig::{AxisAccelerometer, AxisEncoder, AxisMotion, AxisRecording, DrivenAxis as Rig};
use serde::{Deserialize, Serialize};

/// A driven axis with encoder and accelerometer: recording.csv, truth.csv, truth.json.
///
/// The defaults are those of the reference experiment: 500 lines decoded fourfold at 0.3 m, 16 bits fitted to the
/// signal, 1 kHz. The same seed makes the same recording on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedAxis {
    /// What the axis does
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value = "oscillation"))]
    pub motion: SimulatedMotion,
    /// Frequency of the oscillation or of the motor's reference, Hz [default: 4 or 5]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    pub frequency: Option<f64>,
    /// Duration, s
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().duration))]
    pub duration: f64,
    /// Sampling rate, Hz
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().rate))]
    pub rate: f64,
    /// Lines of the encoder, decoded fourfold
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().lines))]
    pub lines: u32,
    /// Radius at which the accelerometer sits, m
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().radius))]
    pub radius: f64,
    /// A reading of the encoder at every n-th sample
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().every, value_name = "N"))]
    pub every: usize,
    /// Probability that a reading of the encoder is missing
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().missing))]
    pub missing: f64,
    /// Once-per-turn error of an eccentric disc, rad
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().eccentricity))]
    pub eccentricity: f64,
    /// Bits of the counter, which rolls over [default: it never does]
    #[cfg_attr(feature = "clap", arg(long, value_name = "BITS"))]
    pub counter_bits: Option<u32>,
    /// Noise of one sample of the accelerometer, m/s²
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().noise))]
    pub noise: f64,
    /// Offset of the accelerometer as a share of the largest acceleration
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().offset, allow_negative_numbers = true))]
    pub offset: f64,
    /// Relative gain error of the accelerometer
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().gain_error, allow_negative_numbers = true))]
    pub gain_error: f64,
    /// Inclination of the sensitive axis out of the horizontal, °
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().orientation, value_name = "DEGREES", allow_negative_numbers = true))]
    pub orientation: f64,
    /// Low corner of a piezoelectric accelerometer, Hz; 0 measures down to rest
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().roll_off, value_name = "HZ"))]
    pub roll_off: f64,
    /// Time by which the accelerometer is late, s
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().latency, value_name = "SECONDS", allow_negative_numbers = true))]
    pub latency: f64,
    /// Bits of the converter, 0 for none
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().bits))]
    pub bits: u32,
    /// Seed of the noise
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedAxis::default().seed))]
    pub seed: u64,
}

impl Default for SimulatedAxis {
    fn default() -> Self {
        Self {
            motion: SimulatedMotion::Oscillation,
            frequency: None,
            duration: 5.0,
            rate: 1000.0,
            lines: 500,
            radius: 0.3,
            every: 1,
            missing: 0.0,
            eccentricity: 0.0,
            counter_bits: None,
            noise: 0.02,
            offset: 0.0005,
            gain_error: 0.0,
            orientation: 0.0,
            roll_off: 0.0,
            latency: 0.0,
            bits: 16,
            seed: 1,
        }
    }
}

/// What a simulated axis does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SimulatedMotion {
    /// A rod between springs, let go
    Oscillation,
    /// A motor under a position loop that follows a sine
    Motor,
    /// A moving body that is hit
    Impact,
    /// From rest to a slow constant velocity
    Ramp,
    /// Nothing moves
    Standstill,
}

/// The truth beside a simulated recording.
#[derive(Serialize)]
struct Truth<'a> {
    scenario: &'static str,
    seed: u64,
    axis: &'a Rig,
    increment_m: f64,
    offset_m_per_s2: f64,
    converter_step_m_per_s2: f64,
}

impl SimulatedAxis {
    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        if let Some(bits) = self.counter_bits
            && !(8..=32).contains(&bits)
        {
            return Err(
                Trouble::request(format!("a counter of {bits} bits cannot be simulated"))
                    .with_hint("from 8 to 32"),
            );
        }
        let rig = self.rig()?;
        let recording = rig.simulate(self.seed).map_err(|e| {
            Trouble::from(e)
                .with_hint("see `proofmass simulate axis --help` for what each setting means")
        })?;
        let truth = Truth {
            scenario: "axis",
            seed: self.seed,
            axis: &rig,
            increment_m: recording.increment,
            offset_m_per_s2: recording.offset,
            converter_step_m_per_s2: recording.converter_step,
        };
        desk.write("recording.csv", self.sensors(&recording)?)?;
        desk.write("truth.csv", exact(&recording)?)?;
        desk.truth(&truth)
    }

    fn rig(&self) -> Result<Rig> {
        let mut motion = match self.motion {
            SimulatedMotion::Oscillation => AxisMotion::damped_oscillation(),
            SimulatedMotion::Motor => AxisMotion::servo(5.0),
            SimulatedMotion::Impact => AxisMotion::impact(),
            SimulatedMotion::Ramp => AxisMotion::ramp(),
            SimulatedMotion::Standstill => AxisMotion::Standstill,
        };
        match (&mut motion, self.frequency) {
            (_, None) => {}
            (
                AxisMotion::DampedOscillation { frequency, .. }
                | AxisMotion::Servo { frequency, .. },
                Some(f),
            ) => *frequency = f,
            _ => {
                return Err(Trouble::request("this motion has no frequency")
                    .with_hint("leave out --frequency, or choose --motion oscillation or motor"));
            }
        }
        Ok(Rig {
            motion,
            duration: self.duration,
            rate: self.rate,
            encoder: AxisEncoder {
                lines: self.lines,
                radius: self.radius,
                every: self.every,
                missing: self.missing,
                eccentricity: self.eccentricity,
            },
            accelerometer: AxisAccelerometer {
                noise: self.noise,
                offset: self.offset,
                gain_error: self.gain_error,
                orientation: self.orientation.to_radians(),
                roll_off: self.roll_off,
                latency: self.latency,
                bits: self.bits,
            },
        })
    }

    fn sensors(&self, recording: &AxisRecording) -> Result<Vec<u8>> {
        let mut table = Table::new(["time_s", "encoder_count", "acceleration_m/s2"]);
        for (k, (count, a)) in recording
            .count
            .iter()
            .zip(&recording.acceleration)
            .enumerate()
        {
            let count = count.map(|c| match self.counter_bits {
                Some(bits) => c.rem_euclid(1 << bits),
                None => c,
            });
            table.push([
                Cell::from(k as f64 / self.rate),
                count.map_or(Cell::Missing, |c| Cell::Text(c.to_string())),
                Cell::from(*a),
            ])?;
        }
        Ok(table.to_csv()?)
    }
}

fn exact(recording: &AxisRecording) -> Result<Vec<u8>> {
    let mut table = Table::new(["time_s", "position_m", "velocity_m/s", "acceleration_m/s2"]);
    for (k, p) in recording.truth.iter().enumerate() {
        let time = k as f64 * recording.sample_time;
        table.push([time, p.position, p.velocity, p.acceleration])?;
    }
    Ok(table.to_csv()?)
}
