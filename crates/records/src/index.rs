//! What is found fast: rows that are made from the entries alone, and can be made again.

use crate::day::day_of;
use crate::due;
use crate::engine::{Engine, Value};
use crate::entry::{Content, Entry, FiledResult, spelling};
use crate::ledger::{parse, read_entry};
use crate::rests::device_of;
use crate::schema::DERIVED;
use crate::used;
use proofmass_jobs::{Result, Trouble};

/// Adds the rows of an entry.
pub(crate) fn add(engine: &mut dyn Engine, number: i64, entry: &Entry) -> Result<()> {
    let n = Value::from(number);
    match &entry.content {
        Content::Device(d) => {
            let spelled = d.serial.as_deref().map(spelling);
            engine.run(
                "INSERT INTO device (entry, manufacturer, model, serial, spelling, owner_number, axes, standard)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                &[
                    n,
                    d.manufacturer.as_deref().into(),
                    d.model.as_deref().into(),
                    d.serial.as_deref().into(),
                    spelled.as_deref().into(),
                    d.owner_number.as_deref().into(),
                    d.axes.as_deref().into(),
                    i64::from(d.standard).into(),
                ],
            )?;
        }
        Content::Certificate(c) => {
            need(engine, "device", c.standard)?;
            let until = c.valid_until.as_deref().map(day_of).transpose()?;
            engine.run(
                "INSERT INTO certificate (entry, standard, number, valid_from, valid_until, digest, u_relative)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
                &[
                    n,
                    c.standard.into(),
                    (&c.number).into(),
                    day_of(&c.valid_from)?.into(),
                    until.into(),
                    c.file.as_ref().map(|f| f.sha256.as_str()).into(),
                    c.u_relative.into(),
                ],
            )?;
            used::link(engine, number, c)?;
            due::update(engine, c.standard)?;
        }
        Content::Result(r) => result(engine, number, r)?,
        Content::Check(c) => {
            need(engine, "device", c.device)?;
            engine.run(
                "INSERT INTO checked (entry, device, day, quantity, unit, value, u, reference, u_reference, en, good)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
                &[
                    n,
                    c.device.into(),
                    day_of(&c.date)?.into(),
                    (&c.quantity).into(),
                    (&c.unit).into(),
                    c.value.into(),
                    c.u.into(),
                    c.reference.into(),
                    c.u_reference.into(),
                    c.en.into(),
                    i64::from(c.en.abs() <= 1.0).into(),
                ],
            )?;
        }
        Content::Event(e) => {
            need(engine, "device", e.device)?;
            engine.run(
                "INSERT INTO event (entry, device, day, kind, text) VALUES (?1, ?2, ?3, ?4, ?5)",
                &[
                    n,
                    e.device.into(),
                    day_of(&e.date)?.into(),
                    e.event.word().into(),
                    (&e.text).into(),
                ],
            )?;
            due::update(engine, e.device)?;
        }
        Content::Supersession(s) => {
            if !matches!(read_entry(engine, s.old)?.content, Content::Result(_)) {
                return take_back(engine, s.old);
            }
            if let Some(new) = s.new {
                need(engine, "result", new)?;
            }
            let done = engine.rows(
                "SELECT entry FROM supersession WHERE old = ?1",
                &[s.old.into()],
            )?;
            if !done.is_empty() || s.new == Some(s.old) {
                return Err(Trouble::request(format!(
                    "result {} is superseded already, or by itself",
                    s.old
                ))
                .with_hint("`proofmass records show NUMBER` says by which"));
            }
            engine.run(
                "INSERT INTO supersession (entry, old, new, reason) VALUES (?1, ?2, ?3, ?4)",
                &[n, s.old.into(), s.new.into(), (&s.reason).into()],
            )?;
            due_of_result(engine, s.old)?;
        }
        Content::Rule(r) => {
            if let Some(device) = r.device {
                need(engine, "device", device)?;
            }
            engine.run(
                "INSERT INTO rule (entry, device) VALUES (?1, ?2)",
                &[n, r.device.into()],
            )?;
            due_again(engine, r.device)?;
        }
        Content::Campaign(_) => {}
        Content::InUse(u) => {
            need(engine, "device", u.device)?;
            need(engine, "result", u.result)?;
        }
    }
    Ok(())
}

fn result(engine: &mut dyn Engine, number: i64, r: &FiledResult) -> Result<()> {
    need(engine, "device", r.device)?;
    let n = Value::from(number);
    engine.run(
        "INSERT INTO result (entry, device, kind, day, number, digest) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
        &[
            n.clone(),
            r.device.into(),
            (&r.result_kind).into(),
            day_of(&r.date)?.into(),
            r.number.as_deref().into(),
            (&r.sha256).into(),
        ],
    )?;
    for (place, q) in r.quantities.iter().enumerate() {
        engine.run(
            "INSERT INTO quantity (result, place, name, unit, value, u, expanded, k, nu, probability, u_standard)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
            &[
                n.clone(),
                (place as i64).into(),
                (&q.name).into(),
                (&q.unit).into(),
                q.value.into(),
                q.u.into(),
                q.expanded.into(),
                q.k.into(),
                q.nu.into(),
                q.probability.into(),
                q.u_standard.into(),
            ],
        )?;
    }
    for used in &r.uses {
        engine.run(
            "INSERT INTO used (result, standard, certificate) VALUES (?1, ?2, ?3)",
            &[n.clone(), used.standard.into(), used.certificate.into()],
        )?;
    }
    for (place, file) in r.inputs.iter().enumerate() {
        engine.run(
            "INSERT INTO input (result, place, path, digest) VALUES (?1, ?2, ?3, ?4)",
            &[
                n.clone(),
                (place as i64).into(),
                (&file.name).into(),
                (&file.sha256).into(),
            ],
        )?;
    }
    for file in &r.files {
        engine.run(
            "INSERT INTO output (result, name, digest) VALUES (?1, ?2, ?3)",
            &[n.clone(), (&file.name).into(), (&file.sha256).into()],
        )?;
    }
    due::update(engine, r.device)
}

/// Takes the rows of an entry that no longer counts out of the index.
fn take_back(engine: &mut dyn Engine, number: i64) -> Result<()> {
    let gone = |engine: &mut dyn Engine, table: &str| -> Result<()> {
        let statement = format!("DELETE FROM {table} WHERE entry = ?1");
        match engine.run(&statement, &[number.into()])? {
            0 => Err(
                Trouble::request(format!("entry {number} counts no longer already"))
                    .with_hint("nothing is to be done"),
            ),
            _ => Ok(()),
        }
    };
    match read_entry(engine, number)?.content {
        Content::Check(_) => gone(engine, "checked"),
        Content::Event(e) => {
            gone(engine, "event")?;
            due::update(engine, e.device)
        }
        Content::Supersession(s) => {
            gone(engine, "supersession")?;
            due_of_result(engine, s.old)
        }
        Content::Certificate(c) => {
            let results = used::unlink(engine, number)?;
            gone(engine, "certificate")?;
            used::link_again(engine, c.standard, &results)?;
            due::update(engine, c.standard)
        }
        Content::Rule(r) => {
            gone(engine, "rule")?;
            due_again(engine, r.device)
        }
        _ => Ok(()),
    }
}

/// Finds anew when the device of a result is due.
fn due_of_result(engine: &mut dyn Engine, result: i64) -> Result<()> {
    match device_of(engine, result)? {
        Some(device) => due::update(engine, device),
        None => Ok(()),
    }
}

/// Finds anew when a device is due, or every device for `None`.
fn due_again(engine: &mut dyn Engine, device: Option<i64>) -> Result<()> {
    if let Some(device) = device {
        return due::update(engine, device);
    }
    let devices = engine.rows(
        "SELECT device FROM result UNION SELECT standard FROM certificate",
        &[],
    )?;
    for device in devices.iter().filter_map(|row| row[0].integer()) {
        due::update(engine, device)?;
    }
    Ok(())
}

/// Refuses an entry that names what is not there.
fn need(engine: &mut dyn Engine, table: &str, number: i64) -> Result<()> {
    let rows = engine.rows(
        &format!("SELECT entry FROM {table} WHERE entry = ?1"),
        &[number.into()],
    )?;
    match rows.is_empty() {
        true => Err(Trouble::request(format!("there is no {table} {number}"))
            .with_hint("`proofmass records list` has the numbers")),
        false => Ok(()),
    }
}

/// Makes every row of the index anew.
pub(crate) fn rebuild(engine: &mut dyn Engine) -> Result<()> {
    for table in DERIVED.iter().rev() {
        engine.run(&format!("DELETE FROM {table}"), &[])?;
    }
    let rows = engine.rows("SELECT number, body FROM entry ORDER BY number", &[])?;
    for row in rows {
        let number = row[0].integer().unwrap_or_default();
        add(engine, number, &parse(number, &row[1].words())?)?;
    }
    Ok(())
}
