//! From what a device is made of to the device.

use super::DeviceConstruction;
use super::tables::CombTable;
use crate::trouble::{Result, Trouble};
use proofmass_rig::{
    PiezoCut, PiezoElement, Principle, ProofMass, SqueezeFilm, Transducer, plate_capacitance,
};
use std::f64::consts::PI;

/// What damps a mass in gas: a stated ratio, or the gas in its gaps.
pub(super) struct Damping {
    pub(super) ratio: Option<f64>,
    pub(super) viscosity: Option<f64>,
    pub(super) pressure: f64,
}

impl Damping {
    /// The gas in a gap of these sizes.
    fn film(&self, [length, width, gap]: [f64; 3], viscosity: f64) -> Result<SqueezeFilm> {
        Ok(SqueezeFilm {
            length,
            width,
            gap,
            viscosity,
            pressure: 1e3 * positive("pressure_kPa", self.pressure)?,
        })
    }
}

pub(super) fn positive(name: &str, value: f64) -> Result<f64> {
    match value.is_finite() && value > 0.0 {
        true => Ok(value),
        false => Err(Trouble::request(format!(
            "`{name}` = {value} of the device: it must be a positive number"
        ))),
    }
}

pub(super) fn finite(name: &str, value: f64) -> Result<f64> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(Trouble::request(format!(
            "`{name}` of the device must be a finite number"
        ))),
    }
}

/// A mass, its stiffness and its stop, damped by a ratio.
fn damped((mass, stiffness, stop): (f64, f64, f64), ratio: f64) -> Result<ProofMass> {
    let ratio = positive("damping_ratio", ratio)?;
    Ok(ProofMass {
        mass,
        stiffness,
        damping: 2.0 * ratio * (stiffness * mass).sqrt(),
        stop,
    })
}

/// As [`damped`], or by the coefficient of the gas, whose cut-off the natural frequency must lie below.
fn front(
    (mass, stiffness, stop): (f64, f64, f64),
    damping: &Damping,
    film: impl Fn(f64) -> Result<(f64, Option<f64>)>,
) -> Result<ProofMass> {
    match (damping.ratio, damping.viscosity) {
        (Some(ratio), None) => damped((mass, stiffness, stop), ratio),
        (None, Some(viscosity)) => {
            let (damping, cut_off) = film(1e-6 * positive("viscosity_uPa_s", viscosity)?)?;
            let front = ProofMass {
                mass,
                stiffness,
                damping,
                stop,
            };
            let natural = front.natural_frequency();
            if let Some(cut_off) = cut_off.filter(|f| *f < natural) {
                return Err(Trouble::request(format!(
                    "the gas in the gap is compressed from {cut_off:.0} Hz on, below the natural frequency of {natural:.0} Hz: it is a \
                     spring there and no damper"
                ))
                .with_hint("give a wider gap, a smaller plate or a higher pressure, or state damping_ratio"));
            }
            Ok(front)
        }
        _ => Err(
            Trouble::request("the damping of the device is given twice or not at all")
                .with_hint("give either damping_ratio or viscosity_uPa_s"),
        ),
    }
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
                let damping = t.damping();
                let (m, k) = t.spring()?;
                let stop = stop(t.stop_um, 0.5 * d)?;
                let mass = front((m, k, stop), &damping, |v| squeezed([a, b, d], v, &damping))?;
                let principle = above_a_plate([a, b, d], t.permittivity, 0.0)?;
                (mass, principle, "capacitive, one plate")
            }
            Self::CapacitiveCantilever(t) => {
                let beam = t.beam()?;
                let [a, b, d] = plate(t.plate_length_um, t.plate_width_um, t.gap_um)?;
                let thick = 1e-6 * positive("plate_thickness_um", t.plate_thickness_um)?;
                let held = beam.tip_plate(a);
                let m = beam.density * a * b * thick + 33.0 / 140.0 * beam.mass();
                let damping = t.damping();
                let tilt = 0.5 * a * held.turn;
                let stop = stop(t.stop_um, 0.5 * d / (1.0 + tilt))?;
                let mass = front((m, held.stiffness, stop), &damping, |v| {
                    squeezed([a, b, d], v, &damping)
                })?;
                let principle = above_a_plate([a, b, d], t.permittivity, tilt)?;
                (mass, principle, "capacitive, plate on a cantilever")
            }
            Self::PiezoresistiveBridge(t) => {
                let beam = t.beam()?;
                let m = 1e-9 * positive("mass_ug", t.mass_ug)? + 33.0 / 140.0 * beam.mass();
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let mass = damped((m, beam.cantilever(), stop), t.damping_ratio)?;
                let strain = beam.cantilever_strain(1e-6 * finite("gauge_at_um", t.gauge_at_um)?);
                let principle = Principle::Bridge {
                    gauge_factor: t.gauge_factor()?,
                    strain_per_metre: positive("strain of the gauges per metre", strain)?,
                    arms: t.arms,
                    excitation: positive("excitation_V", t.excitation_V)?,
                    temperature: finite("temperature_per_K", t.temperature_per_K)?,
                };
                (mass, principle, "piezoresistive, bridge on a cantilever")
            }
            Self::PiezoresistiveSeries(t) => {
                let beam = t.beam()?;
                let m = 1e-9 * positive("mass_ug", t.mass_ug)? + 4.0 * 13.0 / 35.0 * beam.mass();
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let mass = damped((m, 4.0 * beam.guided(), stop), t.damping_ratio)?;
                let strain = beam.guided_strain(1e-6 * finite("gauge_at_um", t.gauge_at_um)?);
                let principle = Principle::SeriesGauges {
                    gauge_factor: t.gauge_factor()?,
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
                let mass = damped((m, element.stiffness(), stop), t.damping_ratio)?;
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
                let beam = t.beam()?;
                let (m, k) = t.spring()?;
                let stop = 1e-6 * positive("stop_um", t.stop_um)?;
                let principle = Principle::Resonant {
                    frequency: beam.clamped_frequency(),
                    per_metre: beam.pull() * positive("lever", t.lever)? * k,
                };
                let mass = damped((m, k, stop), t.damping_ratio)?;
                (mass, principle, "resonant beam")
            }
            Self::Tunnelling(t) => {
                let (m, k) = t.spring()?;
                let gap = 1e-9 * positive("gap_nm", t.gap_nm)?;
                let principle = Principle::Tunnelling {
                    current: 1e-9 * positive("current_nA", t.current_nA)?,
                    barrier: positive("barrier_eV", t.barrier_eV)?,
                };
                let mass = damped((m, k, gap), t.damping_ratio)?;
                (mass, principle, "tunnelling")
            }
            Self::Shutter(t) => {
                let (m, k) = t.spring()?;
                let width = 1e-6 * positive("width_um", t.width_um)?;
                let stop = stop(t.stop_um, 0.4 * width)?;
                let principle = Principle::Shutter {
                    photocurrent: 1e-3
                        * positive("power_mW", t.power_mW)?
                        * positive("responsivity_A_per_W", t.responsivity_A_per_W)?,
                    width,
                };
                let mass = damped((m, k, stop), t.damping_ratio)?;
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

/// A plate of these sizes above a fixed one, that turns by so much for each unit of its displacement.
fn above_a_plate([a, b, gap]: [f64; 3], permittivity: f64, tilt: f64) -> Result<Principle> {
    Ok(Principle::Plate {
        rest_capacitance: plate_capacitance(positive("permittivity", permittivity)?, a * b, gap),
        gap,
        tilt,
    })
}

/// Damping and cut-off of the gas under a plate.
fn squeezed(sizes: [f64; 3], viscosity: f64, damping: &Damping) -> Result<(f64, Option<f64>)> {
    let film = damping.film(sizes, viscosity)?;
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
        let (m, k) = self.spring()?;
        let gap = 1e-6 * positive("gap_um", self.gap_um)?;
        let overlap = 1e-6 * positive("overlap_um", self.overlap_um)?;
        let stop = stop(
            self.stop_um,
            if squeezes { 0.75 * gap } else { 0.5 * overlap },
        )?;
        let damping = self.damping();
        front((m, k, stop), &damping, |viscosity| {
            let width = 1e-6 * positive("thickness_um", self.thickness_um)?;
            let film = damping.film([overlap, width, gap], viscosity)?;
            // Each finger has a film on either side.
            let films = 2.0 * positive("fingers", self.fingers)?;
            match squeezes {
                true => Ok((films * film.damping()?, Some(film.cut_off()?))),
                false => Ok((films * film.sliding()?, None)),
            }
        })
    }
}
