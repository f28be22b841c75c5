//! `proofmass velocity`: velocity from an encoder and an accelerometer.

mod compare;
mod estimate;
mod method;
mod reading;
mod reference;
mod sensors;
mod tune;

use crate::{Failure, Outcome};

/// Velocity of an axis from its encoder (or wheel speed) and its accelerometer.
#[derive(clap::Args)]
pub(crate) struct Velocity {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    Estimate(estimate::Estimate),
    Compare(compare::Compare),
    Tune(tune::Tune),
}

impl Velocity {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.question {
            Question::Estimate(command) => command.run(),
            Question::Compare(command) => command.run(),
            Question::Tune(command) => command.run(),
        }
    }
}
