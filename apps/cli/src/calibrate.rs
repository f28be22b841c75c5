//! `proofmass calibrate`: any campaign, its kind read from it.

mod multi_position;

use crate::{Failure, Outcome};
use proofmass::io::Campaign;
use std::path::PathBuf;

/// Calibrate a sensor from a campaign folder.
///
/// A campaign is a folder with `campaign.toml` and the recordings it names; its `kind` says what is calibrated.
/// Results go to a folder: result.json (everything, covariance included), report.html (one file, opens without
/// network), calibration.json (what `proofmass apply` needs) and CSV tables.
#[derive(clap::Args)]
pub(crate) struct Calibrate {
    /// Campaign folder, or its campaign.toml
    campaign: PathBuf,
    /// Folder for the results [default: `result` beside campaign.toml]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace the output folder even when it holds files that are not results of proofmass
    #[arg(long)]
    force: bool,
    /// Print result.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Exit with code 3 when a finding needs a decision
    #[arg(long)]
    strict: bool,
}

impl Calibrate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match Campaign::open(&self.campaign)? {
            Campaign::MultiPosition(campaign) => multi_position::run(&self, &campaign),
            other => Err(Failure::new(format!(
                "campaigns of kind `{}` cannot be calibrated yet",
                other.kind()
            ))),
        }
    }
}
