//! Effective degrees of freedom: Welch–Satterthwaite and its generalisations.

use crate::DegreesOfFreedom;
#[cfg(feature = "estimate")]
pub use joint::{CorrelatedGroup, GroupDof, willink, willink_hall};

/// Effective degrees of freedom of a sum of independent contributions (u_i, ν_i): Welch–Satterthwaite.
///
/// ν_eff = (Σ u_i²)² / Σ u_i⁴/ν_i.
///
/// **Assumes** independent contributions, each variance with its own ν_i, and ν_i not smaller than about 4 for
/// the dominant ones; below, the interval built on ν_eff may cover less than it says.
/// **Source** `[GUM] G.2b`.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, welch_satterthwaite};
/// let nu = |n| DegreesOfFreedom::new(n).unwrap();
/// let effective = welch_satterthwaite(&[(0.25, nu(9.0)), (0.57, nu(4.0)), (0.82, nu(14.0))]);
/// assert!((effective.get() - 19.0).abs() < 0.05); // `[GUM]` G.4.1
/// ```
pub fn welch_satterthwaite(contributions: &[(f64, DegreesOfFreedom)]) -> DegreesOfFreedom {
    // Scaled by the largest, so that u⁴ neither overflows nor underflows for any unit.
    let largest = contributions
        .iter()
        .fold(0.0, |m: f64, (u, _)| m.max(u.abs()));
    if largest == 0.0 {
        return DegreesOfFreedom::INFINITE;
    }
    let variance: f64 = contributions
        .iter()
        .map(|(u, _)| (u / largest).powi(2))
        .sum();
    let spread: f64 = contributions
        .iter()
        .map(|(u, nu)| (u / largest).powi(4) / nu.get())
        .sum();
    DegreesOfFreedom::new(variance * variance / spread).unwrap_or(DegreesOfFreedom::INFINITE)
}

#[cfg(feature = "estimate")]
mod joint;
