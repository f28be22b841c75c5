//! A free-living campaign from its files to its results.

use super::Calibrate;
use crate::console::Progress;
use crate::{Failure, Outcome, clock};
use proofmass::jobs::campaign::FreeLivingCampaign;
use proofmass::jobs::free_living::FreeLivingOutcome;
use proofmass::jobs::{Filed, Job, Outcome as _};

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &FreeLivingCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(FreeLivingOutcome::KIND, &campaign.source)?;
    let watch = Progress::new();
    let windows = campaign.load(&watch)?;
    let outcome = campaign.job().evaluate(&windows, &watch)?;
    let record = campaign.record(&windows, Some(clock::today()));
    arguments
        .delivery
        .deliver(Some(folder), &Filed::new(record, outcome))
}
