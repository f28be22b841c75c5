//! The report of an input that was found behind an output.

use crate::number::{concise, plain, two_digits};
use crate::{Axis, Cell, Column, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_signal::Trace;
use proofmass_uncertainty::{Finding, Quantity};

/// What the report tells of a deconvolution.
#[derive(Clone, Debug)]
pub struct DeconvolutionReport<'a> {
    /// Title.
    pub title: String,
    /// Label and value.
    pub meta: Vec<(String, String)>,
    /// Name and SHA-256 of each input file.
    pub inputs: Vec<(String, String)>,
    /// All findings.
    pub findings: &'a [Finding],
    /// Last line.
    pub footer: String,
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
    pub fn full(&self) -> Report {
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
            .section(Section::new("Inputs").inputs(&self.inputs))
            .footer(self.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self) -> Report {
        let mut report = Report::new(self.title.clone());
        for (label, value) in &self.meta {
            report = report.meta(label.clone(), value.clone());
        }
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
            .findings(self.findings.iter().cloned())
            .section(Section::new("Result").key_figures(figures).table(table))
    }
}
