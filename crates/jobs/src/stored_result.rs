//! A result as data: what `result.json` holds, and every file that is made from it.

use crate::findings;
use crate::outcome::{Outcome, QUANTITIES};
use crate::page::answer::answer_first;
use crate::record::{READINGS, Record, named};
use crate::trouble::{Result, Trouble};
use proofmass_documents::{
    AnyCalibration, RESULT_VERSION, ResultDocument, StatedQuantity, TrialFile,
};
use proofmass_io::{Cell, Input, Table};
use proofmass_report::{Place, Report, Section, html};
use proofmass_uncertainty::{Estimate, Finding};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Name of result.json in a folder of results.
pub const RESULT: &str = "result.json";
/// Name of the report in a folder of results.
pub const REPORT: &str = "report.html";
/// Name of the calibration in a folder of results.
pub const CALIBRATION: &str = "calibration.json";

/// Cells of a table that only a file has, from which on result.json leaves it out: a value for every sample of a recording.
const LONG: usize = 200_000;
/// Section with page and files.
const SHOWN: &str = "shown";
/// Section with what compensation needs.
const CALIBRATION_SECTION: &str = "calibration";

/// A result of whatever job: quantities, findings, page, tables and calibration, without a type of the job.
///
/// ```
/// use proofmass_jobs::{Job, Record, StoredResult, Unwatched, uncertainty::UncertaintyJob};
///
/// let text = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
///             [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2 * m\"\n";
/// let job = UncertaintyJob { model: proofmass_documents::read_model(text).unwrap(), ..Default::default() };
/// let result = StoredResult::new(Record::default(), &job.evaluate(&(), &Unwatched)?)?;
/// let read = StoredResult::from_json(&result.to_json()?)?;
/// assert_eq!(read.kind(), "uncertainty");
/// assert_eq!(read.files()?, result.files()?);
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[doc(alias("result.json"))]
#[derive(Clone, Debug, PartialEq)]
pub struct StoredResult {
    document: ResultDocument,
    record: Record,
    calibration: Option<AnyCalibration>,
    shown: Shown,
    /// Files that stand beside result.json alone.
    beside: Vec<(String, Vec<u8>)>,
}

/// What a page and the files beside it are made from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Shown {
    /// Table of the principal result.
    principal_table: String,
    /// Sections between head and inputs.
    page: Report,
    /// Files whose text is no table of the page.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    files: BTreeMap<String, String>,
}

/// The schemas of the sections of `extra` that every result may have.
#[cfg(feature = "schema")]
pub(crate) fn result_extra_schemas(
    generator: &mut schemars::SchemaGenerator,
) -> Vec<(&'static str, schemars::Schema)> {
    vec![
        (SHOWN, generator.subschema_for::<Shown>()),
        ("date", generator.subschema_for::<Option<String>>()),
        (
            "ambient",
            generator.subschema_for::<proofmass_documents::Ambient>(),
        ),
    ]
}

/// One digest for all inputs, where paper does not have each: that of their lines as `sha256sum` writes them.
fn digest_of_list(inputs: &[(String, String)]) -> String {
    let lines: String = inputs
        .iter()
        .map(|(path, digest)| format!("{digest}  {path}\n"))
        .collect();
    format!(
        "{} files. SHA-256 of their list, a line `digest  name` for each in the order of result.json: {}.",
        inputs.len(),
        proofmass_io::sha256(&[lines.as_bytes()])
    )
}

impl StoredResult {
    /// The file of a result: itself, or result.json of a folder.
    pub fn place(path: &std::path::Path) -> std::path::PathBuf {
        if path.is_dir() {
            path.join(RESULT)
        } else {
            path.to_path_buf()
        }
    }

    /// The file of a calibration: itself, or of a folder of results calibration.json, else result.json.
    pub fn calibration_place(path: &std::path::Path) -> std::path::PathBuf {
        let inside = ["calibration.json", RESULT].map(|name| path.join(name));
        let held = inside.into_iter().find(|file| file.is_file());
        held.unwrap_or_else(|| path.to_path_buf())
    }

    /// Puts an outcome beside what the caller knows: device, conditions, date, inputs, software.
    ///
    /// # Errors
    /// A number that is not finite; a response that contradicts itself.
    pub fn new<O: Outcome>(mut record: Record, outcome: &O) -> Result<Self> {
        if let Some(gravity) = outcome.gravity() {
            let readings = record.inputs.iter_mut().filter_map(|i| i.reading.as_mut());
            for reading in readings.filter(|reading| reading.gravity.is_none()) {
                reading.gravity = Some(gravity.clone());
            }
        }
        let mut document = ResultDocument::new(O::KIND)
            .device(&record.device)
            .findings(outcome.findings());
        document.findings.extend(doubts_of_inputs(&record.inputs));
        document.software = record.software.clone();
        document.title = Some(outcome.title(&record));
        document.model = outcome.model();
        document.inputs = record.inputs.clone();
        document.quantities = outcome.quantities();
        if let Some(estimate) = outcome.estimate() {
            document = document.joint(estimate);
        }
        document = document.section("date", &record.date)?;
        document = document.section("ambient", &record.ambient)?;
        for (name, value) in outcome.sections()? {
            document = document.section(name, &value)?;
        }
        let page = answer_first(outcome.page(Report::default()), &document.quantities).shortened();
        let mut files = BTreeMap::new();
        for (name, bytes) in outcome.attachments(&record)? {
            let text = String::from_utf8(bytes)
                .map_err(|_| Trouble::data(format!("the file {name} is no text")))?;
            files.insert(name, text);
        }
        let calibration = outcome.calibration(&record)?;
        let shown = Shown {
            principal_table: O::PRINCIPAL_TABLE.to_owned(),
            page,
            files,
        };
        Ok(Self {
            document,
            record,
            calibration,
            shown,
            beside: outcome.beside()?,
        })
    }

    /// Reads a result.
    ///
    /// # Errors
    /// Another kind of file, another form, a damaged one.
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let mut document = ResultDocument::from_json(bytes)?;
        if document.schema.version < RESULT_VERSION {
            return Err(Trouble::data(format!(
                "the result is of form {}, which has no page of its own",
                document.schema.version
            ))
            .with_hint("evaluate it again, or use the version of proofmass that wrote it; it stands under `software`"));
        }
        let mut shown: Shown = part(&document, SHOWN)?;
        // Pages that were written before a page had an answer.
        shown.page = answer_first(shown.page, &document.quantities);
        document.extra.remove(SHOWN);
        if !shown.page.is_whole() {
            return Err(Trouble::data("the result is damaged: a row of one of its tables is not as long as the table is wide")
                .with_hint("take a copy of the result, or evaluate it again"));
        }
        let tables = shown.page.filed_tables();
        let names = tables.iter().map(|t| &t.file).chain(shown.files.keys());
        for name in names {
            if name.contains(['/', '\\', '\0']) || name == ".." {
                return Err(Trouble::data(format!(
                    "the result names a file outside of its folder: {name:?}"
                )));
            }
        }
        let calibration = document.extra.remove(CALIBRATION_SECTION);
        let calibration = calibration
            .map(|value| AnyCalibration::from_json(value.to_string().as_bytes()))
            .transpose()?;
        let record = Record {
            title: document.title.clone(),
            device: document.device.clone(),
            ambient: part(&document, "ambient")?,
            date: part(&document, "date")?,
            inputs: document.inputs.clone(),
            software: document.software.clone(),
        };
        Ok(Self {
            document,
            record,
            calibration,
            shown,
            beside: Vec::new(),
        })
    }

    /// Adds the files that stand beside result.json alone, from where it was read; `read` gives the bytes of a name.
    ///
    /// # Errors
    /// A file that is not there, or not the one that was written with the result.
    pub fn with_files_beside(mut self, read: impl Fn(&str) -> Result<Vec<u8>>) -> Result<Self> {
        if let Some(trials) = TrialFile::in_result(&self.document)? {
            let bytes = read(&trials.file)?;
            trials.table(bytes.clone(), &self.document)?;
            self.beside = vec![(trials.file, bytes)];
        }
        Ok(self)
    }

    /// Bytes of result.json. Tables with a row for every sample of a long recording, which no page shows, stand in their file alone.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        let shown = Shown {
            principal_table: self.shown.principal_table.clone(),
            page: self.shown.page.without_long_files(LONG),
            files: self.shown.files.clone(),
        };
        let mut document = self.document.clone().section(SHOWN, &shown)?;
        if let Some(calibration) = &self.calibration {
            let value: serde_json::Value = serde_json::from_slice(&calibration.to_json()?)
                .map_err(|e| Trouble::data(format!("the calibration has no form in JSON: {e}")))?;
            document = document.section(CALIBRATION_SECTION, &value)?;
        }
        Ok(document.to_json()?)
    }

    /// Kind of the result, as in result.json.
    pub fn kind(&self) -> &str {
        &self.document.kind
    }

    /// What it is filed with.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The principal result.
    pub fn quantities(&self) -> &[StatedQuantity] {
        &self.document.quantities
    }

    /// The joint estimate behind the quantities, where there is one.
    ///
    /// # Errors
    /// It says otherwise than the quantities.
    pub fn estimate(&self) -> Result<Option<&Estimate>> {
        Ok(self.document.stated()?)
    }

    /// What compensation needs, where the result is a calibration.
    pub fn calibration(&self) -> Option<&AnyCalibration> {
        self.calibration.as_ref()
    }

    /// A part of the result that only its kind has.
    pub fn section(&self, name: &str) -> Option<&serde_json::Value> {
        self.document.extra.get(name)
    }

    /// The files that stand beside result.json alone, by name: what [`StoredResult::with_files_beside`] asks for.
    pub fn beside(&self) -> &[(String, Vec<u8>)] {
        &self.beside
    }

    /// What to doubt.
    pub fn findings(&self) -> &[Finding] {
        &self.document.findings
    }

    /// Name of the table that states the principal result, where there is one.
    pub fn principal_table(&self) -> &str {
        &self.shown.principal_table
    }

    /// Page and summary as data.
    pub fn report(&self) -> Report {
        let mut page = self.shown.page.clone();
        page.title = self.document.title.clone().unwrap_or_default();
        if page.language.is_empty() {
            page.language = "en".to_owned();
        }
        let mut readings = self.record.readings().into_iter();
        let inputs = self.record.digests();
        let files: Vec<&str> = inputs.iter().map(|(path, _)| path.as_str()).collect();
        // Tables, results and requests have no columns to tell; what was read is said all the same.
        if readings.len() == 0 && !inputs.is_empty() {
            page = page.reading_at_least(named(&files));
        }
        for (_, first) in readings.by_ref().take(READINGS) {
            page = page.reading(first);
        }
        page.meta = [readings.collect(), self.record.meta(), page.meta].concat();
        page = page.findings(self.findings().iter().cloned());
        if !inputs.is_empty() {
            let mut section = Section::new("Inputs");
            if inputs.len() > Section::FEW_INPUTS {
                section = section.paragraph(digest_of_list(&inputs));
            }
            page = page.section(section.inputs(&inputs));
        }
        page.footer(self.record.software.to_string())
    }

    /// What is worth a look in a terminal.
    pub fn summary(&self) -> Report {
        self.report().of(Place::Summary)
    }

    /// The page.
    ///
    /// # Errors
    /// A number that cannot be drawn.
    pub fn html(&self) -> Result<String> {
        Ok(html::render(&self.report().of(Place::Page))?)
    }

    /// Bytes of a table of the page, by the name of its file.
    ///
    /// # Errors
    /// No table of that name.
    pub fn table(&self, name: &str) -> Result<Vec<u8>> {
        let tables = self.shown.page.filed_tables();
        match tables.into_iter().find(|table| table.file == name) {
            Some(table) => as_filed(table),
            None => Err(Trouble::data(format!("the result has no table {name}"))),
        }
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
        if let Some(calibration) = &self.calibration {
            files.push((CALIBRATION.to_owned(), calibration.to_json()?));
        }
        if self.principal_table() == QUANTITIES && !self.quantities().is_empty() {
            files.push((QUANTITIES.to_owned(), stated(self.quantities())?.to_csv()?));
        }
        for table in self.shown.page.filed_tables() {
            files.push((table.file.clone(), as_filed(table)?));
        }
        let texts = self.shown.files.iter();
        files.extend(texts.map(|(name, text)| (name.clone(), text.clone().into_bytes())));
        files.extend(self.beside.iter().cloned());
        Ok(files)
    }
}

/// What there is to doubt about the files themselves: one that was changed after it was written, copies that pass for repeats.
pub(crate) fn doubts_of_inputs(inputs: &[Input]) -> Vec<Finding> {
    let mut doubts: Vec<Finding> = inputs.iter().flat_map(Input::findings).collect();
    let mut recordings: BTreeMap<&str, Vec<&Input>> = BTreeMap::new();
    for input in inputs.iter().filter(|i| i.reading.is_some()) {
        recordings.entry(&input.sha256).or_default().push(input);
    }
    for same in recordings.values() {
        // Several stretches or columns of one recording are no copies.
        let copies = same[1..].iter().filter(|i| i.reading == same[0].reading);
        let copies: Vec<&str> = copies.map(|i| i.path.as_str()).collect();
        if !copies.is_empty() {
            let copies = copies.join(", ");
            doubts.push(findings::same_recording_twice(&same[0].path, &copies));
        }
    }
    doubts
}

/// A part of a result.json that another job reads back, of this kind of result.
///
/// # Errors
/// Another kind of file or of result, an earlier form, a damaged file.
pub(crate) fn read_section<T: DeserializeOwned>(
    bytes: &[u8],
    kind: &str,
    name: &str,
) -> Result<(T, ResultDocument)> {
    let document = ResultDocument::from_json(bytes)?;
    if document.kind != kind {
        return Err(Trouble::data(format!(
            "the result is of kind `{}`, not `{kind}`",
            document.kind
        )));
    }
    Ok((part(&document, name)?, document))
}

fn part<T: DeserializeOwned>(document: &ResultDocument, name: &str) -> Result<T> {
    let value = document.extra.get(name).ok_or_else(|| {
        Trouble::data(format!("the result has no section `{name}`"))
            .with_hint("it was written by an earlier version: evaluate it again")
    })?;
    T::deserialize(value)
        .map_err(|e| Trouble::data(format!("the result is damaged: in `{name}`, {e}")))
}

/// Rows that are written at a time: a table of a million needs no copy of itself.
const ROWS: usize = 4096;

/// A table of a page as its file has it.
pub(crate) fn as_filed(table: &proofmass_report::Table) -> Result<Vec<u8>> {
    use proofmass_report::Cell as Shown;
    let mut csv = Vec::new();
    let mut start = 0;
    while start == 0 || start < table.rows.len() {
        let end = table.rows.len().min(start + ROWS);
        let mut part = proofmass_report::Table::default();
        part.columns = table.columns.clone();
        part.rows = table.rows[start..end].to_vec();
        let (names, rows) = part.records();
        let mut file = Table::new(names);
        for row in rows {
            file.push(row.into_iter().map(|cell| match cell {
                Shown::Value(value) | Shown::Estimate(value, _) => Cell::Number(value),
                Shown::Text(text)
                | Shown::Linked { text, .. }
                | Shown::Number { text }
                | Shown::Worded { text, .. } => Cell::Text(text),
                Shown::Quantity(q) => Cell::Number(q.value),
                Shown::Empty => Cell::Missing,
            }))?;
        }
        let written = file.to_csv()?;
        let heading = written
            .iter()
            .position(|b| *b == b'\n')
            .map_or(0, |n| n + 1);
        csv.extend_from_slice(&written[if start == 0 { 0 } else { heading }..]);
        start = end.max(1);
    }
    Ok(csv)
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
            Cell::from(q.symmetric()),
            Cell::from(q.k.filter(|_| q.interval.is_none())),
            Cell::from(nu),
            Cell::from(q.probability),
            Cell::from(q.interval.map(|[low, _]| low)),
            Cell::from(q.interval.map(|[_, high]| high)),
        ])?;
    }
    Ok(table)
}
