//! Forward: what rests on a standard.

use crate::day::as_date;
use crate::day::date_of;
use crate::engine::Engine;
use crate::entry::Content;
use crate::filing::name_of;
use crate::ledger::{Records, read_entry};
use crate::rests::resting_on;
use crate::schema::CALIBRATIONS;
use proofmass_documents::at_frequency;
use proofmass_jobs::{Result, Trouble};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Share by which two statements of one uncertainty may differ, for rounding.
const SLACK: f64 = 0.05;

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
    /// What the failed check found, measured over known value, less one.
    pub found: Option<f64>,
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
    /// What the stated value is wrong by (stated less true), in the unit; of other quantities than sensitivities the size.
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
    /// Relative standard uncertainty that was stated.
    #[serde(skip)]
    u: Option<f64>,
}

impl Records {
    /// What used a standard while it may have been wrong, as of the day `found`, directly or through results that were the reference of others:
    /// where a check failed, from the last good one of the same quantity before it to the first good one after it; else since the last good
    /// check of a sensitivity, or the certificate. `error` is the relative error of the standard.
    ///
    /// The error is that of the sensitivity of the standard: measured over certificate, less one. What was found with it is wrong by the
    /// other sign: a sensitivity by −error.
    ///
    /// The effect on a quantity is error/u · c, with the relative standard uncertainty u of the certificate that was used, or of the own
    /// result of the standard, and the part c of the uncertainty that the stored budget gives to the reference: the sensitivity of the
    /// result to the standard. Where c of a sensitivity is another share of it than u, the budget rests on another certificate than the
    /// one that is filed, and nothing is stated. A relative error turns no phase. Where the result was the reference of another, its own
    /// effect over its u takes the place of error/u there.
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
        let ([from, found], why, error_found) = match since {
            Some(day) if day > found => {
                return Err(Trouble::request("the first day lies behind the last")
                    .with_hint("give --since before --until"));
            }
            Some(day) => ([day, found], "the day that was given".to_owned(), None),
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
            for next in resting_on(engine, result)? {
                if !seen.contains(&next) {
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
            found: error_found,
            results,
        })
    }
}

/// First and last day in which a standard may have been wrong, and why the first.
///
/// After a failed check: from the last good check of the same quantity before it to the first good one after it. Without one: from the last
/// good check of a sensitivity on.
fn in_question(
    engine: &mut dyn Engine,
    standard: i64,
    found: i64,
) -> Result<([i64; 2], String, Option<f64>)> {
    let rows = engine.rows(
        "SELECT day, quantity, good, value, reference FROM checked WHERE device = ?1 AND day <= ?2 ORDER BY day, entry",
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
    let error = failed.and_then(|at| {
        let (value, reference) = (rows[at][3].real()?, rows[at][4].real()?);
        Some(value / reference - 1.0).filter(|e| e.is_finite())
    });
    let earlier = failed.map_or(0, |at| checks[..at].iter().filter(|c| !c.2).count());
    let (before, until, behind) = match failed {
        Some(at) => {
            let (day, quantity, _) = &checks[at];
            let good = |c: &&(i64, String, bool)| c.2 && c.1 == *quantity;
            // Several that failed in a row are one time.
            let before = checks[..at].iter().rfind(good);
            let after = checks[at..].iter().find(good).map_or(found, |c| c.0);
            let others = match earlier {
                0 => String::new(),
                n => format!(" (the last of {}; --until names an earlier day)", n + 1),
            };
            (
                before,
                after,
                format!(" before the one that failed on {}{others}", date_of(*day)),
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
        return Ok(([*day, until], since, error));
    }
    let rows = engine.rows(
        "SELECT entry, valid_from FROM certificate WHERE standard = ?1 AND valid_from <= ?2 ORDER BY valid_from DESC, entry DESC LIMIT 1",
        &[standard.into(), found.into()],
    )?;
    if let Some(row) = rows.first() {
        let valid = row[1].integer().unwrap_or_default();
        // A result may have read its table before it was valid.
        let first = engine.rows(
            "SELECT min(day) FROM used JOIN result ON result.entry = used.result WHERE certificate = ?1",
            &[row[0].clone()],
        )?;
        let first = first.first().and_then(|row| row[0].integer());
        let why = format!(
            "its certificate, valid from {}: no good check stands between",
            date_of(valid)
        );
        return Ok(([first.unwrap_or(valid).min(valid), until], why, error));
    }
    let rows = engine.rows(
        &format!("SELECT max(day) FROM {CALIBRATIONS} WHERE device = ?1 AND day <= ?2"),
        &[standard.into(), found.into()],
    )?;
    Ok(match rows.first().and_then(|row| row[0].integer()) {
        Some(day) => {
            let why = format!(
                "its calibration on {}: no good check stands between",
                date_of(day)
            );
            ([day, until], why, error)
        }
        None => (
            [i64::MIN / 2, until],
            "the beginning: it has neither a good check nor a certificate nor a calibration here"
                .to_owned(),
            error,
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
    let own = match certificate {
        Some(_) => Vec::new(),
        None => of_standard(engine, standard, result)?,
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
        // Effect over u, and u, of the sensitivity of the reference.
        let behind = match reference {
            Some(reference) => at(&reference.effects, frequency, |e| e.ratio.zip(e.u)),
            None => match &certificate {
                Some(c) => c.u(frequency),
                None => at(&own, frequency, |p| Some((p.1, p.1))).map(|p| p.1),
            }
            .map(|u| (-error / u, u)),
        };
        let Some((ratio, u)) = behind else {
            return Ok(Err(match reference {
                Some(reference) => format!(
                    "what the error does to its reference, result {}, is not determinable",
                    reference.result
                ),
                None => "neither certificate nor result of the standard states a relative uncertainty here".to_owned(),
            }));
        };
        let value = row[5].real().unwrap_or_default();
        let of_sensitivity = row[0].words().starts_with("S.");
        let share = row[2].real().unwrap_or_default() / value.abs();
        let least = if used.len() > 1 {
            f64::INFINITY
        } else {
            1.0 + SLACK
        };
        if of_sensitivity && value != 0.0 && !((1.0 - SLACK) * u..=least * u).contains(&share) {
            return Ok(Err(format!(
                "its budget has u = {:.3} % for the reference in {}, what is filed of the standard {:.3} %: it rests on another certificate",
                1e2 * share,
                row[0].words(),
                1e2 * u
            )));
        }
        let effect = ratio * row[2].real().unwrap_or_default();
        let effect = if of_sensitivity { effect } else { effect.abs() };
        let share = |whole: Option<f64>| whole.filter(|w| *w != 0.0).map(|w| effect / w.abs());
        found.push(RecalledEffect {
            quantity: row[0].words(),
            unit: row[1].words(),
            effect,
            relative: share(row[5].real()),
            at_most: used.len() > 1,
            expanded: row[3].real(),
            ratio: share(row[4].real()),
            u: row[4]
                .real()
                .filter(|_| value != 0.0)
                .map(|u| u / value.abs()),
        });
    }
    Ok(Ok(found))
}

/// What is known of a quantity: its name and a number.
trait Named {
    fn name(&self) -> &str;
}

impl Named for RecalledEffect {
    fn name(&self) -> &str {
        &self.quantity
    }
}

impl Named for (String, f64) {
    fn name(&self) -> &str {
        &self.0
    }
}

/// The pair that belongs to a frequency; where there is none, the one of the largest size where all lie within a twentieth.
fn at<T: Named>(
    all: &[T],
    frequency_of: Option<f64>,
    pair: impl Fn(&T) -> Option<(f64, f64)>,
) -> Option<(f64, f64)> {
    let same = all
        .iter()
        .find(|e| frequency_of.is_some() && frequency(e.name()) == frequency_of);
    if let Some(same) = same {
        return pair(same);
    }
    let pairs: Vec<(f64, f64)> = all.iter().filter_map(&pair).collect();
    let most = pairs
        .iter()
        .copied()
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let alike = |p: &(f64, f64)| p.0.abs() >= (1.0 - SLACK) * most.0.abs();
    pairs.iter().all(alike).then_some(most)
}

/// Relative standard uncertainties of the sensitivities that a result of the standard states, whose file an input is.
fn of_standard(engine: &mut dyn Engine, standard: i64, result: i64) -> Result<Vec<(String, f64)>> {
    let rows = engine.rows(
        "SELECT DISTINCT quantity.name, u, value FROM input JOIN output ON output.digest = input.digest
         JOIN result ON result.entry = output.result JOIN quantity ON quantity.result = result.entry
         WHERE input.result = ?1 AND result.device = ?2 AND u IS NOT NULL AND value <> 0",
        &[result.into(), standard.into()],
    )?;
    let relative = rows.iter().filter_map(|row| {
        let name = row[0].words();
        let is_modulus = name.starts_with("S.") && name.contains("modulus");
        Some((name, row[1].real()? / row[2].real()?.abs())).filter(|_| is_modulus)
    });
    Ok(relative.collect())
}

/// Frequency in the name of a quantity.
fn frequency(name: &str) -> Option<f64> {
    Some(at_frequency(name)?.1)
}
