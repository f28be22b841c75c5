//! The result with the runs that contradict the others beside the one without.

use super::digits::{TERMS, Unit};
use super::sign;
use proofmass_report::number::plain;
use proofmass_report::{Cell, Column, Section, Table};
use proofmass_shaker::ShakerCalibration;

/// Frequencies with runs that contradict the others, with them and without.
pub(super) fn section(calibration: &ShakerCalibration, unit: Unit) -> Option<Section> {
    if calibration.contested.is_empty() {
        return None;
    }
    let mut columns = vec![Column::number("f", "Hz"), Column::text("result")];
    columns.extend(TERMS.map(|t| Column::number(format!("S_{t}"), unit.name)));
    let mut table = Table::new(
        "Real parts of S with and without the runs in question",
        columns,
    );
    let mut names: Vec<&str> = vec![];
    for c in &calibration.contested {
        names.extend(c.runs.iter().map(String::as_str));
        let correction = match calibration
            .contested
            .iter()
            .any(|o| o.correction != c.correction)
        {
            true => format!(" ({})", c.correction),
            false => String::new(),
        };
        let mut row = |words: &str, s: &[[f64; 2]]| {
            let mut cells = vec![
                Cell::number(plain(c.frequency)),
                Cell::text(format!("{words}{correction}")),
            ];
            let parts = s
                .iter()
                .map(|[re, _]| sign(format!("{:.4}", unit.factor * re)));
            cells.extend(parts.map(Cell::number));
            table = std::mem::take(&mut table).row(cells);
        };
        row("without", &c.without);
        if let Some(with) = &c.with {
            row("with", with);
        }
    }
    names.sort_unstable();
    names.dedup();
    Some(
        Section::new("Result with and without the runs in question")
            .paragraph(format!(
                "Run {} contradicts the others. The result is without; at these frequencies its intervals reach the result with \
                 every run (of that frequency alone), U² = (k u)² + ΔS², until somebody has decided. Other frequencies are not \
                 touched. Where only one line stands, no angles reconcile the runs with the others.",
                names.join(", ")
            ))
            .table(table),
    )
}
