//! The one error of this crate: what is wrong, in which file, line and column, and what to do about it.

use proofmass_core::Visible;
use std::fmt;
use std::path::{Path, PathBuf};

/// What kind of trouble it is, for callers that act on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file or folder is not there.
    NotFound,
    /// The operating system refused to read or write.
    Access,
    /// The file is not of the form that was expected (binary, empty, another schema).
    Format,
    /// A row has another number of fields than the rest.
    Row,
    /// A field is not a finite number.
    Field,
    /// A column is missing, named twice or of the wrong unit.
    Column,
    /// An element of a document holds what cannot be.
    Element,
    /// The time column does not run forward, or there is no time base.
    Time,
    /// A configuration key is unknown, missing or has a value outside its range.
    Configuration,
    /// The output place is taken, or a value to be written is not finite.
    Output,
    /// Nobody reads what is written any more (`… -o - | head`).
    Closed,
}

impl ErrorKind {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::NotFound,
        Self::Access,
        Self::Format,
        Self::Row,
        Self::Field,
        Self::Column,
        Self::Element,
        Self::Time,
        Self::Configuration,
        Self::Output,
        Self::Closed,
    ];

    /// The kind as a word that stays.
    pub fn code(self) -> &'static str {
        match self {
            Self::NotFound => "not-found",
            Self::Access => "access",
            Self::Format => "format",
            Self::Row => "row",
            Self::Field => "field",
            Self::Column => "column",
            Self::Element => "element",
            Self::Time => "time",
            Self::Configuration => "configuration",
            Self::Output => "output",
            Self::Closed => "closed",
        }
    }
}

/// Result with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What is wrong with a file, where, and what to do about it.
///
/// The display is one line, `path:line: column "acc_x": what is wrong`; [`Error::hint`] is the remedy.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.line_of_text())]
pub struct Error {
    #[source]
    source: Option<Box<dyn std::error::Error + Send + Sync>>,
    place: Box<Place>,
}

#[derive(Debug)]
struct Place {
    kind: ErrorKind,
    what: String,
    path: Option<PathBuf>,
    line: Option<u64>,
    column: Option<String>,
    hint: Option<String>,
}

impl Error {
    /// An error of a kind: what is wrong, in one line.
    pub fn new(kind: ErrorKind, what: impl Into<String>) -> Self {
        Self {
            source: None,
            place: Box::new(Place {
                kind,
                what: what.into(),
                path: None,
                line: None,
                column: None,
                hint: None,
            }),
        }
    }

    /// An operating-system error while `doing` something with `path`.
    pub fn access(path: &Path, doing: &str, source: std::io::Error) -> Self {
        let (kind, what, hint) = match source.kind() {
            // A folder of the system, such as /proc, is there and takes no files.
            std::io::ErrorKind::NotFound if path.is_dir() => (
                ErrorKind::Access,
                format!("cannot {doing}: it takes no new files"),
                Some("name a folder on a disk, such as `results`"),
            ),
            std::io::ErrorKind::NotFound => (
                ErrorKind::NotFound,
                "there is no such file or folder".to_string(),
                Some(
                    "check the path; it is taken relative to the current folder (to that of campaign.toml where it stands in a campaign)",
                ),
            ),
            std::io::ErrorKind::PermissionDenied => (
                ErrorKind::Access,
                format!("no permission to {doing}"),
                Some("check the permissions of the file and of its folder"),
            ),
            std::io::ErrorKind::StorageFull => (
                ErrorKind::Access,
                format!("cannot {doing}: the disk is full"),
                Some("free some space and run again; nothing half written was left"),
            ),
            std::io::ErrorKind::BrokenPipe => (
                ErrorKind::Closed,
                "nobody reads what is written any more".to_string(),
                None,
            ),
            _ => (ErrorKind::Access, format!("cannot {doing}: {source}"), None),
        };
        let mut error = Self::new(kind, what).at(path);
        error.place.hint = hint.map(str::to_string);
        error.source = Some(Box::new(source));
        error
    }

    /// Adds the file, unless one is named already.
    pub fn at(mut self, path: &Path) -> Self {
        self.place.path.get_or_insert_with(|| path.to_path_buf());
        self
    }

    /// Adds the line, counted from one.
    pub fn line(mut self, line: u64) -> Self {
        self.place.line = Some(line);
        self
    }

    /// Adds the column, key or value.
    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.place.column = Some(column.into());
        self
    }

    /// Sets what to do about it.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.place.hint = Some(hint.into());
        self
    }

    /// Keeps the error it comes from.
    pub fn because(mut self, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        self.source = Some(source.into());
        self
    }

    /// What kind of trouble it is.
    pub fn kind(&self) -> ErrorKind {
        self.place.kind
    }

    /// The file or folder.
    pub fn path(&self) -> Option<&Path> {
        self.place.path.as_deref()
    }

    /// Line of the file, counted from one.
    pub fn line_number(&self) -> Option<u64> {
        self.place.line
    }

    /// Name of the column, field or key.
    pub fn field(&self) -> Option<&str> {
        self.place.column.as_deref()
    }

    /// What to do about it.
    pub fn hint(&self) -> Option<&str> {
        self.place.hint.as_deref()
    }

    fn line_of_text(&self) -> impl fmt::Display + '_ {
        struct Line<'a>(&'a Place);
        impl fmt::Display for Line<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                if let Some(path) = &self.0.path {
                    write!(f, "{}:", Visible(&path.to_string_lossy()))?;
                    if let Some(line) = self.0.line {
                        write!(f, "{line}:")?;
                    }
                    f.write_str(" ")?;
                }
                if let Some(column) = &self.0.column {
                    let word = match self.0.kind {
                        ErrorKind::Configuration => "key",
                        ErrorKind::Output => "value",
                        ErrorKind::Element => "element",
                        _ => "column",
                    };
                    write!(f, "{word} \"{}\": ", Visible(column))?;
                }
                write!(f, "{}", Visible(&self.0.what))
            }
        }
        Line(&self.place)
    }
}
