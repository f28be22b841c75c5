//! Calibration certificates: those of others read, our own drafted, checked and released.
//!
//! A certificate is a job: a request (laboratory, customer, item, language, rule, number) and the stored result of a calibration become an
//! outcome, which is filed like any other. Sheet, digital certificate, page and terminal are made from the same texts and rounded numbers.

mod blocks;
mod conformity;
mod content;
mod digital;
mod figure;
mod laboratory;
pub mod reading;
pub mod register;
mod results;
mod sheet;
mod standards;
mod stated;
mod texts;

pub use conformity::{Decided, DecidedEntry};
pub use content::says;
pub use laboratory::{
    CalibrationPlace, CertificateFile, ConformityEntry, Contact, Item, Numbering, Performance,
    RuleWord, Signatory, Standard, Statement,
};
pub use results::{StatedColumn, StatedNumber, StatedResults, StatedSingle, StatedTable};
pub use texts::Language;

use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use crate::{RESULT, StoredResult};
use content::Content;
use proofmass_core::Watch;
use proofmass_documents::{DigitalCertificate, StatedQuantity, base64};
use proofmass_io::sha256;
use proofmass_report::Report;
use proofmass_uncertainty::Finding;
use register::Registered;
use serde::{Deserialize, Serialize};
use sheet::{Sheet, SheetAttachment};

/// Name of the digital certificate in a folder of results.
pub const DIGITAL: &str = "certificate.xml";
/// Name of the sheet in a folder of results: what the typesetter lays out, but for the files inside of the document.
pub const SHEET: &str = "sheet.json";
/// Name of the typeset certificate in a folder of results.
pub const PAPER: &str = "certificate.pdf";

/// Whether a number is the word that a draft has in the place of one, in any language.
pub(crate) fn is_draft(number: &str) -> bool {
    Language::ALL
        .iter()
        .any(|l| texts::Text::Draft.of(*l) == number)
}

/// A certificate that is replaced, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Replaced {
    /// Its number.
    pub number: String,
    /// Why.
    pub reason: String,
    /// Whether it named another item, and that was what was wrong.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub other_item: bool,
}

/// A certificate of a result. Without a number it is a draft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CertificateJob {
    /// Laboratory, customer, item, standards, rule.
    #[serde(flatten)]
    pub file: CertificateFile,
    /// Language of the texts.
    pub language: Language,
    /// Numbers of a certificate in Persian with the digits of Persian.
    pub persian_digits: bool,
    /// Number; a released certificate has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// Day of issue (ISO 8601).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub issued: Option<String>,
    /// What it replaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replaces: Option<Replaced>,
}

/// The results that are certified.
#[derive(Clone, Copy, Debug)]
pub struct CertificateData<'a> {
    /// The result; as left where the item was adjusted.
    pub result: &'a StoredResult,
    /// The result as found, where the item was adjusted.
    pub as_found: Option<&'a StoredResult>,
    /// Digital certificates of the standards, known by their digests.
    pub certificates: &'a [DigitalCertificate],
    /// Certificates that the laboratory has released.
    pub released: &'a [Registered],
    /// Names of files that the result was computed from and that are not there any more.
    pub lost: &'a [String],
}

impl<'a> CertificateData<'a> {
    /// Of a result alone.
    pub fn new(result: &'a StoredResult) -> Self {
        Self {
            result,
            as_found: None,
            certificates: &[],
            released: &[],
            lost: &[],
        }
    }
}

/// A certificate or a draft of one.
#[derive(Clone, Debug)]
pub struct CertificateOutcome {
    content: Content,
    number: Option<String>,
    language: Language,
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    sheet: Sheet,
    xml: String,
    result: Vec<u8>,
}

impl Job for CertificateJob {
    type Data<'a> = CertificateData<'a>;
    type Outcome = CertificateOutcome;

    fn evaluate(
        &self,
        data: &CertificateData<'_>,
        watch: &dyn Watch,
    ) -> Result<CertificateOutcome> {
        watch.step("certificate", 0, 1)?;
        let result = data.result;
        let content = Content::of(self, data)?;
        if let (Some(number), false) = (&self.number, content.missing.is_empty()) {
            return Err(incomplete(number, &content.missing));
        }
        // Notes about the result are for the laboratory: a draft has them, what is handed over does not.
        let mut listed: Vec<Finding> = match self.number {
            Some(_) => Vec::new(),
            None => result.findings().to_vec(),
        };
        if !content.missing.is_empty() {
            let list = content.missing.join("; ");
            listed.insert(
                0,
                findings::certificate_incomplete(content.missing.len(), &list),
            );
        }
        let bytes = result.to_json()?;
        let digest = sha256(&[&bytes]);
        let outcome = CertificateOutcome {
            sheet: blocks::sheet(self, &content, digest)?,
            xml: digital::certificate(self, &content, result, &bytes)?.to_xml(),
            number: self.number.clone(),
            language: self.language,
            quantities: results::stated(result).cloned().collect(),
            findings: listed,
            content,
            result: bytes,
        };
        watch.step("certificate", 1, 1)?;
        Ok(outcome)
    }
}

/// How much is missing, in words: `one thing is missing to a certificate`.
pub fn lack(missing: usize) -> String {
    let how_much = match missing {
        0 => "nothing is".to_owned(),
        1 => "one thing is".to_owned(),
        n => format!("{n} things are"),
    };
    format!("{how_much} missing to a certificate")
}

/// What to do about what is missing: keys are added to a file, an open decision is settled where the result is computed.
pub fn what_to_add(missing: &[String]) -> &'static str {
    let open = missing.iter().filter(|m| m.starts_with(OPEN)).count();
    match open {
        0 => "add them to LAB.toml or to the file of the order",
        n if n == missing.len() => {
            "follow the advice of each open decision, and evaluate the result again; `proofmass explain CODE` says what it means"
        }
        _ => {
            "add what is missing to LAB.toml or to the file of the order; follow the advice of each open decision, and evaluate the result again"
        }
    }
}

/// How a line begins that is about a decision that was not made.
const OPEN: &str = "an open decision of the result";

fn incomplete(number: &str, missing: &[String]) -> Trouble {
    let trouble = Trouble::data(format!(
        "certificate {number} cannot be released: {}",
        lack(missing.len())
    ))
    .with_hint(format!(
        "{}; a draft can be made all the same",
        what_to_add(missing)
    ));
    missing.iter().fold(trouble, |t, m| t.detail(m.clone()))
}

impl CertificateOutcome {
    /// What is missing to a released certificate, each in one line.
    pub fn missing(&self) -> &[String] {
        &self.content.missing
    }

    /// How much is missing, in words: `one thing is missing to a certificate`.
    pub fn lack(&self) -> String {
        lack(self.missing().len())
    }

    /// The item, in one line.
    pub fn item(&self) -> String {
        let item = self.content.file.item.as_ref();
        item.map(Item::line).unwrap_or_default()
    }

    /// What it states.
    pub fn results(&self) -> &StatedResults {
        &self.content.results
    }

    /// The digital certificate.
    pub fn xml(&self) -> &str {
        &self.xml
    }

    /// The sheet with the files that go into the document: what the typesetter is given.
    ///
    /// # Errors
    /// None in practice.
    pub fn whole_sheet(&self) -> Result<Vec<u8>> {
        let file =
            |name: &str, media_type: &str, relationship: &str, bytes: &[u8]| SheetAttachment {
                name: name.to_owned(),
                media_type: media_type.to_owned(),
                relationship: relationship.to_owned(),
                description: name.to_owned(),
                base64: base64(bytes),
            };
        let mut sheet = self.sheet.clone();
        sheet.attachments = vec![
            file(
                DIGITAL,
                "application/xml",
                "Alternative",
                self.xml.as_bytes(),
            ),
            file(RESULT, "application/json", "Source", &self.result),
        ];
        json(&sheet)
    }
}

fn json(sheet: &Sheet) -> Result<Vec<u8>> {
    serde_json::to_vec_pretty(sheet)
        .map_err(|e| Trouble::data(format!("the sheet cannot be written: {e}")))
}

impl Outcome for CertificateOutcome {
    const KIND: &'static str = "certificate";

    fn title(&self, record: &Record) -> String {
        let own = || format!("{}: {}", self.sheet.title, self.sheet.number);
        record.title.clone().unwrap_or_else(own)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        #[derive(Serialize)]
        struct Filed<'a> {
            number: &'a Option<String>,
            language: Language,
            #[serde(flatten)]
            content: &'a Content,
        }
        let filed = Filed {
            number: &self.number,
            language: self.language,
            content: &self.content,
        };
        Ok(vec![section("certificate", &filed)?])
    }

    fn attachments(&self, _record: &Record) -> Result<Vec<(String, Vec<u8>)>> {
        Ok(vec![
            (DIGITAL.to_owned(), self.xml.clone().into_bytes()),
            (SHEET.to_owned(), json(&self.sheet)?),
        ])
    }

    fn page(&self, page: Report) -> Report {
        let page = match &self.number {
            // Notes about the result were for the laboratory: nothing is said here that would count them.
            Some(number) => page.question(format!(
                "Certificate {number} has everything that it must state."
            )),
            None => page.verdict(format!("A draft: {}.", self.lack())),
        };
        let figures = blocks::key_figures(&self.content, self.language);
        self.sheet.report(page.answers(figures))
    }
}
