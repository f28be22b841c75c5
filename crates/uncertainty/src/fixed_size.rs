//! Propagation for functions of fixed size, without allocation.

use crate::Dual;

/// Values and covariance of a fixed-size function of n inputs, without a single allocation: for models in an
/// inner loop, such as the inverse of a 3 × 3 matrix.
///
/// **Shapes** `covariance` is n × n, the result m × m.
///
/// ```
/// use proofmass_uncertainty::propagate_fixed;
/// let (y, u2) = propagate_fixed(|[a, b]| [a * b], [2.0, 3.0], [[0.01, 0.0], [0.0, 0.04]]);
/// assert_eq!(y, [6.0]);
/// assert!((u2[0][0] - (9.0 * 0.01 + 4.0 * 0.04)).abs() < 1e-15);
/// ```
#[inline]
pub fn propagate_fixed<const N: usize, const M: usize>(
    f: impl Fn([Dual<f64, N>; N]) -> [Dual<f64, N>; M],
    x: [f64; N],
    covariance: [[f64; N]; N],
) -> ([f64; M], [[f64; M]; M]) {
    let y = f(std::array::from_fn(|i| Dual::variable(x[i], i)));
    // J C, then each element of the symmetric product once.
    let half: [[f64; N]; M] = std::array::from_fn(|i| {
        let mut row = [0.0; N];
        for k in 0..N {
            let j = y[i].partials[k];
            for l in 0..N {
                row[l] += j * covariance[k][l];
            }
        }
        row
    });
    let mut result = [[0.0; M]; M];
    for i in 0..M {
        for j in 0..=i {
            let mut sum = 0.0;
            for l in 0..N {
                sum += half[i][l] * y[j].partials[l];
            }
            result[i][j] = sum;
            result[j][i] = sum;
        }
    }
    (y.map(|y| y.real), result)
}

/// As [`propagate_fixed`], for independent inputs with these standard uncertainties.
///
/// ```
/// use proofmass_uncertainty::propagate_independent;
/// let (y, u2) = propagate_independent(|[a, b]| [a * b, a], [2.0, 3.0], [0.1, 0.2]);
/// assert!((u2[0][0] - (9.0 * 0.01 + 4.0 * 0.04)).abs() < 1e-15);
/// assert!((u2[0][1] - 3.0 * 0.01).abs() < 1e-15);
/// assert_eq!(y, [6.0, 2.0]);
/// ```
#[inline]
pub fn propagate_independent<const N: usize, const M: usize>(
    f: impl Fn([Dual<f64, N>; N]) -> [Dual<f64, N>; M],
    x: [f64; N],
    u: [f64; N],
) -> ([f64; M], [[f64; M]; M]) {
    let y = f(std::array::from_fn(|i| Dual::variable(x[i], i)));
    let jacobian = std::array::from_fn(|i| y[i].partials);
    (y.map(|y| y.real), propagate_jacobian(&jacobian, &u))
}

/// Covariance of m results of n independent inputs from a Jacobian that is known analytically: J diag(u²) Jᵀ.
#[inline]
pub fn propagate_jacobian<const N: usize, const M: usize>(
    jacobian: &[[f64; N]; M],
    u: &[f64; N],
) -> [[f64; M]; M] {
    let mut contributions = [[0.0; N]; M];
    let mut transposed = [[0.0; M]; N];
    for i in 0..M {
        for k in 0..N {
            contributions[i][k] = jacobian[i][k] * u[k];
            transposed[k][i] = contributions[i][k];
        }
    }
    // A row at a time as a sum of rows: whole vectors, no sum that waits for itself. The upper triangle costs less
    // than telling it apart, and is bit for bit the lower one.
    let mut result = [[0.0; M]; M];
    for (row, contribution) in result.iter_mut().zip(&contributions) {
        let mut sum = [0.0; M];
        for (c, others) in contribution.iter().zip(&transposed) {
            for (s, other) in sum.iter_mut().zip(others) {
                *s += c * other;
            }
        }
        *row = sum;
    }
    result
}
