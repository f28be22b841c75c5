//! The report of calibrations over frequency, held against each other.

use proofmass_dynamic::frequency_response::{
    ComparedPoint, Equivalence, ReferenceComparison, ReferenceElement, ResponseComparison,
};
use proofmass_report::number::{minus, plain, two_digits};
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};

/// What the report tells of a comparison.
#[derive(Clone, Debug)]
pub(crate) struct ComparisonReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// What they are called.
    pub names: &'a [String],
    /// Two, held against each other.
    pub comparison: Option<&'a ResponseComparison>,
    /// More, held against their reference value.
    pub reference: Option<&'a ReferenceComparison>,
}

/// Points of a table that is not folded away.
const MOST: usize = 60;

impl ComparisonReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary();
        if let Some(pair) = self.pair() {
            report = report.section(pair.figures()).section(pair.points());
        }
        if let Some(several) = self.several() {
            report = report
                .section(several.figures())
                .section(several.values())
                .section(several.laboratories());
        }
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let mut report = self
            .head
            .open()
            .findings(self.head.findings.iter().cloned());
        if let Some(pair) = self.pair() {
            report = report.section(pair.result());
        }
        if let Some(several) = self.several() {
            report = report.section(several.result());
        }
        report
    }

    fn pair(&self) -> Option<Pair<'_>> {
        match self.names {
            [a, b] => self.comparison.map(|comparison| Pair {
                names: [a, b],
                comparison,
            }),
            _ => None,
        }
    }

    fn several(&self) -> Option<Several<'_>> {
        self.reference.map(|reference| Several {
            names: self.names,
            reference,
        })
    }
}

/// Names of the elements, each once.
fn elements<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut list: Vec<&str> = Vec::new();
    for name in names {
        if !list.contains(&name) {
            list.push(name);
        }
    }
    list
}

/// A table, folded away when it is long.
fn listed(section: Section, table: Table, rows: usize) -> Section {
    if rows > MOST {
        section.folded("All points", [proofmass_report::Block::Table(table)])
    } else {
        section.table(table)
    }
}

fn signed(v: f64) -> Cell {
    Cell::number(minus(&two_digits(v)))
}

fn en(v: f64) -> Cell {
    Cell::number(minus(&format!("{v:.2}")))
}

/// Two calibrations.
struct Pair<'a> {
    names: [&'a str; 2],
    comparison: &'a ResponseComparison,
}

impl Pair<'_> {
    fn result(&self) -> Section {
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
        Section::new("Result")
            .paragraph(format!("Differences are {a} less {b}."))
            .key_figures(figures)
    }

    fn figures(&self) -> Section {
        let mut section = Section::new("Differences over frequency").paragraph(
            "Bars are the expanded uncertainties of the differences, those of both together. Points whose bars do not reach zero have \
             |E_n| above 1.",
        );
        for element in elements(self.comparison.points.iter().map(|p| p.element.as_str())) {
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
        for p in &self.comparison.points {
            table = table.row([
                Cell::number(plain(p.frequency)),
                Cell::text(p.element.clone()),
                Cell::number(proofmass_report::scientific(p.value[0].norm(), 5)),
                Cell::number(proofmass_report::scientific(p.value[1].norm(), 5)),
                signed(100.0 * p.modulus_difference),
                Cell::number(two_digits(100.0 * p.modulus_expanded)),
                en(p.modulus_en),
                signed(p.phase_difference.to_degrees()),
                Cell::number(two_digits(p.phase_expanded.to_degrees())),
                en(p.phase_en),
            ]);
        }
        listed(Section::new("Points"), table, self.comparison.points.len())
    }
}

/// Three calibrations or more.
struct Several<'a> {
    names: &'a [String],
    reference: &'a ReferenceComparison,
}

impl Several<'_> {
    fn result(&self) -> Section {
        let points = &self.reference.points;
        let largest = |i: usize, of: fn(&Equivalence) -> f64| -> f64 {
            let each = points.iter().filter_map(|p| p.laboratories.get(i));
            each.map(|l| of(l).abs()).fold(0.0, f64::max)
        };
        let mut figures: Vec<KeyFigure> = self
            .names
            .iter()
            .enumerate()
            .map(|(i, name)| {
                let beside = two_digits(largest(i, |l| l.phase_en));
                KeyFigure::new(
                    format!("largest |E_n|, modulus, {name}"),
                    two_digits(largest(i, |l| l.modulus_en)),
                    "",
                )
                .note(format!(
                    "deviation up to {} %; of the phase |E_n| up to {beside}",
                    two_digits(100.0 * largest(i, |l| l.modulus_difference))
                ))
            })
            .collect();
        figures.push(
            KeyFigure::new(
                "frequencies at which the mean is fit to be the reference",
                format!("{:.0}", 100.0 * self.reference.consistent),
                "%",
            )
            .note("the deviations from it have a chance of 5 % or more"),
        );
        Section::new("Result")
            .paragraph(format!(
                "The reference is the weighted mean of {} laboratories; deviations are those of each from it, and their uncertainty \
                 knows that the laboratory is part of the mean. The median stands beside it: a laboratory that is off hardly draws \
                 it along.",
                self.names.len()
            ))
            .key_figures(figures)
    }

    fn figures(&self) -> Section {
        let mut section = Section::new("Deviations over frequency").paragraph(
            "Bars are expanded uncertainties of the deviations. Laboratories are drawn a little beside one another.",
        );
        let points = &self.reference.points;
        for element in elements(points.iter().map(|p| p.element.as_str())) {
            let plot = |label: &str, unit: &str, value: fn(&Equivalence) -> (f64, f64)| {
                let axes = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear(label, unit))
                    .height(240.0)
                    .horizontal(0.0, "");
                self.names.iter().enumerate().fold(axes, |plot, (i, name)| {
                    let beside = 1.0 + 0.012 * (i as f64 - 0.5 * (self.names.len() - 1) as f64);
                    let of = |p: &ReferenceElement| {
                        let (difference, expanded) = value(p.laboratories.get(i)?);
                        Some((beside * p.frequency, difference, expanded))
                    };
                    let list: Vec<_> = points
                        .iter()
                        .filter(|p| p.element == element)
                        .filter_map(of)
                        .collect();
                    plot.series(Series::intervals(name.clone(), &list).look(i))
                })
            };
            section = section
                .figure(
                    format!("|{element}|, deviation from the mean"),
                    plot("deviation of the modulus", "%", |l| {
                        (100.0 * l.modulus_difference, 100.0 * l.modulus_expanded)
                    }),
                )
                .figure(
                    format!("arg {element}, deviation from the mean"),
                    plot("deviation of the phase", "°", |l| {
                        (
                            l.phase_difference.to_degrees(),
                            l.phase_expanded.to_degrees(),
                        )
                    }),
                );
        }
        section
    }

    fn values(&self) -> Section {
        let unit = self.reference.unit.as_str();
        let mut table = Table::new(
            "Weighted mean and median, standard uncertainties, and the chance of deviations as large",
            [
                Column::number("f", "Hz"),
                Column::text("element"),
                Column::number("mean, modulus", unit),
                Column::number("u", "%"),
                Column::number("phase", "°"),
                Column::number("u", "°"),
                Column::number("median, modulus", unit),
                Column::number("u", "%"),
                Column::number("phase", "°"),
                Column::number("u", "°"),
                Column::number("chance", ""),
            ],
        );
        for p in &self.reference.points {
            table = table.row([
                Cell::number(plain(p.frequency)),
                Cell::text(p.element.clone()),
                Cell::number(proofmass_report::scientific(p.mean.norm(), 5)),
                Cell::number(two_digits(100.0 * p.mean_uncertainty[0])),
                Cell::number(minus(&format!("{:.3}", p.mean.arg().to_degrees()))),
                Cell::number(two_digits(p.mean_uncertainty[1].to_degrees())),
                Cell::number(proofmass_report::scientific(p.median.norm(), 5)),
                Cell::number(two_digits(100.0 * p.median_uncertainty[0])),
                Cell::number(minus(&format!("{:.3}", p.median.arg().to_degrees()))),
                Cell::number(two_digits(p.median_uncertainty[1].to_degrees())),
                Cell::number(if p.chance < 1e-3 {
                    proofmass_report::scientific(p.chance, 2)
                } else {
                    two_digits(p.chance)
                }),
            ]);
        }
        let rows = self.reference.points.len();
        listed(Section::new("Reference values"), table, rows)
    }

    fn laboratories(&self) -> Section {
        let mut table = Table::new(
            format!(
                "Deviations from the mean; U for {} %",
                plain(100.0 * self.reference.probability)
            ),
            [
                Column::number("f", "Hz"),
                Column::text("element"),
                Column::text("laboratory"),
                Column::number("modulus", "%"),
                Column::number("U", "%"),
                Column::number("E_n", ""),
                Column::number("phase", "°"),
                Column::number("U", "°"),
                Column::number("E_n", ""),
            ],
        );
        let mut rows = 0;
        for p in &self.reference.points {
            for (l, name) in p.laboratories.iter().zip(self.names) {
                rows += 1;
                table = table.row([
                    Cell::number(plain(p.frequency)),
                    Cell::text(p.element.clone()),
                    Cell::text(name.clone()),
                    signed(100.0 * l.modulus_difference),
                    Cell::number(two_digits(100.0 * l.modulus_expanded)),
                    en(l.modulus_en),
                    signed(l.phase_difference.to_degrees()),
                    Cell::number(two_digits(l.phase_expanded.to_degrees())),
                    en(l.phase_en),
                ]);
            }
        }
        listed(Section::new("Laboratories"), table, rows)
    }
}
