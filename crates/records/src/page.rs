//! Pages of the records: the list, a device, a standard, what is due, a recall, a check. Made of the blocks of every report.

use crate::check::{Check, Difference, Recomputed};
use crate::day::{date_of, day_of};
use crate::device::DeviceRow;
use crate::due::Due;
use crate::entry::{Content, FiledQuantity};
use crate::history::{History, Point};
use crate::ledger::Records;
use crate::recall::{Recall, Recalled};
use crate::rests::Rest;
use crate::tolerance::judge;
use proofmass_jobs::{Result, Sink, Trouble};
use proofmass_report::{Axis, Cell, Field, Report, Rounding, Section, Series, Table, XyPlot, html};
use proofmass_static::static_test::MONTH;

fn date(day: Option<i64>) -> Cell {
    day.map(date_of).into()
}

fn number(n: i64) -> Cell {
    Cell::number(n.to_string())
}

/// A digest as it is shown.
fn short(sha256: &str) -> String {
    match sha256.get(..12) {
        Some(start) => format!("{start}…"),
        None => sha256.to_owned(),
    }
}

/// Every device, or the standards alone, with what is overdue.
///
/// # Errors
/// The database refuses, or `today` is no date.
pub fn list(records: &mut Records, standards_alone: bool, today: &str) -> Result<Report> {
    let day = day_of(today)?;
    let devices = records.devices(standards_alone)?;
    let over = devices
        .iter()
        .filter(|d| d.due.is_some_and(|due| due < day))
        .count();
    let verdict = match over {
        0 => "No device is overdue.".to_owned(),
        1 => "One device is overdue.".to_owned(),
        n => format!("{n} devices are overdue."),
    };
    Ok(Report::new("Devices")
        .subtitle(format!(
            "{} devices and standards on {today}",
            devices.len()
        ))
        .question(verdict)
        .section(
            Section::new("Devices")
                .table(device_table(&devices, day))
                .summarised(),
        ))
}

fn device_table(devices: &[DeviceRow], today: i64) -> Table {
    let fields = [
        Field::new("number", |d: &DeviceRow| number(d.number)).page("no.", ""),
        Field::new("device", |d: &DeviceRow| d.name.as_str().into()).page("device", ""),
        Field::new("owner_number", |d: &DeviceRow| {
            d.owner_number.clone().into()
        })
        .page("owner's no.", ""),
        Field::shown("", "", |d: &DeviceRow| {
            if d.standard { "standard" } else { "" }.into()
        }),
        Field::new("calibrations", |d: &DeviceRow| number(d.results)).page("calibrations", ""),
        Field::new("last", |d: &DeviceRow| date(d.last)).page("last", ""),
        Field::new("due", |d: &DeviceRow| date(d.due)).page("due", ""),
        Field::shown("", "", move |d: &DeviceRow| {
            if d.due.is_some_and(|due| due < today) {
                "OVERDUE"
            } else {
                ""
            }
            .into()
        }),
    ];
    Table::of("", fields, devices).file("devices.csv")
}

/// What is due within so many days, with the rule of each.
///
/// # Errors
/// The database refuses, or `today` is no date.
pub fn due(records: &mut Records, today: &str, within: i64) -> Result<Report> {
    let day = day_of(today)?;
    let due = records.due(day + within)?;
    let over = due.iter().filter(|d| d.is_over(day)).count();
    let fields = [
        Field::new("device", |d: &Due| d.name.as_str().into()).page("device", ""),
        Field::new("number", |d: &Due| number(d.device)).page("no.", ""),
        Field::new("due", |d: &Due| date(Some(d.day))).page("due", ""),
        Field::new("days", move |d: &Due| number(d.day - day)).page("in", "d"),
        Field::shown("", "", move |d: &Due| {
            if d.is_over(day) { "OVERDUE" } else { "" }.into()
        }),
        Field::new("evidence", |d: &Due| d.evidence.as_str().into()).page("by the rule", ""),
    ];
    let table = Table::of("", fields, &due).file("due.csv");
    Ok(Report::new("Due")
        .subtitle(format!("within {within} days of {today}"))
        .question(format!("{} due, {over} of them overdue.", due.len()))
        .section(Section::new("Due").table(table).summarised()))
}

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
    page = page.section(results_section(records, device)?);
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
            Field::shown("", "", |r: &Vec<_>| {
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
            Field::shown("", "", |e: &(i64, String, String)| e.2.as_str().into()),
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

fn integer(row: &[crate::engine::Value], i: usize) -> Option<i64> {
    row[i].integer()
}

fn real(row: &[crate::engine::Value], i: usize) -> Option<f64> {
    row[i].real()
}

fn text(row: &[crate::engine::Value], i: usize) -> Cell {
    row[i].text().map(str::to_owned).into()
}

/// A value with the standard uncertainty behind it.
fn pair(row: &[crate::engine::Value], i: usize) -> Cell {
    match (row[i].real(), row[i + 1].real()) {
        (Some(value), Some(u)) => Cell::Estimate(value, u),
        (value, _) => value.into(),
    }
}

fn results_section(records: &mut Records, device: i64) -> Result<Section> {
    let rows = records.engine.rows(
        "SELECT result.entry, result.day, kind, number, (SELECT new FROM supersession WHERE old = result.entry),
                (SELECT reason FROM supersession WHERE old = result.entry)
         FROM result WHERE device = ?1 ORDER BY day, result.entry",
        &[device.into()],
    )?;
    let fields = [
        Field::shown("no.", "", |r: &Vec<_>| {
            number(integer(r, 0).unwrap_or_default())
        }),
        Field::shown("day", "", |r: &Vec<_>| date(integer(r, 1))),
        Field::shown("kind", "", |r: &Vec<_>| text(r, 2)),
        Field::shown("certificate", "", |r: &Vec<_>| text(r, 3)),
        Field::shown("superseded by", "", |r: &Vec<_>| {
            integer(r, 4).map(number).into_cell()
        }),
        Field::shown("because", "", |r: &Vec<_>| text(r, 5)),
    ];
    Ok(Section::new("Results")
        .table(Table::of("", fields, rows))
        .summarised())
}

/// A cell, or an empty place.
trait IntoCell {
    fn into_cell(self) -> Cell;
}

impl IntoCell for Option<Cell> {
    fn into_cell(self) -> Cell {
        self.unwrap_or(Cell::Empty)
    }
}

fn rests_table(rests: &[Rest]) -> Table {
    let fields = [
        Field::new("depth", |r: &Rest| number(r.depth as i64)).page("depth", ""),
        Field::new("result", |r: &Rest| number(r.result)).page("named by", ""),
        Field::new("name", |r: &Rest| r.name.as_str().into()).page("file", ""),
        Field::new("sha256", |r: &Rest| r.sha256.as_str().into()),
        Field::shown("SHA-256", "", |r: &Rest| short(&r.sha256).into()),
        Field::shown("", "", |r: &Rest| {
            match (r.kept, r.from) {
                (_, Some(from)) => format!("of result {from}"),
                (true, None) => "kept".to_owned(),
                (false, None) => "its digest alone".to_owned(),
            }
            .into()
        }),
    ];
    Table::of("", fields, rests).file("rests_on.csv")
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
        let named = filed
            .quantities
            .iter()
            .find(|q| q.name == tolerance.quantity);
        if let (Some(limits), Some(q)) = (tolerance.limits, named) {
            rows.push((q.clone(), limits, judge(q, limits)?));
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
        Field::shown("", "", |r: &Judged| {
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

/// A result: its quantities, and what it rests on.
///
/// # Errors
/// There is no such result, or the database refuses.
pub fn result(records: &mut Records, result: i64) -> Result<Report> {
    let Content::Result(filed) = records.entry(result)?.content else {
        return Err(Trouble::request(format!("entry {result} is no result"))
            .with_hint("`proofmass records list` has the results"));
    };
    let device = records.filed_device(filed.device)?;
    let mut page = Report::new(format!("Result {result} of {}", device.line()))
        .meta("kind", filed.result_kind.clone())
        .meta("day", filed.date.clone())
        .meta("computed by", filed.source.clone());
    if let Some(number) = &filed.number {
        page = page.meta("certificate", number.clone());
    }
    page = page.question(match records.superseded(result)? {
        Some((Some(new), reason)) => format!("Superseded by result {new}: {reason}."),
        Some((None, reason)) => format!("It no longer counts: {reason}."),
        None => "It counts.".to_owned(),
    });
    let fields = [
        Field::new("quantity", |q: &FiledQuantity| q.name.as_str().into()).page("quantity", ""),
        Field::new("value", |q: &FiledQuantity| {
            q.u.map_or(q.value.into(), |u| Cell::Estimate(q.value, u))
        })
        .page("value", ""),
        Field::new("U", |q: &FiledQuantity| q.expanded.into())
            .page("U", "")
            .rounded(Rounding::Power(2)),
        Field::new("k", |q: &FiledQuantity| q.k.into())
            .page("k", "")
            .decimals(2),
        Field::new("unit", |q: &FiledQuantity| q.unit.as_str().into()).page("unit", ""),
        Field::new("u_standard", |q: &FiledQuantity| q.u_standard.into())
            .page("u of the standard", "")
            .rounded(Rounding::Power(1)),
    ];
    let table = Table::of("", fields, &filed.quantities);
    let rests = records.rests_on(result)?;
    page = page.section(Section::new("Quantities").table(table).summarised());
    if !rests.is_empty() {
        page = page.section(
            Section::new("What it rests on")
                .table(rests_table(&rests))
                .summarised(),
        );
    }
    Ok(page)
}

/// The history of every quantity of a device, or of those whose name begins with `quantity`.
///
/// # Errors
/// The device has no result, or the database refuses.
pub fn history(records: &mut Records, device: i64, quantity: Option<&str>) -> Result<Report> {
    let name = records.filed_device(device)?.line();
    let mut found = records.history(device)?;
    found.retain(|h| quantity.is_none_or(|q| h.series.name.starts_with(q)));
    if found.is_empty() {
        return Err(Trouble::request("no quantity of the device has this name")
            .with_hint("leave --quantity away to see all"));
    }
    let fields = [
        Field::new("quantity", |h: &History| h.series.name.as_str().into()).page("quantity", ""),
        Field::new("calibrations", |h: &History| {
            number(h.series.points.len() as i64)
        })
        .page("calibrations", ""),
        Field::new("last", |h: &History| {
            h.series.points.last().map(|p| p.value).into()
        })
        .page("last value", "")
        .rounded(Rounding::Significant(6)),
        Field::estimate("drift_per_month", "u_drift_per_month", |h: &History| {
            h.drift
                .as_ref()
                .map(|d| (d.drift.value, d.drift.standard_uncertainty))
        })
        .page("drift per month", ""),
        Field::new("U_drift_per_month", |h: &History| {
            h.drift.as_ref().map(|d| d.drift.expanded(0.95)).into()
        })
        .page("U (95 %)", "")
        .rounded(Rounding::Power(1)),
        Field::new("unit", |h: &History| h.series.unit.as_str().into()).page("unit", ""),
        Field::shown("jump", "", |h: &History| {
            h.jump
                .map(|j| format!("{:+.3e} before {}", j.height, date_of(j.before as i64)))
                .into()
        }),
    ];
    let table = Table::of("", fields, &found).file("history.csv");
    let drifting = found
        .iter()
        .filter(|h| {
            h.drift
                .as_ref()
                .is_some_and(|d| d.drift.value.abs() > d.drift.expanded(0.95))
        })
        .count();
    let mut charts = Section::new("Control charts")
        .paragraph("Markers with the stated U; the band is where a calibration of such uncertainty is expected. Values without U have no bar.");
    for h in &found {
        charts = charts.figure(format!("Control chart of {}", h.series.name), chart(h));
    }
    let page = Report::new(format!("History of {name}"))
        .question(match drifting {
            0 => "No drift is larger than its U.".to_owned(),
            1 => "The drift of one quantity is larger than its U.".to_owned(),
            n => format!("The drifts of {n} quantities are larger than their U."),
        })
        .findings(found.iter().flat_map(|h| h.findings.iter().cloned()))
        .section(Section::new("Quantities").table(table).summarised())
        .section(charts)
        .section(Section::new("Calibrations").table(points(&found)));
    Ok(page)
}

fn points(found: &[History]) -> Table {
    type Row = (String, String, Point);
    let rows: Vec<Row> = found
        .iter()
        .flat_map(|h| {
            h.series
                .points
                .iter()
                .map(|p| (h.series.name.clone(), h.series.unit.clone(), p.clone()))
        })
        .collect();
    let fields = [
        Field::new("quantity", |r: &Row| r.0.as_str().into()).page("quantity", ""),
        Field::new("result", |r: &Row| number(r.2.result)).page("result", ""),
        Field::new("day", |r: &Row| date(Some(r.2.day))).page("day", ""),
        Field::new("value", |r: &Row| {
            r.2.u
                .map_or(r.2.value.into(), |u| Cell::Estimate(r.2.value, u))
        })
        .page("value", ""),
        Field::new("U", |r: &Row| r.2.expanded.into())
            .page("U", "")
            .rounded(Rounding::Power(1)),
        Field::new("unit", |r: &Row| r.1.as_str().into()).page("unit", ""),
    ];
    Table::of("", fields, rows).file("calibrations.csv")
}

fn chart(h: &History) -> XyPlot {
    let last = h.series.points.last().map_or(0, |p| p.day);
    let day = |p: &Point| (p.day - last) as f64;
    let days: Vec<f64> = h.series.points.iter().map(day).collect();
    let values: Vec<f64> = h.series.points.iter().map(|p| p.value).collect();
    let half = |p: &Point| p.expanded.or(p.u.map(|u| 2.0 * u)).unwrap_or(0.0);
    let [low, high] = [-1.0, 1.0].map(|s| {
        h.series
            .points
            .iter()
            .map(|p| p.value + s * half(p))
            .collect::<Vec<f64>>()
    });
    let mut plot = XyPlot::new(
        Axis::linear("days before the last calibration", "d"),
        Axis::linear(&h.series.name, &h.series.unit),
    );
    if let Some(d) = &h.drift {
        let at: Vec<f64> = d.limits.iter().map(|l| l[0] - last as f64).collect();
        let line: Vec<f64> = d
            .limits
            .iter()
            .map(|l| d.level + d.drift.value * (l[0] - d.mean_day) / MONTH)
            .collect();
        let [from, to] = [1, 2].map(|i| d.limits.iter().map(|l| l[i]).collect::<Vec<f64>>());
        plot = plot.series(Series::line("drift", &at, &line).band(&from, &to));
    }
    plot.series(Series::markers("calibrations", &days, &values).bars(&low, &high))
}

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
                (None, Some(e)) => format!("{:.2e} {} in {}", e.effect, e.unit, e.quantity),
                (None, None) => String::new(),
            }
            .into()
        }),
        Field::shown("", "", |r: &Recalled| {
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
    let mut page = Report::new(format!("What rests on {}", recall.name))
        .subtitle(format!("from {from} to {to}, since {}", recall.since))
        .question(format!(
            "Results: {}; devices: {}; certificates with a number: {certificates}.",
            recall.results.len(),
            devices.len()
        ))
        .section(
            Section::new("Results")
                .table(Table::of("", fields, &recall.results).file("recall.csv"))
                .summarised(),
        );
    if !each.is_empty() {
        page = page.section(
            Section::new("Effects").table(Table::of("", effects, each).file("effects.csv")),
        );
    }
    page
}

/// The effect that is largest beside its U.
fn worst(r: &Recalled) -> Option<&crate::recall::RecalledEffect> {
    let share = |e: &crate::recall::RecalledEffect| e.expanded.map_or(0.0, |u| e.effect / u);
    r.effects
        .iter()
        .max_by(|a, b| share(a).total_cmp(&share(b)))
}

fn largest(r: &Recalled) -> Option<f64> {
    let worst = worst(r)?;
    worst
        .expanded
        .filter(|u| *u > 0.0)
        .map(|u| worst.effect / u)
}

/// What a check found.
pub fn check(check: &Check) -> Report {
    let mut section = Section::new("Damage");
    for line in &check.damage {
        section = section.paragraph(line.clone());
    }
    let page = Report::new("Check of the records")
        .question(match check.damage.len() {
            0 => format!(
                "The records are whole: {} entries, {} files, {} signatures.",
                check.entries, check.files, check.signatures
            ),
            1 => "One thing is not as it was filed.".to_owned(),
            n => format!("{n} things are not as they were filed."),
        })
        .meta("digest of the last entry", check.head.clone());
    match check.is_whole() {
        true => page,
        false => page.section(section.summarised()),
    }
}

/// What came of computing a result again.
pub fn recomputed(result: i64, found: &Recomputed) -> Report {
    let page = Report::new(format!("Result {result} computed again"));
    let table = |quantities: &[Difference]| {
        let fields = [
            Field::shown("quantity", "", |d: &Difference| d.name.as_str().into()),
            Field::shown("stored", "", |d: &Difference| d.values[0].into())
                .rounded(Rounding::Significant(8)),
            Field::shown("now", "", |d: &Difference| d.values[1].into())
                .rounded(Rounding::Significant(8)),
            Field::shown("unit", "", |d: &Difference| d.unit.as_str().into()),
            Field::shown("difference / U", "", |d: &Difference| d.share.into())
                .rounded(Rounding::TwoDigits),
            Field::shown("", "", |d: &Difference| {
                if d.is_within() {
                    "within U"
                } else {
                    "BEYOND U"
                }
                .into()
            }),
        ];
        Section::new("Quantities")
            .table(Table::of("", fields, quantities))
            .summarised()
    };
    match found {
        Recomputed::Same => page.question("The same version gives the same bytes."),
        Recomputed::Differs { quantities } => page
            .question("The same version gives OTHER bytes.")
            .section(table(quantities)),
        Recomputed::OtherVersion {
            version,
            quantities,
        } => {
            let beyond = quantities.iter().filter(|d| !d.is_within()).count();
            page.question(format!(
                "Computed by {version}; {beyond} of {} quantities now differ by more than their U.",
                quantities.len()
            ))
            .section(table(quantities))
        }
        Recomputed::NotPossible { why } => {
            page.question(format!("It cannot be computed again: {why}."))
        }
    }
}

/// Writes the pages: index.html with the devices, due.html, and one for each device or standard.
///
/// # Errors
/// The database or the place refuses.
pub fn write(records: &mut Records, sink: &dyn Sink, today: &str) -> Result<()> {
    let put = |name: String, page: Report| -> Result<()> {
        sink.write(&name, html::render(&page)?.into_bytes())?;
        Ok(())
    };
    let mut index = list(records, false, today)?;
    index = index.section(Section::new("Pages").paragraph(
        "due.html has what is due; device-N.html has the device or standard with the number N.",
    ));
    put("index.html".to_owned(), index)?;
    put("due.html".to_owned(), due(records, today, 366)?)?;
    for row in records.devices(false)? {
        let mut page = device(records, row.number, today)?;
        if row.results > 0 {
            let history = history(records, row.number, None)?;
            page = page.findings(history_findings(records, row.number)?);
            page.sections.extend(history.sections);
        }
        put(format!("device-{}.html", row.number), page)?;
    }
    Ok(())
}

fn history_findings(
    records: &mut Records,
    device: i64,
) -> Result<Vec<proofmass_uncertainty::Finding>> {
    Ok(records
        .history(device)?
        .into_iter()
        .flat_map(|h| h.findings)
        .collect())
}
