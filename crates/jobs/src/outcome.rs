//! A job and its outcome: the one place where a result is decided.

use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_io::{Input, ReadGravity};
use proofmass_report::Report;
use proofmass_uncertainty::{Estimate, Finding, Severity};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A question as plain data: what a campaign, options of a command line, JSON of a server all become.
///
/// SI, no paths, no clock. The same request and data give the same outcome, bit for bit.
pub trait Job: Serialize + DeserializeOwned {
    /// The data of the question: slices, or a stream.
    type Data<'a>;
    /// The answer.
    type Outcome: Outcome;

    /// Answers the question.
    ///
    /// # Errors
    /// What is wrong with request or data; [`TroubleKind::Cancelled`](crate::TroubleKind::Cancelled) when `watch` wanted it to stop.
    fn evaluate(&self, data: &Self::Data<'_>, watch: &dyn Watch) -> Result<Self::Outcome>;

    /// The same where the files behind the data are known: a refusal begins with how they were read.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    fn answer(
        &self,
        data: &Self::Data<'_>,
        inputs: &[Input],
        watch: &dyn Watch,
    ) -> Result<Self::Outcome> {
        let outcome = self.evaluate(data, watch);
        outcome.map_err(|trouble| trouble.read_as(inputs))
    }
}

/// The answer of a job, typed; [`StoredResult`](crate::StoredResult) is what is written of it and read again.
///
/// What the result is (value, U, k, ν, by which method, what is to be doubted) is decided when an outcome is made.
/// Files, pages, terminal and servers repeat it; nothing here computes.
#[doc(alias("result"))]
pub trait Outcome {
    /// Kind of the result, as `kind` in result.json.
    const KIND: &'static str;

    /// Table that states the principal result: one of the outcome's own where it has one, else [`QUANTITIES`].
    const PRINCIPAL_TABLE: &'static str = QUANTITIES;

    /// Title of a report and of result.json: the one given, or one of the job's own.
    fn title(&self, record: &Record) -> String;

    /// The principal result.
    fn quantities(&self) -> Vec<StatedQuantity>;

    /// What to doubt, the gravest first.
    fn findings(&self) -> &[Finding];

    /// The joint estimate behind the quantities, where there is one: it says what the quantities say.
    fn estimate(&self) -> Option<&Estimate> {
        None
    }

    /// Local gravity that the recordings were held against, where the record does not say it.
    fn gravity(&self) -> Option<ReadGravity> {
        None
    }

    /// Name of the fitted model or method.
    fn model(&self) -> Option<String> {
        None
    }

    /// Sections of result.json that machines rely on, by name, beside the outcome itself.
    ///
    /// # Errors
    /// A number that is not finite.
    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(Vec::new())
    }

    /// Files of other kinds, by name.
    ///
    /// # Errors
    /// A number that is not finite.
    fn attachments(&self, _record: &Record) -> Result<Vec<(String, Vec<u8>)>> {
        Ok(Vec::new())
    }

    /// Files that stand beside result.json alone, by name, with their digests in a section of it: what another calculation
    /// reads, and no page shows.
    ///
    /// # Errors
    /// A number that is not finite.
    fn beside(&self) -> Result<Vec<(String, Vec<u8>)>> {
        Ok(Vec::new())
    }

    /// What compensation needs, where the outcome is a calibration.
    ///
    /// # Errors
    /// A response that contradicts itself.
    fn calibration(&self, _record: &Record) -> Result<Option<AnyCalibration>> {
        Ok(None)
    }

    /// Adds to an opened page what the result says: a line under the title, the verdict in words, sections with their tables
    /// and figures.
    ///
    /// The page opens with its [`Answer`](proofmass_report::Answer). Where the job names no numbers for it, they are the first
    /// quantities, else the first key figures; where it names no plot, it is the first one.
    /// Sections of the summary say so by their [`Place`](proofmass_report::Place); tables that name a file are written there too. Findings,
    /// inputs, device and the last line are added by whoever opened the page.
    fn page(&self, page: Report) -> Report;

    /// Whether a finding needs a decision before the result is used.
    fn needs_decision(&self) -> bool {
        self.findings()
            .iter()
            .any(|f| f.severity() == Severity::Decision)
    }
}

/// Name of the table of the principal result, where a job has none of its own.
pub const QUANTITIES: &str = "quantities.csv";

/// A section for [`Outcome::sections`].
///
/// # Errors
/// A number that is not finite.
pub fn section(
    name: &'static str,
    value: &impl Serialize,
) -> Result<(&'static str, serde_json::Value)> {
    let value = proofmass_io::finite::to_value(value).map_err(Trouble::from)?;
    Ok((name, value))
}
