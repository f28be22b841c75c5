//! One device or standard with all it rests on.

use super::cells::{date, integer, number, pair, real, short, text};
use super::result::rests_table;
use crate::day::{date_of, day_of};
use crate::entry::{Content, FiledQuantity};
use crate::ledger::Records;
use crate::tolerance::judge;
use proofmass_jobs::Result;
use proofmass_report::{Cell, Field, Report, Rounding, Section, Table};

/// A device or standard: results, events, certificates, checks, and what its last result rests on.
///
/// # Errors
/// There is no such device, or the database refuses.
pub fn device(records: &mut Records, device: i64, today: &str) -> Result<Report> {
    let filed = records.filed_device(device)?;
    let due = records.due_of(device)?;
    let over = due
        .as_ref()
        .is_some_and(|d| day_of(today).is_ok_and(|today| d.is_over(today)));
    let results = records.results_of(device)?;
    let verdict = match (&due, over) {
        (Some(due), true) => format!("OVERDUE since {} ({}).", date_of(due.day), due.evidence),
        (Some(due), false) => format!("Due on {} ({}).", date_of(due.day), due.evidence),
        (None, _) if results.is_empty() => "It has no calibration here.".to_owned(),
        (None, _) => "No rule says when it is due.".to_owned(),
    };
    let what = if filed.standard {
        "Reference standard"
    } else {
        "Device"
    };
    let mut page = Report::new(format!("{what} {}", filed.line()))
        .question(verdict)
        .meta("number", device.to_string());
    for (label, text) in [
        ("owner's number", &filed.owner_number),
        ("axes", &filed.axes),
        ("description", &filed.description),
    ] {
        if let Some(text) = text {
            page = page.meta(label, text.clone());
        }
    }
    if let Some(rule) = records.rule_of(device)? {
        page = page.meta("rule", rule.words());
    }
    if let Some(section) = results_section(records, device)? {
        page = page.section(section);
    }
    let certificates = records.engine.rows(
        "SELECT entry, number, valid_from, valid_until, u_relative, digest FROM certificate WHERE standard = ?1 ORDER BY valid_from",
        &[device.into()],
    )?;
    if !certificates.is_empty() {
        let fields = [
            Field::shown("no.", "", |r: &Vec<_>| {
                number(integer(r, 0).unwrap_or_default())
            }),
            Field::shown("certificate", "", |r: &Vec<_>| text(r, 1)),
            Field::shown("valid from", "", |r: &Vec<_>| date(integer(r, 2))),
            Field::shown("until", "", |r: &Vec<_>| date(integer(r, 3))),
            Field::shown("u relative", "%", |r: &Vec<_>| {
                real(r, 4).map(|u| 1e2 * u).into()
            })
            .rounded(Rounding::TwoDigits),
            Field::shown("SHA-256", "", |r: &Vec<crate::engine::Value>| {
                r[5].text().map(short).into()
            }),
        ];
        page = page.section(
            Section::new("Certificates")
                .table(Table::of("", fields, certificates))
                .summarised(),
        );
    }
    let checks = records.engine.rows(
        "SELECT day, quantity, unit, value, u, reference, u_reference, en, good FROM checked WHERE device = ?1 ORDER BY day, entry",
        &[device.into()],
    )?;
    if !checks.is_empty() {
        let fields = [
            Field::shown("day", "", |r: &Vec<_>| date(integer(r, 0))),
            Field::shown("quantity", "", |r: &Vec<_>| text(r, 1)),
            Field::shown("measured", "", |r: &Vec<_>| pair(r, 3)),
            Field::shown("reference", "", |r: &Vec<_>| pair(r, 5)),
            Field::shown("unit", "", |r: &Vec<_>| text(r, 2)),
            Field::shown("E_n", "", |r: &Vec<_>| real(r, 7).into()).decimals(2),
            Field::shown("judgement", "", |r: &Vec<_>| {
                if integer(r, 8) == Some(1) {
                    "agrees"
                } else {
                    "DOES NOT AGREE"
                }
                .into()
            }),
        ];
        page = page.section(
            Section::new("Check measurements")
                .table(Table::of("", fields, checks))
                .summarised(),
        );
    }
    let events = records.events(device)?;
    if !events.is_empty() {
        let fields = [
            Field::shown("day", "", |e: &(i64, String, String)| date(Some(e.0))),
            Field::shown("event", "", |e: &(i64, String, String)| e.1.as_str().into()),
            Field::shown("in words", "", |e: &(i64, String, String)| {
                e.2.as_str().into()
            }),
        ];
        page = page.section(
            Section::new("Events")
                .table(Table::of("", fields, events))
                .summarised(),
        );
    }
    if let Some(last) = results.first() {
        let rests = records.rests_on(*last)?;
        if !rests.is_empty() {
            page = page.section(
                Section::new("What its last result rests on")
                    .table(rests_table(&rests))
                    .summarised(),
            );
        }
        let limits = limits(records, device, *last)?;
        if let Some(table) = limits {
            page = page.section(Section::new("Limits").table(table).summarised());
        }
    }
    Ok(page)
}

fn results_section(records: &mut Records, device: i64) -> Result<Option<Section>> {
    let rows = records.engine.rows(
        "SELECT result.entry, result.day, kind, number, (SELECT new FROM supersession WHERE old = result.entry),
                (SELECT reason FROM supersession WHERE old = result.entry)
         FROM result WHERE device = ?1 ORDER BY day, result.entry",
        &[device.into()],
    )?;
    if rows.is_empty() {
        return Ok(None);
    }
    let fields = [
        Field::shown("no.", "", |r: &Vec<_>| {
            number(integer(r, 0).unwrap_or_default())
        }),
        Field::shown("day", "", |r: &Vec<_>| date(integer(r, 1))),
        Field::shown("kind", "", |r: &Vec<_>| text(r, 2)),
        Field::shown("certificate", "", |r: &Vec<_>| text(r, 3)),
        Field::shown("superseded by", "", |r: &Vec<crate::engine::Value>| match (
            integer(r, 4),
            r[5].text(),
        ) {
            (Some(new), _) => number(new),
            (None, Some(_)) => "none".into(),
            (None, None) => "".into(),
        }),
        Field::shown("because", "", |r: &Vec<_>| text(r, 5)),
    ];
    Ok(Some(
        Section::new("Results")
            .table(Table::of("", fields, rows))
            .summarised(),
    ))
}

/// A quantity, its limits, and what they say: whether it is accepted, and the probability of conformity.
type Judged = (FiledQuantity, [f64; 2], Option<(bool, f64)>);

fn limits(records: &mut Records, device: i64, result: i64) -> Result<Option<Table>> {
    let Some(rule) = records.rule_of(device)? else {
        return Ok(None);
    };
    let Content::Result(filed) = records.entry(result)?.content else {
        return Ok(None);
    };
    let mut rows: Vec<Judged> = Vec::new();
    for tolerance in &rule.tolerances {
        if let Some(limits) = tolerance.limits {
            let named = filed.quantities.iter().filter(|q| tolerance.is_of(&q.name));
            for q in named {
                rows.push((q.clone(), limits, judge(q, limits)?));
            }
        }
    }
    if rows.is_empty() {
        return Ok(None);
    }
    let fields = [
        Field::shown("quantity", "", |r: &Judged| r.0.name.as_str().into()),
        Field::shown("value", "", |r: &Judged| {
            r.0.u
                .map_or(r.0.value.into(), |u| Cell::Estimate(r.0.value, u))
        }),
        Field::shown("lower", "", |r: &Judged| r.1[0].into()),
        Field::shown("upper", "", |r: &Judged| r.1[1].into()),
        Field::shown("unit", "", |r: &Judged| r.0.unit.as_str().into()),
        Field::shown("probability of conformity", "", |r: &Judged| {
            r.2.map(|d| d.1).into()
        })
        .decimals(3),
        Field::shown("decision", "", |r: &Judged| {
            match r.2 {
                Some((true, _)) => "accepted",
                Some((false, _)) => "NOT ACCEPTED",
                None => "not judged: no uncertainty",
            }
            .into()
        }),
    ];
    let table =
        Table::of("", fields, rows).note("Accepted within the limits narrowed by U on each side.");
    Ok(Some(table))
}
