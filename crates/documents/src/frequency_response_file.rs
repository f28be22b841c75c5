//! `calibration.json` of a device whose sensitivity is known over frequency.

use crate::Device;
use crate::any_calibration::{calibration_schema, parse_kind, read_document};
use proofmass_io::{ColumnRef, Error, ErrorKind, Input, Result, Schema, Software, Source, Unit};
use proofmass_uncertainty::EstimateSeries;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Kind of a calibration by a complex matrix over frequency.
pub const FREQUENCY_RESPONSE: &str = "frequency-response";

/// A stored frequency response: õ(f) = K(f) a(f), K outputs × axes and complex, phasors turning as e^{+j2πft}.
///
/// **Units** frequencies in Hz, K in input unit per output unit. "Input" is what enters the compensation (the output
/// of the sensor), "output" what leaves it, as in [`CalibrationFile`](crate::CalibrationFile).
///
/// **Shapes** every point of the series has real and imaginary part of each element of K, row by row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FrequencyResponseFile {
    /// Form and version.
    pub(crate) schema: Schema,
    /// Kind of calibration, [`FREQUENCY_RESPONSE`].
    pub(crate) kind: String,
    /// Program that wrote it.
    pub software: Software,
    /// The calibrated device.
    pub device: Device,
    /// Unit of the recordings it applies to.
    pub(crate) input_unit: Unit,
    /// Unit of the compensated signal.
    pub output_unit: Unit,
    /// Columns of the outputs in a recording, where they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<ColumnRef>>,
    /// How it was found: the method of a shaker calibration, a certificate.
    pub(crate) model: String,
    /// Names of the outputs: rows of K.
    pub outputs: Vec<String>,
    /// Names of the directions of acceleration: columns of K.
    pub axes: Vec<String>,
    /// K at every frequency with its covariance, and what the frequencies have in common.
    pub series: EstimateSeries,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
}

impl FrequencyResponseFile {
    /// A calibration with what cannot be left out; the rest is set through the public fields.
    pub fn new(
        model: impl Into<String>,
        input_unit: Unit,
        outputs: Vec<String>,
        axes: Vec<String>,
        series: EstimateSeries,
    ) -> Self {
        Self {
            schema: calibration_schema(),
            kind: FREQUENCY_RESPONSE.into(),
            software: Software::default(),
            device: Device::default(),
            input_unit,
            output_unit: Unit::MetrePerSecondSquared,
            columns: None,
            model: model.into(),
            outputs,
            axes,
            series,
            inputs: Vec::new(),
        }
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// Another form, version or kind (with advice), a damaged file.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_source(Source::open(path)?).map(|(file, _)| file)
    }

    /// Reads and checks a source; its name and digest come with it.
    ///
    /// # Errors
    /// As [`FrequencyResponseFile::read`].
    pub fn from_source(source: Source) -> Result<(Self, Input)> {
        read_document(source, Self::from_json)
    }

    /// Reads and checks the bytes of a file.
    ///
    /// # Errors
    /// As [`FrequencyResponseFile::read`].
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let advice = "use a calibration over frequency, such as one from a shaker";
        let file: Self = parse_kind(bytes, &[FREQUENCY_RESPONSE], advice)?;
        file.check()?;
        Ok(file)
    }

    /// The bytes of the file. Numbers are written with as many digits as bring back the same double.
    ///
    /// # Errors
    /// A number that is not finite, or shapes that contradict each other.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        self.check()?;
        proofmass_io::finite::to_json(self)
    }

    fn check(&self) -> Result<()> {
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
        let elements = self.outputs.len() * self.axes.len();
        if elements == 0 || self.series.dimension() != 2 * elements {
            return refuse(
                "series",
                format!(
                    "{} outputs and {} axes have {elements} complex elements, the series has {} reals at each frequency",
                    self.outputs.len(),
                    self.axes.len(),
                    self.series.dimension()
                ),
            );
        }
        let parts = self.series.points()[0].estimate.components();
        if let Some(odd) = parts.chunks(2).find(|pair| {
            let parts = (
                pair[0].name.strip_suffix(".re"),
                pair[1].name.strip_suffix(".im"),
            );
            !matches!(parts, (Some(re), Some(im)) if re == im)
        }) {
            return refuse(
                "series",
                format!(
                    "the names {} and {} are not those of a real and an imaginary part",
                    odd[0].name, odd[1].name
                ),
            );
        }
        if self
            .columns
            .as_ref()
            .is_some_and(|c| c.len() != self.outputs.len())
        {
            return refuse("columns", "there is not one column per output".to_owned());
        }
        if let Some(point) = self.series.points().iter().find(|p| p.at <= 0.0) {
            return refuse(
                "series",
                format!(
                    "a frequency of {} Hz is out of range: it must be positive",
                    point.at
                ),
            );
        }
        Ok(())
    }
}
