//! Which stream of a file is read, and as what.

use proofmass_io::{DecimalMark, LayoutOptions, RecordingOptions, Separator, Source};
use serde::{Deserialize, Serialize};

/// Marks of a text that its look does not tell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct StatedMarks {
    /// Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe, whitespace
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "clap",
        arg(long, hide_short_help = true, value_name = "SEPARATOR", value_parser = crate::arguments::word::<Separator>)
    )]
    pub separator: Option<Separator>,
    /// Decimal mark of a text, where its look does not tell: point, comma
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "clap",
        arg(long, hide_short_help = true, value_name = "MARK", value_parser = crate::arguments::word::<DecimalMark>)
    )]
    pub decimal: Option<DecimalMark>,
}

impl StatedMarks {
    /// What is stated, as keys and words of a campaign.
    pub(crate) fn words(&self) -> Vec<(&'static str, String)> {
        let word = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
        let separator = self.separator.map(|s| ("separator", serde_json::json!(s)));
        let decimal = self.decimal.map(|d| ("decimal", serde_json::json!(d)));
        let stated = separator.into_iter().chain(decimal);
        stated.map(|(key, value)| (key, word(value))).collect()
    }

    /// The same as options of a reader.
    fn layout(&self) -> LayoutOptions {
        LayoutOptions {
            separator: self.separator,
            decimal: self.decimal,
            ..LayoutOptions::default()
        }
    }

    /// The source with what is stated of it.
    #[must_use]
    pub fn of(&self, mut source: Source) -> Source {
        self.mark(&mut source);
        source
    }

    /// States them of a source.
    pub(crate) fn mark(&self, source: &mut Source) {
        source.state_layout(self.layout());
    }
}

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
    /// How a text is to be read.
    #[serde(flatten)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub marks: StatedMarks,
}

impl StreamChoice {
    /// The stream of a source that is chosen.
    #[must_use]
    pub fn stream_of(&self, source: Source) -> Source {
        let mut source = source.with_stream(self.source.as_deref(), self.raw);
        self.marks.mark(&mut source);
        source
    }

    /// The same as options of a reader.
    pub(crate) fn options(&self) -> RecordingOptions {
        RecordingOptions {
            layout: self.marks.layout(),
            stream: self.source.clone(),
            as_stored: self.raw,
            ..RecordingOptions::default()
        }
    }
}
