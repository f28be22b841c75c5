//! The report of an input that was found behind an output.

use proofmass_report::number::{concise, plain, two_digits};
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_signal::Trace;
use proofmass_uncertainty::Quantity;

/// What the report tells of a deconvolution.
#[derive(Clone, Debug)]
pub(crate) struct DeconvolutionReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Unit of the input.
    pub unit: &'a str,
    /// Greatest value.
    pub peak: Quantity,
    /// Greatest value of the output over the static sensitivity.
    pub plain_peak: f64,
    /// Corner of the low-pass, Hz.
    pub corner: f64,
    /// Standard uncertainties: noise, model at its greatest, regularisation.
    pub causes: [f64; 3],
    /// The input.
    pub value: Trace,
    /// Lower ends of the 95 % intervals.
    pub low: Trace,
    /// Upper ends.
    pub high: Trace,
    /// The output over the static sensitivity.
    pub plain: Trace,
}

impl DeconvolutionReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let line = |name: &str, t: &Trace| Series::line(name, &t.x, &t.y);
        let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("input", self.unit))
            .series(line("output over static sensitivity", &self.plain))
            .series(line("input", &self.value))
            .series(line("95 % interval, lower end", &self.low))
            .series(line("95 % interval, upper end", &self.high));
        self.summary()
            .section(
                Section::new("Time history")
                    .figure("The input, and the plain reading beside it", plot),
            )
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let figures = [
            KeyFigure::new(
                "peak",
                concise(self.peak.value, self.peak.standard_uncertainty),
                self.unit,
            ),
            KeyFigure::new(
                "plain reading",
                format!("{:.5}", self.plain_peak),
                self.unit,
            )
            .note("output over static sensitivity"),
            KeyFigure::new("corner of the low-pass", plain(self.corner), "Hz"),
        ];
        let mut table = Table::new(
            "Standard uncertainty of a sample, by cause",
            [Column::text("cause"), Column::number("u", self.unit)],
        );
        for (name, u) in [
            "noise of the output",
            "model, at its greatest",
            "what the low-pass removes",
        ]
        .into_iter()
        .zip(self.causes)
        {
            table = table.row([Cell::text(name), Cell::number(two_digits(u))]);
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").key_figures(figures).table(table))
    }
}
