//! Fitted parameters with their intervals, as the pages of dynamic tests show them.

use proofmass_report::number::{concise, two_digits};
use proofmass_report::{Cell, Column, Table};
use proofmass_uncertainty::Quantity;

/// A row for each parameter.
pub(crate) fn parameters(caption: &str, quantities: &[Quantity]) -> Table {
    let table = Table::new(
        caption,
        [
            Column::text("parameter"),
            Column::number("value", ""),
            Column::number("U (95 %)", ""),
            Column::text("unit"),
        ],
    );
    quantities.iter().fold(table, |table, q| {
        table.row([
            Cell::text(q.name.clone()),
            Cell::number(concise(q.value, q.standard_uncertainty)),
            Cell::number(two_digits(q.expanded(0.95))),
            Cell::text(q.unit.clone()),
        ])
    })
}
