//! The report of an encoder map: its lines, and the error over a turn.

use super::VelocityReport;
use proofmass_motion::{FoundMap, MapLine};
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Cell, Column, Report, Section, Table, scientific};
use std::f64::consts::TAU;

impl VelocityReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn map_summary(&self, found: &FoundMap, samples: usize) -> Report {
        let unit = self.unit("m");
        let mut table = Table::new(
            format!(
                "Lines over {:.2} turns of {} {unit}",
                found.turns,
                scientific(found.map.turn, 6)
            ),
            [
                Column::number("cycles per turn", ""),
                Column::number("amplitude", unit.clone()),
                Column::number("u", unit),
                Column::number("phase", "°"),
                Column::number("of the velocity", "%"),
                Column::number("by chance", ""),
                Column::text("subtracted"),
            ],
        );
        for line in &found.lines {
            let there = found.map.lines.iter().any(|l| l.order == line.order);
            let amplitude = line.amplitude();
            table = table.row([
                Cell::number(line.order.to_string()),
                Cell::number(scientific(amplitude, 3)),
                Cell::number(scientific(line.amplitude_uncertainty(), 2)),
                Cell::number(match there {
                    true => format!("{:.1}", phase(line)),
                    // The phase of noise.
                    false => "–".to_owned(),
                }),
                Cell::number(scientific(
                    100.0 * TAU * line.order * amplitude / found.map.turn,
                    2,
                )),
                Cell::number(match line.chance < 1e-12 {
                    true => "< 10⁻¹²".to_owned(),
                    false => scientific(line.chance, 1),
                }),
                Cell::text(if there { "yes" } else { "no" }),
            ]);
        }
        self.head(samples)
            .section(Section::new("Encoder map").table(table))
    }

    /// The whole report.
    pub(crate) fn map(&self, found: &FoundMap, samples: usize) -> Report {
        let report = self.map_summary(found, samples);
        if found.map.lines.is_empty() {
            return self.foot(report);
        }
        let angle: Vec<f64> = (0..=360).map(f64::from).collect();
        let place = |a: &f64| a / 360.0 * found.map.turn;
        let error: Vec<f64> = angle.iter().map(|a| found.map.error(place(a))).collect();
        let edge = |sign: f64| -> Vec<f64> {
            let pairs = angle.iter().zip(&error);
            pairs
                .map(|(a, e)| e + sign * 2.0 * found.map.uncertainty(place(a)))
                .collect()
        };
        let plot = XyPlot::new(
            Axis::linear("reading within a turn", "°").range(0.0, 360.0),
            Axis::linear("error of the reading", self.unit("m")),
        )
        .series(Series::line("", &angle, &error).band(&edge(-1.0), &edge(1.0)))
        .horizontal(0.0, "");
        self.foot(report.section(Section::new("Error over a turn").figure(
            "What the encoder shows too much, with ± 2 u; it belongs to the zero of the readings",
            plot,
        )))
    }
}

/// Angle of the maximum of a line, in degrees of its own cycle.
fn phase(line: &MapLine) -> f64 {
    line.sine.atan2(line.cosine).to_degrees()
}
