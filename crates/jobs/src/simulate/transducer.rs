//! A transducer of any principle under a shock, noise, a sweep or a step.

use super::Desk;
use super::construction::TransducerConstruction;
use crate::trouble::{Result, Trouble};
use proofmass_documents::StatedQuantity;
use proofmass_io::Table;
use proofmass_rig::{
    ProofMass, Transducer, TransducerBench, TransducerMotion, TransducerRecording,
};
use proofmass_signal::PulseShape;
use serde::{Deserialize, Serialize};

/// A transducer on a bench: recording.csv (time, reference, output), truth.csv, truth.json.
///
/// The same seed makes the same recording on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedTransducer {
    /// Principle of the device, which is that of an example in all else
    #[cfg_attr(
        feature = "clap",
        arg(long, value_enum, default_value = "piezoelectric")
    )]
    pub principle: SimulatedPrinciple,
    /// What happens to it
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value = "shock"))]
    pub motion: SimulatedExcitation,
    /// Greatest acceleration of the motion (RMS of noise), m/s² [default: a fifth of what the device measures, at its resonance where that is swept]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive, value_name = "M_PER_S2"))]
    pub level: Option<f64>,
    /// Duration of the pulse, s [default: twenty periods of the mass]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive, value_name = "SECONDS"))]
    pub pulse: Option<f64>,
    /// Natural frequency of the mass, Hz [default: that of the example]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive, value_name = "HZ"))]
    pub natural_frequency: Option<f64>,
    /// Damping ratio of the mass [default: that of the example]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive, value_name = "RATIO"))]
    pub damping: Option<f64>,
    /// The device by its construction, in place of an example
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub construction: Option<TransducerConstruction>,
    /// Sampling rate, Hz [default: fifty times the natural frequency]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive))]
    pub rate: Option<f64>,
    /// Duration, s [default: 65 536 samples]
    #[cfg_attr(feature = "clap", arg(long, value_parser = crate::arguments::positive))]
    pub duration: Option<f64>,
    /// Departure from the reference temperature, K
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedTransducer::default().temperature, allow_negative_numbers = true))]
    pub temperature: f64,
    /// Noise of one sample as a share of full scale
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedTransducer::default().noise))]
    pub noise: f64,
    /// Noise of one sample of the reference, m/s²
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedTransducer::default().reference_noise))]
    pub reference_noise: f64,
    /// Bits of the converter, 0 for none
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedTransducer::default().bits))]
    pub bits: u32,
    /// Seed of the noise
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedTransducer::default().seed))]
    pub seed: u64,
}

impl Default for SimulatedTransducer {
    fn default() -> Self {
        Self {
            principle: SimulatedPrinciple::Piezoelectric,
            motion: SimulatedExcitation::Shock,
            level: None,
            pulse: None,
            natural_frequency: None,
            damping: None,
            construction: None,
            rate: None,
            duration: None,
            temperature: 0.0,
            noise: 1e-5,
            reference_noise: 0.0,
            bits: 24,
            seed: 1,
        }
    }
}

/// Principles of which there is an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)] // The names say it; the laws of each are those of the rig.
pub enum SimulatedPrinciple {
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

/// What happens to a simulated transducer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SimulatedExcitation {
    /// Half-sine pulse
    Shock,
    /// White noise
    Random,
    /// Logarithmic sweep, from a thousandth of the natural frequency to twice it
    Sweep,
    /// From rest to a constant acceleration
    Step,
}

/// The truth beside a simulated recording.
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
    /// What the construction says of the device, with uncertainties.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<Vec<StatedQuantity>>,
}

impl SimulatedTransducer {
    /// The device that is simulated.
    ///
    /// # Errors
    /// A construction that makes no device, or one beside a natural frequency or a damping ratio.
    pub fn device(&self) -> Result<Transducer> {
        if let Some(construction) = &self.construction {
            if self.natural_frequency.is_some() || self.damping.is_some() {
                return Err(Trouble::request(
                    "natural frequency and damping of a device by its construction are what it makes them",
                )
                .with_hint("change its mass, stiffness or gap, or leave the construction out"));
            }
            return construction.build();
        }
        let mut examples = Transducer::examples();
        let mut device = examples.swap_remove(self.principle as usize);
        if self.natural_frequency.is_some() || self.damping.is_some() {
            let old = device.mass;
            device.mass = ProofMass::of(
                old.mass,
                self.natural_frequency.unwrap_or(old.natural_frequency()),
                self.damping.unwrap_or(old.damping_ratio()),
                old.stop,
            );
        }
        Ok(device)
    }

    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        let bench = self.bench()?;
        let recording = bench.simulate(self.seed).map_err(|e| {
            Trouble::from(e)
                .with_hint("see `proofmass simulate transducer --help` for what each setting means")
        })?;
        let device = &bench.transducer;
        let (unit, factor) = recorded(device.unit(), &recording.output);
        let model = match &self.construction {
            Some(construction) => {
                desk.write("transfer.csv", construction.transfer()?.to_csv()?)?;
                let figures = construction.figures()?.quantities();
                let stated = figures.iter().map(|q| StatedQuantity::new(q, 0.95));
                Some(stated.collect())
            }
            None => None,
        };
        let truth = Truth {
            scenario: "transducer",
            seed: self.seed,
            unit,
            natural_frequency_hz: device.mass.natural_frequency(),
            damping_ratio: device.mass.damping_ratio(),
            sensitivity: device.sensitivity().map(|s| factor * s),
            high_pass_hz: device.principle.high_pass(),
            low_pass_hz: device.principle.low_pass(),
            samples_beyond_range: recording.beyond,
            model,
            bench: &bench,
        };
        write(&recording, unit, factor, desk)?;
        desk.truth(&truth)
    }

    fn bench(&self) -> Result<TransducerBench> {
        let device = self.device()?;
        let natural = device.mass.natural_frequency();
        // A sweep rests at the resonance, which raises it by 1/2ζ.
        let raised = match self.motion {
            SimulatedExcitation::Sweep => (2.0 * device.mass.damping_ratio()).min(1.0),
            _ => 1.0,
        };
        let level = self
            .level
            .unwrap_or(0.2 * raised * device.limits().acceleration);
        let rate = self.rate.unwrap_or(50.0 * natural);
        let motion = match self.motion {
            SimulatedExcitation::Shock => TransducerMotion::Shock {
                shape: PulseShape::HalfSine,
                peak: level,
                duration: self.pulse.unwrap_or(20.0 / natural),
            },
            SimulatedExcitation::Random => TransducerMotion::Random { rms: level },
            SimulatedExcitation::Sweep => TransducerMotion::Sweep {
                low: 1e-3 * natural,
                high: (2.0 * natural).min(0.4 * rate),
                amplitude: level,
            },
            SimulatedExcitation::Step => TransducerMotion::Step { height: level },
        };
        Ok(TransducerBench {
            motion,
            rate,
            duration: self.duration.unwrap_or(65_536.0 / rate),
            temperature: self.temperature,
            noise: self.noise,
            reference_noise: self.reference_noise,
            bits: self.bits,
            transducer: device,
        })
    }
}

/// Unit in which an output is recorded, and its number in one of the device's own: farads and amperes are too large.
pub(super) fn recorded(unit: &'static str, output: &[f64]) -> (&'static str, f64) {
    let greatest = output.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    match unit {
        "F" => ("pF", 1e12),
        "A" if greatest < 1e-6 => ("nA", 1e9),
        "A" => ("mA", 1e3),
        other => (other, 1.0),
    }
}

fn write(recording: &TransducerRecording, unit: &str, factor: f64, desk: &Desk<'_>) -> Result<()> {
    let mut table = Table::new([
        "time_s".to_owned(),
        "reference_m/s2".to_owned(),
        format!("output_{unit}"),
    ]);
    let mut exact = Table::new(["time_s", "acceleration_m/s2"]);
    for (k, t) in recording.time.iter().enumerate() {
        table.push([*t, recording.reference[k], factor * recording.output[k]])?;
        exact.push([*t, recording.truth[k]])?;
    }
    desk.write("recording.csv", table.to_csv()?)?;
    desk.write("truth.csv", exact.to_csv()?)
}
