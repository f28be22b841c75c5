//! `proofmass simulate axis`: a driven axis with an encoder and an accelerometer.

use crate::{Failure, Outcome, console};
use proofmass::io::{Cell, OutputFolder, Table};
use proofmass::rig::{Axis as Rig, AxisAccelerometer, AxisEncoder, AxisMotion, AxisRecording};
use serde::Serialize;
use std::path::PathBuf;

/// A driven axis with encoder and accelerometer: recording.csv, truth.csv, truth.json.
///
/// The defaults are those of the reference experiment: 500 lines decoded fourfold at 0.3 m, 16 bits fitted to the
/// signal, 1 kHz. The same seed makes the same recording on every machine.
#[derive(clap::Args)]
pub(super) struct Axis {
    /// Folder for the recording
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// What the axis does
    #[arg(long, value_enum, default_value = "oscillation")]
    motion: Motion,
    /// Frequency of the oscillation or of the motor's reference, Hz [default: 4 or 5]
    #[arg(long, value_name = "HZ")]
    frequency: Option<f64>,
    /// Duration, s
    #[arg(long, default_value_t = 5.0)]
    duration: f64,
    /// Sampling rate, Hz
    #[arg(long, default_value_t = 1000.0)]
    rate: f64,
    /// Lines of the encoder, decoded fourfold
    #[arg(long, default_value_t = 500)]
    lines: u32,
    /// Radius at which the accelerometer sits, m
    #[arg(long, default_value_t = 0.3)]
    radius: f64,
    /// A reading of the encoder at every n-th sample
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: usize,
    /// Probability that a reading of the encoder is missing
    #[arg(long, default_value_t = 0.0)]
    missing: f64,
    /// Once-per-turn error of an eccentric disc, rad
    #[arg(long, default_value_t = 0.0)]
    eccentricity: f64,
    /// Bits of the counter, which rolls over [default: it never does]
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(8..=32))]
    counter_bits: Option<u32>,
    /// Noise of one sample of the accelerometer, m/s²
    #[arg(long, default_value_t = 0.02)]
    noise: f64,
    /// Offset of the accelerometer as a share of the largest acceleration
    #[arg(long, default_value_t = 0.0005, allow_negative_numbers = true)]
    offset: f64,
    /// Relative gain error of the accelerometer
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    gain_error: f64,
    /// Inclination of the sensitive axis out of the horizontal, °
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    orientation: f64,
    /// Low corner of a piezoelectric accelerometer, Hz; 0 measures down to rest
    #[arg(long, value_name = "HZ", default_value_t = 0.0)]
    roll_off: f64,
    /// Time by which the accelerometer is late, s
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    latency: f64,
    /// Bits of the converter, 0 for none
    #[arg(long, default_value_t = 16)]
    bits: u32,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Motion {
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

impl Axis {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let rig = self.rig()?;
        let folder = OutputFolder::create(&self.output, false)?;
        let recording = rig.simulate(self.seed).map_err(|e| {
            Failure::from(e)
                .hint("see `proofmass simulate axis --help` for what each setting means")
        })?;
        let truth = Truth {
            scenario: "axis",
            seed: self.seed,
            axis: &rig,
            increment_m: recording.increment,
            offset_m_per_s2: recording.offset,
            converter_step_m_per_s2: recording.converter_step,
        };
        let truth = serde_json::to_vec_pretty(&truth)
            .map_err(|e| Failure::new(format!("the truth cannot be written: {e}")))?;
        folder.write("recording.csv", self.sensors(&recording)?)?;
        folder.write("truth.csv", exact(&recording)?)?;
        folder.write("truth.json", truth)?;
        let place = folder.commit()?;
        let bits = self
            .counter_bits
            .map_or(String::new(), |b| format!(" --bits {b}"));
        console::note(format!(
            "written: {0}; next: proofmass velocity compare {0}/recording.csv --position encoder \
             --counts-per-turn {1} --radius {2}{bits} --acceleration acceleration --reference velocity \
             --reference-file {0}/truth.csv",
            place.display(),
            4 * u64::from(self.lines),
            self.radius
        ));
        Ok(Outcome::Done)
    }

    fn rig(&self) -> Result<Rig, Failure> {
        let mut motion = match self.motion {
            Motion::Oscillation => AxisMotion::damped_oscillation(),
            Motion::Motor => AxisMotion::servo(5.0),
            Motion::Impact => AxisMotion::impact(),
            Motion::Ramp => AxisMotion::ramp(),
            Motion::Standstill => AxisMotion::Standstill,
        };
        match (&mut motion, self.frequency) {
            (_, None) => {}
            (
                AxisMotion::DampedOscillation { frequency, .. }
                | AxisMotion::Servo { frequency, .. },
                Some(f),
            ) => *frequency = f,
            _ => {
                return Err(Failure::new("this motion has no frequency")
                    .hint("leave out --frequency, or choose --motion oscillation or motor"));
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

    fn sensors(&self, recording: &AxisRecording) -> Result<Vec<u8>, Failure> {
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

fn exact(recording: &AxisRecording) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new(["time_s", "position_m", "velocity_m/s", "acceleration_m/s2"]);
    for (k, p) in recording.truth.iter().enumerate() {
        let time = k as f64 * recording.sample_time;
        table.push([time, p.position, p.velocity, p.acceleration])?;
    }
    Ok(table.to_csv()?)
}
