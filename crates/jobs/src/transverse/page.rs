//! The report of a transverse sensitivity test.

use super::TransverseOutcome;
use crate::page::columns::{coverage_factor, filed, frequency, number};
use crate::page::coverage::stated_at;
use crate::page::shares::shares;
use num_complex::Complex64;
use proofmass_report::Rounding::{Exact, TwoDigits};
use proofmass_report::number::{plain, rounded};
use proofmass_report::{Axis, Cell, Field, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_shaker::transverse::{Motion, TransverseRow, TransverseSensitivity};

pub(super) fn add(mut page: Report, outcome: &TransverseOutcome) -> Report {
    let results = &outcome.results;
    let across: usize = results.iter().map(|r| r.runs).sum();
    page.meta.extend(
        outcome
            .reference
            .iter()
            .map(|r| ("Reference".to_owned(), r.clone())),
    );
    page = page
        .subtitle(format!(
            "Transverse sensitivity at {}: {across} runs across the axis",
            if results.len() == 1 {
                "one frequency".to_owned()
            } else {
                format!("{} frequencies", results.len())
            }
        ))
        .verdict(verdict(outcome))
        .answers(answer(outcome))
        .section(result(outcome));
    if results.len() > 1 {
        page = page.section(over_frequency(outcome));
    }
    page.section(over_rotation(outcome))
        .section(budget(results))
        .section(Section::new("Method").paragraph(
            "The device is shaken across its axis and turned about it by ω (ISO 16063-31): y(ω) = c + S_x cos ω + S_y sin ω, \
             with complex S_x, S_y by least squares. T is the largest |S_x cos ω + S_y sin ω| over |S|, the sensitivity along \
             the axis. c is what the motion along the axis makes; from three directions on it is fitted. A base that does \
             not sit flat turns with the device, so that its tilt enters T undiminished. ω is counted clockwise, seen from \
             above on the device: the direction of the vibration in the base, from x towards y. Near zero the interval is \
             the set of values that the measured one does not contradict.",
        ))
        .section(Section::filed([runs(outcome)]))
}

/// T and its expanded uncertainty in per cent, as printed.
fn printed(r: &TransverseSensitivity) -> (String, String) {
    rounded(100.0 * r.ratio.value, 100.0 * r.ratio.expanded)
}

/// Direction of the largest response and its expanded uncertainty in degrees, where it is stated.
fn direction(r: &TransverseSensitivity) -> Option<(f64, f64)> {
    let d = r.direction.as_ref()?;
    Some((
        d.value.to_degrees().rem_euclid(180.0),
        d.expanded.to_degrees(),
    ))
}

fn table(results: &[TransverseSensitivity]) -> Table {
    type R = TransverseSensitivity;
    let part =
        |name: &str, of: fn(&R) -> Option<f64>| filed(name, move |r: &R| of(r).map(|v| 100.0 * v));
    fn across(r: &R, k: usize) -> Complex64 {
        let [s, x, y] = r.sensitivities();
        [x, y][k] / s
    }
    fn constant(r: &R) -> Option<Complex64> {
        r.constant_fitted.then_some(r.constant)
    }
    let fields = [
        frequency(|r: &R| r.frequency),
        Field::new("transverse_%", |r: &R| {
            Cell::printed(100.0 * r.ratio.value, printed(r).0)
        })
        .page("T", "%"),
        part("u_transverse_%", |r| Some(r.ratio.standard_uncertainty)),
        Field::new("U_transverse_%", |r: &R| {
            Cell::printed(100.0 * r.ratio.expanded, printed(r).1)
        })
        .page("U", "%"),
        coverage_factor("k", |r: &R| r.ratio.coverage_factor),
        filed("nu_eff", |r: &R| r.ratio.dof),
        Field::new("direction_deg", |r: &R| {
            direction(r)
                .map(|(d, u)| Cell::printed(d, rounded(d, u).0))
                .into()
        })
        .page("direction", "°"),
        Field::new("U_direction_deg", |r: &R| {
            direction(r)
                .map(|(d, u)| Cell::printed(u, rounded(d, u).1))
                .into()
        })
        .page("U", "°"),
        part("x_real_%", |r| Some(across(r, 0).re)),
        part("x_imaginary_%", |r| Some(across(r, 0).im)),
        part("y_real_%", |r| Some(across(r, 1).re)),
        part("y_imaginary_%", |r| Some(across(r, 1).im)),
        part("constant_real_%", |r| constant(r).map(|c| c.re)),
        part("constant_imaginary_%", |r| constant(r).map(|c| c.im)),
        part("scatter_%", |r| r.scatter)
            .page("scatter", "%")
            .rounded(TwoDigits),
        filed("runs", |r: &R| r.runs),
        number("directions", ("directions", ""), Exact, |r: &R| {
            r.directions
        }),
    ];
    let caption = format!(
        "Transverse sensitivity relative to that along the axis, with its expanded uncertainty at {}",
        at(results)
    );
    Table::of(caption, fields, results).file("transverse.csv").note(
        "The direction is that of the largest response, modulo 180°; it is stated where T exceeds U. \
         Scatter is that of one run about the fit, relative to the sensitivity along the axis.",
    )
}

fn runs(outcome: &TransverseOutcome) -> Table {
    type R = TransverseRow;
    let rotation = |r: &R| match r.motion {
        Motion::Axial => None,
        Motion::Transverse { rotation } => Some(rotation.to_degrees()),
    };
    let unit = outcome.output.unit().replace('²', "2");
    let fields = [
        Field::new("run", |r: &R| r.run.as_str().into()),
        frequency(|r: &R| r.frequency),
        filed("inclination_deg", |r: &R| match r.motion {
            Motion::Axial => 0.0,
            Motion::Transverse { .. } => 90.0,
        }),
        filed("rotation_deg", rotation),
        filed(format!("real_{unit}"), |r: &R| r.ratio.re),
        filed(format!("imaginary_{unit}"), |r: &R| r.ratio.im),
        filed(format!("modulus_{unit}"), |r: &R| r.ratio.norm()),
        filed("phase_deg", |r: &R| r.ratio.arg().to_degrees()),
    ];
    Table::of("", fields, &outcome.runs).file("runs.csv")
}

/// The largest transverse sensitivity and its limit.
fn answer(outcome: &TransverseOutcome) -> Vec<KeyFigure> {
    let mut figures = Vec::new();
    let largest = outcome
        .results
        .iter()
        .max_by(|a, b| a.ratio.value.total_cmp(&b.ratio.value));
    if let Some(r) = largest {
        let (value, expanded) = printed(r);
        figures.push(
            KeyFigure::new(
                "largest transverse sensitivity",
                format!("{value} ± {expanded}"),
                "%",
            )
            .note(format!(
                "at {} Hz, k = {:.2}",
                plain(r.frequency),
                r.ratio.coverage_factor
            )),
        );
        if let Some(limit) = outcome.limit {
            figures.push(KeyFigure::new(
                "limit of the datasheet",
                plain(100.0 * limit),
                "%",
            ));
        }
    }
    figures
}

fn result(outcome: &TransverseOutcome) -> Section {
    Section::new("Result")
        .table(table(&outcome.results))
        .summarised()
}

/// The largest transverse sensitivity against the limit of the datasheet, its interval taken into account.
fn verdict(outcome: &TransverseOutcome) -> String {
    let Some(limit) = outcome.limit else {
        return String::new();
    };
    let each = || outcome.results.iter().map(|r| &r.ratio);
    let beyond = each().filter(|q| q.value - q.expanded > limit).count();
    let within = each().filter(|q| q.value + q.expanded <= limit).count();
    let (all, limit) = (outcome.results.len(), plain(100.0 * limit));
    match (beyond, within) {
        (0, n) if n == all => format!(
            "Kept: the transverse sensitivity is within {limit} %, its uncertainty included."
        ),
        (0, n) => format!(
            "Undecided: at {} of {all} frequencies the limit of {limit} % lies in the interval.",
            all - n
        ),
        (n, _) => format!(
            "Missed: the transverse sensitivity exceeds {limit} % at {n} of {all} frequencies."
        ),
    }
}

fn over_frequency(outcome: &TransverseOutcome) -> Section {
    let results = &outcome.results;
    let points: Vec<(f64, f64, f64)> = results
        .iter()
        .map(|r| (r.frequency, 100.0 * r.ratio.value, 100.0 * r.ratio.expanded))
        .collect();
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("transverse sensitivity", "%"),
    )
    .height(220.0)
    .series(Series::intervals("", &points));
    if let Some(limit) = outcome.limit {
        plot = plot.horizontal(100.0 * limit, "datasheet");
    }
    Section::new("Transverse sensitivity against frequency").figure(
        format!(
            "Transverse sensitivity relative to that along the axis, with its intervals at {}",
            at(results)
        ),
        plot,
    )
}

/// At most four frequencies, spread over all of them.
fn over_rotation(outcome: &TransverseOutcome) -> Section {
    let results = &outcome.results;
    let mut section = Section::new("Output against direction");
    let shown = results.len().min(4);
    for k in 0..shown {
        let r = &results[if shown > 1 {
            k * (results.len() - 1) / (shown - 1)
        } else {
            0
        }];
        let [s, x, y] = r.sensitivities();
        let angles: Vec<f64> = (0..=360).step_by(2).map(f64::from).collect();
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            100.0 * ((x * cos + y * sin) / s + r.constant)
        };
        let seen: Vec<(f64, Complex64)> = outcome
            .runs
            .iter()
            .filter(|row| row.frequency == r.frequency)
            .filter_map(|row| match row.motion {
                Motion::Transverse { rotation } => Some((
                    rotation.to_degrees().rem_euclid(360.0),
                    100.0 * row.ratio / s,
                )),
                Motion::Axial => None,
            })
            .collect();
        let x: Vec<f64> = seen.iter().map(|p| p.0).collect();
        let real: Vec<f64> = seen.iter().map(|p| p.1.re).collect();
        let imaginary: Vec<f64> = seen.iter().map(|p| p.1.im).collect();
        let fit: Vec<Complex64> = angles.iter().map(|a| at(*a)).collect();
        let part = |of: fn(&Complex64) -> f64| -> Vec<f64> { fit.iter().map(of).collect() };
        let plot = XyPlot::new(
            Axis::linear("direction ω", "°"),
            Axis::linear("output over that along the axis", "%"),
        )
        .height(220.0)
        .series(Series::line("in phase, fit", &angles, &part(|z| z.re)).look(0))
        .series(Series::markers("in phase", &x, &real).look(0))
        .series(Series::line("in quadrature, fit", &angles, &part(|z| z.im)).look(1))
        .series(Series::markers("in quadrature", &x, &imaginary).look(1));
        section = section.figure(
            format!(
                "{} Hz: runs and the fitted cosine, relative to the output along the axis",
                plain(r.frequency)
            ),
            plot,
        );
    }
    section
}

/// What U is stated at.
fn at(results: &[TransverseSensitivity]) -> String {
    stated_at(
        results
            .iter()
            .flat_map(|r| std::iter::once(&r.ratio).chain(&r.direction)),
    )
}

fn budget(results: &[TransverseSensitivity]) -> Section {
    let causes = results.iter().flat_map(|r| {
        // Of the two parts of both transverse sensitivities together.
        let mut all = 0.0;
        let mut own: Vec<(String, f64)> = vec![];
        for name in ["x.re", "x.im", "y.re", "y.im"] {
            let u = r.estimate.get(name).map_or(0.0, |q| q.standard_uncertainty);
            for line in r.estimate.budget(name).unwrap_or_default() {
                all += line.share * u * u;
                own.push((line.description, line.share * u * u));
            }
        }
        let share = move |variance: f64| match all > 0.0 {
            true => variance / all / results.len() as f64,
            false => 0.0,
        };
        own.into_iter()
            .map(move |(cause, variance)| (cause, share(variance)))
    });
    Section::new("Uncertainty").figure(
        "Causes of the uncertainty of S_x and S_y, mean over the frequencies",
        shares(causes),
    )
}
