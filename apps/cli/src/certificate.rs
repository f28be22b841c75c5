//! `proofmass certificate`: what a laboratory hands over, and what other laboratories handed over.

use crate::{Failure, Outcome, console};
use proofmass::io::{DigitalCertificate, Source};
use proofmass::jobs::certificate::reading;
use std::path::PathBuf;

/// Read, draft, check and release calibration certificates.
#[derive(clap::Args)]
#[command(arg_required_else_help = true)]
pub(crate) struct Certificate {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Read(ReadCertificate),
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
        match self.what {
            What::Read(command) => command.run(),
        }
    }
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
