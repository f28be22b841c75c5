//! To be written.
use super::Calibrate;
use crate::{Failure, Outcome};
use proofmass::io::SpuriousMotionCampaign;

pub(super) fn run(_: &Calibrate, _: &SpuriousMotionCampaign) -> Result<Outcome, Failure> {
    Err(Failure::new("not yet"))
}
