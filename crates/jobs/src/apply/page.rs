//! The report of a compensated recording.

use proofmass_dynamic::frequency_response::{BandMatrix, CompensationError};
use proofmass_report::{Block, Cell, Column, Head, KeyFigure, Report, Section, Table};

/// What the report tells.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompensationReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Rows written.
    pub written: u64,
    /// Rows of the recording that are not among them.
    pub left_out: u64,
    /// What the compensation states about itself, where it is one over frequency.
    pub error: Option<&'a CompensationError>,
    /// The constant matrix of a band, where it is one.
    pub band: Option<&'a BandMatrix>,
    /// Length and sampling rate of a filter, where it is one.
    pub filter: Option<(usize, f64)>,
}

impl CompensationReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let mut figures = vec![
            KeyFigure::new("rows written", self.written.to_string(), "")
                .note(format!("{} left out", self.left_out)),
        ];
        if let Some((length, rate)) = self.filter {
            figures.push(
                KeyFigure::new("filter", length.to_string(), "samples")
                    .note(format!("at {rate:.6} Hz")),
            );
        }
        let mut section = Section::new("Result");
        if let Some(e) = self.error {
            let percent = |v: f64| format!("{:.3}", 100.0 * v);
            figures.push(
                KeyFigure::new("stated error", percent(e.stated), "%").note(format!(
                    "of the acceleration, {} Hz to {} Hz",
                    e.band[0], e.band[1]
                )),
            );
            let rows = [
                ("departure from the inverse of K", percent(e.departure), "%"),
                (
                    "the same, delay not taken out",
                    percent(e.departure_with_delay),
                    "%",
                ),
                (
                    "expanded uncertainty of K, 95 %",
                    percent(e.uncertainty),
                    "%",
                ),
                (
                    "interpolation between the frequencies",
                    e.interpolation.map_or("–".to_owned(), percent),
                    "%",
                ),
                (
                    "delay of the compensated signal",
                    format!("{:.3}", 1e6 * e.delay),
                    "µs",
                ),
            ];
            let mut table = Table::new(
                "Largest values over the band",
                [
                    Column::text("part"),
                    Column::text("value"),
                    Column::text("unit"),
                ],
            );
            for (part, value, unit) in rows {
                table = table.row([Cell::text(part), Cell::number(value), Cell::text(unit)]);
            }
            section = section.key_figures(figures).table(table);
        } else {
            section = section.key_figures(figures);
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(section)
    }

    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary();
        if let Some(band) = self.band {
            let n = (band.matrix.len() as f64).sqrt().round() as usize;
            let rows = |m: &[f64]| {
                m.chunks(n.max(1))
                    .map(|r| {
                        r.iter()
                            .map(|v| format!("{v:>14.7e}"))
                            .collect::<Vec<_>>()
                            .join(" ")
                    })
                    .collect::<Vec<_>>()
                    .join("\n")
            };
            report = report.section(
                Section::new("Matrix of the band")
                    .paragraph(
                        "K as a constant (rows: outputs) and its inverse, which was applied:",
                    )
                    .block(Block::Code(rows(&band.matrix)))
                    .block(Block::Code(rows(&band.inverse))),
            );
        }
        report.foot(&self.head)
    }
}
