//! The report of what a velocity from an accelerometer alone drifts.

use crate::outcome::Outcome;
use crate::page::answer::stated;
use crate::page::columns::{filed, number, words};
use crate::velocity::drift::DriftAfter;
use crate::velocity::{TakenFrom, VelocityDrift};
use proofmass_motion::{AidedDrift, DriftBudget};
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Report, Rounding::Significant, Section, Table, scientific};

/// Causes with what each brings after a time: name in the file, heading, and the part of a budget.
type Cause = (&'static str, &'static str, fn(&DriftBudget) -> f64);

const CAUSES: [Cause; 10] = [
    ("offset_m/s", "offset, known", |b| b.offset),
    ("orientation_m/s", "inclination, known", |b| b.orientation),
    ("gain_m/s", "gain, known", |b| b.gain),
    ("u_offset_m/s", "u of the offset", |b| b.offset_uncertainty),
    ("u_orientation_m/s", "u of the inclination", |b| {
        b.orientation_uncertainty
    }),
    ("u_gain_m/s", "u of the gain", |b| b.gain_uncertainty),
    ("u_noise_m/s", "white noise", |b| b.noise),
    ("u_flicker_m/s", "flicker noise", |b| b.flicker),
    ("u_walk_m/s", "walk of the offset", |b| b.walk),
    ("u_markov_m/s", "Gauss–Markov", |b| b.markov),
];

/// Coverage factor of a normal distribution.
const K95: f64 = 1.96;

pub(in crate::velocity) fn drift(page: Report, outcome: &VelocityDrift) -> Report {
    let budgets = outcome.budgets();
    let page = match budgets.last() {
        Some(last) => {
            // The numbers beside the verdict are those of its time.
            let all = outcome.quantities();
            let of_last = all.len() / budgets.len();
            page.verdict(verdict(outcome, last))
                .answers(all[all.len() - of_last..].iter().map(stated))
        }
        None => page,
    };
    let mut result = Section::new("Drift")
        .table(causes(budgets))
        .table(places(budgets));
    if outcome.request.sources.rest > 0.0 {
        result = result.table(aided(budgets));
    }
    if outcome.request.encoder.is_some() {
        result = result.table(beside_encoder(budgets));
    }
    let mut page =
        page.section(result.summarised())
            .section(Section::new("Drift over time").figure(
            "Known drift of the velocity, and below of the place, with the interval that holds the error in 95 of 100 cases",
            plot(outcome),
        ));
    if !outcome.request.taken.is_empty() {
        page = page.section(
            Section::new("Taken from results")
                .paragraph(
                    "Coefficients of the noise are the most likely values with their 95 % intervals; the upper ends are in the \
                     columns so named. A calibration leaves δb/k + (δk/k) a of every compensated acceleration, with the covariance \
                     of both. Quantisation Q, a ramp R and what follows the temperature are not in the drift.",
                )
                .table(taken(&outcome.request.taken)),
        );
    }
    page
}

fn verdict(outcome: &VelocityDrift, last: &DriftAfter) -> String {
    let said = |[v, p]: &[DriftBudget; 2]| {
        format!(
            "{} m/s with U = {} m/s, the place by {} m with U = {} m",
            scientific(v.known(), 3),
            scientific(K95 * v.combined, 2),
            scientific(p.known(), 3),
            scientific(K95 * p.combined, 2)
        )
    };
    let time = scientific(last.alone[0].time, 3);
    let aided = last.aided.as_ref().map_or(String::new(), |aided| {
        format!(
            " With the mean of a rest of {} s before the start taken off: {}.",
            scientific(outcome.request.sources.rest, 3),
            said(aided)
        )
    });
    let encoder = last.beside_encoder.as_ref().map_or(String::new(), |e| {
        format!(
            " With the encoder: U = {} m/s, the place with U = {} m.",
            scientific(K95 * e.combined[0], 2),
            scientific(K95 * e.combined[1], 2)
        )
    });
    format!(
        "After {time} s the velocity from the accelerometer alone is off by {} (k = 1.96, 95 %).{aided}{encoder}",
        said(&last.alone)
    )
}

fn causes(budgets: &[DriftAfter]) -> Table {
    let after = |b: &DriftAfter| b.alone[0].time;
    let mut fields = vec![number("time_s", ("after", "s"), Significant(3), after)];
    for (name, heading, part) in CAUSES {
        let of = move |b: &DriftAfter| part(&b.alone[0]);
        // A page has no room for what is nowhere.
        fields.push(match budgets.iter().any(|b| of(b) != 0.0) {
            true => number(name, (heading, "m/s"), Significant(3), of),
            false => filed(name, of),
        });
    }
    fields.extend([
        number(
            "drift_m/s",
            ("drift", "m/s"),
            Significant(3),
            |b: &DriftAfter| b.alone[0].known(),
        ),
        number("", ("U, 95 %", "m/s"), Significant(3), |b: &DriftAfter| {
            K95 * b.alone[0].combined
        }),
        filed("standard_uncertainty_m/s", |b: &DriftAfter| {
            b.alone[0].combined
        }),
        filed("standard_uncertainty_upper_m/s", |b: &DriftAfter| {
            b.upper.map(|u| u[0].combined)
        }),
        filed("place_m", |b: &DriftAfter| b.alone[1].known()),
        filed("u_place_m", |b: &DriftAfter| b.alone[1].combined),
        filed("u_place_upper_m", |b: &DriftAfter| {
            b.upper.map(|u| u[1].combined)
        }),
        filed("drift_aided_m/s", |b: &DriftAfter| {
            b.aided.map(|a| a[0].known())
        }),
        filed("u_drift_aided_m/s", |b: &DriftAfter| {
            b.aided.map(|a| a[0].combined)
        }),
        filed("u_drift_aided_upper_m/s", |b: &DriftAfter| {
            b.aided_upper.map(|a| a[0].combined)
        }),
        filed("place_aided_m", |b: &DriftAfter| {
            b.aided.map(|a| a[1].known())
        }),
        filed("u_place_aided_m", |b: &DriftAfter| {
            b.aided.map(|a| a[1].combined)
        }),
        filed("u_drift_beside_encoder_m/s", |b: &DriftAfter| {
            b.beside_encoder.map(|e| e.combined[0])
        }),
        filed("u_place_beside_encoder_m", |b: &DriftAfter| {
            b.beside_encoder.map(|e| e.combined[1])
        }),
    ]);
    let caption = "Velocity from the accelerometer alone, in excess of the true one";
    Table::of(caption, fields, budgets).file("drift.csv")
}

fn places(budgets: &[DriftAfter]) -> Table {
    let fields = vec![
        number("", ("after", "s"), Significant(3), |b: &DriftAfter| {
            b.alone[1].time
        }),
        number("", ("place", "m"), Significant(3), |b: &DriftAfter| {
            b.alone[1].known()
        }),
        number("", ("U, 95 %", "m"), Significant(3), |b: &DriftAfter| {
            K95 * b.alone[1].combined
        }),
    ];
    Table::of(
        "Place from the accelerometer alone, beyond the true one",
        fields,
        budgets,
    )
}

fn aided(budgets: &[DriftAfter]) -> Table {
    let of =
        |heading: &'static str, unit: &'static str, which: usize, part: fn(&DriftBudget) -> f64| {
            number(
                "",
                (heading, unit),
                Significant(3),
                move |b: &DriftAfter| b.aided.map(|a| part(&a[which])),
            )
        };
    let fields = vec![
        number("", ("after", "s"), Significant(3), |b: &DriftAfter| {
            b.alone[0].time
        }),
        of("drift", "m/s", 0, DriftBudget::known),
        of("white noise", "m/s", 0, |b| b.noise),
        of("flicker noise", "m/s", 0, |b| b.flicker),
        of("walk", "m/s", 0, |b| b.walk),
        of("U, 95 %", "m/s", 0, |b| K95 * b.combined),
        of("place", "m", 1, DriftBudget::known),
        of("U, 95 %", "m", 1, |b| K95 * b.combined),
    ];
    Table::of(
        "With the mean of the rest before the start taken off",
        fields,
        budgets,
    )
}

/// Velocity and place with the encoder's aiding, by cause.
fn beside_encoder(budgets: &[DriftAfter]) -> Table {
    let of = |heading: &'static str, unit: &'static str, part: fn(&AidedDrift) -> f64| {
        number(
            "",
            (heading, unit),
            Significant(3),
            move |b: &DriftAfter| b.beside_encoder.as_ref().map(part),
        )
    };
    let fields = vec![
        number("", ("after", "s"), Significant(3), |b: &DriftAfter| {
            b.alone[0].time
        }),
        of("both sensors", "m/s", |e| e.filter[0]),
        of("length of a count", "m/s", |e| e.scale[0]),
        of("U, 95 %", "m/s", |e| K95 * e.combined[0]),
        of("both sensors", "m", |e| e.filter[1]),
        of("length of a count", "m", |e| e.scale[1]),
        of("counts added up", "m", |e| e.walk),
        of("U, 95 %", "m", |e| K95 * e.combined[1]),
    ];
    Table::of("With an encoder beside the accelerometer", fields, budgets)
}

fn taken(taken: &[TakenFrom]) -> Table {
    let fields = vec![
        words("quantity", |t: &TakenFrom| t.quantity.clone()),
        words("value", |t: &TakenFrom| t.value.clone()),
        words("unit", |t: &TakenFrom| t.unit.clone()),
        words("from", |t: &TakenFrom| t.file.clone()),
    ];
    Table::of("What was taken from which file", fields, taken)
}

fn plot(outcome: &VelocityDrift) -> XyPlot {
    let last = outcome.budgets().iter();
    let last = last.fold(0.0f64, |m, b| m.max(b.alone[0].time));
    let time: Vec<f64> = (1..=200).map(|k| last * f64::from(k) / 200.0).collect();
    // The request was answered: it is answered for other times.
    let curve = outcome.request.after_all(&time).unwrap_or_default();
    let line = |name: &str, which: usize, pick: fn(&DriftAfter) -> Option<&[DriftBudget; 2]>| {
        let budgets: Option<Vec<&DriftBudget>> =
            curve.iter().map(|b| Some(&pick(b)?[which])).collect();
        let budgets = budgets?;
        let known: Vec<f64> = budgets.iter().map(|b| b.known()).collect();
        let half: Vec<f64> = budgets.iter().map(|b| K95 * b.combined).collect();
        Some(Series::line(name, &time, &known).within(&half))
    };
    let mut plot = XyPlot::new(
        Axis::linear("time since the integration began", "s"),
        Axis::linear("drift", "m/s"),
    );
    let rested = outcome.request.sources.rest > 0.0;
    let name = match (rested, outcome.request.encoder.is_some()) {
        (true, _) => "without the rest",
        (false, true) => "accelerometer alone",
        (false, false) => "",
    };
    for which in 0..2 {
        if which == 1 {
            plot = plot.below(Axis::linear("place", "m"));
        }
        for series in [
            line(name, which, |b| Some(&b.alone)),
            line("with the rest", which, |b| b.aided.as_ref()),
        ]
        .into_iter()
        .flatten()
        {
            plot = plot.series(series);
        }
        let aided: Option<Vec<f64>> = curve
            .iter()
            .map(|b| b.beside_encoder.map(|e| K95 * e.combined[which]))
            .collect();
        if let Some(half) = aided.filter(|h| h.len() == time.len()) {
            let zero = vec![0.0; time.len()];
            plot = plot.series(Series::line("with the encoder", &time, &zero).within(&half));
        }
        plot = plot.horizontal(0.0, "");
    }
    plot
}
