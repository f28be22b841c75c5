//! What is to be doubted at the moment something other than a result is filed.

use crate::engine::Engine;
use crate::entry::{Content, FiledCheck, FiledRule};
use crate::filing::name_of;
use crate::ledger::read_entry;
use crate::{tolerance, used};
use proofmass_jobs::Result;
use proofmass_jobs::findings::filing as findings;
use proofmass_uncertainty::Finding;

/// The doubts about an entry that was just filed.
pub(crate) fn of(engine: &mut dyn Engine, number: i64, content: &Content) -> Result<Vec<Finding>> {
    match content {
        Content::Certificate(c) => used::doubts_behind(engine, number, c),
        Content::Check(check) => failed(engine, check),
        Content::Rule(rule) => not_kept(engine, rule),
        Content::Supersession(s) => {
            let rows = engine.rows(
                "SELECT DISTINCT input.result FROM output JOIN input ON input.digest = output.digest
                 WHERE output.result = ?1 AND output.name IN ('result.json', 'calibration.json') AND input.result <> ?1
                   AND input.result NOT IN (SELECT old FROM supersession) ORDER BY input.result",
                &[s.old.into()],
            )?;
            let numbers: Vec<String> = rows
                .iter()
                .filter_map(|row| Some(row[0].integer()?.to_string()))
                .collect();
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

/// A check measurement that does not agree.
fn failed(engine: &mut dyn Engine, c: &FiledCheck) -> Result<Vec<Finding>> {
    if c.en.abs() <= 1.0 {
        return Ok(Vec::new());
    }
    let name = name_of(engine, c.device)?;
    let difference = c.value - c.reference;
    let expanded = (difference / c.en).abs();
    Ok(vec![findings::check_failed(
        &name,
        &c.quantity,
        c.en,
        difference,
        expanded,
        &c.unit,
    )])
}

/// Limits that the last result of a device does not keep.
fn not_kept(engine: &mut dyn Engine, rule: &FiledRule) -> Result<Vec<Finding>> {
    if rule.tolerances.iter().all(|t| t.limits.is_none()) {
        return Ok(Vec::new());
    }
    let last =
        "SELECT entry, device, day FROM result WHERE entry NOT IN (SELECT old FROM supersession)";
    let rows = match rule.device {
        Some(device) => engine.rows(
            &format!("{last} AND device = ?1 ORDER BY day, entry"),
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
