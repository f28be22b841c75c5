//! From the displacement of a proof mass to something electrical, and back.

use super::ProofMass;
use super::plates::tilting;
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
    /// Differential comb whose fingers slide along each other: ΔC = 2C₀x/l, F.
    AreaComb {
        /// C₀ of each side at rest, F.
        rest_capacitance: f64,
        /// l by which the fingers overlap at rest, m.
        overlap: f64,
    },
    /// One plate that comes nearer to a fixed one, and may turn as it does: ΔC = C₀ (d/(d − x) · artanh(z)/z − 1), z = ux/(d − x), F.
    Plate {
        /// C₀ at rest, F.
        rest_capacitance: f64,
        /// d, m.
        gap: f64,
        /// u: half the length of the plate by its rotation per displacement of its centre; 0 without rotation.
        tilt: f64,
    },
    /// Gauges in series with one that is not strained, fed by one current: V = IR(1 + αT)(nKε + δ), and without (1 + αT) where it is
    /// taken relative to the voltage of the unstrained one.
    SeriesGauges {
        /// K.
        gauge_factor: f64,
        /// ε/x, 1/m.
        strain_per_metre: f64,
        /// n: gauges that add up.
        active: f64,
        /// R of one, Ω.
        resistance: f64,
        /// I, A.
        current: f64,
        /// δ: sum of the relative differences of the gauges at rest.
        mismatch: f64,
        /// α of all resistances, 1/K.
        drift: f64,
        /// Relative change of the gauge factor, 1/K.
        temperature: f64,
        /// Whether the unstrained gauge takes the drift away.
        compensated: bool,
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
            Self::AreaComb {
                rest_capacitance,
                overlap,
            } => 2.0 * rest_capacitance * x / overlap,
            Self::Plate {
                rest_capacitance,
                gap,
                tilt,
            } => rest_capacitance * (tilting(x, gap, tilt) - 1.0),
            Self::SeriesGauges {
                gauge_factor,
                strain_per_metre,
                active,
                resistance,
                current,
                mismatch,
                ..
            } => current * resistance * (active * gauge_factor * strain_per_metre * x + mismatch),
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
            Self::AreaComb {
                rest_capacitance,
                overlap,
            } => output * overlap / (2.0 * rest_capacitance),
            Self::Plate { .. } => self.plate_displacement(output, mass)?,
            Self::SeriesGauges {
                gauge_factor,
                strain_per_metre,
                active,
                resistance,
                current,
                mismatch,
                ..
            } => {
                (output / (current * resistance) - mismatch)
                    / (active * gauge_factor * strain_per_metre)
            }
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

    /// Output at a temperature so many kelvins off that of the constants: the sensitivity changes by its coefficient, the output at rest
    /// only with resistances that drift.
    pub fn output_at(&self, x: f64, mass: &ProofMass, temperature: f64) -> Option<f64> {
        let rest = self.output(0.0, mass).unwrap_or(0.0);
        let change = self.output(x, mass)? - rest;
        Some(match *self {
            Self::SeriesGauges {
                drift,
                temperature: gauge,
                compensated,
                ..
            } => {
                let resistance = if compensated {
                    1.0
                } else {
                    1.0 + drift * temperature
                };
                resistance * (rest + (1.0 + gauge * temperature) * change)
            }
            _ => rest + (1.0 + self.temperature_coefficient() * temperature) * change,
        })
    }

    /// The relation of a plate has no inverse in closed form, but rises everywhere: halved until no number lies between.
    fn plate_displacement(&self, output: f64, mass: &ProofMass) -> Option<f64> {
        let reach = self.reach();
        let (mut low, mut high) = (-reach, reach);
        if !output.is_finite() || output < self.output(low * (1.0 - 1e-15), mass)? {
            return None;
        }
        for _ in 0..2000 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            match self.output(middle, mass) {
                Some(v) if v <= output => low = middle,
                _ => high = middle,
            }
        }
        Some(low)
    }

    /// Displacement up to which the relation holds, m.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Comb { gap, .. } => gap,
            Self::AreaComb { overlap, .. } => overlap,
            // Its nearer edge meets the fixed plate.
            Self::Plate { gap, tilt, .. } => gap / (1.0 + tilt),
            // A strain of 1 % breaks silicon and foil alike.
            Self::Bridge {
                strain_per_metre, ..
            }
            | Self::SeriesGauges {
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
            Self::SeriesGauges {
                drift,
                temperature,
                compensated,
                ..
            } => temperature + if compensated { 0.0 } else { drift },
            _ => 0.0,
        }
    }

    /// Unit of the output.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Comb { .. } | Self::AreaComb { .. } | Self::Plate { .. } => "F",
            Self::Resonant { .. } => "Hz",
            Self::Tunnelling { .. } | Self::Shutter { .. } => "A",
            Self::Interferometer { .. } => "rad",
            _ => "V",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS: ProofMass = ProofMass {
        mass: 1e-8,
        stiffness: 10.0,
        damping: 1e-4,
        stop: 1e-6,
    };

    /// A parallel plate: C₀ d/(d − x); one that turns is the mean over its length of that.
    #[test]
    fn known_plates() {
        let of = |tilt| Principle::Plate {
            rest_capacitance: 1e-12,
            gap: 2e-6,
            tilt,
        };
        let x = 0.5e-6;
        let flat = of(0.0).output(x, &MASS).unwrap();
        assert!((flat / (1e-12 * (2.0 / 1.5 - 1.0)) - 1.0).abs() < 1e-12);
        let (u, n) = (0.6, 10_000);
        let mean: f64 = (0..n)
            .map(|k| 2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0)
            .map(|s| 2e-6 / (2e-6 - x * (1.0 + u * s)))
            .sum::<f64>()
            / f64::from(n);
        let tilted = of(u).output(x, &MASS).unwrap();
        assert!(
            (tilted / (1e-12 * (mean - 1.0)) - 1.0).abs() < 1e-7,
            "{tilted} {mean}"
        );
        for tilt in [0.0, 1e-6, u] {
            let p = of(tilt);
            for share in [-0.99, -0.3, 1e-7, 0.5, 0.99] {
                let x = share * p.reach();
                let back = p.displacement(p.output(x, &MASS).unwrap(), &MASS).unwrap();
                assert!((back - x).abs() < 1e-9 * p.reach(), "{tilt} {x} {back}");
            }
            assert_eq!(p.displacement(f64::NAN, &MASS), None);
            assert_eq!(p.displacement(-1e-11, &MASS), None);
        }
    }

    #[test]
    fn known_area_comb_is_linear() {
        let p = Principle::AreaComb {
            rest_capacitance: 1e-12,
            overlap: 50e-6,
        };
        assert!((p.output(5e-6, &MASS).unwrap() / 0.2e-12 - 1.0).abs() < 1e-12);
        assert_eq!(p.output(60e-6, &MASS), None);
    }

    /// The gauge that is not strained takes the drift of all resistances away, not that of the gauge factor.
    #[test]
    fn known_drift_and_its_compensation() {
        let of = |compensated| Principle::SeriesGauges {
            gauge_factor: 100.0,
            strain_per_metre: 1000.0,
            active: 2.0,
            resistance: 2e3,
            current: 1e-3,
            mismatch: 0.01,
            drift: 2e-3,
            temperature: -1e-3,
            compensated,
        };
        let x = 1e-7;
        // IR = 2 V; nKε = 0.02.
        let cold = of(false).output(x, &MASS).unwrap();
        assert!((cold / 0.06 - 1.0).abs() < 1e-12);
        let warm = of(false).output_at(x, &MASS, 10.0).unwrap();
        assert!((warm / (2.0 * 1.02 * (0.02 * 0.99 + 0.01)) - 1.0).abs() < 1e-12);
        let held = of(true).output_at(x, &MASS, 10.0).unwrap();
        assert!((held / (2.0 * (0.02 * 0.99 + 0.01)) - 1.0).abs() < 1e-12);
        let rest = |c| of(c).output_at(0.0, &MASS, 10.0).unwrap();
        assert!(
            (rest(true) / 0.02 - 1.0).abs() < 1e-12 && (rest(false) / 0.0204 - 1.0).abs() < 1e-12
        );
    }
}
