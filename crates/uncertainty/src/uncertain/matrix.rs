//! Small matrices of numbers with uncertainty.

use super::Uncertain;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::ops::Mul;

/// A matrix whose elements carry their causes; a vector is a matrix of one column.
///
/// ```
/// use proofmass_uncertainty::{Uncertain, UncertainMatrix};
/// let element = |name: &str, value: f64, u: f64| Uncertain::new(name, value, u);
/// let a = UncertainMatrix::from_rows(2, vec![
///     element("a", 1.0, 0.1)?, element("b", 2.0, 0.2)?,
///     element("c", 3.0, 0.3)?, element("d", 4.0, 0.4)?,
/// ])?;
/// let inverse = a.inverse()?;
/// assert!((inverse.get(0, 0).unwrap().value() + 2.0).abs() < 1e-14);
/// assert!((inverse.get(0, 0).unwrap().standard_uncertainty() - 1.113_552_872_566_004).abs() < 1e-12);
/// // Identity is kept: A⁻¹A is 1 without uncertainty.
/// let one = inverse.product(&a)?;
/// assert!(one.elements().iter().all(|e| e.standard_uncertainty() < 1e-13));
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts")]
pub struct UncertainMatrix {
    columns: usize,
    elements: Vec<Uncertain>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Parts {
    columns: usize,
    elements: Vec<Uncertain>,
}

impl TryFrom<Parts> for UncertainMatrix {
    type Error = Error;
    fn try_from(parts: Parts) -> Result<Self, Error> {
        Self::from_rows(parts.columns, parts.elements)
    }
}

impl UncertainMatrix {
    /// From its elements, row by row.
    ///
    /// # Errors
    /// [`Error::Length`] when they do not fill whole rows, [`Error::TooFew`] without any.
    pub fn from_rows(columns: usize, elements: Vec<Uncertain>) -> Result<Self, Error> {
        if columns == 0 || elements.is_empty() {
            return Err(Error::TooFew {
                name: "elements of a matrix",
                needed: 1,
                got: 0,
            });
        }
        if !elements.len().is_multiple_of(columns) {
            return Err(Error::Length {
                name: "elements of a matrix",
                expected: elements.len().div_ceil(columns) * columns,
                got: elements.len(),
            });
        }
        Ok(Self { columns, elements })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.elements.len() / self.columns
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Elements, row by row.
    pub fn elements(&self) -> &[Uncertain] {
        &self.elements
    }

    /// One element; `None` outside.
    pub fn get(&self, row: usize, column: usize) -> Option<&Uncertain> {
        if column >= self.columns {
            return None;
        }
        self.elements.get(row * self.columns + column)
    }

    /// Rows as columns.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let (m, n) = (self.rows(), self.columns);
        let elements = (0..m * n).map(|k| self.elements[(k % m) * n + k / m].clone());
        Self {
            columns: m,
            elements: elements.collect(),
        }
    }

    /// Product.
    ///
    /// # Errors
    /// [`Error::Length`] unless the other has as many rows as this has columns.
    pub fn product(&self, other: &Self) -> Result<Self, Error> {
        if other.rows() != self.columns {
            return Err(Error::Length {
                name: "rows of the right factor",
                expected: self.columns,
                got: other.rows(),
            });
        }
        let (m, n) = (self.columns, other.columns);
        let elements = (0..self.rows() * n).map(|k| {
            let terms =
                (0..m).map(|l| &self.elements[k / n * m + l] * &other.elements[l * n + k % n]);
            terms.sum()
        });
        Ok(Self {
            columns: n,
            elements: elements.collect(),
        })
    }

    /// X of A X = B.
    ///
    /// # Errors
    /// [`Error::Length`] for a matrix that is not square or a right side of another height, [`Error::Singular`].
    pub fn solve(&self, right: &Self) -> Result<Self, Error> {
        self.eliminate(right).map(|(solution, _)| solution)
    }

    /// Inverse.
    ///
    /// # Errors
    /// As [`UncertainMatrix::solve`].
    pub fn inverse(&self) -> Result<Self, Error> {
        let n = self.columns;
        let unit = |k: usize| Uncertain::exact(if k / n == k % n { 1.0 } else { 0.0 });
        self.solve(&Self {
            columns: n,
            elements: (0..n * n).map(unit).collect(),
        })
    }

    /// Determinant.
    ///
    /// # Errors
    /// As [`UncertainMatrix::solve`].
    pub fn determinant(&self) -> Result<Uncertain, Error> {
        let empty = Self {
            columns: 1,
            elements: vec![Uncertain::exact(0.0); self.rows()],
        };
        self.eliminate(&empty).map(|(_, determinant)| determinant)
    }

    /// By Gauss with the largest pivot of each column.
    fn eliminate(&self, right: &Self) -> Result<(Self, Uncertain), Error> {
        let (n, m) = (self.columns, right.columns);
        for (name, got) in [
            ("rows of a square matrix", self.rows()),
            ("rows of the right side", right.rows()),
        ] {
            if got != n {
                return Err(Error::Length {
                    name,
                    expected: n,
                    got,
                });
            }
        }
        let mut a: Vec<Vec<Uncertain>> =
            self.elements.chunks(n).map(<[Uncertain]>::to_vec).collect();
        let mut b: Vec<Vec<Uncertain>> = right
            .elements
            .chunks(m)
            .map(<[Uncertain]>::to_vec)
            .collect();
        let scale = self
            .elements
            .iter()
            .map(|e| e.value().abs())
            .fold(0.0, f64::max);
        let mut determinant = Uncertain::exact(1.0);
        for c in 0..n {
            let size = |r: &usize| a[*r][c].value().abs();
            let pivot = (c..n)
                .max_by(|r, s| size(r).total_cmp(&size(s)))
                .unwrap_or(c);
            // Not one digit is left of a smaller one.
            if !(a[pivot][c].value().abs() > 1e-15 * scale) {
                return Err(Error::Singular {
                    name: "matrix of numbers with uncertainty",
                    condition: f64::INFINITY,
                });
            }
            if pivot != c {
                a.swap(pivot, c);
                b.swap(pivot, c);
                determinant = -determinant;
            }
            determinant *= &a[c][c];
            for r in (0..n).filter(|&r| r != c) {
                let factor = &a[r][c] / &a[c][c];
                for k in c..n {
                    a[r][k] = &a[r][k] - &factor * &a[c][k];
                }
                for k in 0..m {
                    b[r][k] = &b[r][k] - &factor * &b[c][k];
                }
            }
        }
        let elements = (0..n * m).map(|k| &b[k / m][k % m] / &a[k / m][k / m]);
        let solution = Self {
            columns: m,
            elements: elements.collect(),
        };
        Ok((solution, determinant))
    }
}

impl Mul<&Uncertain> for &UncertainMatrix {
    type Output = UncertainMatrix;
    fn mul(self, factor: &Uncertain) -> UncertainMatrix {
        UncertainMatrix {
            columns: self.columns,
            elements: self.elements.iter().map(|e| e * factor).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(name: &str, value: f64, u: f64) -> Uncertain {
        Uncertain::new(name, value, u).unwrap()
    }

    #[test]
    fn known_linear_equations() {
        let a = UncertainMatrix::from_rows(
            2,
            vec![
                element("a", 0.0, 0.1),
                element("b", 2.0, 0.2),
                element("c", 3.0, 0.3),
                element("d", 4.0, 0.4),
            ],
        )
        .unwrap();
        let right =
            UncertainMatrix::from_rows(1, vec![Uncertain::exact(2.0), Uncertain::exact(7.0)])
                .unwrap();
        let x = a.solve(&right).unwrap();
        assert!(x.elements().iter().all(|x| (x.value() - 1.0).abs() < 1e-15));
        // dx = −A⁻¹ dA x with x = (1, 1): x₁ sees (4/6)(da + db) and (2/6)(dc + dd).
        let u = (4.0 / 6.0 * 0.1f64.hypot(0.2)).hypot(2.0 / 6.0 * 0.5);
        assert!((x.elements()[0].standard_uncertainty() - u).abs() < 1e-14);
        let det = a.determinant().unwrap();
        assert!((det.value() + 6.0).abs() < 1e-14);
        let u = [0.1 * 4.0, 0.2 * 3.0, 0.3 * 2.0, 0.0f64]
            .iter()
            .map(|u| u * u)
            .sum::<f64>()
            .sqrt();
        assert!((det.standard_uncertainty() - u).abs() < 1e-14);
        assert_eq!(a.transposed().get(0, 1), a.get(1, 0));
        assert!(a.product(&right).is_ok() && right.product(&right).is_err());
        assert!(right.determinant().is_err());
        let text = serde_json::to_string(&a).unwrap();
        assert_eq!(serde_json::from_str::<UncertainMatrix>(&text).unwrap(), a);
        assert!(
            serde_json::from_str::<UncertainMatrix>(
                &text.replace("\"columns\":2", "\"columns\":3")
            )
            .is_err()
        );
        let singular = UncertainMatrix::from_rows(2, vec![Uncertain::exact(1.0); 4]).unwrap();
        assert!(singular.inverse().is_err());
    }
}
