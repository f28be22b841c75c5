//! A measurement of the spurious motion from its files to its results.

use super::Calibrate;
use crate::console::Progress;
use crate::{Failure, Outcome, clock};
use proofmass::jobs::campaign::SpuriousMotionCampaign;
use proofmass::jobs::spurious_motion::SpuriousMotionOutcome;
use proofmass::jobs::{Filed, Job, Outcome as _};

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &SpuriousMotionCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(SpuriousMotionOutcome::KIND, &campaign.source)?;
    let watch = Progress::new();
    let files = campaign.load(&watch)?;
    let outcome = files.job.evaluate(&files.data(), &watch)?;
    let record = campaign.record(&files, Some(clock::today()));
    arguments
        .delivery
        .deliver(Some(folder), &Filed::new(record, outcome))
}
