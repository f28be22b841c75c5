//! The page of a bias over time.

use super::outcome::{BiasOutcome, BiasRest};
use crate::page::{AXES, MG};
use crate::plural::count;
use proofmass_core::velocity::BiasModel;
use proofmass_report::number::{plain, two_digits};
use proofmass_report::{
    Axis, Cell, Field, KeyFigure, Report, Rounding, Section, Series, Table, XyPlot, concise,
    scientific,
};
use proofmass_static::{AxisTrack, BiasEstimate, BiasTrack};
use proofmass_uncertainty::Quantity;

pub(super) fn add(page: Report, outcome: &BiasOutcome) -> Report {
    let track = outcome.track();
    let [from, to] = [track.time.first(), track.time.last()].map(|t| t.copied().unwrap_or(0.0));
    let updates: Vec<usize> = (0..track.rest.len())
        .filter(|i| track.rest[*i].is_some())
        .collect();
    let mut section = Section::new("Bias over time");
    for (axis, name) in track.axes.iter().zip(AXES) {
        section = section.figure(
            format!("{name}: smoothed over the whole recording with two standard uncertainties, and as the filter had it on line"),
            curve(track, axis),
        );
    }
    let at: Vec<f64> = updates.iter().map(|i| track.time[*i]).collect();
    let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("innovation", "σ"))
        .horizontal(2.0, "")
        .horizontal(-2.0, "");
    let plot = track
        .axes
        .iter()
        .zip(AXES)
        .fold(plot, |plot, (axis, name)| {
            let n = at.len().min(axis.normalised.len());
            plot.series(Series::markers(name, &at[..n], &axis.normalised[..n]))
        });
    page.subtitle(format!(
        "{}, {} means, {:.1} s",
        count(outcome.rests().len(), "rest"),
        updates.len(),
        to - from
    ))
    .verdict(verdict(track))
    .section(result(outcome).summarised())
    .section(section)
    .section(Section::new("Innovations").figure(
        "What each mean lies beside its prediction, in standard deviations",
        plot,
    ))
    .section(Section::new("On the chip").table(firmware(outcome)))
    .section(Section::new("Rests").table(rests(outcome)))
    .section(Section::filed([
        over_time(track),
        innovations(track, &updates),
    ]))
}

/// How far the bias went over the recording.
fn verdict(track: &BiasTrack) -> String {
    let range = |axis: &AxisTrack| {
        let values = axis.smoothed.iter().map(|e| e.bias);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
        MG * (high - low)
    };
    let ranges = track.axes.iter().map(range).zip(AXES);
    match ranges.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((most, axis)) if most.is_finite() => format!(
            "The bias moved by {} mg at most over the recording, on {axis}.",
            two_digits(most)
        ),
        _ => String::new(),
    }
}

fn result(outcome: &BiasOutcome) -> Section {
    type Row<'a> = (&'a Quantity, &'a AxisTrack);
    let (track, p) = (outcome.track(), outcome.request.probability);
    let rows: Vec<Row<'_>> = track.quantities.iter().zip(&track.axes).collect();
    let figures = rows.iter().map(|(q, axis)| {
        let label = format!("{} at the end", q.name.replace('.', " of "));
        let value = concise(q.value * MG, q.standard_uncertainty * MG);
        let figure = KeyFigure::new(label, value, "mg");
        match (axis.smoothed.last(), axis.smoothed.first()) {
            (Some(last), Some(first)) => figure.note(format!(
                "{:+.3} mg since the beginning",
                (last.bias - first.bias) * MG
            )),
            _ => figure,
        }
    });
    let fields = [
        Field::shown("quantity", "", |r: &Row<'_>| r.0.name.as_str().into()),
        Field::estimate("", "", |r: &Row<'_>| {
            Some((r.0.value, r.0.standard_uncertainty))
        })
        .page("value", "m/s²"),
        Field::shown(format!("U ({:.0} %)", 1e2 * p), "m/s²", |r: &Row<'_>| {
            r.0.expanded(p).into()
        })
        .rounded(Rounding::Significant(2)),
        Field::shown("from the known acceleration", "m/s²", |r: &Row<'_>| {
            r.1.known_part.into()
        })
        .rounded(Rounding::Significant(2)),
    ];
    let what = match outcome.request.gravity {
        Some(g) => format!(
            "At rest the sensor reads gravity, {:.5} m/s², in the stated attitude. An error of the scale in that direction is part of the bias.",
            g.value()
        ),
        None => "At rest the sensor reads zero: its readings are free of gravity.".to_owned(),
    };
    Section::new("Result")
        .paragraph(what)
        .key_figures(figures)
        .table(Table::of("Bias at the end of the recording", fields, &rows))
        .table(consistency(track))
}

fn firmware(outcome: &BiasOutcome) -> Table {
    type Row<'a> = (&'static str, &'a [f64; 3]);
    let (rate, coefficients) = outcome.coefficients();
    let fields = [
        Field::shown("axis", "", |r: &Row<'_>| r.0.into()),
        Field::shown("φ", "", |r: &Row<'_>| r.1[0].into()).decimals(9),
        Field::shown("Q", "(m/s²)²", |r: &Row<'_>| r.1[1].into()).rounded(Rounding::Power(4)),
        Field::shown("R", "(m/s²)²", |r: &Row<'_>| r.1[2].into()).rounded(Rounding::Power(4)),
    ];
    let caption = format!("Coefficients of the filter at {} Hz", plain(rate));
    let rows: Vec<Row<'_>> = AXES.into_iter().zip(coefficients).collect();
    Table::of(caption, fields, &rows)
        .note("b ← φ b, P ← φ² P + Q at every sample; K = P/(P + R), b ← b + K (ã − a − b) while a is known.")
}

fn rests(outcome: &BiasOutcome) -> Table {
    /// Number of a rest, its name and span, its middle among the times.
    type Row<'a> = (usize, &'a BiasRest, usize);
    let track = outcome.track();
    let rests = outcome.rests().iter().enumerate();
    let rows = rests.filter_map(|(number, rest)| {
        let of = |i: &usize| track.rest[*i] == Some(number);
        let members: Vec<usize> = (0..track.rest.len()).filter(of).collect();
        Some((number, rest, *members.get(members.len() / 2)?))
    });
    let name = |(number, rest, _): &Row<'_>| match &rest.label {
        Some(label) => label.clone(),
        None => (number + 1).to_string(),
    };
    let mut fields = vec![
        Field::shown("rest", "", |r: &Row<'_>| name(r).into()),
        Field::shown("from", "s", |r: &Row<'_>| r.1.start.into()).decimals(2),
        Field::shown("to", "s", |r: &Row<'_>| r.1.end.into()).decimals(2),
    ];
    fields.extend(track.axes.iter().zip(AXES).map(|(axis, name)| {
        let middle = |r: &Row<'_>| axis.smoothed.get(r.2).map(|e| (e.bias, e.u));
        Field::estimate("", "", middle).page(format!("bias of {name}"), "m/s²")
    }));
    Table::of("Rests", fields, rows.collect::<Vec<Row<'_>>>())
        .note("Smoothed, in the middle of each rest.")
}

/// Number of the rest a time belongs to, as files count.
fn rest(track: &BiasTrack, i: usize) -> Cell {
    track.rest[i].map(|r| r as f64 + 1.0).into()
}

fn over_time(track: &BiasTrack) -> Table {
    let mut fields = vec![
        Field::series("time_s", &track.time),
        Field::new("rest", |i: &usize| rest(track, *i)),
    ];
    type Part = fn(&AxisTrack) -> &Vec<BiasEstimate>;
    let parts: [(&str, Part); 2] = [("filtered", |a| &a.filtered), ("smoothed", |a| &a.smoothed)];
    for (kind, of) in parts {
        fields.extend(track.axes.iter().zip(AXES).map(|(axis, name)| {
            Field::estimate(
                format!("{kind}_{name}_m/s2"),
                format!("u_{kind}_{name}_m/s2"),
                move |i: &usize| of(axis).get(*i).map(|e| (e.bias, e.u)),
            )
        }));
    }
    Table::of("", fields, 0..track.time.len()).file("bias.csv")
}

fn innovations(track: &BiasTrack, updates: &[usize]) -> Table {
    let mut fields = vec![
        Field::new("time_s", |k: &usize| track.time[updates[*k]].into()),
        Field::new("rest", |k: &usize| rest(track, updates[*k])),
    ];
    let axes = || track.axes.iter().zip(AXES);
    fields.extend(
        axes().map(|(a, name)| Field::series(format!("innovation_{name}_m/s2"), &a.innovations)),
    );
    fields
        .extend(axes().map(|(a, name)| Field::series(format!("normalised_{name}"), &a.normalised)));
    Table::of("", fields, 0..updates.len()).file("innovations.csv")
}

fn consistency(track: &BiasTrack) -> Table {
    type Row<'a> = (&'static str, &'a AxisTrack);
    let model = |axis: &AxisTrack| match axis.noise.model {
        BiasModel::RandomWalk { density, .. } => {
            format!("walk, {} (m/s²)·√Hz", scientific(density.sqrt(), 3))
        }
        BiasModel::GaussMarkov { deviation, time } => {
            format!(
                "Gauss–Markov, {} m/s², {time:.4} s",
                scientific(deviation, 3)
            )
        }
    };
    let limits = |[low, high]: [f64; 2]| format!("{low:.3} to {high:.3}");
    let whiteness = |r: &Row<'_>, part: usize| r.1.consistency.whiteness.map(|w| w[part]).into();
    let fields = [
        Field::shown("axis", "", |r: &Row<'_>| r.0.into()),
        Field::shown("white noise", "(m/s²)/√Hz", |r: &Row<'_>| {
            r.1.noise.white.into()
        })
        .rounded(Rounding::Significant(3)),
        Field::shown("bias", "", |r: &Row<'_>| model(r.1).into()),
        Field::shown("innovations over σ", "", |r: &Row<'_>| {
            r.1.consistency.ratio.into()
        })
        .decimals(3),
        Field::shown("by chance", "", |r: &Row<'_>| {
            limits(r.1.consistency.limits).into()
        }),
        Field::shown("Ljung–Box", "", |r: &Row<'_>| whiteness(r, 0)).decimals(1),
        Field::shown("limit", "", |r: &Row<'_>| whiteness(r, 1)).decimals(1),
        Field::shown("rests out of line", "", |r: &Row<'_>| {
            r.1.consistency.deviating.len().into()
        }),
    ];
    let rows: Vec<Row<'_>> = AXES.into_iter().zip(&track.axes).collect();
    Table::of(
        "Are the innovations as expected from the noise?",
        fields,
        &rows,
    )
}

fn curve(track: &BiasTrack, axis: &AxisTrack) -> XyPlot {
    let part = |estimates: &[BiasEstimate], k: f64| -> Vec<f64> {
        estimates.iter().map(|e| (e.bias + k * e.u) * MG).collect()
    };
    // Before its first update the filter knows nothing: that is no part of the picture.
    let first = track.rest.iter().position(Option::is_some).unwrap_or(0);
    XyPlot::new(Axis::linear("time", "s"), Axis::linear("bias", "mg"))
        .series(
            Series::line("smoothed", &track.time, &part(&axis.smoothed, 0.0))
                .band(&part(&axis.smoothed, -2.0), &part(&axis.smoothed, 2.0)),
        )
        .series(Series::line(
            "on line",
            &track.time[first..],
            &part(&axis.filtered[first..], 0.0),
        ))
}
