//! Which stream of a file is read, and as what.

use proofmass_io::{RecordingOptions, Source};
use serde::{Deserialize, Serialize};

/// Choice among the streams of a file that holds several, and whether its scaling counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct StreamChoice {
    /// Stream of a file that holds several, by its name as `proofmass inspect` lists it
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub source: Option<String>,
    /// Take the numbers as stored, without the scaling that a file declares (TDMS)
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "clap", arg(long))]
    pub raw: bool,
}

impl StreamChoice {
    /// The stream of a source that is chosen.
    #[must_use]
    pub fn stream_of(&self, source: Source) -> Source {
        source.with_stream(self.source.as_deref(), self.raw)
    }

    /// The same as options of a reader.
    pub(crate) fn options(&self) -> RecordingOptions {
        RecordingOptions {
            stream: self.source.clone(),
            as_stored: self.raw,
            ..RecordingOptions::default()
        }
    }
}
