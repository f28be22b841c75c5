//! How the text of a recording is laid out and timed, as every `[recording]` says it: declared once.

/// Declares a table of a campaign that names a recording, with the keys for its layout and its clock where the program does not see them itself.
macro_rules! text_table {
    ($(#[$about:meta])* pub struct $name:ident { $($fields:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($fields)*
            /// Stream of a file that holds several, by its name as `proofmass inspect` lists it.
            pub(crate) source: Option<String>,
            /// Time column, by name or number.
            pub(crate) time: Option<proofmass_io::ColumnRef>,
            /// `s`, `ms`, `us`, `ns`, `min`, `h`, `d` or `index`, where the heading of the time column does not say it.
            pub(crate) time_unit: Option<proofmass_io::TimeUnit>,
            /// Sampling rate, Hz, instead of a time column.
            #[serde(rename = "sampling_rate_Hz", alias = "sampling_rate_hz")]
            pub(crate) sampling_rate_hz: Option<f64>,
            /// The segment of every file that is read, from one time on and before another, s.
            pub(crate) between_s: Option<[f64; 2]>,
            /// `comma`, `semicolon`, `tab`, `pipe` or `whitespace`.
            separator: Option<proofmass_io::Separator>,
            /// Whether there is a header row.
            header: Option<bool>,
            /// Prefixes of comment lines.
            comment: Option<crate::campaign::Prefixes>,
            /// `point` or `comma`.
            decimal: Option<proofmass_io::DecimalMark>,
            /// Lines to pass over at the top.
            skip_lines: Option<usize>,
        }

        impl $name {
            /// The layout of the text, as far as it is stated.
            pub(crate) fn layout(&self) -> proofmass_io::LayoutOptions {
                proofmass_io::LayoutOptions {
                    separator: self.separator,
                    header: self.header,
                    comment: self.comment.as_ref().map(crate::campaign::Prefixes::list),
                    decimal: self.decimal,
                    skip_lines: self.skip_lines,
                }
            }
        }
    };
}

pub(in crate::campaign) use text_table;
