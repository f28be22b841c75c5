//! `proofmass calibrate`: any campaign, its kind read from it.

mod free_living;
mod multi_position;
mod shaker_single;
mod shaker_triaxial;
mod spurious_motion;

use crate::delivery::Delivery;
use crate::draft_arguments::DraftArguments;
use crate::{Failure, Outcome};
use proofmass::io::OutputFolder;
use proofmass::jobs::campaign::{Campaign, CampaignFile};
use std::path::PathBuf;

/// Calibrate a sensor from a campaign folder, or from one recording with standstills.
///
/// A campaign is a folder with `campaign.toml` and the recordings it names; its `kind` says what is calibrated. A
/// recording alone needs the place (`--latitude`) or local gravity; `proofmass init` writes it a campaign.
/// Results go to a folder: result.json (everything, covariance included), report.html (one file, opens without
/// network), calibration.json (what `proofmass apply` needs) and CSV tables.
#[derive(clap::Args)]
#[command(mut_arg("output", |a| a.help("Folder for the results [default: `result` beside campaign.toml]")))]
pub(crate) struct Calibrate {
    /// Campaign folder, its campaign.toml, or a recording
    campaign: PathBuf,
    /// Refuse a campaign that names files outside of its folder: for campaigns of strangers
    #[arg(long)]
    contained: bool,
    #[command(flatten)]
    recording: DraftArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Calibrate {
    /// Begins the folder of results, by default beside the campaign.
    fn begin(&self, kind: &str, campaign: &CampaignFile) -> Result<OutputFolder, Failure> {
        let place = self.delivery.output.clone();
        self.delivery.begin_at(
            place.unwrap_or_else(|| campaign.resolve("result")),
            kind,
            &[&campaign.path],
        )
    }

    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let recording = self.campaign.is_file()
            && self
                .campaign
                .extension()
                .is_none_or(|e| !e.eq_ignore_ascii_case("toml"));
        let campaign = if recording {
            let draft = self.recording.draft();
            if !draft.free_living && draft.gravity.is_none() && draft.latitude_deg.is_none() {
                return Err(Failure::new("a recording alone does not say where it was made")
                    .detail(self.campaign.display().to_string())
                    .hint("add --latitude DEGREES (and --height METRES), or --gravity and --gravity-uncertainty; or write a campaign: proofmass init RECORDING"));
            }
            draft.campaign(&self.campaign)?
        } else {
            self.recording.refuse_with_a_campaign()?;
            match self.contained {
                true => Campaign::open_contained(&self.campaign)?,
                false => Campaign::open(&self.campaign)?,
            }
        };
        match campaign {
            Campaign::MultiPosition(campaign) => multi_position::run(&self, &campaign),
            Campaign::FreeLiving(campaign) => free_living::run(&self, &campaign),
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
