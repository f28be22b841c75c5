//! Every quantity of a device over time: drift, jumps, limits.

use crate::day::as_date;
use crate::day::date_of;
use crate::engine::{Engine, Value};
use crate::ledger::Records;
use proofmass_jobs::{Result, Trouble};
use proofmass_static::static_test::{DatedValue, Drift, DriftQuestion, Jump};
use proofmass_uncertainty::{DegreesOfFreedom, Finding};
use serde::Serialize;

/// Coverage probability of what is found over time.
const PROBABILITY: f64 = 0.95;

/// One quantity of a device over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Series {
    /// Name of the quantity.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The calibrations, the oldest first.
    pub points: Vec<Point>,
}

/// A calibration in a history.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Point {
    /// The result.
    pub result: i64,
    /// Days from 1970-01-01.
    #[serde(serialize_with = "as_date::one")]
    pub day: i64,
    /// Value.
    pub value: f64,
    /// Standard uncertainty; unknown for old values without one.
    pub u: Option<f64>,
    /// Expanded uncertainty.
    pub expanded: Option<f64>,
    /// Degrees of freedom.
    pub dof: DegreesOfFreedom,
    /// The certificate of the standard behind it with the standard uncertainty that comes from there.
    pub shared: Option<(i64, f64)>,
}

/// What is found of a quantity over time.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct History {
    /// All calibrations that count.
    pub series: Series,
    /// Drift since the last repair or adjustment, from three calibrations with uncertainty on.
    pub drift: Option<Drift>,
    /// The largest jump since then, where one is beyond chance.
    pub jump: Option<Jump>,
    /// What is to be doubted.
    pub findings: Vec<Finding>,
}

impl Series {
    /// The calibrations with an uncertainty, for a regression. Those with the same certificate share its error.
    pub fn dated(&self) -> Vec<DatedValue> {
        let with_u = self.points.iter().filter_map(|p| {
            let u = p.u.filter(|u| *u > 0.0)?;
            let value = DatedValue::new(p.day as f64, p.value, u, p.dof);
            Some(match p.shared {
                Some((certificate, shared)) => value.sharing(certificate as u64, shared.min(u)),
                None => value,
            })
        });
        with_u.collect()
    }
}

impl Records {
    /// The history of every quantity of a device; superseded results are left out.
    ///
    /// # Errors
    /// The device has no result, or the database refuses.
    pub fn history(&mut self, device: i64) -> Result<Vec<History>> {
        let engine = &mut *self.engine;
        let all = series(engine, device, false)?;
        if all.is_empty() {
            return Err(
                Trouble::request(format!("device {device} has no calibration here"))
                    .with_hint("`proofmass records add result FOLDER` files one"),
            );
        }
        let from = anew(engine, device)?;
        all.into_iter().map(|s| found(s, from)).collect()
    }

    /// Repairs, drops and the like of a device: day, kind and words, the oldest first.
    ///
    /// # Errors
    /// The database refuses.
    pub fn events(&mut self, device: i64) -> Result<Vec<(i64, String, String)>> {
        let rows = self.engine.rows(
            "SELECT day, kind, text FROM event WHERE device = ?1 ORDER BY day, entry",
            &[device.into()],
        )?;
        Ok(rows
            .iter()
            .map(|r| {
                (
                    r[0].integer().unwrap_or_default(),
                    r[1].words(),
                    r[2].words(),
                )
            })
            .collect())
    }
}

fn found(series: Series, from: i64) -> Result<History> {
    let recent = Series {
        points: series
            .points
            .iter()
            .filter(|p| p.day >= from)
            .cloned()
            .collect(),
        ..series.clone()
    };
    let dated = recent.dated();
    let question = DriftQuestion {
        probability: PROBABILITY,
        tolerance: None,
        longest_interval: 12.0,
    };
    let drift = match several_days(&dated) {
        true => Some(Drift::of(&series.name, &series.unit, &dated, &question)?),
        false => None,
    };
    let jump = match several_days(&dated) {
        true => Jump::of(&dated)?,
        false => None,
    };
    let findings = jump
        .iter()
        .map(|jump| {
            let day = |day: f64| date_of(day as i64);
            let when = format!("between {} and {}", day(jump.after), day(jump.before));
            jump.finding(&series.name, &series.unit, &when)
        })
        .collect();
    Ok(History {
        series,
        drift,
        jump,
        findings,
    })
}

/// Whether there are three values and two days.
fn several_days(values: &[DatedValue]) -> bool {
    values.len() >= 3 && values.iter().any(|v| v.day != values[0].day)
}

/// Degrees of freedom as they are filed: unlimited without a number.
pub(crate) fn freedom(nu: Option<f64>) -> DegreesOfFreedom {
    nu.and_then(DegreesOfFreedom::new)
        .unwrap_or(DegreesOfFreedom::INFINITE)
}

/// The day from which a history counts anew: that of the last repair or adjustment.
fn anew(engine: &mut dyn Engine, device: i64) -> Result<i64> {
    let rows = engine.rows(
        "SELECT max(day) FROM event WHERE device = ?1 AND kind IN ('repair', 'adjustment')",
        &[device.into()],
    )?;
    Ok(rows
        .first()
        .and_then(|row| row[0].integer())
        .unwrap_or(i64::MIN))
}

/// The quantities of a device over time, in the order of their first result; `recent` leaves out what was before the last repair or
/// adjustment.
pub(crate) fn series(engine: &mut dyn Engine, device: i64, recent: bool) -> Result<Vec<Series>> {
    let from = if recent {
        anew(engine, device)?
    } else {
        i64::MIN
    };
    let rows = engine.rows(
        "SELECT result.entry, result.day, quantity.name, quantity.unit, value, u, expanded, k, nu, u_standard,
                (SELECT min(certificate) FROM used WHERE used.result = result.entry)
         FROM result JOIN quantity ON quantity.result = result.entry
         WHERE device = ?1 AND day >= ?2 AND result.entry NOT IN (SELECT old FROM supersession)
         ORDER BY day, result.entry, quantity.place",
        &[device.into(), from.into()],
    )?;
    let mut all: Vec<Series> = Vec::new();
    let mut places: std::collections::HashMap<(String, String), usize> = Default::default();
    for row in &rows {
        let key = (row[2].words(), row[3].words());
        let place = *places.entry(key.clone()).or_insert_with(|| {
            all.push(Series {
                name: key.0,
                unit: key.1,
                points: Vec::new(),
            });
            all.len() - 1
        });
        all[place].points.push(point(row));
    }
    Ok(all)
}

fn point(row: &[Value]) -> Point {
    let expanded = row[6].real();
    // Where only U is stated, k is that of it, or 2.
    let u = row[5]
        .real()
        .or_else(|| Some(expanded? / row[7].real().unwrap_or(2.0)));
    Point {
        result: row[0].integer().unwrap_or_default(),
        day: row[1].integer().unwrap_or_default(),
        value: row[4].real().unwrap_or_default(),
        u,
        expanded,
        dof: freedom(row[8].real()),
        shared: row[10].integer().zip(row[9].real()),
    }
}
