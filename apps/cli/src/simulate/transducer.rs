//! `proofmass simulate transducer`: a transducer of any principle under a shock, noise, a sweep or a step.

use crate::{Failure, Outcome, console};
use proofmass::jobs::simulate::{
    SimulateJob, SimulatedExcitation, SimulatedPrinciple, SimulatedTransducer,
};
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

impl Transducer {
    fn job(&self) -> SimulatedTransducer {
        let mut job = SimulatedTransducer::default();
        job.principle = match self.principle {
            Principle::Capacitive => SimulatedPrinciple::Capacitive,
            Principle::Piezoresistive => SimulatedPrinciple::Piezoresistive,
            Principle::StrainGauge => SimulatedPrinciple::StrainGauge,
            Principle::Piezoelectric => SimulatedPrinciple::Piezoelectric,
            Principle::Inductive => SimulatedPrinciple::Inductive,
            Principle::Hall => SimulatedPrinciple::Hall,
            Principle::Thermal => SimulatedPrinciple::Thermal,
            Principle::Resonant => SimulatedPrinciple::Resonant,
            Principle::Tunnelling => SimulatedPrinciple::Tunnelling,
            Principle::Shutter => SimulatedPrinciple::Shutter,
            Principle::Interferometer => SimulatedPrinciple::Interferometer,
        };
        job.motion = match self.motion {
            Motion::Shock => SimulatedExcitation::Shock,
            Motion::Random => SimulatedExcitation::Random,
            Motion::Sweep => SimulatedExcitation::Sweep,
            Motion::Step => SimulatedExcitation::Step,
        };
        job.level = self.level;
        job.pulse = self.pulse;
        job.natural_frequency = self.natural_frequency;
        job.damping = self.damping;
        job.rate = self.rate;
        job.duration = self.duration;
        job.temperature = self.temperature;
        job.noise = self.noise;
        job.reference_noise = self.reference_noise;
        job.bits = self.bits;
        job.seed = self.seed;
        job
    }

    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let job = self.job();
        let range = job.device().limits().acceleration;
        let (place, outcome) = super::into_folder(&SimulateJob::Transducer(job), self.output)?;
        match outcome.truth()["samples_beyond_range"].as_u64() {
            None | Some(0) => {}
            Some(beyond) => console::note(format!(
                "note: {beyond} samples lie beyond what the device measures ({range:.4} m/s²)"
            )),
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
