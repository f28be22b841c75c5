//! A job and its outcome: the one place where a result is decided.

use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_io::{AnyCalibration, Cell, NamedCovariance, ResultDocument, StatedQuantity, Table};
use proofmass_report::{Report, html};
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
}

/// The answer of a job, typed, written and read again as the same type.
///
/// What the result is (value, U, k, ν, by which method, what is to be doubted) is decided when an outcome is made.
/// Files, pages, terminal and servers repeat it; nothing here computes.
#[doc(alias("result"))]
pub trait Outcome: Serialize + DeserializeOwned {
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

    /// The joint estimate behind the quantities, where there is one.
    fn estimate(&self) -> Option<&Estimate> {
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

    /// Tables, by file name.
    ///
    /// # Errors
    /// A number that is not finite.
    fn tables(&self) -> Result<Vec<(String, Table)>> {
        Ok(Vec::new())
    }

    /// Files of other kinds, by name.
    ///
    /// # Errors
    /// A number that is not finite.
    fn attachments(&self, _record: &Record) -> Result<Vec<(String, Vec<u8>)>> {
        Ok(Vec::new())
    }

    /// What compensation needs, where the outcome is a calibration.
    ///
    /// # Errors
    /// A response that contradicts itself.
    fn calibration(&self, _record: &Record) -> Result<Option<AnyCalibration>> {
        Ok(None)
    }

    /// What is worth a look in a terminal.
    fn summary(&self, record: &Record) -> Report;

    /// The whole report.
    fn report(&self, record: &Record) -> Report;

    /// Whether a finding needs a decision before the result is used.
    fn needs_decision(&self) -> bool {
        self.findings()
            .iter()
            .any(|f| f.severity() == Severity::Decision)
    }
}

/// An outcome with what it is filed with: what `result.json` holds.
#[doc(alias("result.json"))]
#[derive(Clone, Debug, PartialEq)]
pub struct Filed<O> {
    /// Device, conditions, date, inputs, software.
    pub record: Record,
    /// The answer.
    pub outcome: O,
}

/// Name of result.json in a folder of results.
pub const RESULT: &str = "result.json";
/// Name of the report in a folder of results.
pub const REPORT: &str = "report.html";
/// Name of the table of the principal result, where a job has none of its own.
pub const QUANTITIES: &str = "quantities.csv";
/// Name of the calibration in a folder of results.
pub const CALIBRATION: &str = "calibration.json";

impl<O: Outcome> Filed<O> {
    /// Files an outcome.
    pub fn new(record: Record, outcome: O) -> Self {
        Self { record, outcome }
    }

    /// The result document.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn document(&self) -> Result<ResultDocument> {
        let record = &self.record;
        let mut document = ResultDocument::new(O::KIND)
            .device(&record.device)
            .findings(self.outcome.findings());
        document.software = record.software.clone();
        document.title = Some(self.outcome.title(record));
        document.model = self.outcome.model();
        document.inputs = record.inputs.clone();
        document.quantities = self.outcome.quantities();
        if let Some(estimate) = self.outcome.estimate() {
            document.covariance = Some(NamedCovariance::of(estimate));
            document.estimate = Some(estimate.clone());
        }
        document = document.section("date", &record.date)?;
        document = document.section("ambient", &record.ambient)?;
        for (name, value) in self.outcome.sections()? {
            document = document.section(name, &value)?;
        }
        Ok(document.section("outcome", &self.outcome)?)
    }

    /// Bytes of result.json.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        Ok(self.document()?.to_json()?)
    }

    /// Reads a result again.
    ///
    /// # Errors
    /// Another kind of file or of result, or a damaged one.
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let mut document = ResultDocument::from_json(bytes)?;
        if document.kind != O::KIND {
            return Err(Trouble::data(format!(
                "the result is of kind `{}`, not `{}`",
                document.kind,
                O::KIND
            )));
        }
        let part = |name: &str, value: Option<serde_json::Value>| {
            value.ok_or_else(|| {
                Trouble::data(format!("the result has no section `{name}`"))
                    .with_hint("it was written by an earlier version: calibrate again")
            })
        };
        let damaged = |e: serde_json::Error| Trouble::data(format!("the result is damaged: {e}"));
        let outcome = part("outcome", document.extra.remove("outcome"))?;
        let mut section = |name: &str| document.extra.remove(name).unwrap_or_default();
        let date = serde_json::from_value(section("date")).map_err(damaged)?;
        let ambient = match section("ambient") {
            serde_json::Value::Null => Default::default(),
            value => serde_json::from_value(value).map_err(damaged)?,
        };
        Ok(Self {
            record: Record {
                title: document.title,
                device: document.device,
                ambient,
                date,
                inputs: document.inputs,
                software: document.software,
            },
            outcome: serde_json::from_value(outcome).map_err(damaged)?,
        })
    }

    /// What is worth a look in a terminal.
    pub fn summary(&self) -> Report {
        self.outcome.summary(&self.record)
    }

    /// The page.
    ///
    /// # Errors
    /// A number that cannot be drawn.
    pub fn html(&self) -> Result<String> {
        Ok(html::render(&self.outcome.report(&self.record))?)
    }

    /// Every file of the result, by name: `result.json`, `report.html`, tables, a calibration where it is one.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let mut files = vec![
            (RESULT.to_owned(), self.to_json()?),
            (REPORT.to_owned(), self.html()?.into_bytes()),
        ];
        if let Some(calibration) = self.outcome.calibration(&self.record)? {
            files.push((CALIBRATION.to_owned(), calibration.to_json()?));
        }
        let quantities = self.outcome.quantities();
        if O::PRINCIPAL_TABLE == QUANTITIES && !quantities.is_empty() {
            files.push((QUANTITIES.to_owned(), stated(&quantities)?.to_csv()?));
        }
        for (name, table) in self.outcome.tables()? {
            files.push((name, table.to_csv()?));
        }
        files.extend(self.outcome.attachments(&self.record)?);
        Ok(files)
    }
}

/// A table of quantities as they are stated, one to a row; what is not known is an empty field.
pub(crate) fn stated(quantities: &[StatedQuantity]) -> Result<Table> {
    let mut table = Table::new([
        "quantity",
        "value",
        "unit",
        "u",
        "U",
        "k",
        "nu_eff",
        "probability",
        "low",
        "high",
    ]);
    for q in quantities {
        let nu = q.nu_eff.map(|nu| nu.get()).filter(|nu| nu.is_finite());
        table.push([
            Cell::from(q.name.as_str()),
            Cell::from(q.value),
            Cell::from(q.unit.as_str()),
            Cell::from(q.u),
            Cell::from(q.expanded),
            Cell::from(q.k),
            Cell::from(nu),
            Cell::from(q.probability),
            Cell::from(q.interval.map(|[low, _]| low)),
            Cell::from(q.interval.map(|[_, high]| high)),
        ])?;
    }
    Ok(table)
}

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
