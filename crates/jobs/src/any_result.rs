//! A result of whatever job: read by its kind, rendered again.

use crate::outcome::{Filed, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_io::{ResultDocument, StatedQuantity};
use proofmass_report::Report;
use proofmass_uncertainty::Finding;

/// A filed outcome of any kind, for callers that treat all alike: a viewer, a server, an archive.
pub trait AnyResult {
    /// Kind of the result, as in result.json.
    fn kind(&self) -> &'static str;
    /// What it is filed with.
    fn record(&self) -> &Record;
    /// The principal result.
    fn quantities(&self) -> Vec<StatedQuantity>;
    /// What to doubt.
    fn findings(&self) -> &[Finding];
    /// Whether a finding needs a decision before the result is used.
    fn needs_decision(&self) -> bool;
    /// What is worth a look in a terminal.
    fn summary(&self) -> Report;
    /// Name of the table that states the principal result, where there is one.
    fn principal_table(&self) -> &'static str;
    /// Bytes of result.json.
    ///
    /// # Errors
    /// A number that is not finite.
    fn to_json(&self) -> Result<Vec<u8>>;
    /// Every file of the result, by name.
    ///
    /// # Errors
    /// A number that is not finite.
    fn files(&self) -> Result<Vec<(String, Vec<u8>)>>;
}

impl<O: Outcome> AnyResult for Filed<O> {
    fn kind(&self) -> &'static str {
        O::KIND
    }

    fn record(&self) -> &Record {
        &self.record
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.outcome.quantities()
    }

    fn findings(&self) -> &[Finding] {
        self.outcome.findings()
    }

    fn needs_decision(&self) -> bool {
        self.outcome.needs_decision()
    }

    fn summary(&self) -> Report {
        Filed::summary(self)
    }

    fn principal_table(&self) -> &'static str {
        O::PRINCIPAL_TABLE
    }

    fn to_json(&self) -> Result<Vec<u8>> {
        Filed::to_json(self)
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        Filed::files(self)
    }
}

pub(crate) type Reader = fn(&[u8]) -> Result<Box<dyn AnyResult>>;

pub(crate) fn reader<O: Outcome + 'static>() -> (&'static str, Reader) {
    (O::KIND, |bytes| Ok(Box::new(Filed::<O>::from_json(bytes)?)))
}

/// Every kind of result, as `kind` in result.json: one for each job of [`AnyJob`](crate::AnyJob), where two jobs may
/// share a kind.
pub fn result_kinds() -> Vec<&'static str> {
    let mut kinds: Vec<&str> = Vec::new();
    for (kind, _) in crate::any_job::readers() {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    kinds
}

/// Reads a result.json of whatever kind.
///
/// ```
/// use proofmass_jobs::{Filed, Job, Record, Unwatched, read_result, uncertainty::UncertaintyJob};
///
/// let text = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
///             [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2 * m\"\n";
/// let job = UncertaintyJob { model: proofmass_io::read_model(text).unwrap(), ..Default::default() };
/// let filed = Filed::new(Record::default(), job.evaluate(&(), &Unwatched)?);
/// let read = read_result(&filed.to_json()?)?;
/// assert_eq!(read.kind(), "uncertainty");
/// assert_eq!(read.files()?, filed.files()?);
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
///
/// # Errors
/// Another kind of file, a kind this version does not know, a damaged file.
pub fn read_result(bytes: &[u8]) -> Result<Box<dyn AnyResult>> {
    let kind = ResultDocument::from_json(bytes)?.kind;
    let readers = crate::any_job::readers();
    match readers.iter().find(|(name, _)| *name == kind) {
        Some((_, read)) => read(bytes),
        None => Err(Trouble::data(format!(
            "the result is of kind `{kind}`, which cannot be read again"
        ))
        .with_hint(format!("kinds that can: {}", result_kinds().join(", ")))),
    }
}
