//! Forward: what rests on a standard.

use crate::day::as_date;
use crate::day::date_of;
use crate::engine::Engine;
use crate::entry::Content;
use crate::filing::name_of;
use crate::ledger::{Records, read_entry};
use proofmass_jobs::{Result, Trouble};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What rests on a standard within a time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Recall {
    /// The standard.
    pub standard: i64,
    /// Its name.
    pub name: String,
    /// First and last day, days from 1970-01-01.
    #[serde(serialize_with = "as_date::pair")]
    pub days: [i64; 2],
    /// Why it begins there.
    pub since: String,
    /// Relative error of the standard, where one was given.
    pub error: Option<f64>,
    /// Every result, the oldest first.
    pub results: Vec<Recalled>,
}

/// A result that rests on the standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Recalled {
    /// The result.
    pub result: i64,
    /// Number of its certificate.
    pub number: Option<String>,
    /// Its device.
    pub device: i64,
    /// Name of the device.
    pub name: String,
    /// Day, days from 1970-01-01.
    #[serde(serialize_with = "as_date::one")]
    pub day: i64,
    /// Whether another has taken its place already.
    pub superseded: bool,
    /// Results between the standard and this one; none where it was used directly.
    pub through: Vec<i64>,
    /// Effect of the error of the standard on each quantity, in its unit with the U that is stated; empty where no error was given or the
    /// stored budget does not tell it.
    pub effects: Vec<RecalledEffect>,
    /// Why no effect can be told, where that is so.
    pub undetermined: Option<String>,
}

/// What an error of the standard does to a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RecalledEffect {
    /// The quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Size of the change, in the unit.
    pub effect: f64,
    /// The same as a share of the value.
    pub relative: Option<f64>,
    /// Whether the effect may be smaller: the budget does not tell several standards apart.
    pub at_most: bool,
    /// The expanded uncertainty that was stated.
    pub expanded: Option<f64>,
    /// Effect over the standard uncertainty that was stated.
    #[serde(skip)]
    ratio: Option<f64>,
}

impl Records {
    /// What used a standard while it may have been wrong, as of the day `found`, directly or through results that were the reference of others:
    /// where a check failed, from the last good one of the same quantity before it to the first good one after it; else since the last good
    /// check of a sensitivity, or the certificate. `error` is the relative error of the standard.
    ///
    /// The effect on a quantity is error/u · c, with the relative standard uncertainty u of the certificate that was used and the part c
    /// of the uncertainty that the stored budget gives to the reference: the sensitivity of the result to the standard. A relative error
    /// turns no phase. Where the result was the reference of another, its own effect over its u takes the place of error/u there.
    ///
    /// # Errors
    /// The database refuses; a first day behind the last, an error that is not finite.
    pub fn recall(
        &mut self,
        standard: i64,
        found: i64,
        since: Option<i64>,
        error: Option<f64>,
    ) -> Result<Recall> {
        if error.is_some_and(|e| !e.is_finite()) {
            return Err(Trouble::request("the error of the standard is not finite")
                .with_hint("give it in percent, such as --error 0.8"));
        }
        let engine = &mut *self.engine;
        let ([from, found], why) = match since {
            Some(day) if day > found => {
                return Err(Trouble::request("the first day lies behind the last")
                    .with_hint("give --since before --until"));
            }
            Some(day) => ([day, found], "the day that was given".to_owned()),
            None => in_question(engine, standard, found)?,
        };
        let rows = engine.rows(
            "SELECT result.entry FROM used JOIN result ON result.entry = used.result
             WHERE used.standard = ?1 AND result.day >= ?2 AND result.day <= ?3 ORDER BY result.day, result.entry",
            &[standard.into(), from.into(), found.into()],
        )?;
        let mut through: BTreeMap<i64, Vec<i64>> = BTreeMap::new();
        let mut open: Vec<(i64, Vec<i64>)> = rows
            .iter()
            .filter_map(|row| Some((row[0].integer()?, Vec::new())))
            .collect();
        open.reverse();
        let mut seen = BTreeSet::new();
        while let Some((result, path)) = open.pop() {
            if !seen.insert(result) {
                continue;
            }
            let mut further = path.clone();
            further.push(result);
            through.insert(result, path);
            // Results that have a file of this one among their inputs.
            let next = engine.rows(
                "SELECT DISTINCT input.result FROM output JOIN input ON input.digest = output.digest
                 WHERE output.result = ?1 AND output.name IN ('result.json', 'calibration.json') AND input.result <> ?1",
                &[result.into()],
            )?;
            for row in next {
                if let Some(next) = row[0].integer().filter(|n| !seen.contains(n)) {
                    open.insert(0, (next, further.clone()));
                }
            }
        }
        let mut results: Vec<Recalled> = Vec::new();
        let mut paths: Vec<(i64, Vec<i64>)> = through.into_iter().collect();
        // What was a reference is judged before what rests on it.
        paths.sort_by_key(|(_, path)| path.len());
        for (result, path) in paths {
            let reference = path.last();
            let reference = results
                .iter()
                .find(|r| Some(&r.result) == reference)
                .cloned();
            results.push(recalled(
                engine,
                standard,
                result,
                path,
                error,
                reference.as_ref(),
            )?);
        }
        results.sort_by_key(|r| (r.day, r.result));
        Ok(Recall {
            standard,
            name: name_of(engine, standard)?,
            days: [from, found],
            since: why,
            error,
            results,
        })
    }
}

/// First and last day in which a standard may have been wrong, and why the first.
///
/// After a failed check: from the last good check of the same quantity before it to the first good one after it. Without one: from the last
/// good check of a sensitivity on.
fn in_question(engine: &mut dyn Engine, standard: i64, found: i64) -> Result<([i64; 2], String)> {
    let rows = engine.rows(
        "SELECT day, quantity, good FROM checked WHERE device = ?1 AND day <= ?2 ORDER BY day, entry",
        &[standard.into(), found.into()],
    )?;
    let checks: Vec<(i64, String, bool)> = rows
        .iter()
        .filter_map(|row| {
            Some((
                row[0].integer()?,
                row[1].words(),
                row[2].integer() == Some(1),
            ))
        })
        .collect();
    let failed = checks.iter().rposition(|(_, _, good)| !good);
    let (before, until, behind) = match failed {
        Some(at) => {
            let (day, quantity, _) = &checks[at];
            let good = |c: &&(i64, String, bool)| c.2 && c.1 == *quantity;
            // Several that failed in a row are one time.
            let before = checks[..at].iter().rfind(good);
            let after = checks[at..].iter().find(good).map_or(found, |c| c.0);
            (
                before,
                after,
                format!(" before the one that failed on {}", date_of(*day)),
            )
        }
        None => {
            let of_sensitivity =
                |c: &&(i64, String, bool)| c.2 && c.1.to_lowercase().starts_with('s');
            (checks.iter().rfind(of_sensitivity), found, String::new())
        }
    };
    if let Some((day, ..)) = before {
        let since = format!("its last good check{behind}, on {}", date_of(*day));
        return Ok(([*day, until], since));
    }
    let rows = engine.rows(
        "SELECT max(valid_from) FROM certificate WHERE standard = ?1 AND valid_from <= ?2",
        &[standard.into(), found.into()],
    )?;
    Ok(match rows.first().and_then(|row| row[0].integer()) {
        Some(day) => (
            [day, until],
            format!(
                "its certificate, valid from {}: no good check stands between",
                date_of(day)
            ),
        ),
        None => (
            [i64::MIN / 2, until],
            "the beginning: it has neither a good check nor a certificate".to_owned(),
        ),
    })
}

fn recalled(
    engine: &mut dyn Engine,
    standard: i64,
    result: i64,
    through: Vec<i64>,
    error: Option<f64>,
    reference: Option<&Recalled>,
) -> Result<Recalled> {
    let rows = engine.rows(
        "SELECT result.device, result.day, result.number, manufacturer, model, serial, owner_number,
                (SELECT count(*) FROM supersession WHERE old = result.entry)
         FROM result JOIN device ON device.entry = result.device WHERE result.entry = ?1",
        &[result.into()],
    )?;
    let Some(row) = rows.first() else {
        return Err(Trouble::data(format!("result {result} is gone"))
            .with_hint("`proofmass records check` lists what is damaged"));
    };
    let mut found = Recalled {
        result,
        number: row[2].text().map(str::to_owned),
        device: row[0].integer().unwrap_or_default(),
        name: crate::device::line(&row[3..7]),
        day: row[1].integer().unwrap_or_default(),
        superseded: row[7].integer() != Some(0),
        through,
        effects: Vec::new(),
        undetermined: None,
    };
    let Some(error) = error else {
        return Ok(found);
    };
    match effects(engine, standard, result, error, reference)? {
        Ok(effects) => found.effects = effects,
        Err(why) => found.undetermined = Some(why),
    }
    Ok(found)
}

/// The effect on each quantity, or why none can be told.
fn effects(
    engine: &mut dyn Engine,
    standard: i64,
    result: i64,
    error: f64,
    reference: Option<&Recalled>,
) -> Result<std::result::Result<Vec<RecalledEffect>, String>> {
    let used = engine.rows(
        "SELECT standard, certificate FROM used WHERE result = ?1",
        &[result.into()],
    )?;
    let certificate = used
        .iter()
        .find(|row| row[0].integer() == Some(standard))
        .and_then(|row| row[1].integer());
    let certificate = match certificate {
        Some(number) => match read_entry(engine, number)?.content {
            Content::Certificate(certificate) => Some(certificate),
            _ => None,
        },
        None => None,
    };
    let quantities = engine.rows(
        "SELECT name, unit, u_standard, expanded, u, value FROM quantity
         WHERE result = ?1 AND u_standard IS NOT NULL AND unit <> 'rad' ORDER BY place",
        &[result.into()],
    )?;
    if quantities.is_empty() {
        return Ok(Err(
            "its stored budget does not tell the part of the standard".to_owned(),
        ));
    }
    let mut found = Vec::new();
    for row in &quantities {
        let frequency = frequency(&row[0].words());
        let ratio = match reference {
            Some(reference) => ratio_of(reference, frequency),
            None => certificate
                .as_ref()
                .and_then(|c| c.u(frequency))
                .map(|u| error / u),
        };
        let Some(ratio) = ratio else {
            return Ok(Err(match reference {
                Some(reference) => format!(
                    "what the error does to its reference, result {}, is not determinable",
                    reference.result
                ),
                None => {
                    "the certificate that it used states no relative uncertainty here".to_owned()
                }
            }));
        };
        let effect = (ratio * row[2].real().unwrap_or_default()).abs();
        let share = |whole: Option<f64>| whole.filter(|w| *w != 0.0).map(|w| effect / w.abs());
        found.push(RecalledEffect {
            quantity: row[0].words(),
            unit: row[1].words(),
            effect,
            relative: share(row[5].real()),
            at_most: used.len() > 1,
            expanded: row[3].real(),
            ratio: share(row[4].real()),
        });
    }
    Ok(Ok(found))
}

/// Effect over u of what a reference states at a frequency; where it states none there, the largest of all, which lie within a twentieth.
fn ratio_of(reference: &Recalled, at: Option<f64>) -> Option<f64> {
    let of = |e: &RecalledEffect| e.ratio;
    let same = reference
        .effects
        .iter()
        .find(|e| at.is_some() && frequency(&e.quantity) == at);
    if let Some(same) = same {
        return of(same);
    }
    let all: Vec<f64> = reference.effects.iter().filter_map(of).collect();
    let most = all.iter().copied().reduce(f64::max)?;
    let least = all.iter().copied().reduce(f64::min)?;
    (least >= 0.95 * most).then_some(most)
}

/// Frequency in the name of a quantity, such as `S.modulus[frequency=160]`.
fn frequency(name: &str) -> Option<f64> {
    let (_, at) = name.split_once("[frequency=")?;
    at.strip_suffix(']')?.parse().ok()
}
