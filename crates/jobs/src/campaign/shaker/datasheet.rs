//! `[datasheet]`: what the maker states, of one axis as a number, of three axes as the sheet prints it.

use crate::campaign::CampaignFile;
use crate::device_output::DeviceOutput;
use proofmass_io::sheet::{ACCELERATION_RATIO, COUNT_SENSITIVITY, SENSITIVITY};
use proofmass_io::{Error, Result};
use proofmass_shaker::datasheet::{Datasheet as Stated, SheetBand, SheetSensitivity};
use serde::Deserialize;

/// `[datasheet]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Datasheet {
    /// Nominal sensitivity.
    pub(crate) sensitivity: f64,
    /// Its tolerance or expanded uncertainty, in the same unit.
    pub(crate) tolerance: f64,
    /// `V/(m/s²)`, `mV/(m/s²)`, `V/g`, `mV/g`; of a single axis also `g/g` and `count/(m/s²)` and their like.
    pub(crate) unit: String,
}

impl Datasheet {
    /// What the device gives, its sensitivity per m/s² and the tolerance.
    pub(crate) fn si(&self, source: &CampaignFile) -> Result<(DeviceOutput, (f64, f64))> {
        let (output, factor) = output_of(source, &self.unit)?;
        for (key, value) in [
            ("sensitivity", self.sensitivity),
            ("tolerance", self.tolerance),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(source.refuse(
                    "datasheet",
                    key,
                    format!("{value} is not a positive number"),
                ));
            }
        }
        Ok((output, (self.sensitivity * factor, self.tolerance * factor)))
    }
}

/// What a device gives by the unit of its sensitivity, and how many of that per m/s² the unit is.
fn output_of(source: &CampaignFile, stated: &str) -> Result<(DeviceOutput, f64)> {
    let unit: String = stated.replace('²', "2").replace(' ', "");
    let kinds = [
        (DeviceOutput::Volt, SENSITIVITY),
        (DeviceOutput::Acceleration, ACCELERATION_RATIO),
        (DeviceOutput::Count, COUNT_SENSITIVITY),
    ];
    let known = kinds
        .into_iter()
        .flat_map(|(output, endings)| endings.iter().map(move |(u, f)| (output, *u, *f)));
    let Some((output, _, factor)) = known.clone().find(|(_, u, _)| *u == unit) else {
        let valid: Vec<&str> = known.map(|(_, u, _)| u).collect();
        return Err(source
            .refuse("datasheet", "unit", format!("unknown unit \"{stated}\""))
            .with_hint(format!("valid here: {}", valid.join(", "))));
    };
    Ok((output, factor))
}

/// `[datasheet]` of a triaxial device.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct TriaxialDatasheet {
    /// Nominal sensitivity of the axes that have no table of their own.
    pub(crate) sensitivity: Option<f64>,
    /// Its tolerance or expanded uncertainty, in the same unit.
    pub(crate) tolerance: Option<f64>,
    /// The same in per cent of the sensitivity.
    #[serde(rename = "tolerance_%")]
    pub(crate) tolerance_percent: Option<f64>,
    /// Unit of the sensitivities: `V/(m/s²)`, `mV/(m/s²)`, `V/g`, `mV/g`; of a sensor with `[output_recording]` also `g/g` and
    /// `count/(m/s²)` and their like.
    pub(crate) unit: Option<String>,
    /// Frequency at which the sensitivity of the sheet holds, Hz: the bands count from the sensitivity that was measured there, or at the
    /// nearest frequency within an octave. Without it they count from the sensitivity of the sheet.
    #[serde(rename = "reference_Hz")]
    pub(crate) reference: Option<f64>,
    /// Largest transverse sensitivity, per cent of the sensitivity along the axis.
    #[serde(rename = "transverse_%")]
    pub(crate) transverse: Option<f64>,
    /// Sensitivity of x.
    pub(crate) x: Option<AxisDatasheet>,
    /// Sensitivity of y.
    pub(crate) y: Option<AxisDatasheet>,
    /// Sensitivity of z.
    pub(crate) z: Option<AxisDatasheet>,
    /// Bands of frequencies with their tolerance, one table each; where several hold, the smallest.
    #[serde(rename = "band")]
    pub(crate) bands: Vec<BandTable>,
}

/// `[datasheet.x]`, `[datasheet.y]`, `[datasheet.z]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AxisDatasheet {
    /// Sensitivity of the axis, in the unit of the sheet.
    pub(crate) sensitivity: f64,
    /// Its tolerance or expanded uncertainty, in the same unit; that of `[datasheet]` without it.
    pub(crate) tolerance: Option<f64>,
    /// The same in per cent of the sensitivity.
    #[serde(rename = "tolerance_%")]
    pub(crate) tolerance_percent: Option<f64>,
}

/// `[[datasheet.band]]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BandTable {
    /// Lowest and highest frequency, Hz.
    #[serde(rename = "frequency_Hz")]
    pub(crate) frequency: [f64; 2],
    /// Largest departure of the sensitivity, in the unit of the sheet.
    pub(crate) tolerance: Option<f64>,
    /// The same in per cent of the sensitivity.
    #[serde(rename = "tolerance_%")]
    pub(crate) tolerance_percent: Option<f64>,
    /// Axes that it holds for, such as `["x", "y"]`; all without it.
    #[serde(default)]
    pub(crate) channels: Vec<String>,
}

const AXES: [&str; 3] = ["x", "y", "z"];
const HOW: &str = "tolerance_% = 10 in per cent of the sensitivity, or tolerance in its unit";

/// Where a number stands: table, its place among those of one name, key.
type Place<'a> = (&'a str, usize, &'a str);

fn positive(source: &CampaignFile, place: Place<'_>, value: f64) -> Result<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(source
        .refuse_in(place, format!("{value} is not a positive number"))
        .with_hint("as the sheet prints it, without a sign"))
}

/// A tolerance in one of its two forms, and the key it has in the file; of the sensitivity when relative.
fn tolerance(
    source: &CampaignFile,
    (table, nth): (&str, usize),
    (absolute, percent): (Option<f64>, Option<f64>),
) -> Result<Option<Tolerance>> {
    match (absolute, percent) {
        (Some(_), Some(_)) => Err(source
            .refuse_in(
                (table, nth, "tolerance_%"),
                "`tolerance` and `tolerance_%` exclude each other",
            )
            .with_hint(HOW)),
        (Some(t), None) => {
            let place = (table, nth, "tolerance");
            Ok(Some(Tolerance::Absolute(positive(source, place, t)?)))
        }
        (None, Some(t)) => {
            let t = positive(source, (table, nth, "tolerance_%"), t)?;
            if t >= 100.0 {
                return Err(source
                    .refuse_in(
                        (table, nth, "tolerance_%"),
                        format!("{t} % is no tolerance of a sensitivity"),
                    )
                    .with_hint(HOW));
            }
            Ok(Some(Tolerance::Relative(t / 100.0)))
        }
        (None, None) => Ok(None),
    }
}

#[derive(Clone, Copy)]
enum Tolerance {
    Absolute(f64),
    Relative(f64),
}

impl Tolerance {
    /// In the unit of a sensitivity.
    fn of(self, sensitivity: f64) -> f64 {
        match self {
            Self::Absolute(t) => t,
            Self::Relative(t) => t * sensitivity,
        }
    }
}

impl TriaxialDatasheet {
    /// What the sheet states per m/s², of a device that gives this.
    ///
    /// # Errors
    /// A number that cannot be, a key that is missing, with its line.
    pub(crate) fn si(&self, source: &CampaignFile, outputs: DeviceOutput) -> Result<Stated> {
        let factor = self.factor(source, outputs)?;
        let general = tolerance(
            source,
            ("datasheet", 0),
            (self.tolerance, self.tolerance_percent),
        )?;
        if let Some(s) = self.sensitivity {
            positive(source, ("datasheet", 0, "sensitivity"), s)?;
        }
        let mut stated = Stated::default();
        for (k, own) in [&self.x, &self.y, &self.z].into_iter().enumerate() {
            let table = format!("datasheet.{}", AXES[k]);
            let (sensitivity, tolerance) = match own {
                None => (self.sensitivity, general),
                Some(axis) => {
                    let value = positive(source, (&table, 0, "sensitivity"), axis.sensitivity)?;
                    let both = (axis.tolerance, axis.tolerance_percent);
                    let own = tolerance(source, (&table, 0), both)?;
                    (Some(value), own.or(general))
                }
            };
            let Some(value) = sensitivity else { continue };
            // In bands that count from the sheet its own tolerance has nothing to hold.
            if tolerance.is_none() && self.bands.is_empty() {
                let (table, key) = match own {
                    Some(_) => (table.as_str(), "sensitivity"),
                    None => ("datasheet", "sensitivity"),
                };
                return Err(source
                    .refuse_in(
                        (table, 0, key),
                        "the tolerance of the sensitivity is missing",
                    )
                    .with_hint(format!("add {HOW}, or the bands as [[datasheet.band]]")));
            }
            stated.axes[k] = Some(SheetSensitivity {
                value: factor * value,
                tolerance: tolerance.map(|t| factor * t.of(value)),
            });
        }
        if let Some(f) = self.reference {
            stated.reference = Some(positive(source, ("datasheet", 0, "reference_Hz"), f)?);
        }
        if let Some(t) = self.transverse {
            let t = positive(source, ("datasheet", 0, "transverse_%"), t)?;
            if t >= 100.0 {
                return Err(source
                    .refuse(
                        "datasheet",
                        "transverse_%",
                        format!("{t} % is no transverse sensitivity"),
                    )
                    .with_hint("in per cent of the sensitivity along the axis, such as 5"));
            }
            stated.transverse = Some(t / 100.0);
        }
        for (nth, band) in self.bands.iter().enumerate() {
            stated
                .bands
                .extend(band.si(source, nth, &stated.axes, factor)?);
        }
        if stated.axes.iter().all(Option::is_none) && stated.transverse.is_none() {
            return Err(source
                .refuse("datasheet", "unit", "the datasheet states nothing")
                .with_hint(
                    "add sensitivity with tolerance_% and unit, [datasheet.x] of one axis, or transverse_%",
                ));
        }
        Ok(stated)
    }

    /// How many of what the device gives per m/s² the unit of the sheet is.
    fn factor(&self, source: &CampaignFile, outputs: DeviceOutput) -> Result<f64> {
        let any =
            self.sensitivity.is_some() || [&self.x, &self.y, &self.z].iter().any(|a| a.is_some());
        let Some(unit) = &self.unit else {
            if any {
                return Err(source
                    .refuse(
                        "datasheet",
                        "sensitivity",
                        "the unit of the sensitivity is missing",
                    )
                    .with_hint("add unit = \"mV/(m/s²)\", \"mV/g\" or another"));
            }
            return Ok(1.0);
        };
        let (given, factor) = output_of(source, unit)?;
        if given != outputs {
            return Err(source
                .refuse(
                    "datasheet",
                    "unit",
                    format!(
                        "the sensitivity is in {}, not in {}",
                        outputs.unit(),
                        given.unit()
                    ),
                )
                .with_hint("V/(m/s2), mV/(m/s2), V/g or mV/g; of a sensor with [output_recording] its unit per m/s2 or g"));
        }
        Ok(factor)
    }
}

impl BandTable {
    /// The band, for each axis by itself where its tolerance is in the unit of the sensitivity.
    fn si(
        &self,
        source: &CampaignFile,
        nth: usize,
        axes: &[Option<SheetSensitivity>; 3],
        factor: f64,
    ) -> Result<Vec<SheetBand>> {
        const TABLE: &str = "datasheet.band";
        let refuse =
            |key: &str, what: String| -> Error { source.refuse_in((TABLE, nth, key), what) };
        let [from, to] = self.frequency;
        if !(from >= 0.0 && from < to && to.is_finite()) {
            return Err(
                refuse("frequency_Hz", format!("{from} to {to} Hz is no band"))
                    .with_hint("write frequency_Hz = [LOWEST, HIGHEST], such as [2, 5000]"),
            );
        }
        let both = (self.tolerance, self.tolerance_percent);
        let Some(tolerance) = tolerance(source, (TABLE, nth), both)? else {
            return Err(refuse(
                "frequency_Hz",
                "the tolerance of the band is missing".to_owned(),
            )
            .with_hint(
                "tolerance_% = 5 in per cent of the sensitivity, or tolerance in its unit",
            ));
        };
        let mut of = Vec::new();
        for name in &self.channels {
            let Some(k) = AXES.iter().position(|a| a == name) else {
                return Err(refuse("channels", format!("there is no axis \"{name}\""))
                    .with_hint("channels = [\"x\", \"y\"]; leave it out for all three"));
            };
            if of.contains(&k) {
                return Err(refuse("channels", format!("the axis {name} stands twice"))
                    .with_hint("name each axis once"));
            }
            of.push(k);
        }
        let concerned: Vec<usize> = match of.is_empty() {
            true => (0..3).filter(|k| axes[*k].is_some()).collect(),
            false => of.clone(),
        };
        if concerned.is_empty() || concerned.iter().any(|k| axes[*k].is_none()) {
            return Err(refuse(
                "frequency_Hz",
                "the band counts from a sensitivity, and none is stated".to_owned(),
            )
            .with_hint(
                "add sensitivity and unit to [datasheet], or [datasheet.x] with sensitivity",
            ));
        }
        Ok(match tolerance {
            Tolerance::Relative(tolerance) => vec![SheetBand {
                from,
                to,
                tolerance,
                axes: of,
            }],
            Tolerance::Absolute(t) => concerned
                .into_iter()
                .filter_map(|k| {
                    Some(SheetBand {
                        from,
                        to,
                        tolerance: factor * t / axes[k]?.value,
                        axes: vec![k],
                    })
                })
                .collect(),
        })
    }
}
