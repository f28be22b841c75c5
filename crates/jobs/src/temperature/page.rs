//! The page of temperature coefficients.

use super::TemperatureOutcome;
use crate::page::MG;
use crate::page::answer::plus_minus;
use crate::page::columns::coverage_factor;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_report::number::{minus, two_digits};
use proofmass_report::{
    Axis, Field, KeyFigure, Report, Rounding, Section, Series, Table, XyPlot, concise,
};
use proofmass_static::{AxisFit, OrderFit, TemperatureFit};
use proofmass_uncertainty::Quantity;

pub(super) fn add(page: Report, outcome: &TemperatureOutcome) -> Report {
    let fit = &outcome.fit;
    let mut section = Section::new("Temperature and output");
    let mut page = page;
    let steepest = steepest(fit).map_or(0, |(index, _)| index);
    for (index, (name, axis)) in fit.named_axes().enumerate() {
        let caption = format!(
            "{name}: block means about their attitude, heating and cooling apart, and the fitted curve"
        );
        // The axis that the verdict names opens the page.
        match index == steepest {
            true => page = page.shown_by(caption, curve(fit, axis, index)),
            false => section = section.figure(caption, curve(fit, axis, index)),
        }
    }
    let page = page
        .subtitle(format!(
            "{:.1} to {:.1} °C, {} blocks of {:.3} s, reference {:.2} °C",
            fit.range[0],
            fit.range[1],
            fit.blocks.len(),
            fit.blocks.duration,
            fit.reference
        ))
        .verdict(verdict(outcome))
        .section(result(outcome).summarised())
        .section(section);
    let page = match hysteresis(fit) {
        Some(plot) => page.section(Section::new("Hysteresis").figure(
            "Difference of the branches with two standard uncertainties",
            plot,
        )),
        None => page,
    };
    page.section(Section::new("Orders").table(orders(fit)))
        .section(Section::new("Attitudes").table(attitudes(fit)))
        .section(Section::filed([blocks(fit)]))
}

/// The steepest of the mean slopes, and whether it is told from zero.
fn verdict(outcome: &TemperatureOutcome) -> String {
    let (fit, probability) = (&outcome.fit, outcome.probability);
    let told = slopes(fit)
        .filter(|(_, q)| q.value.abs() > q.expanded(probability))
        .count();
    let all = slopes(fit).count();
    steepest(fit).map_or(String::new(), |(index, q)| {
        let change = minus(&plus_minus(MG * q.value, MG * q.expanded(probability)));
        let percent = 100.0 * probability;
        let k = q.expanded(probability) / q.standard_uncertainty;
        match all {
            1 => {
                let differs = if told == 1 { "differs" } else { "does not differ" };
                format!("The output changes by {change} mg/K (k = {k:.2}, {percent:.0} %), which {differs} significantly from zero.")
            }
            _ => format!(
                "The output of {} changes most, by {change} mg/K (k = {k:.2}, {percent:.0} %); on {told} of {all} axes the slope differs significantly from zero.",
                fit.blocks.names()[index]
            ),
        }
    })
}

/// The mean slopes with the numbers of their axes.
fn slopes(fit: &TemperatureFit) -> impl Iterator<Item = (usize, Quantity)> + '_ {
    (0..fit.axes.len()).filter_map(|k| Some((k, fit.slope(k)?)))
}

fn steepest(fit: &TemperatureFit) -> Option<(usize, Quantity)> {
    slopes(fit).max_by(|a, b| a.1.value.abs().total_cmp(&b.1.value.abs()))
}

fn result(outcome: &TemperatureOutcome) -> Section {
    let (fit, probability) = (&outcome.fit, outcome.probability);
    let what = if fit.scale {
        "Bias and scale were separated by the attitudes."
    } else {
        "Bias and scale together, as they appear in this attitude."
    };
    let combined = if outcome.calibration.is_some() {
        " calibration.json holds the calibration that was named with these coefficients in it."
    } else {
        ""
    };
    Section::new("Result")
        .paragraph(format!(
            "{what} Stated is order {}, averaged over every noise of the grid by evidence with the variance between them.{combined}",
            fit.largest_order
        ))
        .key_figures(figures(fit, probability))
        .table(coefficients(fit, probability))
}

fn figures(fit: &TemperatureFit, probability: f64) -> Vec<KeyFigure> {
    let figure = |label: String, value: f64, u: f64, unit: &str| {
        KeyFigure::new(label, concise(value * MG, u * MG), unit)
    };
    let mut figures = Vec::new();
    for (k, (name, axis)) in fit.named_axes().enumerate() {
        if let Some(q) = fit.slope(k) {
            let label = format!("mean slope of {name}");
            let expanded = two_digits(q.expanded(probability) * MG * 1e3);
            let k = q.expanded(probability) / q.standard_uncertainty;
            let stated = format!("± {expanded} µg/K, k = {k:.2}, {:.0} %", 1e2 * probability);
            let slope = figure(label, q.value, q.standard_uncertainty, "mg/K");
            figures.push(slope.note(stated));
        }
        figures.extend(axis.hysteresis.as_ref().map(|h| {
            let label = format!("hysteresis of {name}");
            let largest = h
                .raw
                .iter()
                .max_by(|a, b| a[1].abs().total_cmp(&b[1].abs()));
            let raw = largest.map_or(String::new(), |[t, difference, _]| {
                let difference = difference * MG;
                format!("; by the outputs alone {difference:.2} mg at {t:.0} °C")
            });
            let note = format!(
                "heating less cooling, largest at {:.0} °C{raw}",
                h.temperature
            );
            figure(label, h.difference, h.standard_uncertainty, "mg").note(note)
        }));
    }
    for (name, axis) in fit.named_axes() {
        figures.extend(axis.self_heating.filter(|h| h.determined).map(|h| {
            let label = format!("self-heating of {name}");
            figure(label, h.amplitude, h.standard_uncertainty, "mg")
                .note(format!("at switching on, {:.0} s", h.time_constant))
        }));
    }
    figures.extend(fit.thermometer_lag().map(|[lag, u]| {
        KeyFigure::new("lag of the thermometer", concise(lag, u), "s")
            .note("behind what the outputs follow")
    }));
    figures
}

fn hysteresis(fit: &TemperatureFit) -> Option<XyPlot> {
    let mut branches = fit
        .named_axes()
        .filter_map(|(name, axis)| Some((name, axis.hysteresis.as_ref()?)))
        .peekable();
    branches.peek()?;
    let plot = XyPlot::new(
        Axis::linear("temperature", "°C"),
        Axis::linear("heating less cooling", "mg"),
    )
    .horizontal(0.0, "");
    Some(branches.fold(plot, |plot, (name, h)| {
        let t: Vec<f64> = h.curve.iter().map(|p| p[0]).collect();
        let part = |k: f64| -> Vec<f64> {
            let points = h.curve.iter();
            points.map(|p| (p[1] + k * p[2]) * MG).collect()
        };
        let raw =
            |i: usize, factor: f64| -> Vec<f64> { h.raw.iter().map(|p| p[i] * factor).collect() };
        let markers = Series::markers(format!("{name}, by the outputs"), &raw(0, 1.0), &raw(1, MG));
        plot.series(Series::line(name, &t, &part(0.0)).band(&part(-2.0), &part(2.0)))
            .series(markers)
    }))
}

fn coefficients(fit: &TemperatureFit, probability: f64) -> Table {
    let u = format!("U ({:.0} %)", 1e2 * probability);
    let fields = [
        Field::shown("quantity", "", |q: &Quantity| q.name.as_str().into()),
        Field::shown("value", "", |q: &Quantity| q.value.into()).rounded(Rounding::Power(4)),
        Field::shown(u, "", |q: &Quantity| q.expanded(probability).into())
            .rounded(Rounding::Power(1)),
        coverage_factor("", |q: &Quantity| q.coverage_factor(probability)),
        Field::shown("unit", "", |q: &Quantity| q.unit.as_str().into()),
    ];
    Table::of(
        "Coefficients of d = T − T₀",
        fields,
        fit.estimate.quantities(),
    )
}

fn orders(fit: &TemperatureFit) -> Table {
    type Row<'a> = (&'static str, &'a OrderFit);
    let rows = fit
        .named_axes()
        .flat_map(|(name, axis)| axis.orders.iter().map(move |o| (name, o)));
    let fields = [
        Field::shown("axis", "", |r: &Row<'_>| r.0.into()),
        Field::shown("order", "", |r: &Row<'_>| r.1.order.into()),
        Field::shown("ΔAICc", "", |r: &Row<'_>| r.1.aicc.into()).decimals(2),
        Field::shown("weight", "", |r: &Row<'_>| r.1.weight.into()).decimals(3),
        Field::shown("F", "", |r: &Row<'_>| r.1.f.into()).decimals(2),
        Field::shown("F limit", "", |r: &Row<'_>| r.1.f_limit.into()).decimals(2),
        Field::shown("cross-validation", "mg", |r: &Row<'_>| {
            (r.1.cross_validation * MG).into()
        })
        .decimals(4),
        Field::estimate("", "", |r: &Row<'_>| {
            Some((r.1.slope * MG, r.1.slope_uncertainty * MG))
        })
        .page("mean slope", "mg/K"),
    ];
    Table::of("Every order that was fitted", fields, rows.collect::<Vec<Row<'_>>>())
        .note("F: the last power against the order below, correlated noise accounted for; one in twenty exceeds the limit without such a power.")
        .note("Cross-validation: RMS error of ten stretches of time, each predicted from the rest.")
}

fn attitudes(fit: &TemperatureFit) -> Table {
    let mut columns = vec![
        ("from", "s", 1),
        ("to", "s", 1),
        ("lowest", "°C", 1),
        ("highest", "°C", 1),
    ];
    columns.extend(fit.blocks.names().iter().map(|axis| (*axis, "g", 4)));
    let fields = columns
        .into_iter()
        .enumerate()
        .map(|(k, (name, unit, decimals))| {
            Field::shown(name, unit, move |row: &[f64; 7]| row[k].into()).decimals(decimals)
        });
    let rows = fit.attitudes().iter().map(|a| {
        let ([from, to], [low, high]) = (a.time, a.range);
        let [x, y, z] = a.output.map(|v| v / STANDARD_GRAVITY);
        [from, to, low, high, x, y, z]
    });
    Table::of("Stretches in which the sensor was not turned", fields, rows)
}

fn blocks(fit: &TemperatureFit) -> Table {
    let blocks = &fit.blocks;
    let mut fields = vec![
        Field::series("time_s", &blocks.time),
        Field::series("temperature_degC", &blocks.temperature),
        Field::series("direction", &fit.direction),
        Field::new("attitude", |i: &usize| {
            (blocks.attitude[*i] as f64 + 1.0).into()
        }),
    ];
    fields.extend((0..fit.axes.len()).map(|k| {
        let name = blocks.parameter("acceleration", k).replace('.', "_");
        Field::new(format!("{name}_m/s2"), move |i: &usize| {
            blocks.output[*i][k].into()
        })
    }));
    Table::of("", fields, 0..blocks.len()).file("blocks.csv")
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
