//! The linear budget of a campaign against Monte Carlo, frequency by frequency.

use super::campaign::ShakerCampaign;
use super::fit::complex;
use super::monte_carlo::{Verdict, validate};
use super::observation::{PhasorRow, SpuriousTable};
use super::screening::{Observations, observations};
use proofmass_core::Error;
use serde::Serialize;

/// Verdicts at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrequencyCheck {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Trials.
    pub trials: u64,
    /// One verdict for each of the 18 reals of S.
    pub verdicts: Vec<Verdict>,
}

/// [`validate`] at every frequency of a campaign, with its runs, its budget and the S that the complex method finds.
///
/// # Errors
/// As [`complex`] and [`validate`].
pub fn check(
    campaign: &ShakerCampaign,
    trials: u64,
    digits: u32,
    seed: u64,
) -> Result<Vec<FrequencyCheck>, Error> {
    let Observations { rows, budget, .. } = observations(campaign)?;
    let none = SpuriousTable::default();
    let table = campaign.corrections.first().map_or(&none, |c| &c.table);
    complex(&rows, table, &budget)?
        .frequencies
        .iter()
        .map(|f| {
            let at: Vec<PhasorRow> = rows
                .iter()
                .filter(|r| r.frequency == f.frequency)
                .cloned()
                .collect();
            Ok(FrequencyCheck {
                frequency: f.frequency,
                trials,
                verdicts: validate(&at, &f.sensitivity, &budget, trials, digits, seed)?,
            })
        })
        .collect()
}
