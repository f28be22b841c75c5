//! A multi-position campaign from its files to its results.

use super::Calibrate;
use crate::console::Progress;
use crate::{Failure, Outcome, clock};
use proofmass::jobs::campaign::MultiPositionCampaign;
use proofmass::jobs::multi_position::MultiPositionOutcome;
use proofmass::jobs::{Filed, Job, Outcome as _};

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &MultiPositionCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(MultiPositionOutcome::KIND, &campaign.source)?;
    let watch = Progress::new();
    let recordings = campaign.load(&watch)?;
    let outcome = campaign
        .job(&recordings)?
        .evaluate(&recordings.data(), &watch)?;
    let record = campaign.record(&recordings, Some(clock::today()));
    arguments
        .delivery
        .deliver(Some(folder), &Filed::new(record, outcome))
}
