//! What is uncertain on the bench, how it acts on an observation, and with what it varies.

use proofmass_core::Error;
use proofmass_uncertainty::{DegreesOfFreedom, Evaluation};
use serde::{Deserialize, Serialize};

/// What an input quantity does to the observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Acts {
    /// Relative error of the modulus of the reference acceleration.
    ReferenceModulus,
    /// Error of its phase, radians.
    ReferencePhase,
    /// Relative error of the modulus of an output.
    OutputModulus,
    /// Error of the phase of an output, radians.
    OutputPhase,
    /// Additive error of an output, volts, in each of the real and the imaginary part.
    OutputAdditive,
    /// Error of the inclination α, radians.
    Inclination,
    /// Error of the rotation ω, radians.
    Rotation,
}

impl Acts {
    /// Whether the error is one of the mounting, so that the data may speak about it.
    pub fn is_angle(self) -> bool {
        matches!(self, Self::Inclination | Self::Rotation)
    }

    pub(crate) fn on_one_output(self) -> bool {
        matches!(
            self,
            Self::OutputModulus | Self::OutputPhase | Self::OutputAdditive
        )
    }
}

/// A grouping key: one independent draw exists per distinct value of the keys an input varies with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Key {
    /// Drive frequency.
    Frequency,
    /// Wedge.
    Inclination,
    /// Rotation on the wedge.
    Rotation,
    /// Output channel.
    Channel,
    /// One configuration at one frequency.
    Run,
}

/// One input of the budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Stable name, such as `reference.calibration`.
    pub key: String,
    /// What it is, for a reader of the budget.
    pub description: String,
    /// What it does.
    pub acts: Acts,
    /// Standard uncertainty in the unit that `acts` names.
    pub standard_uncertainty: f64,
    /// Distribution as a word.
    pub distribution: String,
    /// Type A or B.
    pub evaluation: Evaluation,
    /// Degrees of freedom.
    pub dof: DegreesOfFreedom,
    /// Keys it varies with; none is one draw for the campaign.
    pub varies_with: Vec<Key>,
    /// Standard uncertainty at single frequencies (Hz), where it is not the same at all; `standard_uncertainty` is
    /// then the largest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_frequencies: Vec<(f64, f64)>,
}

impl Input {
    /// A type B input with a normal distribution and infinite degrees of freedom.
    pub fn new(key: &str, acts: Acts, standard_uncertainty: f64, varies_with: &[Key]) -> Self {
        Self {
            key: key.to_owned(),
            description: key.to_owned(),
            acts,
            standard_uncertainty,
            distribution: "normal".to_owned(),
            evaluation: Evaluation::B,
            dof: DegreesOfFreedom::INFINITE,
            varies_with: varies_with.to_vec(),
            at_frequencies: vec![],
        }
    }

    /// Standard uncertainty at a frequency in Hz.
    pub fn standard_uncertainty_at(&self, frequency: f64) -> f64 {
        self.at_frequencies
            .iter()
            .find(|(f, _)| (f / frequency - 1.0).abs() < 1e-9)
            .map_or(self.standard_uncertainty, |(_, u)| *u)
    }

    /// A rectangular distribution of this half width: u = a/√3.
    pub fn rectangular(key: &str, acts: Acts, half_width: f64, varies_with: &[Key]) -> Self {
        Self {
            distribution: "rectangular".to_owned(),
            ..Self::new(key, acts, half_width / 3f64.sqrt(), varies_with)
        }
    }

    /// A description for the reader.
    #[must_use]
    pub fn described(mut self, description: &str) -> Self {
        description.clone_into(&mut self.description);
        self
    }

    /// Evaluated by statistics, with these degrees of freedom.
    #[must_use]
    pub fn type_a(mut self, dof: f64) -> Self {
        self.evaluation = Evaluation::A;
        self.dof = DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE);
        self
    }

    /// Whether the draws of two frequencies are the same.
    pub(crate) fn shared_by_frequencies(&self) -> bool {
        !self.varies_with.contains(&Key::Frequency) && !self.varies_with.contains(&Key::Run)
    }

    /// Whether no two runs share a draw, so that it is part of the noise of a run. Angles never are: they act
    /// through the geometry.
    pub(crate) fn within_a_run(&self) -> bool {
        self.varies_with.contains(&Key::Run) && !self.acts.is_angle()
    }
}

/// The inputs of a calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Inputs, independent of each other.
    pub inputs: Vec<Input>,
}

impl Budget {
    /// Inputs after a check of their numbers.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a standard uncertainty that is negative or not finite.
    pub fn new(inputs: Vec<Input>) -> Result<Self, Error> {
        for input in &inputs {
            if !(input.standard_uncertainty >= 0.0 && input.standard_uncertainty.is_finite()) {
                return Err(Error::OutOfRange {
                    name: "standard uncertainty of an input",
                    value: input.standard_uncertainty,
                    min: 0.0,
                    max: f64::MAX,
                });
            }
        }
        Ok(Self { inputs })
    }

    /// The budget of the published bench, with the printed contributions and the keys they vary with.
    ///
    /// 0.4 % (k = 2) reference calibration per frequency; ±0.1° per wedge; ±1° per gluing; conditioner
    /// stability per channel; the rest per run and channel.
    ///
    /// **Source** `[Murgia2022]` 3.4, figure 3.8; the keys are ours: the printed budget has none.
    pub fn published_bench() -> Self {
        use Acts::*;
        let run_channel = [Key::Run, Key::Channel];
        Self {
            inputs: vec![
                Input::new(
                    "reference.calibration",
                    ReferenceModulus,
                    0.002,
                    &[Key::Frequency],
                )
                .described("calibration of the reference standard"),
                Input::rectangular(
                    "wedge.angle",
                    Inclination,
                    0.1f64.to_radians(),
                    &[Key::Inclination],
                )
                .described("machining tolerance of the wedge faces"),
                Input::rectangular(
                    "gluing.angle",
                    Rotation,
                    1f64.to_radians(),
                    &[Key::Inclination, Key::Rotation],
                )
                .described("angle at which the device was glued"),
                Input::rectangular("conditioner.gain", OutputModulus, 0.0015, &[Key::Channel])
                    .described("gain stability of the conditioner"),
                Input::new("repeatability", OutputModulus, 0.001, &run_channel)
                    .described("repeatability of one reading")
                    .type_a(20.0),
                Input::new("reproducibility", OutputModulus, 0.003, &run_channel)
                    .described("reproducibility of one reading")
                    .type_a(20.0),
                Input::new("reading.phase", OutputPhase, 0.003, &run_channel)
                    .described("phase of one reading"),
                Input::rectangular("transverse.motion", OutputModulus, 0.001, &run_channel)
                    .described("residual transverse motion"),
                Input::rectangular("coupled.vibration", OutputModulus, 0.001, &run_channel)
                    .described("coupled vibration"),
                Input::rectangular("resolution", OutputModulus, 0.0015, &run_channel)
                    .described("resolution"),
            ],
        }
    }

    /// The same inputs without those of a key; for comparisons and negative controls.
    #[must_use]
    pub fn without(&self, key: &str) -> Self {
        Self {
            inputs: self
                .inputs
                .iter()
                .filter(|i| i.key != key)
                .cloned()
                .collect(),
        }
    }

    /// The same inputs with one standard uncertainty multiplied.
    #[must_use]
    pub fn scaled(&self, key: &str, factor: f64) -> Self {
        let mut budget = self.clone();
        for input in budget.inputs.iter_mut().filter(|i| i.key == key) {
            input.standard_uncertainty *= factor;
            for (_, u) in &mut input.at_frequencies {
                *u *= factor;
            }
        }
        budget
    }
}
