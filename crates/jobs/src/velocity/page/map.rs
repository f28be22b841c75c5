//! The report of an encoder map: its lines, and the error over a turn.

use crate::page::answer::plus_minus;
use crate::page::columns::{filed, number};
use crate::velocity::VelocityMap;
use proofmass_motion::MapLine;
use proofmass_report::Rounding::{Exact, Significant};
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Cell, Field, KeyFigure, Report, Section, Table, scientific};
use std::f64::consts::TAU;

pub(in crate::velocity) fn map(page: Report, outcome: &VelocityMap) -> Report {
    let (head, found) = (&outcome.head, &outcome.found);
    let turn = found.map.turn;
    let unit = head.unit("m");
    let there = |line: &MapLine| found.map.lines.iter().any(|l| l.order == line.order);
    let fields = [
        number(
            "cycles_per_turn",
            ("cycles per turn", ""),
            Exact,
            |l: &MapLine| l.order,
        ),
        filed(head.unit("cosine_m"), |l: &MapLine| l.cosine),
        filed(head.unit("sine_m"), |l: &MapLine| l.sine),
        filed(head.unit("u_cosine_m"), |l: &MapLine| {
            l.covariance[0][0].sqrt()
        }),
        filed(head.unit("u_sine_m"), |l: &MapLine| {
            l.covariance[1][1].sqrt()
        }),
        number(
            head.unit("amplitude_m"),
            ("amplitude", &unit),
            Significant(3),
            MapLine::amplitude,
        ),
        number(
            head.unit("u_amplitude_m"),
            ("u", &unit),
            Significant(2),
            MapLine::amplitude_uncertainty,
        ),
        Field::shown("phase", "°", |l: &MapLine| {
            Cell::number(match there(l) {
                true => format!("{:.1}", phase(l)),
                // The phase of noise.
                false => "–".to_owned(),
            })
        }),
        number(
            "share_of_velocity",
            ("of the velocity", "%"),
            Significant(2),
            |l: &MapLine| TAU * l.order * l.amplitude() / turn,
        )
        .scaled(100.0),
        Field::new("chance", |l: &MapLine| match l.chance < 1e-12 {
            true => Cell::printed(l.chance, "< 10⁻¹²"),
            false => l.chance.into(),
        })
        .page("by chance", "")
        .rounded(Significant(1)),
        Field::new("subtracted", |l: &MapLine| {
            Cell::from(usize::from(there(l))).worded(if there(l) { "yes" } else { "no" })
        })
        .page("subtracted", "")
        .left(),
    ];
    let caption = format!(
        "Lines over {:.2} turns of {} {unit}",
        found.turns,
        scientific(turn, 6)
    );
    let table = Table::of(caption, fields, &found.lines).file("lines.csv");
    let page = head
        .opened(page, head.samples)
        .verdict(
            match found.map.lines.len() {
                0 => "No line of the encoder's error is significant; nothing is to be subtracted."
                    .to_owned(),
                1 => "One line of the encoder's error is significant and is subtracted.".to_owned(),
                n => {
                    format!("{n} lines of the encoder's error are significant and are subtracted.")
                }
            } + &head.part().unwrap_or_default(),
        )
        .answers(largest(&found.map.lines, &unit))
        .section(Section::new("Encoder map").table(table).summarised());
    if found.map.lines.is_empty() {
        let lines = &found.lines;
        let amplitudes: Vec<(f64, f64, f64)> = lines
            .iter()
            .map(|l| (l.order, l.amplitude(), 2.0 * l.amplitude_uncertainty()))
            .collect();
        let most = lines.iter().map(|l| l.order).fold(0.0, f64::max);
        let plot = XyPlot::new(
            Axis::linear("cycles per turn", "").range(0.0, most + 1.0),
            Axis::linear("amplitude", unit),
        )
        .horizontal(0.0, "")
        .series(Series::intervals("", &amplitudes));
        return page.shown_by(
            "Amplitude of each line that was looked for, with ± 2 u: noise alone gives such ones",
            plot,
        );
    }
    let angle: Vec<f64> = (0..=360).map(f64::from).collect();
    let place = |a: &f64| a / 360.0 * found.map.turn;
    let error: Vec<f64> = angle.iter().map(|a| found.map.error(place(a))).collect();
    let half = angle.iter().map(|a| 2.0 * found.map.uncertainty(place(a)));
    let half: Vec<f64> = half.collect();
    let plot = XyPlot::new(
        Axis::linear("reading within a turn", "°").range(0.0, 360.0),
        Axis::linear("error of the reading", unit),
    )
    .series(Series::line("", &angle, &error).within(&half))
    .horizontal(0.0, "");
    page.section(Section::new("Error over a turn").figure(
        "What the encoder shows too much, with ± 2 u; it belongs to the zero of the readings",
        plot,
    ))
}

/// How many lines are subtracted, and the largest of them.
fn largest(lines: &[MapLine], unit: &str) -> Vec<KeyFigure> {
    let mut figures = vec![KeyFigure::new(
        "lines subtracted",
        lines.len().to_string(),
        "",
    )];
    let amplitude = |l: &&MapLine| l.amplitude();
    if let Some(line) = lines
        .iter()
        .max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)))
    {
        let expanded = 2.0 * line.amplitude_uncertainty();
        figures.push(
            KeyFigure::new("largest line", plus_minus(line.amplitude(), expanded), unit)
                .note(format!("k = 2; {} cycles per turn", line.order)),
        );
    }
    figures
}

/// Angle of the maximum of a line, in degrees of its own cycle.
fn phase(line: &MapLine) -> f64 {
    line.sine.atan2(line.cosine).to_degrees()
}
