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

/// As [`symmetric_eigenvalues`], of a Hermitian matrix.
///
/// **Errors** [`Error::NotConverged`] of this name.
pub fn hermitian_eigenvalues(m: &Mat<c64>, name: &'static str) -> Result<Vec<f64>, Error> {
    m.self_adjoint_eigenvalues(Side::Lower)
        .map_err(|_| not_converged(name))
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
    m.partial_piv_lu().solve(right)
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
