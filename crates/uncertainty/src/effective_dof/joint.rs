//! Effective degrees of freedom of correlated groups and of complex quantities.

use crate::{Covariance, DegreesOfFreedom};
use proofmass_core::Error;

/// How the variances inside a correlated group were found.
#[derive(Clone, Debug, PartialEq)]
pub enum GroupDof {
    /// All members were observed together, n times: their covariance matrix has n − 1 degrees of freedom as a
    /// whole, and so has the variance of any combination of them.
    Together(DegreesOfFreedom),
    /// Each variance was estimated on its own with these degrees of freedom; the correlation coefficients are
    /// known from the physics.
    Separately(Vec<DegreesOfFreedom>),
}

/// Contributions to one result that are correlated among themselves and with nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrelatedGroup {
    /// Covariance of the contributions c_i x_i.
    pub contributions: Covariance,
    /// What is known about it.
    pub dof: GroupDof,
}

/// Effective degrees of freedom when inputs are correlated in groups.
///
/// With u² = Σ over groups of their combined variances v_g,
///
/// ```text
/// ν_eff = u⁴ / Σ_g q_g,   q_g = v_g²/ν_g                       (observed together)
///                          q_g = Σ_i (Σ_j r_ij u_i u_j)²/ν_i    (variances estimated separately)
/// ```
///
/// The second form is the first-order variance of Σ r_ij s_i s_j. A group of one gives Welch–Satterthwaite.
/// **Source** `[Willink2007]`.
///
/// # Errors
/// [`Error::Length`] when the degrees of freedom do not fit the group.
///
/// ```
/// use proofmass_uncertainty::{Covariance, CorrelatedGroup, DegreesOfFreedom, GroupDof, willink};
/// let nu = |n| DegreesOfFreedom::new(n).unwrap();
/// // V, I and φ of `[GUM]` H.2 were read together five times: ν stays 4, whatever their correlation.
/// let together = CorrelatedGroup {
///     contributions: Covariance::try_from_rows(2, &[1.0, -0.3, -0.3, 2.0])?,
///     dof: GroupDof::Together(nu(4.0)),
/// };
/// assert_eq!(willink(&[together])?.get(), 4.0);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn willink(groups: &[CorrelatedGroup]) -> Result<DegreesOfFreedom, Error> {
    let (mut variance, mut spread) = (0.0, 0.0);
    for group in groups {
        let c = &group.contributions;
        let n = c.dimension();
        let rows: Vec<f64> = (0..n).map(|i| (0..n).map(|j| c[(i, j)]).sum()).collect();
        let v: f64 = rows.iter().sum::<f64>().max(0.0);
        variance += v;
        spread += match &group.dof {
            GroupDof::Together(nu) => v * v / nu.get(),
            GroupDof::Separately(nus) if nus.len() == n => rows
                .iter()
                .zip(nus)
                .map(|(row, nu)| row * row / nu.get())
                .sum(),
            GroupDof::Separately(nus) => {
                return Err(Error::Length {
                    name: "degrees of freedom of a group",
                    expected: n,
                    got: nus.len(),
                });
            }
        };
    }
    Ok(if variance > 0.0 {
        DegreesOfFreedom::new(variance * variance / spread).unwrap_or(DegreesOfFreedom::INFINITE)
    } else {
        DegreesOfFreedom::INFINITE
    })
}

/// Effective degrees of freedom of a complex quantity: a sum of independent complex contributions, each with a
/// 2 × 2 covariance (real, imaginary) and degrees of freedom.
///
/// ```text
/// ν = [2V₁₁² + (V₁₁V₂₂ + V₁₂²) + 2V₂₂²] / Σ_i [2v₁₁² + (v₁₁v₂₂ + v₁₂²) + 2v₂₂²]_i / ν_i
/// ```
///
/// with V the sum of the v_i; a contribution alone keeps its own ν.
/// **Source** `[WillinkHall2002]`.
///
/// # Errors
/// [`Error::Length`] when a covariance is not 2 × 2.
pub fn willink_hall(
    contributions: &[(Covariance, DegreesOfFreedom)],
) -> Result<DegreesOfFreedom, Error> {
    let measure = |a: f64, b: f64, c: f64| 2.0 * a * a + (a * b + c * c) + 2.0 * b * b;
    let (mut a, mut b, mut c, mut spread) = (0.0, 0.0, 0.0, 0.0);
    for (v, nu) in contributions {
        if v.dimension() != 2 {
            return Err(Error::Length {
                name: "covariance of a complex quantity",
                expected: 2,
                got: v.dimension(),
            });
        }
        let (v11, v22, v12) = (v[(0, 0)], v[(1, 1)], v[(0, 1)]);
        (a, b, c) = (a + v11, b + v22, c + v12);
        spread += measure(v11, v22, v12) / nu.get();
    }
    let total = measure(a, b, c);
    Ok(if total > 0.0 {
        DegreesOfFreedom::new(total / spread).unwrap_or(DegreesOfFreedom::INFINITE)
    } else {
        DegreesOfFreedom::INFINITE
    })
}
