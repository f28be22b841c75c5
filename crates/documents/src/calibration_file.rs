//! `calibration.json`: what compensation needs, with its uncertainty, its units and where it is valid.

mod accelerations;
mod blocks;
mod environment;

pub use blocks::{CurvatureBlock, ThermalBlock};
pub use environment::EnvironmentBlock;

use crate::Device;
use crate::any_calibration::{calibration_schema, parse_kind, read_document};
use proofmass_core::{
    AxisCompensation, Compensation, Curvature, Matrix3, SensorModel, ThermalTerms,
};
use proofmass_io::{
    AtomicFile, ColumnRef, Error, ErrorKind, Input, Result, Schema, Software, Source, Unit,
};
use proofmass_signal::AnyCompensation;
use proofmass_uncertainty::{Estimate, Quantity};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Kind of a calibration by one real matrix and a bias.
pub const TRIAXIAL: &str = "triaxial";
/// Kind of a calibration of one axis, by a scale factor and a bias.
pub const SINGLE_AXIS: &str = "single-axis";

/// What an axis adds to the name of a parameter: three have letters, one has none.
pub(crate) fn axis_names(axes: usize) -> &'static [&'static str] {
    match axes {
        1 => &[""],
        _ => &[".x", ".y", ".z"],
    }
}

/// A stored calibration of an accelerometer of three axes or of one: ã = K a + b, so a = K⁻¹(ã − b).
///
/// **Shapes** three axes, or one: K is 3 × 3 or 1 × 1, and whatever there is per axis as long as b.
///
/// **Units** K in input unit per output unit, b in the input unit. "Input" is what enters the compensation (the
/// output of the sensor), "output" what leaves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CalibrationFile {
    /// Form and version.
    pub schema: Schema,
    /// Kind of calibration, [`TRIAXIAL`] or [`SINGLE_AXIS`].
    pub(crate) kind: String,
    /// Program that wrote it.
    pub software: Software,
    /// The calibrated device.
    pub device: Device,
    /// Unit of the recordings it applies to.
    pub input_unit: Unit,
    /// Unit of the compensated signal.
    pub output_unit: Unit,
    /// Columns of the axes in the recording it came from, as the campaign named them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<ColumnRef>>,
    /// Name of the fitted model.
    pub model: String,
    /// Scale, misalignment and cross-axis matrix, by rows.
    #[serde(rename = "K")]
    pub k: Vec<Vec<f64>>,
    /// Bias.
    pub b: Vec<f64>,
    /// All parameters with their joint covariance and its causes.
    pub estimate: Estimate,
    /// Local gravity of the calibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Quantity>,
    /// Standard deviation of one standstill about the model beyond its noise, output unit; zero where the noise
    /// explained the residuals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeatability: Option<f64>,
    /// Smallest and largest temperature during calibration, °C.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        rename = "temperature_range_degC"
    )]
    pub temperature_range: Option<[f64; 2]>,
    /// Range of acceleration per axis in which it was tested, output unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_range: Option<[f64; 2]>,
    /// How bias and scale follow the temperature, where that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<ThermalBlock>,
    /// How bias and scale follow other quantities of the surroundings, where that was measured: humidity, pressure, supply voltage.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub environment: Vec<EnvironmentBlock>,
    /// What is not linear, where that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<CurvatureBlock>,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
}

impl CalibrationFile {
    /// A calibration with what cannot be left out; the rest is set through the public fields. N is three, or one.
    pub fn new<const N: usize>(
        model: impl Into<String>,
        input_unit: Unit,
        k: [[f64; N]; N],
        b: [f64; N],
        estimate: Estimate,
    ) -> Self {
        Self {
            schema: calibration_schema(),
            kind: if N == 1 { SINGLE_AXIS } else { TRIAXIAL }.into(),
            software: Software::default(),
            device: Device::default(),
            input_unit,
            output_unit: Unit::MetrePerSecondSquared,
            columns: None,
            model: model.into(),
            k: k.map(|row| row.to_vec()).to_vec(),
            b: b.to_vec(),
            estimate,
            gravity: None,
            repeatability: None,
            temperature_range: None,
            acceleration_range: None,
            temperature: None,
            environment: Vec::new(),
            curvature: None,
            inputs: Vec::new(),
        }
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// Another form, version or kind (with advice), a number that is not finite, a K that cannot be inverted.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_source(Source::open(path)?).map(|(file, _)| file)
    }

    /// Reads and checks a source; its name and digest come with it.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn from_source(source: Source) -> Result<(Self, Input)> {
        read_document(source, Self::from_json)
    }

    /// Reads and checks the bytes of a file.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let advice = "use a calibration from static positions or from a static test; of one over frequency `--band` makes such a one, where the command has it";
        let file: Self = parse_kind(bytes, &[TRIAXIAL, SINGLE_AXIS], advice)?;
        file.check()?;
        Ok(file)
    }

    /// Writes it beside nothing half written: the file appears whole or not at all.
    ///
    /// # Errors
    /// A number that is not finite, a singular K, or a place that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes = self.to_json()?;
        let mut file = AtomicFile::create(path, &[])?;
        file.write_all(&bytes)?;
        file.commit()
    }

    /// The bytes of the file. Numbers are written with as many digits as bring back the same double.
    ///
    /// # Errors
    /// A number that is not finite, or a singular K.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        self.check()?;
        proofmass_io::finite::to_json(self)
    }

    /// Form and version that this program writes: those of a file that was read are its own.
    pub fn schema() -> Schema {
        calibration_schema()
    }

    /// The same with accelerations in another frame, a' = R a: its matrix is K Rᵀ, whose inverse is R K⁻¹.
    ///
    /// Bias and temperature are those of the outputs, and stay. The estimate is of K in the frame of the sensor, and is left out. The range
    /// in which it was tested is one of its own axes, and is left out too.
    ///
    /// # Errors
    /// One axis, or curvature: that is along the axes of the sensor.
    pub fn turned(&self, rotation: &Matrix3<f64>) -> Result<Self> {
        if self.axes() != 3 {
            return Err(Error::new(
                ErrorKind::Configuration,
                "a rotation turns three axes, and the calibration is of one",
            )
            .with_hint("leave the rotation out, or give a calibration of three axes"));
        }
        if self.curvature.is_some() {
            return Err(Error::new(
                ErrorKind::Configuration,
                "the calibration has curvature, which is along the axes of the sensor: a rotation has no place in its matrix",
            )
            .with_hint("write it without the rotation, and turn the acceleration that it gives"));
        }
        let row = |r: &Vec<f64>| <[f64; 3]>::try_from(r.as_slice()).ok();
        let rows: Option<Vec<[f64; 3]>> = self.k.iter().map(row).collect();
        let rows = rows.and_then(|rows| <[[f64; 3]; 3]>::try_from(rows).ok());
        let k =
            rows.ok_or_else(|| Error::new(ErrorKind::Format, "K has no three rows of three"))?;
        let estimate = Estimate::new(Vec::new(), Vec::new())
            .map_err(|e| Error::new(ErrorKind::Configuration, e.to_string()))?;
        let turned = Matrix3(k).product(&rotation.transpose());
        Ok(Self {
            k: turned.0.map(|row| row.to_vec()).to_vec(),
            estimate,
            acceleration_range: None,
            ..self.clone()
        })
    }

    /// Number of axes: three, or one.
    pub fn axes(&self) -> usize {
        self.b.len()
    }

    /// Kind as in the file: [`TRIAXIAL`] or [`SINGLE_AXIS`].
    pub fn kind(&self) -> &'static str {
        match self.axes() {
            1 => SINGLE_AXIS,
            _ => TRIAXIAL,
        }
    }

    /// What runs on the desk and on the chip: the linear model with what the blocks of temperature and curvature say, at the reference of
    /// other quantities of the surroundings.
    ///
    /// # Errors
    /// A K that cannot be inverted, a coefficient that is not finite, curvature that is no small correction.
    pub fn compensation(&self) -> Result<AnyCompensation> {
        let reach = self.curvature.as_ref().map_or(0.0, |c| c.reach);
        Ok(match (self.k.as_slice(), self.b.as_slice()) {
            ([row], &[bias]) if row.len() == 1 => {
                let (thermal, curvature) = (self.thermal()?, self.curvature()?);
                let model = AxisCompensation::new(row[0], bias, thermal, curvature, reach);
                AnyCompensation::OneAxis(model.map_err(unusable)?)
            }
            _ => {
                let (sensor, thermal) = (self.sensor()?, self.thermal()?);
                let model = Compensation::new(sensor, thermal, self.curvature()?, reach);
                AnyCompensation::ThreeAxes(model.map_err(unusable)?)
            }
        })
    }

    /// The linear part of a calibration of three axes.
    ///
    /// # Errors
    /// One of a single axis; a K that cannot be inverted.
    pub fn sensor(&self) -> Result<SensorModel<f64>> {
        let row = |row: &Vec<f64>| <[f64; 3]>::try_from(row.as_slice()).ok();
        let rows: Option<Vec<[f64; 3]>> = self.k.iter().map(row).collect();
        let k = rows.and_then(|rows| <[[f64; 3]; 3]>::try_from(rows).ok());
        let (Some(k), Ok(b)) = (k, <[f64; 3]>::try_from(self.b.as_slice())) else {
            return Err(Error::new(
                ErrorKind::Format,
                "is a calibration of one axis; one of three axes is needed here",
            )
            .with_hint(
                "use a calibration of a triaxial accelerometer, such as one from static positions",
            ));
        };
        SensorModel::new(Matrix3(k), b).map_err(unusable)
    }

    fn thermal<const N: usize>(&self) -> Result<Option<ThermalTerms<f64, N>>> {
        let terms = self.temperature.as_ref().map(ThermalBlock::terms);
        terms
            .map(|t| t.ok_or_else(|| misshapen("temperature")))
            .transpose()
    }

    fn curvature<const N: usize>(&self) -> Result<Option<Curvature<f64, N>>> {
        let terms = self.curvature.as_ref().map(CurvatureBlock::terms);
        terms
            .map(|t| t.ok_or_else(|| misshapen("curvature")))
            .transpose()
    }

    /// K and b stand twice in the file, as they are applied and as the quantities of the estimate: they must agree.
    fn check_consistency(&self) -> Result<()> {
        let refuse = |key: &str, what: String| {
            Err(Error::new(ErrorKind::Format, what)
                .column(key)
                .with_hint("do not edit the file by hand; calibrate again"))
        };
        if self.output_unit != Unit::MetrePerSecondSquared {
            return refuse(
                "output_unit",
                format!("a calibration gives m/s², not {}", self.output_unit),
            );
        }
        if let Some(gravity) = &self.gravity
            && !(9.7..=9.9).contains(&gravity.value)
        {
            return refuse(
                "gravity",
                format!(
                    "a local gravity of {} m/s² is out of range: on the ground it is 9.7 m/s² to 9.9 m/s²",
                    gravity.value
                ),
            );
        }
        let stated = |name: String, fallback: f64| {
            let index = self.estimate.index_of(&name);
            index.map_or(fallback, |i| self.estimate.components()[i].value)
        };
        let axes = axis_names(self.axes());
        for (i, a) in axes.iter().enumerate() {
            let (bias, scale) = (self.b[i], self.k[i][i]);
            // A part in 10⁹ is far beyond the rounding of written doubles and far below any uncertainty.
            let agree = |x: f64, y: f64, size: f64| (x - y).abs() <= 1e-9 * size.abs();
            let size = bias.abs().max(9.8 * scale.abs());
            if !agree(stated(format!("bias{a}"), bias), bias, size) {
                return refuse("b", format!("b disagrees with bias{a} of the estimate"));
            }
            if !agree(stated(format!("scale{a}"), scale), scale, scale) {
                return refuse("K", format!("K disagrees with scale{a} of the estimate"));
            }
            for (j, b) in axes.iter().enumerate().filter(|(j, _)| *j != i) {
                let b = b.trim_start_matches('.');
                let angle = self.k[i][j] / scale;
                // A model without an angle has none; coefficients of others come without any estimate.
                let none = self.estimate.components().is_empty();
                let missing = if none { angle } else { 0.0 };
                if !agree(stated(format!("misalignment{a}{b}"), missing), angle, 1.0) {
                    return refuse(
                        "K",
                        format!("K disagrees with misalignment{a}{b} of the estimate"),
                    );
                }
            }
            let thermal = self.temperature.iter().map(|t| ("temperature", t.named(i)));
            let around = self.environment.iter().map(|e| ("environment", e.named(i)));
            let curved = self.curvature.iter().map(|c| ("curvature", c.named(i)));
            for (key, terms) in thermal.chain(around).chain(curved) {
                for (name, value) in terms {
                    // What no estimate knows has no uncertainty; zero is what was not measured.
                    let unknown = key == "environment" && value != 0.0;
                    if unknown && self.estimate.index_of(&name).is_none() {
                        return refuse(key, format!("{name} of the block stands in no estimate"));
                    }
                    if !agree(stated(name.clone(), value), value, value) {
                        return refuse(
                            key,
                            format!("{name} of the block disagrees with that of the estimate"),
                        );
                    }
                }
            }
        }
        Ok(())
    }

    fn check(&self) -> Result<()> {
        let finite = |name: &str, values: &[f64]| match values.iter().find(|v| !v.is_finite()) {
            Some(v) => Err(Error::new(
                ErrorKind::Format,
                format!("{name} holds {v}, which is not finite"),
            )
            .column(name)
            .with_hint("calibrate again")),
            None => Ok(()),
        };
        let n = self.axes();
        let shapes = [
            (
                "K",
                self.k.len() == n && self.k.iter().all(|row| row.len() == n),
            ),
            ("b", n == if self.kind == SINGLE_AXIS { 1 } else { 3 }),
            (
                "columns",
                self.columns.as_ref().is_none_or(|c| c.len() == n),
            ),
            (
                "temperature",
                self.temperature.as_ref().is_none_or(|t| t.is_of(n)),
            ),
            ("environment", self.environment.iter().all(|e| e.is_of(n))),
            (
                "curvature",
                self.curvature.as_ref().is_none_or(|c| c.is_of(n)),
            ),
        ];
        if let Some((name, _)) = shapes.into_iter().rfind(|(_, fits)| !fits) {
            return Err(misshapen(name));
        }
        finite("K", &self.k.concat())?;
        finite("b", &self.b)?;
        for (name, range) in [
            ("temperature_range_degC", self.temperature_range),
            ("acceleration_range", self.acceleration_range),
        ] {
            if let Some(range) = range {
                finite(name, &range)?;
                if range[0] > range[1] {
                    return Err(
                        Error::new(ErrorKind::Format, format!("{name} is reversed")).column(name)
                    );
                }
            }
        }
        if self.is_flat() {
            return Err(Error::new(
                ErrorKind::Format,
                "the matrix K is singular, so it cannot be inverted",
            )
            .column("K")
            .with_hint("calibrate again with attitudes that reach all axes"));
        }
        if let Some(block) = &self.temperature {
            finite("temperature", &block.numbers())?;
            if !(block.range[0] < block.range[1]) {
                return Err(Error::new(
                    ErrorKind::Format,
                    "the temperature range of the coefficients is empty or reversed",
                )
                .column("temperature"));
            }
        }
        for (k, block) in self.environment.iter().enumerate() {
            finite("environment", &block.numbers())?;
            let twice = self.environment[..k].iter().any(|e| e.name == block.name);
            let twice = twice.then(|| format!("{} stands there twice", block.name));
            if let Some(fault) = twice.or_else(|| block.fault()) {
                return Err(Error::new(ErrorKind::Format, fault)
                    .column("environment")
                    .with_hint("do not edit the file by hand; calibrate again"));
            }
        }
        self.compensation()?;
        self.check_consistency()
    }

    /// Whether nothing is left to invert.
    ///
    /// Columns scaled to length one, the determinant is the volume of the axes: 1 when orthogonal. A sensor with axes a thousandth of
    /// a degree from one plane has 2e-5; below 1e-9 nothing is left.
    fn is_flat(&self) -> bool {
        let k = &self.k;
        if self.axes() == 1 {
            return k[0][0] == 0.0;
        }
        let length = |j: usize| (0..3).map(|i| k[i][j] * k[i][j]).sum::<f64>().sqrt();
        let product = length(0) * length(1) * length(2);
        let determinant = k[0][0] * (k[1][1] * k[2][2] - k[1][2] * k[2][1])
            - k[0][1] * (k[1][0] * k[2][2] - k[1][2] * k[2][0])
            + k[0][2] * (k[1][0] * k[2][1] - k[1][1] * k[2][0]);
        determinant.abs() <= 1e-9 * product
    }
}

fn misshapen(name: &str) -> Error {
    Error::new(
        ErrorKind::Format,
        format!("{name} is of another number of axes than the calibration"),
    )
    .column(name)
    .with_hint("do not edit the file by hand; calibrate again")
}

fn unusable(error: proofmass_core::Error) -> Error {
    Error::new(
        ErrorKind::Format,
        format!("the calibration cannot be applied: {error}"),
    )
    .with_hint("calibrate again")
    .because(error)
}
