//! The report of temperature coefficients.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_report::number::two_digits;
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot, concise,
};
use proofmass_static::{AxisFit, TemperatureFit};

const AXES: [&str; 3] = ["x", "y", "z"];
const MG: f64 = 1e3 / STANDARD_GRAVITY;

/// What the report tells beside the fit itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct TemperatureReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Coverage probability.
    pub probability: f64,
    /// Whether a calibration with these coefficients is among the results.
    pub combined: bool,
}

impl TemperatureReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, fit: &TemperatureFit) -> Report {
        let report = self.head.open().subtitle(format!(
            "{:.1} to {:.1} °C, {} blocks of {:.3} s, reference {:.2} °C",
            fit.range[0],
            fit.range[1],
            fit.blocks.len(),
            fit.blocks.duration,
            fit.reference
        ));
        let mut figures = Vec::new();
        for (axis, name) in fit.axes.iter().zip(AXES) {
            if let Some(q) = fit.estimate.get(&format!("slope.{name}")) {
                figures.push(
                    KeyFigure::new(
                        format!("mean slope of {name}"),
                        concise(q.value * MG, q.standard_uncertainty * MG),
                        "mg/K",
                    )
                    .note(format!(
                        "± {} µg/K at {:.0} %",
                        two_digits(q.expanded(self.probability) * MG * 1e3),
                        1e2 * self.probability
                    )),
                );
            }
            if let Some(h) = &axis.hysteresis {
                figures.push(
                    KeyFigure::new(
                        format!("hysteresis of {name}"),
                        concise(h.difference * MG, h.standard_uncertainty * MG),
                        "mg",
                    )
                    .note(format!(
                        "heating less cooling, largest at {:.0} °C",
                        h.temperature
                    )),
                );
            }
        }
        for (axis, name) in fit.axes.iter().zip(AXES) {
            if let Some(h) = axis.self_heating.filter(|h| h.determined) {
                figures.push(
                    KeyFigure::new(
                        format!("self-heating of {name}"),
                        concise(h.amplitude * MG, h.standard_uncertainty * MG),
                        "mg",
                    )
                    .note(format!("at switching on, {:.0} s", h.time_constant)),
                );
            }
        }
        if let Some([lag, u]) = fit.thermometer_lag() {
            figures.push(
                KeyFigure::new("lag of the thermometer", concise(lag, u), "s")
                    .note("behind what the outputs follow"),
            );
        }
        let what = if fit.scale {
            "Bias and scale were told apart by the attitudes."
        } else {
            "Bias and scale together, as they appear in this attitude."
        };
        let combined = if self.combined {
            " calibration.json holds the calibration that was named with these coefficients in it."
        } else {
            ""
        };
        report.findings(self.head.findings.iter().cloned()).section(
            Section::new("Result")
                .paragraph(format!(
                    "{what} Stated is order {}, averaged over every noise of the grid by evidence with the variance between them.{combined}",
                    fit.largest_order
                ))
                .key_figures(figures)
                .table(coefficients(fit, self.probability)),
        )
    }

    /// The whole report.
    pub(crate) fn full(&self, fit: &TemperatureFit) -> Report {
        let mut section = Section::new("Temperature and output");
        for (index, (axis, name)) in fit.axes.iter().zip(AXES).enumerate() {
            section = section.figure(
                format!("{name}: block means about their attitude, heating and cooling apart, and the fitted curve"),
                curve(fit, axis, index),
            );
        }
        let mut report = self.summary(fit).section(section);
        let branches: Vec<_> = fit
            .axes
            .iter()
            .zip(AXES)
            .filter_map(|(axis, name)| axis.hysteresis.as_ref().map(|h| (name, h)))
            .collect();
        if !branches.is_empty() {
            let mut plot = XyPlot::new(
                Axis::linear("temperature", "°C"),
                Axis::linear("heating less cooling", "mg"),
            )
            .horizontal(0.0, "");
            for (name, h) in &branches {
                let t: Vec<f64> = h.curve.iter().map(|p| p[0]).collect();
                let part = |k: f64| {
                    h.curve
                        .iter()
                        .map(|p| (p[1] + k * p[2]) * MG)
                        .collect::<Vec<_>>()
                };
                plot =
                    plot.series(Series::line(*name, &t, &part(0.0)).band(&part(-2.0), &part(2.0)));
            }
            report = report.section(Section::new("Hysteresis").figure(
                "Difference of the branches with two standard uncertainties",
                plot,
            ));
        }
        report
            .section(Section::new("Orders").table(orders(fit)))
            .section(Section::new("Attitudes").table(attitudes(fit)))
            .foot(&self.head)
    }
}

fn coefficients(fit: &TemperatureFit, probability: f64) -> Table {
    let mut table = Table::new(
        "Coefficients of d = T − T₀",
        [
            Column::text("quantity"),
            Column::number("value", ""),
            Column::number(format!("U ({:.0} %)", 1e2 * probability), ""),
            Column::text("unit"),
        ],
    );
    for q in fit.estimate.quantities() {
        table = table.row([
            Cell::text(q.name.clone()),
            Cell::number(format!("{:.4e}", q.value)),
            Cell::number(format!("{:.1e}", q.expanded(probability))),
            Cell::text(q.unit.clone()),
        ]);
    }
    table
}

fn orders(fit: &TemperatureFit) -> Table {
    let mut table = Table::new(
        "Every order that was fitted",
        [
            Column::text("axis"),
            Column::number("order", ""),
            Column::number("ΔAICc", ""),
            Column::number("weight", ""),
            Column::number("F", ""),
            Column::number("F limit", ""),
            Column::number("cross-validation", "mg"),
            Column::number("mean slope", "mg/K"),
        ],
    )
    .note("F: the last power against the order below, correlated noise accounted for; one in twenty exceeds the limit without such a power.")
    .note("Cross-validation: RMS error of ten stretches of time, each predicted from the rest.");
    for (axis, name) in fit.axes.iter().zip(AXES) {
        for o in &axis.orders {
            table = table.row([
                Cell::text(name),
                Cell::number(o.order.to_string()),
                Cell::number(format!("{:.2}", o.aicc)),
                Cell::number(format!("{:.3}", o.weight)),
                o.f.map_or(Cell::Empty, |f| Cell::number(format!("{f:.2}"))),
                Cell::number(format!("{:.2}", o.f_limit)),
                Cell::number(format!("{:.4}", o.cross_validation * MG)),
                Cell::number(concise(o.slope * MG, o.slope_uncertainty * MG)),
            ]);
        }
    }
    table
}

fn attitudes(fit: &TemperatureFit) -> Table {
    let mut table = Table::new(
        "Stretches in which the sensor was not turned",
        [
            Column::number("from", "s"),
            Column::number("to", "s"),
            Column::number("lowest", "°C"),
            Column::number("highest", "°C"),
            Column::number("x", "g"),
            Column::number("y", "g"),
            Column::number("z", "g"),
        ],
    );
    for a in fit.attitudes() {
        let numbers = [a.time[0], a.time[1], a.range[0], a.range[1]];
        let g = a.output.map(|v| v / STANDARD_GRAVITY);
        let cells = numbers.iter().map(|v| Cell::number(format!("{v:.1}")));
        table = table.row(cells.chain(g.iter().map(|v| Cell::number(format!("{v:.4}")))));
    }
    table
}

/// Block means less their attitude's, over temperature.
fn curve(fit: &TemperatureFit, axis: &AxisFit, index: usize) -> XyPlot {
    let blocks = &fit.blocks;
    let branch = |wanted: f64| {
        let members = (0..blocks.len()).filter(|i| fit.direction[*i] == wanted);
        let points = members.map(|i| {
            let mean = blocks.attitudes[blocks.attitude[i]].output[index];
            (blocks.temperature[i], (blocks.output[i][index] - mean) * MG)
        });
        points.unzip::<f64, f64, Vec<f64>, Vec<f64>>()
    };
    let [low, high] = fit.range;
    let t: Vec<f64> = (0..=60)
        .map(|i| low + (high - low) * f64::from(i) / 60.0)
        .collect();
    let line: Vec<f64> = t
        .iter()
        .map(|t| (axis.change(t - fit.reference) - axis.mean_change) * MG)
        .collect();
    let mut plot = XyPlot::new(
        Axis::linear("temperature", "°C"),
        Axis::linear("change of the output", "mg"),
    );
    for (name, sign) in [("heating", 1.0), ("cooling", -1.0)] {
        let (x, y) = branch(sign);
        if !x.is_empty() {
            plot = plot.series(Series::markers(name, &x, &y));
        }
    }
    plot.series(Series::line("fit", &t, &line))
}
