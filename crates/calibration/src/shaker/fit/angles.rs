//! Mounting angles after the data, and declared uncertainties that the runs do not support.

use super::{AngleEstimate, upper_tail};
use crate::shaker::adjustment::Adjustment;
use crate::shaker::budget::{Acts, Budget};
use crate::shaker::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side};
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Angles after the data, and whether the data agree with their priors.
pub(super) fn angles(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    budget: &Budget,
) -> Result<(Vec<AngleEstimate>, Vec<Finding>), Error> {
    let offset = 18 * adjustment.frequencies.len();
    let (mut estimates, mut findings) = (vec![], vec![]);
    for (index, input) in budget.inputs.iter().enumerate() {
        if !input.acts.is_angle() {
            continue;
        }
        let draws: Vec<usize> = (0..adjustment.draws.len())
            .filter(|&d| adjustment.draws[d].input == Some(index))
            .collect();
        let prior = input.standard_uncertainty();
        for &d in &draws {
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
        let Some((statistic, seen)) = agreement(adjustment, &draws)? else {
            continue;
        };
        let nu = seen as f64;
        let ratio = (statistic / nu).sqrt();
        let evidence = format!(
            "the data want {ratio:.2} times the declared {:.3}°: χ² = {statistic:.1} with {seen} degrees of freedom",
            prior.to_degrees()
        );
        if upper_tail(statistic, nu) < 1e-4 {
            findings.push(
                Finding::new(
                    Severity::Decision,
                    "angle-prior-too-small",
                    format!("the mounting angles of {} scatter more than declared", input.key),
                )
                .evidence(evidence)
                .advice("declare a larger uncertainty, or look for a configuration that was mounted wrongly"),
            );
        } else if 1.0 - upper_tail(statistic, nu) < 1e-4 {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "angle-prior-too-large",
                    format!(
                        "the mounting angles of {} scatter less than declared",
                        input.key
                    ),
                )
                .evidence(evidence)
                .advice("a smaller declared uncertainty would be defensible"),
            );
        }
    }
    Ok((estimates, findings))
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
    let eigen = spread
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::NotConverged {
            name: "eigenvalues of the angles",
            iterations: 0,
            step: f64::INFINITY,
        })?;
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

/// A declared uncertainty of a mounting angle that the runs do not support, and the one that was used instead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RaisedInput {
    /// Key of the input.
    pub key: String,
    /// Declared standard uncertainty, rad.
    pub declared: f64,
    /// Estimated from the runs, rad.
    pub used: f64,
    /// Degrees of freedom the runs have for it.
    pub freedom: f64,
}

/// Probability below which a declared uncertainty counts as too small.
const TOO_SMALL: f64 = 1e-4;
/// Median of z² when z is standard normal.
const MEDIAN: f64 = 0.454_936;
/// Rounds of the fixed point; it gains a digit in two or three.
const ROUNDS: usize = 20;

/// Angles of the budget that scatter more than declared, each with the uncertainty at which they would not: the
/// restricted maximum of the likelihood, u² ← u² Σz²/(m − ΣC_zz), with the declared value as the floor.
///
/// One run that is mounted wrongly does not raise what all gluings have: more than half of the angles must be larger
/// than declared. Few degrees of freedom γ widen the answer by γ/(γ − 2).
///
/// **Source** `[Harville1977]`; the fixed point `[Wood2017]`.
///
/// # Errors
/// As [`crate::shaker::joint`].
pub fn unsupported(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Vec<RaisedInput>, Error> {
    let mut raised: Vec<RaisedInput> = vec![];
    let mut current = budget.clone();
    for _ in 0..ROUNDS {
        let adjustment = Adjustment::new(rows, spurious, &current)?;
        let offset = adjustment.first_draw();
        let mut settled = true;
        let mut next = current.clone();
        for (index, input) in current.inputs.iter().enumerate() {
            if !input.acts.is_angle() || input.varies_with.is_empty() {
                continue;
            }
            let draws: Vec<usize> = (0..adjustment.draws.len())
                .filter(|&d| adjustment.draws[d].input == Some(index))
                .collect();
            let seen = draws.iter().map(|d| {
                let p = offset + d;
                (
                    adjustment.parameters[p].powi(2),
                    1.0 - adjustment.covariance(p, p),
                )
            });
            let (sum, freedom) = seen
                .clone()
                .fold((0.0, 0.0), |(s, g), (z, f)| (s + z, g + f));
            let known = raised.iter().position(|r| r.key == input.key);
            if known.is_none() {
                let Some((statistic, nu)) = agreement(&adjustment, &draws)? else {
                    continue;
                };
                let mut sizes: Vec<f64> = seen.filter(|s| s.1 > 0.05).map(|(z, f)| z / f).collect();
                sizes.sort_by(f64::total_cmp);
                let usual = sizes.get(sizes.len() / 2).is_none_or(|m| *m < 1.5 * MEDIAN);
                if usual || upper_tail(statistic, nu as f64) >= TOO_SMALL {
                    continue;
                }
            }
            let few = freedom / (freedom - 2.0).max(1.0);
            let used = input.standard_uncertainty() * (sum / freedom).sqrt();
            let declared = budget.inputs[index].standard_uncertainty();
            let entry = RaisedInput {
                key: input.key.clone(),
                declared,
                used: used.max(declared) * few.max(1.0).sqrt(),
                freedom,
            };
            settled &= (used / input.standard_uncertainty() - 1.0).abs() < 4e-3;
            next = next.scaled(
                &input.key,
                used.max(declared) / input.standard_uncertainty(),
            );
            match known {
                Some(k) => raised[k] = entry,
                None => {
                    settled = false;
                    raised.push(entry);
                }
            }
        }
        if settled {
            break;
        }
        current = next;
    }
    Ok(raised)
}

/// The budget with the uncertainties that the runs support.
pub fn supported(budget: &Budget, raised: &[RaisedInput]) -> Budget {
    raised.iter().fold(budget.clone(), |budget, r| {
        budget.scaled(&r.key, r.used / r.declared)
    })
}

/// What was raised, for the reader.
pub(crate) fn raised_findings(raised: &[RaisedInput]) -> Vec<Finding> {
    raised
        .iter()
        .map(|r| {
            Finding::new(
                Severity::Decision,
                "angle-uncertainty-raised",
                format!(
                    "the uncertainty of {} was raised to what the runs support",
                    r.key
                ),
            )
            .evidence(format!(
                "u = {:.3}° instead of the declared {:.3}°, by the {:.0} degrees of freedom that the runs have for it",
                r.used.to_degrees(),
                r.declared.to_degrees(),
                r.freedom
            ))
            .advice("declare it so, or look for what turns the device more than the drawing allows")
        })
        .collect()
}
