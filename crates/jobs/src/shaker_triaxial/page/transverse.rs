//! What follows from S: transverse sensitivity, misalignment, intrinsic properties.

use super::digits::{Unit, plus_minus, scaled};
use crate::page::AXES;
use crate::page::columns::{frequency, printed};
use proofmass_report::{Axis, Section, Series, Table, XyPlot};
use proofmass_shaker::derived::Expanded;
use proofmass_shaker::{FrequencyResult, MethodResult};

fn find<'a>(list: &'a [Expanded], name: &str) -> Option<&'a Expanded> {
    list.iter().find(|q| q.name == name)
}

/// Transverse sensitivity and its direction.
pub(super) fn section(result: &MethodResult) -> Section {
    let mut fields = vec![frequency(|f: &FrequencyResult| f.frequency)];
    for axis in AXES {
        let size =
            move |f: &FrequencyResult| find(&f.transverse, &format!("transverse.{axis}")).cloned();
        fields.push(printed(format!("T_{axis}"), "%", move |f| {
            Some(scaled(&size(f)?, 100.0))
        }));
        fields.push(printed(
            format!("θ_{axis}"),
            "°",
            move |f: &FrequencyResult| {
                let q = find(&f.transverse, &format!("transverse.{axis}.angle"))?;
                let degrees = q.value.to_degrees().rem_euclid(180.0);
                let known = size(f).is_some_and(|s| s.value > s.expanded);
                known.then(|| plus_minus(degrees, q.expanded.to_degrees()))
            },
        ));
    }
    let table = Table::of(
        "Transverse sensitivity and its direction, value ± U",
        fields,
        &result.frequencies,
    )
    .note(
        "θ_x is counted from y towards z, θ_y from z towards x, θ_z from x towards y, modulo 180°. The direction of a \
         transverse sensitivity below its uncertainty is left out.",
    );
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("transverse sensitivity", "%"),
    );
    for (number, axis) in AXES.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .filter_map(|f| {
                let q = find(&f.transverse, &format!("transverse.{axis}"))?;
                let apart = 1.02f64.powf(number as f64 - 1.0);
                Some((f.frequency * apart, 100.0 * q.value, 100.0 * q.expanded))
            })
            .collect();
        plot = plot.series(Series::intervals(format!("output {axis}"), &points).look(number));
    }
    Section::new("Transverse sensitivity")
        .paragraph(
            "The largest response of an output to motion across its axis, over its main sensitivity, and the direction \
             of that motion (ISO 16063-31).",
        )
        .figure(
            format!(
                "Transverse sensitivity of the three outputs with its interval at {}",
                super::curves::at(&result.frequencies)
            ),
            plot,
        )
        .table(table)
}

/// Leaning of the axes and what no rotation of the device changes.
pub(super) fn axes(result: &MethodResult, unit: Unit) -> Section {
    type R = FrequencyResult;
    let mut lean = vec![frequency(|f: &R| f.frequency)];
    for (axis, towards) in [
        ("x", "y"),
        ("x", "z"),
        ("y", "z"),
        ("y", "x"),
        ("z", "x"),
        ("z", "y"),
    ] {
        lean.push(printed(
            format!("{axis} to {towards}"),
            "°",
            move |f: &R| {
                let tilt = find(&f.misalignment, &format!("tilt.{axis}.{towards}"))?;
                Some(scaled(tilt, 180.0 / std::f64::consts::PI))
            },
        ));
    }
    let lean = Table::of(
        "Misalignment: angle by which the sensitive axis of an output leans towards another axis, value ± U",
        lean,
        &result.frequencies,
    );
    let mut intrinsic = vec![frequency(|f: &R| f.frequency)];
    for axis in AXES {
        intrinsic.push(printed(
            format!("‖s_{axis}‖"),
            unit.name,
            move |f: &R| {
                Some(scaled(
                    find(&f.intrinsic, &format!("length.{axis}"))?,
                    unit.factor,
                ))
            },
        ));
    }
    for pair in ["xy", "yz", "zx"] {
        intrinsic.push(printed(
            format!("γ_{pair} − 90°"),
            "°",
            move |f: &R| {
                let q = find(&f.intrinsic, &format!("angle.{pair}"))?;
                Some(plus_minus(
                    q.value.to_degrees() - 90.0,
                    q.expanded.to_degrees(),
                ))
            },
        ));
    }
    let intrinsic = Table::of(
        "Intrinsic properties: length of the sensitivity vector of each output and angles between them, value ± U",
        intrinsic,
        &result.frequencies,
    );
    Section::new("Axes and intrinsic properties")
        .paragraph(
            "Lengths of the sensitivity vectors and the angles between them do not depend on how the device was turned \
             against the bench, so the common rotation of all gluings, which limits the cross terms, does not touch them.",
        )
        .table(intrinsic)
        .table(lean)
}
