//! What follows from S: transverse sensitivity, misalignment, intrinsic properties.

use super::digits::{Unit, plus_minus, scaled};
use proofmass_report::number::plain;
use proofmass_report::{Axis, Cell, Column, Section, Series, Table, XyPlot};
use proofmass_shaker::MethodResult;
use proofmass_shaker::derived::Expanded;

const AXES: [&str; 3] = ["x", "y", "z"];

fn find<'a>(list: &'a [Expanded], name: &str) -> Option<&'a Expanded> {
    list.iter().find(|q| q.name == name)
}

fn cell(q: Option<&Expanded>, factor: f64) -> Cell {
    q.map_or(Cell::Empty, |q| Cell::number(scaled(q, factor)))
}

/// Transverse sensitivity and its direction.
pub(super) fn section(result: &MethodResult) -> Section {
    let mut columns = vec![Column::number("f", "Hz")];
    for axis in AXES {
        columns.push(Column::number(format!("T_{axis}"), "%"));
        columns.push(Column::number(format!("θ_{axis}"), "°"));
    }
    let mut table = Table::new("Transverse sensitivity and its direction, value ± U", columns)
        .note(
            "θ_x is counted from y towards z, θ_y from z towards x, θ_z from x towards y, modulo 180°. The direction of a \
             transverse sensitivity below its uncertainty is left out.",
        );
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("transverse sensitivity", "%"),
    );
    for f in &result.frequencies {
        let mut cells = vec![Cell::number(plain(f.frequency))];
        for axis in AXES {
            let size = find(&f.transverse, &format!("transverse.{axis}"));
            let angle = find(&f.transverse, &format!("transverse.{axis}.angle"));
            let known = size.is_some_and(|q| q.value > q.expanded);
            cells.push(cell(size, 100.0));
            cells.push(match angle {
                Some(q) if known => {
                    let degrees = q.value.to_degrees().rem_euclid(180.0);
                    Cell::number(plus_minus(degrees, q.expanded.to_degrees()))
                }
                _ => Cell::Empty,
            });
        }
        table = table.row(cells);
    }
    for (number, axis) in AXES.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .filter_map(|f| {
                let q = find(&f.transverse, &format!("transverse.{axis}"))?;
                let apart = 1.02f64.powf(number as f64 - 1.0);
                Some((f.frequency * apart, 100.0 * q.value, 100.0 * q.expanded))
            })
            .collect();
        plot = plot.series(Series::intervals(format!("output {axis}"), &points).look(number));
    }
    Section::new("Transverse sensitivity")
        .paragraph(
            "The largest response of an output to motion across its axis, over its main sensitivity, and the direction \
             of that motion (ISO 16063-31).",
        )
        .figure(
            format!(
                "Transverse sensitivity of the three outputs with its interval at {}",
                super::curves::at(&result.frequencies)
            ),
            plot,
        )
        .table(table)
}

/// Leaning of the axes and what no rotation of the device changes.
pub(super) fn axes(result: &MethodResult, unit: Unit) -> Section {
    let tilts = ["x.y", "x.z", "y.z", "y.x", "z.x", "z.y"];
    let mut columns = vec![Column::number("f", "Hz")];
    columns.extend(tilts.map(|t| {
        let (axis, towards) = t.split_at(1);
        Column::number(format!("{axis} to {}", &towards[1..]), "°")
    }));
    let mut lean = Table::new(
        "Misalignment: angle by which the sensitive axis of an output leans towards another axis, value ± U",
        columns,
    );
    let mut columns = vec![Column::number("f", "Hz")];
    columns.extend(AXES.map(|a| Column::number(format!("‖s_{a}‖"), unit.name)));
    columns.extend(["xy", "yz", "zx"].map(|p| Column::number(format!("γ_{p} − 90°"), "°")));
    let mut intrinsic = Table::new(
        "Intrinsic properties: length of the sensitivity vector of each output and angles between them, value ± U",
        columns,
    );
    for f in &result.frequencies {
        let mut cells = vec![Cell::number(plain(f.frequency))];
        cells.extend(tilts.map(|t| {
            cell(
                find(&f.misalignment, &format!("tilt.{t}")),
                180.0 / std::f64::consts::PI,
            )
        }));
        lean = lean.row(cells);
        let mut cells = vec![Cell::number(plain(f.frequency))];
        cells.extend(AXES.map(|a| cell(find(&f.intrinsic, &format!("length.{a}")), unit.factor)));
        cells.extend(["xy", "yz", "zx"].map(|p| {
            find(&f.intrinsic, &format!("angle.{p}")).map_or(Cell::Empty, |q| {
                Cell::number(plus_minus(
                    q.value.to_degrees() - 90.0,
                    q.expanded.to_degrees(),
                ))
            })
        }));
        intrinsic = intrinsic.row(cells);
    }
    Section::new("Axes and intrinsic properties")
        .paragraph(
            "Lengths of the sensitivity vectors and the angles between them do not depend on how the device was turned \
             against the bench, so the common rotation of all gluings, which limits the cross terms, does not touch them.",
        )
        .table(intrinsic)
        .table(lean)
}
