//! Residuals beyond the budget, where they are.

use super::upper_tail;
use crate::shaker::adjustment::Adjustment;
use proofmass_uncertainty::{Finding, Severity};

/// Probability of residuals as large by chance, over all frequencies, from which they count as beyond the budget.
const BEYOND: f64 = 1e-3;

/// By how much the variance of the residuals of each frequency exceeds what the budget allows; zero where it does not.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Excess {
    /// By frequency.
    pub(super) of: Vec<f64>,
    /// Degrees of freedom of the residuals of each frequency.
    pub(super) dof: Vec<f64>,
    finding: Option<Finding>,
}

impl Excess {
    /// The contradiction of one frequency stays there; what all share, such as mounting angles that scatter more than
    /// declared, is in all of them.
    pub(super) fn new(adjustment: &Adjustment) -> Self {
        let (own, shared) = adjustment.parts();
        let count = own.len();
        let (whole, dof) = (adjustment.chi_squared, adjustment.dof() as f64);
        let beyond = |chi_squared: f64, dof: f64| {
            if dof > 0.5 && upper_tail(chi_squared, dof) < BEYOND / count as f64 {
                (chi_squared / dof - 1.0).max(0.0)
            } else {
                0.0
            }
        };
        if count == 1 {
            let excess = beyond(whole, dof);
            let place = format!("at {} Hz", adjustment.frequencies[0]);
            return Self {
                of: vec![excess],
                dof: vec![dof],
                finding: (excess > 0.0).then(|| finding(&place, whole, dof)),
            };
        }
        let common = beyond(shared.chi_squared, shared.dof);
        let mut places = vec![];
        let of: Vec<f64> = own
            .iter()
            .zip(&adjustment.frequencies)
            .map(|(part, f)| {
                let excess = beyond(part.chi_squared, part.dof);
                if excess > 0.0 {
                    places.push(format!(
                        "at {f} Hz (χ² = {:.1}, ν = {:.1})",
                        part.chi_squared, part.dof
                    ));
                }
                excess.max(common)
            })
            .collect();
        if common > 0.0 {
            places.push(format!(
                "in what the frequencies share (χ² = {:.1}, ν = {:.1})",
                shared.chi_squared, shared.dof
            ));
        }
        Self {
            of,
            dof: own.iter().map(|p| p.dof.max(1.0)).collect(),
            finding: (!places.is_empty()).then(|| finding(&places.join(", "), whole, dof)),
        }
    }

    pub(super) fn finding(&self) -> Option<Finding> {
        self.finding.clone()
    }
}

fn finding(place: &str, chi_squared: f64, dof: f64) -> Finding {
    Finding::new(
        Severity::Warning,
        "excess-residuals",
        format!("the residuals {place} are larger than the budget allows"),
    )
    .evidence(format!(
        "χ² = {chi_squared:.1} with {dof:.0} degrees of freedom, a factor of {:.2} in u",
        (chi_squared / dof).sqrt()
    ))
    .advice(
        "the uncertainties are enlarged there by that factor; look at the runs with the largest statistic, then at the \
         repeatability in the budget",
    )
}
