//! The records as files: tables, JSON, and a folder from which the same records are made.

use crate::day::date_of;
use crate::engine::Value;
use crate::entry::link;
use crate::files;
use crate::ledger::{Records, append_body, parse};
use proofmass_io::formats::write::{TableCells, TableColumn, parquet_table};
use proofmass_io::{Cell, Table};
use proofmass_jobs::{Result, Sink, Trouble, TroubleKind};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the file with the entries in an exported folder.
const ENTRIES: &str = "entries.jsonl";
/// Name of the file with the names of people.
const PEOPLE: &str = "people.jsonl";

/// An entry as it stands in a folder.
#[derive(Serialize, Deserialize)]
struct Line {
    number: i64,
    digest: String,
    body: String,
}

/// A person as it stands in a folder.
#[derive(Serialize, Deserialize)]
struct Person {
    digest: String,
    salt: String,
    name: String,
}

/// Kind of a column of an export.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Text.
    Text,
    /// A whole number, or the number of an entry.
    Integer,
    /// A number.
    Number,
    /// A day.
    Date,
}

/// Kind of each column by its heading; what is not here is text.
const KINDS: [(&[&str], Kind); 3] = [
    (
        &[
            "device",
            "standard",
            "certificate",
            "result",
            "check",
            "event",
            "counts",
            "superseded_by",
            "good",
        ],
        Kind::Integer,
    ),
    (
        &[
            "u_relative",
            "value",
            "u",
            "U",
            "k",
            "nu",
            "probability",
            "u_standard",
            "reference",
            "u_reference",
            "en",
        ],
        Kind::Number,
    ),
    (
        &["date", "due_date", "valid_from_date", "valid_until_date"],
        Kind::Date,
    ),
];

fn kind(heading: &str) -> Kind {
    let found = KINDS.iter().find(|(names, _)| names.contains(&heading));
    found.map_or(Kind::Text, |(_, kind)| *kind)
}

/// A table of an export: its name, its columns, and the question behind it.
const TABLES: [(&str, &[&str], &str); 7] = [
    (
        "devices",
        &["device", "manufacturer", "model", "serial", "owner_number", "axes", "standard", "due_date", "evidence"],
        "SELECT device.entry, manufacturer, model, serial, owner_number, axes, standard, due.day, due.evidence
         FROM device LEFT JOIN due ON due.device = device.entry ORDER BY device.entry",
    ),
    (
        "certificates",
        &["certificate", "standard", "number", "valid_from_date", "valid_until_date", "u_relative", "sha256"],
        "SELECT entry, standard, number, valid_from, valid_until, u_relative, digest FROM certificate ORDER BY entry",
    ),
    (
        "results",
        &["result", "device", "kind", "date", "number", "sha256", "counts", "superseded_by", "reason"],
        "SELECT result.entry, result.device, kind, day, number, digest, CAST(CASE WHEN old IS NULL THEN 1 ELSE 0 END AS BIGINT), new, reason
         FROM result LEFT JOIN supersession ON supersession.old = result.entry ORDER BY result.entry",
    ),
    (
        "quantities",
        &["result", "quantity", "unit", "value", "u", "U", "k", "nu", "probability", "u_standard"],
        "SELECT result, name, unit, value, u, expanded, k, nu, probability, u_standard FROM quantity ORDER BY result, place",
    ),
    (
        "used",
        &["result", "standard", "certificate"],
        "SELECT result, standard, certificate FROM used ORDER BY result, standard",
    ),
    (
        "checks",
        &["check", "device", "date", "quantity", "unit", "value", "u", "reference", "u_reference", "en", "good"],
        "SELECT entry, device, day, quantity, unit, value, u, reference, u_reference, en, good FROM checked ORDER BY entry",
    ),
    (
        "events",
        &["event", "device", "date", "kind", "text"],
        "SELECT entry, device, day, kind, text FROM event ORDER BY entry",
    ),
];

impl Records {
    /// Writes every table as CSV. Text that a spreadsheet would take for a formula is harmless.
    ///
    /// # Errors
    /// The database or the place refuses.
    pub fn export_csv(&mut self, sink: &dyn Sink) -> Result<()> {
        for (name, headings, question) in TABLES {
            let mut table = Table::new(headings.iter().copied());
            for row in self.engine.rows(question, &[])? {
                let cells = row
                    .iter()
                    .zip(headings)
                    .map(|(value, heading)| match value {
                        Value::Integer(day) if kind(heading) == Kind::Date => {
                            Cell::Text(date_of(*day))
                        }
                        Value::Integer(value) => Cell::Text(value.to_string()),
                        Value::Real(value) => Cell::Number(*value),
                        Value::Text(text) => Cell::Text(text.clone()),
                        _ => Cell::Missing,
                    });
                table.push(cells)?;
            }
            sink.write(&format!("{name}.csv"), table.to_csv()?)?;
        }
        Ok(())
    }

    /// Writes every table as Parquet: texts, whole numbers, numbers and dates as what they are.
    ///
    /// # Errors
    /// The database or the place refuses; this build does not write Parquet.
    pub fn export_parquet(&mut self, sink: &dyn Sink) -> Result<()> {
        for (name, headings, question) in TABLES {
            let rows = self.engine.rows(question, &[])?;
            let columns = headings.iter().enumerate().map(|(i, heading)| {
                let column = rows.iter().map(|row| &row[i]);
                TableColumn {
                    name: (*heading).to_owned(),
                    cells: match kind(heading) {
                        Kind::Text => {
                            TableCells::Text(column.map(|v| v.text().map(str::to_owned)).collect())
                        }
                        Kind::Integer => TableCells::Integer(column.map(Value::integer).collect()),
                        Kind::Number => TableCells::Number(column.map(Value::real).collect()),
                        Kind::Date => {
                            let day = |v: &Value| v.integer().and_then(|d| i32::try_from(d).ok());
                            TableCells::Date(column.map(day).collect())
                        }
                    },
                }
            });
            let columns: Vec<TableColumn> = columns.collect();
            let bytes = parquet_table(&columns).map_err(|e| {
                let refused = Trouble::new(TroubleKind::Output, e.to_string());
                match e.hint() {
                    Some(hint) => refused.with_hint(hint),
                    None => refused,
                }
            })?;
            sink.write(&format!("{name}.parquet"), bytes)?;
        }
        Ok(())
    }

    /// Every entry as JSON, with its number and digest.
    ///
    /// # Errors
    /// The database refuses, or an entry is damaged.
    pub fn export_json(&mut self) -> Result<Vec<u8>> {
        let rows = self.engine.rows(
            "SELECT number, body, digest FROM entry ORDER BY number",
            &[],
        )?;
        let entry = |row: &Vec<Value>| -> Result<serde_json::Value> {
            let number = row[0].integer().unwrap_or_default();
            let body: serde_json::Value = serde_json::from_str(&row[1].words())
                .map_err(|e| Trouble::data(format!("entry {number} is damaged: {e}")))?;
            Ok(serde_json::json!({ "number": number, "digest": row[2].words(), "entry": body }))
        };
        let all = rows.iter().map(entry).collect::<Result<Vec<_>>>()?;
        serde_json::to_vec_pretty(&all)
            .map_err(|e| Trouble::new(TroubleKind::Output, e.to_string()))
    }

    /// Writes everything: the entries with their chain, the names of people and every kept file by its digest.
    ///
    /// # Errors
    /// The database or the place refuses, a file is damaged.
    pub fn export_folder(&mut self, sink: &dyn Sink) -> Result<()> {
        let mut text = String::new();
        for row in self.engine.rows(
            "SELECT number, digest, body FROM entry ORDER BY number",
            &[],
        )? {
            let line = Line {
                number: row[0].integer().unwrap_or_default(),
                digest: row[1].words(),
                body: row[2].words(),
            };
            text += &json(&line)?;
        }
        sink.write(ENTRIES, text.into_bytes())?;
        let mut text = String::new();
        for row in self
            .engine
            .rows("SELECT digest, salt, name FROM person ORDER BY digest", &[])?
        {
            let [digest, salt, name] = [0, 1, 2].map(|i: usize| row[i].words());
            text += &json(&Person { digest, salt, name })?;
        }
        sink.write(PEOPLE, text.into_bytes())?;
        for row in self
            .engine
            .rows("SELECT digest FROM file ORDER BY digest", &[])?
        {
            let digest = row[0].words();
            if let Some(bytes) = self.file(&digest)? {
                sink.write(&digest, bytes)?;
            }
        }
        Ok(())
    }

    /// Makes the same records from an exported folder; these must be empty. All of it or nothing.
    ///
    /// # Errors
    /// The folder is no export, or its chain or a file is not what was exported; these records are not empty.
    pub fn import_folder(&mut self, folder: &Path) -> Result<u64> {
        if !self
            .engine
            .rows("SELECT number FROM entry LIMIT 1", &[])?
            .is_empty()
        {
            return Err(Trouble::request(
                "these records are not empty: an exported folder becomes new records",
            )
            .with_hint("name a file that is not there yet with --records"));
        }
        let text = |name: &str| {
            let place = folder.join(name);
            std::fs::read_to_string(&place).map_err(|e| {
                Trouble::data(format!("{}: {e}", place.display()))
                    .with_hint("name a folder that `proofmass records export --folder` wrote")
            })
        };
        let (entries, people) = (text(ENTRIES)?, text(PEOPLE)?);
        let changed = |what: &str| {
            Trouble::data(format!("{what} is not what was exported"))
                .with_hint("fetch the folder again from where it was written")
        };
        self.writing(|engine, beside| {
            for line in people.lines() {
                let person: Person = serde_json::from_str(line).map_err(|_| changed(PEOPLE))?;
                engine.run(
                    "INSERT INTO person (digest, salt, name) VALUES (?1, ?2, ?3)",
                    &[
                        (&person.digest).into(),
                        (&person.salt).into(),
                        (&person.name).into(),
                    ],
                )?;
            }
            for found in std::fs::read_dir(folder)
                .map_err(|e| files::refused(folder, &e))?
                .flatten()
            {
                let name = found.file_name().to_string_lossy().into_owned();
                if name.len() != 64 {
                    continue;
                }
                let bytes = crate::candidate::bytes_of(&found.path())?;
                if crate::entry::sha256(&[&bytes]) != name {
                    return Err(changed(&name));
                }
                crate::ledger::keep(engine, beside, &name, &bytes)?;
            }
            let known = engine.rows("SELECT digest FROM file", &[])?;
            let known: std::collections::HashSet<String> =
                known.iter().map(|row| row[0].words()).collect();
            let mut previous = String::new();
            let mut count = 0;
            for line in entries.lines() {
                let line: Line = serde_json::from_str(line).map_err(|_| changed(ENTRIES))?;
                if link(line.number, &line.body, &previous) != line.digest {
                    return Err(changed(&format!("entry {}", line.number)));
                }
                let entry = parse(line.number, &line.body)?;
                if let Some(lost) = entry.content.kept().find(|f| !known.contains(&f.sha256)) {
                    return Err(Trouble::data(format!(
                        "{} of the entry {} is not in {}",
                        lost.name,
                        line.number,
                        folder.display()
                    ))
                    .with_hint("fetch the folder again, whole, from where it was written"));
                }
                append_body(engine, &line.body, &entry)?;
                previous = line.digest;
                count += 1;
            }
            Ok(count)
        })
    }
}

fn json(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value)
        .map_err(|e| Trouble::new(TroubleKind::Output, e.to_string()))?;
    Ok(text + "\n")
}
