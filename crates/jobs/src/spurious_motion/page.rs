//! The report of a measurement of the spurious motion.

use super::{CORRECTIONS, LargestMotion, Measurement, SpuriousMotionOutcome};
use crate::campaign::SpuriousFile;
use crate::page::AXES;
use crate::page::answer::plus_minus;
use crate::page::columns::{degrees, e_n, filed, frequency, number, percent};
use proofmass_report::Rounding::{Decimals, Exact, Plain};
use proofmass_report::number::plain;
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, Block, Cell, Field, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_shaker::SpuriousTable;
use proofmass_shaker::spurious::{Average, Comparison, RatioRepeats, RatioSummary};

pub(super) fn add(page: Report, outcome: &SpuriousMotionOutcome) -> Report {
    let [first, others @ ..] = outcome.measurements.as_slice() else {
        return page;
    };
    let mut page = page
        .subtitle(format!(
            "Spurious motion of the bench: {} ratios at {} places",
            first.summaries.len(),
            first.table.entries.len()
        ))
        .verdict(verdict(outcome, first))
        .answers(answer(first))
        .section(result(first))
        .section(curves(&first.table))
        .section(directions(&outcome.measurements));
    for (label, list) in &outcome.comparisons {
        page = page.section(compared(&first.label, label, list));
    }
    let mut files: Vec<Table> = CORRECTIONS[1..]
        .iter()
        .zip(others)
        .map(|(name, other)| SpuriousFile::table(&other.table).file(*name))
        .collect();
    if !outcome.comparisons.is_empty() {
        let rows = outcome.comparisons.iter().flat_map(|(label, list)| {
            let both = (first.label.as_str(), label.as_str());
            list.iter().map(move |c| -> Compared<'_> { (both, c) })
        });
        files.push(differences(rows).file("comparison.csv"));
    }
    page.section(Section::new("Method").paragraph(
        "Ratios of the motion along each axis of the bench to the reference acceleration, jΩ v/a. Averages are of \
         complex ratios, never of degrees; repeats whose moduli agree while their phases cover the circle were \
         recorded without a common clock and are not averaged.",
    ))
    .section(Section::filed(files))
}

/// How many ratios were averaged, and whether further measurements agree.
fn verdict(outcome: &SpuriousMotionOutcome, first: &Measurement) -> String {
    let all = first.summaries.len();
    let refused = first.summaries.iter().filter(|s| mean(s).is_none()).count();
    let averaged = match refused {
        0 => format!("All {all} ratios have repeats with a common phase and were averaged"),
        n => format!("{n} of {all} ratios have no common phase and were not averaged"),
    };
    let compared = outcome.comparisons.iter().map(|(label, list)| {
        match list.iter().filter(|c| disagrees(c)).count() {
            0 => format!("; {label} agrees"),
            n => format!("; {label} disagrees in {n} of {} ratios", list.len()),
        }
    });
    let size = match (first.largest(&[0, 1]), first.largest(&[2])) {
        (Some(across), along) => {
            let along = along.map_or(String::new(), |z| {
                format!("; along it the motion departs by up to {}", in_words(&z))
            });
            format!(
                "Across the excitation the motion is up to {}{along}. ",
                in_words(&across)
            )
        }
        (None, Some(z)) => format!(
            "Along the excitation the motion departs by up to {}. ",
            in_words(&z)
        ),
        (None, None) => String::new(),
    };
    format!("{size}{averaged}{}.", compared.collect::<String>())
}

/// `(1.23 ± 0.05) % of it (k = 2.05; y′ at 30°, 160 Hz)`.
fn in_words(m: &LargestMotion) -> String {
    let size = plus_minus(100.0 * m.modulus, 100.0 * m.expanded);
    format!(
        "({size}) % of it (k = {:.2}; {})",
        m.coverage_factor,
        place(m)
    )
}

fn place(m: &LargestMotion) -> String {
    format!(
        "{}′ at {:.0}°, {} Hz",
        AXES[m.axis],
        m.inclination.to_degrees(),
        plain(m.frequency)
    )
}

/// The largest motion across the excitation, else along it: what a reader came for.
fn answer(first: &Measurement) -> Option<KeyFigure> {
    let across = first.largest(&[0, 1]);
    let name = match across {
        Some(_) => "largest motion across the excitation",
        None => "largest departure along the excitation",
    };
    let m = across.or_else(|| first.largest(&[2]))?;
    let size = plus_minus(100.0 * m.modulus, 100.0 * m.expanded);
    let figure = KeyFigure::new(name, size, "%");
    Some(figure.note(format!("{}; 95 %, k = {:.2}", place(&m), m.coverage_factor)))
}

fn result(first: &Measurement) -> Section {
    let (summaries, table) = (&first.summaries, &first.table);
    let refused = summaries.iter().filter(|s| mean(s).is_none()).count();
    let figures = [
        KeyFigure::new(
            "ratios averaged",
            (summaries.len() - refused).to_string(),
            "",
        ),
        KeyFigure::new(
            "refused for want of a common phase",
            refused.to_string(),
            "",
        ),
    ];
    Section::new("Result")
        .key_figures(figures)
        .table(SpuriousFile::table(table).file(CORRECTIONS[0]))
        .summarised()
}

fn curves(table: &SpuriousTable) -> Section {
    let mut inclinations: Vec<f64> = vec![];
    for e in &table.entries {
        if !inclinations
            .iter()
            .any(|i| (i - e.inclination).abs() < 1e-6)
        {
            inclinations.push(e.inclination);
        }
    }
    inclinations.sort_by(f64::total_cmp);
    let mut plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::default());
    plot.panels.clear();
    for (k, axis) in AXES.iter().enumerate() {
        plot = plot.below(Axis::linear(format!("|ε_{axis}′|"), "%"));
        for (number, &inclination) in inclinations.iter().enumerate() {
            let mut points: Vec<(f64, f64)> = table
                .entries
                .iter()
                .filter(|e| (e.inclination - inclination).abs() < 1e-6)
                .map(|e| (e.frequency, 100.0 * e.ratio[k].norm()))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            let name = if k == 0 {
                format!("{:.0}°", inclination.to_degrees())
            } else {
                String::new()
            };
            plot = plot.series(
                Series::line(name, &x, &y)
                    .style(Style::LineAndMarkers)
                    .look(number),
            );
        }
    }
    Section::new("Spurious motion against frequency").figure(
        "Modulus of the spurious motion along the three axes of the bench for each inclination",
        plot,
    )
}

/// A ratio: label of its measurement, repeats and what they say.
type Ratio<'a> = (&'a str, &'a RatioRepeats, &'a RatioSummary);

/// The mean with the variances of its parts, where the repeats have one.
fn mean(s: &RatioSummary) -> Option<[f64; 4]> {
    match &s.average {
        Average::Coherent(e) => Some([e.mean.re, e.mean.im, e.covariance[0], e.covariance[2]]),
        Average::Incoherent { .. } => None,
    }
}

fn ratios<'a>(caption: &str, rows: &[Ratio<'a>], several: bool) -> Table {
    type R<'a> = Ratio<'a>;
    let label = Field::new("measurement", |r: &R<'a>| r.0.into());
    let fields = [
        match several {
            true => label.page("measurement", ""),
            false => label,
        },
        Field::new("", |r: &R<'a>| format!("{}′", r.2.axis).into()).page("axis", ""),
        number("inclination_deg", ("α", "°"), Plain, |r: &R<'a>| {
            (r.1.inclination.to_degrees() * 1e9).round() / 1e9
        }),
        frequency(|r: &R<'a>| r.1.frequency),
        Field::new("axis", |r: &R<'a>| r.2.axis.as_str().into()),
        number("repeats", ("repeats", ""), Exact, |r: &R<'a>| {
            r.1.ratios.len()
        }),
        Field::new("averaged", |r: &R<'a>| {
            if mean(r.2).is_some() { "yes" } else { "no" }.into()
        }),
        percent("", "modulus, mean", |r: &R<'a>| {
            r.2.moduli.iter().sum::<f64>() / r.2.moduli.len().max(1) as f64
        })
        .rounded(Decimals(2)),
        degrees("", "mean direction", |r: &R<'a>| r.2.phases.mean).rounded(Decimals(1)),
        filed("real", |r: &R<'a>| mean(r.2).map(|m| m[0])),
        filed("imaginary", |r: &R<'a>| mean(r.2).map(|m| m[1])),
        filed("u_real", |r: &R<'a>| mean(r.2).map(|m| m[2].sqrt())),
        filed("u_imaginary", |r: &R<'a>| mean(r.2).map(|m| m[3].sqrt())),
        number(
            "mean_resultant_length",
            ("resultant length", ""),
            Decimals(3),
            |r: &R<'a>| r.2.phases.resultant,
        ),
        Field::new("rayleigh_p", |r: &R<'a>| match r.2.phases.rayleigh_p {
            p if p < 1e-3 => Cell::printed(p, "< 0.001"),
            p => Cell::printed(p, format!("{p:.3}")),
        })
        .page("Rayleigh p", ""),
        degrees(
            "circular_standard_deviation_deg",
            "circular s",
            |r: &R<'a>| r.2.phases.standard_deviation,
        )
        .rounded(Decimals(1)),
        Field::new("", |r: &R<'a>| {
            if mean(r.2).is_some() {
                "averaged"
            } else {
                "refused"
            }
            .into()
        }),
    ];
    Table::of(caption, fields, rows)
}

fn directions(measurements: &[Measurement]) -> Section {
    let several = measurements.len() > 1;
    let all: Vec<Ratio<'_>> = measurements
        .iter()
        .flat_map(|m| {
            let pairs = m.repeats.iter().zip(&m.summaries);
            pairs.map(|(r, s)| (m.label.as_str(), r, s))
        })
        .collect();
    let mut section = Section::new("Directions of the repeats").paragraph(
        "The Rayleigh test asks whether directions are uniform on the circle: a small p says that the repeats share a \
         phase. Repeats without one have no mean, however well their moduli agree.",
    );
    let refused: Vec<Ratio<'_>> = all
        .iter()
        .copied()
        .filter(|r| mean(r.2).is_none())
        .collect();
    if !refused.is_empty() {
        section = section.table(ratios("Ratios that were not averaged", &refused, several));
    }
    let caption = "Repeats of every ratio, with the statistics of their directions on the circle";
    let table = ratios(caption, &all, several).file("ratios.csv");
    section.folded("All ratios", [Block::Table(table)])
}

/// A difference between the first measurement and another, or a calculated motion.
type Compared<'a> = ((&'a str, &'a str), &'a Comparison);

fn disagrees(c: &Comparison) -> bool {
    c.e_n.is_some_and(|e| e > 1.0)
}

fn differences<'a>(rows: impl IntoIterator<Item = Compared<'a>>) -> Table {
    type R<'a> = Compared<'a>;
    let fields = [
        Field::new("first", |r: &R<'a>| r.0.0.into()),
        Field::new("second", |r: &R<'a>| r.0.1.into()),
        Field::new("", |r: &R<'a>| format!("{}′", r.1.axis).into()).page("axis", ""),
        degrees("inclination_deg", "α", |r: &R<'a>| r.1.inclination).rounded(Plain),
        frequency(|r: &R<'a>| r.1.frequency),
        Field::new("axis", |r: &R<'a>| r.1.axis.as_str().into()),
        number(
            "difference",
            ("|difference|", "%"),
            Decimals(3),
            |r: &R<'a>| r.1.difference,
        )
        .scaled(100.0),
        e_n("E_n", |r: &R<'a>| r.1.e_n),
        Field::new("", |r: &R<'a>| {
            if disagrees(r.1) { "disagree" } else { "" }.into()
        }),
    ];
    Table::of("Differences", fields, rows)
}

fn compared(first: &str, label: &str, list: &[Comparison]) -> Section {
    let beyond = list.iter().filter(|c| disagrees(c)).count();
    Section::new(format!("Compared with {label}"))
        .paragraph(format!(
            "{beyond} of {} ratios differ by more than their expanded uncertainties allow (E_n > 1).",
            list.len()
        ))
        .table(differences(list.iter().map(|c| ((first, label), c))))
}
