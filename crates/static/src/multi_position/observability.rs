//! Whether the equations determine every parameter.

use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::Equations;
use proofmass_uncertainty::algebra::thin_svd;

/// Condition number beyond which a direction of the parameters counts as undetermined.
const MAX_CONDITION: f64 = 1e4;

/// Condition number of the unweighted Jacobian; an error that names the parameter when it is hopeless.
///
/// # Errors
/// [`Error::Unobservable`] with the parameter that weighs most in the undetermined direction;
/// [`Error::TooFew`] for fewer equations than parameters.
pub(super) fn observability(
    equations: &Equations,
    p: usize,
    name: impl Fn(usize) -> &'static str,
) -> Result<f64, Error> {
    let n = equations.residual.len();
    if n < p {
        return Err(Error::TooFew {
            name: "standstills",
            needed: p,
            got: n,
        });
    }
    let jacobian = Mat::from_fn(n, p, |i, j| equations.jacobian[i * p + j]);
    let svd = thin_svd(&jacobian, "singular values")?;
    let (largest, smallest) = (svd.S()[0], svd.S()[p - 1]);
    let condition = if smallest > 0.0 {
        largest / smallest
    } else {
        f64::INFINITY
    };
    if !(condition < MAX_CONDITION) {
        let weight = |i: usize| svd.V()[(i, p - 1)].abs();
        let weakest = (0..p)
            .max_by(|&a, &b| weight(a).total_cmp(&weight(b)))
            .unwrap_or(0);
        return Err(Error::Unobservable {
            parameter: name(weakest),
            condition,
        });
    }
    Ok(condition)
}
