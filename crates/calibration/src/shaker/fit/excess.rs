//! Residuals beyond the budget, where they are.

use super::upper_tail;
use crate::shaker::adjustment::Adjustment;
use proofmass_uncertainty::{Finding, Severity};

/// Probability of residuals as large by chance, over all frequencies, from which they count as beyond the budget.
const BEYOND: f64 = 1e-3;

/// Frequencies whose residuals are larger than what is declared, or what all frequencies share, such as mounting angles
/// that scatter more.
pub(super) fn finding(adjustment: &Adjustment) -> Option<Finding> {
    let (own, shared) = adjustment.parts();
    let count = own.len();
    let (whole, dof) = (adjustment.chi_squared, adjustment.dof() as f64);
    let beyond = |chi_squared: f64, dof: f64| {
        dof > 0.5 && chi_squared > dof && upper_tail(chi_squared, dof) < BEYOND / count as f64
    };
    let mut places = vec![];
    if count == 1 {
        if beyond(whole, dof) {
            places.push(format!("at {} Hz", adjustment.frequencies[0]));
        }
    } else {
        let said = |what: String, chi_squared: f64, dof: f64| {
            format!("{what} (χ² = {chi_squared:.1}, ν = {dof:.1})")
        };
        for (part, f) in own.iter().zip(&adjustment.frequencies) {
            if beyond(part.chi_squared, part.dof) {
                places.push(said(format!("at {f} Hz"), part.chi_squared, part.dof));
            }
        }
        if beyond(shared.chi_squared, shared.dof) {
            let what = "in what the frequencies share".to_owned();
            places.push(said(what, shared.chi_squared, shared.dof));
        }
    }
    (!places.is_empty()).then(|| {
        Finding::new(
            Severity::Warning,
            "excess-residuals",
            format!(
                "the residuals {} are larger than the budget allows",
                places.join(", ")
            ),
        )
        .evidence(format!(
            "χ² = {whole:.1} with {dof:.0} degrees of freedom, a factor of {:.2} in u",
            (whole / dof).sqrt()
        ))
        .advice(
            "the result is with the uncertainties that the runs support (`components`); look at the runs with the largest \
             statistic, then at the repeatability in the budget",
        )
    })
}
