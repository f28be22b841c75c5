//! `kind = "multi-position"`: a triaxial accelerometer held still in many positions.

use super::single_axis::twice;
use super::statement::confidence;
use super::{CampaignFile, Unsaid};
use proofmass_io::SegmentRow;
use proofmass_io::{ColumnRef, Layout};
use proofmass_io::{
    Error, ErrorKind, GivenAttitude, Input, Recording, RecordingOptions, Result, Unit,
    check_agreement,
};
use proofmass_static::Terms;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

super::head::campaign! {
    /// The tables of a multi-position campaign.
    ///
    /// ```toml
    /// kind = "multi-position"
    /// title = "Hand-held positions, unit 0300"
    ///
    /// [device]
    /// manufacturer = "Xsens"
    /// model = "MTi"
    ///
    /// [recording]
    /// file = "recording.txt"
    /// columns = { x = 2, y = 3, z = 4 }
    /// time = 1
    /// time_unit = "s"
    /// unit = "count"
    ///
    /// [gravity]
    /// value = 9.81744
    /// standard_uncertainty = 2e-5
    /// ```
    #[non_exhaustive]
    pub struct MultiPositionCampaign {
        /// Where the samples are.
        pub(crate) recording: RecordingTable,
        /// Local gravity.
        pub(crate) gravity: GravityInput,
        /// How standstills are found.
        #[serde(default)]
        pub(crate) standstill: StandstillTable,
        /// What is fitted.
        #[serde(default)]
        pub method: MethodTable,
        /// What is fitted beside the matrix.
        #[serde(default)]
        pub(crate) terms: Terms,
        /// Uncertainty of given attitudes.
        #[serde(default)]
        pub(crate) attitude: AttitudeTable,
    }
}

/// Columns of the three axes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Column of x.
    pub(crate) x: ColumnRef,
    /// Column of y.
    pub(crate) y: ColumnRef,
    /// Column of z.
    pub(crate) z: ColumnRef,
}

super::text_table::text_table! {
    /// `[recording]`: files, shape of the text, columns, times, unit.
    pub struct RecordingTable {
        /// One file, relative to the campaign.
        pub(crate) file: Option<String>,
        /// Several files, each a recording of its own.
        pub(crate) files: Option<Vec<String>>,
        /// Columns of the axes, by name or number.
        pub(crate) columns: Axes,
        /// Temperature column, by name or number.
        pub(crate) temperature: Option<ColumnRef>,
        /// Unit of the three axes.
        pub(crate) unit: Option<Unit>,
        /// Smallest and largest output in that unit, beyond which the converter clips.
        pub(crate) range: Option<[f64; 2]>,
        /// What a row is: a sample of a recording, or a reading (a mean) of its own.
        #[serde(default)]
        pub(crate) rows: RowsAre,
        /// What a file is: a recording in which standstills are found, or one standstill.
        #[serde(default)]
        pub(crate) each_file: FileIs,
    }
}

/// What a row of a table is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RowsAre {
    /// One sample among many.
    #[default]
    Samples,
    /// A reading or a mean in an attitude of its own.
    Readings,
    /// One sample of a sensor that is turned slowly all the time.
    Tumble,
}

/// What a file is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FileIs {
    /// A recording in which standstills are to be found.
    #[default]
    Recording,
    /// One standstill from beginning to end.
    Standstill,
}

/// One prefix or several.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Prefixes {
    /// One.
    One(String),
    /// Several.
    Several(Vec<String>),
}

impl Prefixes {
    pub(super) fn list(&self) -> Vec<String> {
        match self {
            Self::One(one) => vec![one.clone()],
            Self::Several(all) => all.clone(),
        }
    }
}

/// `[gravity]`: given, or from the place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GravityInput {
    /// Local gravity, m/s².
    pub(crate) value: Option<f64>,
    /// Its standard uncertainty, m/s²; of a place that of the resulting value, instead of the model's own.
    pub(crate) standard_uncertainty: Option<f64>,
    /// Geodetic latitude, degrees, instead of a value.
    pub(crate) latitude_deg: Option<f64>,
    /// Height above the ellipsoid (or the sea), m.
    pub(crate) height_m: Option<f64>,
    /// Standard uncertainty of the latitude, degrees.
    pub(crate) latitude_standard_uncertainty_deg: Option<f64>,
    /// Standard uncertainty of the height, m.
    pub(crate) height_standard_uncertainty_m: Option<f64>,
}

/// `[standstill]`: everything may be left out.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StandstillTable {
    /// Shortest standstill, s.
    pub(crate) minimum_duration_s: Option<f64>,
    /// Window of the moving variance, s.
    pub(crate) window_s: Option<f64>,
    /// Threshold of the variance relative to that of the quietest stretch, instead of a sweep.
    pub(crate) threshold: Option<f64>,
    /// Table of given segments, relative to the campaign.
    pub(crate) segments: Option<String>,
    /// Attitude of each standstill in order, where each file or each row is one: the axis that points up (`+x`, `-z`), or several
    /// where it points between them (`+x+y`); or a unit vector, or a table with angles or the true acceleration.
    pub(crate) directions: Option<Vec<StatedAttitude>>,
    /// Standstills that are left out, by number counted from one or by label.
    #[serde(default)]
    pub(crate) exclude: Vec<NumberOrLabel>,
    /// Standard uncertainty of a reading from its noise, in the unit of the file, where rows are readings.
    pub(crate) reading_standard_uncertainty: Option<f64>,
}

/// The attitude of one standstill.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "an attitude is a word (\"+x\", \"+x+y\"), a unit vector of three numbers, or a table such as { roll_deg = 45, pitch_deg = 0 } or { a_true = [6.93, 6.93, 0], u_a_true = 0.01 }"
)]
pub enum StatedAttitude {
    /// The axis that points up, or several.
    Word(String),
    /// A unit vector, up in the axes of the sensor.
    Vector([f64; 3]),
    /// Angles or the true acceleration.
    Table(AttitudeEntry),
}

/// An attitude by angles, or by the true acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AttitudeEntry {
    /// Turn about the x axis of the sensor, from z up, degrees.
    pub(crate) roll_deg: Option<f64>,
    /// Then turn about the level y axis, degrees.
    pub(crate) pitch_deg: Option<f64>,
    /// True acceleration in the axes of the sensor, m/s².
    pub(crate) a_true: Option<[f64; 3]>,
    /// Standard uncertainty of each of its components, m/s².
    pub(crate) u_a_true: Option<f64>,
}

impl StatedAttitude {
    /// What it says.
    pub(crate) fn given(&self) -> Result<GivenAttitude> {
        match self {
            Self::Word(word) => GivenAttitude::word(word),
            Self::Vector(v) => GivenAttitude::vector(*v),
            Self::Table(entry) => entry.given(),
        }
    }
}

impl AttitudeEntry {
    fn given(&self) -> Result<GivenAttitude> {
        let refuse = |what: &str| {
            Err(Error::new(ErrorKind::Configuration, what).with_hint(
                "give { roll_deg = …, pitch_deg = … }, or { a_true = [x, y, z], u_a_true = … } in m/s²",
            ))
        };
        let angles = match (self.roll_deg, self.pitch_deg) {
            (Some(roll), Some(pitch)) => Some(GivenAttitude::angles(
                roll.to_radians(),
                pitch.to_radians(),
            )?),
            (None, None) => None,
            _ => return refuse("of roll_deg and pitch_deg one is missing"),
        };
        let truth = match (self.a_true, self.u_a_true) {
            (Some(value), u) => Some(GivenAttitude::acceleration(value, u)?),
            (None, Some(_)) => return refuse("u_a_true stands without a_true"),
            (None, None) => None,
        };
        match (angles, truth) {
            (Some(angles), Some(truth)) => {
                check_agreement(&angles, &truth)?;
                Ok(truth)
            }
            (Some(one), None) | (None, Some(one)) => Ok(one),
            (None, None) => refuse("the attitude says nothing"),
        }
    }
}

/// How a standstill is called.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum NumberOrLabel {
    /// Counted from one.
    Number(u32),
    /// Label of the table of standstills, or name of the file.
    Label(String),
}

impl std::fmt::Display for NumberOrLabel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Label(label) => f.write_str(label),
        }
    }
}

/// What is fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MethodModel {
    /// Bias only.
    Bias,
    /// Bias and three scale factors.
    BiasScale,
    /// Bias and an upper-triangular K, nine parameters.
    #[default]
    Triangular,
    /// Bias and a symmetric K, nine parameters.
    Symmetric,
    /// All twelve; needs given attitudes.
    Full,
    /// Six positions, closed form.
    SixPosition,
    /// Six positions after Ferraris.
    Ferraris,
    /// Ellipsoid fit.
    Ellipsoid,
}

impl MethodModel {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Bias,
        Self::BiasScale,
        Self::Triangular,
        Self::Symmetric,
        Self::Full,
        Self::SixPosition,
        Self::Ferraris,
        Self::Ellipsoid,
    ];

    /// The word in the campaign.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::BiasScale => "bias-scale",
            Self::Triangular => "triangular",
            Self::Symmetric => "symmetric",
            Self::Full => "full",
            Self::SixPosition => "six-position",
            Self::Ferraris => "ferraris",
            Self::Ellipsoid => "ellipsoid",
        }
    }

    /// Whether the fit needs attitudes to be given.
    pub(crate) fn needs_attitudes(self) -> bool {
        matches!(self, Self::Full | Self::SixPosition | Self::Ferraris)
    }
}

/// `[method]`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct MethodTable {
    /// What is fitted.
    pub model: MethodModel,
    /// Probability of the intervals.
    pub confidence: f64,
    /// Largest standard uncertainty at which a parameter is a result: of a scale factor relative, of a misalignment in
    /// rad, of a bias in units of g.
    pub(crate) largest_uncertainty: Option<f64>,
}

impl Default for MethodTable {
    fn default() -> Self {
        Self {
            model: MethodModel::default(),
            confidence: 0.95,
            largest_uncertainty: None,
        }
    }
}

/// `[attitude]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AttitudeTable {
    /// Standard uncertainty of a given direction, per transverse axis, degrees.
    pub(crate) standard_uncertainty_deg: Option<f64>,
    /// Standard uncertainty of the frame of all attitudes about each of its axes, degrees: how the sensor is aligned with the fixture.
    pub(crate) frame_standard_uncertainty_deg: Option<f64>,
    /// Standard uncertainty of each component of a true acceleration, m/s², where it does not stand beside it (`u_a_true`).
    pub(crate) a_true_standard_uncertainty: Option<f64>,
    /// For true accelerations that are not gravity alone, as on a centrifuge: their lengths count, and this is the relative
    /// standard uncertainty common to all of them.
    pub(crate) a_true_relative_standard_uncertainty: Option<f64>,
}

impl MultiPositionCampaign {
    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        if self.gravity.value.is_none() && self.gravity.latitude_deg.is_none() {
            self.ask(true)?;
        }
        self.gravity.check(&self.source)?;
        let table = &self.recording;
        let refuse =
            |table: &str, key: &str, what: String| Err(self.source.refuse(table, key, what));
        match (&table.file, &table.files) {
            (Some(_), Some(_)) => {
                return refuse(
                    "recording",
                    "files",
                    "`file` and `files` exclude each other".into(),
                );
            }
            (None, None) => {
                return Err(self
                    .source
                    .refuse("recording", "file", "no recording is named")
                    .with_hint(
                        "add file = \"…\" to [recording], relative to the folder of the campaign",
                    ));
            }
            (None, Some(files)) if twice(files.iter()).is_some() => {
                let name = twice(files.iter()).map_or("", String::as_str);
                return refuse(
                    "recording",
                    "files",
                    format!("{name} is named twice: the same standstills would count twice"),
                );
            }
            (None, Some(files)) if files.is_empty() => {
                return refuse(
                    "recording",
                    "files",
                    "the list of recordings is empty".into(),
                );
            }
            _ => {}
        }
        let positive = |table: &str, key: &str, value: Option<f64>| match value {
            Some(v) if !(v.is_finite() && v > 0.0) => {
                Err(self
                    .source
                    .refuse(table, key, format!("{v} is not a positive number")))
            }
            _ => Ok(()),
        };
        positive("recording", "sampling_rate_Hz", table.sampling_rate_hz)?;
        self.source.check_between("recording", table.between_s)?;
        positive(
            "standstill",
            "minimum_duration_s",
            self.standstill.minimum_duration_s,
        )?;
        positive("standstill", "window_s", self.standstill.window_s)?;
        positive("standstill", "threshold", self.standstill.threshold)?;
        positive(
            "standstill",
            "reading_standard_uncertainty",
            self.standstill.reading_standard_uncertainty,
        )?;
        positive(
            "method",
            "largest_uncertainty",
            self.method.largest_uncertainty,
        )?;
        if table.rows == RowsAre::Tumble {
            let search = &self.standstill;
            if search.segments.is_some() || table.each_file == FileIs::Standstill {
                return refuse(
                    "recording",
                    "rows",
                    "a sensor that is turned all the time has no standstills".into(),
                );
            }
            if self.method.model.needs_attitudes() {
                return refuse(
                    "method",
                    "model",
                    "of a tumble no attitudes are known".into(),
                );
            }
        }
        let single = table.rows == RowsAre::Readings || table.each_file == FileIs::Standstill;
        if self.standstill.directions.is_some() && !single {
            return Err(self
                .source
                .refuse(
                    "standstill",
                    "directions",
                    "a list of directions has no standstills to belong to",
                )
                .with_hint("add each_file = \"standstill\" or rows = \"readings\" to [recording], or give `segments`"));
        }
        if self.standstill.reading_standard_uncertainty.is_some() && table.rows != RowsAre::Readings
        {
            return refuse(
                "standstill",
                "reading_standard_uncertainty",
                "the noise of standstills is taken from their samples; this is for rows = \"readings\" in [recording]".into(),
            );
        }
        if self.standstill.segments.is_some() && single {
            return refuse(
                "standstill",
                "segments",
                "each file or row is a standstill already; give `directions`".into(),
            );
        }
        let attitude = &self.attitude;
        let relative = attitude.a_true_relative_standard_uncertainty;
        for (key, value) in [
            (
                "standard_uncertainty_deg",
                attitude.standard_uncertainty_deg,
            ),
            (
                "frame_standard_uncertainty_deg",
                attitude.frame_standard_uncertainty_deg,
            ),
            (
                "a_true_standard_uncertainty",
                attitude.a_true_standard_uncertainty,
            ),
            ("a_true_relative_standard_uncertainty", relative),
        ] {
            positive("attitude", key, value)?;
        }
        if let Some(u) = relative.filter(|u| *u >= 1.0) {
            return Err(self
                .source
                .refuse(
                    "attitude",
                    "a_true_relative_standard_uncertainty",
                    format!("{u} is more than the acceleration itself"),
                )
                .with_hint("relative, 0.001 is a thousandth"));
        }
        let orders = [
            ("bias", self.terms.bias),
            ("scale", self.terms.scale),
            ("curvature", self.terms.curvature),
        ];
        for (key, order) in orders {
            if order > 3 || (key == "curvature" && order == 1) {
                let what = match key {
                    "curvature" => "the largest power of the acceleration is 2 or 3",
                    _ => "the largest power of the temperature is 0 to 3",
                };
                return refuse("terms", key, format!("{order}: {what}"));
            }
        }
        if let Some(t) = self.terms.reference
            && !(-273.15..=10_000.0).contains(&t)
        {
            return refuse(
                "terms",
                "reference_degC",
                format!("{t} °C is out of range: from −273.15 °C to 10 000 °C"),
            );
        }
        if let Some(t) = self.ambient.temperature_deg_c
            && !(-273.15..=10_000.0).contains(&t)
        {
            return refuse(
                "ambient",
                "temperature_degC",
                format!("{t} °C is out of range: from −273.15 °C to 10 000 °C"),
            );
        }
        if let Some([lo, hi]) = table.range
            && !(lo.is_finite() && hi.is_finite() && lo < hi)
        {
            return refuse(
                "recording",
                "range",
                format!("[{lo}, {hi}] is not an interval"),
            );
        }
        if let Some(unit) = table.unit
            && !(unit.is_acceleration() || unit.is_raw())
        {
            return Err(self
                .source
                .refuse(
                    "recording",
                    "unit",
                    format!("{unit} is not a unit of an accelerometer's output"),
                )
                .with_hint("known units: m/s², mm/s², g, mg, µg, Gal, count, V, mV, µV"));
        }
        confidence(&self.source, self.method.confidence)?;
        Ok(())
    }

    /// Asks for all that neither the first recording nor the campaign says, in one refusal; `place` is part of it.
    pub(crate) fn ask(&self, place: bool) -> Result<()> {
        let (name, options) = (self.names().next(), self.recording_options());
        let opened = name.and_then(|name| self.source.source(name).ok());
        // What cannot be read is refused where it is read.
        let layout = opened.and_then(|mut source| Layout::of(&mut source, &options.layout).ok());
        let Some((layout, name)) = layout.zip(name) else {
            return Ok(());
        };
        let signals: Vec<usize> = options
            .columns
            .iter()
            .filter_map(|column| layout.find(column).ok())
            .collect();
        let unsaid = Unsaid {
            signals: &signals,
            unit: options.unit,
            time: options.time.as_ref().and_then(|t| layout.find(t).ok()),
            time_unit: options.time_unit,
            rate_hz: options.sampling_rate_hz,
            timeless: options.table,
        };
        let refused = unsaid.refuse(&layout, place);
        refused.map_err(|e| e.at(&self.source.resolve(name)))
    }

    /// The recordings, with their paths resolved.
    pub fn files(&self) -> Vec<PathBuf> {
        self.names().map(|name| self.source.resolve(name)).collect()
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &String> {
        let table = &self.recording;
        table.file.iter().chain(table.files.iter().flatten())
    }

    /// How each recording is to be read.
    pub(crate) fn recording_options(&self) -> RecordingOptions {
        let t = &self.recording;
        RecordingOptions {
            layout: t.layout(),
            columns: vec![
                t.columns.x.clone(),
                t.columns.y.clone(),
                t.columns.z.clone(),
            ],
            time: t.time.clone(),
            time_unit: t.time_unit,
            // A table of readings has no time: its rows are numbered.
            sampling_rate_hz: t.sampling_rate_hz,
            table: t.rows == RowsAre::Readings && t.time.is_none(),
            temperature: t.temperature.clone(),
            between: t.between_s,
            stream: t.source.clone(),
            unit: t.unit,
            ..RecordingOptions::default()
        }
    }

    /// Reads the recordings, columns x, y, z in the unit of the file.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_recordings(&self) -> Result<Vec<Recording>> {
        let options = self.recording_options();
        self.names()
            .map(|name| Recording::from_source(self.source.source(name)?, &options))
            .collect()
    }

    /// Reads the given segments against a recording; `None` where standstills are to be found.
    ///
    /// # Errors
    /// As [`SegmentRow::from_source`].
    pub fn read_segments(&self, recording: &Recording) -> Result<Option<(Vec<SegmentRow>, Input)>> {
        let Some(name) = &self.standstill.segments else {
            return Ok(None);
        };
        SegmentRow::from_source(self.source.source(name)?, recording).map(Some)
    }
}

impl GravityInput {
    /// Refuses what is impossible, or said twice or not at all.
    pub(super) fn check(&self, source: &CampaignFile) -> Result<()> {
        let refuse = |key: &str, what: String, hint: &str| {
            Err(source.refuse("gravity", key, what).with_hint(hint))
        };
        for (key, u) in [
            ("standard_uncertainty", self.standard_uncertainty),
            (
                "latitude_standard_uncertainty_deg",
                self.latitude_standard_uncertainty_deg,
            ),
            (
                "height_standard_uncertainty_m",
                self.height_standard_uncertainty_m,
            ),
        ] {
            if let Some(u) = u
                && !(u.is_finite() && u >= 0.0)
            {
                return refuse(
                    key,
                    format!("{u} is out of range: a standard uncertainty must not be negative"),
                    "give a number from zero up",
                );
            }
        }
        match (self.value, self.latitude_deg) {
            (Some(_), Some(_)) => refuse(
                "value",
                "`value` and `latitude_deg` exclude each other".into(),
                "keep the measured value",
            ),
            (Some(value), None) => {
                if self.height_m.is_some()
                    || self.latitude_standard_uncertainty_deg.is_some()
                    || self.height_standard_uncertainty_m.is_some()
                {
                    return refuse(
                        "value",
                        "a given value needs neither latitude nor height".into(),
                        "keep `value` and `standard_uncertainty`",
                    );
                }
                // The Earth's surface spans 9.76 to 9.84; beyond 9.7 to 9.9 the unit or the digits are wrong.
                if !(9.7..=9.9).contains(&value) {
                    return refuse(
                        "value",
                        format!(
                            "a local gravity of {value} m/s² is out of range: on the ground it is 9.7 m/s² to 9.9 m/s²"
                        ),
                        "give it in m/s², such as 9.8127",
                    );
                }
                if self.standard_uncertainty.is_none() {
                    return refuse(
                        "standard_uncertainty",
                        "the uncertainty of gravity is missing".into(),
                        "add standard_uncertainty = … in m/s² (a surveyed value: 1e-5, a value from a map: 1e-3)",
                    );
                }
                Ok(())
            }
            (None, Some(latitude_deg)) => {
                if !(-90.0..=90.0).contains(&latitude_deg) {
                    return refuse(
                        "latitude_deg",
                        format!("a latitude of {latitude_deg}° is out of range: from −90° to 90°"),
                        "give degrees north; south is negative",
                    );
                }
                let Some(height_m) = self.height_m else {
                    return refuse(
                        "height_m",
                        "the height is missing".into(),
                        "add height_m = …; 100 m change gravity by 0.3 mm/s²",
                    );
                };
                if !(-500.0..=9_000.0).contains(&height_m) {
                    return refuse(
                        "height_m",
                        format!("a height of {height_m} m is not on the ground"),
                        "give metres above the sea",
                    );
                }
                Ok(())
            }
            (None, None) => refuse(
                "value",
                "local gravity is not given".into(),
                "add `value` and `standard_uncertainty`, or `latitude_deg` and `height_m`",
            ),
        }
    }
}
