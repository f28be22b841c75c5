//! The report of a single-axis comparison with a reference.

use super::ShakerSingleOutcome;
use crate::page::answer::plus_minus;
use crate::page::columns::{degrees, e_n, filed, frequency, number, percent};
use crate::page::coverage::stated_at;
use crate::page::polar::{Polar, polar};
use crate::page::shares::shares;
use crate::plural::count;
use crate::sensor_clock::SensorClock;
use proofmass_report::Rounding::Decimals;
use proofmass_report::number::{minus, plain, two_digits};
use proofmass_report::{Axis, Field, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_shaker::check_standard::CheckPoint;
use proofmass_shaker::derived::Expanded;
use proofmass_shaker::single_axis::{ComparisonRow, SingleAxis, transverse_limit};

pub(super) fn add(page: Report, outcome: &ShakerSingleOutcome) -> Report {
    let title = "Single-axis calibration by comparison with a reference";
    let method = Section::new("Method").paragraph(
        "Comparison with a reference transducer (ISO 16063-21): S₂ = (X₂/X₁) S₁, φ₂ = φ₂,₁ + φ₁. Uncertainty by the \
         law of propagation, coverage factors from Student's t (JCGM 100:2008).",
    );
    with(page, outcome, title, [method])
}

/// The report of sensitivities over frequency, with the sections that are particular to how they were found.
pub(crate) fn with(
    mut page: Report,
    outcome: &ShakerSingleOutcome,
    title: &str,
    own: impl IntoIterator<Item = Section>,
) -> Report {
    let reference = outcome.reference.iter();
    page.meta
        .extend(reference.map(|r| ("Reference".to_owned(), r.clone())));
    page.meta
        .extend(outcome.clock.iter().flat_map(SensorClock::lines));
    let repeats = outcome.single.iter().zip(&outcome.runs);
    let repeats = repeats.filter_map(|(s, run)| row(outcome, &run.run, s));
    let run = Field::new("run", |r: &Row<'_>| r.0.0.into());
    let mut page = page
        .subtitle(format!(
            "{title}: {} at {}",
            count(outcome.runs.len(), "run"),
            match outcome.results.len() {
                1 => "one frequency".to_owned(),
                n => format!("{n} frequencies"),
            }
        ))
        .verdict(verdict(outcome))
        .answers(answer(outcome))
        .section(result(outcome))
        .section(Section::filed([
            sensitivity(outcome, [run], repeats).file("repeats.csv")
        ]))
        .section(curves(outcome))
        .section(budget(&outcome.results));
    if outcome.runs.iter().any(|r| r.transverse.is_some()) {
        page = page.section(transverse(&outcome.runs));
    }
    if !outcome.check_standard.is_empty() {
        let points = &outcome.check_standard;
        page = page
            .section(check_standard(points))
            .section(Section::filed([check_table(points)]));
    }
    own.into_iter().fold(page, Report::section)
}

fn quantity(
    outcome: &ShakerSingleOutcome,
    result: &SingleAxis,
    name: &str,
    factor: f64,
) -> Option<(f64, f64, Expanded)> {
    let q = Expanded::of(result.estimate.get(name)?, outcome.coverage_factor);
    Some((factor * q.value, factor * q.expanded, q))
}

/// What U is stated at, of modulus and phase.
fn at(outcome: &ShakerSingleOutcome) -> String {
    at_of(outcome, &["modulus", "phase"])
}

/// What U of these is stated at.
fn at_of(outcome: &ShakerSingleOutcome, names: &[&str]) -> String {
    let all = outcome.results.iter().flat_map(|r| {
        let names = names.iter();
        names.filter_map(|name| Some(quantity(outcome, r, name, 1.0)?.2))
    });
    stated_at(&all.collect::<Vec<_>>())
}

/// A sensitivity behind the name of its run, empty for a mean, and its frequency.
type Row<'a> = ((&'a str, f64), Polar);

fn row<'a>(outcome: &ShakerSingleOutcome, run: &'a str, result: &SingleAxis) -> Option<Row<'a>> {
    let (_, _, modulus) = quantity(outcome, result, "modulus", 1.0)?;
    let phase = quantity(outcome, result, "phase", 1.0).map(|(_, _, phase)| phase);
    // Without a phase the complex number has a size alone.
    let s = result.sensitivity;
    let parts = phase.is_some().then_some([s.re, s.im]);
    Some((
        (run, result.frequency),
        Polar::new(parts, &modulus, phase.as_ref()),
    ))
}

/// Sensitivities, behind the columns that come first.
fn sensitivity<'a>(
    outcome: &ShakerSingleOutcome,
    first: impl IntoIterator<Item = Field<'a, Row<'a>>>,
    results: impl IntoIterator<Item = Row<'a>>,
) -> Table {
    let mut fields: Vec<_> = first.into_iter().collect();
    fields.push(frequency(|r: &Row<'a>| r.0.1));
    fields.extend(polar(outcome.output.unit(), Some(unit(&outcome.results))));
    let caption = format!(
        "Sensitivity with its expanded uncertainty at {}",
        at(outcome)
    );
    Table::of(caption, fields, results)
}

fn check_table(points: &[CheckPoint]) -> Table {
    type P = CheckPoint;
    let fields = [
        frequency(|p: &P| p.frequency),
        filed("known", |p: &P| p.known),
        filed("measured", |p: &P| p.measured),
        percent("departure_%", "", |p: &P| p.modulus),
        percent("u_departure_%", "", |p: &P| p.modulus_uncertainty),
        e_n("E_n", |p: &P| p.e_n()[0]),
        degrees("phase_departure_deg", "", |p: &P| p.phase),
        degrees("u_phase_departure_deg", "", |p: &P| p.phase_uncertainty),
        e_n("E_n_phase", |p: &P| p.e_n()[1]),
    ];
    Table::of("", fields, points).file("check_standard.csv")
}

/// How well the sensitivity is known, and whether the bench is as it was.
fn verdict(outcome: &ShakerSingleOutcome) -> String {
    let moduli = outcome
        .results
        .iter()
        .filter_map(|r| quantity(outcome, r, "modulus", 1.0));
    let shares = moduli.map(|(m, u, _)| 100.0 * (u / m).abs());
    let (least, most) = shares.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let known = match least.is_finite() {
        true => format!(
            "The sensitivity is known to U = {} (at {})",
            match [two_digits(least), two_digits(most)] {
                [least, most] if least == most => format!("{most} %"),
                [least, most] => format!("{least} % to {most} %"),
            },
            at_of(outcome, &["modulus"])
        ),
        false => "No sensitivity was found".to_owned(),
    };
    let beyond = |p: &&CheckPoint| p.e_n().iter().any(|e| e.is_some_and(|e| e.abs() > 1.0));
    let bench = match outcome.check_standard.iter().filter(beyond).count() {
        _ if outcome.check_standard.is_empty() => String::new(),
        0 => "; the check standard agrees with its known values".to_owned(),
        n => format!(
            "; the check standard departs at {n} of {} frequencies",
            outcome.check_standard.len()
        ),
    };
    format!("{known}{bench}.")
}

/// The sensitivity at the frequency that is usually stated.
fn answer(outcome: &ShakerSingleOutcome) -> Option<KeyFigure> {
    let (unit, factor) = unit(&outcome.results);
    let nearest = outcome.results.iter().min_by(|a, b| {
        let far = |r: &SingleAxis| (r.frequency / 160.0).ln().abs();
        far(a).total_cmp(&far(b))
    });
    let r = nearest?;
    let (m, u, q) = quantity(outcome, r, "modulus", factor)?;
    let figure = KeyFigure::new(
        format!("sensitivity at {} Hz", plain(r.frequency)),
        plus_minus(m, u),
        unit,
    );
    Some(figure.note(format!(
        "± {} %, k = {:.2}",
        two_digits(100.0 * u / m),
        q.coverage_factor
    )))
}

fn result(outcome: &ShakerSingleOutcome) -> Section {
    let rows = outcome.results.iter().filter_map(|r| row(outcome, "", r));
    Section::new("Result")
        .table(sensitivity(outcome, [], rows).file("sensitivity.csv"))
        .summarised()
}

fn curves(outcome: &ShakerSingleOutcome) -> Section {
    let (unit, factor) = unit(&outcome.results);
    let points = |name: &str, factor: f64| -> Vec<(f64, f64, f64)> {
        let mut points: Vec<_> = outcome
            .results
            .iter()
            .filter_map(|r| quantity(outcome, r, name, factor).map(|(v, u, _)| (r.frequency, v, u)))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let mut plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear("modulus", unit))
        .series(Series::intervals("", &points("modulus", factor)));
    let phases = points("phase", 180.0 / std::f64::consts::PI);
    let caption = if phases.is_empty() {
        "Modulus"
    } else {
        plot = plot
            .below(Axis::linear("phase", "°"))
            .series(Series::intervals("", &phases).look(0));
        "Modulus and phase"
    };
    for panel in &mut plot.panels {
        panel.height = 220.0;
    }
    Section::new("Sensitivity against frequency").figure(
        format!(
            "{caption} of the sensitivity with intervals at {}",
            at(outcome)
        ),
        plot,
    )
}

fn check_standard(points: &[CheckPoint]) -> Section {
    let list = |of: fn(&CheckPoint) -> (f64, f64), factor: f64| -> Vec<(f64, f64, f64)> {
        let points = points.iter();
        points
            .map(|p| {
                let (d, u) = of(p);
                (p.frequency, factor * d, 2.0 * factor * u)
            })
            .collect()
    };
    let modulus = list(|p| (p.modulus, p.modulus_uncertainty), 100.0);
    let phase = list(
        |p| (p.phase, p.phase_uncertainty),
        180.0 / std::f64::consts::PI,
    );
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("departure of the modulus", "%"),
    )
    .series(Series::intervals("", &modulus))
    .horizontal(0.0, "")
    .below(Axis::linear("departure of the phase", "°"))
    .series(Series::intervals("", &phase).look(0))
    .horizontal(0.0, "");
    for panel in &mut plot.panels {
        panel.height = 160.0;
    }
    let worst = |k: usize| -> String {
        points
            .iter()
            .filter_map(|p| p.e_n()[k])
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .map_or("–".to_owned(), |e| minus(&format!("{e:.2}")))
    };
    Section::new("Check standard")
            .key_figures([
                KeyFigure::new("largest E_n of the modulus", worst(0), ""),
                KeyFigure::new("largest E_n of the phase", worst(1), ""),
            ])
            .figure(
                "Departure of the check standard from its known sensitivity, with twice the standard uncertainty of both",
                plot,
            )
}

fn transverse(runs: &[ComparisonRow]) -> Section {
    type R = ComparisonRow;
    let fields = [
        Field::new("", |r: &R| r.run.as_str().into()).page("run", ""),
        frequency(|r: &R| r.frequency),
        number("", ("transverse motion", "%"), Decimals(2), |r: &R| {
            r.transverse.map(|t| 100.0 * t)
        }),
        percent("", "limit", |r: &R| transverse_limit(r.frequency)).rounded(Decimals(0)),
        Field::new("", |r: &R| {
            match r.transverse {
                Some(t) if t > transverse_limit(r.frequency) => "exceeds",
                Some(_) => "within",
                None => "not measured",
            }
            .into()
        }),
    ];
    let caption = "Transverse motion against the limits of ISO 16063-21";
    Section::new("Transverse motion").table(Table::of(caption, fields, runs))
}

/// The prefix that suits the largest modulus; only volts take one.
fn unit(results: &[SingleAxis]) -> (&str, f64) {
    let own = results
        .iter()
        .filter_map(|r| r.estimate.components().first())
        .map(|c| c.unit.as_str())
        .next();
    if let Some(other) = own.filter(|unit| *unit != "V/(m/s²)") {
        return (other, 1.0);
    }
    let largest = results.iter().map(|r| r.sensitivity.norm());
    match largest.fold(0.0, f64::max) {
        v if v >= 0.5 => ("V/(m/s²)", 1.0),
        v if v >= 0.5e-3 => ("mV/(m/s²)", 1e3),
        _ => ("µV/(m/s²)", 1e6),
    }
}

fn budget(results: &[SingleAxis]) -> Section {
    let causes = results.iter().flat_map(|r| {
        let lines = r.estimate.budget("modulus").unwrap_or_default().into_iter();
        lines.map(|line| (line.description, line.share / results.len() as f64))
    });
    Section::new("Uncertainty").figure(
        "Causes of the uncertainty of the modulus, mean over the runs",
        shares(causes),
    )
}
