//! The report of a linearity over the level.

use crate::number::{concise, two_digits};
use crate::{Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_calibration::dynamic::linearity::LevelLinearity;

/// What the report tells of a linearity over the level.
#[derive(Clone, Debug)]
pub struct LinearityReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// The fit.
    pub linearity: &'a LevelLinearity,
}

impl LinearityReport<'_> {
    /// The whole report.
    pub fn full(&self) -> Report {
        let points: Vec<(f64, f64, f64)> = self
            .linearity
            .departures
            .iter()
            .map(|[a, d, u]| (*a, 100.0 * d, 200.0 * u))
            .collect();
        let plot = XyPlot::new(
            Axis::linear("level", "m/s²"),
            Axis::linear("departure from the best straight line", "%"),
        )
        .horizontal(0.0, "")
        .series(Series::intervals("", &points));
        self.summary()
            .section(Section::new("Levels").figure(
                "Departures from the best straight line through zero; bars are two standard uncertainties",
                plot,
            ))
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self) -> Report {
        let report = self.head.open();
        let figure = KeyFigure::new(
            "non-linearity",
            two_digits(100.0 * self.linearity.non_linearity),
            "%",
        )
        .note("largest departure, of the highest level");
        let mut table = Table::new(
            "Output = S a (1 + κ a)",
            [
                Column::text("parameter"),
                Column::number("value", ""),
                Column::number("U (95 %)", ""),
                Column::text("unit"),
            ],
        );
        for q in self.linearity.estimate.quantities() {
            table = table.row([
                Cell::text(q.name.replace('_', " ")),
                Cell::number(concise(q.value, q.standard_uncertainty)),
                Cell::number(two_digits(q.expanded(0.95))),
                Cell::text(q.unit.clone()),
            ]);
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").key_figures([figure]).table(table))
    }
}
