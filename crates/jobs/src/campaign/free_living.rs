//! `kind = "free-living"`: days of a logger on a wrist or a machine.

use super::multi_position::{Axes, GravityInput};
use super::statement::confidence;
use proofmass_io::{ColumnRef, Result, Unit};
use proofmass_static::Stop;
use serde::Deserialize;

super::head::campaign! {
    /// A recording of days, calibrated from its still moments.
    ///
    /// ```toml
    /// kind = "free-living"
    ///
    /// [recording]
    /// file = "wrist.csv.gz"
    /// columns = { x = "x", y = "y", z = "z" }
    /// time = "t"
    /// temperature = "temperature"
    /// unit = "g"
    /// ```
    pub struct FreeLivingCampaign {
        /// Where the samples are.
        pub(crate) recording: StreamTable,
        /// How they are fitted.
        #[serde(default)]
        pub(crate) method: FreeLivingMethod,
        /// Gravity where it was worn; `None`: anywhere on the ground.
        pub(crate) gravity: Option<GravityInput>,
    }
}

super::text_table::text_table! {
    /// `[recording]` of a stream.
    pub struct StreamTable {
        /// The file, relative to the campaign.
        pub(crate) file: String,
        /// `text`, or `f32` for raw floats.
        #[serde(default)]
        pub(crate) format: StreamFormat,
        /// Channels in a file of raw floats, when there are more than are named.
        pub(crate) channel_count: Option<usize>,
        /// Columns of the axes, by name or number.
        pub(crate) columns: Axes,
        /// Temperature column, by name or number.
        pub(crate) temperature: Option<ColumnRef>,
        /// Unit of the three axes, where the headings do not say it.
        pub(crate) unit: Option<Unit>,
    }
}

/// Form of the samples of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum StreamFormat {
    /// A table with one row per instant.
    #[default]
    Text,
    /// Little-endian 32-bit floats, the channels of one instant side by side, nothing else in the file.
    F32,
}

/// `[method]` of a free-living campaign.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FreeLivingMethod {
    /// `converged`, or `published` to equal programs that stop early.
    pub(crate) stop: Stop,
    /// Whether temperature is a regressor where there is one.
    pub(crate) temperature: bool,
    /// Probability of the intervals.
    pub(crate) confidence: f64,
}

impl Default for FreeLivingMethod {
    fn default() -> Self {
        Self {
            stop: Stop::Converged,
            temperature: true,
            confidence: 0.95,
        }
    }
}

impl FreeLivingCampaign {
    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        confidence(&self.source, self.method.confidence)?;
        if let Some(rate) = self.recording.sampling_rate_hz
            && !(rate.is_finite() && rate > 0.0)
        {
            return Err(self.source.refuse(
                "recording",
                "sampling_rate_Hz",
                format!("{rate} is not a positive number"),
            ));
        }
        self.source
            .check_between("recording", self.recording.between_s)?;
        match &self.gravity {
            Some(gravity) => gravity.check(&self.source),
            None => Ok(()),
        }
    }
}
