//! Tables of the page alone whose rows are no records of one type.

use proofmass_report::{Cell, Field, Table};

/// Cells line by line under their headings and units.
pub(crate) fn lines<const N: usize>(
    caption: impl Into<String>,
    headings: [(&str, &str); N],
    rows: impl IntoIterator<Item = [Cell; N]>,
) -> Table {
    let cell = |k: usize| move |row: &[Cell; N]| row[k].clone();
    let headings = headings.into_iter().enumerate();
    let fields = headings.map(|(k, (heading, unit))| Field::shown(heading, unit, cell(k)));
    Table::of(caption, fields, rows)
}

/// Names with values and units; the heading is that of the names.
pub(crate) fn measures(
    caption: &str,
    heading: &str,
    rows: impl IntoIterator<Item = (impl Into<Cell>, Cell, impl Into<Cell>)>,
) -> Table {
    let rows = rows.into_iter();
    let rows = rows.map(|(name, value, unit)| [name.into(), value, unit.into()]);
    lines(caption, [(heading, ""), ("value", ""), ("unit", "")], rows)
}
