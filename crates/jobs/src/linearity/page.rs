//! The page of a linearity over the level.

use crate::page::parameters::parameters;
use proofmass_dynamic::linearity::LevelLinearity;
use proofmass_report::number::two_digits;
use proofmass_report::{Axis, Field, KeyFigure, Report, Section, Series, Table, XyPlot};

pub(super) fn add(page: Report, linearity: &LevelLinearity) -> Report {
    let figure = KeyFigure::new(
        "non-linearity",
        two_digits(100.0 * linearity.non_linearity),
        "%",
    )
    .note("largest departure, of the highest level");
    let mut quantities = linearity.estimate.quantities();
    for q in &mut quantities {
        q.name = q.name.replace('_', " ");
    }
    page.verdict(format!(
        "Up to the highest level the output departs from a straight line by {} % at most.",
        two_digits(100.0 * linearity.non_linearity)
    ))
    .section(
        Section::new("Result")
            .key_figures([figure])
            .table(parameters("Output = S a (1 + κ a)", &quantities))
            .summarised(),
    )
    .section(Section::new("Levels").figure(
        "Departures from the best straight line through zero; bars are two standard uncertainties",
        departures(linearity),
    ))
    .section(Section::filed([table(linearity)]))
}

/// Departures from the best straight line.
fn table(linearity: &LevelLinearity) -> Table {
    let fields = [
        Field::new("level_m/s2", |row: &[f64; 3]| row[0].into()),
        Field::new("departure", |row: &[f64; 3]| row[1].into()),
        Field::new("u", |row: &[f64; 3]| row[2].into()),
    ];
    Table::of("", fields, &linearity.departures).file("departures.csv")
}

fn departures(linearity: &LevelLinearity) -> XyPlot {
    let points: Vec<(f64, f64, f64)> = linearity
        .departures
        .iter()
        .map(|[a, d, u]| (*a, 100.0 * d, 200.0 * u))
        .collect();
    XyPlot::new(
        Axis::linear("level", "m/s²"),
        Axis::linear("departure from the best straight line", "%"),
    )
    .horizontal(0.0, "")
    .series(Series::intervals("", &points))
}
