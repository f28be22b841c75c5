//! The page of a choice of integration rule and high-pass.

use super::figures;
use crate::page::columns::{filed, number, words};
use crate::velocity::VelocityIntegrator;
use proofmass_core::velocity::IntegratorRule;
use proofmass_motion::IntegratorDesign;
use proofmass_report::{Field, Report, Rounding::Significant, Section, Table, scientific};
use std::f64::consts::PI;

/// Parts of the Nyquist frequency, in per cent, at which the accuracy of the rules is listed.
const SHARES: [f64; 5] = [5.0, 15.0, 30.0, 45.0, 60.0];

pub(in crate::velocity) fn integrator(page: Report, outcome: &VelocityIntegrator) -> Report {
    let page = match outcome.ranked().first() {
        Some(best) => page.verdict(verdict(outcome, best)),
        None => page,
    };
    let result = Section::new("Rules by themselves, and with the high-pass that fits each")
        .table(ranked(outcome))
        .paragraph(
            "Total: speed times the largest error of gain and phase together in the band, what white noise leaves at the end, and what the bias leaves over the record, as a root \
             of the sum of squares. A bias that changes and an inclination that changes are not in it.",
        );
    page.section(result.summarised())
        .section(
            Section::new("Accuracy and noise of every rule")
                .table(rules())
                .figure(
                    "Accuracy functions |H|ω, and the amplification of noise",
                    figures::integrators(outcome.ranked().first().map(|d| d.rule)),
                ),
        )
        .section(Section::filed([all(outcome)]))
}

fn verdict(outcome: &VelocityIntegrator, best: &IntegratorDesign) -> String {
    let task = &outcome.request.task;
    let judged = match outcome.request.allowed {
        None => String::new(),
        Some(allowed) => format!(
            " {} m/s are allowed: it {}.",
            scientific(allowed, 3),
            match best.total <= allowed {
                true => "holds",
                false =>
                    "does not hold; a smaller bias, less noise or a band that begins higher would help",
            }
        ),
    };
    format!(
        "From {} to {} Hz, at a velocity of {} m/s, {} errs least: {} m/s in all. Type --method {}.{judged}",
        scientific(task.band[0], 3),
        scientific(task.band[1], 3),
        scientific(task.speed, 3),
        words_of(best),
        scientific(best.total, 3),
        VelocityIntegrator::method(best)
    )
}

fn words_of(design: &IntegratorDesign) -> String {
    let rule = match design.rule {
        IntegratorRule::Trapezoid => "the trapezoid",
        rule => rule.label(),
    };
    match design.high_pass {
        None => format!("{rule} without a high-pass"),
        Some(h) => format!(
            "{rule} with a high-pass of order {} at {} Hz{}",
            h.order,
            scientific(h.corner, 3),
            match h.zero_phase {
                true => ", forward and backward",
                false => "",
            }
        ),
    }
}

type D = IntegratorDesign;

fn errors<'a>() -> Vec<Field<'a, D>> {
    vec![
        number("gain_error_%", ("gain", "%"), Significant(3), |d: &D| {
            100.0 * d.gain_error
        }),
        number(
            "phase_error_deg",
            ("phase", "°"),
            Significant(3),
            |d: &D| {
                // What rounding leaves of none is none.
                Some(d.phase_error.to_degrees()).filter(|p| p.abs() > 1e-9)
            },
        ),
        number("noise_m/s", ("noise", "m/s"), Significant(3), |d: &D| {
            d.noise
        }),
        number("bias_m/s", ("bias", "m/s"), Significant(3), |d: &D| d.bias),
        number("total_m/s", ("total", "m/s"), Significant(3), |d: &D| {
            d.total
        }),
    ]
}

/// Designs that are shown; the file has all.
const SHOWN: usize = 8;

fn ranked(outcome: &VelocityIntegrator) -> Table {
    let all = outcome.ranked();
    let mut fields = vec![words("method", VelocityIntegrator::method)];
    fields.extend(errors());
    Table::of(
        "The smallest error first",
        fields,
        &all[..all.len().min(SHOWN)],
    )
}

fn all(outcome: &VelocityIntegrator) -> Table {
    let mut fields = vec![
        filed("rule", |d: &D| d.rule.name()),
        filed("runs", |d: &D| match d.off_line() {
            true => "off line",
            false => "on line",
        }),
        filed("order", |d: &D| d.high_pass.map(|h| h.order as f64)),
        filed("corner_Hz", |d: &D| d.high_pass.map(|h| h.corner)),
    ];
    fields.extend(errors());
    fields.push(filed("method", VelocityIntegrator::method));
    Table::of("", fields, outcome.ranked()).file("integrators.csv")
}

/// The table of docs/velocity.md.
fn rules() -> Table {
    type R = IntegratorRule;
    let mut fields = vec![
        filed("rule", |r: &R| r.name()).page("rule", ""),
        number("steps", ("steps", ""), Significant(1), |r: &R| {
            r.weights().0 as f64
        }),
    ];
    const HEADINGS: [(&str, &str); 5] = [
        ("accuracy_5_%", "at 5 %"),
        ("accuracy_15_%", "15 %"),
        ("accuracy_30_%", "30 %"),
        ("accuracy_45_%", "45 %"),
        ("accuracy_60_%", "60 %"),
    ];
    for (share, (file, heading)) in SHARES.into_iter().zip(HEADINGS) {
        fields.push(number(file, (heading, ""), Significant(5), move |r: &R| {
            r.accuracy(0.01 * share * PI)
        }));
    }
    fields.push(number(
        "noise_walk",
        ("noise", ""),
        Significant(4),
        |r: &R| r.noise_walk(),
    ));
    fields.push(number(
        "next_pole_Nyquist",
        ("next pole", "Nyquist"),
        Significant(3),
        |r: &R| {
            let steps = r.weights().0;
            (steps > 1).then(|| 2.0 / steps as f64)
        },
    ));
    Table::of(
        "Accuracy |H|ω at parts of the Nyquist frequency",
        fields,
        IntegratorRule::ALL,
    )
    .file("rules.csv")
    .note("Noise: the random walk of the velocity over that of a sum. Next pole: what lies there is summed as if it were slow.")
}
