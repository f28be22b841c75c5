//! Factorisations and products of matrices, compiled once for every room that needs them.
//!
//! They are faer's. Called by its own methods, each crate compiles them anew. A dozen unknowns in plain arrays are solved by
//! [`adjustment`](crate::adjustment).

use faer::linalg::solvers::{Llt, LltError, SelfAdjointEigen, Solve, SolveLstsq, Svd};
use faer::{Mat, MatRef, Side, c64};
use proofmass_core::Error;

/// An iteration that did not end, by the name of what it sought.
fn not_converged(name: &'static str) -> Error {
    Error::NotConverged {
        name,
        iterations: 0,
        step: f64::INFINITY,
    }
}

/// A symmetric positive definite matrix by its lower triangular factor, M = L Lᵀ.
#[derive(Clone, Debug)]
pub struct Cholesky(Llt<f64>);

impl Cholesky {
    /// M⁻¹ B.
    pub fn solve(&self, right: &Mat<f64>) -> Mat<f64> {
        self.0.solve(right)
    }

    /// M⁻¹.
    pub fn inverse(&self) -> Mat<f64> {
        let n = self.lower().nrows();
        self.0.solve(Mat::<f64>::identity(n, n))
    }

    /// L.
    pub fn lower(&self) -> MatRef<'_, f64> {
        self.0.L()
    }
}

/// Cholesky's factor of a symmetric matrix, of which the lower triangle is read.
///
/// **Errors** the pivot that is not positive.
///
/// ```
/// use faer::Mat;
/// use proofmass_uncertainty::algebra::cholesky;
/// let m = Mat::from_fn(2, 2, |i, j| if i == j { 2.0 } else { 1.0 });
/// assert!((cholesky(&m)?.inverse()[(0, 1)] + 1.0 / 3.0).abs() < 1e-15);
/// # Ok::<(), faer::linalg::solvers::LltError>(())
/// ```
pub fn cholesky(m: &Mat<f64>) -> Result<Cholesky, LltError> {
    m.llt(Side::Lower).map(Cholesky)
}

/// Eigenvalues, from the smallest, and eigenvectors of a symmetric matrix, of which the lower triangle is read.
///
/// **Errors** [`Error::NotConverged`] of this name.
pub fn symmetric_eigen(m: &Mat<f64>, name: &'static str) -> Result<SelfAdjointEigen<f64>, Error> {
    m.self_adjoint_eigen(Side::Lower)
        .map_err(|_| not_converged(name))
}

/// Eigenvalues of a symmetric matrix from the smallest; the lower triangle is read.
///
/// **Errors** [`Error::NotConverged`] of this name.
pub fn symmetric_eigenvalues(m: &Mat<f64>, name: &'static str) -> Result<Vec<f64>, Error> {
    m.self_adjoint_eigenvalues(Side::Lower)
        .map_err(|_| not_converged(name))
}

/// As [`symmetric_eigenvalues`], of a Hermitian matrix that is filled on both sides.
///
/// **Errors** [`Error::NotConverged`] of this name.
pub fn hermitian_eigenvalues(m: &Mat<c64>, name: &'static str) -> Result<Vec<f64>, Error> {
    let twice = symmetric_eigenvalues(&real_form(m), name)?;
    Ok(twice.into_iter().step_by(2).collect())
}

/// A + iB as the real matrix of twice the size that does the same, A −B over B A. The complex ones have three rows: factorisations of their own
/// would be compiled for nothing.
fn real_form(m: &Mat<c64>) -> Mat<f64> {
    let (rows, columns) = (m.nrows(), m.ncols());
    Mat::from_fn(2 * rows, 2 * columns, |i, j| {
        let z = m[(i % rows, j % columns)];
        match (i < rows, j < columns) {
            (true, false) => -z.im,
            (false, true) => z.im,
            _ => z.re,
        }
    })
}

/// Singular values, from the largest, with as many singular vectors.
///
/// **Errors** [`Error::NotConverged`] of this name.
pub fn thin_svd(m: &Mat<f64>, name: &'static str) -> Result<Svd<f64>, Error> {
    m.thin_svd().map_err(|_| not_converged(name))
}

/// M⁺ by its singular values.
pub fn pseudo_inverse(svd: &Svd<f64>) -> Mat<f64> {
    svd.pseudoinverse()
}

/// M⁻¹ B, by rows exchanged for the largest pivot.
pub fn solve_linear(m: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    m.partial_piv_lu().solve(right)
}

/// As [`solve_linear`], of complex matrices.
pub fn solve_complex(m: &Mat<c64>, right: &Mat<c64>) -> Mat<c64> {
    let rows = m.nrows();
    let stacked = Mat::from_fn(2 * rows, right.ncols(), |i, j| {
        let z = right[(i % rows, j)];
        if i < rows { z.re } else { z.im }
    });
    let x = solve_linear(&real_form(m), &stacked);
    Mat::from_fn(rows, right.ncols(), |i, j| {
        c64::new(x[(i, j)], x[(i + rows, j)])
    })
}

/// The x that makes ‖M x − b‖ smallest for each column b, by orthogonal factors.
pub fn least_squares(m: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    m.qr().solve_lstsq(right)
}

/// Product of two or more matrices, from the left to the right.
///
/// ```
/// use faer::Mat;
/// use proofmass_uncertainty::algebra::product;
/// let x = Mat::from_fn(3, 1, |i, _| i as f64);
/// assert_eq!(product([x.transpose(), x.as_ref()])[(0, 0)], 5.0);
/// ```
pub fn product<const N: usize>(factors: [MatRef<'_, f64>; N]) -> Mat<f64> {
    product_of(&factors)
}

fn product_of(factors: &[MatRef<'_, f64>]) -> Mat<f64> {
    let [first, second, rest @ ..] = factors else {
        return factors
            .first()
            .map_or_else(Mat::new, |only| only.to_owned());
    };
    rest.iter().fold(first * second, |left, right| left * right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix 2, i over −i, 2 has the eigenvalues 1 and 3; what it makes of a vector is solved back.
    #[test]
    fn known_complex_matrices_by_their_real_form() {
        let i = c64::new(0.0, 1.0);
        let two = c64::new(2.0, 0.0);
        let m = Mat::from_fn(2, 2, |a, b| match (a, b) {
            (0, 1) => i,
            (1, 0) => -i,
            _ => two,
        });
        let eigenvalues = hermitian_eigenvalues(&m, "test").unwrap();
        assert_eq!(eigenvalues.len(), 2);
        assert!((eigenvalues[0] - 1.0).abs() < 1e-14 && (eigenvalues[1] - 3.0).abs() < 1e-14);
        // (2x + iy, −ix + 2y) of x = 1 + i, y = 3.
        let right = Mat::from_fn(2, 1, |a, _| [c64::new(2.0, 5.0), c64::new(7.0, -1.0)][a]);
        let x = solve_complex(&m, &right);
        assert!((x[(0, 0)] - c64::new(1.0, 1.0)).norm() < 1e-14);
        assert!((x[(1, 0)] - c64::new(3.0, 0.0)).norm() < 1e-14);
    }
}
