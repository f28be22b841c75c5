//! Sensitivity against frequency.

use super::digits::{CROSS, MAIN, TERMS, Unit, degrees, degrees_of_freedom, plus_minus, scaled};
use crate::page::coverage::stated_at;
use proofmass_report::number::plain;
use proofmass_report::{Axis, Cell, Column, Section, Series, Table, XyPlot};
use proofmass_shaker::{FrequencyResult, MethodResult};

/// Points of several series at one frequency are drawn this far apart, so that their bars can be told.
const APART: f64 = 1.02;

pub(super) fn section(result: &MethodResult, unit: Unit) -> Section {
    Section::new("Sensitivity against frequency")
        .figure(
            format!(
                "Main terms: modulus and phase with their intervals at {}",
                at(&result.frequencies)
            ),
            terms_plot(result, &MAIN, unit),
        )
        .figure(
            format!(
                "Cross terms: modulus and phase with their intervals at {}; points of one frequency are drawn beside each \
                 other, and a phase is shown where the modulus exceeds its uncertainty",
                at(&result.frequencies)
            ),
            terms_plot(result, &CROSS, unit),
        )
        .table(phases(result))
}

/// What U of the terms is stated at.
pub(super) fn at(frequencies: &[FrequencyResult]) -> String {
    let terms = frequencies.iter().flat_map(|f| &f.sensitivity);
    stated_at(terms.flat_map(|t| std::iter::once(&t.modulus).chain(&t.phase)))
}

/// The table a reader takes away: main terms at every frequency.
pub(super) fn main_table(frequencies: &[FrequencyResult], unit: Unit) -> Table {
    let mut columns = vec![Column::number("f", "Hz")];
    for axis in ["xx", "yy", "zz"] {
        columns.push(Column::number(format!("|S_{axis}|"), unit.name));
        columns.push(Column::number("U", "%"));
    }
    let mut table = Table::new(
        format!(
            "Main terms with their expanded uncertainty at {}",
            at(frequencies)
        ),
        columns,
    );
    for f in frequencies {
        let mut cells = vec![Cell::number(plain(f.frequency))];
        for k in MAIN {
            let m = &f.sensitivity[k].modulus;
            cells.push(Cell::number(scaled(m, unit.factor)));
            cells.push(Cell::number(format!("{:.2}", 100.0 * m.expanded / m.value)));
        }
        table = table.row(cells);
    }
    table
}

fn phases(result: &MethodResult) -> Table {
    let mut columns = vec![Column::number("f", "Hz")];
    for axis in ["xx", "yy", "zz"] {
        columns.push(Column::number(format!("phase of S_{axis}"), "°"));
        columns.push(Column::number("k", ""));
        columns.push(Column::number("ν_eff", ""));
    }
    let mut table = Table::new(
        "Phases of the main terms with their expanded uncertainty; coverage factor and effective degrees of freedom of \
         the modulus",
        columns,
    );
    for f in &result.frequencies {
        let mut cells = vec![Cell::number(plain(f.frequency))];
        for k in MAIN {
            let m = &f.sensitivity[k].modulus;
            cells.push(
                degrees(&f.sensitivity[k])
                    .map_or(Cell::Empty, |(v, u)| Cell::number(plus_minus(v, u))),
            );
            cells.push(Cell::number(format!("{:.2}", m.coverage_factor)));
            cells.push(Cell::number(degrees_of_freedom(m.dof)));
        }
        table = table.row(cells);
    }
    table
}

fn terms_plot(result: &MethodResult, which: &[usize], unit: Unit) -> XyPlot {
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("modulus", unit.name),
    );
    let place = |number: usize, f: f64| {
        if which.len() > 3 {
            f * APART.powf(number as f64 - 0.5 * (which.len() - 1) as f64)
        } else {
            f
        }
    };
    for (number, &k) in which.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .map(|f| {
                let m = &f.sensitivity[k].modulus;
                (
                    place(number, f.frequency),
                    unit.factor * m.value,
                    unit.factor * m.expanded,
                )
            })
            .collect();
        plot = plot.series(Series::intervals(format!("S_{}", TERMS[k]), &points).look(number));
    }
    plot = plot.below(Axis::linear("phase", "°"));
    for (number, &k) in which.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .filter_map(|f| {
                let (value, expanded) = degrees(&f.sensitivity[k])?;
                Some((place(number, f.frequency), value, expanded))
            })
            .collect();
        if !points.is_empty() {
            plot = plot.series(Series::intervals(String::new(), &points).look(number));
        }
    }
    for panel in &mut plot.panels {
        panel.height = 220.0;
    }
    plot
}
