//! A transducer by what it is made of: sizes, materials and circuit in place of a natural frequency and a damping ratio.

mod build;
mod tables;

pub use tables::{
    CantileverTable, CombTable, GaugeTable, PiezoTable, PlateTable, ResonantTable, SeriesTable,
    ShutterTable, ThermalTable, TunnellingTable,
};

use crate::campaign::CampaignFile;
use crate::trouble::{Result, Trouble};
use proofmass_fixture::thirds_of_octave;
use proofmass_io::Table;
use proofmass_rig::Transducer;
use proofmass_uncertainty::{Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
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
