//! Residuals beyond the budget, where they are.

use crate::adjustment::{Adjustment, Part};
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{Finding, findings::excess_residuals};

/// Probability of residuals as large by chance, over all frequencies, from which they count as beyond the budget.
const BEYOND: f64 = 1e-3;

/// Frequencies whose residuals are larger than what is declared, or what all frequencies share, such as mounting angles
/// that scatter more.
pub(super) fn finding(adjustment: &Adjustment) -> Option<Finding> {
    let (own, shared) = adjustment.parts();
    let count = own.len();
    let (chi_squared, dof) = (adjustment.chi_squared, adjustment.dof() as f64);
    let beyond = |part: Part| {
        let Part { chi_squared, dof } = part;
        dof > 0.5
            && chi_squared > dof
            && chi_squared_chance(chi_squared, dof) < BEYOND / count as f64
    };
    let mut places = vec![];
    if count == 1 {
        if beyond(Part { chi_squared, dof }) {
            places.push(format!("at {} Hz", adjustment.frequencies[0]));
        }
    } else {
        let mut told = |what: String, part: Part| {
            if beyond(part) {
                let Part { chi_squared, dof } = part;
                places.push(format!("{what} (χ² = {chi_squared:.1}, ν = {dof:.1})"));
            }
        };
        for (part, f) in own.into_iter().zip(&adjustment.frequencies) {
            told(format!("at {f} Hz"), part);
        }
        told("in what the frequencies share".to_owned(), shared);
    }
    (!places.is_empty()).then(|| {
        excess_residuals(
            &places.join(", "),
            &format!(
                "χ² = {chi_squared:.1} with {dof:.0} degrees of freedom, a factor of {:.2} in u",
                (chi_squared / dof).sqrt()
            ),
            "`components` has those that the runs support; look at the runs with the largest statistic, then at the \
             repeatability in the budget",
        )
    })
}
