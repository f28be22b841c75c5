//! What has to be recalled.

use super::cells::{date, number};
use crate::day::date_of;
use crate::recall::{Recall, Recalled};
use proofmass_report::{Field, Report, Rounding, Section, Table};

/// What rests on a standard.
pub fn recall(recall: &Recall) -> Report {
    let fields = [
        Field::new("result", |r: &Recalled| number(r.result)).page("result", ""),
        Field::new("day", |r: &Recalled| date(Some(r.day))).page("day", ""),
        Field::new("certificate", |r: &Recalled| r.number.clone().into()).page("certificate", ""),
        Field::new("device", |r: &Recalled| r.name.as_str().into()).page("device", ""),
        Field::new("through", |r: &Recalled| {
            r.through
                .iter()
                .map(i64::to_string)
                .collect::<Vec<_>>()
                .join(" ")
                .into()
        })
        .page("through results", ""),
        Field::new("largest_effect_over_U", |r: &Recalled| largest(r).into())
            .page("largest effect / U", "")
            .decimals(2),
        Field::shown("effect", "", |r: &Recalled| {
            match (&r.undetermined, worst(r)) {
                (Some(why), _) => format!("not determinable: {why}"),
                (None, Some(e)) => {
                    let most = if e.at_most { "at most " } else { "" };
                    let percent = e
                        .relative
                        .map_or(String::new(), |r| format!(" ({:+.2} %)", 1e2 * r));
                    format!(
                        "{most}{:.2e} {}{percent} in {}",
                        e.effect, e.unit, e.quantity
                    )
                }
                (None, None) => String::new(),
            }
            .into()
        }),
        Field::shown("state", "", |r: &Recalled| {
            if r.superseded { "superseded" } else { "" }.into()
        }),
    ];
    let devices: std::collections::BTreeSet<i64> =
        recall.results.iter().map(|r| r.device).collect();
    let certificates = recall.results.iter().filter(|r| r.number.is_some()).count();
    type Row = (i64, crate::recall::RecalledEffect);
    let each: Vec<Row> = recall
        .results
        .iter()
        .flat_map(|r| r.effects.iter().map(|e| (r.result, e.clone())))
        .collect();
    let effects = [
        Field::new("result", |r: &Row| number(r.0)).page("result", ""),
        Field::new("quantity", |r: &Row| r.1.quantity.as_str().into()).page("quantity", ""),
        Field::new("effect", |r: &Row| r.1.effect.into())
            .page("effect", "")
            .rounded(Rounding::Power(2)),
        Field::new("effect_percent", |r: &Row| {
            r.1.relative.map(|e| 1e2 * e).into()
        })
        .page("of the value", "%")
        .rounded(Rounding::TwoDigits),
        Field::new("U", |r: &Row| r.1.expanded.into())
            .page("U", "")
            .rounded(Rounding::Power(2)),
        Field::new("unit", |r: &Row| r.1.unit.as_str().into()).page("unit", ""),
    ];
    let [from, to] = recall.days.map(|day| {
        if day < -1_000_000 {
            "the beginning".to_owned()
        } else {
            date_of(day)
        }
    });
    let mut table = Table::of("", fields, &recall.results).file("recall.csv");
    if let Some(error) = recall.error {
        table = table.note(format!(
            "For a standard whose sensitivity is {:+.3} % of what its certificate says away from it. Effects are stated less true: a \
             sensitivity is stated too small where that of the standard is too large.",
            1e2 * error
        ));
    } else if let Some(found) = recall.found {
        table = table.note(format!(
            "The failed check found {:+.3} %: --error {:.3} gives the effect on each result.",
            1e2 * found,
            1e2 * found
        ));
    }
    let mut page = Report::new(format!("What rests on {}", recall.name))
        .subtitle(format!("from {from} to {to}, since {}", recall.since))
        .question(format!(
            "Results: {}; devices: {}; certificates with a number: {certificates}.",
            recall.results.len(),
            devices.len()
        ))
        .section(Section::new("Results").table(table).summarised());
    if !each.is_empty() {
        page = page.section(
            Section::new("Effects").table(Table::of("", effects, each).file("effects.csv")),
        );
    }
    page
}

/// The effect that is largest beside its U.
fn worst(r: &Recalled) -> Option<&crate::recall::RecalledEffect> {
    let share = |e: &crate::recall::RecalledEffect| e.expanded.map_or(0.0, |u| e.effect.abs() / u);
    r.effects
        .iter()
        .max_by(|a, b| share(a).total_cmp(&share(b)))
}

fn largest(r: &Recalled) -> Option<f64> {
    let worst = worst(r)?;
    worst
        .expanded
        .filter(|u| *u > 0.0)
        .map(|u| worst.effect.abs() / u)
}
