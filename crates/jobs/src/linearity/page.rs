//! The report of a linearity over the level.

use crate::page::parameters::parameters;
use proofmass_dynamic::linearity::LevelLinearity;
use proofmass_report::number::two_digits;
use proofmass_report::{Axis, Head, KeyFigure, Report, Section, Series, XyPlot};

/// What the report tells of a linearity over the level.
#[derive(Clone, Debug)]
pub(crate) struct LinearityReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// The fit.
    pub linearity: &'a LevelLinearity,
}

impl LinearityReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
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
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let figure = KeyFigure::new(
            "non-linearity",
            two_digits(100.0 * self.linearity.non_linearity),
            "%",
        )
        .note("largest departure, of the highest level");
        let mut quantities = self.linearity.estimate.quantities();
        for q in &mut quantities {
            q.name = q.name.replace('_', " ");
        }
        let table = parameters("Output = S a (1 + κ a)", &quantities);
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").key_figures([figure]).table(table))
    }
}
