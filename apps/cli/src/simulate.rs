//! `proofmass simulate`: recordings with truth.

mod axis;
mod fault;
mod multi_position;
mod shaker;
mod spurious_motion;

use crate::{Failure, Outcome};

/// Make a campaign whose truth is known.
#[derive(clap::Args)]
pub(crate) struct Simulate {
    #[command(subcommand)]
    scenario: Scenario,
}

#[derive(clap::Subcommand)]
enum Scenario {
    MultiPosition(multi_position::MultiPosition),
    Shaker(shaker::Shaker),
    SpuriousMotion(spurious_motion::SpuriousMotion),
    Axis(axis::Axis),
}

impl Simulate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.scenario {
            Scenario::MultiPosition(scenario) => scenario.run(),
            Scenario::Shaker(scenario) => scenario.run(),
            Scenario::SpuriousMotion(scenario) => scenario.run(),
            Scenario::Axis(scenario) => scenario.run(),
        }
    }
}
