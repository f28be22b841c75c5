//! A transducer by what it is made of: sizes, materials and circuit in place of a natural frequency and a damping ratio.

use crate::campaign::CampaignFile;
use crate::trouble::{Result, Trouble};
use proofmass_fixture::thirds_of_octave;
use proofmass_io::Table;
use proofmass_rig::{
    Beam, BridgeArms, PiezoCut, PiezoElement, Principle, ProofMass, SqueezeFilm, Transducer,
    plate_capacitance,
};
use proofmass_uncertainty::{Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

/// A device by its construction, with standard uncertainties.
///
/// ```
/// use proofmass_jobs::simulate::TransducerConstruction;
/// // A plate of 1 mm × 1 mm, 2 µm above the fixed one: C₀ = 4.43 pF, S = C₀ m/(k d).
/// let text = r#"{"device": {"principle": "capacitive-plate", "mass_ug": 20, "stiffness_N_per_m": 20, "length_um": 1000,
///     "width_um": 1000, "gap_um": 2, "damping_ratio": 0.7}, "uncertainty": {"gap_um": 0.02}}"#;
/// let device: TransducerConstruction = serde_json::from_str(text)?;
/// let figures = device.figures()?;
/// let s = figures.get("sensitivity").unwrap();
/// assert!((s.value / 2.2135e-3 - 1.0).abs() < 1e-3 && s.unit == "pF/(m/s²)");
/// // S falls with the square of the gap: 1 % of gap is 2 %.
/// assert!((s.standard_uncertainty / s.value / 0.02 - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct TransducerConstruction {
    /// What it is called.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Principle and parameters.
    pub device: DeviceConstruction,
    /// Standard uncertainties by the key of the parameter, in its unit.
    #[serde(default)]
    pub uncertainty: BTreeMap<String, f64>,
}

/// What a device is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "principle", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DeviceConstruction {
    /// Differential comb whose gaps vary.
    CapacitiveGap(CombTable),
    /// Differential comb whose area varies.
    CapacitiveArea(CombTable),
    /// One plate against a fixed one.
    CapacitivePlate(PlateTable),
    /// A plate at the end of a cantilever, which turns as it bends.
    CapacitiveCantilever(CantileverTable),
    /// Gauges on a cantilever, in a Wheatstone bridge.
    PiezoresistiveBridge(GaugeTable),
    /// Four gauges on four beams and a fifth without strain, in series.
    PiezoresistiveSeries(SeriesTable),
    /// Piezoelectric elements, compressed or sheared.
    Piezoelectric(PiezoTable),
    /// Heated gas between two resistors.
    Thermal(ThermalTable),
    /// A beam whose frequency the mass changes.
    Resonant(ResonantTable),
    /// A tunnel current.
    Tunnelling(TunnellingTable),
    /// Light past an edge.
    Shutter(ShutterTable),
}

/// What damps a mass: a stated ratio, or the gas in its gaps.
#[derive(Default)]
struct Damping {
    ratio: Option<f64>,
    viscosity: Option<f64>,
    pressure: f64,
}

fn one() -> f64 {
    1.0
}

fn atmosphere() -> f64 {
    101.325
}

fn yes() -> bool {
    true
}

/// Fingers of a mass between fixed ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct CombTable {
    /// Proof mass, µg.
    pub mass_ug: f64,
    /// Stiffness of its springs, N/m.
    pub stiffness_N_per_m: f64,
    /// Fingers of the mass, each with a fixed one on either side.
    pub fingers: f64,
    /// Length over which a finger faces a fixed one, µm.
    pub overlap_um: f64,
    /// Thickness of the fingers, µm.
    pub thickness_um: f64,
    /// Gap on either side, µm.
    pub gap_um: f64,
    /// Relative permittivity of the gas.
    #[serde(default = "one")]
    pub permittivity: f64,
    /// Damping ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_ratio: Option<f64>,
    /// Viscosity of the gas in the gaps, µPa·s, in place of a damping ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscosity_uPa_s: Option<f64>,
    /// Pressure of the gas, kPa.
    #[serde(default = "atmosphere")]
    pub pressure_kPa: f64,
    /// Displacement at which it meets its stop, µm; three quarters of the gap, or half of the overlap, without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_um: Option<f64>,
}

/// A plate on a spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct PlateTable {
    /// Proof mass, µg.
    pub mass_ug: f64,
    /// Stiffness of its springs, N/m.
    pub stiffness_N_per_m: f64,
    /// Length of the plate, µm.
    pub length_um: f64,
    /// Width of the plate, µm.
    pub width_um: f64,
    /// Gap to the fixed plate, µm.
    pub gap_um: f64,
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
    /// Displacement at which it meets its stop, µm; half of the gap without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_um: Option<f64>,
}

/// A plate at the end of a cantilever of the same material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct CantileverTable {
    /// Length of the beam, µm.
    pub beam_length_um: f64,
    /// Width of the beam, µm.
    pub beam_width_um: f64,
    /// Thickness of the beam, µm.
    pub beam_thickness_um: f64,
    /// Young's modulus, GPa.
    pub young_GPa: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
    /// Length of the plate, µm.
    pub plate_length_um: f64,
    /// Width of the plate, µm.
    pub plate_width_um: f64,
    /// Thickness of the plate, µm.
    pub plate_thickness_um: f64,
    /// Gap to the fixed plate, µm.
    pub gap_um: f64,
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
    /// Displacement of the centre of the plate at its stop, µm; half of the gap without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_um: Option<f64>,
}

/// Gauges in a bridge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct GaugeTable {
    /// Mass at the end of the cantilever, µg; 33/140 of the beam is added.
    pub mass_ug: f64,
    /// Length of the beam, µm.
    pub beam_length_um: f64,
    /// Width of the beam, µm.
    pub beam_width_um: f64,
    /// Thickness of the beam, µm.
    pub beam_thickness_um: f64,
    /// Young's modulus, GPa.
    pub young_GPa: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
    /// Distance of the middle of the gauges from the root, µm.
    #[serde(default)]
    pub gauge_at_um: f64,
    /// Poisson's ratio of the gauges.
    pub poisson: f64,
    /// (Δρ/ρ)/ε of the gauges: relative change of the resistivity per strain.
    #[serde(default)]
    pub piezoresistance: f64,
    /// Arms of the bridge with gauges.
    pub arms: BridgeArms,
    /// Excitation, V.
    pub excitation_V: f64,
    /// Relative change of the gauge factor, 1/K.
    #[serde(default)]
    pub temperature_per_K: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Displacement at which it meets its stop, µm.
    pub stop_um: f64,
}

/// Five resistors in series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct SeriesTable {
    /// Mass between four beams, µg; 13/35 of each is added.
    pub mass_ug: f64,
    /// Length of a beam, µm.
    pub beam_length_um: f64,
    /// Width of a beam, µm.
    pub beam_width_um: f64,
    /// Thickness of a beam, µm.
    pub beam_thickness_um: f64,
    /// Young's modulus, GPa.
    pub young_GPa: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
    /// Distance of the middle of the gauges from the outer end of the beams, µm.
    #[serde(default)]
    pub gauge_at_um: f64,
    /// Poisson's ratio of the gauges.
    pub poisson: f64,
    /// (Δρ/ρ)/ε of the gauges.
    #[serde(default)]
    pub piezoresistance: f64,
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
    /// Relative change of the gauge factor, 1/K.
    #[serde(default)]
    pub temperature_per_K: f64,
    /// Whether the voltages are taken relative to that of the fifth, which takes the drift away.
    #[serde(default = "yes")]
    pub compensated: bool,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Displacement at which it meets its stop, µm.
    pub stop_um: f64,
}

/// Piezoelectric elements and what they are wired to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct PiezoTable {
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

/// Heated gas in a cavity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct ThermalTable {
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

/// A mass that pulls at a resonating beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct ResonantTable {
    /// Proof mass, µg.
    pub mass_ug: f64,
    /// Stiffness of its springs with the beam, N/m.
    pub stiffness_N_per_m: f64,
    /// Axial force in the beam over the force of the mass.
    #[serde(default = "one")]
    pub lever: f64,
    /// Length of the beam, clamped at both ends, µm.
    pub beam_length_um: f64,
    /// Width of the beam, µm.
    pub beam_width_um: f64,
    /// Thickness of the beam along its vibration, µm.
    pub beam_thickness_um: f64,
    /// Young's modulus, GPa.
    pub young_GPa: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
    /// Damping ratio of the mass.
    pub damping_ratio: f64,
    /// Displacement at which it meets its stop, µm.
    pub stop_um: f64,
}

/// A mass with a tip above an electrode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct TunnellingTable {
    /// Proof mass, µg.
    pub mass_ug: f64,
    /// Stiffness of its springs, N/m.
    pub stiffness_N_per_m: f64,
    /// Current at rest, nA.
    pub current_nA: f64,
    /// Height of the barrier, eV.
    pub barrier_eV: f64,
    /// Gap at rest, nm: the tip meets the electrode there.
    pub gap_nm: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

/// A mass with an edge in a beam of light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct ShutterTable {
    /// Proof mass, µg.
    pub mass_ug: f64,
    /// Stiffness of its springs, N/m.
    pub stiffness_N_per_m: f64,
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

/// Unit of a key by how it ends, longest first.
const UNITS: [(&str, &str); 28] = [
    ("_mm2_per_s", "mm²/s"),
    ("_kg_per_m3", "kg/m³"),
    ("_m_per_s2", "m/s²"),
    ("_pC_per_N", "pC/N"),
    ("_N_per_m", "N/m"),
    ("_A_per_W", "A/W"),
    ("_percent", "%"),
    ("_uPa_s", "µPa·s"),
    ("_per_K", "1/K"),
    ("_GOhm", "GΩ"),
    ("_kOhm", "kΩ"),
    ("_mm2", "mm²"),
    ("_GPa", "GPa"),
    ("_kPa", "kPa"),
    ("_um", "µm"),
    ("_nm", "nm"),
    ("_mm", "mm"),
    ("_ug", "µg"),
    ("_pF", "pF"),
    ("_mA", "mA"),
    ("_nA", "nA"),
    ("_mW", "mW"),
    ("_eV", "eV"),
    ("_g", "g"),
    ("_V", "V"),
    ("_K", "K"),
    ("_A", "A"),
    ("", "1"),
];

fn unit_of(key: &str) -> &'static str {
    let known = UNITS.iter().find(|(end, _)| key.ends_with(end));
    known.map_or("1", |(_, unit)| unit)
}

fn positive(name: &str, value: f64) -> Result<f64> {
    match value.is_finite() && value > 0.0 {
        true => Ok(value),
        false => Err(Trouble::request(format!(
            "`{name}` = {value} of the device: it must be a positive number"
        ))),
    }
}

fn finite(name: &str, value: f64) -> Result<f64> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(Trouble::request(format!(
            "`{name}` of the device must be a finite number"
        ))),
    }
}

/// Stiffness, mass, and what damps it: the ratio, or the coefficient of the gas, whose cut-off the natural frequency must lie below.
fn front(
    (mass, stiffness, stop): (f64, f64, f64),
    damping: &Damping,
    film: impl Fn(f64) -> Result<(f64, Option<f64>)>,
) -> Result<ProofMass> {
    let mut front = ProofMass {
        mass,
        stiffness,
        damping: 0.0,
        stop,
    };
    match (damping.ratio, damping.viscosity) {
        (Some(ratio), None) => {
            let ratio = positive("damping_ratio", ratio)?;
            front.damping = 2.0 * ratio * (stiffness * mass).sqrt();
        }
        (None, Some(viscosity)) => {
            let (damping, cut_off) = film(1e-6 * positive("viscosity_uPa_s", viscosity)?)?;
            front.damping = damping;
            let natural = front.natural_frequency();
            if let Some(cut_off) = cut_off.filter(|f| *f < natural) {
                return Err(Trouble::request(format!(
                    "the gas in the gap is compressed from {cut_off:.0} Hz on, below the natural frequency of {natural:.0} Hz: it is a \
                     spring there and no damper"
                ))
                .with_hint("give a wider gap, a smaller plate or a higher pressure, or state damping_ratio"));
            }
        }
        _ => {
            return Err(
                Trouble::request("the damping of the device is given twice or not at all")
                    .with_hint("give either damping_ratio or viscosity_uPa_s"),
            );
        }
    }
    Ok(front)
}

fn given(ratio: f64) -> Damping {
    Damping {
        ratio: Some(ratio),
        ..Damping::default()
    }
}

/// A damping that is stated has no film.
fn no_film(_: f64) -> Result<(f64, Option<f64>)> {
    Ok((0.0, None))
}

fn beam(um: [f64; 3], young_gpa: f64, density: f64) -> Result<Beam> {
    let [length, width, thickness] = um.map(|v| 1e-6 * v);
    let beam = Beam {
        length,
        width,
        thickness,
        young: 1e9 * young_gpa,
        density,
    };
    beam.check()?;
    Ok(beam)
}

/// 1 + 2ν + (Δρ/ρ)/ε.
fn gauge_factor(poisson: f64, piezoresistance: f64) -> Result<f64> {
    Ok(1.0 + 2.0 * finite("poisson", poisson)? + finite("piezoresistance", piezoresistance)?)
}

impl DeviceConstruction {
    /// The device it makes.
    ///
    /// # Errors
    /// A parameter that no device has.
    pub fn build(&self) -> Result<Transducer> {
        let (mass, principle, name) = match self {
            Self::CapacitiveGap(t) => (t.front(true)?, t.gap()?, "capacitive, varying gap"),
            Self::CapacitiveArea(t) => (t.front(false)?, t.area()?, "capacitive, varying area"),
            Self::CapacitivePlate(t) => {
                let [a, b, d] = plate(t.length_um, t.width_um, t.gap_um)?;
                let damping = Damping {
                    ratio: t.damping_ratio,
                    viscosity: t.viscosity_uPa_s,
                    pressure: t.pressure_kPa,
                };
                let m = 1e-9 * positive("mass_ug", t.mass_ug)?;
                let k = positive("stiffness_N_per_m", t.stiffness_N_per_m)?;
                let stop = stop(t.stop_um, 0.5 * d)?;
                let mass = front((m, k, stop), &damping, |v| squeezed([a, b, d], v, &damping))?;
                let principle = Principle::Plate {
                    rest_capacitance: plate_capacitance(
                        positive("permittivity", t.permittivity)?,
                        a * b,
                        d,
                    ),
                    gap: d,
                    tilt: 0.0,
                };
                (mass, principle, "capacitive, one plate")
            }
            Self::CapacitiveCantilever(t) => {
                let beam = beam(
                    [t.beam_length_um, t.beam_width_um, t.beam_thickness_um],
                    t.young_GPa,
                    t.density_kg_per_m3,
                )?;
                let [a, b, d] = plate(t.plate_length_um, t.plate_width_um, t.gap_um)?;
                let thick = 1e-6 * positive("plate_thickness_um", t.plate_thickness_um)?;
                let held = beam.tip_plate(a);
                let m = beam.density * a * b * thick + 33.0 / 140.0 * beam.mass();
                let damping = Damping {
                    ratio: t.damping_ratio,
                    viscosity: t.viscosity_uPa_s,
                    pressure: t.pressure_kPa,
                };
                let tilt = 0.5 * a * held.turn;
                let stop = stop(t.stop_um, 0.5 * d / (1.0 + tilt))?;
                let mass = front((m, held.stiffness, stop), &damping, |v| {
                    squeezed([a, b, d], v, &damping)
                })?;
                let principle = Principle::Plate {
                    rest_capacitance: plate_capacitance(
                        positive("permittivity", t.permittivity)?,
                        a * b,
                        d,
                    ),
                    gap: d,
                    tilt,
                };
                (mass, principle, "capacitive, plate on a cantilever")
            }
            Self::PiezoresistiveBridge(t) => {
                let beam = beam(
                    [t.beam_length_um, t.beam_width_um, t.beam_thickness_um],
                    t.young_GPa,
                    t.density_kg_per_m3,
                )?;
                let m = 1e-9 * positive("mass_ug", t.mass_ug)? + 33.0 / 140.0 * beam.mass();
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let mass = front(
                    (m, beam.cantilever(), stop),
                    &given(t.damping_ratio),
                    no_film,
                )?;
                let strain = beam.cantilever_strain(1e-6 * finite("gauge_at_um", t.gauge_at_um)?);
                let principle = Principle::Bridge {
                    gauge_factor: gauge_factor(t.poisson, t.piezoresistance)?,
                    strain_per_metre: positive("strain of the gauges per metre", strain)?,
                    arms: t.arms,
                    excitation: positive("excitation_V", t.excitation_V)?,
                    temperature: finite("temperature_per_K", t.temperature_per_K)?,
                };
                (mass, principle, "piezoresistive, bridge on a cantilever")
            }
            Self::PiezoresistiveSeries(t) => {
                let beam = beam(
                    [t.beam_length_um, t.beam_width_um, t.beam_thickness_um],
                    t.young_GPa,
                    t.density_kg_per_m3,
                )?;
                let m = 1e-9 * positive("mass_ug", t.mass_ug)? + 4.0 * 13.0 / 35.0 * beam.mass();
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let mass = front(
                    (m, 4.0 * beam.guided(), stop),
                    &given(t.damping_ratio),
                    no_film,
                )?;
                let strain = beam.guided_strain(1e-6 * finite("gauge_at_um", t.gauge_at_um)?);
                let principle = Principle::SeriesGauges {
                    gauge_factor: gauge_factor(t.poisson, t.piezoresistance)?,
                    strain_per_metre: positive("strain of the gauges per metre", strain)?,
                    active: 4.0,
                    resistance: 1e3 * positive("resistance_kOhm", t.resistance_kOhm)?,
                    current: 1e-3 * positive("current_mA", t.current_mA)?,
                    mismatch: 1e-2 * finite("mismatch_percent", t.mismatch_percent)?,
                    drift: finite("drift_per_K", t.drift_per_K)?,
                    temperature: finite("temperature_per_K", t.temperature_per_K)?,
                    compensated: t.compensated,
                };
                (mass, principle, "piezoresistive, five resistors in series")
            }
            Self::Piezoelectric(t) => {
                let element = PiezoElement {
                    cut: t.cut,
                    coefficient: 1e-12 * t.charge_pC_per_N,
                    area: 1e-6 * t.area_mm2,
                    thickness: 1e-3 * t.thickness_mm,
                    permittivity: t.permittivity,
                    modulus: 1e9 * t.modulus_GPa,
                    elements: t.elements,
                };
                element.check()?;
                let cable = 1e-12 * finite("cable_pF", t.cable_pF)?;
                if cable < 0.0 {
                    return Err(Trouble::request("`cable_pF` of the device is negative"));
                }
                let m = 1e-3 * positive("mass_g", t.mass_g)?;
                let stop = stop(t.stop_um, 1e-4 * element.thickness)?;
                let mass = front(
                    (m, element.stiffness(), stop),
                    &given(t.damping_ratio),
                    no_film,
                )?;
                let principle = Principle::Piezoelectric {
                    charge_coefficient: element.charge(),
                    capacitance: element.capacitance() + cable,
                    resistance: 1e9 * positive("leak_GOhm", t.leak_GOhm)?,
                    temperature: finite("temperature_per_K", t.temperature_per_K)?,
                };
                let name = match t.cut {
                    PiezoCut::Compression => "piezoelectric, compression",
                    PiezoCut::Shear => "piezoelectric, shear",
                };
                (mass, principle, name)
            }
            Self::Thermal(t) => {
                let length = 1e-3 * positive("cavity_mm", t.cavity_mm)?;
                let viscosity = 1e-6 * positive("viscosity_mm2_per_s", t.viscosity_mm2_per_s)?;
                let spread = 1e-6 * positive("diffusivity_mm2_per_s", t.diffusivity_mm2_per_s)?;
                let heater = positive("heater_K", t.heater_K)?;
                // Gr = βΔT L³ a/ν² with β = 1/T of an ideal gas.
                let grashof =
                    heater / positive("gas_K", t.gas_K)? * length.powi(3) / viscosity.powi(2);
                let difference = positive("response", t.response)? * grashof * heater;
                let sensitivity = 0.25
                    * positive("excitation_V", t.excitation_V)?
                    * positive("resistors_per_K", t.resistors_per_K)?
                    * difference;
                // The gas has no proof mass; its first order lies far below this one's resonance.
                let time_constant = length.powi(2) / (PI.powi(2) * spread);
                let mass = ProofMass::of(1e-9, 100.0 / time_constant, 0.7, 1.0);
                let range = positive("range_m_per_s2", t.range_m_per_s2)?;
                let stop = mass.static_displacement(range);
                let principle = Principle::Thermal {
                    sensitivity,
                    time_constant,
                    temperature: finite("temperature_per_K", t.temperature_per_K)?,
                };
                (ProofMass { stop, ..mass }, principle, "thermal convective")
            }
            Self::Resonant(t) => {
                let beam = beam(
                    [t.beam_length_um, t.beam_width_um, t.beam_thickness_um],
                    t.young_GPa,
                    t.density_kg_per_m3,
                )?;
                let m = 1e-9 * positive("mass_ug", t.mass_ug)?;
                let k = positive("stiffness_N_per_m", t.stiffness_N_per_m)?;
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let principle = Principle::Resonant {
                    frequency: beam.clamped_frequency(),
                    per_metre: beam.pull() * positive("lever", t.lever)? * k,
                };
                let mass = front((m, k, stop), &given(t.damping_ratio), no_film)?;
                (mass, principle, "resonant beam")
            }
            Self::Tunnelling(t) => {
                let m = 1e-9 * positive("mass_ug", t.mass_ug)?;
                let k = positive("stiffness_N_per_m", t.stiffness_N_per_m)?;
                let gap = 1e-9 * positive("gap_nm", t.gap_nm)?;
                let principle = Principle::Tunnelling {
                    current: 1e-9 * positive("current_nA", t.current_nA)?,
                    barrier: positive("barrier_eV", t.barrier_eV)?,
                };
                let mass = front((m, k, gap), &given(t.damping_ratio), no_film)?;
                (mass, principle, "tunnelling")
            }
            Self::Shutter(t) => {
                let m = 1e-9 * positive("mass_ug", t.mass_ug)?;
                let k = positive("stiffness_N_per_m", t.stiffness_N_per_m)?;
                let width = 1e-6 * positive("width_um", t.width_um)?;
                let stop = stop(t.stop_um, 0.4 * width)?;
                let principle = Principle::Shutter {
                    photocurrent: 1e-3
                        * positive("power_mW", t.power_mW)?
                        * positive("responsivity_A_per_W", t.responsivity_A_per_W)?,
                    width,
                };
                let mass = front((m, k, stop), &given(t.damping_ratio), no_film)?;
                (mass, principle, "optical, shutter")
            }
        };
        Ok(Transducer::new(name, mass, principle))
    }
}

fn plate(length: f64, width: f64, gap: f64) -> Result<[f64; 3]> {
    Ok([
        1e-6 * positive("length of the plate", length)?,
        1e-6 * positive("width of the plate", width)?,
        1e-6 * positive("gap_um", gap)?,
    ])
}

fn stop(given: Option<f64>, otherwise: f64) -> Result<f64> {
    match given {
        Some(um) => Ok(1e-6 * positive("stop_um", um)?),
        None => Ok(otherwise),
    }
}

/// Damping and cut-off of the gas under a plate.
fn squeezed(
    [length, width, gap]: [f64; 3],
    viscosity: f64,
    damping: &Damping,
) -> Result<(f64, Option<f64>)> {
    let film = SqueezeFilm {
        length,
        width,
        gap,
        viscosity,
        pressure: 1e3 * positive("pressure_kPa", damping.pressure)?,
    };
    Ok((film.damping()?, Some(film.cut_off()?)))
}

impl CombTable {
    fn capacitance(&self) -> Result<f64> {
        let area = positive("fingers", self.fingers)?
            * 1e-12
            * positive("overlap_um", self.overlap_um)?
            * positive("thickness_um", self.thickness_um)?;
        let permittivity = positive("permittivity", self.permittivity)?;
        Ok(plate_capacitance(
            permittivity,
            area,
            1e-6 * positive("gap_um", self.gap_um)?,
        ))
    }

    fn gap(&self) -> Result<Principle> {
        Ok(Principle::Comb {
            rest_capacitance: self.capacitance()?,
            gap: 1e-6 * self.gap_um,
        })
    }

    fn area(&self) -> Result<Principle> {
        Ok(Principle::AreaComb {
            rest_capacitance: self.capacitance()?,
            overlap: 1e-6 * self.overlap_um,
        })
    }

    fn front(&self, squeezes: bool) -> Result<ProofMass> {
        let m = 1e-9 * positive("mass_ug", self.mass_ug)?;
        let k = positive("stiffness_N_per_m", self.stiffness_N_per_m)?;
        let gap = 1e-6 * positive("gap_um", self.gap_um)?;
        let overlap = 1e-6 * positive("overlap_um", self.overlap_um)?;
        let stop = stop(
            self.stop_um,
            if squeezes { 0.75 * gap } else { 0.5 * overlap },
        )?;
        let damping = Damping {
            ratio: self.damping_ratio,
            viscosity: self.viscosity_uPa_s,
            pressure: self.pressure_kPa,
        };
        front((m, k, stop), &damping, |viscosity| {
            let film = SqueezeFilm {
                length: overlap,
                width: 1e-6 * positive("thickness_um", self.thickness_um)?,
                gap,
                viscosity,
                pressure: 1e3 * positive("pressure_kPa", damping.pressure)?,
            };
            // Each finger has a film on either side.
            let films = 2.0 * positive("fingers", self.fingers)?;
            match squeezes {
                true => Ok((films * film.damping()?, Some(film.cut_off()?))),
                false => Ok((films * film.sliding()?, None)),
            }
        })
    }
}

impl TransducerConstruction {
    /// Reads a device from a TOML file.
    ///
    /// # Errors
    /// A missing file, an unknown key, a value that no device has.
    pub fn open(path: &Path) -> Result<Self> {
        let source = CampaignFile::open(path)?;
        let construction: Self = source.parse()?;
        construction.figures()?;
        Ok(construction)
    }

    /// The device.
    ///
    /// # Errors
    /// As [`DeviceConstruction::build`].
    pub fn build(&self) -> Result<Transducer> {
        let mut device = self.device.build()?;
        if let Some(name) = &self.name {
            device.name.clone_from(name);
        }
        Ok(device)
    }

    /// The device with one parameter changed.
    fn with(&self, key: &str, value: f64) -> Result<Transducer> {
        let failed = |e: serde_json::Error| Trouble::request(format!("`{key}`: {e}"));
        let mut parameters = serde_json::to_value(&self.device).map_err(failed)?;
        parameters[key] = value.into();
        let changed: DeviceConstruction = serde_json::from_value(parameters).map_err(failed)?;
        changed.build()
    }

    /// Value of a parameter that has an uncertainty.
    fn parameter(&self, key: &str) -> Result<f64> {
        let parameters = serde_json::to_value(&self.device)
            .map_err(|e| Trouble::request(format!("`{key}`: {e}")))?;
        parameters
            .get(key)
            .and_then(serde_json::Value::as_f64)
            .ok_or_else(|| {
                let names: Vec<&str> = parameters
                    .as_object()
                    .into_iter()
                    .flatten()
                    .filter(|(_, v)| v.is_number())
                    .map(|(k, _)| k.as_str())
                    .collect();
                Trouble::request(format!(
                    "`{key}` has an uncertainty, but this device has no such number"
                ))
                .with_hint(format!("its numbers: {}", names.join(", ")))
            })
    }

    /// Components of a device with their covariance: `of` gives their values, derivatives are central differences.
    fn estimate(
        &self,
        components: &[(&str, String)],
        of: impl Fn(&Transducer) -> Option<Vec<f64>>,
    ) -> Result<Estimate> {
        let values = |device: &Transducer| {
            of(device).ok_or_else(|| {
                Trouble::request(
                    "the device has no sensitivity: its output does not follow the acceleration",
                )
            })
        };
        let here = values(&self.build()?)?;
        let mut influences = vec![];
        for (key, &u) in &self.uncertainty {
            let value = self.parameter(key)?;
            if !(u.is_finite() && u >= 0.0) {
                return Err(Trouble::request(format!(
                    "the uncertainty of `{key}` is {u}: a standard uncertainty is not negative"
                )));
            }
            if u == 0.0 {
                continue;
            }
            // Smooth relations: the difference over 10⁻⁴ of a value is exact to 10⁻⁷ and leaves enough digits.
            let step = if value == 0.0 {
                1e-3 * u
            } else {
                1e-4 * value.abs()
            };
            let up = values(&self.with(key, value + step)?)?;
            let down = values(&self.with(key, value - step)?)?;
            let slopes = up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * step));
            influences.push(Influence {
                key: key.clone(),
                description: key.clone(),
                evaluation: Evaluation::B,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Scalar {
                    value,
                    unit: unit_of(key).into(),
                    standard_uncertainty: u,
                    sensitivity: slopes.collect(),
                },
            });
        }
        let components = components
            .iter()
            .zip(here)
            .map(|((name, unit), value)| Component::new(*name, unit.clone(), value))
            .collect();
        Ok(Estimate::new(components, influences)?)
    }

    /// Sensitivity in the unit of the recording, natural frequency, damping ratio, and the corners there are, with their joint
    /// covariance by the law of propagation.
    ///
    /// # Errors
    /// As [`DeviceConstruction::build`]; an uncertainty of a parameter that there is not.
    pub fn figures(&self) -> Result<Estimate> {
        let device = self.build()?;
        let (unit, factor) = recorded_sensitivity(&device);
        let mut components = vec![
            ("sensitivity", format!("{unit}/(m/s²)")),
            ("natural-frequency", "Hz".to_owned()),
            ("damping-ratio", "1".to_owned()),
        ];
        let corners = [device.principle.high_pass(), device.principle.low_pass()];
        for (corner, name) in corners.iter().zip(["lower-corner", "upper-corner"]) {
            if corner.is_some() {
                components.push((name, "Hz".to_owned()));
            }
        }
        self.estimate(&components, |device| {
            let mut values = vec![
                factor * device.sensitivity()?,
                device.mass.natural_frequency(),
                device.mass.damping_ratio(),
            ];
            values.extend(device.principle.high_pass());
            values.extend(device.principle.low_pass());
            Some(values)
        })
    }

    /// Transfer function at thirds of an octave from three times the lower corner, or a thousandth of the natural frequency, to twice the
    /// natural frequency (of the upper corner, where there is one): a table as laboratories have it.
    ///
    /// # Errors
    /// As [`TransducerConstruction::figures`].
    pub(super) fn transfer(&self) -> Result<Table> {
        let device = self.build()?;
        let (unit, factor) = recorded_sensitivity(&device);
        let high = device
            .principle
            .low_pass()
            .unwrap_or(device.mass.natural_frequency());
        let low = device
            .principle
            .high_pass()
            .map_or(1e-3 * high, |f| 3.0 * f);
        let known = !self.uncertainty.is_empty();
        let mut headings = vec![
            "frequency_Hz".to_owned(),
            format!("sensitivity_{unit}/(m/s2)"),
            "phase_deg".to_owned(),
        ];
        if known {
            headings.extend(["u_relative_%".to_owned(), "u_phase_deg".to_owned()]);
        }
        let mut table = Table::new(headings);
        let parts = [("modulus", "1".to_owned()), ("phase", "rad".to_owned())];
        for frequency in thirds_of_octave(low.min(high), 2.0 * high) {
            let point = self.estimate(&parts, |device| {
                let h = device.response(frequency)?;
                Some(vec![factor * h.norm(), h.arg()])
            })?;
            let of = |name: &str| {
                let q = point.get(name);
                q.map_or((0.0, 0.0), |q| (q.value, q.standard_uncertainty))
            };
            let ((modulus, u), (phase, u_phase)) = (of("modulus"), of("phase"));
            let mut row = vec![frequency, modulus, phase.to_degrees()];
            if known {
                row.extend([1e2 * u / modulus, u_phase.to_degrees()]);
            }
            table.push(row)?;
        }
        Ok(table)
    }
}

/// Unit of the recorded output and its number in one of the device's own.
fn recorded_sensitivity(device: &Transducer) -> (&'static str, f64) {
    let top = device.output(0.2 * device.limits().acceleration);
    super::transducer::recorded(device.unit(), top.as_slice())
}
