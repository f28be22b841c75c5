//! Complex 3 × 3 matrices: sensitivities and their inverses.

use num_complex::Complex64;
use proofmass_core::Error;

/// Rows of a complex 3 × 3 matrix.
pub type Matrix = [[Complex64; 3]; 3];

/// Names of the axes, in order.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// The product of a row and a matrix.
pub fn row_times(row: [Complex64; 3], m: &Matrix) -> [Complex64; 3] {
    std::array::from_fn(|j| (0..3).map(|i| row[i] * m[i][j]).sum())
}

/// The product of two matrices.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| row_times(a[i], b))
}

/// The inverse, by cofactors.
///
/// # Errors
/// [`Error::Singular`] when the determinant vanishes against the product of the row lengths.
pub fn inverse(m: &Matrix) -> Result<Matrix, Error> {
    let cofactor = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]
    };
    let determinant: Complex64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    let scale: f64 = m
        .iter()
        .map(|row| row.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt())
        .product();
    let condition = scale / determinant.norm();
    if !(condition < 1e12) {
        return Err(Error::Singular {
            name: "sensitivity matrix",
            condition,
        });
    }
    Ok(std::array::from_fn(|i| {
        std::array::from_fn(|j| cofactor(j, i) / determinant)
    }))
}

/// Real parts re and im of the nine terms, row by row: the order of all parameter vectors and covariances.
pub fn to_real(m: &Matrix) -> [f64; 18] {
    let mut v = [0.0; 18];
    for i in 0..3 {
        for j in 0..3 {
            v[2 * (3 * i + j)] = m[i][j].re;
            v[2 * (3 * i + j) + 1] = m[i][j].im;
        }
    }
    v
}

/// The matrix behind a vector of 18 reals.
pub fn from_real(v: &[f64]) -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| Complex64::new(v[2 * (3 * i + j)], v[2 * (3 * i + j) + 1]))
    })
}

/// Jacobian (18 × 18, row-major) of vec A for A = S⁻¹: dA = −A dS A.
pub fn inverse_jacobian(a: &Matrix) -> Vec<f64> {
    let mut jacobian = vec![0.0; 18 * 18];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                for l in 0..3 {
                    // dA_ij = −A_ik dS_kl A_lj, complex-linear in dS.
                    let g = -a[i][k] * a[l][j];
                    let (row, column) = (2 * (3 * i + j), 2 * (3 * k + l));
                    jacobian[row * 18 + column] = g.re;
                    jacobian[row * 18 + column + 1] = -g.im;
                    jacobian[(row + 1) * 18 + column] = g.im;
                    jacobian[(row + 1) * 18 + column + 1] = g.re;
                }
            }
        }
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Matrix {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let d = if i == j { 10.0 } else { 0.0 };
                Complex64::new(
                    d + 0.3 * i as f64 - 0.2 * j as f64,
                    0.1 * (i * j) as f64 - 0.05,
                )
            })
        })
    }

    #[test]
    fn law_a_matrix_times_its_inverse_is_one() {
        let m = example();
        let p = product(&m, &inverse(&m).unwrap());
        for (i, row) in p.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                assert!((v - Complex64::new(f64::from(i == j), 0.0)).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn law_the_jacobian_of_the_inverse_is_its_difference() {
        let m = example();
        let jacobian = inverse_jacobian(&inverse(&m).unwrap());
        let step = 1e-6;
        for column in 0..18 {
            let (mut up, mut down) = (to_real(&m), to_real(&m));
            up[column] += step;
            down[column] -= step;
            let (up, down) = (
                to_real(&inverse(&from_real(&up)).unwrap()),
                to_real(&inverse(&from_real(&down)).unwrap()),
            );
            for row in 0..18 {
                let difference = (up[row] - down[row]) / (2.0 * step);
                // Central difference: rounding 1e-16/1e-6 of elements of size 0.1.
                assert!((jacobian[row * 18 + column] - difference).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn refuses_a_singular_matrix() {
        let row = [
            Complex64::new(1.0, 0.0),
            Complex64::new(2.0, 1.0),
            Complex64::new(0.0, 0.0),
        ];
        assert!(matches!(
            inverse(&[row, row, row]),
            Err(Error::Singular { .. })
        ));
    }
}
