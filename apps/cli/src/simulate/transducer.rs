//! `proofmass simulate transducer`: a transducer of any principle under a shock, noise, a sweep or a step.

use crate::{Failure, Outcome, console};
use proofmass::io::{OutputFolder, Table};
use proofmass::rig::{Transducer as Device, TransducerBench, TransducerMotion};
use proofmass::signal::PulseShape;
use serde::Serialize;
use std::path::PathBuf;

/// A transducer on a bench: recording.csv (time, reference, output), truth.csv, truth.json.
///
/// The same seed makes the same recording. docs/dynamic-tests.md says which principle suits which job.
#[derive(clap::Args)]
pub(super) struct Transducer {
    /// Folder for the recording
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Principle
    #[arg(long, value_enum, default_value = "piezoelectric")]
    principle: Principle,
    /// What happens to it
    #[arg(long, value_enum, default_value = "shock")]
    motion: Motion,
    /// Greatest acceleration of the motion (RMS of noise), m/s² [default: a fifth of what the device measures]
    #[arg(long, value_name = "M_PER_S2", value_parser = crate::test::positive)]
    level: Option<f64>,
    /// Duration of the pulse, s [default: twenty periods of the mass]
    #[arg(long, value_name = "SECONDS", value_parser = crate::test::positive)]
    pulse: Option<f64>,
    /// Natural frequency of the mass, Hz [default: that of the example]
    #[arg(long, value_name = "HZ", value_parser = crate::test::positive)]
    natural_frequency: Option<f64>,
    /// Damping ratio of the mass [default: that of the example]
    #[arg(long, value_name = "RATIO", value_parser = crate::test::positive)]
    damping: Option<f64>,
    /// Sampling rate, Hz [default: fifty times the natural frequency]
    #[arg(long, value_parser = crate::test::positive)]
    rate: Option<f64>,
    /// Duration, s [default: 65 536 samples]
    #[arg(long, value_parser = crate::test::positive)]
    duration: Option<f64>,
    /// Departure from the reference temperature, K
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    temperature: f64,
    /// Noise of one sample as a share of full scale
    #[arg(long, default_value_t = 1e-5)]
    noise: f64,
    /// Noise of one sample of the reference, m/s²
    #[arg(long, default_value_t = 0.0)]
    reference_noise: f64,
    /// Bits of the converter, 0 for none
    #[arg(long, default_value_t = 24)]
    bits: u32,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Principle {
    Capacitive,
    Piezoresistive,
    StrainGauge,
    Piezoelectric,
    Inductive,
    Hall,
    Thermal,
    Resonant,
    Tunnelling,
    Shutter,
    Interferometer,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Motion {
    /// Half-sine pulse
    Shock,
    /// White noise
    Random,
    /// Logarithmic sweep, from a thousandth of the natural frequency to twice it
    Sweep,
    /// From rest to a constant acceleration
    Step,
}

#[derive(Serialize)]
struct Truth<'a> {
    scenario: &'static str,
    seed: u64,
    bench: &'a TransducerBench,
    unit: &'static str,
    natural_frequency_hz: f64,
    damping_ratio: f64,
    /// Change of the output per m/s² at rest.
    sensitivity: Option<f64>,
    high_pass_hz: Option<f64>,
    low_pass_hz: Option<f64>,
    samples_beyond_range: usize,
}

impl Transducer {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut examples = Device::examples();
        let mut device = examples.swap_remove(self.principle as usize);
        if self.natural_frequency.is_some() || self.damping.is_some() {
            let old = device.mass;
            device.mass = proofmass::rig::ProofMass::of(
                old.mass,
                self.natural_frequency.unwrap_or(old.natural_frequency()),
                self.damping.unwrap_or(old.damping_ratio()),
                old.stop,
            );
        }
        let natural = device.mass.natural_frequency();
        let limits = device.limits();
        let level = self.level.unwrap_or(0.2 * limits.acceleration);
        let rate = self.rate.unwrap_or(50.0 * natural);
        let motion = match self.motion {
            Motion::Shock => TransducerMotion::Shock {
                shape: PulseShape::HalfSine,
                peak: level,
                duration: self.pulse.unwrap_or(20.0 / natural),
            },
            Motion::Random => TransducerMotion::Random { rms: level },
            Motion::Sweep => TransducerMotion::Sweep {
                low: 1e-3 * natural,
                high: (2.0 * natural).min(0.4 * rate),
                amplitude: level,
            },
            Motion::Step => TransducerMotion::Step { height: level },
        };
        let bench = TransducerBench {
            motion,
            rate,
            duration: self.duration.unwrap_or(65_536.0 / rate),
            temperature: self.temperature,
            noise: self.noise,
            reference_noise: self.reference_noise,
            bits: self.bits,
            transducer: device,
        };
        let folder = OutputFolder::create(&self.output, false)?;
        let recording = bench.simulate(self.seed).map_err(|e| {
            Failure::from(e)
                .hint("see `proofmass simulate transducer --help` for what each setting means")
        })?;
        let device = &bench.transducer;
        let slope = |a: f64| Some((device.output(a)? - device.output(-a)?) / (2.0 * a));
        let truth = Truth {
            scenario: "transducer",
            seed: self.seed,
            unit: device.unit(),
            natural_frequency_hz: natural,
            damping_ratio: device.mass.damping_ratio(),
            sensitivity: slope(1e-3 * limits.acceleration),
            high_pass_hz: device.principle.high_pass(),
            low_pass_hz: device.principle.low_pass(),
            samples_beyond_range: recording.beyond,
            bench: &bench,
        };
        let mut table = Table::new([
            "time_s".to_owned(),
            "reference_m/s2".to_owned(),
            format!("output_{}", device.unit()),
        ]);
        let mut exact = Table::new(["time_s", "acceleration_m/s2"]);
        for (k, t) in recording.time.iter().enumerate() {
            table.push([*t, recording.reference[k], recording.output[k]])?;
            exact.push([*t, recording.truth[k]])?;
        }
        let truth = serde_json::to_vec_pretty(&truth)
            .map_err(|e| Failure::new(format!("the truth cannot be written: {e}")))?;
        folder.write("recording.csv", table.to_csv()?)?;
        folder.write("truth.csv", exact.to_csv()?)?;
        folder.write("truth.json", truth)?;
        let place = folder.commit()?;
        if recording.beyond > 0 {
            console::note(format!(
                "note: {} samples lie beyond what the device measures ({:.4} m/s²)",
                recording.beyond, limits.acceleration
            ));
        }
        let next = match self.motion {
            Motion::Shock => "shock --reference reference --output-column output",
            Motion::Random => "random --input reference --output-column output --model 1mode",
            Motion::Sweep => "sweep --input reference --output-column output --model 1mode",
            Motion::Step => "step --column output",
        };
        let (command, options) = next.split_once(' ').unwrap_or((next, ""));
        console::note(format!(
            "written: {0}; next: proofmass test {command} {0}/recording.csv {options}",
            place.display()
        ));
        Ok(Outcome::Done)
    }
}
