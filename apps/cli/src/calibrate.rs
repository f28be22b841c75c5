//! `proofmass calibrate`: any campaign, its kind read from it.

mod multi_position;
mod shaker_single;
mod shaker_triaxial;
mod spurious_motion;

use crate::delivery::Delivery;
use crate::{Failure, Outcome};
use proofmass::io::OutputFolder;
use proofmass::jobs::campaign::{Campaign, CampaignFile};
use std::path::PathBuf;

/// Calibrate a sensor from a campaign folder.
///
/// A campaign is a folder with `campaign.toml` and the recordings it names; its `kind` says what is calibrated.
/// Results go to a folder: result.json (everything, covariance included), report.html (one file, opens without
/// network), calibration.json (what `proofmass apply` needs) and CSV tables.
#[derive(clap::Args)]
#[command(mut_arg("output", |a| a.help("Folder for the results [default: `result` beside campaign.toml]")))]
pub(crate) struct Calibrate {
    /// Campaign folder, or its campaign.toml
    campaign: PathBuf,
    #[command(flatten)]
    delivery: Delivery,
}

impl Calibrate {
    /// Begins the folder of results, by default beside the campaign.
    fn begin(&self, campaign: &CampaignFile) -> Result<OutputFolder, Failure> {
        let place = self.delivery.output.clone();
        self.delivery.begin_at(
            place.unwrap_or_else(|| campaign.resolve("result")),
            &[&campaign.path],
        )
    }

    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match Campaign::open(&self.campaign)? {
            Campaign::MultiPosition(campaign) => multi_position::run(&self, &campaign),
            Campaign::ShakerTriaxial(campaign) => shaker_triaxial::run(&self, &campaign),
            Campaign::ShakerSingle(campaign) => shaker_single::run(&self, &campaign),
            Campaign::SpuriousMotion(campaign) => spurious_motion::run(&self, &campaign),
            other => Err(Failure::new(format!(
                "campaigns of kind `{}` cannot be calibrated yet",
                other.kind()
            ))),
        }
    }
}
