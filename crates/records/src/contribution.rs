//! What the reference standard has to do with each quantity of a result: its part of the uncertainty, from the budget that is stored.

use proofmass_documents::{AnyCalibration, at_frequency};
use proofmass_jobs::{Result, StoredResult};
use proofmass_uncertainty::{Effect, Estimate, Influence};
use std::collections::BTreeMap;

/// Beginnings of the names of causes that are the reference standard.
const STANDARD: [&str; 3] = ["reference", "certificate", "standard"];

/// Standard uncertainty that the reference contributes to each quantity, where the stored budget tells it.
///
/// A result over frequency keeps its budget with the inverse response K. An error of the reference is one factor on K and on the
/// sensitivity S, so that its relative part is the same in both.
pub(crate) fn from_standards(result: &StoredResult) -> Result<BTreeMap<String, f64>> {
    let mut found = BTreeMap::new();
    if let Some(estimate) = result.estimate()? {
        for component in estimate.components() {
            let lines = estimate.budget(&component.name).unwrap_or_default();
            let own = lines.iter().filter(|line| is_standard(&line.key));
            let variance: f64 = own.map(|line| line.contribution.powi(2)).sum();
            if variance > 0.0 {
                found.insert(component.name.clone(), variance.sqrt());
            }
        }
    }
    if let Some(AnyCalibration::FrequencyResponse(file)) = result.calibration() {
        for point in file.series.points() {
            for q in result.quantities() {
                let Some((row, phase)) = term(&q.name, point.at) else {
                    continue;
                };
                if let Some(share) = relative(&point.estimate, row, phase) {
                    let size = if phase { 1.0 } else { q.value.abs() };
                    found.insert(q.name.clone(), share * size);
                }
            }
        }
    }
    Ok(found)
}

fn is_standard(key: &str) -> bool {
    STANDARD.iter().any(|word| key.starts_with(word))
}

/// Row of K that a term of S at this frequency belongs to, and whether it is a phase: `S.xy.phase[frequency=160]`, `S.modulus[…]`.
fn term(name: &str, frequency: f64) -> Option<(usize, bool)> {
    let (head, at) = at_frequency(name)?;
    if at != frequency {
        return None;
    }
    let parts: Vec<&str> = head.split('.').collect();
    let (row, last) = match parts[..] {
        ["S", last] => (0, last),
        ["S", axes, last] => ("xyz".find(axes.get(..1)?)?, last),
        _ => return None,
    };
    match last {
        "modulus" => Some((row, false)),
        "phase" => Some((row, true)),
        _ => None,
    }
}

/// Relative standard uncertainty of the modulus of the element K of this row and its own axis, or that of its phase in rad, from the
/// reference alone.
fn relative(estimate: &Estimate, row: usize, phase: bool) -> Option<f64> {
    let n = estimate.components().len();
    // Real and imaginary part of each element, row by row: 2 for one axis, 18 for three.
    let at = match n {
        2 => 0,
        18 => 8 * row,
        _ => return None,
    };
    let (re, im) = (
        estimate.components()[at].value,
        estimate.components()[at + 1].value,
    );
    let square = re * re + im * im;
    let variance = |influence: &Influence| -> Option<f64> {
        let c = influence.effect.covariance(n).ok()?;
        let (rr, ri, ii) = (c[(at, at)], c[(at, at + 1)], c[(at + 1, at + 1)]);
        Some(match phase {
            false => re * re * rr + 2.0 * re * im * ri + im * im * ii,
            true => im * im * rr - 2.0 * re * im * ri + re * re * ii,
        })
    };
    let own = estimate.influences().iter().filter(|i| is_standard(&i.key));
    let own = own.filter(|i| !matches!(i.effect, Effect::Correlated { .. }));
    let sum: f64 = own.filter_map(variance).sum();
    (sum > 0.0).then(|| sum.sqrt() / square)
}
