//! What is wrong, where, and what to do.

use std::fmt;

/// Why there is no certificate.
#[derive(Debug)]
pub struct Error {
    what: String,
    place: String,
    remedy: String,
}

/// What is made, or why it is not.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// `what` is wrong; `remedy` says what to do. The place follows with [`Error::at`].
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            place: String::new(),
            remedy: remedy.into(),
        }
    }

    /// Names the place: a field of the sheet, as `blocks[3].rows[0]`, or a file. An outer place stands before an inner one.
    #[must_use]
    pub fn at(mut self, place: &str) -> Self {
        if !place.is_empty() {
            self.place = if self.place.is_empty() {
                place.to_owned()
            } else {
                format!("{place}: {}", self.place)
            };
        }
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "error: {}", self.what)?;
        if !self.place.is_empty() {
            writeln!(f, "  {}", self.place)?;
        }
        write!(f, "hint: {}", self.remedy)
    }
}
