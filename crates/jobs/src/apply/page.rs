//! The page of a compensated recording.

use super::ApplyOutcome;
use crate::page::measures::measures;
use proofmass_report::{Block, Cell, KeyFigure, Report, Section};

pub(super) fn add(page: Report, apply: &ApplyOutcome) -> Report {
    let rows = match apply.rows() {
        1 => "One row was compensated".to_owned(),
        n => format!("{n} rows were compensated"),
    };
    let page = page
        .verdict(match apply.error() {
            Some(e) => format!(
                "{rows}; from {} Hz to {} Hz the error is at most {:.3} % of the acceleration.",
                e.band[0],
                e.band[1],
                100.0 * e.stated
            ),
            None => format!("{rows}."),
        })
        .section(result(apply).summarised());
    let Some(band) = apply.band() else {
        return page;
    };
    let n = (band.matrix.len() as f64).sqrt().round() as usize;
    let row = |r: &[f64]| -> String {
        let numbers: Vec<String> = r.iter().map(|v| format!("{v:>14.7e}")).collect();
        numbers.join(" ")
    };
    let rows = |m: &[f64]| -> Block {
        let rows: Vec<String> = m.chunks(n.max(1)).map(row).collect();
        Block::Code(rows.join("\n"))
    };
    page.section(
        Section::new("Matrix of the band")
            .paragraph("K as a constant (rows: outputs) and its inverse, which was applied:")
            .block(rows(&band.matrix))
            .block(rows(&band.inverse)),
    )
}

fn result(apply: &ApplyOutcome) -> Section {
    let mut figures = vec![
        KeyFigure::new("rows written", apply.rows().to_string(), "")
            .note(format!("{} left out", apply.left_out())),
    ];
    if let Some(filter) = apply.filter() {
        figures.push(
            KeyFigure::new("filter", filter.length.to_string(), "samples")
                .note(format!("at {:.6} Hz", filter.rate)),
        );
    }
    let Some(e) = apply.error() else {
        return Section::new("Result").key_figures(figures);
    };
    let percent = |v: f64| format!("{:.3}", 100.0 * v);
    let [low, high] = e.band;
    figures.push(
        KeyFigure::new("stated error", percent(e.stated), "%")
            .note(format!("of the acceleration, {low} Hz to {high} Hz")),
    );
    let interpolation = e.interpolation.map_or("–".to_owned(), percent);
    let with_delay = percent(e.departure_with_delay);
    let uncertainty = percent(e.uncertainty);
    let delay = format!("{:.3}", 1e6 * e.delay);
    let rows = [
        ("departure from the inverse of K", percent(e.departure), "%"),
        ("the same, delay not taken out", with_delay, "%"),
        ("expanded uncertainty of K, 95 %", uncertainty, "%"),
        ("interpolation between the frequencies", interpolation, "%"),
        ("delay of the compensated signal", delay, "µs"),
    ];
    let rows = rows.map(|(part, value, unit)| (part, Cell::number(value), unit));
    Section::new("Result").key_figures(figures).table(measures(
        "Largest values over the band",
        "part",
        rows,
    ))
}
