//! The stated uncertainties of a campaign against Monte Carlo, frequency by frequency.

use super::campaign::{Method, ShakerCampaign};
use super::monte_carlo::{FrequencyCheck, Options, validate};
use super::observation::SpuriousTable;
use super::screening::{Observations, observations};
use proofmass_uncertainty::{Progress, Refusal};
use std::ops::ControlFlow;

/// [`validate`] of the result that stands first: the first method with a budget, with the first correction.
///
/// `progress` is told how far the trials have come and may stop them. Without such a method there is nothing to check.
///
/// # Errors
/// As [`validate`].
pub fn check(
    campaign: &ShakerCampaign,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<FrequencyCheck>, Refusal> {
    let Some(method) = campaign
        .methods
        .iter()
        .copied()
        .find(|m| *m != Method::PublishedMagnitude)
    else {
        return Ok(vec![]);
    };
    let Observations { rows, budget, .. } = observations(campaign)?;
    let none = SpuriousTable::default();
    let table = campaign.corrections.first().map_or(&none, |c| &c.table);
    validate(method, &rows, table, &budget, options, progress)
}
