//! Backward: what a result or a device rests on, down to the recordings.

use crate::engine::Engine;
use crate::ledger::Records;
use crate::schema::CALIBRATIONS;
use proofmass_jobs::Result;
use serde::Serialize;
use std::collections::BTreeSet;

/// A file or certificate that something rests on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Rest {
    /// How many results lie between: 0 for an input of the result itself.
    pub depth: usize,
    /// The result that names it.
    pub result: i64,
    /// Path as the result names it, or number and standard of a certificate.
    pub name: String,
    /// SHA-256, empty for a certificate without a file.
    pub sha256: String,
    /// Whether its bytes are kept here.
    pub kept: bool,
    /// The result here whose file it is.
    pub from: Option<i64>,
}

impl Records {
    /// Everything behind a result: its inputs, and behind those that are files of other results here, theirs; and the certificates.
    ///
    /// # Errors
    /// The database refuses.
    pub fn rests_on(&mut self, result: i64) -> Result<Vec<Rest>> {
        let mut found = Vec::new();
        let mut seen = BTreeSet::new();
        collect(&mut *self.engine, result, 0, &mut seen, &mut found)?;
        Ok(found)
    }

    /// The results of a device that count, the newest first; certificates made of them are left out.
    ///
    /// # Errors
    /// The database refuses.
    pub fn results_of(&mut self, device: i64) -> Result<Vec<i64>> {
        let rows = self.engine.rows(
            &format!(
                "SELECT entry FROM {CALIBRATIONS} WHERE device = ?1 ORDER BY day DESC, entry DESC"
            ),
            &[device.into()],
        )?;
        Ok(rows.iter().filter_map(|row| row[0].integer()).collect())
    }

    /// What took the place of a result: the new one and the reason.
    ///
    /// # Errors
    /// The database refuses.
    pub fn superseded(&mut self, result: i64) -> Result<Option<(Option<i64>, String)>> {
        superseded(&mut *self.engine, result)
    }
}

/// What took the place of a result: the new one and the reason.
pub(crate) fn superseded(
    engine: &mut dyn Engine,
    result: i64,
) -> Result<Option<(Option<i64>, String)>> {
    let rows = engine.rows(
        "SELECT new, reason FROM supersession WHERE old = ?1",
        &[result.into()],
    )?;
    Ok(rows.first().map(|row| (row[0].integer(), row[1].words())))
}

/// Results that have a file of this one among their inputs, in their order.
pub(crate) fn resting_on(engine: &mut dyn Engine, result: i64) -> Result<Vec<i64>> {
    let rows = engine.rows(
        "SELECT DISTINCT input.result FROM output JOIN input ON input.digest = output.digest
         WHERE output.result = ?1 AND output.name IN ('result.json', 'calibration.json') AND input.result <> ?1 ORDER BY input.result",
        &[result.into()],
    )?;
    Ok(rows.iter().filter_map(|row| row[0].integer()).collect())
}

/// The device of a result, `None` where there is no such result.
pub(crate) fn device_of(engine: &mut dyn Engine, result: i64) -> Result<Option<i64>> {
    let rows = engine.rows(
        "SELECT device FROM result WHERE entry = ?1",
        &[result.into()],
    )?;
    Ok(rows.first().and_then(|row| row[0].integer()))
}

fn collect(
    engine: &mut dyn Engine,
    result: i64,
    depth: usize,
    seen: &mut BTreeSet<i64>,
    found: &mut Vec<Rest>,
) -> Result<()> {
    if !seen.insert(result) {
        return Ok(());
    }
    let inputs = engine.rows(
        "SELECT input.path, input.digest, (SELECT count(*) FROM file WHERE file.digest = input.digest),
                (SELECT min(output.result) FROM output WHERE output.digest = input.digest AND output.result <> ?1)
         FROM input WHERE input.result = ?1 ORDER BY place",
        &[result.into()],
    )?;
    let mut further = Vec::new();
    for row in &inputs {
        let from = row[3].integer();
        further.extend(from);
        found.push(Rest {
            depth,
            result,
            name: row[0].words(),
            sha256: row[1].words(),
            kept: row[2].integer() == Some(1),
            from,
        });
    }
    let certificates = engine.rows(
        "SELECT certificate.number, certificate.digest, manufacturer, model, serial, owner_number
         FROM used JOIN certificate ON certificate.entry = used.certificate JOIN device ON device.entry = used.standard
         WHERE used.result = ?1 ORDER BY used.standard",
        &[result.into()],
    )?;
    for row in &certificates {
        let sha256 = row[1].words();
        found.push(Rest {
            depth,
            result,
            name: format!(
                "certificate {} of {}",
                row[0].words(),
                crate::device::line(&row[2..6])
            ),
            kept: !sha256.is_empty(),
            sha256,
            from: None,
        });
    }
    for from in further {
        collect(engine, from, depth + 1, seen, found)?;
    }
    Ok(())
}
