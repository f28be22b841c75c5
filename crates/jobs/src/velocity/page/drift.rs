//! The report of what a velocity from an accelerometer alone drifts.

use crate::page::columns::{filed, number};
use crate::velocity::VelocityDrift;
use proofmass_motion::DriftBudget;
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Report, Rounding::Significant, Section, Table, scientific};

/// Causes with what each brings after a time: name in the file, heading, and the part of a budget.
type Cause = (&'static str, &'static str, fn(&DriftBudget) -> f64);

const CAUSES: [Cause; 8] = [
    ("offset_m/s", "offset, known", |b| b.offset),
    ("orientation_m/s", "inclination, known", |b| b.orientation),
    ("gain_m/s", "gain, known", |b| b.gain),
    ("u_offset_m/s", "u of the offset", |b| b.offset_uncertainty),
    ("u_orientation_m/s", "u of the inclination", |b| {
        b.orientation_uncertainty
    }),
    ("u_gain_m/s", "u of the gain", |b| b.gain_uncertainty),
    ("u_noise_m/s", "white noise", |b| b.noise),
    ("u_walk_m/s", "walk of the offset", |b| b.walk),
];

pub(in crate::velocity) fn drift(page: Report, outcome: &VelocityDrift) -> Report {
    let budgets = outcome.budgets();
    let after = |b: &DriftBudget| b.time;
    let mut fields = vec![number("time_s", ("after", "s"), Significant(3), after)];
    for (name, heading, part) in CAUSES {
        // A page has no room for what is nowhere.
        fields.push(match budgets.iter().any(|b| part(b) != 0.0) {
            true => number(name, (heading, "m/s"), Significant(3), part),
            false => filed(name, part),
        });
    }
    let expanded = |b: &DriftBudget| 1.96 * b.combined;
    fields.extend([
        number(
            "drift_m/s",
            ("drift", "m/s"),
            Significant(3),
            DriftBudget::known,
        ),
        number("", ("U, 95 %", "m/s"), Significant(3), expanded),
        filed("standard_uncertainty_m/s", |b: &DriftBudget| b.combined),
    ]);
    let caption = "Velocity from the accelerometer alone, in excess of the true one";
    let table = Table::of(caption, fields, budgets).file("drift.csv");
    let last = budgets.iter().fold(0.0f64, |m, b| m.max(b.time));
    let time: Vec<f64> = (1..=200).map(|k| last * f64::from(k) / 200.0).collect();
    let curve = time.iter().map(|t| outcome.request.sources.after(*t));
    let curve: Vec<DriftBudget> = curve.collect();
    let known: Vec<f64> = curve.iter().map(DriftBudget::known).collect();
    let half: Vec<f64> = curve.iter().map(|b| 1.96 * b.combined).collect();
    let plot = XyPlot::new(
        Axis::linear("time since the integration began", "s"),
        Axis::linear("drift", "m/s"),
    )
    .series(Series::line("", &time, &known).within(&half))
    .horizontal(0.0, "");
    let page = match budgets.last() {
        Some(b) => page.verdict(format!(
            "After {} s the velocity from the accelerometer alone is off by {} m/s with U = {} m/s (k = 1.96, 95 %).",
            scientific(b.time, 3),
            scientific(b.known(), 3),
            scientific(expanded(b), 2)
        )),
        None => page,
    };
    page.section(Section::new("Drift").table(table).summarised())
        .section(Section::new("Drift over time").figure(
            "The known drift, with the interval that holds it in 95 of 100 cases",
            plot,
        ))
}
