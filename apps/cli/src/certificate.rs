//! `proofmass certificate`: what a laboratory hands over, and what other laboratories handed over.

mod paper;
mod release;
mod request;

use crate::delivery::Delivery;
use crate::{Failure, Outcome, console};
use proofmass::documents::DigitalCertificate;
use proofmass::io::{OutputFolder, Source};
use proofmass::jobs::certificate::{CertificateOutcome, PAPER, lack, reading, what_to_add};
use proofmass::jobs::{Outcome as _, StoredResult};
use release::Release;
use request::Request;
use std::path::PathBuf;

/// What a laboratory fills in.
const TEMPLATE: &str = include_str!("certificate/LAB.toml");

/// Draft, check and release calibration certificates, and read those of others.
///
/// From the result of a calibration and LAB.toml: laboratory, customer, item, standards. A draft has a watermark and no number; `release`
/// gives it the next number of the register. The digital certificate (DCC 3.3.0) has the same numbers as the paper, to the digit.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    arg_required_else_help = true
)]
pub(crate) struct Certificate {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    request: Option<Request>,
    #[command(flatten)]
    draft: Draft,
}

#[derive(clap::Subcommand)]
enum What {
    Read(ReadCertificate),
    Check(Check),
    Release(Release),
    Template(Template),
}

/// Print a LAB.toml to fill in: `proofmass certificate template > LAB.toml`.
#[derive(clap::Args)]
struct Template {}

/// A draft.
#[derive(clap::Args)]
struct Draft {
    /// Print the digital certificate (DCC, XML) instead of the summary
    #[arg(long, conflicts_with = "json")]
    xml: bool,
    /// Write certificate.pdf as well, by the program proofmass-certificate
    #[arg(long, requires = "output")]
    pdf: bool,
    #[command(flatten)]
    delivery: Delivery,
}

/// List what is missing to a certificate: exit code 1 where anything is.
#[derive(clap::Args)]
struct Check {
    #[command(flatten)]
    request: Request,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Show what a digital calibration certificate (DCC, XML) says.
///
/// Versions 2.3 to 3.3. Lists of unequal length, wrong units, numbers that are not finite, frequencies that stand twice and a k that
/// contradicts its probability are refused with element and line. A signature in it is not checked, and never called valid.
#[derive(clap::Args)]
struct ReadCertificate {
    /// Digital calibration certificate; `-` is standard input
    file: PathBuf,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl Certificate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match (self.what, self.request) {
            (Some(What::Read(command)), _) => command.run(),
            (Some(What::Check(command)), _) => command.run(),
            (Some(What::Release(command)), _) => command.run(),
            (Some(What::Template(_)), _) => {
                console::print(TEMPLATE)?;
                Ok(Outcome::Done)
            }
            (None, Some(request)) => self.draft.run(&request),
            (None, None) => Err(
                Failure::new("the result that is to be certified is not named")
                    .hint("proofmass certificate RESULT --lab LAB.toml"),
            ),
        }
    }
}

impl Draft {
    fn run(self, request: &Request) -> Result<Outcome, Failure> {
        let certified = request.read()?;
        let outcome = certified.evaluate(None)?;
        let files = certified.files();
        let folder = self.delivery.begin(CertificateOutcome::KIND, &files)?;
        if let (true, Some(folder)) = (self.pdf, &folder) {
            paper::write(&outcome, &folder.file(PAPER))?;
        }
        let result = StoredResult::new(certified.record(), &outcome)?;
        if !self.xml {
            return self.delivery.deliver(folder, &result);
        }
        if let Some(folder) = folder {
            console::note(format!("written: {}", commit(folder, &result)?.display()));
        }
        console::print(outcome.xml())?;
        Ok(Outcome::Done)
    }
}

impl Check {
    fn run(self) -> Result<Outcome, Failure> {
        let certified = self.request.read()?;
        let outcome = certified.evaluate(None)?;
        let mut missing = outcome.missing().to_vec();
        let mut number = String::new();
        match certified.number(&outcome.item()) {
            Ok((next, false)) => number = next,
            Ok((next, true)) => number = format!("{next}, with --first: the register is empty"),
            Err(failure) => missing.push(failure.to_string()),
        }
        if self.json {
            let json = serde_json::to_vec_pretty(&missing)
                .map_err(|e| Failure::new(format!("the list cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else if missing.is_empty() {
            console::print(&format!(
                "nothing is missing: the certificate can be released, as {number}\n"
            ))?;
        } else {
            missing
                .iter()
                .try_for_each(|m| console::print(&format!("{m}\n")))?;
        }
        match missing.len() {
            0 => Ok(Outcome::Done),
            n => Err(Failure::new(lack(n)).hint(what_to_add(&missing))),
        }
    }
}

/// Writes every file of a result and puts the folder in its place.
fn commit(folder: OutputFolder, result: &StoredResult) -> Result<PathBuf, Failure> {
    for (name, bytes) in result.files()? {
        folder.write(&name, bytes)?;
    }
    Ok(folder.commit()?)
}

impl ReadCertificate {
    fn run(self) -> Result<Outcome, Failure> {
        let certificate = DigitalCertificate::from_source(Source::open(&self.file)?)?;
        console::doubt(&certificate.input);
        if self.json {
            let json = serde_json::to_vec_pretty(&reading::data(&certificate))
                .map_err(|e| Failure::new(format!("the certificate cannot be written: {e}")))?;
            console::print_json(&json)?;
            certificate.findings().iter().for_each(console::finding);
        } else {
            console::show(&reading::page(&certificate))?;
        }
        Ok(Outcome::Done)
    }
}
