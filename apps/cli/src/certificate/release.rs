//! `proofmass certificate release`: a number of the register, and the files of a certificate.

use super::request::{Numbered, Request};
use super::{commit, paper};
use crate::console::Shown;
use crate::{Failure, Outcome, console};
use proofmass::io::{OutputFolder, SigningKey};
use proofmass::jobs::StoredResult;
use proofmass::jobs::certificate::register::NewEntry;
use proofmass::jobs::certificate::{PAPER, Replaced, says, what_to_add};
use std::path::PathBuf;

/// Release a certificate: the next number of the register, and files that are never overwritten.
///
/// Nothing is released while anything is missing; `check` lists it. The number is entered in the register beside LAB.toml, which only
/// grows. The same request again writes the same certificate under the same number.
#[derive(clap::Args)]
pub(super) struct Release {
    #[command(flatten)]
    request: Request,
    /// Folder of the certificate, which must not be there yet
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Write certificate.pdf as well, by the program proofmass-certificate
    #[arg(long)]
    pdf: bool,
    /// Begin the register: this is the first certificate of all
    #[arg(long, conflicts_with = "replaces")]
    first: bool,
    /// Number of the certificate that this one replaces
    #[arg(long, value_name = "NUMBER", requires = "reason")]
    replaces: Option<String>,
    /// Why it is replaced
    #[arg(long, value_name = "TEXT", requires = "replaces")]
    reason: Option<String>,
    /// The replaced certificate named another item, and that was what was wrong
    #[arg(long, requires = "replaces")]
    other_item: bool,
    /// Sign the list of files with a private key (PEM, Ed25519), as `proofmass keygen` makes it
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
}

impl Release {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        if std::fs::symlink_metadata(&self.output).is_ok() {
            return Err(Failure::new(format!("{} is there already", self.output.display()))
                .hint("name a folder that is not there: a released certificate is never written over another file"));
        }
        if self.reason.as_ref().is_some_and(|r| !says(r)) {
            return Err(Failure::new("--reason: no reason is said")
                .hint("it is printed on the certificate, and stays in the register"));
        }
        let key = self.sign.as_deref().map(SigningKey::read).transpose()?;
        let certified = self.request.read()?;
        certified.numbering()?;
        certified.vouched()?;
        // What is missing is told before a number is looked for.
        let draft = certified.evaluate(None)?;
        if !draft.missing().is_empty() {
            let failure = Failure::new(format!("no certificate is released: {}", draft.lack()))
                .hint(what_to_add(draft.missing()));
            return Err(draft
                .missing()
                .iter()
                .fold(failure, |f, m| f.detail(m.clone())));
        }
        let replaces = self
            .replaces
            .zip(self.reason)
            .map(|(number, reason)| Replaced {
                number,
                reason,
                other_item: self.other_item,
            });
        let mut register = certified.open_register()?;
        let item = draft.item();
        // A run that was ended between register and folder is brought to its end, and what was released is found again.
        let mut before = None;
        for entry in register.of_result(&certified.result.to_json()?, replaces.as_ref()) {
            let numbered = Numbered {
                number: entry.number.clone(),
                issued: entry.issued.clone(),
                replaces: replaces.clone(),
            };
            // What could not be released on that day is not what was released then.
            let Ok(outcome) = certified.evaluate(Some(&numbered)) else {
                continue;
            };
            if entry.is_of(outcome.xml().as_bytes()) {
                before = Some((numbered, outcome));
                break;
            }
        }
        let is_new = before.is_none();
        let (numbered, outcome) = match before {
            Some(same) => same,
            None => {
                certified.begun(&register, self.first)?;
                let numbered = certified.next(&register, replaces, &item)?;
                let outcome = certified.evaluate(Some(&numbered))?;
                (numbered, outcome)
            }
        };
        let mut folder = OutputFolder::create(self.output.clone(), false)?;
        if let Some(key) = key {
            folder.sign_with(key);
        }
        folder.protect(certified.files());
        if self.pdf {
            paper::write(&outcome, &folder.file(PAPER))?;
        }
        let mut record = certified.record();
        record.date = Some(numbered.issued.clone());
        let result = StoredResult::new(record, &outcome)?;
        if is_new {
            register.enter(&NewEntry {
                number: &numbered.number,
                issued: &numbered.issued,
                item: &item,
                certificate: outcome.xml().as_bytes(),
                result: &certified.result.to_json()?,
                language: certified.language,
                replaces: numbered.replaces.as_ref(),
            })?;
        }
        let place = commit(folder, &result)?;
        let whole = Shown {
            filed: true,
            ..Shown::WHOLE
        };
        console::show_result(&result, whole)?;
        let told = if is_new {
            "released"
        } else {
            "written again, as it was released"
        };
        console::note(format!(
            "{told}: certificate {} in {}",
            numbered.number,
            place.display()
        ));
        Ok(Outcome::Done)
    }
}
