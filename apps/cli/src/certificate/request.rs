//! Which result is certified, for whom, and in which language.

use crate::console::Progress;
use crate::{Failure, clock, console};
use proofmass::documents::{DigitalCertificate, Fate, Verification};
use proofmass::io::formats::calendar::day_of;
use proofmass::io::{Input, LARGEST_DOCUMENT, Source, unlisted};
use proofmass::jobs::certificate::register::Register;
use proofmass::jobs::certificate::{
    CertificateData, CertificateFile, CertificateJob, CertificateOutcome, Language, Numbering,
    Replaced,
};
use proofmass::jobs::{Job, Record, StoredResult};
use std::path::{Path, PathBuf};

/// Options of everything that is made of a result.
#[derive(clap::Args)]
pub(super) struct Request {
    /// result.json of a calibration, or the folder that holds it
    result: PathBuf,
    /// Laboratory, standards, numbering; what it leaves out may stand in the file of the order
    #[arg(long, value_name = "LAB.toml")]
    pub(super) lab: PathBuf,
    /// Customer, item, dates of one order; its sections hold before those of LAB.toml
    #[arg(long, value_name = "FILE")]
    order: Option<PathBuf>,
    /// Language of the certificate
    #[arg(long, value_enum, default_value = "en")]
    language: Language,
    /// Numbers of a certificate in Persian with the digits of Persian
    #[arg(long)]
    persian_digits: bool,
    /// The result before the item was adjusted: result.json, or the folder that holds it
    #[arg(long, value_name = "RESULT")]
    as_found: Option<PathBuf>,
    /// Day of issue, YYYY-MM-DD [default: today]
    #[arg(long, value_name = "DATE")]
    issued: Option<String>,
}

/// A request with everything that it names.
pub(super) struct Certified {
    pub(super) file: CertificateFile,
    pub(super) issued: String,
    pub(super) result: StoredResult,
    as_found: Option<StoredResult>,
    /// Digital certificates that the result rests on.
    certificates: Vec<DigitalCertificate>,
    /// Names of files that it rests on and that are not there any more.
    lost: Vec<String>,
    /// The register as it stands.
    register: Option<Register>,
    lab: PathBuf,
    pub(super) language: Language,
    persian_digits: bool,
    paths: Vec<PathBuf>,
    inputs: Vec<Input>,
    /// Whether the list of its folder says that the result is as it was computed.
    pub(super) listed: bool,
}

/// What makes a draft a certificate.
pub(super) struct Numbered {
    pub(super) number: String,
    pub(super) issued: String,
    pub(super) replaces: Option<Replaced>,
}

fn stored(path: &Path) -> Result<(StoredResult, PathBuf, Input), Failure> {
    let path = StoredResult::place(path);
    let (bytes, input) = Source::open(&path)?.into_bytes(LARGEST_DOCUMENT)?;
    if let Some(doubt) = &input.doubt {
        return Err(Failure::new(doubt)
            .hint("a result that was changed has no certificate: evaluate it again"));
    }
    let result = StoredResult::from_json(&bytes)
        .map_err(|trouble| Failure::from(trouble).detail(path.display().to_string()))?;
    Ok((result, path, input))
}

/// The digital certificates among the files that a result was computed from.
fn certificates(chain: &Verification) -> Result<Vec<DigitalCertificate>, Failure> {
    let found = chain.links.iter().filter_map(|l| l.found.as_ref());
    let found = found.filter(|path| DigitalCertificate::is_named(path));
    let read = |path: &PathBuf| Ok(DigitalCertificate::from_source(Source::open(path)?)?);
    found.map(read).collect()
}

/// Names of files that a result was computed from and that are not there any more.
fn lost(chain: &Verification) -> Vec<String> {
    let lost = chain.links.iter().filter(|l| l.fate == Fate::Missing);
    lost.map(|l| l.name.clone()).collect()
}

fn unnumbered() -> Failure {
    Failure::new("LAB.toml does not say how certificates are numbered")
        .hint("add [numbering] with pattern = \"CAL-{year}-{number:4}\"")
}

/// Where the register is.
fn place(lab: &Path, numbering: &Numbering) -> PathBuf {
    lab.with_file_name(&numbering.register)
}

impl Request {
    pub(super) fn read(&self) -> Result<Certified, Failure> {
        let (result, path, input) = stored(&self.result)?;
        if let Some(issued) = &self.issued {
            let today = day_of(&clock::today());
            match (day_of(issued), today) {
                (None, _) => {
                    return Err(Failure::new(format!("--issued: {issued:?} is no day"))
                        .hint("write YYYY-MM-DD"));
                }
                (Some(day), Some(today)) if day > today => {
                    return Err(Failure::new(format!("--issued: {issued} lies ahead")).hint(
                        "a certificate is issued on the day on which it is released, or before",
                    ));
                }
                _ => {}
            }
        }
        let chain = Verification::of(&path, None)?;
        if let Some(changed) = chain.links.iter().find(|l| l.fate == Fate::Changed) {
            return Err(Failure::new(format!(
                "{} was changed since the result was computed from it",
                changed.name
            ))
            .detail(format!("{} names it", changed.named_by.display()))
            .hint("fetch it again as it was, or evaluate it again; `proofmass verify` follows the whole chain"));
        }
        let listed = unlisted(&path, &input).is_none();
        let mut file = CertificateFile::open(&self.lab)?;
        // What LAB.toml and the order say stands in the certificate: these files go on to change, and are no inputs that have to stay.
        let (mut paths, mut inputs) = (vec![path, self.lab.clone()], vec![input]);
        if let Some(order) = &self.order {
            let order_file = CertificateFile::open(order)?;
            if order_file.numbering.is_some() {
                return Err(Failure::new(format!(
                    "{}: [numbering] belongs to LAB.toml",
                    order.display()
                ))
                .hint("an order has no register of its own: take the section out"));
            }
            file = file.with_order(order_file);
            paths.push(order.clone());
        }
        let as_found = match &self.as_found {
            None => None,
            Some(found) => {
                let (result, path, input) = stored(found)?;
                paths.push(path);
                inputs.push(input);
                Some(result)
            }
        };
        if self.persian_digits && self.language != Language::Persian {
            console::note(
                "note: --persian-digits has no effect on a certificate in another language",
            );
        }
        Ok(Certified {
            issued: self.issued.clone().unwrap_or_else(clock::today),
            result,
            as_found,
            certificates: certificates(&chain)?,
            lost: lost(&chain),
            register: file
                .numbering
                .as_ref()
                .map(|n| Register::look(&place(&self.lab, n)))
                .transpose()?,
            file,
            lab: self.lab.clone(),
            language: self.language,
            persian_digits: self.persian_digits,
            paths,
            inputs,
            listed,
        })
    }
}

impl Certified {
    /// How certificates are numbered.
    pub(super) fn numbering(&self) -> Result<&Numbering, Failure> {
        self.file.numbering.as_ref().ok_or_else(unnumbered)
    }

    /// The register, locked.
    pub(super) fn open_register(&self) -> Result<Register, Failure> {
        Ok(Register::open(&place(&self.lab, self.numbering()?))?)
    }

    /// The number that a new certificate has.
    pub(super) fn next(
        &self,
        register: &Register,
        replaces: Option<Replaced>,
        item: &str,
    ) -> Result<Numbered, Failure> {
        if let Some(replaced) = &replaces {
            register.may_replace(replaced, item)?;
        }
        register.may_state(&self.result.to_json()?, self.language, replaces.as_ref())?;
        if let Some(last) = register.entries().last()
            && self.issued < last.issued
        {
            return Err(Failure::new(format!(
                "--issued: {} lies before {}, the day of the certificate {}",
                self.issued, last.issued, last.number
            ))
            .hint("numbers follow the days of issue"));
        }
        Ok(Numbered {
            number: register.next(self.numbering()?, &self.issued)?,
            issued: self.issued.clone(),
            replaces,
        })
    }

    /// Refuses a result that no list of its folder vouches for.
    pub(super) fn vouched(&self) -> Result<(), Failure> {
        if self.listed {
            return Ok(());
        }
        Err(Failure::new("no list of its folder says that the result is as it was computed")
            .hint("release it from the folder that `proofmass calibrate` wrote, with its manifest.json"))
    }

    /// The number that the certificate would have if it were released now, and whether it would be the first one of its register.
    pub(super) fn number(&self, item: &str) -> Result<(String, bool), Failure> {
        self.vouched()?;
        let register = self.register.as_ref().ok_or_else(unnumbered)?;
        let number = self.next(register, None, item)?.number;
        Ok((number, register.entries().is_empty()))
    }

    /// Refuses to begin a register that nobody asked to be begun: one that was emptied or lost would give its numbers a second time.
    pub(super) fn begun(&self, register: &Register, first: bool) -> Result<(), Failure> {
        let name = &self.numbering()?.register;
        match (register.entries().len(), first) {
            (0, false) => Err(Failure::new(format!(
                "the register {name} beside {} holds no certificate",
                self.lab.display()
            ))
            .hint("say --first where this is the first certificate of all; else fetch the register from a copy")),
            (n, true) if n > 0 => Err(Failure::new(format!(
                "the register {name} holds {n} already, so that this is not the first certificate"
            ))
            .hint("leave --first out")),
            _ => Ok(()),
        }
    }

    /// The certificate; without a number a draft.
    pub(super) fn evaluate(
        &self,
        numbered: Option<&Numbered>,
    ) -> Result<CertificateOutcome, Failure> {
        let job = CertificateJob {
            file: self.file.clone(),
            language: self.language,
            persian_digits: self.persian_digits,
            number: numbered.map(|n| n.number.clone()),
            issued: Some(numbered.map_or_else(|| self.issued.clone(), |n| n.issued.clone())),
            replaces: numbered.and_then(|n| n.replaces.clone()),
        };
        let data = CertificateData {
            result: &self.result,
            as_found: self.as_found.as_ref(),
            certificates: &self.certificates,
            lost: &self.lost,
            released: self.register.as_ref().map_or(&[], Register::entries),
        };
        Ok(job.evaluate(&data, &Progress::new())?)
    }

    /// The files that were read, which are never replaced.
    pub(super) fn files(&self) -> Vec<&Path> {
        self.paths.iter().map(PathBuf::as_path).collect()
    }

    pub(super) fn record(&self) -> Record {
        let of_result = self.result.record();
        Record {
            title: None,
            device: of_result.device.clone(),
            ambient: of_result.ambient.clone(),
            date: Some(self.issued.clone()),
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}
