//! Normal equations whose unknowns belong mostly to few runs, or to one frequency: solved within their envelope.

use super::lanes::Real;
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::cholesky;
use pulp::Simd;

/// Cholesky factor L of a positive definite matrix, without the runs of zeros of its rows.
///
/// What several blocks share comes last: the other rows of L then have little to the left of the diagonal.
///
/// **Source** `[GeorgeLiu1981]` chapter 4.
pub(super) struct Envelope {
    /// Unknown of each row, and its standard deviation.
    unknowns: Vec<(usize, f64)>,
    rows: Vec<Row>,
    runs: Vec<Run>,
    values: Vec<f64>,
}

/// A row of L: the end of its runs and the reciprocal of the diagonal.
struct Row {
    end: usize,
    reciprocal: f64,
}

/// Elements of a row from one column on, and where their values end.
struct Run {
    column: usize,
    end: usize,
}

/// Zeros for which a run ends; fewer are cheaper to multiply than to step over.
const GAP: usize = 6;

/// Unknowns that an equation connects, and the block (the frequency) it belongs to.
pub(super) struct Group {
    pub(super) block: usize,
    pub(super) unknowns: Vec<usize>,
}

/// Additions that do not wait for each other.
const SUMS: usize = 4;

impl Envelope {
    /// From the covariance (row-major) that is the inverse of the matrix, and the groups of unknowns that equations
    /// connect; two that are in no group together have a zero there.
    ///
    /// # Errors
    /// [`Error::Singular`] for a covariance that is not positive definite.
    pub(super) fn new(covariance: &[f64], groups: &[Group]) -> Result<Self, Error> {
        let singular = Error::Singular {
            name: "normal equations of a trial",
            condition: f64::INFINITY,
        };
        let count = covariance.len().isqrt();
        let deviation: Vec<f64> = (0..count)
            .map(|i| covariance[i * count + i].sqrt())
            .collect();
        // In units of the standard deviations, so that volts and radians are alike.
        let correlation = Mat::from_fn(count, count, |i, j| {
            covariance[i * count + j] / (deviation[i] * deviation[j])
        });
        let normal = cholesky(&correlation).map_err(|_| singular)?.inverse();
        // Unknowns of one block together, in it those of few equations first; after them what several blocks share.
        let mut keys = vec![(false, usize::MAX, 0, 0); count];
        for (g, group) in groups.iter().enumerate() {
            for &unknown in &group.unknowns {
                let (shared, block, equations, last) = &mut keys[unknown];
                *shared |= *equations > 0 && *block != group.block;
                (*block, *last) = (group.block, g);
                *equations += 1;
            }
        }
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|&unknown| match keys[unknown] {
            (true, _, equations, last) => (true, 0, equations, last),
            local => local,
        });
        let mut place = vec![0; count];
        for (position, &unknown) in order.iter().enumerate() {
            place[unknown] = position;
        }
        let mut first: Vec<usize> = (0..count).collect();
        for group in groups {
            let least = group.unknowns.iter().map(|&u| place[u]).min().unwrap_or(0);
            for &unknown in &group.unknowns {
                first[place[unknown]] = first[place[unknown]].min(least);
            }
        }
        // What is in no equation together is exactly zero, where the covariance left the rounding of its inverse.
        let mut l = vec![0.0; count * count];
        for group in groups {
            for &i in &group.unknowns {
                for &j in &group.unknowns {
                    l[place[i] * count + place[j]] = normal[(i, j)];
                }
            }
        }
        let mut factor = Self {
            unknowns: order.iter().map(|&u| (u, deviation[u])).collect(),
            rows: Vec::with_capacity(count),
            runs: vec![],
            values: vec![],
        };
        // Row by row in full, so that a row can be subtracted from the next ones.
        for i in 0..count {
            let (above, below) = l.split_at_mut(i * count);
            let row = &mut below[..count];
            let first = first[i];
            // An unknown of the prior alone stands in no group.
            let mut square = if row[i] != 0.0 {
                row[i]
            } else {
                normal[(order[i], order[i])]
            };
            for j in first..i {
                let theirs = &above[j * count..j * count + j];
                let products = row[first..j].iter().zip(&theirs[first..]);
                let inner: f64 = products.map(|(a, b)| a * b).sum();
                let value = (row[j] - inner) * factor.rows[j].reciprocal;
                square -= value * value;
                row[j] = value;
            }
            if !(square > 0.0) {
                return Err(singular);
            }
            factor.keep(&row[..i], 1.0 / square.sqrt());
        }
        Ok(factor)
    }

    /// The next row of L.
    fn keep(&mut self, row: &[f64], reciprocal: f64) {
        let mut zeros = GAP;
        for (column, &value) in row.iter().enumerate() {
            if value == 0.0 {
                zeros += 1;
                continue;
            }
            if zeros >= GAP {
                self.runs.push(Run { column, end: 0 });
            } else {
                self.values.extend(std::iter::repeat_n(0.0, zeros));
            }
            zeros = 0;
            self.values.push(value);
            if let Some(run) = self.runs.last_mut() {
                run.end = self.values.len();
            }
        }
        let end = self.runs.len();
        self.rows.push(Row { end, reciprocal });
    }

    /// Solves for the right-hand side of every trial; `work` has the same length. Returns the largest part of the solution, in
    /// standard deviations.
    #[inline(always)]
    pub(super) fn solve<S: Simd>(
        &self,
        simd: S,
        right: &[Real<S>],
        work: &mut [Real<S>],
        solution: &mut [Real<S>],
    ) -> Real<S> {
        let zero = Real::new(simd, 0.0);
        let (mut first, mut start) = (0, 0);
        for (i, row) in self.rows.iter().enumerate() {
            let (unknown, deviation) = self.unknowns[i];
            let mut sums = [zero; SUMS];
            for run in &self.runs[first..row.end] {
                let l = &self.values[start..run.end];
                let x = &work[run.column..run.column + l.len()];
                let (l4, x4) = (l.chunks_exact(SUMS), x.chunks_exact(SUMS));
                for (l, x) in l4.remainder().iter().zip(x4.remainder()) {
                    sums[0] += *x * *l;
                }
                for (l, x) in l4.zip(x4) {
                    for k in 0..SUMS {
                        sums[k] += x[k] * l[k];
                    }
                }
                start = run.end;
            }
            first = row.end;
            let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            work[i] = (right[unknown] * deviation - sum) * row.reciprocal;
        }
        let mut largest = zero;
        for (i, row) in self.rows.iter().enumerate().rev() {
            let (unknown, deviation) = self.unknowns[i];
            let value = work[i] * row.reciprocal;
            solution[unknown] = value * deviation;
            largest = largest.max(value.abs());
            let first = if i > 0 { self.rows[i - 1].end } else { 0 };
            for run in first..row.end {
                let start = if run > 0 { self.runs[run - 1].end } else { 0 };
                let l = &self.values[start..self.runs[run].end];
                let column = self.runs[run].column;
                for (x, l) in work[column..column + l.len()].iter_mut().zip(l) {
                    *x = *x - value * *l;
                }
            }
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Scalar;

    #[test]
    fn law_the_solution_is_the_covariance_times_the_right_hand_side() {
        // Two blocks of three unknowns that share two more; unknowns 0 and 1, 3 and 4 are in no equation together.
        let groups = [
            (0, vec![0, 2, 6, 7]),
            (0, vec![1, 2, 6]),
            (1, vec![3, 5, 7]),
            (1, vec![4, 5, 6, 7]),
        ]
        .map(|(block, unknowns)| Group { block, unknowns });
        let mut normal = Mat::<f64>::identity(8, 8);
        for (g, group) in groups.iter().enumerate() {
            for (a, &i) in group.unknowns.iter().enumerate() {
                for (b, &j) in group.unknowns.iter().enumerate() {
                    let part = |k: usize| ((1 + k + 3 * g) as f64).sin();
                    normal[(i, j)] += part(a) * part(b);
                }
            }
        }
        // Units that are far apart.
        let unit = |i: usize| 10f64.powi(i as i32 - 4);
        let inverse = cholesky(&normal).unwrap().inverse();
        let covariance: Vec<f64> = (0..64)
            .map(|k| inverse[(k / 8, k % 8)] * unit(k / 8) * unit(k % 8))
            .collect();
        let envelope = Envelope::new(&covariance, &groups).unwrap();
        // Zeros that no equation fills are not kept.
        assert!(
            envelope.values.len() < 8 * 7 / 2,
            "{}",
            envelope.values.len()
        );
        let simd = Scalar::new();
        let right: Vec<f64> = (0..8).map(|i| (i as f64 - 2.5) / unit(i)).collect();
        let zero = Real::new(simd, 0.0);
        let lanes: Vec<Real<Scalar>> = right.iter().map(|x| Real::new(simd, *x)).collect();
        let (mut work, mut solution) = (vec![zero; 8], vec![zero; 8]);
        let largest = envelope.solve(simd, &lanes, &mut work, &mut solution);
        let mut most = 0f64;
        for i in 0..8 {
            let mut found = [0.0];
            solution[i].store(&mut found);
            let expected: f64 = (0..8).map(|j| covariance[8 * i + j] * right[j]).sum();
            assert!((found[0] / expected - 1.0).abs() < 1e-12, "{i}");
            most = most.max((expected / covariance[9 * i].sqrt()).abs());
        }
        let mut found = [0.0];
        largest.store(&mut found);
        assert!((found[0] / most - 1.0).abs() < 1e-12);
    }
}
