//! Tables of words.

use proofmass_report::{Field, Table};

/// Columns of text under their headings, for the page alone.
pub(crate) fn words<const N: usize>(
    caption: impl Into<String>,
    headings: [&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> Table {
    let text = |k: usize| move |row: &[String; N]| row[k].clone().into();
    let headings = headings.into_iter().enumerate();
    let fields = headings.map(|(k, heading)| Field::shown(heading, "", text(k)));
    Table::of(caption, fields, rows)
}
