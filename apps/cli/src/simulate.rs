//! `proofmass simulate`: recordings with truth.

mod axis;
mod bench_arguments;
mod fault;
mod multi_position;
mod shaker;
mod spurious_motion;

use crate::{Failure, Outcome, console};
use proofmass::io::OutputFolder;
use serde::Serialize;

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

/// Writes campaign.toml and truth.json, puts the folder in its place and says what comes next.
fn hand_over(
    folder: OutputFolder,
    campaign: String,
    truth: &impl Serialize,
) -> Result<Outcome, Failure> {
    let truth = serde_json::to_vec_pretty(truth)
        .map_err(|e| Failure::new(format!("the truth cannot be written: {e}")))?;
    folder.write("campaign.toml", campaign)?;
    folder.write("truth.json", truth)?;
    let place = folder.commit()?;
    console::note(format!(
        "written: {0}; next: proofmass calibrate {0}",
        place.display()
    ));
    Ok(Outcome::Done)
}
