//! Mounting angles after the data, and whether they agree with what is declared.

use super::AngleEstimate;
use crate::adjustment::Adjustment;
use crate::budget::{Acts, Budget, ShakerInput};
use crate::findings;
use crate::observation::PhasorRow;
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::Finding;
use proofmass_uncertainty::algebra::symmetric_eigen;
use proofmass_uncertainty::chi_squared_chance;

/// Draws of every angle of the budget.
fn draws<'a>(
    adjustment: &'a Adjustment,
    budget: &'a Budget,
) -> impl Iterator<Item = (&'a ShakerInput, Vec<usize>)> {
    let inputs = budget.inputs.iter().enumerate();
    inputs
        .filter(|(_, input)| input.acts.is_angle())
        .map(|(index, input)| (input, adjustment.draws_of(index).collect()))
}

/// Angles after the data.
pub(super) fn estimates(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    budget: &Budget,
) -> Vec<AngleEstimate> {
    let offset = adjustment.first_draw();
    let mut estimates = vec![];
    for (input, draws) in draws(adjustment, budget) {
        let prior = input.standard_uncertainty();
        for d in draws {
            let p = offset + d;
            let about = ["x", "y"][adjustment.draws[d].part % 2];
            estimates.push(AngleEstimate {
                key: match input.acts {
                    Acts::Tilt => format!("{}.{about}", input.key),
                    _ => input.key.clone(),
                },
                configuration: rows[adjustment.draws[d].row].configuration,
                value: adjustment.parameters[p] * prior,
                standard_uncertainty: adjustment.covariance(p, p).sqrt() * prior,
                prior,
            });
        }
    }
    estimates
}

/// Whether the data agree with what is declared of the angles.
pub(super) fn findings(adjustment: &Adjustment, budget: &Budget) -> Result<Vec<Finding>, Error> {
    let mut found = vec![];
    for (input, draws) in draws(adjustment, budget) {
        let Some((statistic, seen)) = agreement(adjustment, &draws)? else {
            continue;
        };
        let prior = input.standard_uncertainty();
        let nu = seen as f64;
        let ratio = (statistic / nu).sqrt();
        let kind = if chi_squared_chance(statistic, nu) < 1e-4 {
            findings::angle_prior_too_small
        } else if 1.0 - chi_squared_chance(statistic, nu) < 1e-4 {
            findings::angle_prior_too_large
        } else {
            continue;
        };
        found.push(kind(&input.key, ratio, prior.to_degrees(), statistic, seen));
    }
    Ok(found)
}

/// χ² of the draws of an input in the directions that the data see, and their number: under the prior the estimates have
/// covariance 1 − C. `None` where the data see none of them.
fn agreement(adjustment: &Adjustment, draws: &[usize]) -> Result<Option<(f64, usize)>, Error> {
    let (m, offset) = (draws.len(), adjustment.first_draw());
    if m == 0 {
        return Ok(None);
    }
    let spread = Mat::from_fn(m, m, |a, b| {
        let c = adjustment.covariance(offset + draws[a], offset + draws[b]);
        f64::from(a == b) - c
    });
    let eigen = symmetric_eigen(&spread, "eigenvalues of the angles")?;
    let (mut statistic, mut seen) = (0.0, 0usize);
    for e in 0..m {
        let lambda = eigen.S()[e];
        if lambda > 0.05 {
            let along: f64 = (0..m)
                .map(|a| eigen.U()[(a, e)] * adjustment.parameters[offset + draws[a]])
                .sum();
            statistic += along * along / lambda;
            seen += 1;
        }
    }
    Ok((seen > 0).then_some((statistic, seen)))
}
