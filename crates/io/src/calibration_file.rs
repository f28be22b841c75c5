//! `calibration.json`: what compensation needs, with its uncertainty, its units and where it is valid.

mod blocks;

pub use blocks::{CurvatureBlock, ThermalBlock};

use crate::Device;
use crate::any_calibration::{calibration_schema, parse_kind, read_document};
use crate::layout::ColumnRef;
use crate::output::AtomicFile;
use crate::software::{Schema, Software};
use crate::{Error, ErrorKind, Input, Result, Source, Unit};
use proofmass_core::{Compensation, Matrix3, SensorModel};
use proofmass_uncertainty::{Estimate, Quantity};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Kind of a calibration by one real matrix and a bias.
pub const TRIAXIAL: &str = "triaxial";

/// A stored calibration of a triaxial accelerometer: ã = K a + b, so a = K⁻¹(ã − b).
///
/// **Units** K in input unit per output unit, b in the input unit. "Input" is what enters the compensation (the
/// output of the sensor), "output" what leaves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CalibrationFile {
    /// Form and version.
    pub schema: Schema,
    /// Kind of calibration, [`TRIAXIAL`].
    pub(crate) kind: String,
    /// Program that wrote it.
    pub software: Software,
    /// The calibrated device.
    pub device: Device,
    /// Unit of the recordings it applies to.
    pub input_unit: Unit,
    /// Unit of the compensated signal.
    pub output_unit: Unit,
    /// Columns of x, y, z in the recording it came from, as the campaign named them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<[ColumnRef; 3]>,
    /// Name of the fitted model.
    pub model: String,
    /// Scale, misalignment and cross-axis matrix, by rows.
    #[serde(rename = "K")]
    pub k: [[f64; 3]; 3],
    /// Bias.
    pub b: [f64; 3],
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
    /// What is not linear, where that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<CurvatureBlock>,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
}

impl CalibrationFile {
    /// A calibration with what cannot be left out; the rest is set through the public fields.
    pub fn new(
        model: impl Into<String>,
        input_unit: Unit,
        k: [[f64; 3]; 3],
        b: [f64; 3],
        estimate: Estimate,
    ) -> Self {
        Self {
            schema: calibration_schema(),
            kind: TRIAXIAL.into(),
            software: Software::default(),
            device: Device::default(),
            input_unit,
            output_unit: Unit::MetrePerSecondSquared,
            columns: None,
            model: model.into(),
            k,
            b,
            estimate,
            gravity: None,
            repeatability: None,
            temperature_range: None,
            acceleration_range: None,
            temperature: None,
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
        let advice = "use a calibration of a triaxial accelerometer from static positions";
        let file: Self = parse_kind(bytes, TRIAXIAL, advice)?;
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
        crate::finite::to_json(self)
    }

    /// Form and version that this program writes: those of a file that was read are its own.
    pub fn schema() -> Schema {
        calibration_schema()
    }

    /// What runs on the desk and on the chip: the linear model with what the blocks say.
    ///
    /// # Errors
    /// A K that cannot be inverted, a coefficient that is not finite, curvature that is no small correction.
    pub fn compensation(&self) -> Result<Compensation<f64>> {
        let sensor = SensorModel::new(Matrix3(self.k), self.b).map_err(unusable)?;
        let thermal = self.temperature.as_ref().map(ThermalBlock::terms);
        let curvature = self.curvature.as_ref().map(CurvatureBlock::terms);
        let reach = self.curvature.as_ref().map_or(0.0, |c| c.reach);
        Compensation::new(sensor, thermal, curvature, reach).map_err(unusable)
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
                    "a local gravity of {} m/s² is impossible on the ground",
                    gravity.value
                ),
            );
        }
        const AXES: [char; 3] = ['x', 'y', 'z'];
        let stated = |name: String, fallback: f64| {
            let index = self.estimate.index_of(&name);
            index.map_or(fallback, |i| self.estimate.components()[i].value)
        };
        for (i, a) in AXES.into_iter().enumerate() {
            let (bias, scale) = (self.b[i], self.k[i][i]);
            // A part in 10⁹ is far beyond the rounding of written doubles and far below any uncertainty.
            let agree = |x: f64, y: f64, size: f64| (x - y).abs() <= 1e-9 * size.abs();
            let size = bias.abs().max(9.8 * scale.abs());
            if !agree(stated(format!("bias.{a}"), bias), bias, size) {
                return refuse(
                    "b",
                    format!("b of {a} disagrees with bias.{a} of the estimate"),
                );
            }
            if !agree(stated(format!("scale.{a}"), scale), scale, scale) {
                return refuse(
                    "K",
                    format!("K of {a} disagrees with scale.{a} of the estimate"),
                );
            }
            for (j, b) in AXES.into_iter().enumerate().filter(|(j, _)| *j != i) {
                let angle = self.k[i][j] / scale;
                // A model without an angle has none; coefficients of others come without any estimate.
                let none = self.estimate.components().is_empty();
                let missing = if none { angle } else { 0.0 };
                if !agree(stated(format!("misalignment.{a}{b}"), missing), angle, 1.0) {
                    return refuse(
                        "K",
                        format!("K of {a}{b} disagrees with misalignment.{a}{b} of the estimate"),
                    );
                }
            }
            let blocks = [
                self.temperature.as_ref().map(|t| t.named(i, a)),
                self.curvature.as_ref().map(|c| c.named(i, a)),
            ];
            for (name, value) in blocks.into_iter().flatten().flatten() {
                if !agree(stated(name.clone(), value), value, value) {
                    return refuse(
                        if name.starts_with("curvature") {
                            "curvature"
                        } else {
                            "temperature"
                        },
                        format!("{name} of the block disagrees with that of the estimate"),
                    );
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
        finite("K", self.k.as_flattened())?;
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
        // Columns scaled to length one, the determinant is the volume of the axes: 1 when orthogonal. A sensor with
        // axes a thousandth of a degree from one plane has 2e-5; below 1e-9 nothing is left to invert.
        let k = &self.k;
        let length = |j: usize| (0..3).map(|i| k[i][j] * k[i][j]).sum::<f64>().sqrt();
        let product = length(0) * length(1) * length(2);
        let determinant = k[0][0] * (k[1][1] * k[2][2] - k[1][2] * k[2][1])
            - k[0][1] * (k[1][0] * k[2][2] - k[1][2] * k[2][0])
            + k[0][2] * (k[1][0] * k[2][1] - k[1][1] * k[2][0]);
        if determinant.abs() <= 1e-9 * product {
            return Err(Error::new(
                ErrorKind::Format,
                "the matrix K is singular, so it cannot be inverted",
            )
            .column("K")
            .with_hint("calibrate again with attitudes that reach all three axes"));
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
        self.compensation()?;
        self.check_consistency()
    }
}

fn unusable(error: proofmass_core::Error) -> Error {
    Error::new(
        ErrorKind::Format,
        format!("the calibration cannot be applied: {error}"),
    )
    .with_hint("calibrate again")
    .because(error)
}
