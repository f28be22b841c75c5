//! What a database has to do for the records. No other part of this crate knows which one it is.

use proofmass_jobs::Result;

/// A value of a row, or of a place in a statement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Null,
    Integer(i64),
    Real(f64),
    Text(String),
    Bytes(Vec<u8>),
}

/// One row of an answer.
pub(crate) type Row = Vec<Value>;

/// A database with the statements that SQLite and PostgreSQL have in common; places in a statement are `?1`, `?2`, ….
pub(crate) trait Engine: Send {
    /// Carries out one statement and gives the number of rows that it touched.
    fn run(&mut self, statement: &str, values: &[Value]) -> Result<u64>;
    /// The rows of a question.
    fn rows(&mut self, question: &str, values: &[Value]) -> Result<Vec<Row>>;
    /// Carries out several statements without values.
    fn script(&mut self, statements: &str) -> Result<()>;
    /// Begins to write: until the end nobody else does.
    fn begin(&mut self) -> Result<()>;
    /// Keeps what was written since the beginning; it is on the disk afterwards.
    fn commit(&mut self) -> Result<()>;
    /// Drops what was written since the beginning.
    fn rollback(&mut self);
    /// Version of the form of the tables; 0 without tables.
    fn version(&mut self) -> Result<usize>;
    /// States the version.
    fn set_version(&mut self, version: usize) -> Result<()>;
    /// What the database itself finds damaged.
    fn damage(&mut self) -> Result<Vec<String>>;
    /// Copies the whole database into a file, while others use it.
    fn copy_to(&mut self, place: &std::path::Path) -> Result<()>;
    /// Keeps a copy before the form of the tables is changed, and says where.
    fn keep_copy(&mut self) -> Result<String>;
    /// Where larger files stand beside the database; `None` where all are inside.
    fn beside(&self) -> Option<std::path::PathBuf>;
}

impl Value {
    pub(crate) fn integer(&self) -> Option<i64> {
        match self {
            Self::Integer(value) => Some(*value),
            _ => None,
        }
    }

    pub(crate) fn real(&self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(*value),
            Self::Integer(value) => Some(*value as f64),
            _ => None,
        }
    }

    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The text, empty for none.
    pub(crate) fn words(&self) -> String {
        self.text().unwrap_or_default().to_owned()
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<&String> for Value {
    fn from(text: &String) -> Self {
        Self::Text(text.clone())
    }
}

impl<T: Into<Self>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, Into::into)
    }
}
