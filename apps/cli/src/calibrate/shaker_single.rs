//! To be written.
use super::Calibrate;
use crate::{Failure, Outcome};
use proofmass::io::ShakerSingleCampaign;

pub(super) fn run(_: &Calibrate, _: &ShakerSingleCampaign) -> Result<Outcome, Failure> {
    Err(Failure::new("not yet"))
}
