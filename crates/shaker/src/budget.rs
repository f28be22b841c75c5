//! What is uncertain on the bench, how it acts on an observation, and with what it varies.

use proofmass_core::Error;
use proofmass_dynamic::log_frequency::place;
use proofmass_uncertainty::{DegreesOfFreedom, Distribution, Evaluation, Inputs};
use serde::{Deserialize, Serialize};

/// What an input quantity does to the observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Additive error of an output, volts (or whatever the outputs are), in each of the real and the imaginary part.
    OutputAdditive,
    /// Error of the inclination α, radians.
    Inclination,
    /// Error of the rotation ω, radians.
    Rotation,
    /// Lateral lean of the wedge face, radians: a turn of the seat about x′.
    Lean,
    /// Tilt of the device in its adhesive, radians: two independent turns, about its own x and its own y.
    Tilt,
}

impl Acts {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::ReferenceModulus,
        Self::ReferencePhase,
        Self::OutputModulus,
        Self::OutputPhase,
        Self::OutputAdditive,
        Self::Inclination,
        Self::Rotation,
        Self::Lean,
        Self::Tilt,
    ];

    /// Its name in a budget file.
    pub fn name(self) -> &'static str {
        match self {
            Self::ReferenceModulus => "reference-modulus",
            Self::ReferencePhase => "reference-phase",
            Self::OutputModulus => "output-modulus",
            Self::OutputPhase => "output-phase",
            Self::OutputAdditive => "output-additive",
            Self::Inclination => "inclination",
            Self::Rotation => "rotation",
            Self::Lean => "lean",
            Self::Tilt => "tilt",
        }
    }

    /// Whether the error is one of the mounting, so that the data may speak about it.
    pub fn is_angle(self) -> bool {
        matches!(
            self,
            Self::Inclination | Self::Rotation | Self::Lean | Self::Tilt
        )
    }

    /// Unit of the error.
    pub fn unit(self) -> &'static str {
        match self {
            Self::ReferenceModulus | Self::OutputModulus => "1",
            Self::OutputAdditive => "V",
            Self::ReferencePhase
            | Self::OutputPhase
            | Self::Inclination
            | Self::Rotation
            | Self::Lean
            | Self::Tilt => "rad",
        }
    }

    /// Independent draws that one error has, beside those of the outputs: real and imaginary part, or two axes.
    pub(crate) fn parts(self) -> usize {
        match self {
            Self::OutputAdditive | Self::Tilt => 2,
            _ => 1,
        }
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Session in which a run was measured: a day, or a bench that was set up anew.
    Session,
}

/// Key of the real and the imaginary part of an additive error, beside those of [`Key`].
pub(crate) const PART: &str = "part";

impl Key {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Frequency,
        Self::Inclination,
        Self::Rotation,
        Self::Channel,
        Self::Run,
        Self::Session,
    ];

    /// Its name in a budget file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frequency => "frequency",
            Self::Inclination => "inclination",
            Self::Rotation => "rotation",
            Self::Channel => "channel",
            Self::Run => "run",
            Self::Session => "session",
        }
    }
}

/// One input of the budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShakerInput {
    /// Stable name, such as `reference.calibration`.
    pub key: String,
    /// What it is, for a reader of the budget.
    pub description: String,
    /// What it does.
    pub acts: Acts,
    /// What is known of the error: a distribution about zero, in the unit that `acts` names.
    pub distribution: Distribution,
    /// Type A or B.
    pub evaluation: Evaluation,
    /// Degrees of freedom.
    pub dof: DegreesOfFreedom,
    /// Keys it varies with; none is one draw for the campaign.
    pub varies_with: Vec<Key>,
    /// Standard uncertainty over ascending frequencies (Hz), where it is not the same at all, linear in the logarithm of the frequency
    /// between them; that of `distribution` is then the largest, and the shape is the same everywhere.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_frequencies: Vec<(f64, f64)>,
    /// The one output that has the error, 0 to 2; all three where `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<usize>,
    /// Whether nobody declares it: its uncertainty is a size to begin with, and in the result that which the runs have.
    #[serde(skip)]
    pub(crate) assumed: bool,
}

impl ShakerInput {
    /// A type B input with a normal distribution and infinite degrees of freedom.
    pub fn new(key: &str, acts: Acts, standard_uncertainty: f64, varies_with: &[Key]) -> Self {
        Self {
            key: key.to_owned(),
            description: key.to_owned(),
            acts,
            distribution: Distribution::Normal {
                mean: 0.0,
                u: standard_uncertainty,
            },
            evaluation: Evaluation::B,
            dof: DegreesOfFreedom::INFINITE,
            varies_with: varies_with.to_vec(),
            at_frequencies: vec![],
            output: None,
            assumed: false,
        }
    }

    /// Standard uncertainty in the unit that `acts` names.
    pub fn standard_uncertainty(&self) -> f64 {
        self.distribution.standard_uncertainty()
    }

    /// Standard uncertainty at a frequency in Hz; the largest beyond the frequencies that are stated.
    pub fn standard_uncertainty_at(&self, frequency: f64) -> f64 {
        let list = &self.at_frequencies;
        match place(list, |p| p.0, frequency) {
            Some((k, 0.0)) => list[k].1,
            Some((k, share)) => list[k].1 + share * (list[k + 1].1 - list[k].1),
            None => self.standard_uncertainty(),
        }
    }

    /// Whether its standard uncertainty is stated at a frequency in Hz.
    pub fn reaches(&self, frequency: f64) -> bool {
        let list = &self.at_frequencies;
        list.is_empty() || place(list, |p| p.0, frequency).is_some()
    }

    /// Outputs, or axes of a tilt, that have it: one part of it each.
    pub(crate) fn on_parts(&self) -> std::ops::Range<usize> {
        match (self.acts.on_one_output(), self.output) {
            (true, Some(k)) => k..k + 1,
            (true, None) => 0..3,
            (false, _) => 0..self.acts.parts(),
        }
    }

    /// The same of one output alone, 0 to 2.
    #[must_use]
    pub fn of_output(mut self, output: usize) -> Self {
        self.output = Some(output);
        self
    }

    /// Standard uncertainties over ascending frequencies, (Hz, u).
    #[must_use]
    pub fn over_frequency(mut self, list: Vec<(f64, f64)>) -> Self {
        let largest = list.iter().fold(0.0, |a: f64, (_, u)| a.max(*u));
        self.distribution = Distribution::Normal {
            mean: 0.0,
            u: largest,
        };
        self.at_frequencies = list;
        self
    }

    /// A rectangular distribution of this half width: u = a/√3.
    pub fn rectangular(key: &str, acts: Acts, half_width: f64, varies_with: &[Key]) -> Self {
        Self {
            distribution: Distribution::Rectangular {
                lower: -half_width,
                upper: half_width,
            },
            ..Self::new(key, acts, 0.0, varies_with)
        }
    }

    /// Another distribution about zero.
    #[must_use]
    pub fn distributed(mut self, distribution: Distribution) -> Self {
        self.dof = distribution.dof();
        self.distribution = distribution;
        self
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

    /// Multiplies its standard uncertainty.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.distribution = self.distribution.scaled(factor, 0.0);
        for (_, u) in &mut self.at_frequencies {
            *u *= factor;
        }
    }

    /// Whether the draws of two frequencies are the same.
    pub(crate) fn shared_by_frequencies(&self) -> bool {
        !self.varies_with.contains(&Key::Frequency) && !self.varies_with.contains(&Key::Run)
    }

    /// Whether the runs of a session share a draw, and those of another have another.
    pub fn varies_between_sessions(&self) -> bool {
        self.varies_with.contains(&Key::Session)
            && !self.varies_with.contains(&Key::Run)
            && self.standard_uncertainty() > 0.0
    }

    /// Whether no two runs share a draw, so that it is part of the noise of a run. Angles never are: they act
    /// through the geometry.
    pub(crate) fn within_a_run(&self) -> bool {
        self.varies_with.contains(&Key::Run) && !self.acts.is_angle()
    }
}

/// The inputs of a calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Budget {
    /// Inputs, independent of each other.
    pub inputs: Vec<ShakerInput>,
    /// Unit of the outputs, in which additive errors are stated.
    #[serde(default)]
    pub output: super::OutputUnit,
}

impl Budget {
    /// Inputs after a check of their numbers.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a distribution that does not exist, or whose mean is not zero: what is known is to be
    /// corrected, and only what is left is an error.
    pub fn new(inputs: Vec<ShakerInput>) -> Result<Self, Error> {
        for input in &inputs {
            if let Some(output @ 3..) = input.output {
                return Err(Error::OutOfRange {
                    name: "output of an input",
                    value: output as f64,
                    min: 0.0,
                    max: 2.0,
                });
            }
            input.distribution.check()?;
            let (mean, u) = (
                input.distribution.estimate(),
                input.distribution.standard_uncertainty(),
            );
            if !(mean.abs() <= 1e-9 * u) {
                return Err(Error::OutOfRange {
                    name: "mean of the error of an input",
                    value: mean,
                    min: -1e-9 * u,
                    max: 1e-9 * u,
                });
            }
        }
        Ok(Self {
            inputs,
            output: super::OutputUnit::default(),
        })
    }

    /// The same inputs for a device with other outputs than volts.
    #[must_use]
    pub fn of_outputs(mut self, output: super::OutputUnit) -> Self {
        self.output = output;
        self
    }

    /// The same inputs for the general engine, each with the keys it varies with; an error of two parts (real and
    /// imaginary, or about two axes) has the further key `part`.
    ///
    /// This is what is drawn in the Monte Carlo check, and there is no other place where the budget becomes random
    /// numbers.
    pub fn inputs(&self) -> Inputs {
        self.inputs.iter().fold(Inputs::new(), |inputs, input| {
            let mut keys: Vec<&str> = input.varies_with.iter().map(|k| k.name()).collect();
            if input.acts.parts() > 1 {
                keys.push(PART);
            }
            inputs.add(
                proofmass_uncertainty::Input::new(
                    &input.key,
                    match input.acts {
                        Acts::OutputAdditive => self.output.symbol(),
                        other => other.unit(),
                    },
                    input.distribution.clone(),
                )
                .description(&input.description)
                .evaluation(input.evaluation)
                .dof(input.dof)
                .varies_with(keys),
            )
        })
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
            output: super::OutputUnit::default(),
            inputs: vec![
                ShakerInput::new(
                    "reference.calibration",
                    ReferenceModulus,
                    0.002,
                    &[Key::Frequency],
                )
                .described("calibration of the reference standard"),
                ShakerInput::rectangular(
                    "wedge.angle",
                    Inclination,
                    0.1f64.to_radians(),
                    &[Key::Inclination],
                )
                .described("machining tolerance of the wedge faces"),
                ShakerInput::rectangular(
                    "gluing.angle",
                    Rotation,
                    1f64.to_radians(),
                    &[Key::Inclination, Key::Rotation],
                )
                .described("angle at which the device was glued"),
                ShakerInput::rectangular(
                    "conditioner.gain",
                    OutputModulus,
                    0.0015,
                    &[Key::Channel],
                )
                .described("gain stability of the conditioner"),
                ShakerInput::new("repeatability", OutputModulus, 0.001, &run_channel)
                    .described("repeatability of one reading")
                    .type_a(20.0),
                ShakerInput::new("reproducibility", OutputModulus, 0.003, &run_channel)
                    .described("reproducibility of one reading")
                    .type_a(20.0),
                ShakerInput::new("reading.phase", OutputPhase, 0.003, &run_channel)
                    .described("phase of one reading"),
                ShakerInput::rectangular("transverse.motion", OutputModulus, 0.001, &run_channel)
                    .described("residual transverse motion"),
                ShakerInput::rectangular("coupled.vibration", OutputModulus, 0.001, &run_channel)
                    .described("coupled vibration"),
                ShakerInput::rectangular("resolution", OutputModulus, 0.0015, &run_channel)
                    .described("resolution"),
            ],
        }
    }

    /// The same inputs without those of a key; for comparisons and negative controls.
    #[must_use]
    pub fn without(&self, key: &str) -> Self {
        Self {
            output: self.output,
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
            input.scale(factor);
        }
        budget
    }
}
