//! The report of calibrations over frequency, held against each other.

use crate::page::answer::plus_minus;
use crate::page::columns::{coverage_factor, degrees, e_n, filed, frequency, number, percent};
use proofmass_dynamic::frequency_response::{
    ComparedPoint, Equivalence, ReferenceComparison, ReferenceElement, ResponseComparison,
};
use proofmass_report::Rounding::{Decimals, Significant};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::{
    Axis, Block, Cell, Field, Figure, KeyFigure, Report, Section, Series, Table, XyPlot, scientific,
};

/// Points of a table that is not folded away.
const MOST: usize = 60;

/// Two calibrations.
pub(super) fn pair(page: Report, pair: &ResponseComparison, names: &[String]) -> Report {
    let [a, b] = names else { return page };
    page.verdict(verdict(pair, [a, b]))
        .section(pair_result(pair, [a, b]))
        .section(differences(pair))
        .section(points(pair, [a, b]).summarised())
}

/// Three calibrations or more.
pub(super) fn several(page: Report, several: &ReferenceComparison, names: &[String]) -> Report {
    let beyond = beyond_mean(several);
    let all = several.points.len() * names.len();
    page.verdict(format!(
        "At {:.0} % of the frequencies the laboratories agree with their weighted mean (chance of 5 % or more); {}.",
        100.0 * several.consistent,
        match beyond {
            0 => format!("none of {all} deviations is beyond its U"),
            n => format!("{n} of {all} deviations are beyond their U (|E_n| > 1), where chance makes 5 %"),
        }
    ))
    .section(reference_result(several, names))
        .section(deviations(several, names).summarised())
        .section(values(several))
        .section(laboratories(several, names))
}

/// Deviations of a laboratory from the mean beyond their expanded uncertainty, in modulus or phase.
fn beyond_mean(several: &ReferenceComparison) -> usize {
    let each = several.points.iter().flat_map(|p| &p.laboratories);
    each.filter(|l| l.modulus_en.abs() > 1.0 || l.phase_en.abs() > 1.0)
        .count()
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
fn listed(title: &str, table: Table) -> Section {
    let section = Section::new(title);
    if table.rows.len() > MOST {
        section.folded("All points", [Block::Table(table)])
    } else {
        section.table(table)
    }
}

/// Point by point and as a whole.
fn verdict(pair: &ResponseComparison, [a, b]: [&str; 2]) -> String {
    let beyond = beyond(pair);
    let points = match beyond {
        0 => format!(
            "{a} and {b} agree at all {} points (|E_n| ≤ 1)",
            pair.points.len()
        ),
        n => format!(
            "{a} and {b} differ at {n} of {} points (|E_n| > 1)",
            pair.points.len()
        ),
    };
    let whole = pair
        .whole
        .as_ref()
        .map_or("", |w| match w.chi_square > w.limit {
            true => "; as a whole they differ by more than chance allows",
            false => "; as a whole the differences are within chance",
        });
    let by_size = |p: &&ComparedPoint, q: &&ComparedPoint| {
        p.modulus_difference
            .abs()
            .total_cmp(&q.modulus_difference.abs())
    };
    let moduli = match pair.points.iter().max_by(by_size) {
        Some(p) if p.modulus_difference.abs() > ROUNDING => format!(
            "moduli differ by up to {} %, {}",
            two_digits(100.0 * p.modulus_difference.abs()),
            place(pair, p)
        ),
        _ => "the moduli are the same".to_owned(),
    };
    format!("{points}{whole}; {moduli}.")
}

/// Relative difference below which two numbers are one that was written twice.
const ROUNDING: f64 = 1e-12;

/// Element and frequency of a point; of one element the frequency alone.
fn place(pair: &ResponseComparison, p: &ComparedPoint) -> String {
    let at = format!("at {} Hz", plain(p.frequency));
    match pair.points.iter().any(|other| other.element != p.element) {
        true => format!("that of {} {at}", p.element),
        false => at,
    }
}

/// Points whose differences exceed their expanded uncertainty.
fn beyond(pair: &ResponseComparison) -> usize {
    pair.points.iter().filter(|p| p.largest_en() > 1.0).count()
}

fn pair_result(pair: &ResponseComparison, [a, b]: [&str; 2]) -> Section {
    let points = &pair.points;
    let beyond = beyond(pair);
    let farthest = |of: fn(&ComparedPoint) -> f64| {
        let by_size = |p: &&ComparedPoint, q: &&ComparedPoint| of(p).abs().total_cmp(&of(q).abs());
        points.iter().max_by(by_size)
    };
    let mut figures = Vec::new();
    figures.extend(farthest(|p| p.modulus_en).map(|p| {
        let difference = plus_minus(100.0 * p.modulus_difference, 100.0 * p.modulus_expanded);
        KeyFigure::new("difference of the moduli", difference, "%").note(format!(
            "k = {:.2}, {} %, {}, where |E_n| = {} is largest",
            p.modulus_coverage_factor,
            plain(100.0 * pair.probability),
            place(pair, p),
            two_digits(p.modulus_en.abs())
        ))
    }));
    let phases = farthest(|p| p.phase.map_or(0.0, |p| p.en));
    figures.extend(phases.and_then(|p| {
        let phase = p.phase?;
        let [difference, expanded] = [phase.difference, phase.expanded].map(f64::to_degrees);
        let figure = KeyFigure::new(
            "difference of the phases",
            plus_minus(difference, expanded),
            "°",
        );
        Some(figure.note(format!(
            "k = {:.2}, {} %, {}, where |E_n| = {} is largest",
            phase.coverage_factor,
            plain(100.0 * pair.probability),
            place(pair, p),
            two_digits(phase.en.abs())
        )))
    }));
    figures.push(
        KeyFigure::new("points with |E_n| above 1", beyond.to_string(), "")
            .note(format!("of {}", points.len())),
    );
    if let Some(whole) = &pair.whole {
        figures.push(
            KeyFigure::new("χ² of all differences", scientific(whole.chi_square, 3), "").note(
                format!(
                    "of {} differences; above {} once in a thousand by chance",
                    whole.freedom,
                    two_digits(whole.limit)
                ),
            ),
        );
    }
    Section::new("Result")
        .paragraph(match pair.common.is_empty() {
            true => format!("Differences are {a} less {b}."),
            false => format!(
                "Differences are {a} less {b}; {} of both is one error, and out of U.",
                pair.common.join(", ")
            ),
        })
        .key_figures(figures)
        .summarised()
}

fn differences(pair: &ResponseComparison) -> Section {
    let mut section = Section::new("Differences over frequency").paragraph(
            "Bars are the expanded uncertainties of the differences, those of both together. Points whose bars do not reach zero have \
             |E_n| above 1.",
        );
    let mut all = elements(pair.points.iter().map(|p| p.element.as_str()));
    let largest = |element: &str| {
        let own = pair.points.iter().filter(|p| p.element == element);
        own.map(ComparedPoint::largest_en).fold(0.0, f64::max)
    };
    // The element that differs most stands first.
    all.sort_by(|a, b| largest(b).total_cmp(&largest(a)));
    for element in all {
        let of = |value: fn(&ComparedPoint) -> Option<(f64, f64)>| -> Vec<(f64, f64, f64)> {
            let points = pair.points.iter();
            points
                .filter(|p| p.element == element)
                .filter_map(|p| {
                    let (difference, expanded) = value(p)?;
                    Some((p.frequency, difference, expanded))
                })
                .collect()
        };
        let modulus = of(|p| Some((100.0 * p.modulus_difference, 100.0 * p.modulus_expanded)));
        let phase = of(|p| {
            let phase = p.phase?;
            Some((phase.difference.to_degrees(), phase.expanded.to_degrees()))
        });
        let plot = |axis: Axis, points: &[(f64, f64, f64)]| {
            XyPlot::new(Axis::log("frequency", "Hz"), axis)
                .height(200.0)
                .horizontal(0.0, "")
                .series(Series::intervals("", points))
        };
        section = section.figure(
            format!("|{element}|, relative difference"),
            plot(Axis::linear("difference of the modulus", "%"), &modulus),
        );
        if !phase.is_empty() {
            section = section.figure(
                format!("arg {element}, difference"),
                plot(Axis::linear("difference of the phase", "°"), &phase),
            );
        }
    }
    section
}

fn points(pair: &ResponseComparison, [a, b]: [&str; 2]) -> Section {
    type P = ComparedPoint;
    let unit = pair.unit.as_str();
    let mut fields = vec![
        frequency(|p: &P| p.frequency),
        Field::new("element", |p: &P| p.element.as_str().into()).page("element", ""),
        number(
            format!("modulus_first_{unit}"),
            (&format!("modulus, {a}"), unit),
            Significant(5),
            |p: &P| p.value[0].norm(),
        ),
        number(
            format!("modulus_second_{unit}"),
            (&format!("modulus, {b}"), unit),
            Significant(5),
            |p: &P| p.value[1].norm(),
        ),
        percent("difference_percent", "difference", |p: &P| {
            p.modulus_difference
        }),
        percent("U_percent", "U", |p: &P| p.modulus_expanded),
        coverage_factor("k", |p: &P| p.modulus_coverage_factor),
        e_n("E_n", |p: &P| p.modulus_en),
    ];
    if !pair.common.is_empty() {
        fields.push(number(
            "E_n_independent",
            ("E_n, nothing shared", ""),
            Decimals(2),
            |p: &P| p.modulus_en_independent,
        ));
    }
    if pair.points.iter().any(|p| p.phase.is_some()) {
        fields.extend([
            filed("phase_first_deg", |p: &P| p.value[0].arg().to_degrees()),
            filed("phase_second_deg", |p: &P| p.value[1].arg().to_degrees()),
            degrees("phase_difference_deg", "phase difference", |p: &P| {
                p.phase.map(|p| p.difference)
            }),
            degrees("phase_U_deg", "U", |p: &P| p.phase.map(|p| p.expanded)),
            coverage_factor("phase_k", |p: &P| p.phase.map(|p| p.coverage_factor)),
            e_n("phase_E_n", |p: &P| p.phase.map(|p| p.en)),
        ]);
        if !pair.common.is_empty() {
            fields.push(number(
                "phase_E_n_independent",
                ("E_n, nothing shared", ""),
                Decimals(2),
                |p: &P| p.phase.and_then(|p| p.en_independent),
            ));
        }
    }
    fields.push(filed("chi_squared", |p: &P| p.chi_square));
    let caption = format!(
        "Point by point; U for {} %",
        plain(100.0 * pair.probability)
    );
    listed(
        "Points",
        Table::of(caption, fields, &pair.points).file("comparison.csv"),
    )
}

fn reference_result(several: &ReferenceComparison, names: &[String]) -> Section {
    let points = &several.points;
    let largest = |i: usize, of: fn(&Equivalence) -> f64| -> f64 {
        let each = points.iter().filter_map(|p| p.laboratories.get(i));
        each.map(|l| of(l).abs()).fold(0.0, f64::max)
    };
    let mut figures: Vec<KeyFigure> = names
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
            format!("{:.0}", 100.0 * several.consistent),
            "%",
        )
        .note("the deviations from it have a chance of 5 % or more"),
    );
    Section::new("Result")
            .paragraph(format!(
                "The reference is the weighted mean of {} laboratories; deviations are those of each from it, and their uncertainty \
                 knows that the laboratory is part of the mean. The median stands beside it: a laboratory that is off hardly draws \
                 it along.",
                names.len()
            ))
            .key_figures(figures)
            .summarised()
}

fn deviations(several: &ReferenceComparison, names: &[String]) -> Section {
    let mut section = Section::new("Deviations over frequency").paragraph(
            "Bars are expanded uncertainties of the deviations. Laboratories are drawn a little beside one another.",
        );
    let points = &several.points;
    let mut folded = Vec::new();
    for (k, element) in elements(points.iter().map(|p| p.element.as_str()))
        .into_iter()
        .enumerate()
    {
        let plot = |label: &str, unit: &str, value: fn(&Equivalence) -> (f64, f64)| {
            let axes = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear(label, unit))
                .height(240.0)
                .horizontal(0.0, "");
            names.iter().enumerate().fold(axes, |plot, (i, name)| {
                let beside = 1.0 + 0.012 * (i as f64 - 0.5 * (names.len() - 1) as f64);
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
        let modulus = plot("deviation of the modulus", "%", |l| {
            (100.0 * l.modulus_difference, 100.0 * l.modulus_expanded)
        });
        let phase = plot("deviation of the phase", "°", |l| {
            (
                l.phase_difference.to_degrees(),
                l.phase_expanded.to_degrees(),
            )
        });
        let captions = [
            format!("|{element}|, deviation from the mean"),
            format!("arg {element}, deviation from the mean"),
        ];
        for (caption, plot) in captions.into_iter().zip([modulus, phase]) {
            match k {
                0 => section = section.figure(caption, plot),
                _ => folded.push(Block::Figure(Figure::new(caption, plot))),
            }
        }
    }
    match folded.is_empty() {
        true => section,
        false => section.folded("The other elements", folded),
    }
}

fn values(several: &ReferenceComparison) -> Section {
    type P = ReferenceElement;
    let unit = several.unit.as_str();
    let fields = [
        frequency(|p: &P| p.frequency),
        Field::new("element", |p: &P| p.element.as_str().into()).page("element", ""),
        number(
            format!("mean_modulus_{unit}"),
            ("mean, modulus", unit),
            Significant(5),
            |p: &P| p.mean.norm(),
        ),
        percent("u_mean_modulus_percent", "u", |p: &P| p.mean_uncertainty[0]),
        number("mean_phase_deg", ("phase", "°"), Decimals(3), |p: &P| {
            p.mean.arg().to_degrees()
        }),
        degrees("u_mean_phase_deg", "u", |p: &P| p.mean_uncertainty[1]),
        number(
            format!("median_modulus_{unit}"),
            ("median, modulus", unit),
            Significant(5),
            |p: &P| p.median.norm(),
        ),
        percent("u_median_modulus_percent", "u", |p: &P| {
            p.median_uncertainty[0]
        }),
        number("median_phase_deg", ("phase", "°"), Decimals(3), |p: &P| {
            p.median.arg().to_degrees()
        }),
        degrees("u_median_phase_deg", "u", |p: &P| p.median_uncertainty[1]),
        Field::new("chance", |p: &P| {
            let shown = if p.chance < 1e-3 {
                scientific(p.chance, 2)
            } else {
                two_digits(p.chance)
            };
            Cell::printed(p.chance, shown)
        })
        .page("chance", ""),
    ];
    let caption =
        "Weighted mean and median, standard uncertainties, and the chance of deviations as large";
    listed(
        "Reference values",
        Table::of(caption, fields, &several.points).file("reference.csv"),
    )
}

/// Laboratory by laboratory at every point.
type Row<'a> = (&'a ReferenceElement, &'a Equivalence, &'a str);

fn laboratories(several: &ReferenceComparison, names: &[String]) -> Section {
    let unit = several.unit.as_str();
    let mut fields = vec![
        frequency(|r: &Row<'_>| r.0.frequency),
        Field::new("element", |r: &Row<'_>| r.0.element.as_str().into()).page("element", ""),
        Field::new("laboratory", |r: &Row<'_>| r.2.into()).page("laboratory", ""),
        filed(format!("modulus_{unit}"), |r: &Row<'_>| r.1.value.norm()),
        filed("phase_deg", |r: &Row<'_>| r.1.value.arg().to_degrees()),
        percent("modulus_difference_percent", "modulus", |r: &Row<'_>| {
            r.1.modulus_difference
        }),
        percent("modulus_U_percent", "U", |r: &Row<'_>| r.1.modulus_expanded),
        coverage_factor("k", |r: &Row<'_>| r.0.coverage_factor),
        e_n("modulus_E_n", |r: &Row<'_>| r.1.modulus_en),
        degrees("phase_difference_deg", "phase", |r: &Row<'_>| {
            r.1.phase_difference
        }),
        degrees("phase_U_deg", "U", |r: &Row<'_>| r.1.phase_expanded),
        e_n("phase_E_n", |r: &Row<'_>| r.1.phase_en),
    ];
    for (k, name) in ["", "_low", "_high"].into_iter().enumerate() {
        fields.push(Field::new(
            format!("modulus_from_median{name}_percent"),
            move |r: &Row<'_>| (100.0 * r.1.median_modulus[k]).into(),
        ));
    }
    for (k, name) in ["", "_low", "_high"].into_iter().enumerate() {
        fields.push(Field::new(
            format!("phase_from_median{name}_deg"),
            move |r: &Row<'_>| r.1.median_phase[k].to_degrees().into(),
        ));
    }
    let rows = several.points.iter().flat_map(|p| {
        let laboratories = p.laboratories.iter().zip(names);
        laboratories.map(move |(l, name)| -> Row<'_> { (p, l, name) })
    });
    let caption = format!(
        "Deviations from the mean; U for {} %",
        plain(100.0 * several.probability)
    );
    listed(
        "Laboratories",
        Table::of(caption, fields, rows).file("equivalence.csv"),
    )
}
