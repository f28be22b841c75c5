//! The records themselves: opened, read, and added to; never changed.

use crate::check::need_chain;
use crate::engine::{Engine, Value};
use crate::entry::{Content, Entry, FiledFile, link, sha256};
use crate::filing::{Filed, name_of};
use crate::schema::{self, VERSION};
use crate::sqlite::{Access, Sqlite};
use crate::{doubts, files, index, sound};
use proofmass_jobs::{Result, Trouble, TroubleKind};
use std::path::{Path, PathBuf};

/// Bytes up to which a file stands inside the database, where larger ones can stand beside it.
const INSIDE: usize = 1 << 16;

/// The records of a laboratory.
///
/// A place is a file (SQLite) or, with the feature `postgres`, a URL `postgresql://…`; nothing else depends on which.
///
/// ```
/// use proofmass_records::{Content, FiledDevice, Records};
///
/// let mut records = Records::in_memory()?;
/// let device = FiledDevice { serial: Some("0042".into()), ..Default::default() };
/// let number = records.add("2026-01-31", None, Content::Device(device))?;
/// assert_eq!(records.entries(1)?[0].0, number);
/// assert!(records.check()?.is_whole());
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
pub struct Records {
    pub(crate) engine: Box<dyn Engine>,
    beside: Option<PathBuf>,
}

impl Records {
    /// Opens records to read them. Nothing is written, so that a copy on a medium that cannot be written will do.
    ///
    /// # Errors
    /// No records there, a newer version, a damaged or half copied file.
    pub fn open(place: &str) -> Result<Self> {
        let mut records = Self::at(place, Access::Read)?;
        schema::need_current(&mut *records.engine)?;
        Ok(records)
    }

    /// Opens records to add to them.
    ///
    /// # Errors
    /// As [`Records::open`]; a damaged end of the chain; a place that cannot be written, or on a network share; an older version, which
    /// [`Records::upgrade`] brings up to this one.
    pub fn open_to_add(place: &str) -> Result<Self> {
        let mut records = Self::at(place, Access::Write)?;
        schema::need_current(&mut *records.engine)?;
        need_end(&mut *records.engine)?;
        Ok(records)
    }

    /// Opens records to add to them, and makes them where there are none.
    ///
    /// # Errors
    /// As [`Records::open_to_add`].
    pub fn open_or_make(place: &str) -> Result<Self> {
        let mut records = Self::at(place, Access::Create)?;
        if records.engine.version()? == 0 {
            schema::make(&mut *records.engine, VERSION)?;
        }
        schema::need_current(&mut *records.engine)?;
        need_end(&mut *records.engine)?;
        Ok(records)
    }

    /// Records in memory, for a look or a test.
    ///
    /// # Errors
    /// None in practice.
    pub fn in_memory() -> Result<Self> {
        let mut engine: Box<dyn Engine> = Box::new(Sqlite::in_memory()?);
        schema::make(&mut *engine, VERSION)?;
        Ok(Self {
            engine,
            beside: None,
        })
    }

    /// Records of an older version, for tests of the upgrade.
    #[doc(hidden)]
    pub fn make_of_version(place: &str, version: usize) -> Result<Self> {
        let mut records = Self::at(place, Access::Create)?;
        schema::make(&mut *records.engine, version)?;
        Ok(records)
    }

    fn at(place: &str, access: Access) -> Result<Self> {
        let engine: Box<dyn Engine> = if is_url(place) {
            #[cfg(feature = "postgres")]
            {
                Box::new(crate::postgresql::Postgresql::open(place, access)?)
            }
            #[cfg(not(feature = "postgres"))]
            return Err(
                Trouble::request("this program was built without PostgreSQL")
                    .with_hint("build it with `--features postgres`, or name a file"),
            );
        } else {
            Box::new(Sqlite::open(Path::new(place), access)?)
        };
        let beside = engine.beside();
        Ok(Self { engine, beside })
    }

    /// Brings records of an older version to this one, after a copy of them was kept; says where the copy is, `None` where there was
    /// nothing to do.
    ///
    /// # Errors
    /// The copy or the change fails; the records are then as they were.
    pub fn upgrade(place: &str) -> Result<Option<String>> {
        let mut records = Self::at(place, Access::Write)?;
        let engine = &mut *records.engine;
        if engine.version()? == VERSION {
            return Ok(None);
        }
        let copy = engine.keep_copy()?;
        schema::make(engine, VERSION)?;
        records.writing(|engine, _| index::rebuild(engine))?;
        Ok(Some(copy))
    }

    /// Carries out what is written as one: all of it or nothing.
    pub(crate) fn writing<T>(
        &mut self,
        write: impl FnOnce(&mut dyn Engine, Option<&Path>) -> Result<T>,
    ) -> Result<T> {
        let engine = &mut *self.engine;
        engine.begin()?;
        let done = write(engine, self.beside.as_deref());
        schema::end(engine, done)
    }

    /// Files an entry and gives its number. It is on the disk afterwards.
    ///
    /// # Errors
    /// It names an entry that is not there, or the database refuses; the records are then as they were.
    pub fn add(&mut self, filed: &str, by: Option<&str>, content: Content) -> Result<i64> {
        Ok(self.file_content(filed, by, content)?.number)
    }

    /// Files an entry, and says what is to be doubted about it and about what it concerns.
    ///
    /// # Errors
    /// As [`Records::add`].
    pub fn file_content(
        &mut self,
        filed: &str,
        by: Option<&str>,
        content: Content,
    ) -> Result<Filed> {
        self.writing(|engine, _| {
            let by = by.map(|name| person(engine, name)).transpose()?;
            let entry = entry(filed, by, content);
            let number = append(engine, &entry)?;
            Ok(Filed {
                number,
                known: false,
                new_device: None,
                findings: doubts::of(engine, number, &entry.content)?,
            })
        })
    }

    /// The entries from a number on, in order.
    ///
    /// # Errors
    /// The database refuses, or an entry is damaged.
    pub fn entries(&mut self, from: i64) -> Result<Vec<(i64, Entry)>> {
        let question = "SELECT number, body FROM entry WHERE number >= ?1 ORDER BY number";
        let rows = self.engine.rows(question, &[from.into()])?;
        let read = |row: &Vec<Value>| {
            let number = row[0].integer().unwrap_or_default();
            Ok((number, parse(number, &row[1].words())?))
        };
        rows.iter().map(read).collect()
    }

    /// One entry.
    ///
    /// # Errors
    /// There is none of this number, or it is damaged.
    pub fn entry(&mut self, number: i64) -> Result<Entry> {
        read_entry(&mut *self.engine, number)
    }

    /// An entry in words: what it is, of which device, of which day.
    ///
    /// # Errors
    /// There is none of this number, or it is damaged.
    pub fn named_entry(&mut self, number: i64) -> Result<String> {
        let (what, device, date) = match self.entry(number)?.content {
            Content::Device(d) => return Ok(format!("device {number} ({})", d.line())),
            Content::Certificate(c) => ("certificate", Some(c.standard), c.valid_from),
            Content::Result(r) => ("result", Some(r.device), r.date),
            Content::Check(c) => ("check", Some(c.device), c.date),
            Content::Event(e) => ("event", Some(e.device), e.date),
            Content::InUse(u) => ("use", Some(u.device), u.date),
            Content::Supersession(s) => return Ok(format!("supersession {number} of {}", s.old)),
            Content::Rule(_) => return Ok(format!("rule {number}")),
            Content::Campaign(c) => return Ok(format!("campaign {number} ({})", c.title)),
        };
        let name = match device {
            Some(device) => name_of(&mut *self.engine, device)?,
            None => String::new(),
        };
        Ok(format!("{what} {number} ({name}, {date})"))
    }

    /// Bytes of a file by its digest, `None` where only the digest is kept.
    ///
    /// # Errors
    /// The file is damaged or gone.
    pub fn file(&mut self, sha256: &str) -> Result<Option<Vec<u8>>> {
        files::get(&mut *self.engine, self.beside.as_deref(), sha256)
    }

    /// Copies the whole records into a new file and folder, while others add to them.
    ///
    /// # Errors
    /// The records are damaged; and as [`Records::copy_as_it_is`].
    pub fn backup(&mut self, place: &Path) -> Result<()> {
        if let Some(damage) = self.engine.damage()?.into_iter().next() {
            return Err(Trouble::data(format!("the records are damaged: {damage}")).with_hint(
                "`proofmass records check` lists what is damaged; take the last backup, and keep it",
            ));
        }
        need_chain(&mut *self.engine, 1)?;
        if let Some(damage) = self.damaged_files()?.into_iter().next() {
            return Err(Trouble::data(format!("the records are damaged: {damage}")).with_hint(
                "`proofmass records check` lists what is damaged; take the file from the last backup",
            ));
        }
        self.copy_as_it_is(place)
    }

    /// Copies the whole records as they are, be they damaged.
    ///
    /// # Errors
    /// The place is taken or cannot be written; records on a server.
    pub fn copy_as_it_is(&mut self, place: &Path) -> Result<()> {
        // The database first: whatever it names was on the disk before, and is copied after it.
        let mut to = place.as_os_str().to_owned();
        to.push(".files");
        self.engine.copy_to(place)?;
        match &self.beside {
            Some(beside) if beside.is_dir() => files::copy_folder(beside, Path::new(&to)),
            _ => Ok(()),
        }
    }

    /// Removes the name of a person. The entries stay, and stay linked.
    ///
    /// # Errors
    /// Nobody of this name is known.
    pub fn forget(&mut self, name: &str) -> Result<()> {
        let gone = self.writing(|engine, _| {
            engine.run("DELETE FROM person WHERE name = ?1", &[name.into()])
        })?;
        match gone {
            0 => Err(Trouble::request(format!(
                "nobody is known by the name {name:?}"
            ))),
            _ => Ok(()),
        }
    }

    /// The name behind a digest of [`Entry::by`], where it was not removed.
    ///
    /// # Errors
    /// The database refuses.
    pub fn person(&mut self, digest: &str) -> Result<Option<String>> {
        let rows = self.engine.rows(
            "SELECT name FROM person WHERE digest = ?1",
            &[digest.into()],
        )?;
        Ok(rows.first().map(|row| row[0].words()))
    }
}

/// Nothing is filed behind an entry that is not what was filed.
fn need_end(engine: &mut dyn Engine) -> Result<()> {
    let rows = engine.rows("SELECT max(number) FROM entry", &[])?;
    let last = rows.first().and_then(|row| row[0].integer());
    need_chain(engine, last.unwrap_or(1) - 1)
}

/// Whether a place is a database on a server.
pub(crate) fn is_url(place: &str) -> bool {
    place.starts_with("postgres://") || place.starts_with("postgresql://")
}

/// An entry of a day.
pub(crate) fn entry(filed: &str, by: Option<String>, content: Content) -> Entry {
    Entry {
        filed: filed.to_owned(),
        by,
        content,
    }
}

/// Files an entry within what is being written.
pub(crate) fn append(engine: &mut dyn Engine, entry: &Entry) -> Result<i64> {
    let body = serde_json::to_string(entry).map_err(|e| {
        Trouble::new(
            TroubleKind::Output,
            format!("the entry has no form in JSON: {e}"),
        )
    })?;
    sound::check(engine, entry, &body)?;
    append_body(engine, &body, entry)
}

/// Files an entry whose text is known.
pub(crate) fn append_body(engine: &mut dyn Engine, body: &str, entry: &Entry) -> Result<i64> {
    let last = engine.rows(
        "SELECT number, digest FROM entry ORDER BY number DESC LIMIT 1",
        &[],
    )?;
    let (number, previous) = match last.first() {
        Some(row) => (row[0].integer().unwrap_or_default() + 1, row[1].words()),
        None => (1, String::new()),
    };
    let digest = link(number, body, &previous);
    engine.run(
        "INSERT INTO entry (number, body, previous, digest) VALUES (?1, ?2, ?3, ?4)",
        &[
            number.into(),
            body.into(),
            previous.as_str().into(),
            digest.as_str().into(),
        ],
    )?;
    index::add(engine, number, entry)?;
    Ok(number)
}

/// Reads the text of an entry.
pub(crate) fn parse(number: i64, body: &str) -> Result<Entry> {
    serde_json::from_str(body).map_err(|e| {
        Trouble::data(format!("entry {number} is damaged: {e}"))
            .with_hint("`proofmass records check` lists what is damaged; take the last backup")
    })
}

/// Reads one entry.
pub(crate) fn read_entry(engine: &mut dyn Engine, number: i64) -> Result<Entry> {
    let rows = engine.rows("SELECT body FROM entry WHERE number = ?1", &[number.into()])?;
    match rows.first() {
        Some(row) => parse(number, &row[0].words()),
        None => Err(Trouble::request(format!("there is no entry {number}"))
            .with_hint("`proofmass records list` has the numbers")),
    }
}

/// The digest that stands for a person in entries; the name stands apart with a number that nobody can guess.
pub(crate) fn person(engine: &mut dyn Engine, name: &str) -> Result<String> {
    let known = engine.rows("SELECT digest FROM person WHERE name = ?1", &[name.into()])?;
    if let Some(row) = known.first() {
        return Ok(row[0].words());
    }
    // The public key of a new pair is as good a random number as any.
    let salt = proofmass_io::SigningKey::generate()?.public().to_string();
    let digest = sha256(&[salt.as_bytes(), name.as_bytes()]);
    engine.run(
        "INSERT INTO person (digest, salt, name) VALUES (?1, ?2, ?3)",
        &[digest.as_str().into(), salt.as_str().into(), name.into()],
    )?;
    Ok(digest)
}

/// Keeps the bytes of a file and gives what an entry says of it.
pub(crate) fn keep(
    engine: &mut dyn Engine,
    beside: Option<&Path>,
    name: &str,
    bytes: &[u8],
) -> Result<FiledFile> {
    let sha256 = sha256(&[bytes]);
    files::put(engine, beside, &sha256, bytes, INSIDE)?;
    Ok(FiledFile {
        name: name.to_owned(),
        sha256,
        kept: true,
    })
}

impl Records {
    /// Keeps the bytes of a file, such as the table or page of a certificate, and gives what an entry says of it.
    ///
    /// # Errors
    /// The database or the disk refuses.
    pub fn keep_file(&mut self, name: &str, bytes: &[u8]) -> Result<FiledFile> {
        self.writing(|engine, beside| keep(engine, beside, name, bytes))
    }
}
