//! The page of a plan: what a campaign will achieve before anything is measured.

use super::PlanOutcome;
use proofmass_report::number::minus;
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, Block, Cell, Field, KeyFigure, Report, Rounding, Section, Series, SpherePlot, Table,
    XyPlot,
};
use proofmass_shaker::Configuration;
use proofmass_shaker::plan::{PlanCost, Predicted};

pub(super) fn add(page: Report, plan: &PlanOutcome) -> Report {
    let expected = format!(
        "{} mV/(m/s²) at {} m/s², reference as at {} Hz",
        1e3 * plan.sensitivity,
        plan.amplitude,
        plan.frequency
    );
    let candidates = format!("{}, {}", plan.candidates.len(), plan.origin);
    let page = page
        .meta("Candidates", candidates)
        .meta("Expected", expected)
        .subtitle(format!(
            "What a plan of {} configurations will achieve",
            plan.conditioning.count
        ))
        .verdict(format!(
            "{} configurations will reach U = {:.2} % for the main terms and {:.2} % for the cross terms (k = 2).",
            plan.conditioning.count,
            200.0 * largest(&plan.predicted, true),
            200.0 * largest(&plan.predicted, false)
        ))
        .section(prediction(plan).summarised());
    let costs = match plan.costs.is_empty() {
        true => Section::filed([cost_table(&plan.costs)]),
        false => costs(&plan.costs).summarised(),
    };
    // What was chosen is the answer; all candidates are known.
    match plan.chosen {
        Some(_) => page
            .section(configurations(plan).summarised())
            .section(costs),
        None => page.section(costs).section(configurations(plan)),
    }
}

fn configurations(plan: &PlanOutcome) -> Section {
    /// Number in the plan, number of the candidate, configuration.
    type Row<'a> = (usize, usize, &'a Configuration);
    let candidate = |k: usize| {
        plan.chosen
            .as_ref()
            .and_then(|c| c.get(k))
            .map_or(k, |c| *c)
            + 1
    };
    let rows = plan.configurations.iter().enumerate();
    let rows: Vec<Row<'_>> = rows.map(|(k, c)| (k + 1, candidate(k), c)).collect();
    // Radians of whole degrees come back with rounding in the last digit.
    let degrees = |angle: f64| (angle.to_degrees() * 1e9).round() / 1e9;
    let direction = |heading: &str, i: usize| {
        let along = move |r: &Row<'_>| r.2.direction()[i].into();
        Field::shown(heading, "a_ref", along).decimals(3)
    };
    let fields = [
        Field::new("configuration", |r: &Row<'_>| r.0.into()),
        Field::shown("number", "", |r: &Row<'_>| r.1.into()),
        Field::new("inclination_deg", |r: &Row<'_>| {
            degrees(r.2.inclination).into()
        })
        .page("inclination α", "°")
        .rounded(Rounding::Plain),
        Field::new("rotation_deg", |r: &Row<'_>| degrees(r.2.rotation).into())
            .page("rotation ω", "°")
            .rounded(Rounding::Plain),
        direction("a_x", 0),
        direction("a_y", 1),
        direction("a_z", 2),
    ];
    let mut fields = Vec::from(fields);
    if !plan.sessions.is_empty() {
        let session = |r: &Row<'_>| plan.sessions.get(r.0 - 1).map(String::as_str).into();
        fields.push(Field::new("session", session).page("session", ""));
    }
    let table = Table::of("Configurations", fields, &rows).file("plan.csv");
    let sphere = plan.configurations.iter();
    let sphere = sphere.fold(SpherePlot::new("", ""), |s, c| {
        s.point(c.direction(), 1.0, "")
    });
    let words = match plan.chosen {
        Some(_) => "The chosen configurations, numbered as the candidates are.",
        None => "The configurations in the order of the plan.",
    };
    let section = Section::new("Configurations").paragraph(words);
    let caption = "Directions of the excitation in the axes of the device";
    match plan.chosen {
        Some(_) => section.table(table).figure(caption, sphere),
        None => section
            .figure(caption, sphere)
            .folded("Table of the configurations", [Block::Table(table)]),
    }
}

fn largest(predicted: &[Predicted], main: bool) -> f64 {
    predicted
        .iter()
        .filter(|p| (p.term.chars().next() == p.term.chars().nth(1)) == main)
        .map(|p| p.relative_real)
        .fold(0.0, f64::max)
}

fn prediction(plan: &PlanOutcome) -> Section {
    let percent = |main: bool| format!("{:.2}", 200.0 * largest(&plan.predicted, main));
    let c = &plan.conditioning;
    let [xy, yz, zx] = c.correlation;
    // Rounding of sines of whole turns is no correlation.
    let printed = |c: f64| minus(&format!("{c:.2}"));
    let number = |label: &str, value: f64| KeyFigure::new(label, format!("{value:.3}"), "");
    let part = |name: &str, heading: &str, of: fn(&Predicted) -> f64| {
        Field::new(name, move |p: &Predicted| (100.0 * of(p)).into())
            .page(heading, "%")
            .rounded(Rounding::TwoDigits)
    };
    let fields = [
        Field::new("term", |p: &Predicted| {
            Cell::text(&p.term).worded(format!("S_{}", p.term))
        })
        .page("term", ""),
        part("u_real_%", "real part", |p| p.relative_real),
        part("u_imaginary_%", "imaginary part", |p| p.relative_imaginary),
    ];
    let caption =
        "Predicted standard uncertainty of every term of S, relative to the mean main sensitivity";
    Section::new("Prediction")
        .key_figures([
            KeyFigure::new("U of the main terms", percent(true), "%")
                .note("k = 2, the largest of three"),
            KeyFigure::new("U of the cross terms", percent(false), "%")
                .note("of the main sensitivity, k = 2"),
            number("condition number", c.condition),
            number("D-efficiency", c.d_efficiency).note("1: directions cover the sphere evenly"),
            number("A-efficiency", c.a_efficiency),
        ])
        .paragraph(format!(
            "Correlation of the regressors: a_x with a_y {}, a_y with a_z {}, a_z with a_x {}.",
            printed(xy),
            printed(yz),
            printed(zx)
        ))
        .table(Table::of(caption, fields, &plan.predicted).file("predicted.csv"))
}

fn cost_table(costs: &[PlanCost]) -> Table {
    let number = |name: &str, heading: &str, decimals: u8, of: fn(&PlanCost) -> f64| {
        Field::new(name, move |c: &PlanCost| of(c).into())
            .page(heading, "")
            .decimals(decimals)
    };
    // The file has u, the page U = 2 u.
    let percent = |name: &str, heading: &str, of: fn(&PlanCost) -> f64| {
        Field::new(name, move |c: &PlanCost| (100.0 * of(c)).into())
            .page(heading, "%")
            .scaled(2.0)
            .decimals(2)
    };
    let chosen =
        |c: &PlanCost| -> Vec<String> { c.chosen.iter().map(|k| (k + 1).to_string()).collect() };
    let fields = [
        Field::new("configurations", |c: &PlanCost| c.conditioning.count.into())
            .page("configurations", ""),
        percent("u_main_%", "U main", |c| c.main),
        percent("u_cross_%", "U cross", |c| c.cross),
        number("condition", "condition", 2, |c| c.conditioning.condition),
        number("D_efficiency", "D-efficiency", 3, |c| {
            c.conditioning.d_efficiency
        }),
        number("A_efficiency", "A-efficiency", 3, |c| {
            c.conditioning.a_efficiency
        }),
        Field::new("candidates", |c: &PlanCost| chosen(c).join(" ").into()),
    ];
    let caption =
        "The best plans of fewer configurations (largest determinant), and what they cost";
    Table::of(caption, fields, costs)
        .note("U = 2 u (k = 2) of the worst term, relative to the mean main sensitivity.")
        .file("costs.csv")
}

fn costs(costs: &[PlanCost]) -> Section {
    let column = |of: fn(&PlanCost) -> f64| costs.iter().map(of).collect::<Vec<f64>>();
    let count = column(|c| c.conditioning.count as f64);
    let line = |name: &str, values: Vec<f64>| {
        Series::line(name, &count, &values).style(Style::LineAndMarkers)
    };
    let plot = XyPlot::new(
        Axis::linear("configurations", ""),
        Axis::linear("predicted U of the worst term", "%"),
    )
    .series(line("main terms", column(|c| 200.0 * c.main)))
    .series(line("cross terms", column(|c| 200.0 * c.cross)));
    Section::new("What fewer configurations cost")
        .figure(
            "Predicted expanded uncertainty (k = 2) of the worst main and the worst cross term",
            plot,
        )
        .table(cost_table(costs))
}
