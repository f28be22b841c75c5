//! The report of a step response.

use crate::page::parameters::parameters;
use proofmass_report::{Axis, Head, KeyFigure, Report, Section, Series, XyPlot};
use proofmass_signal::Trace;
use proofmass_uncertainty::Quantity;

/// What the report tells of a step response.
#[derive(Clone, Debug)]
pub(crate) struct StepReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Name and unit of the channel.
    pub channel: (&'a str, &'a str),
    /// Fitted parameters.
    pub quantities: Vec<Quantity>,
    /// Rise time (s), overshoot, settling time (s).
    pub figures: [f64; 3],
    /// The record, the fit, their difference.
    pub traces: &'a [Trace; 3],
}

impl StepReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let [record, fit, residual] = self.traces;
        let (name, unit) = self.channel;
        let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear(name, unit))
            .series(Series::line("recorded", &record.x, &record.y))
            .series(Series::line("fitted", &fit.x, &fit.y))
            .below(Axis::linear("recorded − fitted", unit))
            .series(Series::line("", &residual.x, &residual.y));
        self.summary()
            .section(
                Section::new("Time history")
                    .figure("The step, the fitted oscillator, and what is left", plot),
            )
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let [rise, overshoot, settling] = self.figures;
        let figures = [
            KeyFigure::new("rise time", format!("{:.4}", 1e3 * rise), "ms").note("10 % to 90 %"),
            KeyFigure::new("overshoot", format!("{:.2}", 100.0 * overshoot), "%"),
            KeyFigure::new("settling time", format!("{:.4}", 1e3 * settling), "ms").note("to 2 %"),
        ];
        let table = parameters("Fitted oscillator", &self.quantities);
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").key_figures(figures).table(table))
    }
}
