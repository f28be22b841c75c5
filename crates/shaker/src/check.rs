//! The stated uncertainties of a campaign against Monte Carlo, frequency by frequency.

use super::campaign::{ShakerCalibration, ShakerCampaign, ShakerMethod};
use super::monte_carlo::{CheckOptions, FrequencyCheck, validate};
use super::observation::SpuriousTable;
use super::screening::{Observations, observations, with_motion};
use proofmass_uncertainty::{Progress, Refusal, Verdict};
use std::ops::ControlFlow;

/// [`validate`] of the result that stands first: the first method with a budget, with the first correction, on the runs
/// that `calibration` kept.
///
/// `progress` is told how far the trials have come and may stop them. Without such a method there is nothing to check.
///
/// # Errors
/// As [`validate`].
pub fn check(
    campaign: &ShakerCampaign,
    calibration: &ShakerCalibration,
    options: &CheckOptions,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<FrequencyCheck>, Refusal> {
    let Some(method) = campaign
        .methods
        .iter()
        .copied()
        .find(|m| *m != ShakerMethod::PublishedMagnitude)
    else {
        return Ok(vec![]);
    };
    let Observations {
        mut rows, budget, ..
    } = observations(campaign)?;
    rows.retain(|r| !calibration.set_aside.contains(&r.run));
    let table = campaign
        .corrections
        .first()
        .map_or_else(SpuriousTable::default, |c| c.table.pooled(&c.label).0);
    let places = rows
        .iter()
        .map(|r| (r.configuration.inclination, r.frequency));
    let table = table.completed(places, campaign.unmeasured_motion);
    let budget = with_motion(&budget, &table, &rows)?;
    validate(method, &rows, &table, &budget, options, progress)
}

/// Gives the terms of the principal result the intervals of the trials where the verdict is that the stated ones do not
/// hold: U and u of S_ij are multiplied by the ratio of the two half widths, along the term for its modulus, across it
/// for its phase.
pub fn adopt(calibration: &mut ShakerCalibration, checks: &[FrequencyCheck]) {
    let Some(result) = calibration
        .results
        .iter_mut()
        .find(|r| r.method != ShakerMethod::PublishedMagnitude)
    else {
        return;
    };
    for f in &mut result.frequencies {
        let Some(check) = checks.iter().find(|c| c.frequency == f.frequency) else {
            continue;
        };
        for (k, term) in f.sensitivity.iter_mut().enumerate() {
            let factor = |part: usize| {
                check.components.get(2 * k + part).map_or(1.0, |c| {
                    let half = c.interval[0].abs().max(c.interval[1].abs());
                    match c.validation.verdict {
                        Verdict::NotValidated => half / c.linear_interval[1],
                        Verdict::Validated | Verdict::Undecided => 1.0,
                    }
                })
            };
            let (along, across) = if term.re.abs() >= term.im.abs() {
                (0, 1)
            } else {
                (1, 0)
            };
            let scale = |q: &mut super::derived::Expanded, factor: f64| {
                q.standard_uncertainty *= factor;
                q.expanded *= factor;
            };
            scale(&mut term.real, factor(0));
            scale(&mut term.modulus, factor(along));
            if let Some(phase) = &mut term.phase {
                scale(phase, factor(across));
            }
        }
    }
}
