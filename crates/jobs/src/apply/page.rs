//! The page of a compensated recording.

use super::{ApplyOutcome, ChainFigures};
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
    let page = match apply.chain() {
        Some(chain) => page.section(steps(chain)),
        None => page,
    };
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

/// The steps in their order, and what they leave to be known.
fn steps(chain: &ChainFigures) -> Section {
    let list = chain.steps.iter().enumerate();
    let list: Vec<String> = list.map(|(i, step)| format!("{}. {step}", i + 1)).collect();
    let percent = |v: f64| Cell::number(format!("{:.4}", 100.0 * v));
    let time = |v: f64| Cell::number(format!("{:.3}", 1e6 * v));
    let mut rows = vec![
        (
            "delay of all steps at low frequency",
            time(chain.delay),
            "µs",
        ),
        (
            "left when the samples are in their rows",
            time(chain.delay_left),
            "µs",
        ),
    ];
    if let Some(rate) = chain.rate {
        rows.push((
            "rate of what is written",
            Cell::number(format!("{rate:.6}")),
            "Hz",
        ));
    }
    if let Some(ripple) = chain.ripple {
        rows.push(("ripple of the gain up to the corner", percent(ripple), "%"));
    }
    if let Some(folded) = chain.folded {
        rows.push(("gain of what decimation folds", percent(folded), "%"));
    }
    if let Some(u) = chain.bias_uncertainty {
        let u = Cell::number(format!("{u:.3e}"));
        rows.push(("standard uncertainty of the bias", u, "m/s²"));
    }
    if let Some(u) = chain.rotation_uncertainty {
        rows.push((
            "standard uncertainty by the angles, of the acceleration",
            percent(u),
            "%",
        ));
    }
    Section::new("Steps")
        .block(Block::Code(list.join("\n")))
        .table(measures("What the steps leave", "part", rows))
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
