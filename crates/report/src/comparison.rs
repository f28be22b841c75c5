//! The report of two calibrations over frequency, held against each other.

use crate::number::{minus, plain, two_digits};
use crate::{Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_calibration::frequency_response::{ComparedPoint, ResponseComparison};

/// What the report tells of a comparison.
#[derive(Clone, Debug)]
pub struct ComparisonReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// What the two are called.
    pub names: &'a [String; 2],
    /// The comparison.
    pub comparison: &'a ResponseComparison,
}

/// Points of a table that is not folded away.
const MOST: usize = 60;

impl ComparisonReport<'_> {
    /// The whole report.
    pub fn full(&self) -> Report {
        self.summary()
            .section(self.figures())
            .section(self.points())
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self) -> Report {
        let points = &self.comparison.points;
        let largest = |of: fn(&ComparedPoint) -> f64| -> f64 {
            points.iter().map(|p| of(p).abs()).fold(0.0, f64::max)
        };
        let beyond = points
            .iter()
            .filter(|p| p.modulus_en.abs() > 1.0 || p.phase_en.abs() > 1.0)
            .count();
        let mut figures = vec![
            KeyFigure::new(
                "largest |E_n|, modulus",
                two_digits(largest(|p| p.modulus_en)),
                "",
            )
            .note(format!(
                "difference up to {} %",
                two_digits(100.0 * largest(|p| p.modulus_difference))
            )),
            KeyFigure::new(
                "largest |E_n|, phase",
                two_digits(largest(|p| p.phase_en)),
                "",
            )
            .note(format!(
                "difference up to {}°",
                two_digits(largest(|p| p.phase_difference).to_degrees())
            )),
            KeyFigure::new("points with |E_n| above 1", beyond.to_string(), "")
                .note(format!("of {}", points.len())),
        ];
        if let Some(whole) = &self.comparison.whole {
            figures.push(
                KeyFigure::new("χ² of all differences", two_digits(whole.chi_square), "").note(
                    format!(
                        "of {} differences; above {} once in a thousand by chance",
                        whole.freedom,
                        two_digits(whole.limit)
                    ),
                ),
            );
        }
        let [a, b] = self.names;
        let report = self.head.open();
        report.findings(self.head.findings.iter().cloned()).section(
            Section::new("Result")
                .paragraph(format!("Differences are {a} less {b}."))
                .key_figures(figures),
        )
    }

    fn figures(&self) -> Section {
        let mut section = Section::new("Differences over frequency").paragraph(
            "Bars are the expanded uncertainties of the differences, those of both together. Points whose bars do not reach zero have \
             |E_n| above 1.",
        );
        let mut elements: Vec<&str> = Vec::new();
        for p in &self.comparison.points {
            if !elements.contains(&p.element.as_str()) {
                elements.push(&p.element);
            }
        }
        for element in elements {
            let of = |value: fn(&ComparedPoint) -> (f64, f64)| -> Vec<(f64, f64, f64)> {
                let points = self.comparison.points.iter();
                points
                    .filter(|p| p.element == element)
                    .map(|p| {
                        let (difference, expanded) = value(p);
                        (p.frequency, difference, expanded)
                    })
                    .collect()
            };
            let modulus = of(|p| (100.0 * p.modulus_difference, 100.0 * p.modulus_expanded));
            let phase = of(|p| {
                (
                    p.phase_difference.to_degrees(),
                    p.phase_expanded.to_degrees(),
                )
            });
            let plot = |axis: Axis, points: &[(f64, f64, f64)]| {
                XyPlot::new(Axis::log("frequency", "Hz"), axis)
                    .height(200.0)
                    .horizontal(0.0, "")
                    .series(Series::intervals("", points))
            };
            section = section
                .figure(
                    format!("|{element}|, relative difference"),
                    plot(Axis::linear("difference of the modulus", "%"), &modulus),
                )
                .figure(
                    format!("arg {element}, difference"),
                    plot(Axis::linear("difference of the phase", "°"), &phase),
                );
        }
        section
    }

    fn points(&self) -> Section {
        let unit = self.comparison.unit.as_str();
        let [a, b] = self.names;
        let mut table = Table::new(
            format!(
                "Point by point; U for {} %",
                plain(100.0 * self.comparison.probability)
            ),
            [
                Column::number("f", "Hz"),
                Column::text("element"),
                Column::number(format!("modulus, {a}"), unit),
                Column::number(format!("modulus, {b}"), unit),
                Column::number("difference", "%"),
                Column::number("U", "%"),
                Column::number("E_n", ""),
                Column::number("phase difference", "°"),
                Column::number("U", "°"),
                Column::number("E_n", ""),
            ],
        );
        let signed = |v: f64| Cell::number(minus(&two_digits(v)));
        for p in &self.comparison.points {
            table = table.row([
                Cell::number(plain(p.frequency)),
                Cell::text(p.element.clone()),
                Cell::number(crate::scientific(p.value[0].norm(), 5)),
                Cell::number(crate::scientific(p.value[1].norm(), 5)),
                signed(100.0 * p.modulus_difference),
                Cell::number(two_digits(100.0 * p.modulus_expanded)),
                Cell::number(minus(&format!("{:.2}", p.modulus_en))),
                signed(p.phase_difference.to_degrees()),
                Cell::number(two_digits(p.phase_expanded.to_degrees())),
                Cell::number(minus(&format!("{:.2}", p.phase_en))),
            ]);
        }
        let section = Section::new("Points");
        if self.comparison.points.len() > MOST {
            section.folded("All points", [crate::Block::Table(table)])
        } else {
            section.table(table)
        }
    }
}
