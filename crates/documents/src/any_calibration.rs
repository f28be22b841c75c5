//! A calibration file of whatever kind.

use crate::{
    CalibrationFile, Device, FREQUENCY_RESPONSE, FrequencyResponseFile, SINGLE_AXIS, TRIAXIAL,
};
use proofmass_io::{
    ColumnRef, Error, ErrorKind, Input, LARGEST_DOCUMENT, RESULT_SCHEMA, Result, Schema, Source,
    Unit,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::path::Path;

/// Name of the form.
pub const CALIBRATION_SCHEMA: &str = "proofmass.calibration";
/// Version of the form; version 1 (kind [`TRIAXIAL`] alone) is read as well.
pub const CALIBRATION_VERSION: u32 = 2;

/// A calibration of any kind that this version knows.
///
/// ```
/// use proofmass_documents::AnyCalibration;
///
/// let refused = AnyCalibration::from_json(b"{\"schema\": {\"name\": \"proofmass.result\", \"version\": 1}}");
/// assert!(refused.unwrap_err().to_string().contains("a result without a calibration"));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnyCalibration {
    /// One real matrix and a bias, of three axes or one, from static positions or a static test.
    Constant(Box<CalibrationFile>),
    /// A complex matrix over frequency, from a shaker, a shock or a certificate.
    FrequencyResponse(Box<FrequencyResponseFile>),
}

impl From<CalibrationFile> for AnyCalibration {
    fn from(file: CalibrationFile) -> Self {
        Self::Constant(Box::new(file))
    }
}

impl From<FrequencyResponseFile> for AnyCalibration {
    fn from(file: FrequencyResponseFile) -> Self {
        Self::FrequencyResponse(Box::new(file))
    }
}

impl AnyCalibration {
    /// The calibration at stated values of quantities of the surroundings, as [`CalibrationFile::at_environment`].
    ///
    /// # Errors
    /// As there; a calibration of another kind follows none.
    pub fn at_environment(self, values: &[(String, f64)]) -> Result<Self> {
        match (self, values) {
            (this, []) => Ok(this),
            (Self::Constant(file), values) => Ok(Self::from(file.at_environment(values)?)),
            (_, [(name, _), ..]) => Err(Error::new(
                ErrorKind::Configuration,
                format!("the calibration is one over frequency, and does not follow {name}"),
            )
            .with_hint("leave --at out")),
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
    /// As [`AnyCalibration::read`].
    pub fn from_source(source: Source) -> Result<(Self, Input)> {
        read_document(source, Self::from_json)
    }

    /// Reads and checks the bytes of a file.
    ///
    /// # Errors
    /// As [`AnyCalibration::read`].
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let (kind, bytes) = opened(bytes)?;
        let bytes = bytes.as_ref();
        match kind.as_str() {
            TRIAXIAL | SINGLE_AXIS => CalibrationFile::from_json(bytes).map(Self::from),
            FREQUENCY_RESPONSE => FrequencyResponseFile::from_json(bytes).map(Self::from),
            _ => Err(Error::new(
                ErrorKind::Format,
                format!("is a calibration of kind \"{kind}\", which this version does not know"),
            )
            .with_hint(format!(
                "kinds it knows: {TRIAXIAL}, {SINGLE_AXIS}, {FREQUENCY_RESPONSE}; use the version of proofmass that wrote it"
            ))),
        }
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// A number that is not finite, or a singular matrix.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        match self {
            Self::Constant(file) => file.to_json(),
            Self::FrequencyResponse(file) => file.to_json(),
        }
    }

    /// Kind as in the file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Constant(file) => file.kind(),
            Self::FrequencyResponse(_) => FREQUENCY_RESPONSE,
        }
    }

    /// The calibrated device.
    pub fn device(&self) -> &Device {
        match self {
            Self::Constant(file) => &file.device,
            Self::FrequencyResponse(file) => &file.device,
        }
    }

    /// Columns of its outputs in the recording that it came from, where it names them.
    pub fn columns(&self) -> Option<Vec<ColumnRef>> {
        match self {
            Self::Constant(file) => file.columns.clone(),
            Self::FrequencyResponse(file) => file.columns.clone(),
        }
    }

    /// Unit of the recordings it applies to.
    pub fn input_unit(&self) -> Unit {
        match self {
            Self::Constant(file) => file.input_unit,
            Self::FrequencyResponse(file) => file.input_unit,
        }
    }
}

/// Form and version that this program writes.
pub(crate) fn calibration_schema() -> Schema {
    Schema::new(CALIBRATION_SCHEMA, CALIBRATION_VERSION)
}

/// The kind of a calibration and its bytes, after its form and version have been checked: a file of its own, or the part of a
/// result.json.
fn opened(bytes: &[u8]) -> Result<(String, Cow<'_, [u8]>)> {
    #[derive(Deserialize)]
    struct Head {
        schema: Option<Schema>,
        kind: Option<String>,
        #[serde(default)]
        extra: Sections,
    }
    #[derive(Default, Deserialize)]
    struct Sections {
        calibration: Option<serde_json::Value>,
    }
    let not_ours = |what: String| {
        Error::new(ErrorKind::Format, what).with_hint(
            "name the calibration.json or result.json of a calibration or a test of one axis",
        )
    };
    let head: Head = serde_json::from_slice(bytes).map_err(|e| {
        not_ours(
            "the file is not a calibration of proofmass, or it is damaged or incomplete".into(),
        )
        .line(e.line() as u64)
        .because(e)
    })?;
    if head
        .schema
        .as_ref()
        .is_some_and(|s| s.name() == RESULT_SCHEMA)
    {
        let kind = head.kind.unwrap_or_default();
        let part = head.extra.calibration.ok_or_else(|| {
            not_ours(format!(
                "is a result without a calibration ({RESULT_SCHEMA}, kind \"{kind}\")"
            ))
        })?;
        let part = part.to_string().into_bytes();
        let (kind, part) = opened(&part)?;
        return Ok((kind, Cow::Owned(part.into_owned())));
    }
    let schema = head
        .schema
        .ok_or_else(|| not_ours("is not a calibration file: it names no schema".into()))?;
    if schema.name() != CALIBRATION_SCHEMA {
        return Err(not_ours(format!(
            "is a {} file, not a {CALIBRATION_SCHEMA} file",
            schema.name()
        )));
    }
    if !(1..=CALIBRATION_VERSION).contains(&schema.version) {
        return Err(Error::new(
            ErrorKind::Format,
            format!(
                "is of version {} of the calibration form; this program reads versions 1 to {CALIBRATION_VERSION}",
                schema.version
            ),
        )
        .with_hint("use the version of proofmass that wrote it (it stands under `software`), or calibrate again"));
    }
    Ok((head.kind.unwrap_or_default(), Cow::Borrowed(bytes)))
}

/// A document of a form of its own, with name and digest of its source; what is wrong names the source.
pub(crate) fn read_document<T>(
    source: Source,
    parse: impl FnOnce(&[u8]) -> Result<T>,
) -> Result<(T, Input)> {
    let name = source.name().to_path_buf();
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    let document = parse(&bytes).map_err(|e| e.at(&name))?;
    Ok((document, input))
}

/// A calibration of one kind; of another kind, `advice` says what to do.
pub(crate) fn parse_kind<T: DeserializeOwned>(
    bytes: &[u8],
    wanted: &[&str],
    advice: &str,
) -> Result<T> {
    let (kind, bytes) = opened(bytes)?;
    if !wanted.contains(&kind.as_str()) {
        let wanted = wanted.join("\" or \"");
        return Err(Error::new(
            ErrorKind::Format,
            format!("is a calibration of kind \"{kind}\"; one of kind \"{wanted}\" is needed here"),
        )
        .with_hint(advice));
    }
    serde_json::from_slice(&bytes).map_err(|e| {
        Error::new(
            ErrorKind::Format,
            format!("the calibration is damaged: {e}"),
        )
        .line(e.line() as u64)
        .with_hint("do not edit the file by hand; calibrate again")
        .because(e)
    })
}
