//! Transducer models: proof mass on a spring, and the principles by which its motion becomes electrical.

mod beam;
mod piezo_element;
mod plates;
mod principle;
mod recording;
mod squeeze_film;

pub use beam::{Beam, TipPlate};
pub use piezo_element::{PiezoCut, PiezoElement};
pub use plates::plate_capacitance;
pub use principle::{BridgeArms, Principle};
pub use recording::{TransducerBench, TransducerMotion, TransducerRecording};
pub use squeeze_film::SqueezeFilm;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Mass, spring and damper of an accelerometer, with the way to its stop.
///
/// ```
/// use proofmass_rig::ProofMass;
/// // 2 mg on 80 N/m: 6.32 krad/s.
/// let mass = ProofMass { mass: 2e-6, stiffness: 80.0, damping: 5e-4, stop: 2e-6 };
/// assert!((mass.natural_frequency() - 1006.6).abs() < 0.1);
/// assert!((mass.quality() - 25.298).abs() < 1e-3);
/// assert!((mass.static_displacement(9.81) - 245.25e-9).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProofMass {
    /// kg.
    pub mass: f64,
    /// N/m.
    pub stiffness: f64,
    /// N·s/m.
    pub damping: f64,
    /// Displacement at which it meets its stop, m.
    pub stop: f64,
}

impl ProofMass {
    /// With this natural frequency in Hz and damping ratio.
    pub fn of(mass: f64, frequency: f64, damping_ratio: f64, stop: f64) -> Self {
        let omega = TAU * frequency;
        Self {
            mass,
            stiffness: mass * omega * omega,
            damping: 2.0 * damping_ratio * mass * omega,
            stop,
        }
    }

    /// √(k/m)/2π, Hz.
    pub fn natural_frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt() / TAU
    }

    /// b/(2√(km)).
    pub fn damping_ratio(&self) -> f64 {
        self.damping / (2.0 * (self.stiffness * self.mass).sqrt())
    }

    /// 1/(2ζ).
    pub fn quality(&self) -> f64 {
        0.5 / self.damping_ratio()
    }

    /// Displacement that a constant acceleration holds, m: (m/k) a.
    pub fn static_displacement(&self, acceleration: f64) -> f64 {
        self.mass / self.stiffness * acceleration
    }

    /// The acceleration that a constant displacement tells.
    pub fn static_acceleration(&self, displacement: f64) -> f64 {
        self.stiffness / self.mass * displacement
    }

    /// Greatest frequency up to which |1/(1 − r² + 2jζr)| stays within this departure of one, Hz.
    pub fn flat_to(&self, departure: f64) -> f64 {
        let zeta = self.damping_ratio();
        let gain = |r: f64| {
            ((1.0 - r * r).powi(2) + (2.0 * zeta * r).powi(2))
                .sqrt()
                .recip()
        };
        // The first passage, on a grid far finer than any answer is used.
        let r = (1..20_000)
            .map(|k| 1e-4 * f64::from(k))
            .find(|r| (gain(*r) - 1.0).abs() > departure);
        r.unwrap_or(2.0) * self.natural_frequency()
    }
}

/// A proof mass with a principle.
///
/// ```
/// use proofmass_rig::Transducer;
/// for device in Transducer::examples() {
///     let a = 0.3 * device.limits().acceleration;
///     let output = device.output(a).unwrap();
///     assert!((device.acceleration(output).unwrap() / a - 1.0).abs() < 1e-9, "{}", device.name);
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Transducer {
    /// What it is called.
    pub name: String,
    /// Its front.
    pub mass: ProofMass,
    /// How displacement (or force) becomes electrical.
    pub principle: Principle,
}

/// Within what a transducer measures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TransducerLimits {
    /// Greatest acceleration, m/s².
    pub acceleration: f64,
    /// Lowest frequency within 5 %, Hz; zero where it measures down to rest.
    pub(crate) lowest: f64,
    /// Highest frequency within 5 %, Hz.
    pub(crate) highest: f64,
    /// Relative change of the sensitivity with temperature, 1/K.
    pub(crate) temperature: f64,
}

impl Transducer {
    /// A device.
    pub fn new(name: impl Into<String>, mass: ProofMass, principle: Principle) -> Self {
        Self {
            name: name.into(),
            mass,
            principle,
        }
    }

    /// Output for a constant acceleration (for a piezoelectric one: for a change too fast to leak away), in [`Self::unit`];
    /// `None` beyond what it measures.
    pub fn output(&self, acceleration: f64) -> Option<f64> {
        let x = self.mass.static_displacement(acceleration);
        (x.abs() < self.mass.stop)
            .then(|| self.principle.output(x, &self.mass))
            .flatten()
    }

    /// The acceleration that an output tells; `None` for an output that no displacement gives.
    pub fn acceleration(&self, output: f64) -> Option<f64> {
        let x = self.principle.displacement(output, &self.mass)?;
        (x.abs() < self.mass.stop).then(|| self.mass.static_acceleration(x))
    }

    /// Change of the output per acceleration about rest, in [`Self::unit`] per m/s².
    pub fn sensitivity(&self) -> Option<f64> {
        // Even parts of the relation cancel; of a cubic part 10⁻⁶ of what it has at the end of the range is left.
        let a = 1e-3 * self.limits().acceleration;
        Some((self.output(a)? - self.output(-a)?) / (2.0 * a))
    }

    /// Transfer function: output per acceleration at a frequency in Hz, e^{jωt}, in [`Self::unit`] per m/s².
    ///
    /// H = S/(1 − r² + 2jζr) with r = f/f₀, times jf/(f_c + jf) of a leak, times f_l/(f_l + jf) of a low-pass.
    ///
    /// ```
    /// use proofmass_rig::Transducer;
    /// for device in Transducer::examples() {
    ///     let corner = device.principle.high_pass().unwrap_or(0.0);
    ///     let h = device.response(corner.max(1e-3 * device.mass.natural_frequency().min(10.0))).unwrap();
    ///     assert!((h.norm() / device.sensitivity().unwrap().abs() - 1.0).abs() < 0.3, "{}", device.name);
    /// }
    /// ```
    pub fn response(&self, frequency: f64) -> Option<Complex64> {
        let r = frequency / self.mass.natural_frequency();
        let j = Complex64::i();
        let mut h = self.sensitivity()? / (1.0 - r * r + 2.0 * j * self.mass.damping_ratio() * r);
        if let Some(corner) = self.principle.high_pass() {
            h *= j * frequency / (corner + j * frequency);
        }
        if let Some(corner) = self.principle.low_pass() {
            h *= corner / (corner + j * frequency);
        }
        h.is_finite().then_some(h)
    }

    /// Unit of the output.
    pub fn unit(&self) -> &'static str {
        self.principle.unit()
    }

    /// Range, band and temperature coefficient, from the model.
    pub fn limits(&self) -> TransducerLimits {
        let reach = self.mass.stop.min(self.principle.reach());
        // Of a first-order high-pass 5 % are left out at 3.04 corners; of a first-order low-pass at 0.33.
        let lowest = self.principle.high_pass().map_or(0.0, |f| 3.042 * f);
        let highest = self.mass.flat_to(0.05);
        TransducerLimits {
            acceleration: self.mass.static_acceleration(reach),
            lowest,
            highest: self
                .principle
                .low_pass()
                .map_or(highest, |f| highest.min(0.329 * f)),
            temperature: self.principle.temperature_coefficient(),
        }
    }

    /// One of each principle, with figures as devices of its kind have them.
    pub fn examples() -> Vec<Self> {
        let device = |name: &str, mass: ProofMass, principle: Principle| Self {
            name: name.into(),
            mass,
            principle,
        };
        vec![
            device(
                "capacitive, differential comb",
                ProofMass::of(2e-9, 4500.0, 0.7, 1.5e-6),
                Principle::Comb {
                    rest_capacitance: 0.2e-12,
                    gap: 2e-6,
                },
            ),
            device(
                "piezoresistive, full bridge",
                ProofMass::of(1e-7, 30_000.0, 0.05, 4e-7),
                Principle::Bridge {
                    gauge_factor: 120.0,
                    strain_per_metre: 2500.0,
                    arms: BridgeArms::Full,
                    excitation: 10.0,
                    temperature: -1.5e-3,
                },
            ),
            device(
                "strain gauge, half bridge",
                ProofMass::of(5e-3, 600.0, 0.6, 1e-4),
                Principle::Bridge {
                    gauge_factor: 2.1,
                    strain_per_metre: 20.0,
                    arms: BridgeArms::Half,
                    excitation: 5.0,
                    temperature: 1e-4,
                },
            ),
            device(
                "piezoelectric, shear",
                ProofMass::of(5e-3, 30_000.0, 0.02, 1e-6),
                Principle::Piezoelectric {
                    charge_coefficient: 500e-12,
                    capacitance: 1e-9,
                    resistance: 1e9,
                    temperature: 1.4e-3,
                },
            ),
            device(
                "inductive, differential transformer",
                ProofMass::of(2e-2, 60.0, 0.65, 1e-3),
                Principle::Inductive {
                    sensitivity: 200.0,
                    carrier: 5000.0,
                },
            ),
            device(
                "Hall",
                ProofMass::of(1e-3, 100.0, 0.5, 5e-4),
                Principle::Hall {
                    sensitivity: 5.0,
                    gradient: 50.0,
                    temperature: -6e-4,
                },
            ),
            device(
                "thermal convective",
                // No mass moves: what limits is the gas, not a spring.
                ProofMass::of(1e-9, 1e4, 0.7, 1e-7),
                Principle::Thermal {
                    sensitivity: 0.05,
                    time_constant: 5e-3,
                    temperature: -4e-3,
                },
            ),
            device(
                "resonant beam",
                ProofMass::of(1e-6, 2000.0, 0.7, 2e-6),
                Principle::Resonant {
                    frequency: 40e3,
                    per_metre: 3e3,
                },
            ),
            device(
                "tunnelling",
                ProofMass::of(5e-8, 8000.0, 0.1, 1e-9),
                Principle::Tunnelling {
                    current: 1e-9,
                    barrier: 0.3,
                },
            ),
            device(
                "optical, shutter",
                ProofMass::of(1e-4, 300.0, 0.6, 4e-5),
                Principle::Shutter {
                    photocurrent: 1e-3,
                    width: 1e-4,
                },
            ),
            device(
                "optical, interferometer",
                ProofMass::of(1e-2, 150.0, 0.1, 1e-5),
                Principle::Interferometer {
                    wavelength: 632.8e-9,
                },
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_the_guide_prints_what_the_models_give() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/dynamic-tests.md");
        let guide = std::fs::read_to_string(path).unwrap();
        for device in Transducer::examples() {
            let limits = device.limits();
            let row = guide
                .lines()
                .find(|l| l.starts_with(&format!("| {} |", device.name)))
                .unwrap_or_else(|| panic!("no row for {}", device.name));
            let cells: Vec<f64> = row
                .split('|')
                .skip(2)
                .take(4)
                .map(|c| c.trim().replace('−', "-").parse().unwrap())
                .collect();
            for (cell, value) in cells.iter().zip([
                limits.acceleration,
                limits.lowest,
                limits.highest,
                limits.temperature,
            ]) {
                // Two or three digits are printed.
                assert!(
                    (cell - value).abs() <= 0.012 * value.abs(),
                    "{row}: {value}"
                );
            }
        }
    }
}
