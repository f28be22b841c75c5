//! The standards behind a result: found by the digests of its inputs, or named; and what is to be doubted about them.

use crate::candidate::Candidate;
use crate::day::{date_of, day_of};
use crate::engine::Engine;
use crate::entry::{FiledCertificate, UsedStandard};
use crate::filing::name_of;
use proofmass_jobs::Result;
use proofmass_jobs::findings::filing as findings;
use proofmass_uncertainty::Finding;

/// Standards behind a result: those that are named, and those of whose certificates or results an input is the file.
pub(crate) fn of(
    engine: &mut dyn Engine,
    c: &Candidate,
    named: &[i64],
    day: i64,
) -> Result<Vec<UsedStandard>> {
    let mut uses: Vec<UsedStandard> = Vec::new();
    let mut add = |used: UsedStandard| {
        if !uses.iter().any(|u| u.standard == used.standard) {
            uses.push(used);
        }
    };
    for (_, digest, _) in &c.inputs {
        let rows = engine.rows(
            "SELECT standard, entry FROM certificate WHERE digest = ?1 ORDER BY valid_from DESC LIMIT 1",
            &[digest.into()],
        )?;
        for row in rows {
            add(UsedStandard {
                standard: row[0].integer().unwrap_or_default(),
                certificate: row[1].integer(),
            });
        }
        // A result that was calibrated here and is the reference of this one.
        let rows = engine.rows(
            "SELECT result.device FROM output JOIN result ON result.entry = output.result
             JOIN device ON device.entry = result.device WHERE output.digest = ?1 AND device.standard = 1 LIMIT 1",
            &[digest.into()],
        )?;
        if let Some(standard) = rows.first().and_then(|row| row[0].integer()) {
            let certificate = certificate_on(engine, standard, day)?;
            add(UsedStandard {
                standard,
                certificate,
            });
        }
    }
    for standard in named {
        let certificate = certificate_on(engine, *standard, day)?;
        add(UsedStandard {
            standard: *standard,
            certificate,
        });
    }
    Ok(uses)
}

/// The certificate of a standard on a day: the last one that was valid from then or before.
fn certificate_on(engine: &mut dyn Engine, standard: i64, day: i64) -> Result<Option<i64>> {
    let rows = engine.rows(
        "SELECT entry FROM certificate WHERE standard = ?1 AND valid_from <= ?2 ORDER BY valid_from DESC, entry DESC LIMIT 1",
        &[standard.into(), day.into()],
    )?;
    Ok(rows.first().and_then(|row| row[0].integer()))
}

/// What is to be doubted about a standard on the day of its use.
pub(crate) fn doubts(
    engine: &mut dyn Engine,
    used: &UsedStandard,
    day: i64,
) -> Result<Vec<Finding>> {
    let mut doubts = Vec::new();
    if let Some(certificate) = used.certificate {
        doubts.extend(not_valid(engine, certificate, used.standard, day)?);
    }
    if is_withdrawn(engine, used.standard, day)? {
        let name = name_of(engine, used.standard)?;
        doubts.push(findings::device_withdrawn(&name));
    }
    let rows = engine.rows(
        "SELECT day, en, good FROM checked WHERE device = ?1 AND day <= ?2 ORDER BY day DESC, entry DESC LIMIT 1",
        &[used.standard.into(), day.into()],
    )?;
    if let Some(row) = rows.first().filter(|row| row[2].integer() == Some(0)) {
        let checked = date_of(row[0].integer().unwrap_or_default());
        doubts.push(findings::standard_in_question(
            &name_of(engine, used.standard)?,
            &checked,
            row[1].real().unwrap_or_default(),
        ));
    }
    Ok(doubts)
}

/// Whether a device was out of use on a day.
pub(crate) fn is_withdrawn(engine: &mut dyn Engine, device: i64, day: i64) -> Result<bool> {
    let rows = engine.rows(
        "SELECT kind FROM event WHERE device = ?1 AND day <= ?2 AND kind IN ('withdrawal', 'return') ORDER BY day DESC, entry DESC LIMIT 1",
        &[device.into(), day.into()],
    )?;
    let last = rows.first().and_then(|row| row[0].text());
    Ok(last == Some("withdrawal"))
}

/// A certificate that was not valid on the day of its use.
fn not_valid(
    engine: &mut dyn Engine,
    certificate: i64,
    standard: i64,
    day: i64,
) -> Result<Option<Finding>> {
    let rows = engine.rows(
        "SELECT number, valid_from, valid_until FROM certificate WHERE entry = ?1",
        &[certificate.into()],
    )?;
    let Some(row) = rows.first() else {
        return Ok(None);
    };
    let from = row[1].integer().unwrap_or(i64::MIN);
    let until = row[2].integer();
    if day >= from && until.is_none_or(|until| day <= until) {
        return Ok(None);
    }
    Ok(Some(findings::certificate_not_valid(
        &name_of(engine, standard)?,
        &row[0].words(),
        &date_of(from),
        &until.map_or_else(|| "no stated end".to_owned(), date_of),
        &date_of(day),
    )))
}

/// Results among the inputs that no longer count.
pub(crate) fn superseded(engine: &mut dyn Engine, c: &Candidate) -> Result<Vec<Finding>> {
    let mut doubts = Vec::new();
    for (path, digest, _) in &c.inputs {
        let rows = engine.rows(
            "SELECT old, reason FROM output JOIN supersession ON supersession.old = output.result WHERE digest = ?1 ORDER BY old",
            &[digest.into()],
        )?;
        // The same file may stand in the result that took its place.
        let counts = engine.rows(
            "SELECT result FROM output WHERE digest = ?1 AND result NOT IN (SELECT old FROM supersession) LIMIT 1",
            &[digest.into()],
        )?;
        if let Some(row) = rows.first().filter(|_| counts.is_empty()) {
            let old = row[0].integer().unwrap_or_default();
            doubts.push(findings::input_superseded(
                path,
                &old.to_string(),
                &row[1].words(),
            ));
        }
    }
    Ok(doubts)
}

/// Brings a certificate that is filed late to the results before it: those of whose inputs one is its file, and those that named its
/// standard on a day from which on it is the last one.
pub(crate) fn link(engine: &mut dyn Engine, certificate: i64, c: &FiledCertificate) -> Result<()> {
    let from = day_of(&c.valid_from)?;
    engine.run(
        "UPDATE used SET certificate = ?1 WHERE standard = ?2
         AND (certificate IS NULL OR certificate IN (SELECT entry FROM certificate WHERE standard = ?2 AND valid_from <= ?3))
         AND result IN (SELECT entry FROM result WHERE day >= ?3)
         AND NOT EXISTS (SELECT 1 FROM input JOIN certificate AS own ON own.digest = input.digest
                         WHERE input.result = used.result AND own.standard = ?2)",
        &[certificate.into(), c.standard.into(), from.into()],
    )?;
    let Some(file) = &c.file else {
        return Ok(());
    };
    engine.run(
        "UPDATE used SET certificate = ?1 WHERE standard = ?2 AND result IN (SELECT result FROM input WHERE digest = ?3)
         AND (certificate IS NULL OR certificate NOT IN (SELECT entry FROM certificate WHERE digest = ?3 AND valid_from > ?4))",
        &[certificate.into(), c.standard.into(), (&file.sha256).into(), from.into()],
    )?;
    engine.run(
        "INSERT INTO used (result, standard, certificate)
         SELECT DISTINCT input.result, CAST(?2 AS BIGINT), CAST(?1 AS BIGINT) FROM input WHERE digest = ?3
         AND NOT EXISTS (SELECT 1 FROM used WHERE used.result = input.result AND used.standard = ?2)",
        &[certificate.into(), c.standard.into(), (&file.sha256).into()],
    )?;
    Ok(())
}

/// Takes a certificate from the results that it stands behind, and gives these.
pub(crate) fn unlink(engine: &mut dyn Engine, certificate: i64) -> Result<Vec<i64>> {
    let rows = engine.rows(
        "SELECT result FROM used WHERE certificate = ?1 ORDER BY result",
        &[certificate.into()],
    )?;
    engine.run(
        "UPDATE used SET certificate = NULL WHERE certificate = ?1",
        &[certificate.into()],
    )?;
    Ok(rows.iter().filter_map(|row| row[0].integer()).collect())
}

/// Brings the last certificate of a standard to results that lost theirs.
pub(crate) fn link_again(engine: &mut dyn Engine, standard: i64, results: &[i64]) -> Result<()> {
    for result in results {
        let day = engine.rows(
            "SELECT day FROM result WHERE entry = ?1",
            &[(*result).into()],
        )?;
        let Some(day) = day.first().and_then(|row| row[0].integer()) else {
            continue;
        };
        if let Some(certificate) = certificate_on(engine, standard, day)? {
            engine.run(
                "UPDATE used SET certificate = ?1 WHERE result = ?2 AND standard = ?3",
                &[certificate.into(), (*result).into(), standard.into()],
            )?;
        }
    }
    Ok(())
}

/// What is to be doubted about the results that a certificate was just brought to.
pub(crate) fn doubts_behind(
    engine: &mut dyn Engine,
    certificate: i64,
    c: &FiledCertificate,
) -> Result<Vec<Finding>> {
    let rows = engine.rows(
        "SELECT DISTINCT result.day FROM used JOIN result ON result.entry = used.result WHERE used.certificate = ?1 ORDER BY result.day",
        &[certificate.into()],
    )?;
    let mut doubts = Vec::new();
    for day in rows.iter().filter_map(|row| row[0].integer()) {
        doubts.extend(not_valid(engine, certificate, c.standard, day)?);
    }
    Ok(doubts)
}
