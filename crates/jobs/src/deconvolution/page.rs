//! The page of an input that was found behind an output.

use super::DeconvolutionOutcome;
use crate::shock::integral_unit;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::deconvolution::PulseReading;
use proofmass_report::number::{concise, plain};
use proofmass_report::{
    Axis, Field, KeyFigure, Report, Rounding, Section, Series, Table, XyPlot, scientific,
};
use proofmass_signal::Trace;
use proofmass_uncertainty::Quantity;

/// Number of a sample, its value and standard uncertainty.
type Sample<'a> = (usize, (&'a f64, &'a f64));

/// A cause, its u of a sample, and of duration and velocity change.
type Cause<'a> = (&'a str, f64, [Option<f64>; 2]);

pub(super) fn add(page: Report, outcome: &DeconvolutionOutcome) -> Report {
    let (unit, result, peak) = (&outcome.unit, &outcome.result, outcome.peak());
    let larger = |m: f64, v: &f64| if v.abs() > m.abs() { *v } else { m };
    let plain_peak = outcome.plain.iter().fold(0.0, larger);
    let read = |label: &str, q: &Option<Quantity>, note: &str, why: &str| match q {
        Some(q) => {
            KeyFigure::new(label, concise(q.value, q.standard_uncertainty), &q.unit).note(note)
        }
        None => KeyFigure::new(label, "not determined", "").note(why),
    };
    let unclear = "a tenth of the peak is not clear of the noise and of what the low-pass removes";
    let short = "the record does not hold the whole event";
    let figures = [
        KeyFigure::new("peak", concise(peak.value, peak.standard_uncertainty), unit),
        read(
            "duration",
            &outcome.duration(),
            "at a tenth of the peak",
            unclear,
        ),
        read("velocity change", &outcome.velocity_change(), "", short),
        KeyFigure::new("plain reading", scientific(plain_peak, 4), unit)
            .note("output over static sensitivity"),
        KeyFigure::new("corner of the low-pass", plain(result.corner), "Hz"),
    ];
    let of = |part: fn(&PulseReading) -> f64| {
        [result.duration, result.velocity_change].map(|r| r.as_ref().map(part))
    };
    let causes = [
        ("noise of the output", result.noise, of(|r| r.noise)),
        ("model, at its greatest", result.model, of(|r| r.model)),
        (
            "what the low-pass removes",
            result.regularisation,
            of(|r| r.regularisation),
        ),
    ];
    let fields = [
        Field::shown("cause", "", |c: &Cause<'_>| c.0.into()),
        Field::shown("u of a sample", unit, |c: &Cause<'_>| c.1.into())
            .rounded(Rounding::TwoDigits),
        Field::shown("u of the duration", "s", |c: &Cause<'_>| c.2[0].into())
            .rounded(Rounding::TwoDigits),
        Field::shown(
            "u of the velocity change",
            integral_unit(unit),
            |c: &Cause<'_>| c.2[1].into(),
        )
        .rounded(Rounding::TwoDigits),
    ];
    let pairs = || result.value.iter().zip(&result.standard_uncertainty);
    let time = |k: usize| k as f64 / outcome.rate;
    let x: Vec<f64> = (0..outcome.plain.len()).map(time).collect();
    let line = |name: &str, y: &[f64]| {
        let trace = Trace::new(&x, y, Trace::RUNS);
        Series::line(name, &trace.x, &trace.y)
    };
    let edge = |sign: f64| -> Vec<f64> { pairs().map(|(v, u)| v + sign * 1.96 * u).collect() };
    let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("input", unit))
        .series(line("output over static sensitivity", &outcome.plain))
        .series(line("input", &result.value))
        .series(line("95 % interval, lower end", &edge(-1.0)))
        .series(line("95 % interval, upper end", &edge(1.0)));
    let samples = [
        Field::new("time_s", |(k, _): &Sample<'_>| time(*k).into()),
        Field::new(format!("value_{unit}"), |(_, (v, _)): &Sample<'_>| {
            (**v).into()
        }),
        Field::new(format!("u_{unit}"), |(_, (_, u)): &Sample<'_>| (**u).into()),
        Field::new(format!("U95_{unit}"), |(_, (_, u)): &Sample<'_>| {
            (1.96 * **u).into()
        }),
    ];
    page.verdict(format!(
        "The input reaches {}; the plain reading, output over static sensitivity, says {} {unit}.",
        crate::page::answer::with_unit(&StatedQuantity::new(&peak, 0.95)),
        scientific(plain_peak, 4)
    ))
    .section(
        Section::new("Result")
            .key_figures(figures)
            .table(Table::of("Standard uncertainty by cause", fields, causes))
            .summarised(),
    )
    .section(
        Section::new("Time history").figure("The input, and the plain reading beside it", plot),
    )
    .section(Section::filed([Table::of(
        "",
        samples,
        pairs().enumerate(),
    )
    .file("input.csv")]))
}
