//! The tables, as migrations in order.

use crate::engine::Engine;
use proofmass_jobs::{Result, Trouble};

/// Version of the form.
pub(crate) const VERSION: usize = MIGRATIONS.len();

/// What brings the tables from one version to the next. Types have names that both databases know.
const MIGRATIONS: &[&str] = &[LEDGER, INDEX];

/// What is filed: the entries, linked by their digests, the files, and the names of people apart from both.
const LEDGER: &str = "
CREATE TABLE entry (number BIGINT PRIMARY KEY, body TEXT NOT NULL, previous TEXT NOT NULL, digest TEXT NOT NULL);
CREATE TABLE file (digest TEXT PRIMARY KEY, size BIGINT NOT NULL, content BYTEA);
CREATE TABLE person (digest TEXT PRIMARY KEY, salt TEXT NOT NULL, name TEXT NOT NULL);
";

/// What is found fast: made from the entries alone, and made anew by `check`.
const INDEX: &str = "
CREATE TABLE device (entry BIGINT PRIMARY KEY REFERENCES entry (number), manufacturer TEXT, model TEXT, serial TEXT,
    spelling TEXT, owner_number TEXT, axes TEXT, standard BIGINT NOT NULL);
CREATE INDEX device_spelling ON device (spelling);
CREATE TABLE certificate (entry BIGINT PRIMARY KEY REFERENCES entry (number), standard BIGINT NOT NULL REFERENCES device (entry),
    number TEXT NOT NULL, valid_from BIGINT NOT NULL, valid_until BIGINT, digest TEXT, u_relative DOUBLE PRECISION);
CREATE INDEX certificate_standard ON certificate (standard, valid_from);
CREATE INDEX certificate_digest ON certificate (digest);
CREATE TABLE result (entry BIGINT PRIMARY KEY REFERENCES entry (number), device BIGINT NOT NULL REFERENCES device (entry),
    kind TEXT NOT NULL, day BIGINT NOT NULL, number TEXT, digest TEXT NOT NULL);
CREATE INDEX result_device ON result (device, day);
CREATE INDEX result_digest ON result (digest);
CREATE INDEX result_number ON result (number);
CREATE TABLE quantity (result BIGINT NOT NULL REFERENCES result (entry), place BIGINT NOT NULL, name TEXT NOT NULL, unit TEXT NOT NULL,
    value DOUBLE PRECISION NOT NULL, u DOUBLE PRECISION, expanded DOUBLE PRECISION, k DOUBLE PRECISION, nu DOUBLE PRECISION,
    probability DOUBLE PRECISION, u_standard DOUBLE PRECISION, PRIMARY KEY (result, place));
CREATE TABLE used (result BIGINT NOT NULL REFERENCES result (entry), standard BIGINT NOT NULL REFERENCES device (entry),
    certificate BIGINT REFERENCES certificate (entry), PRIMARY KEY (result, standard));
CREATE INDEX used_standard ON used (standard);
CREATE TABLE input (result BIGINT NOT NULL REFERENCES result (entry), place BIGINT NOT NULL, path TEXT NOT NULL, digest TEXT NOT NULL,
    PRIMARY KEY (result, place));
CREATE INDEX input_digest ON input (digest);
CREATE TABLE output (result BIGINT NOT NULL REFERENCES result (entry), name TEXT NOT NULL, digest TEXT NOT NULL,
    PRIMARY KEY (result, name));
CREATE INDEX output_digest ON output (digest);
CREATE TABLE checked (entry BIGINT PRIMARY KEY REFERENCES entry (number), device BIGINT NOT NULL REFERENCES device (entry),
    day BIGINT NOT NULL, quantity TEXT NOT NULL, unit TEXT NOT NULL, value DOUBLE PRECISION NOT NULL, u DOUBLE PRECISION NOT NULL,
    reference DOUBLE PRECISION NOT NULL, u_reference DOUBLE PRECISION NOT NULL, en DOUBLE PRECISION NOT NULL, good BIGINT NOT NULL);
CREATE INDEX checked_device ON checked (device, day);
CREATE TABLE event (entry BIGINT PRIMARY KEY REFERENCES entry (number), device BIGINT NOT NULL REFERENCES device (entry),
    day BIGINT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL);
CREATE INDEX event_device ON event (device, day);
CREATE TABLE supersession (entry BIGINT PRIMARY KEY REFERENCES entry (number), old BIGINT NOT NULL UNIQUE, new BIGINT, reason TEXT NOT NULL);
CREATE TABLE rule (entry BIGINT PRIMARY KEY REFERENCES entry (number), device BIGINT REFERENCES device (entry));
CREATE INDEX rule_device ON rule (device);
CREATE TABLE due (device BIGINT PRIMARY KEY REFERENCES device (entry), last BIGINT NOT NULL, day BIGINT NOT NULL, evidence TEXT NOT NULL);
CREATE INDEX due_day ON due (day);
";

/// The tables of what was filed, which the others are made from.
#[cfg(feature = "postgres")]
pub(crate) const FILED: [&str; 3] = ["entry", "file", "person"];

/// The results that count as calibrations: neither superseded, nor the certificate of another one.
pub(crate) const CALIBRATIONS: &str = "(SELECT * FROM result WHERE kind <> 'certificate' AND entry NOT IN (SELECT old FROM supersession)) AS result";

/// The tables of the index, which are made from the entries; those that others name first.
pub(crate) const DERIVED: &[&str] = &[
    "device",
    "certificate",
    "result",
    "quantity",
    "used",
    "input",
    "output",
    "checked",
    "event",
    "supersession",
    "rule",
    "due",
];

/// Makes the tables of a version in an empty database.
pub(crate) fn make(engine: &mut dyn Engine, version: usize) -> Result<()> {
    engine.begin()?;
    let made = (|| {
        // Another process may have made them meanwhile.
        let there = engine.version()?;
        for migration in &MIGRATIONS[there..version.max(there)] {
            engine.script(migration)?;
        }
        if there < version {
            engine.set_version(version)?;
        }
        Ok(())
    })();
    end(engine, made)
}

/// Refuses tables of an older version.
pub(crate) fn need_current(engine: &mut dyn Engine) -> Result<()> {
    let version = engine.version()?;
    if version == VERSION {
        return Ok(());
    }
    Err(Trouble::request(format!(
        "the records have version {version} of their form; this program writes version {VERSION}"
    ))
    .with_hint("`proofmass records upgrade` brings them to this version and keeps a copy"))
}

/// Ends what was begun: keeps it where it is good, drops it else.
pub(crate) fn end<T>(engine: &mut dyn Engine, done: Result<T>) -> Result<T> {
    match done.and_then(|value| engine.commit().map(|()| value)) {
        Ok(value) => Ok(value),
        Err(trouble) => {
            engine.rollback();
            Err(trouble)
        }
    }
}
