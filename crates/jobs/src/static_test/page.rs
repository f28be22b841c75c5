//! The report of a static test.

use proofmass_report::number::freedom;
use proofmass_report::{
    Axis, BarPlot, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot, concise,
};
use proofmass_static::static_test::{StabilityFit, StaticFit};
use proofmass_uncertainty::Quantity;

/// What the report tells beside the fit itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct StaticTestReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Coverage probability.
    pub probability: f64,
}

impl StaticTestReport<'_> {
    fn head(&self) -> Report {
        let report = self.head.open();
        report.findings(self.head.findings.iter().cloned())
    }

    fn tail(&self, report: Report) -> Report {
        report.foot(&self.head)
    }

    fn quantities(&self, quantities: &[Quantity]) -> Table {
        let mut table = Table::new(
            "",
            [
                Column::text("quantity"),
                Column::number("value", ""),
                Column::number(format!("U ({:.0} %)", 1e2 * self.probability), ""),
                Column::text("unit"),
                Column::number("ν", ""),
            ],
        );
        for q in quantities {
            table = table.row([
                Cell::text(q.name.clone()),
                Cell::number(concise(q.value, q.standard_uncertainty)),
                Cell::number(format!("{:.2e}", q.expanded(self.probability))),
                Cell::text(q.unit.clone()),
                Cell::number(freedom(q.dof.get())),
            ]);
        }
        table.note("In parentheses: the standard uncertainty in the last digits.")
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, fit: &StaticFit) -> Report {
        let mut figures = Vec::new();
        if let Some(share) = fit.nonlinearity {
            figures.push(
                KeyFigure::new(
                    "largest departure from the line",
                    format!("{:.4}", 1e2 * share),
                    "% FS",
                )
                .note("largest of all readings, their scatter included"),
            );
        }
        if let Some(scatter) = fit.scatter {
            figures.push(KeyFigure::new(
                "scatter of a reading",
                format!("{scatter:.3e}"),
                fit.unit.clone(),
            ));
        }
        let mut section = Section::new("Result");
        if !figures.is_empty() {
            section = section.key_figures(figures);
        }
        section = section.table(self.quantities(&fit.estimate.quantities()));
        if !fit.orders.is_empty() {
            section = section.table(orders(fit));
        }
        self.head().section(section)
    }

    /// The whole report.
    pub(crate) fn full(&self, fit: &StaticFit) -> Report {
        let mut report = self.summary(fit);
        if !fit.readings.is_empty() {
            let of = |f: fn(&proofmass_static::static_test::ReadingResidual) -> f64| {
                fit.readings.iter().map(f).collect::<Vec<f64>>()
            };
            let (x, residual) = (of(|r| r.input), of(|r| r.residual()));
            let plot = XyPlot::new(
                Axis::linear(fit.input.clone(), ""),
                Axis::linear("output less model", fit.unit.clone()),
            )
            .horizontal(0.0, "")
            .series(Series::markers("", &x, &residual));
            report = report.section(Section::new("Residuals").figure("Every reading", plot));
        }
        let mut budget = Section::new("Budget");
        for component in fit.estimate.components() {
            let lines = fit.estimate.budget(&component.name).unwrap_or_default();
            let mut bars = BarPlot::shares("share of the variance");
            for line in lines.iter().filter(|l| l.contribution > 0.0) {
                bars = bars.bar(
                    line.description.clone(),
                    line.share,
                    format!("{:.2e} {}", line.contribution, component.unit),
                );
            }
            if lines.iter().any(|l| l.contribution > 0.0) {
                budget = budget.figure(component.name.clone(), bars);
            }
        }
        self.tail(report.section(budget))
    }

    /// Drifts, for the terminal.
    pub(crate) fn history_summary(&self, fit: &StabilityFit) -> Report {
        let count = fit.drifts.first().map_or(0, |d| d.values.len());
        let quantities: Vec<Quantity> = fit.drifts.iter().map(|d| d.drift.clone()).collect();
        self.head().section(
            Section::new("Result")
                .key_figures([
                    KeyFigure::new("calibrations", count.to_string(), ""),
                    KeyFigure::new("next due in", format!("{:.0}", fit.due_in), "days")
                        .note("after the last calibration"),
                ])
                .table(self.quantities(&quantities)),
        )
    }

    /// Drifts with a control chart of each quantity.
    pub(crate) fn history(&self, fit: &StabilityFit) -> Report {
        let mut section = Section::new("Control charts").paragraph(
            "Markers with two standard uncertainties; the band is where a calibration of such uncertainty is expected.",
        );
        for d in &fit.drifts {
            let column = |i: usize| d.values.iter().map(|v| v[i]).collect::<Vec<f64>>();
            let (day, value, u) = (column(0), column(1), column(2));
            let days: Vec<f64> = day.iter().map(|t| t - fit.last).collect();
            let bound = |k: f64| {
                value
                    .iter()
                    .zip(&u)
                    .map(|(v, u)| v + k * u)
                    .collect::<Vec<f64>>()
            };
            let limit = |i: usize| d.limits.iter().map(|l| l[i]).collect::<Vec<f64>>();
            let line: Vec<f64> = day
                .iter()
                .map(|t| {
                    d.level
                        + d.drift.value * (t - d.mean_day) / proofmass_static::static_test::MONTH
                })
                .collect();
            let plot = XyPlot::new(
                Axis::linear("days before the last calibration", "d"),
                Axis::linear(d.name.clone(), d.unit.clone()),
            )
            .series(Series::line("drift", &days, &line).band(&limit(1), &limit(2)))
            .series(Series::markers("calibrations", &days, &value).bars(&bound(-2.0), &bound(2.0)));
            section = section.figure(d.name.clone(), plot);
        }
        self.tail(self.history_summary(fit).section(section))
    }
}

fn orders(fit: &StaticFit) -> Table {
    let mut table = Table::new(
        "Orders",
        [
            Column::number("order", ""),
            Column::number("ΔAICc", ""),
            Column::number("weight", ""),
            Column::number("F", ""),
            Column::number("F limit", ""),
            Column::number("cross-validation", fit.unit.clone()),
        ],
    );
    for o in &fit.orders {
        table = table.row([
            Cell::number(o.order.to_string()),
            Cell::number(format!("{:.2}", o.aicc)),
            Cell::number(format!("{:.3}", o.weight)),
            o.f.map_or(Cell::Empty, |f| Cell::number(format!("{f:.2}"))),
            Cell::number(format!("{:.2}", o.f_limit)),
            Cell::number(format!("{:.3e}", o.cross_validation)),
        ]);
    }
    table.note("Cross-validation: RMS error of each reading predicted from all others.")
}
