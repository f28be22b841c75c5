//! `kind = "single-axis"`: one axis at rest, up and down or at many known angles.

use super::multi_position::GravityInput;
use super::statement::confidence;
use proofmass_io::{ColumnRef, Recording, RecordingOptions, Result, Unit};
use serde::Deserialize;

super::head::campaign! {
    /// One axis at known angles to the vertical.
    ///
    /// ```toml
    /// kind = "single-axis"
    ///
    /// [recording]
    /// files = ["up.csv", "down.csv"]      # or file = "table.csv" with `angle`, one reading a line
    /// column = "a"
    /// unit = "m/s²"
    ///
    /// [position]
    /// angles_deg = [0, 180]
    /// levelling_deg = 0.1
    ///
    /// [gravity]
    /// latitude_deg = 52.3
    /// height_m = 80
    /// ```
    pub struct SingleAxisCampaign {
        /// Where the readings are.
        pub(crate) recording: SingleAxisTable,
        /// The angles and how well the fixture holds them.
        #[serde(default)]
        pub(crate) position: PositionTable,
        /// Local gravity.
        pub(crate) gravity: GravityInput,
        /// How they are fitted.
        #[serde(default)]
        pub(crate) method: SingleAxisMethod,
    }
}

super::text_table::text_table! {
    /// `[recording]` of one axis.
    pub struct SingleAxisTable {
        /// A table of readings, or one recording in which the axis rests at one angle after the other.
        pub(crate) file: Option<String>,
        /// One file per angle.
        pub(crate) files: Option<Vec<String>>,
        /// Column of the output, by name or number.
        pub(crate) column: ColumnRef,
        /// Column of the angle between the axis and the vertical, degrees unless its heading says rad: every line is a reading.
        pub(crate) angle: Option<ColumnRef>,
        /// Column of the position, 1 up and −1 down: every line is a reading.
        pub(crate) position: Option<ColumnRef>,
        /// Unit of the output.
        pub(crate) unit: Option<Unit>,
    }
}

/// `[position]`: everything may be left out of a table that has a column of angles.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PositionTable {
    /// Angle between the axis and the vertical of each file or standstill in order, degrees: 0 up, 180 down.
    pub(crate) angles_deg: Option<Vec<f64>>,
    /// Standard uncertainty of the levelling of up and down, degrees.
    #[serde(default)]
    pub(crate) levelling_deg: f64,
    /// Standard uncertainty of the zero of the angle scale, degrees.
    #[serde(default)]
    pub(crate) zero_deg: f64,
    /// Standard uncertainty of the inclination of the axis of rotation off the level, degrees.
    #[serde(default)]
    pub(crate) lean_deg: f64,
    /// Standard uncertainty of the angle between the sensitive axis and the plane of turning, degrees.
    #[serde(default)]
    pub(crate) out_of_plane_deg: f64,
    /// Standard uncertainty of one reading of a table, in its unit, where there are no more readings than parameters.
    pub(crate) reading_standard_uncertainty: Option<f64>,
    /// Shortest standstill in one recording of all angles, s.
    pub(crate) minimum_duration_s: Option<f64>,
}

/// `[method]` of a single axis.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SingleAxisMethod {
    /// Probability of the intervals.
    pub(crate) confidence: f64,
}

impl Default for SingleAxisMethod {
    fn default() -> Self {
        Self { confidence: 0.95 }
    }
}

/// A name that stands in a list more than once.
pub(super) fn twice<'a>(names: impl Iterator<Item = &'a String> + Clone) -> Option<&'a String> {
    names
        .clone()
        .enumerate()
        .find(|(index, name)| names.clone().take(*index).any(|before| before == *name))
        .map(|(_, name)| name)
}

impl SingleAxisCampaign {
    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        self.gravity.check(&self.source)?;
        let (table, position) = (&self.recording, &self.position);
        self.source.check_between("recording", table.between_s)?;
        let refuse = |table: &str, key: &str, what: &str, hint: &str| {
            Err(self.source.refuse(table, key, what).with_hint(hint))
        };
        match (&table.file, &table.files) {
            (Some(_), None) => {}
            (None, Some(files)) if !files.is_empty() => {}
            (Some(_), Some(_)) => {
                return refuse(
                    "recording",
                    "files",
                    "`file` and `files` exclude each other",
                    "keep `files` for one file per angle",
                );
            }
            _ => {
                return refuse(
                    "recording",
                    "file",
                    "no recording is named",
                    "add file = \"…\" or files = [\"up.csv\", \"down.csv\"] to [recording]",
                );
            }
        }
        let columns = [&table.angle, &table.position];
        match (
            columns.into_iter().flatten().count(),
            &position.angles_deg,
            &table.files,
        ) {
            (0, Some(_), _) | (1, None, None) => {}
            (0, None, _) => {
                return refuse(
                    "recording",
                    "angle",
                    "the angles are not known",
                    "name the column of a table (angle = \"…\" or position = \"…\" in [recording]), or list them: angles_deg = [0, 180] in [position]",
                );
            }
            _ => {
                return refuse(
                    "recording",
                    if table.angle.is_some() {
                        "angle"
                    } else {
                        "position"
                    },
                    "the angles are given twice",
                    "keep one of `angle` and `position` for a table of readings, or `angles_deg` for files and standstills",
                );
            }
        }
        let files = table.files.iter().flatten();
        if let Some(twice) = twice(files) {
            return refuse(
                "recording",
                "files",
                &format!("{twice} is named twice"),
                "one recording cannot have been made at two angles",
            );
        }
        if let (Some(files), Some(angles)) = (&table.files, &position.angles_deg)
            && files.len() != angles.len()
        {
            return Err(self.source.refuse(
                "position",
                "angles_deg",
                format!("{} angles for {} files", angles.len(), files.len()),
            ));
        }
        let angles = position.angles_deg.iter().flatten();
        if let Some(angle) = angles.clone().find(|a| !a.is_finite()) {
            let what = format!("{angle} is no angle");
            return Err(self.source.refuse("position", "angles_deg", what));
        }
        for (key, value) in [
            ("levelling_deg", position.levelling_deg),
            ("zero_deg", position.zero_deg),
            ("lean_deg", position.lean_deg),
            ("out_of_plane_deg", position.out_of_plane_deg),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                let what =
                    format!("{value} is out of range: a standard uncertainty must not be negative");
                return Err(self
                    .source
                    .refuse("position", key, what)
                    .with_hint("give degrees from zero up"));
            }
        }
        for (section, key, value) in [
            ("recording", "sampling_rate_Hz", table.sampling_rate_hz),
            (
                "position",
                "reading_standard_uncertainty",
                position.reading_standard_uncertainty,
            ),
            (
                "position",
                "minimum_duration_s",
                position.minimum_duration_s,
            ),
        ] {
            if let Some(v) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                let what = format!("{v} is not a positive number");
                return Err(self.source.refuse(section, key, what));
            }
        }
        confidence(&self.source, self.method.confidence)?;
        Ok(())
    }

    /// Whether every line of the file is a reading with its angle or position.
    pub(crate) fn is_table(&self) -> bool {
        self.recording.angle.is_some() || self.recording.position.is_some()
    }

    /// Reads every file: of a table the angle or position first and the output second, else the output alone.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_recordings(&self) -> Result<Vec<Recording>> {
        let t = &self.recording;
        let known = t.angle.iter().chain(&t.position);
        let options = RecordingOptions {
            layout: t.layout(),
            columns: known.chain([&t.column]).cloned().collect(),
            time: t.time.clone(),
            time_unit: t.time_unit,
            // Readings have an order, not a clock.
            sampling_rate_hz: t.sampling_rate_hz,
            table: self.is_table() && t.time.is_none(),
            between: t.between_s,
            stream: t.source.clone(),
            ..RecordingOptions::default()
        };
        t.file
            .iter()
            .chain(t.files.iter().flatten())
            .map(|name| Recording::from_source(self.source.source(name)?, &options))
            .collect()
    }
}
