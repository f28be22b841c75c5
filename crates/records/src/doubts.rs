//! What is to be doubted at the moment something other than a result is filed.

use crate::engine::Engine;
use crate::entry::{Content, FiledCheck, FiledDevice, FiledRule, spelling};
use crate::filing::name_of;
use crate::ledger::read_entry;
use crate::schema::CALIBRATIONS;
use crate::{rests, tolerance, used};
use proofmass_jobs::Result;
use proofmass_jobs::findings::filing as findings;
use proofmass_uncertainty::Finding;

/// Share by which the known value of a check may differ from that of the check before.
const OTHER: f64 = 0.1;

/// The doubts about an entry that was just filed.
pub(crate) fn of(engine: &mut dyn Engine, number: i64, content: &Content) -> Result<Vec<Finding>> {
    match content {
        Content::Device(d) => spelled_alike(engine, number, d),
        Content::Certificate(c) => {
            let mut doubts = used::doubts_behind(engine, number, c)?;
            let others = engine.rows(
                "SELECT entry FROM certificate WHERE number = ?1 AND entry <> ?2 ORDER BY entry LIMIT 1",
                &[(&c.number).into(), number.into()],
            )?;
            if let Some(other) = others.first().and_then(|row| row[0].integer()) {
                doubts.push(findings::number_taken(&c.number, &other.to_string()));
            }
            Ok(doubts)
        }
        Content::Check(check) => failed(engine, number, check),
        Content::Rule(rule) => not_kept(engine, rule),
        Content::Supersession(s) => {
            let mut numbers = Vec::new();
            for result in rests::resting_on(engine, s.old)? {
                if rests::superseded(engine, result)?.is_none() {
                    numbers.push(result.to_string());
                }
            }
            Ok(match numbers.is_empty() {
                true => Vec::new(),
                false => vec![findings::rests_on_superseded(
                    &s.old.to_string(),
                    &numbers.join(", "),
                )],
            })
        }
        _ => Ok(Vec::new()),
    }
}

/// Another device whose serial number is the same but for its spelling.
fn spelled_alike(engine: &mut dyn Engine, number: i64, d: &FiledDevice) -> Result<Vec<Finding>> {
    let Some(serial) = &d.serial else {
        return Ok(Vec::new());
    };
    let rows = engine.rows(
        "SELECT entry, serial FROM device WHERE spelling = ?1 AND entry <> ?2 ORDER BY entry LIMIT 1",
        &[(&spelling(serial)).into(), number.into()],
    )?;
    let doubt = rows.first().map(|row| {
        let other = row[0].integer().unwrap_or_default().to_string();
        findings::serial_spelled_otherwise(serial, &row[1].words(), &other)
    });
    Ok(doubt.into_iter().collect())
}

/// A check measurement that does not agree, or whose known value is not that of the check before.
fn failed(engine: &mut dyn Engine, number: i64, c: &FiledCheck) -> Result<Vec<Finding>> {
    let before = engine.rows(
        "SELECT reference FROM checked WHERE device = ?1 AND quantity = ?2 AND unit = ?3 AND entry <> ?4 ORDER BY day DESC, entry DESC LIMIT 1",
        &[c.device.into(), (&c.quantity).into(), (&c.unit).into(), number.into()],
    )?;
    let mut doubts = Vec::new();
    if let Some(before) = before.first().and_then(|row| row[0].real())
        && (c.reference - before).abs() > OTHER * before.abs()
    {
        let name = name_of(engine, c.device)?;
        doubts.push(findings::check_against_another(
            &name,
            &c.quantity,
            c.reference,
            before,
            &c.unit,
        ));
    }
    if c.en.abs() <= 1.0 {
        return Ok(doubts);
    }
    let name = name_of(engine, c.device)?;
    let difference = c.value - c.reference;
    let expanded = (difference / c.en).abs();
    doubts.push(findings::check_failed(
        &name,
        &c.quantity,
        c.en,
        difference,
        expanded,
        &c.unit,
    ));
    Ok(doubts)
}

/// Limits that the last result of a device does not keep.
fn not_kept(engine: &mut dyn Engine, rule: &FiledRule) -> Result<Vec<Finding>> {
    if rule.tolerances.iter().all(|t| t.limits.is_none()) {
        return Ok(Vec::new());
    }
    let last = format!("SELECT entry, device, day FROM {CALIBRATIONS}");
    let rows = match rule.device {
        Some(device) => engine.rows(
            &format!("{last} WHERE device = ?1 ORDER BY day, entry"),
            &[device.into()],
        )?,
        None => engine.rows(&format!("{last} ORDER BY day, entry"), &[])?,
    };
    let newest: std::collections::BTreeMap<i64, i64> = rows
        .iter()
        .filter_map(|row| Some((row[1].integer()?, row[0].integer()?)))
        .collect();
    let mut doubts = Vec::new();
    for (device, result) in newest {
        if let Content::Result(result) = read_entry(engine, result)?.content {
            doubts.extend(tolerance::doubts(engine, device, &result)?);
        }
    }
    Ok(doubts)
}
