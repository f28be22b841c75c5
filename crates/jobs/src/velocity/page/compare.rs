//! The report of a comparison: error table, overlaid curves, channels and integrators.

use super::{figures, pairing};
use crate::page::columns::{filed, number};
use crate::page::measures::lines;
use crate::velocity::VelocityComparison;
use crate::velocity::outcome::Head;
use proofmass_motion::{CompareResult, Family, Method, MethodRow, excerpt};
use proofmass_report::Rounding::Significant;
use proofmass_report::{
    Axis, Cell, Field, KeyFigure, Place, Report, Section, Series, Table, XyPlot, scientific,
};
use std::ops::Range;

/// Whether two rates are the same.
fn same(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-9
}

pub(in crate::velocity) fn compare(page: Report, outcome: &VelocityComparison) -> Report {
    let (head, result) = (&outcome.head, &outcome.result);
    // A terminal has no room for all columns.
    let mut few = Section::new("Errors").at(Place::Both);
    let mut full = Section::new("Errors in all columns");
    for rate in rates(result) {
        let columns = || error_fields(head, result).into_iter();
        few = few.table(errors(result, rate, columns().take(7)));
        full = full.table(errors(result, rate, columns()).note(
            "Numbers after a name are its settings: points and degree; k₁ and k₂ in rad/s; kx in 1/s and kv in 1/s². \
             Delay is that of the largest cross-correlation with the reference, noise floor the scatter from sample to \
             sample.",
        ));
    }
    let all = Table::of("", error_fields(head, result), &result.rows).file("errors.csv");
    let page = head
        .opened(page, result.reference.len())
        .verdict(verdict(result, &head.unit("mm/s")) + &head.part().unwrap_or_default())
        .answers(answer(result, &head.unit("mm/s")));
    let mut page = page.section(few).section(full);
    let compared = (result.skip / head.sample_time).ceil() as usize;
    let compared = compared.min(result.reference.len() - 1);
    let zoom = excerpt(&result.reference[compared..]);
    let zoom = zoom.start + compared..zoom.end + compared;
    for rate in rates(result) {
        let best = chosen(result, rate);
        // Errors of several times the others' would fill the frame.
        let smallest = best.iter().map(|r| r.agreement.rms);
        let smallest = smallest.fold(f64::INFINITY, f64::min);
        let mut best: Vec<_> = best.into_iter().enumerate().collect();
        // The smoother is the closest of all where it is not the reference itself.
        let off_line = best_of(result, rate, &|r| r.family == Family::OffLine);
        best.extend(
            off_line
                .filter(|_| result.reference_is_truth)
                .map(|r| (5, r)),
        );
        let (near, far): (Vec<_>, Vec<_>) = best
            .iter()
            .copied()
            .partition(|(_, r)| r.agreement.rms < 12.0 * smallest);
        let beyond = if far.is_empty() {
            String::new()
        } else {
            let names: Vec<String> = far.iter().map(|(_, r)| short(result, r)).collect();
            format!("; beyond the frame: {}", names.join(", "))
        };
        page = page.section(
            Section::new(format!("Velocities at {} Hz", gain(rate)))
                .figure(
                    "The whole recording: the reference and the best method of each family",
                    head.overlaid(result, &best, rate, 0..result.reference.len(), false),
                )
                .figure(
                    "The liveliest part of what is compared",
                    head.overlaid(result, &best, rate, zoom.clone(), false),
                )
                .figure(
                    format!("Errors in the same part{beyond}"),
                    head.overlaid(result, &near, rate, zoom.clone(), true),
                ),
        );
    }
    let mut section = Section::new("Models");
    if let Some(found) = &result.pairing {
        section = section.table(pairing(found, None));
    }
    if !result.tuned.is_empty() {
        section = section.table(consistency(result, head.angular));
    }
    if let Some(first) = result.tuned.first() {
        section = section.figure(
            format!(
                "Correlation of the innovations at {} Hz: of a model that describes both sensors 95 % lie within the lines",
                gain(first.rate)
            ),
            figures::whiteness(&first.result.tuned),
        );
    }
    page = page.section(section);
    let mut section = Section::new("Channels and integrators");
    if let Some(first) = result.tuned.first() {
        let methods = [
            ("two channels".to_owned(), first.result.two_channel.method),
            ("observer".to_owned(), first.result.observer.method),
        ];
        if let Some(plot) = figures::bode(&methods, 1.0 / first.rate) {
            section = section.figure(
                "Gain of the encoder's and the accelerometer's channel on the true velocity, of the tuned filters; the two of one filter add to one",
                plot,
            );
        }
    }
    section = section.figure(
        "Integration rules: accuracy function (1 is exact), and noise amplification",
        figures::integrators(None),
    );
    page.section(section)
        .section(Section::filed([all, velocities(head, result)]))
}

/// The best method on line at the highest rate.
fn verdict(result: &CompareResult, unit: &str) -> String {
    let highest = rates(result).into_iter().next();
    let on_line = |r: &&MethodRow| {
        highest.is_some_and(|rate| same(r.rate, rate)) && r.family != Family::OffLine
    };
    let best = result
        .rows
        .iter()
        .filter(on_line)
        .min_by(|a, b| a.agreement.rms.total_cmp(&b.agreement.rms));
    let against = match result.reference_is_truth {
        true => "the reference",
        false => "the smoother",
    };
    best.map_or(String::new(), |r| {
        format!(
            "On line the {} comes closest to {against}: {} {unit} RMS{}.",
            short(result, r),
            scientific(1e3 * r.agreement.rms, 3),
            match result.skip > 0.0 {
                true => format!(
                    "; the first {} s, in which filters settle, are not compared (--skip)",
                    scientific(result.skip, 3)
                ),
                false => String::new(),
            }
        )
    })
}

/// The best of each family at the highest rate.
fn answer(result: &CompareResult, unit: &str) -> Vec<KeyFigure> {
    let best = rates(result)
        .into_iter()
        .next()
        .map(|rate| chosen(result, rate));
    let figure = |r: &MethodRow| {
        KeyFigure::new(short(result, r), scientific(1e3 * r.agreement.rms, 3), unit).note(format!(
            "RMS; largest {}",
            scientific(1e3 * r.agreement.max, 3)
        ))
    };
    best.into_iter().flatten().map(figure).collect()
}

/// Every velocity at the highest rate, one column per method.
fn velocities(head: &Head, result: &CompareResult) -> Table {
    let highest = result.rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
    let stride = (1.0 / (highest * head.sample_time)).round().max(1.0) as usize;
    let mut fields = vec![
        filed("time_s", |k: &usize| head.time(k * stride)),
        filed(head.unit("reference_m/s"), |k: &usize| {
            result.reference[k * stride]
        }),
    ];
    let unit = head.unit("m/s");
    let rows = result.rows.iter().filter(|r| r.rate == highest);
    fields.extend(rows.map(|r| Field::series(format!("{} ({unit})", r.label), &r.velocity)));
    let count = result.reference.len().div_ceil(stride);
    Table::of("", fields, 0..count).file("velocities.csv")
}

impl Head {
    fn overlaid(
        &self,
        result: &CompareResult,
        rows: &[(usize, &MethodRow)],
        rate: f64,
        part: Range<usize>,
        error: bool,
    ) -> XyPlot {
        let stride = (1.0 / (rate * self.sample_time)).round().max(1.0) as usize;
        let reference = &result.reference[part.clone()];
        let slow: Vec<usize> = (part.start.div_ceil(stride)..part.end.div_ceil(stride)).collect();
        let t: Vec<f64> = slow.iter().map(|k| self.time(k * stride)).collect();
        let of = |row: &MethodRow| -> Vec<f64> {
            slow.iter()
                .map(|&k| {
                    if error {
                        1e3 * (row.velocity[k] - result.reference[k * stride])
                    } else {
                        row.velocity[k]
                    }
                })
                .collect()
        };
        let axis = if error {
            Axis::linear("error", self.unit("mm/s"))
        } else {
            figures::framed("velocity", &self.unit("m/s"), reference)
        };
        let mut plot = XyPlot::new(Axis::linear("time", "s"), axis);
        if !error {
            let name = if result.reference_is_truth {
                "reference"
            } else {
                "smoother at the full rate"
            };
            plot = plot.series(Series::line(name, &self.times(part), reference).look(4));
        }
        // A method looks alike in every figure of a rate.
        for (i, row) in rows {
            plot = plot.series(Series::line(short(result, row), &t, &of(row)).look(*i));
        }
        plot
    }
}

/// Rates of a result, highest first.
fn rates(result: &CompareResult) -> Vec<f64> {
    let mut rates: Vec<f64> = Vec::new();
    for row in &result.rows {
        if !rates.iter().any(|r| same(*r, row.rate)) {
            rates.push(row.rate);
        }
    }
    rates
}

/// The best of each family, and the best Kalman filter, at a rate.
fn chosen(result: &CompareResult, rate: f64) -> Vec<&MethodRow> {
    let at = |wanted: &dyn Fn(&MethodRow) -> bool| best_of(result, rate, wanted);
    let kalman = |r: &MethodRow| {
        matches!(
            r.method,
            Method::Kalman { .. } | Method::SteadyKalman { .. }
        )
    };
    [
        at(&|r| r.family == Family::Position),
        at(&|r| r.family == Family::Acceleration),
        at(&|r| r.family == Family::Fused && !kalman(r)),
        at(&kalman),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The one with the smallest error at a rate.
fn best_of<'a>(
    result: &'a CompareResult,
    rate: f64,
    wanted: &dyn Fn(&MethodRow) -> bool,
) -> Option<&'a MethodRow> {
    let rows = result.rows.iter();
    rows.filter(|r| same(r.rate, rate) && wanted(r))
        .min_by(|a, b| a.agreement.rms.total_cmp(&b.agreement.rms))
}

/// Name with its gains and without its noise parameters; `tuned` where the gains were found on this recording.
fn short(result: &CompareResult, row: &MethodRow) -> String {
    let tuned = result
        .tuned
        .iter()
        .any(|t| same(t.rate, row.rate) && t.result.methods().contains(&row.method));
    let gains = |name: &str, gains: &[f64]| {
        let list: Vec<String> = gains.iter().map(|g| gain(*g)).collect();
        let found = if tuned { ", tuned" } else { "" };
        format!("{name} {}{found}", list.join(";\u{a0}"))
    };
    match row.method {
        Method::SavitzkyGolay { window, degree } => {
            format!("Savitzky–Golay {window};\u{a0}{degree}")
        }
        Method::TwoChannel { k1, k2 } => gains("two channels", &[k1, k2]),
        Method::Observer { k_x, k_v } => gains("observer", &[k_x, k_v]),
        Method::Kalman { .. } if tuned => "Kalman, tuned".to_owned(),
        Method::Kalman { .. } => "Kalman".to_owned(),
        Method::SteadyKalman { .. } => "Kalman, steady gain".to_owned(),
        Method::Smoother { .. } if tuned => "smoother, tuned".to_owned(),
        Method::Smoother { .. } => "smoother".to_owned(),
        _ => row.label.clone(),
    }
}

/// Three digits, without zeros that say nothing.
fn gain(value: f64) -> String {
    let text = scientific(value, 3);
    match text.contains('.') && !text.contains('×') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The columns of errors, those that a terminal has no room for last.
fn error_fields<'a>(head: &Head, result: &'a CompareResult) -> [Field<'a, MethodRow>; 10] {
    let (speed, drift) = (head.unit("mm/s"), head.unit("mm/s²"));
    let milli = |name: &str, heading: &str, unit: &str, get: fn(&MethodRow) -> Option<f64>| {
        number(head.unit(name), (heading, unit), Significant(3), get).scaled(1e3)
    };
    [
        filed("rate_Hz", |r: &MethodRow| r.rate),
        Field::new("method", |r: &MethodRow| {
            Cell::from(r.label.as_str()).worded(short(result, r))
        })
        .page("method", ""),
        Field::new("sensors", |r: &MethodRow| {
            Cell::from(r.family.name()).worded(match r.family {
                Family::Position => "encoder",
                Family::Acceleration => "accel.",
                Family::Fused => "both",
                Family::OffLine => "both, off line",
            })
        })
        .page("sensors", ""),
        milli("rms_m/s", "RMS", &speed, |r| Some(r.agreement.rms)),
        milli("max_m/s", "largest", &speed, |r| Some(r.agreement.max)),
        milli("mean_m/s", "mean", &speed, |r| Some(r.agreement.bias)),
        milli("delay_s", "delay", "ms", |r| r.agreement.delay),
        milli("stated_delay_s", "stated delay", "ms", |r| {
            Some(r.stated_delay)
        }),
        milli("noise_floor_m/s", "noise floor", &speed, |r| {
            Some(r.agreement.noise_floor)
        }),
        milli("drift_m/s2", "drift", &drift, |r| Some(r.agreement.drift)),
    ]
}

/// One row per method.
fn errors<'a>(
    result: &CompareResult,
    rate: f64,
    fields: impl Iterator<Item = Field<'a, MethodRow>>,
) -> Table {
    let what = match result.reference_is_truth {
        true => "Errors against the reference",
        false => "Differences to the smoother at the full rate",
    };
    let rows = result.rows.iter().filter(|r| same(r.rate, rate));
    Table::of(format!("{what} at {} Hz", gain(rate)), fields, rows)
}

/// What each rate's own samples say about its model, without any reference.
fn consistency(result: &CompareResult, angular: bool) -> Table {
    let unit = |of_length: &str| super::unit_of(of_length, angular);
    let rows = result.tuned.iter().map(|t| {
        let (model, w) = (&t.result.tuned.model, &t.result.tuned.whiteness);
        let pair = |a: f64, b: f64| format!("{}, {}", scientific(a, 3), scientific(b, 3));
        [
            Cell::number(gain(t.rate)),
            Cell::number(scientific(model.acceleration_noise.sqrt(), 3)),
            Cell::number(scientific(model.reading_noise.sqrt(), 3)),
            Cell::number(scientific(w.mean_square, 4)),
            Cell::number(scientific(w.p_white, 2)),
            Cell::from(match t.result.two_channel.method {
                Method::TwoChannel { k1, k2 } => pair(k1, k2),
                _ => String::new(),
            }),
            Cell::from(match t.result.observer.method {
                Method::Observer { k_x, k_v } => pair(k_x, k_v),
                _ => String::new(),
            }),
        ]
    });
    lines(
        "Consistency of the tuned models with the readings: mean ν²/S is 1 of a matched model, p small where the innovations are correlated",
        [
            ("rate", "Hz"),
            ("√q", &unit("m/s²")),
            ("√R", &unit("m or m/s")),
            ("mean ν²/S", "1"),
            ("p of whiteness", "1"),
            ("two channels k₁, k₂", ""),
            ("observer kx, kv", ""),
        ],
        rows,
    )
}
