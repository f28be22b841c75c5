//! Every quantity of a device over time.

use super::cells::{date, number};
use crate::day::{date_of, round_days};
use crate::history::{History, Point};
use crate::ledger::Records;
use proofmass_jobs::{Result, Trouble};
use proofmass_report::{Axis, Cell, Field, Report, Rounding, Section, Series, Table, XyPlot};
use proofmass_static::static_test::MONTH;

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
            .with_hint("leave --quantity out to see all"));
    }
    Ok(of(&name, &found))
}

/// The page of what was found of each quantity.
pub(super) fn of(name: &str, found: &[History]) -> Report {
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
    let table = Table::of("", fields, found).file("history.csv");
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
    for h in found {
        charts = charts.figure(format!("Control chart of {}", h.series.name), chart(h));
    }
    let first = first(found);
    let jumps = found.iter().filter(|h| h.jump.is_some()).count();
    let mut page = Report::new(format!("History of {name}"))
        .question(match drifting {
            _ if jumps > 0 => match jumps {
                1 => "One quantity has jumped.".to_owned(),
                n => format!("{n} quantities have jumped."),
            },
            0 if found.iter().all(|h| h.drift.is_none()) => {
                "Fewer than three calibrations with U: no drift can be told.".to_owned()
            }
            0 => "No drift is larger than its U.".to_owned(),
            1 => "The drift of one quantity is larger than its U.".to_owned(),
            n => format!("The drifts of {n} quantities are larger than their U."),
        })
        .findings(found.iter().flat_map(|h| h.findings.iter().cloned()))
        .section(Section::new("Quantities").table(table).summarised())
        .section(charts)
        .section(Section::new("Calibrations").table(points(found)));
    if let Some((name, chart)) = first {
        page = page.shown_by(format!("Control chart of {name}"), chart);
    }
    page
}

/// The chart of the quantity that has moved most beside its U.
fn first(found: &[History]) -> Option<(String, XyPlot)> {
    let most = found.iter().max_by(|a, b| moved(a).total_cmp(&moved(b)))?;
    Some((most.series.name.clone(), chart(most)))
}

/// How far a quantity has moved: its jump or its drift over their standard uncertainty.
fn moved(h: &History) -> f64 {
    let jump = h
        .jump
        .map_or(0.0, |j| (j.height / j.standard_uncertainty).abs());
    let drift = h.drift.as_ref().map_or(0.0, |d| {
        (d.drift.value / d.drift.standard_uncertainty).abs()
    });
    jump.max(drift)
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
    let day = |p: &Point| p.day as f64;
    let bounds = |of: fn(i64, i64) -> i64| h.series.points.iter().map(|p| p.day).reduce(of);
    let marks = match (bounds(i64::min), bounds(i64::max)) {
        (Some(first), Some(last)) => round_days(first, last),
        _ => Vec::new(),
    };
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
        Axis::linear("date", "").marked(marks),
        Axis::linear(&h.series.name, &h.series.unit),
    );
    if let Some(d) = &h.drift {
        let at: Vec<f64> = d.limits.iter().map(|l| l[0]).collect();
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
