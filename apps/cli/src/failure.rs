//! Errors as a person reads them: what is wrong, where, what to do.

use proofmass::core::Visible;
use proofmass::io;
use proofmass::jobs::{Trouble, TroubleKind};
use std::fmt;

/// Why a command ended without a result.
#[derive(Debug)]
pub(crate) struct Failure(Trouble);

impl Failure {
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self(Trouble::request(what))
    }

    /// A line that says where, or on what evidence.
    pub(crate) fn detail(self, detail: impl Into<String>) -> Self {
        Self(self.0.detail(detail))
    }

    /// What to do about it.
    pub(crate) fn hint(self, hint: impl Into<String>) -> Self {
        Self(self.0.with_hint(hint))
    }

    /// The same with its remedy in the words of who typed it.
    pub(crate) fn read_by(self, person: io::Addressee) -> Self {
        match self.0.hint().map(|hint| person.read(hint)) {
            Some(hint) => self.hint(hint),
            None => self,
        }
    }

    /// Whether nobody reads standard output any more (`proofmass … | head`).
    pub(crate) fn is_broken_pipe(&self) -> bool {
        self.0.kind() == TroubleKind::Closed
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for read in self.0.read() {
            writeln!(f, "Read  {}", Visible(read))?;
        }
        writeln!(
            f,
            "\x1b[1;31merror[{}]\x1b[0m: {}",
            self.0.code(),
            Visible(&self.0.to_string())
        )?;
        for detail in self.0.place() {
            writeln!(f, "  {}", Visible(detail))?;
        }
        if let Some(hint) = self.0.hint() {
            writeln!(f, "\x1b[1;36mhint\x1b[0m: {}", Visible(hint))?;
        }
        Ok(())
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        Self(trouble)
    }
}

impl From<Failure> for Trouble {
    fn from(failure: Failure) -> Self {
        failure.0
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self(error.into())
    }
}

impl From<proofmass::core::Error> for Failure {
    fn from(error: proofmass::core::Error) -> Self {
        Self(error.into())
    }
}

impl From<proofmass::report::Error> for Failure {
    fn from(error: proofmass::report::Error) -> Self {
        Self(error.into())
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        let kind = match error.kind() {
            std::io::ErrorKind::BrokenPipe => TroubleKind::Closed,
            _ => TroubleKind::Output,
        };
        Self(Trouble::new(kind, error.to_string()))
    }
}
