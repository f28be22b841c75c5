//! Why a job came to no result: what is wrong, where, what to do about it.

use std::fmt;

/// What kind of trouble it is, for callers that act on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TroubleKind {
    /// The request contradicts itself or asks for what there is not.
    Request,
    /// The data cannot be read, or do not carry the result that is asked for.
    Data,
    /// The outcome cannot be put into a file.
    Output,
    /// The onlooker stopped the job.
    Cancelled,
    /// Nobody reads what is written any more.
    Closed,
}

/// Why a job came to no result.
///
/// The display is one line; [`Trouble::place`] has the lines that say where and on what evidence, [`Trouble::hint`]
/// the remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trouble {
    what: String,
    place: Vec<String>,
    hint: Option<String>,
    kind: TroubleKind,
}

/// Result with [`Trouble`].
pub type Result<T, E = Trouble> = std::result::Result<T, E>;

impl Trouble {
    /// What is wrong, in one line.
    pub fn new(kind: TroubleKind, what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            place: Vec::new(),
            hint: None,
            kind,
        }
    }

    /// Data that cannot be read or do not carry the result.
    pub fn data(what: impl Into<String>) -> Self {
        Self::new(TroubleKind::Data, what)
    }

    /// A request that cannot be met whatever the data.
    pub fn request(what: impl Into<String>) -> Self {
        Self::new(TroubleKind::Request, what)
    }

    /// Adds a line that says where, or on what evidence.
    #[must_use]
    pub fn detail(mut self, detail: impl Into<String>) -> Self {
        self.place.push(detail.into());
        self
    }

    /// Sets what to do about it.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Puts the name of the thing that was at work before the message: `run 7: …`.
    #[must_use]
    pub fn about(mut self, subject: impl fmt::Display) -> Self {
        self.what = format!("{subject}: {}", self.what);
        self
    }

    /// What kind of trouble it is.
    pub fn kind(&self) -> TroubleKind {
        self.kind
    }

    /// Where, and on what evidence.
    pub fn place(&self) -> &[String] {
        &self.place
    }

    /// What to do about it.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Trouble {}

impl From<proofmass_core::Error> for Trouble {
    fn from(error: proofmass_core::Error) -> Self {
        let kind = if error.is_cancelled() {
            TroubleKind::Cancelled
        } else {
            TroubleKind::Data
        };
        Self::new(kind, error.to_string())
    }
}

impl From<proofmass_io::Error> for Trouble {
    fn from(error: proofmass_io::Error) -> Self {
        let kind = match error.kind() {
            proofmass_io::ErrorKind::Configuration => TroubleKind::Request,
            proofmass_io::ErrorKind::Output => TroubleKind::Output,
            proofmass_io::ErrorKind::Closed => TroubleKind::Closed,
            _ => TroubleKind::Data,
        };
        let trouble = Self::new(kind, error.to_string());
        match error.hint() {
            Some(hint) => trouble.with_hint(hint),
            None => trouble,
        }
    }
}

impl From<proofmass_uncertainty::Refusal> for Trouble {
    fn from(refusal: proofmass_uncertainty::Refusal) -> Self {
        Self::data(refusal.to_string())
    }
}

impl From<proofmass_report::Error> for Trouble {
    fn from(error: proofmass_report::Error) -> Self {
        Self::new(
            TroubleKind::Output,
            format!("the report cannot be drawn: {error}"),
        )
    }
}
