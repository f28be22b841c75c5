//! Three by three: the only algebra a triaxial sensor needs on a chip.

use crate::{Error, Float};

/// Row-major 3 × 3 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Matrix3<F>(pub [[F; 3]; 3]);

impl<F: Float> Matrix3<F> {
    /// The identity.
    pub fn identity() -> Self {
        Self::diagonal([F::ONE; 3])
    }

    /// Zero but for the diagonal.
    pub fn diagonal(d: [F; 3]) -> Self {
        let mut m = [[F::ZERO; 3]; 3];
        for i in 0..3 {
            m[i][i] = d[i];
        }
        Self(m)
    }

    /// Matrix times column vector.
    pub fn times(&self, v: [F; 3]) -> [F; 3] {
        let row = |r: &[F; 3]| r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
        [row(&self.0[0]), row(&self.0[1]), row(&self.0[2])]
    }

    /// Matrix product `self` · `other`.
    pub fn product(&self, other: &Self) -> Self {
        let mut m = [[F::ZERO; 3]; 3];
        for (i, row) in m.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate() {
                for k in 0..3 {
                    *element += self.0[i][k] * other.0[k][j];
                }
            }
        }
        Self(m)
    }

    /// Rows become columns.
    pub fn transpose(&self) -> Self {
        let m = &self.0;
        Self([
            [m[0][0], m[1][0], m[2][0]],
            [m[0][1], m[1][1], m[2][1]],
            [m[0][2], m[1][2], m[2][2]],
        ])
    }

    /// Determinant.
    pub fn determinant(&self) -> F {
        let m = &self.0;
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    }

    /// Inverse by cofactors.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for an element that is not a number; [`Error::Singular`] when the Frobenius
    /// condition number ‖M‖·‖M⁻¹‖ exceeds 1/(8 ε), where no digit of the inverse would be right.
    pub fn inverse(&self) -> Result<Self, Error> {
        if let Some(index) = self.0.iter().flatten().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "matrix",
                index,
            });
        }
        // Scaled to unit norm first: cofactors of counts in f32 would lose range, not digits.
        let norm = self.norm();
        if norm == F::ZERO {
            return Err(Error::Singular {
                name: "matrix",
                condition: f64::INFINITY,
            });
        }
        let mut m = self.0;
        for element in m.iter_mut().flatten() {
            *element = *element / norm;
        }
        let determinant = Self(m).determinant();
        let cofactor = |a: usize, b: usize, c: usize, d: usize| m[a][b] * m[c][d];
        let adjugate = Self([
            [
                cofactor(1, 1, 2, 2) - cofactor(1, 2, 2, 1),
                cofactor(0, 2, 2, 1) - cofactor(0, 1, 2, 2),
                cofactor(0, 1, 1, 2) - cofactor(0, 2, 1, 1),
            ],
            [
                cofactor(1, 2, 2, 0) - cofactor(1, 0, 2, 2),
                cofactor(0, 0, 2, 2) - cofactor(0, 2, 2, 0),
                cofactor(0, 2, 1, 0) - cofactor(0, 0, 1, 2),
            ],
            [
                cofactor(1, 0, 2, 1) - cofactor(1, 1, 2, 0),
                cofactor(0, 1, 2, 0) - cofactor(0, 0, 2, 1),
                cofactor(0, 0, 1, 1) - cofactor(0, 1, 1, 0),
            ],
        ]);
        let condition = adjugate.norm().to_f64() / determinant.abs().to_f64();
        let limit = 1.0 / (8.0 * F::EPSILON.to_f64());
        // NaN is that of 0/0.
        if condition.is_nan() || condition >= limit {
            return Err(Error::Singular {
                name: "matrix",
                condition: if condition.is_nan() {
                    f64::INFINITY
                } else {
                    condition
                },
            });
        }
        let mut inverse = adjugate.0;
        for element in inverse.iter_mut().flatten() {
            *element = *element / determinant / norm;
        }
        Ok(Self(inverse))
    }

    /// Frobenius norm.
    pub fn norm(&self) -> F {
        let mut sum = F::ZERO;
        for &v in self.0.iter().flatten() {
            sum += v * v;
        }
        sum.sqrt()
    }

    /// The same matrix in the other precision.
    pub fn cast<G: Float>(&self) -> Matrix3<G> {
        Matrix3(self.0.map(|row| row.map(|v| G::from_f64(v.to_f64()))))
    }
}

/// Scalar product.
pub fn dot<F: Float>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Euclidean norm.
pub fn norm<F: Float>(a: [F; 3]) -> F {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_inverse_times_matrix_is_identity() {
        let m = Matrix3([[415.0, 3.0, -2.0], [0.0, 413.0, 1.0], [0.5, 0.0, 415.0f64]]);
        let i = m.product(&m.inverse().unwrap());
        for r in 0..3 {
            for c in 0..3 {
                let expected = if r == c { 1.0 } else { 0.0 };
                // Condition number ~1.7 in the Frobenius sense times a few roundings.
                assert!((i.0[r][c] - expected).abs() < 1e-15 * 8.0);
            }
        }
    }

    #[test]
    fn known_inverse_of_one_two_three() {
        let m = Matrix3([[1.0, 2.0, 3.0], [0.0, 1.0, 4.0], [5.0, 6.0, 0.0f64]]);
        assert_eq!(m.determinant(), 1.0);
        let expected = [[-24.0, 18.0, 5.0], [20.0, -15.0, -4.0], [-5.0, 4.0, 1.0]];
        let inverse = m.inverse().unwrap();
        for r in 0..3 {
            for c in 0..3 {
                // ‖M‖‖M⁻¹‖ = 380, so 380 ε relative to the largest element.
                assert!((inverse.0[r][c] - expected[r][c]).abs() < 380.0 * 24.0 * f64::EPSILON);
            }
        }
    }

    #[test]
    fn refuses_singular_and_not_finite() {
        let flat = Matrix3([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0f64]]);
        assert!(matches!(flat.inverse(), Err(Error::Singular { .. })));
        let zero = Matrix3([[0.0f32; 3]; 3]);
        assert!(matches!(zero.inverse(), Err(Error::Singular { .. })));
        let mut nan = Matrix3::<f64>::identity();
        nan.0[1][2] = f64::NAN;
        assert_eq!(
            nan.inverse(),
            Err(Error::NotFinite {
                name: "matrix",
                index: 5
            })
        );
    }
}
