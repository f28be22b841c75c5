//! Why a job came to no result: what is wrong, where, what to do about it.

use crate::record::what_was_read;
use proofmass_io::Input;
use std::error::Error;
use std::fmt;
use std::sync::Arc;

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

impl TroubleKind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Request,
        Self::Data,
        Self::Output,
        Self::Cancelled,
        Self::Closed,
    ];

    /// The kind as a word that stays.
    pub fn code(self) -> &'static str {
        match self {
            Self::Request => "request",
            Self::Data => "data",
            Self::Output => "output",
            Self::Cancelled => "cancelled",
            Self::Closed => "closed",
        }
    }
}

/// Why a job came to no result.
///
/// The display is one line; [`Trouble::place`] has the lines that say where and on what evidence, [`Trouble::hint`]
/// the remedy.
///
/// [`Error::source`](std::error::Error::source) is the error of the room where it arose; [`Trouble::cause`] is the one
/// of the mathematics, to be matched:
///
/// ```
/// use proofmass_core::Error;
/// use proofmass_jobs::Trouble;
///
/// let trouble = Trouble::from(Error::Unobservable { parameter: "bias.x", condition: 1e17 });
/// assert!(matches!(trouble.about("run 7").cause(), Some(Error::Unobservable { parameter: "bias.x", .. })));
/// ```
#[derive(Debug, Clone)]
pub struct Trouble {
    what: String,
    read: Vec<String>,
    place: Vec<String>,
    hint: Option<String>,
    kind: TroubleKind,
    source: Option<Arc<dyn Error + Send + Sync>>,
}

/// What it says; where it arose is not compared.
impl PartialEq for Trouble {
    fn eq(&self, other: &Self) -> bool {
        let said = |t: &Self| {
            (
                t.what.clone(),
                t.read.clone(),
                t.place.clone(),
                t.hint.clone(),
                t.kind,
            )
        };
        said(self) == said(other)
    }
}

impl Eq for Trouble {}

/// Result with [`Trouble`].
pub type Result<T, E = Trouble> = std::result::Result<T, E>;

impl Trouble {
    /// What is wrong, in one line.
    pub fn new(kind: TroubleKind, what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            read: Vec::new(),
            place: Vec::new(),
            hint: None,
            kind,
            source: None,
        }
    }

    /// What an error of another room says, with the error itself.
    fn of(kind: TroubleKind, error: impl Error + Send + Sync + 'static) -> Self {
        Self {
            what: error.to_string(),
            source: Some(Arc::new(error)),
            ..Self::new(kind, "")
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

    /// Says how the files were read, where it is their content that carries no result: first of all a reader asks whether they
    /// were read as meant. What was said nearer to the data stays.
    #[must_use]
    pub fn read_as(mut self, inputs: &[Input]) -> Self {
        let of_content = matches!(self.kind, TroubleKind::Data | TroubleKind::Request);
        if of_content && self.read.is_empty() {
            self.read = what_was_read(inputs);
        }
        self
    }

    /// How each file was read, in one line each, where that is known: what a message begins with.
    pub fn read(&self) -> &[String] {
        &self.read
    }

    /// What kind of trouble it is.
    pub fn kind(&self) -> TroubleKind {
        self.kind
    }

    /// Where, and on what evidence.
    pub fn place(&self) -> &[String] {
        &self.place
    }

    /// The error of the mathematics behind it, where there is one.
    pub fn cause(&self) -> Option<&proofmass_core::Error> {
        self.behind()
    }

    /// What kind it is, as a word that stays: that of the error behind it, where there is one. [`error_codes`](crate::error_codes) has what
    /// each means.
    pub fn code(&self) -> &'static str {
        let of_file = || {
            self.behind::<proofmass_io::Error>()
                .map(|e| e.kind().code())
        };
        let of_numbers = || self.cause().map(proofmass_core::Error::code);
        let kind = || self.kind.code();
        of_file().or_else(of_numbers).unwrap_or_else(kind)
    }

    /// The first error of this type in the chain of sources.
    fn behind<E: Error + 'static>(&self) -> Option<&E> {
        let mut source = self.source();
        while let Some(error) = source {
            if let Some(found) = error.downcast_ref() {
                return Some(found);
            }
            source = error.source();
        }
        None
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

impl Error for Trouble {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        let source = self.source.as_deref()?;
        Some(source)
    }
}

impl From<proofmass_core::Error> for Trouble {
    fn from(error: proofmass_core::Error) -> Self {
        let kind = if error.is_cancelled() {
            TroubleKind::Cancelled
        } else {
            TroubleKind::Data
        };
        Self::of(kind, error)
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
        let hint = error.hint().map(str::to_owned);
        Self {
            hint,
            ..Self::of(kind, error)
        }
    }
}

impl From<proofmass_uncertainty::Refusal> for Trouble {
    fn from(refusal: proofmass_uncertainty::Refusal) -> Self {
        Self::of(TroubleKind::Data, refusal)
    }
}

impl From<proofmass_report::Error> for Trouble {
    fn from(error: proofmass_report::Error) -> Self {
        Self::of(TroubleKind::Output, error).about("the report cannot be drawn")
    }
}
