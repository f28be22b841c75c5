//! How the text of a recording is laid out, as every `[recording]` says it: declared once.

/// Declares a table of a campaign that names a recording, with the keys for its layout where the program does not see it itself.
macro_rules! text_table {
    ($(#[$about:meta])* pub struct $name:ident { $($fields:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($fields)*
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
