//! A covariance matrix that has been checked once, so that everything later may rely on it.

use crate::algebra::symmetric_eigen;
use faer::Mat;
use proofmass_core::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Symmetric positive semi-definite matrix, row-major.
///
/// Built only through constructors that check it; serialised as an array of rows.
#[doc(alias("correlation", "variance matrix"))]
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    n: usize,
    elements: Vec<f64>,
}

/// Negative eigenvalues up to this share of the largest one are rounding, not indefiniteness.
///
/// A sum of n rank-one products in double precision leaves eigenvalues of relative size n·ε; the bound is that
/// for n of a few thousand.
const ROUNDING: f64 = 1e-12;

impl Covariance {
    /// All zeros: a quantity that is exactly known.
    pub fn zeros(n: usize) -> Self {
        Self {
            n,
            elements: vec![0.0; n * n],
        }
    }

    /// Independent components with these standard uncertainties.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`] for a value that is NaN, infinite or negative.
    pub fn from_standard_uncertainties(u: &[f64]) -> Result<Self, Error> {
        let mut covariance = Self::zeros(u.len());
        for (index, &u) in u.iter().enumerate() {
            if !u.is_finite() {
                return Err(Error::NotFinite {
                    name: "standard uncertainty",
                    index,
                });
            }
            if u < 0.0 {
                return Err(Error::OutOfRange {
                    name: "standard uncertainty",
                    value: u,
                    min: 0.0,
                    max: f64::INFINITY,
                });
            }
            covariance.elements[index * (covariance.n + 1)] = u * u;
        }
        Ok(covariance)
    }

    /// From the rows of a full matrix.
    ///
    /// **Shapes** `elements.len() == n * n`, row-major. The two triangles may differ by rounding (1e-12 of the
    /// product of the standard uncertainties); their mean is kept.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`], or [`Error::NotPositiveDefinite`] with the pair of components
    /// whose correlation breaks the rule.
    pub fn try_from_rows(n: usize, elements: &[f64]) -> Result<Self, Error> {
        if elements.len() != n * n {
            return Err(Error::Length {
                name: "covariance",
                expected: n * n,
                got: elements.len(),
            });
        }
        proofmass_core::check::finite("covariance", elements)?;
        let mut covariance = Self {
            n,
            elements: elements.to_vec(),
        };
        for i in 0..n {
            if covariance[(i, i)] < 0.0 {
                return Err(Error::NotPositiveDefinite {
                    name: "covariance",
                    row: i,
                    column: i,
                    value: covariance[(i, i)],
                });
            }
            for j in 0..i {
                let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                let (a, b) = (covariance[(i, j)], covariance[(j, i)]);
                if (a - b).abs() > ROUNDING * scale.max(f64::MIN_POSITIVE)
                    || a.abs() > scale * (1.0 + ROUNDING)
                {
                    return Err(Error::NotPositiveDefinite {
                        name: "covariance",
                        row: i,
                        column: j,
                        value: a / scale,
                    });
                }
                let mean = 0.5 * (a + b);
                covariance.elements[i * n + j] = mean;
                covariance.elements[j * n + i] = mean;
            }
        }
        covariance.check_semidefinite()?;
        Ok(covariance)
    }

    /// J C Jᵀ for a Jacobian given by rows: how this covariance appears in m = `jacobian.len() / n` results.
    ///
    /// Positive semi-definite by construction, so it cannot fail but for the shape.
    ///
    /// # Errors
    /// [`Error::Length`] when `jacobian` is not a whole number of rows of length n.
    pub fn propagate(&self, jacobian: &[f64]) -> Result<Self, Error> {
        let n = self.n;
        if n == 0 || !jacobian.len().is_multiple_of(n) {
            return Err(Error::Length {
                name: "Jacobian",
                expected: n,
                got: jacobian.len(),
            });
        }
        let m = jacobian.len() / n;
        let mut half = vec![0.0; m * n];
        for i in 0..m {
            for k in 0..n {
                let j = jacobian[i * n + k];
                if j != 0.0 {
                    for l in 0..n {
                        half[i * n + l] += j * self.elements[k * n + l];
                    }
                }
            }
        }
        let mut result = Self::zeros(m);
        for i in 0..m {
            for j in 0..=i {
                let mut value: f64 = (0..n).map(|l| half[i * n + l] * jacobian[j * n + l]).sum();
                // Rounding makes a variance that is exactly zero a little negative, and its root NaN.
                if i == j && value < 0.0 {
                    value = 0.0;
                }
                result.elements[i * m + j] = value;
                result.elements[j * m + i] = value;
            }
        }
        Ok(result)
    }

    /// The sum of two covariances of the same size: two independent causes.
    ///
    /// # Errors
    /// [`Error::Length`] when the sizes differ.
    pub fn plus(&self, other: &Self) -> Result<Self, Error> {
        if self.n != other.n {
            return Err(Error::Length {
                name: "covariance",
                expected: self.n,
                got: other.n,
            });
        }
        let elements = self
            .elements
            .iter()
            .zip(&other.elements)
            .map(|(a, b)| a + b)
            .collect();
        Ok(Self {
            n: self.n,
            elements,
        })
    }

    /// The covariance times a non-negative factor.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] when the factor is negative or not finite.
    pub fn scaled(&self, factor: f64) -> Result<Self, Error> {
        proofmass_core::check::not_negative("factor", factor)?;
        let elements = self.elements.iter().map(|v| v * factor).collect();
        Ok(Self {
            n: self.n,
            elements,
        })
    }

    /// Number of components.
    pub fn dimension(&self) -> usize {
        self.n
    }

    /// Row-major elements, n × n.
    pub fn elements(&self) -> &[f64] {
        &self.elements
    }

    /// Standard uncertainty of one component.
    pub fn standard_uncertainty(&self, i: usize) -> f64 {
        self[(i, i)].sqrt()
    }

    /// Correlation coefficient of two components; `None` where one of them is exactly known.
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let scale = (self[(i, i)] * self[(j, j)]).sqrt();
        (scale > 0.0).then(|| {
            if i == j {
                1.0
            } else {
                (self[(i, j)] / scale).clamp(-1.0, 1.0)
            }
        })
    }

    /// The matrix in faer's form, for algebra.
    pub fn to_mat(&self) -> Mat<f64> {
        Mat::from_fn(self.n, self.n, |i, j| self[(i, j)])
    }

    /// One element, written by callers that build a matrix known to be semi-definite; they set its mirror too.
    pub(crate) fn set(&mut self, i: usize, j: usize, value: f64) {
        self.elements[i * self.n + j] = value;
    }

    fn check_semidefinite(&self) -> Result<(), Error> {
        // Judged on the correlation matrix, so that components of very different units weigh alike.
        let active: Vec<usize> = (0..self.n).filter(|&i| self[(i, i)] > 0.0).collect();
        if active.len() < 2 {
            return Ok(());
        }
        let r = Mat::from_fn(active.len(), active.len(), |i, j| {
            self.correlation(active[i], active[j]).unwrap_or(0.0)
        });
        let eigen = symmetric_eigen(&r, "eigenvalues of the covariance")?;
        let smallest = eigen.S()[0];
        if smallest < -ROUNDING * active.len() as f64 {
            // The two components that weigh most in the offending direction name the culprit.
            let weight = |i: usize| eigen.U()[(i, 0)].abs();
            let mut order: Vec<usize> = (0..active.len()).collect();
            order.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
            let (a, b) = (active[order[0]], active[order[1]]);
            return Err(Error::NotPositiveDefinite {
                name: "covariance",
                row: a.min(b),
                column: a.max(b),
                value: self.correlation(a, b).unwrap_or(0.0),
            });
        }
        Ok(())
    }
}

impl std::ops::Index<(usize, usize)> for Covariance {
    type Output = f64;
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.elements[i * self.n + j]
    }
}

impl Serialize for Covariance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.elements.chunks(self.n.max(1)))
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Covariance {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Covariance".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        <Vec<Vec<f64>>>::json_schema(generator)
    }
}

impl<'de> Deserialize<'de> for Covariance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows: Vec<Vec<f64>> = Vec::deserialize(deserializer)?;
        let n = rows.len();
        if let Some(row) = rows.iter().position(|r| r.len() != n) {
            return Err(serde::de::Error::custom(format!(
                "covariance: row {row} has {} elements, {n} are needed",
                rows[row].len()
            )));
        }
        Self::try_from_rows(n, &rows.concat()).map_err(serde::de::Error::custom)
    }
}
