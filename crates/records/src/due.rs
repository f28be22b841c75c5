//! When devices are due, by the rule that was stated, with its evidence.

use crate::day::as_date;
use crate::day::date_of;
use crate::engine::{Engine, Value};
use crate::entry::{Content, FiledRule};
use crate::history::{self, Series};
use crate::ledger::{Records, read_entry};
use crate::schema::CALIBRATIONS;
use proofmass_jobs::Result;
use proofmass_static::static_test::{Drift, DriftQuestion, RecalibrationRule};
use serde::Serialize;

/// A device that is due, or will be.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Due {
    /// The device.
    pub device: i64,
    /// Maker, type and serial number.
    pub name: String,
    /// Day of its last calibration, days from 1970-01-01.
    #[serde(serialize_with = "as_date::one")]
    pub last: i64,
    /// Day on which it is due, days from 1970-01-01.
    #[serde(serialize_with = "as_date::one")]
    pub day: i64,
    /// The rule, with what it rests on.
    pub evidence: String,
}

impl Due {
    /// Whether it is overdue on a day.
    pub fn is_over(&self, today: i64) -> bool {
        self.day < today
    }
}

impl Records {
    /// What is due up to a day, the first one first; devices out of use, and those with neither a rule nor a certificate that ends, are left out.
    ///
    /// # Errors
    /// The database refuses.
    pub fn due(&mut self, until: i64) -> Result<Vec<Due>> {
        let rows = self.engine.rows(
            "SELECT due.device, due.last, due.day, due.evidence, manufacturer, model, serial, owner_number
             FROM due JOIN device ON device.entry = due.device WHERE due.day <= ?1 ORDER BY due.day, due.device",
            &[until.into()],
        )?;
        let due = rows.iter().map(|row| Due {
            device: row[0].integer().unwrap_or_default(),
            last: row[1].integer().unwrap_or_default(),
            day: row[2].integer().unwrap_or_default(),
            evidence: row[3].words(),
            name: crate::device::line(&row[4..8]),
        });
        Ok(due.collect())
    }

    /// When a device is due; `None` without a calibration, or with neither a rule nor a certificate that ends.
    ///
    /// # Errors
    /// The database refuses.
    pub fn due_of(&mut self, device: i64) -> Result<Option<Due>> {
        of(&mut *self.engine, device)
    }

    /// The rule of a device: its own, or that of all.
    ///
    /// # Errors
    /// The database refuses, or the entry is damaged.
    pub fn rule_of(&mut self, device: i64) -> Result<Option<FiledRule>> {
        rule(&mut *self.engine, device)
    }

    /// The rule of this device alone, or that of all for `None`.
    ///
    /// # Errors
    /// The database refuses, or the entry is damaged.
    pub fn own_rule(&mut self, device: Option<i64>) -> Result<Option<FiledRule>> {
        stated(&mut *self.engine, device)
    }
}

fn of(engine: &mut dyn Engine, device: i64) -> Result<Option<Due>> {
    let rows = engine.rows(
        "SELECT due.last, due.day, due.evidence, manufacturer, model, serial, owner_number
         FROM due JOIN device ON device.entry = due.device WHERE due.device = ?1",
        &[device.into()],
    )?;
    Ok(rows.first().map(|row| Due {
        device,
        last: row[0].integer().unwrap_or_default(),
        day: row[1].integer().unwrap_or_default(),
        evidence: row[2].words(),
        name: crate::device::line(&row[3..7]),
    }))
}

/// The rule that holds for a device.
pub(crate) fn rule(engine: &mut dyn Engine, device: i64) -> Result<Option<FiledRule>> {
    match stated(engine, Some(device))? {
        Some(own) => Ok(Some(own)),
        None => stated(engine, None),
    }
}

/// The last rule that was stated for a device, or for all.
fn stated(engine: &mut dyn Engine, device: Option<i64>) -> Result<Option<FiledRule>> {
    let (condition, values) = match device {
        Some(device) => ("device = ?1", vec![Value::from(device)]),
        None => ("device IS NULL", vec![]),
    };
    let question = format!("SELECT entry FROM rule WHERE {condition} ORDER BY entry DESC LIMIT 1");
    let rows = engine.rows(&question, &values)?;
    if let Some(number) = rows.first().and_then(|row| row[0].integer())
        && let Content::Rule(rule) = read_entry(engine, number)?.content
    {
        return Ok(Some(rule));
    }
    Ok(None)
}

/// Finds anew when a device is due.
pub(crate) fn update(engine: &mut dyn Engine, device: i64) -> Result<()> {
    engine.run("DELETE FROM due WHERE device = ?1", &[device.into()])?;
    let withdrawn = engine.rows(
        "SELECT kind FROM event WHERE device = ?1 AND kind IN ('withdrawal', 'return') ORDER BY day DESC, entry DESC LIMIT 1",
        &[device.into()],
    )?;
    if withdrawn
        .first()
        .is_some_and(|row| row[0].text() == Some("withdrawal"))
    {
        return Ok(());
    }
    let results = engine.rows(
        &format!("SELECT max(day) FROM {CALIBRATIONS} WHERE device = ?1"),
        &[device.into()],
    )?;
    // What another laboratory certified counts as a calibration, too.
    let certificates = engine.rows(
        "SELECT number, valid_from, valid_until FROM certificate WHERE standard = ?1 ORDER BY valid_from DESC, entry DESC LIMIT 1",
        &[device.into()],
    )?;
    let certificate = certificates.first();
    let of_results = results.first().and_then(|row| row[0].integer());
    let of_certificate = certificate.and_then(|row| row[1].integer());
    let Some(last) = of_results.max(of_certificate) else {
        return Ok(());
    };
    let mut found: Option<(i64, String)> = None;
    if let Some(rule) = rule(engine, device)? {
        let is_fixed = matches!(rule.rule, RecalibrationRule::Fixed { .. });
        // A fixed interval asks for no history.
        let series = match is_fixed {
            true => Vec::new(),
            false => history::series(engine, device, true)?,
        };
        let (days, evidence) = rule
            .rule
            .days(&changes(&series, &rule), drift_days(&series, &rule));
        let day = last + days.floor() as i64;
        let none = match is_fixed || tolerated(&series, &rule).next().is_some() {
            true => "",
            false => "; NO RESULT HAS A QUANTITY OF THE RULE",
        };
        let evidence = format!("{evidence}{none}; last calibrated on {}", date_of(last));
        found = Some((day, evidence));
    }
    // The end of a certificate counts, unless a calibration came after it began.
    if let Some(row) = certificate.filter(|_| of_results < of_certificate)
        && let Some(until) = row[2].integer()
        && found.as_ref().is_none_or(|(day, _)| until < *day)
    {
        let evidence = format!(
            "certificate {} is valid until {}",
            row[0].words(),
            date_of(until)
        );
        found = Some((until, evidence));
    }
    let Some((day, evidence)) = found else {
        return Ok(());
    };
    engine.run(
        "INSERT INTO due (device, last, day, evidence) VALUES (?1, ?2, ?3, ?4)",
        &[device.into(), last.into(), day.into(), (&evidence).into()],
    )?;
    Ok(())
}

/// Changes between successive calibrations, the oldest first: days between the two, and the share of the tolerance, of all quantities the
/// largest.
fn changes(series: &[Series], rule: &FiledRule) -> Vec<(f64, f64)> {
    let mut all: std::collections::BTreeMap<i64, (f64, f64)> = Default::default();
    for (s, tolerance) in tolerated(series, rule) {
        for pair in s.points.windows(2) {
            let share = (pair[1].value - pair[0].value).abs() / tolerance;
            let days = (pair[1].day - pair[0].day) as f64;
            let known = all.entry(pair[1].day).or_insert((days, share));
            *known = (known.0.max(days), known.1.max(share));
        }
    }
    all.into_values().collect()
}

/// Days after the last calibration until the first tolerance may be used up.
fn drift_days(series: &[Series], rule: &FiledRule) -> Option<f64> {
    let RecalibrationRule::Drift { longest } = rule.rule else {
        return None;
    };
    let days = tolerated(series, rule).filter_map(|(s, tolerance)| {
        let question = DriftQuestion {
            probability: 0.95,
            tolerance: Some(tolerance),
            longest_interval: longest,
        };
        Drift::of(&s.name, &s.unit, &s.dated(), &question)
            .ok()?
            .due_in
    });
    days.reduce(f64::min)
}

fn tolerated<'a>(
    series: &'a [Series],
    rule: &'a FiledRule,
) -> impl Iterator<Item = (&'a Series, f64)> {
    series.iter().filter_map(|s| {
        let tolerance = rule.tolerances.iter().find(|t| t.is_of(&s.name))?;
        Some((s, tolerance.change?))
    })
}
