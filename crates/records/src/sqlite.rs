//! Records in a file, by SQLite.

use crate::engine::{Engine, Row, Value};
use crate::schema::VERSION;
use proofmass_jobs::{Result, Trouble, TroubleKind};
use rusqlite::types::{ToSql, ToSqlOutput, ValueRef};
use rusqlite::{Connection, OpenFlags};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Marks a file of records in its head.
const APPLICATION: i64 = 0x706d_7265;
/// How long another writer is waited for.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is wanted of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// To read it.
    Read,
    /// To write as well; it is there.
    Write,
    /// To write; it is made where it is not there.
    Create,
}

/// A file of records.
pub(crate) struct Sqlite {
    connection: Connection,
    path: PathBuf,
}

impl Sqlite {
    /// Opens the file, and looks at its head before.
    pub(crate) fn open(path: &Path, access: Access) -> Result<Self> {
        let size = std::fs::metadata(path).map(|m| m.len()).ok();
        match (size, access) {
            (None, Access::Create) => {}
            (Some(0), _) => {
                return Err(
                    Trouble::data(format!("{} is empty", path.display())).with_hint(
                        "if records stood there, take the last backup; else remove the empty file",
                    ),
                );
            }
            (None, _) => {
                return Err(Trouble::request(format!(
                    "there are no records at {}",
                    path.display()
                ))
                .with_hint("name their file with --records; `proofmass records add` makes it"));
            }
            (Some(size), _) => look_at_head(path, size)?,
        }
        if access != Access::Read {
            refuse_network_share(path)?;
        }
        let connection = Self::connect(path, access).map_err(|e| wrong(path, &e))?;
        let mut records = Self {
            connection,
            path: path.to_path_buf(),
        };
        let application: i64 = records.pragma("application_id")?;
        let version: i64 = records.pragma("user_version")?;
        if version > 0 && application != APPLICATION {
            return Err(Trouble::data(format!(
                "{} is a database of another program",
                path.display()
            ))
            .with_hint("name the file of the records"));
        }
        if version > VERSION as i64 {
            return Err(Trouble::data(format!(
                "{} has version {version} of the form of records; this program knows version {VERSION}",
                path.display()
            ))
            .with_hint("use a newer proofmass, or let that one write the records out (`records export --folder`) and import them here"));
        }
        if version == 0 {
            if access != Access::Create {
                return Err(
                    Trouble::data(format!("{} holds no records", path.display()))
                        .with_hint("name the file of the records"),
                );
            }
            records.script(&format!("PRAGMA application_id = {APPLICATION}"))?;
        }
        Ok(records)
    }

    /// Records in memory alone.
    pub(crate) fn in_memory() -> Result<Self> {
        let path = PathBuf::from(":memory:");
        let connection = Connection::open_in_memory().map_err(|e| wrong(&path, &e))?;
        Ok(Self { connection, path })
    }

    fn connect(path: &Path, access: Access) -> rusqlite::Result<Connection> {
        let flags = match access {
            Access::Read => OpenFlags::SQLITE_OPEN_READ_ONLY,
            Access::Write => OpenFlags::SQLITE_OPEN_READ_WRITE,
            Access::Create => OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE,
        } | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        connection.busy_timeout(PATIENCE)?;
        connection.pragma_update(None, "foreign_keys", true)?;
        if access != Access::Read {
            connection.pragma_update(None, "journal_mode", "wal")?;
            connection.pragma_update(None, "synchronous", "full")?;
            // A name that was removed leaves nothing behind.
            connection.pragma_update(None, "secure_delete", true)?;
        }
        let reads = connection.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(()));
        // In a folder that cannot be written no other program writes either: the file stays as it is.
        let mut sidecar = path.as_os_str().to_owned();
        sidecar.push("-wal");
        if reads.is_err() && access == Access::Read && !Path::new(&sidecar).exists() {
            let uri = format!(
                "file:{}?immutable=1",
                path.display()
                    .to_string()
                    .replace('%', "%25")
                    .replace('?', "%3f")
                    .replace('#', "%23")
            );
            return Connection::open_with_flags(uri, flags | OpenFlags::SQLITE_OPEN_URI);
        }
        reads.map(|()| connection)
    }

    fn pragma(&mut self, name: &str) -> Result<i64> {
        let row = self
            .connection
            .query_row(&format!("PRAGMA {name}"), [], |row| row.get(0));
        row.map_err(|e| wrong(&self.path, &e))
    }
}

/// What is wrong with the file, as far as its head tells.
fn look_at_head(path: &Path, size: u64) -> Result<()> {
    let mut head = [0; 100];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut head));
    let hint =
        "take the last backup (`proofmass records backup` makes one while the records are in use)";
    if read.is_err() || &head[..16] != b"SQLite format 3\0" {
        let what = format!(
            "{} is no file of records, or its beginning is damaged",
            path.display()
        );
        return Err(Trouble::data(what).with_hint(hint));
    }
    let number = |at: usize| {
        u64::from(u32::from_be_bytes([
            head[at],
            head[at + 1],
            head[at + 2],
            head[at + 3],
        ]))
    };
    let page = match u64::from(u16::from_be_bytes([head[16], head[17]])) {
        1 => 65536,
        page => page,
    };
    let whole = page * number(28);
    // What a checkpoint that was interrupted left is made whole from the journal beside it.
    let mut journal = path.as_os_str().to_owned();
    journal.push("-wal");
    let is_open = std::fs::metadata(Path::new(&journal)).is_ok_and(|m| m.len() > 0);
    // One page alone has no table: it may become a file of records.
    let application = number(68);
    let bare = application == 0 && number(60) == 0 && number(28) <= 1;
    if !is_open && application != APPLICATION as u64 && !bare {
        return Err(Trouble::data(format!(
            "{} is a database of another program",
            path.display()
        ))
        .with_hint("name the file of the records"));
    }
    // The number of pages counts where both change counters agree.
    if !is_open && number(24) == number(92) && size < whole {
        return Err(Trouble::data(format!(
            "{} was cut off: it has {size} bytes of {whole}, as a copy that did not end",
            path.display()
        ))
        .with_hint(hint));
    }
    Ok(())
}

/// Refuses to write over a network, where locks of SQLite do not hold.
fn refuse_network_share(path: &Path) -> Result<()> {
    #[cfg(target_os = "linux")]
    {
        /// NFS, SMB, CIFS, SMB 2, AFS, Ceph.
        const NETWORK: [i64; 6] = [
            0x6969,
            0x517b,
            0xff53_4d42,
            0xfe53_4d42,
            0x5346_414f,
            0x00c3_6400,
        ];
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        #[allow(
            clippy::unnecessary_cast,
            reason = "its type is not the same on every processor"
        )]
        let kind = rustix::fs::statfs(folder).map(|system| system.f_type as i64 & 0xffff_ffff);
        if let Ok(kind) = kind
            && NETWORK.contains(&kind)
        {
            return Err(Trouble::request(format!("{} lies on a network share, where two writers would damage it", path.display()))
                .with_hint("keep the records on a disk of this computer, or in PostgreSQL (--records postgresql://…)"));
        }
    }
    let _ = path;
    Ok(())
}

/// An error of SQLite with its remedy.
fn wrong(path: &Path, error: &rusqlite::Error) -> Trouble {
    use rusqlite::ErrorCode as Code;
    let hint = match error.sqlite_error_code() {
        Some(Code::DatabaseCorrupt | Code::NotADatabase) => {
            "the file is damaged: take the last backup, or write out what can be read with `records export --folder`"
        }
        Some(Code::ReadOnly | Code::PermissionDenied | Code::CannotOpen) => {
            "the file or its folder cannot be written: ask for the permission, or work on a copy made with `records backup`"
        }
        Some(Code::DiskFull) => "the disk is full: nothing was written; make room and repeat",
        Some(Code::DatabaseBusy | Code::DatabaseLocked) => {
            "another program writes for long: wait for it, or end it"
        }
        _ => "`proofmass records check` says whether the records are whole",
    };
    let kind = match error.sqlite_error_code() {
        Some(Code::DiskFull | Code::ReadOnly | Code::SystemIoFailure) => TroubleKind::Output,
        _ => TroubleKind::Data,
    };
    Trouble::new(kind, format!("{}: {error}", path.display())).with_hint(hint)
}

impl ToSql for Value {
    fn to_sql(&self) -> rusqlite::Result<ToSqlOutput<'_>> {
        Ok(ToSqlOutput::Borrowed(match self {
            Self::Null => ValueRef::Null,
            Self::Integer(value) => ValueRef::Integer(*value),
            Self::Real(value) => ValueRef::Real(*value),
            Self::Text(text) => ValueRef::Text(text.as_bytes()),
            Self::Bytes(bytes) => ValueRef::Blob(bytes),
        }))
    }
}

impl Engine for Sqlite {
    fn run(&mut self, statement: &str, values: &[Value]) -> Result<u64> {
        let prepared = self.connection.prepare_cached(statement);
        let done = prepared.and_then(|mut s| s.execute(rusqlite::params_from_iter(values)));
        done.map(|n| n as u64).map_err(|e| wrong(&self.path, &e))
    }

    fn rows(&mut self, question: &str, values: &[Value]) -> Result<Vec<Row>> {
        let ask = || -> rusqlite::Result<Vec<Row>> {
            let mut prepared = self.connection.prepare_cached(question)?;
            let width = prepared.column_count();
            let rows = prepared.query_map(rusqlite::params_from_iter(values), |row| {
                (0..width)
                    .map(|i| {
                        Ok(match row.get_ref(i)? {
                            ValueRef::Null => Value::Null,
                            ValueRef::Integer(value) => Value::Integer(value),
                            ValueRef::Real(value) => Value::Real(value),
                            ValueRef::Text(text) => {
                                Value::Text(String::from_utf8_lossy(text).into_owned())
                            }
                            ValueRef::Blob(bytes) => Value::Bytes(bytes.to_vec()),
                        })
                    })
                    .collect()
            })?;
            rows.collect()
        };
        ask().map_err(|e| wrong(&self.path, &e))
    }

    fn script(&mut self, statements: &str) -> Result<()> {
        let done = self.connection.execute_batch(statements);
        done.map_err(|e| wrong(&self.path, &e))
    }

    fn begin(&mut self) -> Result<()> {
        self.script("BEGIN IMMEDIATE")
    }

    fn commit(&mut self) -> Result<()> {
        self.script("COMMIT")
    }

    fn rollback(&mut self) {
        let _ = self.script("ROLLBACK");
    }

    fn version(&mut self) -> Result<usize> {
        self.pragma("user_version")
            .map(|v| usize::try_from(v).unwrap_or(0))
    }

    fn set_version(&mut self, version: usize) -> Result<()> {
        self.script(&format!("PRAGMA user_version = {version}"))
    }

    fn damage(&mut self) -> Result<Vec<String>> {
        let rows = match self.rows("PRAGMA integrity_check", &[]) {
            Ok(rows) => rows,
            Err(damage) => return Ok(vec![damage.to_string()]),
        };
        let lines = rows.iter().map(|row| row[0].words());
        Ok(lines.filter(|line| line != "ok").collect())
    }

    fn copy_to(&mut self, place: &Path) -> Result<()> {
        if place.exists() {
            return Err(
                Trouble::request(format!("{} is there already", place.display()))
                    .with_hint("name another file"),
            );
        }
        let mut unfinished = place.as_os_str().to_owned();
        unfinished.push(".unfinished");
        let unfinished = PathBuf::from(unfinished);
        let _ = std::fs::remove_file(&unfinished);
        let copy = || -> rusqlite::Result<()> {
            let mut to = Connection::open(&unfinished)?;
            {
                let backup = rusqlite::backup::Backup::new(&self.connection, &mut to)?;
                backup.run_to_completion(1 << 16, Duration::from_millis(1), None)?;
            }
            // One file, without a journal beside it.
            to.pragma_update(None, "journal_mode", "delete")
        };
        copy().map_err(|e| wrong(&self.path, &e))?;
        std::fs::rename(&unfinished, place)
            .map_err(|e| Trouble::new(TroubleKind::Output, format!("{}: {e}", place.display())))
    }

    fn keep_copy(&mut self) -> Result<String> {
        let version = self.version()?;
        let mut place = self.path.as_os_str().to_owned();
        place.push(format!(".version-{version}"));
        let place = PathBuf::from(place);
        self.copy_to(&place)?;
        Ok(place.display().to_string())
    }

    fn beside(&self) -> Option<PathBuf> {
        let mut place = self.path.as_os_str().to_owned();
        place.push(".files");
        (self.path.as_os_str() != ":memory:").then(|| PathBuf::from(place))
    }
}

#[cfg(test)]
mod tests {
    use crate::{Content, FiledDevice, Records};

    #[test]
    fn law_a_full_disk_leaves_the_state_before() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("lab.records");
        let mut records = Records::open_or_make(place.to_str().unwrap()).unwrap();
        let device = |k: usize| {
            Content::Device(FiledDevice {
                serial: Some(format!("{k}")),
                description: Some("x".repeat(5000)),
                ..Default::default()
            })
        };
        records.engine.script("PRAGMA max_page_count = 80").unwrap();
        let mut filed = 0;
        let full = loop {
            match records.add("2026-01-01", None, device(filed)) {
                Ok(_) => filed += 1,
                Err(full) => break full,
            }
        };
        assert!(full.hint().unwrap().contains("disk is full"), "{full}");
        assert!(filed > 3);
        drop(records);
        let mut records = Records::open_to_add(place.to_str().unwrap()).unwrap();
        assert_eq!(records.entries(1).unwrap().len(), filed);
        assert!(records.check().unwrap().is_whole());
        records.add("2026-01-01", None, device(filed)).unwrap();
    }
}
