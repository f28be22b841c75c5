//! The report of a measurement of the spurious motion.

use proofmass_report::number::{plain, two_digits};
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, Block, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_shaker::SpuriousTable;
use proofmass_shaker::spurious::{Average, Comparison, RatioSummary};

/// What the report tells about a measurement of the spurious motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpuriousReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Labels of other measurements and calculated motions, and the comparison with each.
    pub comparisons: Vec<(&'a str, &'a [Comparison])>,
}

impl SpuriousReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, summaries: &[RatioSummary], table: &SpuriousTable) -> Report {
        let mut report = self
            .summary(summaries, table)
            .section(curves(table))
            .section(circular(summaries));
        for (label, comparison) in &self.comparisons {
            report = report.section(compared(label, comparison));
        }
        let section = Section::new("Inputs and method").inputs(&self.head.inputs);
        report
            .section(section.paragraph(
                "Ratios of the motion along each axis of the bench to the reference acceleration, jΩ v/a. Averages are of \
                 complex ratios, never of degrees; repeats whose moduli agree while their phases cover the circle were \
                 recorded without a common clock and are not averaged.",
            ))
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, summaries: &[RatioSummary], table: &SpuriousTable) -> Report {
        let report = self.head.open().subtitle(format!(
            "Spurious motion of the bench: {} ratios at {} places",
            summaries.len(),
            table.entries.len()
        ));
        let refused = summaries
            .iter()
            .filter(|s| matches!(s.average, Average::Incoherent { .. }))
            .count();
        let largest = table
            .entries
            .iter()
            .flat_map(|e| {
                e.ratio
                    .iter()
                    .zip(AXES)
                    .map(move |(z, axis)| (z.norm(), axis, e))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let mut figures = vec![
            KeyFigure::new(
                "ratios averaged",
                (summaries.len() - refused).to_string(),
                "",
            ),
            KeyFigure::new(
                "refused for want of a common phase",
                refused.to_string(),
                "",
            ),
        ];
        if let Some((modulus, axis, e)) = largest {
            figures.push(
                KeyFigure::new("largest spurious motion", two_digits(100.0 * modulus), "%").note(
                    format!(
                        "along {axis}′ at {:.0}°, {} Hz",
                        e.inclination.to_degrees(),
                        plain(e.frequency)
                    ),
                ),
            );
        }
        report.findings(self.head.findings.iter().cloned()).section(
            Section::new("Result")
                .key_figures(figures)
                .table(ratios(table)),
        )
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Standard uncertainty of one part, mean over both.
fn part([rr, _, ii]: [f64; 3]) -> f64 {
    (0.5 * (rr + ii)).sqrt()
}

fn ratios(table: &SpuriousTable) -> Table {
    let mut columns = vec![Column::number("α", "°"), Column::number("f", "Hz")];
    for axis in AXES {
        columns.push(Column::number(format!("|ε_{axis}′|"), "%"));
        columns.push(Column::number("u", "%"));
        columns.push(Column::number("phase", "°"));
    }
    let mut result = Table::new(
        "Correction of each axis: ratio to the reference acceleration, along z′ the departure from one",
        columns,
    )
    .note("u is that of the real or the imaginary part. A phase is given where the modulus exceeds 2 u.");
    for e in &table.entries {
        let mut cells = vec![
            Cell::number(plain(e.inclination.to_degrees())),
            Cell::number(plain(e.frequency)),
        ];
        for k in 0..3 {
            let (z, u) = (e.ratio[k], part(e.covariance[k]));
            cells.push(Cell::number(format!("{:.3}", 100.0 * z.norm())));
            cells.push(if u > 0.0 {
                Cell::number(two_digits(100.0 * u))
            } else {
                Cell::Empty
            });
            cells.push(if z.norm() > 2.0 * u && z.norm() > 0.0 {
                Cell::number(format!("{:.1}", z.arg().to_degrees()))
            } else {
                Cell::Empty
            });
        }
        result = result.row(cells);
    }
    result
}

fn curves(table: &SpuriousTable) -> Section {
    let mut inclinations: Vec<f64> = vec![];
    for e in &table.entries {
        if !inclinations
            .iter()
            .any(|i| (i - e.inclination).abs() < 1e-6)
        {
            inclinations.push(e.inclination);
        }
    }
    inclinations.sort_by(f64::total_cmp);
    let mut plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::default());
    plot.panels.clear();
    for (k, axis) in AXES.iter().enumerate() {
        plot = plot.below(Axis::linear(format!("|ε_{axis}′|"), "%"));
        for (number, &inclination) in inclinations.iter().enumerate() {
            let mut points: Vec<(f64, f64)> = table
                .entries
                .iter()
                .filter(|e| (e.inclination - inclination).abs() < 1e-6)
                .map(|e| (e.frequency, 100.0 * e.ratio[k].norm()))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            let name = if k == 0 {
                format!("{:.0}°", inclination.to_degrees())
            } else {
                String::new()
            };
            plot = plot.series(
                Series::line(name, &x, &y)
                    .style(Style::LineAndMarkers)
                    .look(number),
            );
        }
    }
    Section::new("Spurious motion against frequency").figure(
        "Modulus of the spurious motion along the three axes of the bench for each inclination",
        plot,
    )
}

fn circular(summaries: &[RatioSummary]) -> Section {
    let mut table = Table::new(
        "Repeats of every ratio, with the statistics of their directions on the circle",
        [
            Column::text("axis"),
            Column::number("α", "°"),
            Column::number("f", "Hz"),
            Column::number("repeats", ""),
            Column::number("modulus, mean", "%"),
            Column::number("mean direction", "°"),
            Column::number("resultant length", ""),
            Column::number("circular s", "°"),
            Column::number("Rayleigh p", ""),
            Column::text(""),
        ],
    );
    let mut refused = vec![];
    for s in summaries {
        let mean = s.moduli.iter().sum::<f64>() / s.moduli.len().max(1) as f64;
        let incoherent = matches!(s.average, Average::Incoherent { .. });
        let row = vec![
            Cell::text(format!("{}′", s.axis)),
            Cell::number(plain(s.inclination.to_degrees())),
            Cell::number(plain(s.frequency)),
            Cell::number(s.moduli.len().to_string()),
            Cell::number(format!("{:.3}", 100.0 * mean)),
            Cell::number(format!("{:.1}", s.phases.mean.to_degrees())),
            Cell::number(format!("{:.3}", s.phases.resultant)),
            Cell::number(format!("{:.1}", s.phases.standard_deviation.to_degrees())),
            Cell::number(if s.phases.rayleigh_p < 1e-3 {
                "< 0.001".to_owned()
            } else {
                format!("{:.3}", s.phases.rayleigh_p)
            }),
            Cell::text(if incoherent { "refused" } else { "averaged" }),
        ];
        if incoherent {
            refused.push(row.clone());
        }
        table = table.row(row);
    }
    let mut section = Section::new("Directions of the repeats").paragraph(
        "The Rayleigh test asks whether directions are uniform on the circle: a small p says that the repeats share a \
         phase. Repeats without one have no mean, however well their moduli agree.",
    );
    if !refused.is_empty() {
        let mut short = Table::new("Ratios that were not averaged", table.columns.clone());
        short.rows = refused;
        section = section.table(short);
    }
    section.folded("All ratios", [Block::Table(table)])
}

fn compared(label: &str, comparison: &[Comparison]) -> Section {
    let mut table = Table::new(
        "Differences",
        [
            Column::text("axis"),
            Column::number("α", "°"),
            Column::number("f", "Hz"),
            Column::number("|difference|", "%"),
            Column::number("E_n", ""),
            Column::text(""),
        ],
    );
    let mut beyond = 0;
    for c in comparison {
        let disagrees = c.e_n.is_some_and(|e| e > 1.0);
        beyond += usize::from(disagrees);
        table = table.row([
            Cell::text(format!("{}′", c.axis)),
            Cell::number(plain(c.inclination.to_degrees())),
            Cell::number(plain(c.frequency)),
            Cell::number(format!("{:.3}", 100.0 * c.difference)),
            c.e_n
                .map_or(Cell::Empty, |e| Cell::number(format!("{e:.2}"))),
            Cell::text(if disagrees { "disagree" } else { "" }),
        ]);
    }
    Section::new(format!("Compared with {label}"))
        .paragraph(format!(
            "{beyond} of {} ratios differ by more than their expanded uncertainties allow (E_n > 1).",
            comparison.len()
        ))
        .table(table)
}
