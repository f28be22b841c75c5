//! What a device is made of, key by key.

use super::build::{Damping, finite, positive};
use crate::trouble::Result;
use proofmass_rig::{Beam, BridgeArms, PiezoCut};
use serde::{Deserialize, Serialize};

fn one() -> f64 {
    1.0
}

fn atmosphere() -> f64 {
    101.325
}

fn yes() -> bool {
    true
}

/// Declares the keys of a device: its own, and those of groups that several have. `spring` is a mass on springs, `beam` a beam, `gauges`
/// what its gauges are of, `gas` a gap with gas that may damp.
macro_rules! device_table {
    ($(#[$doc:meta])* struct $name:ident: [$($group:ident)*] { $($own:tt)* }) => {
        device_table!(@ [$($group)*] [$(#[$doc])*] $name { } { $($own)* });
    };
    (@ [spring $($rest:ident)*] $doc:tt $name:ident { $($first:tt)* } { $($own:tt)* }) => {
        device_table!(@ [$($rest)*] $doc $name {
            $($first)*
            /// Proof mass, µg.
            pub mass_ug: f64,
            /// Stiffness of its springs, N/m.
            pub stiffness_N_per_m: f64,
        } { $($own)* });

        impl $name {
            /// Mass in kg and stiffness in N/m.
            pub(super) fn spring(&self) -> Result<(f64, f64)> {
                Ok((
                    1e-9 * positive("mass_ug", self.mass_ug)?,
                    positive("stiffness_N_per_m", self.stiffness_N_per_m)?,
                ))
            }
        }
    };
    (@ [beam $($rest:ident)*] $doc:tt $name:ident { $($first:tt)* } { $($own:tt)* }) => {
        device_table!(@ [$($rest)*] $doc $name {
            $($first)*
            /// Length of the beam, µm.
            pub beam_length_um: f64,
            /// Width of the beam, µm.
            pub beam_width_um: f64,
            /// Thickness of the beam along its motion, µm.
            pub beam_thickness_um: f64,
            /// Young's modulus, GPa.
            pub young_GPa: f64,
            /// Density, kg/m³.
            pub density_kg_per_m3: f64,
        } { $($own)* });

        impl $name {
            pub(super) fn beam(&self) -> Result<Beam> {
                let beam = Beam {
                    length: 1e-6 * self.beam_length_um,
                    width: 1e-6 * self.beam_width_um,
                    thickness: 1e-6 * self.beam_thickness_um,
                    young: 1e9 * self.young_GPa,
                    density: self.density_kg_per_m3,
                };
                beam.check()?;
                Ok(beam)
            }
        }
    };
    (@ [gauges] $doc:tt $name:ident { $($first:tt)* } { $($own:tt)* }) => {
        device_table!(@ [] $doc $name { $($first)* } {
            /// Poisson's ratio of the gauges.
            pub poisson: f64,
            /// (Δρ/ρ)/ε of the gauges: relative change of the resistivity per strain.
            #[serde(default)]
            pub piezoresistance: f64,
            /// Relative change of the gauge factor, 1/K.
            #[serde(default)]
            pub temperature_per_K: f64,
            $($own)*
        });

        impl $name {
            /// 1 + 2ν + (Δρ/ρ)/ε.
            pub(super) fn gauge_factor(&self) -> Result<f64> {
                let shape = 1.0 + 2.0 * finite("poisson", self.poisson)?;
                Ok(shape + finite("piezoresistance", self.piezoresistance)?)
            }
        }
    };
    (@ [gas] $doc:tt $name:ident { $($first:tt)* } { $($own:tt)* }) => {
        device_table!(@ [] $doc $name { $($first)* } {
            $($own)*
            /// Relative permittivity of the gas.
            #[serde(default = "one")]
            pub permittivity: f64,
            /// Damping ratio.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub damping_ratio: Option<f64>,
            /// Viscosity of the gas in the gap, µPa·s, in place of a damping ratio.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub viscosity_uPa_s: Option<f64>,
            /// Pressure of the gas, kPa.
            #[serde(default = "atmosphere")]
            pub pressure_kPa: f64,
        });

        impl $name {
            pub(super) fn damping(&self) -> Damping {
                Damping {
                    ratio: self.damping_ratio,
                    viscosity: self.viscosity_uPa_s,
                    pressure: self.pressure_kPa,
                }
            }
        }
    };
    (@ [] [$(#[$doc:meta])*] $name:ident { $($first:tt)* } { $($own:tt)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        #[allow(non_snake_case)]
        pub struct $name {
            $($first)*
            $($own)*
        }
    };
}

device_table! {
    /// Fingers of a mass between fixed ones.
    struct CombTable: [spring gas] {
        /// Fingers of the mass, each with a fixed one on either side.
        pub fingers: f64,
        /// Length over which a finger faces a fixed one, µm.
        pub overlap_um: f64,
        /// Thickness of the fingers, µm.
        pub thickness_um: f64,
        /// Gap on either side, µm.
        pub gap_um: f64,
        /// Displacement at which it meets its stop, µm; three quarters of the gap, or half of the overlap, without it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_um: Option<f64>,
    }
}

device_table! {
    /// A plate on a spring.
    struct PlateTable: [spring gas] {
        /// Length of the plate, µm.
        pub length_um: f64,
        /// Width of the plate, µm.
        pub width_um: f64,
        /// Gap to the fixed plate, µm.
        pub gap_um: f64,
        /// Displacement at which it meets its stop, µm; half of the gap without it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_um: Option<f64>,
    }
}

device_table! {
    /// A plate at the end of a cantilever of the same material.
    struct CantileverTable: [beam gas] {
        /// Length of the plate, µm.
        pub plate_length_um: f64,
        /// Width of the plate, µm.
        pub plate_width_um: f64,
        /// Thickness of the plate, µm.
        pub plate_thickness_um: f64,
        /// Gap to the fixed plate, µm.
        pub gap_um: f64,
        /// Displacement of the centre of the plate at its stop, µm; half of the gap without it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_um: Option<f64>,
    }
}

device_table! {
    /// Gauges in a bridge.
    struct GaugeTable: [beam gauges] {
        /// Mass at the end of the cantilever, µg; 33/140 of the beam is added.
        pub mass_ug: f64,
        /// Distance of the middle of the gauges from the root, µm.
        #[serde(default)]
        pub gauge_at_um: f64,
        /// Arms of the bridge with gauges.
        pub arms: BridgeArms,
        /// Excitation, V.
        pub excitation_V: f64,
        /// Damping ratio.
        pub damping_ratio: f64,
        /// Displacement at which it meets its stop, µm.
        pub stop_um: f64,
    }
}

device_table! {
    /// Five resistors in series.
    struct SeriesTable: [beam gauges] {
        /// Mass between four beams, µg; 13/35 of each is added.
        pub mass_ug: f64,
        /// Distance of the middle of the gauges from the outer end of the beams, µm.
        #[serde(default)]
        pub gauge_at_um: f64,
        /// Resistance of each, kΩ.
        pub resistance_kOhm: f64,
        /// Current through all of them, mA.
        pub current_mA: f64,
        /// Sum of the relative differences of the four from the fifth at rest, %.
        #[serde(default)]
        pub mismatch_percent: f64,
        /// Relative change of all resistances, 1/K.
        #[serde(default)]
        pub drift_per_K: f64,
        /// Whether the voltages are taken relative to that of the fifth, which takes the drift away.
        #[serde(default = "yes")]
        pub compensated: bool,
        /// Damping ratio.
        pub damping_ratio: f64,
        /// Displacement at which it meets its stop, µm.
        pub stop_um: f64,
    }
}

device_table! {
    /// Piezoelectric elements and what they are wired to.
    struct PiezoTable: [] {
        /// How the mass loads them.
        pub cut: PiezoCut,
        /// Proof mass, g.
        pub mass_g: f64,
        /// Charge constant, d₃₃ of a compressed, d₁₅ of a sheared element, pC/N.
        pub charge_pC_per_N: f64,
        /// Area of the electrodes of one, mm².
        pub area_mm2: f64,
        /// Thickness of one, mm.
        pub thickness_mm: f64,
        /// Relative permittivity.
        pub permittivity: f64,
        /// Young's modulus of a compressed, shear modulus of a sheared element, GPa.
        pub modulus_GPa: f64,
        /// Number of elements.
        #[serde(default = "one")]
        pub elements: f64,
        /// Capacitance of cable and amplifier, pF.
        #[serde(default)]
        pub cable_pF: f64,
        /// Resistance of all that leaks, GΩ.
        pub leak_GOhm: f64,
        /// Relative change of the charge constant, 1/K.
        #[serde(default)]
        pub temperature_per_K: f64,
        /// Damping ratio.
        pub damping_ratio: f64,
        /// Displacement at which it counts as overloaded, µm; a ten-thousandth of the thickness without it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_um: Option<f64>,
    }
}

device_table! {
    /// Heated gas in a cavity.
    struct ThermalTable: [] {
        /// Length of the cavity, mm.
        pub cavity_mm: f64,
        /// Temperature of the heater above that of the gas, K.
        pub heater_K: f64,
        /// Temperature of the gas, K.
        pub gas_K: f64,
        /// Kinematic viscosity of the gas, mm²/s.
        pub viscosity_mm2_per_s: f64,
        /// Thermal diffusivity of the gas, mm²/s.
        pub diffusivity_mm2_per_s: f64,
        /// Difference of temperature between the two resistors over that of the heater, per Grashof number: of the shape, from a measurement.
        pub response: f64,
        /// Temperature coefficient of the resistors, 1/K.
        pub resistors_per_K: f64,
        /// Excitation of the bridge, V.
        pub excitation_V: f64,
        /// Relative change of the sensitivity, 1/K.
        #[serde(default)]
        pub temperature_per_K: f64,
        /// Greatest acceleration, m/s².
        pub range_m_per_s2: f64,
    }
}

device_table! {
    /// A mass that pulls at a resonating beam, clamped at both ends.
    struct ResonantTable: [spring beam] {
        /// Axial force in the beam over the force of the mass.
        #[serde(default = "one")]
        pub lever: f64,
        /// Damping ratio of the mass.
        pub damping_ratio: f64,
        /// Displacement at which it meets its stop, µm.
        pub stop_um: f64,
    }
}

device_table! {
    /// A mass with a tip above an electrode.
    struct TunnellingTable: [spring] {
        /// Current at rest, nA.
        pub current_nA: f64,
        /// Height of the barrier, eV.
        pub barrier_eV: f64,
        /// Gap at rest, nm: the tip meets the electrode there.
        pub gap_nm: f64,
        /// Damping ratio.
        pub damping_ratio: f64,
    }
}

device_table! {
    /// A mass with an edge in a beam of light.
    struct ShutterTable: [spring] {
        /// Power of the whole beam, mW.
        pub power_mW: f64,
        /// Responsivity of the diode, A/W.
        pub responsivity_A_per_W: f64,
        /// Width of the beam of light, µm.
        pub width_um: f64,
        /// Damping ratio.
        pub damping_ratio: f64,
        /// Displacement at which it meets its stop, µm; four tenths of the width without it.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub stop_um: Option<f64>,
    }
}
