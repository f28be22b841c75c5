//! Errors as a person reads them: what is wrong, where, what to do.

use proofmass::core::Visible;
use proofmass::io;
use std::fmt;

/// Why a command ended without a result.
#[derive(Debug)]
pub(crate) struct Failure {
    what: String,
    details: Vec<String>,
    hint: Option<String>,
    broken_pipe: bool,
}

impl Failure {
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            details: Vec::new(),
            hint: None,
            broken_pipe: false,
        }
    }

    /// A line that says where, or on what evidence.
    pub(crate) fn detail(mut self, detail: impl Into<String>) -> Self {
        self.details.push(detail.into());
        self
    }

    /// What to do about it.
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same with its remedy in the words of who typed it.
    pub(crate) fn read_by(mut self, person: io::Addressee) -> Self {
        self.hint = self.hint.map(|hint| person.read(&hint));
        self
    }

    /// Whether nobody reads standard output any more (`proofmass … | head`).
    pub(crate) fn is_broken_pipe(&self) -> bool {
        self.broken_pipe
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\x1b[1;31merror\x1b[0m: {}", Visible(&self.what))?;
        for detail in &self.details {
            writeln!(f, "  {}", Visible(detail))?;
        }
        if let Some(hint) = &self.hint {
            writeln!(f, "\x1b[1;36mhint\x1b[0m: {}", Visible(hint))?;
        }
        Ok(())
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        let failure = Self {
            broken_pipe: error.kind() == io::ErrorKind::Closed,
            ..Self::new(error.to_string())
        };
        match error.hint() {
            Some(hint) => failure.hint(hint),
            None => failure,
        }
    }
}

impl From<proofmass::jobs::Trouble> for Failure {
    fn from(trouble: proofmass::jobs::Trouble) -> Self {
        let mut failure = Self::new(trouble.to_string());
        failure.details = trouble.place().to_vec();
        failure.hint = trouble.hint().map(str::to_owned);
        failure.broken_pipe = trouble.kind() == proofmass::jobs::TroubleKind::Closed;
        failure
    }
}

impl From<proofmass::core::Error> for Failure {
    fn from(error: proofmass::core::Error) -> Self {
        Self::new(error.to_string())
    }
}

impl From<proofmass::report::Error> for Failure {
    fn from(error: proofmass::report::Error) -> Self {
        Self::new(format!("the report cannot be drawn: {error}"))
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self {
            broken_pipe: error.kind() == std::io::ErrorKind::BrokenPipe,
            ..Self::new(error.to_string())
        }
    }
}
