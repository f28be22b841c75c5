//! From the displacement of a proof mass to something electrical, and back.

use super::ProofMass;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Arms of a Wheatstone bridge that carry gauges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BridgeArms {
    /// One: the output bends with the strain.
    Quarter,
    /// Two, strained oppositely.
    Half,
    /// Four.
    Full,
}

/// How the motion of the mass is read.
///
/// **Source** the relations are those of `[Fraden2016] ch. 9` and `[Bao2005]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Principle {
    /// Differential comb: ΔC = 2C₀ d x/(d² − x²), F.
    Comb {
        /// C₀ of each side at rest, F.
        rest_capacitance: f64,
        /// d, m.
        gap: f64,
    },
    /// Strain gauges or piezoresistors in a bridge: V.
    Bridge {
        /// (ΔR/R)/ε = 1 + 2ν + (Δρ/ρ)/ε.
        gauge_factor: f64,
        /// ε/x, 1/m.
        strain_per_metre: f64,
        /// Gauges.
        arms: BridgeArms,
        /// Excitation, V.
        excitation: f64,
        /// Relative change of the gauge factor, 1/K.
        temperature: f64,
    },
    /// q = d F, V = q/C, with the leakage that makes a high-pass: V.
    Piezoelectric {
        /// d, C/N.
        charge_coefficient: f64,
        /// Of element, cable and amplifier, F.
        capacitance: f64,
        /// Of all that leaks, Ω.
        resistance: f64,
        /// Relative change of d, 1/K.
        temperature: f64,
    },
    /// Differential transformer: V.
    Inductive {
        /// V/m.
        sensitivity: f64,
        /// Carrier, Hz; a tenth of it is the band of its demodulator.
        carrier: f64,
    },
    /// Hall element in the field of a magnet on the mass: V.
    Hall {
        /// V/T.
        sensitivity: f64,
        /// Of the field, T/m.
        gradient: f64,
        /// Relative change, 1/K.
        temperature: f64,
    },
    /// Heated gas, first order and slow; sensed as a voltage per acceleration: V.
    Thermal {
        /// V/(m/s²).
        sensitivity: f64,
        /// s.
        time_constant: f64,
        /// Relative change, 1/K.
        temperature: f64,
    },
    /// Frequency of a beam that the mass pulls: f₀ √(1 + κx), Hz.
    Resonant {
        /// f₀, Hz.
        frequency: f64,
        /// κ, 1/m.
        per_metre: f64,
    },
    /// I = I₀ e^{−α√φ x}, α = 10.25 1/(nm √eV): A.
    Tunnelling {
        /// I₀ at rest, A.
        current: f64,
        /// φ, eV.
        barrier: f64,
    },
    /// Light past an edge: I = I₀(½ + x/w), A.
    Shutter {
        /// I₀ of the whole beam, A.
        photocurrent: f64,
        /// w, m.
        width: f64,
    },
    /// Phase 4πx/λ of the two quadratures of an interferometer, unwrapped: rad.
    Interferometer {
        /// λ, m.
        wavelength: f64,
    },
}

/// α of the tunnel current, 1/(m √eV).
const TUNNEL: f64 = 1.025e10;

impl Principle {
    /// Output at a displacement in m; `None` beyond the reach.
    pub fn output(&self, x: f64, mass: &ProofMass) -> Option<f64> {
        if !(x.abs() < self.reach()) {
            return None;
        }
        Some(match *self {
            Self::Comb {
                rest_capacitance,
                gap,
            } => 2.0 * rest_capacitance * gap * x / (gap * gap - x * x),
            Self::Bridge {
                gauge_factor,
                strain_per_metre,
                arms,
                excitation,
                ..
            } => {
                let r = gauge_factor * strain_per_metre * x;
                excitation
                    * match arms {
                        BridgeArms::Quarter => r / (4.0 + 2.0 * r),
                        BridgeArms::Half => 0.5 * r,
                        BridgeArms::Full => r,
                    }
            }
            Self::Piezoelectric {
                charge_coefficient,
                capacitance,
                ..
            } => charge_coefficient * mass.stiffness * x / capacitance,
            Self::Inductive { sensitivity, .. } => sensitivity * x,
            Self::Hall {
                sensitivity,
                gradient,
                ..
            } => sensitivity * gradient * x,
            Self::Thermal { sensitivity, .. } => sensitivity * mass.static_acceleration(x),
            Self::Resonant {
                frequency,
                per_metre,
            } => frequency * (1.0 + per_metre * x).sqrt(),
            Self::Tunnelling { current, barrier } => current * (-TUNNEL * barrier.sqrt() * x).exp(),
            Self::Shutter {
                photocurrent,
                width,
            } => photocurrent * (0.5 + x / width),
            Self::Interferometer { wavelength } => 4.0 * PI * x / wavelength,
        })
    }

    /// Displacement behind an output; `None` for an output that none gives.
    pub fn displacement(&self, output: f64, mass: &ProofMass) -> Option<f64> {
        let x = match *self {
            // The root of ΔC x² + 2C₀d x − ΔC d² = 0 that vanishes with ΔC.
            Self::Comb {
                rest_capacitance,
                gap,
            } => gap * output / (rest_capacitance + rest_capacitance.hypot(output)),
            Self::Bridge {
                gauge_factor,
                strain_per_metre,
                arms,
                excitation,
                ..
            } => {
                let v = output / excitation;
                let r = match arms {
                    BridgeArms::Quarter => 4.0 * v / (1.0 - 2.0 * v),
                    BridgeArms::Half => 2.0 * v,
                    BridgeArms::Full => v,
                };
                r / (gauge_factor * strain_per_metre)
            }
            Self::Piezoelectric {
                charge_coefficient,
                capacitance,
                ..
            } => output * capacitance / (charge_coefficient * mass.stiffness),
            Self::Inductive { sensitivity, .. } => output / sensitivity,
            Self::Hall {
                sensitivity,
                gradient,
                ..
            } => output / (sensitivity * gradient),
            Self::Thermal { sensitivity, .. } => mass.static_displacement(output / sensitivity),
            Self::Resonant {
                frequency,
                per_metre,
            } => ((output / frequency).powi(2) - 1.0) / per_metre,
            Self::Tunnelling { current, barrier } => {
                -(output / current).ln() / (TUNNEL * barrier.sqrt())
            }
            Self::Shutter {
                photocurrent,
                width,
            } => (output / photocurrent - 0.5) * width,
            Self::Interferometer { wavelength } => output * wavelength / (4.0 * PI),
        };
        (x.abs() < self.reach()).then_some(x)
    }

    /// Displacement up to which the relation holds, m.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Comb { gap, .. } => gap,
            // A strain of 1 % breaks silicon and foil alike.
            Self::Bridge {
                strain_per_metre, ..
            } => 0.01 / strain_per_metre,
            Self::Resonant { per_metre, .. } => 1.0 / per_metre,
            Self::Shutter { width, .. } => 0.5 * width,
            _ => f64::INFINITY,
        }
    }

    /// Corner of the high-pass, Hz, where there is one: 1/(2πRC).
    pub fn high_pass(&self) -> Option<f64> {
        match *self {
            Self::Piezoelectric {
                capacitance,
                resistance,
                ..
            } => Some(1.0 / (TAU * resistance * capacitance)),
            _ => None,
        }
    }

    /// Corner of the first-order low-pass, Hz, where there is one beside the mass.
    pub fn low_pass(&self) -> Option<f64> {
        match *self {
            Self::Thermal { time_constant, .. } => Some(1.0 / (TAU * time_constant)),
            Self::Inductive { carrier, .. } => Some(0.1 * carrier),
            _ => None,
        }
    }

    /// Relative change of the sensitivity, 1/K; zero where the model has none.
    pub fn temperature_coefficient(&self) -> f64 {
        match *self {
            Self::Bridge { temperature, .. }
            | Self::Piezoelectric { temperature, .. }
            | Self::Hall { temperature, .. }
            | Self::Thermal { temperature, .. } => temperature,
            _ => 0.0,
        }
    }

    /// Unit of the output.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Comb { .. } => "F",
            Self::Resonant { .. } => "Hz",
            Self::Tunnelling { .. } | Self::Shutter { .. } => "A",
            Self::Interferometer { .. } => "rad",
            _ => "V",
        }
    }
}
