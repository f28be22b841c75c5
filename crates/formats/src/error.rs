//! What is wrong with a file, and what to do about it.

use std::fmt;

/// Result with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Letters of a message.
const LONGEST: usize = 1000;

/// What is wrong with a file, where in it, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    what: String,
    hint: Option<String>,
    refused: Option<std::io::ErrorKind>,
}

impl Error {
    /// What is wrong, in one line.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self {
            what: crate::names::shortened(&what.into(), LONGEST),
            hint: None,
            refused: None,
        }
    }

    /// What to do about it.
    pub(crate) fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// What to do about it.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }

    /// The refusal of the operating system, where the content is not to blame.
    pub fn refused(&self) -> Option<std::io::ErrorKind> {
        self.refused
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Error {}

impl From<std::io::Error> for Error {
    fn from(e: std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::UnexpectedEof => {
                Self::new("the file became shorter while it was read")
            }
            kind => Self {
                what: format!("cannot be read: {e}"),
                hint: None,
                refused: Some(kind),
            },
        }
    }
}
