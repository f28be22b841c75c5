//! The page of a static test.

use super::{StaticTest, StaticTestFit, StaticTestOutcome};
use crate::page::answer::{label, stated, with_unit};
use crate::page::columns::filed;
use proofmass_report::number::{freedom, two_digits};
use proofmass_report::{
    Axis, BarPlot, Cell, Field, KeyFigure, Report, Rounding, Section, Series, Table, XyPlot,
};
use proofmass_static::static_test::{
    Departure, Drift, Harmonic, MONTH, MountedTurn, PolynomialOrder, ReadingResidual, StabilityFit,
    StaticFit,
};
use proofmass_uncertainty::Quantity;

pub(super) fn add(page: Report, outcome: &StaticTestOutcome) -> Report {
    match &outcome.found {
        StaticTestFit::Test(fit) => test(page, fit, outcome),
        StaticTestFit::History(fit) => history(page, fit, outcome.probability),
        StaticTestFit::Mounting(fit, turn) => mounting(page, fit, turn, outcome),
    }
}

fn quantities(quantities: &[Quantity], probability: f64) -> Table {
    let u = format!("U ({:.0} %)", 1e2 * probability);
    let fields = [
        Field::shown("quantity", "", |q: &Quantity| q.name.as_str().into()),
        Field::estimate("", "", |q: &Quantity| {
            Some((q.value, q.standard_uncertainty))
        })
        .page("value", ""),
        Field::shown(u, "", |q: &Quantity| q.expanded(probability).into())
            .rounded(Rounding::Power(2)),
        Field::shown("k", "", move |q: &Quantity| {
            q.coverage_factor(probability).into()
        })
        .decimals(2),
        Field::shown("unit", "", |q: &Quantity| q.unit.as_str().into()),
        Field::shown("ν", "", |q: &Quantity| Cell::number(freedom(q.dof.get()))),
    ];
    Table::of("", fields, quantities)
        .note("In parentheses: the standard uncertainty in the last digits.")
}

fn test(mut page: Report, fit: &StaticFit, outcome: &StaticTestOutcome) -> Report {
    let probability = outcome.probability;
    let mut figures = Vec::new();
    figures.extend(fit.nonlinearity.map(|share| {
        let share = format!("{:.4}", 1e2 * share);
        KeyFigure::new("largest departure from the line", share, "% FS")
            .note("largest of all readings, their scatter included")
    }));
    figures.extend(fit.scatter.map(|scatter| {
        KeyFigure::new("scatter of a reading", format!("{scatter:.3e}"), &fit.unit)
    }));
    let mut result = Section::new("Result");
    if !figures.is_empty() {
        result = result.key_figures(figures);
    }
    result = result.table(quantities(&fit.estimate.quantities(), probability));
    if !fit.orders.is_empty() {
        result = result.table(orders(fit));
    }
    if !fit.departures.is_empty() {
        result = result.table(departures(fit));
    }
    if !fit.harmonics.is_empty() {
        result = result.table(harmonics(fit));
    }
    if let Some(share) = fit.nonlinearity {
        let (curve, beyond) = match outcome.test {
            StaticTest::Tilt(_) => ("the cosine that was fitted", harmonics_in_words(fit)),
            _ => ("the straight line", String::new()),
        };
        page = page.verdict(format!(
            "The readings lie within {} % of full scale of {curve}{beyond}.",
            two_digits(1e2 * share)
        ));
    }
    if matches!(outcome.test, StaticTest::Sensitivity(_)) {
        page = named_for(page, "sensitivity", outcome);
    }
    let mut page = page.section(result.summarised());
    if !fit.readings.is_empty() {
        let of = |f: fn(&ReadingResidual) -> f64| fit.readings.iter().map(f).collect::<Vec<f64>>();
        let plot = XyPlot::new(
            Axis::linear(&fit.input, ""),
            Axis::linear("output less model", &fit.unit),
        )
        .horizontal(0.0, "")
        .series(Series::markers(
            "",
            &of(|r| r.input),
            &of(ReadingResidual::residual),
        ));
        page = page.section(
            Section::new("Residuals").figure("Residual of each reading: output less model", plot),
        );
    }
    page.section(budget(fit))
        .section(Section::filed([readings(fit)]))
}

/// The page of a test that is named for one of its quantities begins with that.
fn named_for(page: Report, name: &str, outcome: &StaticTestOutcome) -> Report {
    let (first, others): (Vec<_>, Vec<_>) = outcome.quantities.iter().partition(|q| q.name == name);
    let page = match first.first() {
        Some(q) => page.verdict(format!("The {name} is {}.", with_unit(q))),
        None => page,
    };
    page.answers(first.into_iter().chain(others).map(stated))
}

/// Angles in degrees first, as they are typed.
fn mounting(
    page: Report,
    fit: &StaticFit,
    turn: &MountedTurn,
    outcome: &StaticTestOutcome,
) -> Report {
    let [roll, pitch, yaw] = turn.angles.map(|a| format!("{:.3}", a.to_degrees()));
    let page = page.verdict(format!(
        "The sensor sits at roll {roll}°, pitch {pitch}°, yaw {yaw}°. `apply` and `export` take the result: --rotate FOLDER/result.json."
    ));
    test(page, fit, outcome)
}

/// Whether the residuals that the figure shows are more than scatter.
fn harmonics_in_words(fit: &StaticFit) -> String {
    let tested = &fit.harmonics;
    let mut told = tested.iter().filter(|h| h.f > h.f_limit);
    match (tested.is_empty(), told.next()) {
        (true, _) => String::new(),
        (false, None) => {
            "; what is left shows no harmonic of the angle above the scatter".to_owned()
        }
        (false, Some(h)) => format!(
            "; what is left holds harmonic {}, of {} % of 1 g",
            h.order,
            two_digits(1e2 * h.size)
        ),
    }
}

fn readings(fit: &StaticFit) -> Table {
    let fields = [
        filed("input", |r: &ReadingResidual| r.input),
        filed("output", |r: &ReadingResidual| r.output),
        filed("model", |r: &ReadingResidual| r.model),
        filed("residual", |r: &ReadingResidual| r.residual()),
    ];
    Table::of("", fields, &fit.readings).file("readings.csv")
}

fn budget(fit: &StaticFit) -> Section {
    let mut budget = Section::new("Budget");
    for component in fit.estimate.components() {
        let lines = fit.estimate.budget(&component.name).unwrap_or_default();
        let mut lines = lines.iter().filter(|l| l.contribution > 0.0).peekable();
        if lines.peek().is_some() {
            let bars = lines.fold(BarPlot::shares("share of the variance"), |bars, line| {
                let size = format!("{:.2e} {}", line.contribution, component.unit);
                bars.bar(line.description.clone(), line.share, size)
            });
            budget = budget.figure(format!("Budget of {}", label(&component.name)), bars);
        }
    }
    budget
}

fn orders(fit: &StaticFit) -> Table {
    let fields = [
        Field::shown("order", "", |o: &PolynomialOrder| o.order.into()),
        Field::shown("ΔAICc", "", |o: &PolynomialOrder| o.aicc.into()).decimals(2),
        Field::shown("weight", "", |o: &PolynomialOrder| o.weight.into()).decimals(3),
        Field::shown("F", "", |o: &PolynomialOrder| o.f.into()).decimals(2),
        Field::shown("F limit", "", |o: &PolynomialOrder| o.f_limit.into()).decimals(2),
        Field::shown("cross-validation", &fit.unit, |o: &PolynomialOrder| {
            o.cross_validation.into()
        })
        .rounded(Rounding::Power(3)),
    ];
    Table::of("Orders", fields, &fit.orders)
        .note("Cross-validation: RMS error of each reading predicted from all others.")
}

fn departures(fit: &StaticFit) -> Table {
    let percent = |share: f64| -> Cell { (1e2 * share).into() };
    let fields = [
        Field::shown("line", "", |d: &Departure| d.line.as_str().into()),
        Field::shown("largest departure", "% FS", move |d: &Departure| {
            percent(d.share)
        })
        .decimals(4),
        Field::shown("U (95 %)", "% FS", move |d: &Departure| percent(d.expanded)).decimals(4),
        Field::shown("at", "m/s²", |d: &Departure| d.acceleration.into()).decimals(2),
    ];
    Table::of("Linearity", fields, &fit.departures).note(
        "Of the fitted curve: end point, the line through both ends; best fit, by least squares over the readings; zero based, \
         through the output at zero. U holds wherever the largest departure lies.",
    )
}

fn harmonics(fit: &StaticFit) -> Table {
    let percent = |share: f64| -> Cell { (1e2 * share).into() };
    let fields = [
        Field::shown("harmonic", "", |h: &Harmonic| h.order.into()),
        Field::shown("size", "% of 1 g", move |h: &Harmonic| percent(h.size)).decimals(4),
        Field::shown("F", "", |h: &Harmonic| h.f.into()).decimals(2),
        Field::shown("F limit", "", |h: &Harmonic| h.f_limit.into()).decimals(2),
        Field::shown("found in 90 %", "% of 1 g", move |h: &Harmonic| {
            percent(h.found)
        })
        .decimals(4),
    ];
    Table::of("Harmonics of the residuals", fields, &fit.harmonics).note(
        "The last column is the size that nine of ten tests with these angles and this scatter find.",
    )
}

/// Drifts with a control chart of each quantity.
fn history(page: Report, fit: &StabilityFit, probability: f64) -> Report {
    let count = fit.drifts.first().map_or(0, |d| d.values.len());
    let drifts: Vec<Quantity> = fit.drifts.iter().map(|d| d.drift.clone()).collect();
    let figures = [
        KeyFigure::new("calibrations", count.to_string(), ""),
        KeyFigure::new("next due in", format!("{:.0}", fit.due_in), "days")
            .note("after the last calibration"),
    ];
    let result = Section::new("Result")
        .key_figures(figures)
        .table(quantities(&drifts, probability));
    let charts = Section::new("Control charts").paragraph(
        "Markers with two standard uncertainties; the band is where a calibration of such uncertainty is expected.",
    );
    let charts = fit.drifts.iter().fold(charts, |charts, d| {
        charts.figure(
            format!("Control chart of {}", label(&d.name)),
            chart(fit, d),
        )
    });
    page.verdict(format!(
        "The next calibration is due {:.0} days after the last one.",
        fit.due_in
    ))
    .section(result.summarised())
    .section(charts)
    .section(Section::filed([chart_table(fit)]))
}

fn chart_table(fit: &StabilityFit) -> Table {
    /// Name of the quantity; day, value, u; the limits.
    type Row<'a> = (&'a str, [f64; 3], [f64; 3]);
    let rows = fit.drifts.iter().flat_map(|d| {
        let points = d.values.iter().zip(&d.limits);
        points.map(move |(value, limits)| (d.name.as_str(), *value, *limits))
    });
    let fields = [
        filed("quantity", |r: &Row<'_>| r.0),
        filed("day", |r: &Row<'_>| r.1[0]),
        filed("value", |r: &Row<'_>| r.1[1]),
        filed("u", |r: &Row<'_>| r.1[2]),
        filed("lower_limit", |r: &Row<'_>| r.2[1]),
        filed("upper_limit", |r: &Row<'_>| r.2[2]),
    ];
    Table::of("", fields, rows.collect::<Vec<Row<'_>>>()).file("control_chart.csv")
}

fn chart(fit: &StabilityFit, d: &Drift) -> XyPlot {
    let of = |f: &dyn Fn(&[f64; 3]) -> f64| d.values.iter().map(f).collect::<Vec<f64>>();
    let limit = |i: usize| d.limits.iter().map(|l| l[i]).collect::<Vec<f64>>();
    let days = of(&|v| v[0] - fit.last);
    let line = of(&|v| d.level + d.drift.value * (v[0] - d.mean_day) / MONTH);
    let bound = |k: f64| of(&|v| v[1] + k * v[2]);
    XyPlot::new(
        Axis::linear("days before the last calibration", "d"),
        Axis::linear(&d.name, &d.unit),
    )
    .series(Series::line("drift", &days, &line).band(&limit(1), &limit(2)))
    .series(Series::markers("calibrations", &days, &of(&|v| v[1])).bars(&bound(-2.0), &bound(2.0)))
}
