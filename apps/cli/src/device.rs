//! `proofmass device`: a device and what its data sheet promises.

mod check;

use crate::{Failure, Outcome};

/// Hold devices against their data sheet.
#[derive(clap::Args)]
pub(crate) struct Device {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    Check(check::Check),
}

impl Device {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.question {
            Question::Check(check) => check.run(),
        }
    }
}
