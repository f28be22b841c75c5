//! Would further terms explain the residuals of a fit? F tests of added variables, one after another.

mod deletions;
mod weighed;

pub(crate) use weighed::WeighedTerms;

use proofmass_core::numeric::dot;
use proofmass_uncertainty::{f_quantile, normal_quantile};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// A linearised fit whose residuals are to be explained.
#[derive(Clone, Debug)]
pub(crate) struct AddedTerms<'a> {
    /// ∂r/∂θ by rows, n × p.
    jacobian: &'a [f64],
    /// (JᵀWJ)⁻¹JᵀW by rows, p × n.
    gain: &'a [f64],
    /// √w.
    root: Vec<f64>,
    /// Weighted residuals less what the accepted terms explain.
    residual: Vec<f64>,
    /// Orthonormal weighted columns of the accepted terms.
    accepted: Vec<Vec<f64>>,
    freedom: usize,
    floor: f64,
    /// Rows are the equations of the fit in those in which columns are given; empty where they are the same.
    turned: &'a [f64],
}

/// What one group of terms explains.
#[derive(Clone, Debug)]
pub(crate) struct Test {
    /// Coefficient of each column.
    pub(crate) amplitudes: Vec<f64>,
    /// Probability of an F at least this large when none of the terms is there.
    pub(crate) p_value: f64,
    columns: Vec<Vec<f64>>,
    /// Length of each column outside the model over the standard deviation of an equation: what the coefficient is divided by
    /// in the root of the non-centrality.
    lengths: Vec<f64>,
    left: usize,
}

impl Test {
    /// Coefficient of one column alone that nine of ten data sets like these show at this level, the largest of all columns.
    pub(crate) fn found(&self, level: f64) -> f64 {
        let (m, nu) = (self.amplitudes.len() as f64, self.left as f64);
        let limit = m * f_quantile(1.0 - level, m, nu);
        // √(m F) is one standard deviation wide, and its limit as wide as the scatter is known.
        let root = limit.sqrt() + normal_quantile(POWER) * (1.0 + limit / (2.0 * nu)).sqrt();
        let lengths = self.lengths.iter().copied();
        root / lengths.fold(f64::INFINITY, f64::min)
    }
}

/// Probability that a term of the size [`Test::found`] is found.
const POWER: f64 = 0.9;
/// A column of which less than this share lies outside the span of the model cannot be told from the model.
const SEPARABLE: f64 = 0.02;

impl<'a> AddedTerms<'a> {
    /// `variances`: of the noise, and `excess` added to each in the fit; `freedom` = n − p.
    pub fn new(
        jacobian: &'a [f64],
        gain: &'a [f64],
        residual: &[f64],
        variances: &[f64],
        excess: f64,
        freedom: usize,
    ) -> Self {
        let root: Vec<f64> = variances
            .iter()
            .map(|v| (v + excess).sqrt().recip())
            .collect();
        let noise = variances.iter().map(|v| v / (v + excess)).sum::<f64>();
        Self {
            jacobian,
            gain,
            residual: residual.iter().zip(&root).map(|(r, w)| r * w).collect(),
            floor: noise / variances.len().max(1) as f64,
            root,
            accepted: Vec::new(),
            freedom,
            turned: &[],
        }
    }

    /// Columns will be given in other equations: rows of `turned` are those of the fit in them.
    #[must_use]
    pub fn turned(mut self, turned: &'a [f64]) -> Self {
        self.turned = turned;
        self
    }

    /// F test of columns d: r grows by d per unit of the coefficient.
    ///
    /// The variance it is judged by is that of the residuals left over, and never less than that of the noise.
    /// `None` where the columns cannot be told from the model or leave fewer than two degrees of freedom.
    pub fn test(&self, columns: &[Vec<f64>]) -> Option<Test> {
        let m = columns.len();
        let left = self.freedom.checked_sub(self.accepted.len() + m)?;
        if left < 2 {
            return None;
        }
        let mut orthonormal: Vec<Vec<f64>> = Vec::with_capacity(m);
        let mut triangle = vec![0.0; m * m];
        let own: Vec<Vec<f64>>;
        let columns = match self.turned.is_empty() {
            true => columns,
            false => {
                let n = self.residual.len();
                let times =
                    |column: &Vec<f64>| self.turned.chunks(n).map(|t| dot(t, column)).collect();
                own = columns.iter().map(times).collect();
                &own
            }
        };
        for (c, column) in columns.iter().enumerate() {
            let before = norm(column.iter().zip(&self.root).map(|(d, w)| d * w));
            let mut v = self.outside_the_model(column);
            for _ in 0..2 {
                for q in &self.accepted {
                    remove(&mut v, q);
                }
                for (k, q) in orthonormal.iter().enumerate() {
                    triangle[k * m + c] += remove(&mut v, q);
                }
            }
            let length = norm(v.iter().copied());
            if !(length > SEPARABLE * before) {
                return None;
            }
            triangle[c * m + c] = length;
            v.iter_mut().for_each(|x| *x /= length);
            orthonormal.push(v);
        }
        let shares: Vec<f64> = orthonormal.iter().map(|q| dot(q, &self.residual)).collect();
        let explained: f64 = shares.iter().map(|s| s * s).sum();
        let rest = dot(&self.residual, &self.residual) - explained;
        let variance = self.variance(rest, left);
        let f = explained / m as f64 / variance;
        let p_value = FisherSnedecor::new(m as f64, left as f64).map_or(1.0, |d| d.sf(f));
        let mut amplitudes = vec![0.0; m];
        for c in (0..m).rev() {
            let later: f64 = (c + 1..m)
                .map(|k| triangle[c * m + k] * amplitudes[k])
                .sum();
            amplitudes[c] = (shares[c] - later) / triangle[c * m + c];
        }
        let length = |c: usize| norm((0..=c).map(|k| triangle[k * m + c]));
        Some(Test {
            lengths: (0..m).map(|c| length(c) / variance.sqrt()).collect(),
            left,
            amplitudes,
            p_value,
            columns: orthonormal,
        })
    }

    /// Of one equation, from the squares left over, and never less than that of the noise.
    fn variance(&self, squares: f64, left: usize) -> f64 {
        let rest = squares.max(0.0) / left as f64;
        rest.max(self.floor).max(f64::MIN_POSITIVE)
    }

    /// Takes a group of terms into the model.
    pub fn accept(&mut self, test: &Test) {
        for q in &test.columns {
            remove(&mut self.residual, q);
            self.accepted.push(q.clone());
        }
    }

    /// √w (d − J G d).
    fn outside_the_model(&self, column: &[f64]) -> Vec<f64> {
        let n = column.len();
        let along: Vec<f64> = self.gain.chunks(n).map(|g| dot(g, column)).collect();
        let rows = self.jacobian.chunks(along.len().max(1));
        column
            .iter()
            .zip(rows)
            .zip(&self.root)
            .map(|((d, row), w)| w * (d - dot(row, &along)))
            .collect()
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

/// Removes from v its part along the unit vector q, and tells how long it was.
fn remove(v: &mut [f64], q: &[f64]) -> f64 {
    let share = dot(v, q);
    v.iter_mut().zip(q).for_each(|(x, q)| *x -= share * q);
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant fitted to six values that hold a line: the added slope is found with its F.
    #[test]
    fn known_slope_beside_a_constant() {
        let x = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5];
        let noise = [0.1, -0.1, 0.0, 0.0, -0.1, 0.1];
        let residual: Vec<f64> = x.iter().zip(noise).map(|(x, e)| 0.3 * x + e).collect();
        let (jacobian, gain) = ([-1.0; 6], [-1.0 / 6.0; 6]);
        let terms = AddedTerms::new(&jacobian, &gain, &residual, &[1e-4; 6], 0.0, 5);
        let test = terms.test(&[x.to_vec()]).unwrap();
        // Σxe = 0: the slope is exact; F = 0.09 · 17.5/(0.04/4) = 157.5 with 1 and 4.
        assert!((test.amplitudes[0] - 0.3).abs() < 1e-12);
        assert!((test.p_value - FisherSnedecor::new(1.0, 4.0).unwrap().sf(157.5)).abs() < 1e-12);
        let mut after = terms.clone();
        after.accept(&test);
        assert!(
            after.test(&[x.to_vec()]).is_none(),
            "nothing is left to tell"
        );
        assert!(terms.test(&[vec![1.0; 6]]).is_none(), "the model holds it");
    }
}
