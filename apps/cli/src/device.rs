//! `proofmass device`: a device and what its data sheet promises.

mod check;
mod plan;

use crate::{Failure, Outcome};

/// Hold devices against their data sheet; plan what to measure for it.
#[derive(clap::Args)]
pub(crate) struct Device {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    Check(check::Check),
    Plan(plan::Plan),
}

impl Device {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.question {
            Question::Check(check) => check.run(),
            Question::Plan(plan) => plan.run(),
        }
    }
}
