//! Which observations contradict the others: looked for together, so that none hides another.

use super::{AddedTerms, SEPARABLE, Test, dot};
use proofmass_uncertainty::adjustment::{cholesky, solve};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Most observations named: beyond, it is the model that is at fault.
const MOST: usize = 40;

/// A fit from which observations are taken out one after the other, each of `each` equations.
///
/// P is the projection on what the model cannot follow, e = P r the residuals. Without the observations taken out,
/// P ← P − P_{·I} P_II⁻¹ P_{I·}, and e likewise; e_Iᵀ P_II⁻¹ e_I is what the squares fall by.
struct Deletions<'a> {
    terms: &'a AddedTerms<'a>,
    each: usize,
    /// P_II of every observation.
    blocks: Vec<f64>,
    residual: Vec<f64>,
    taken: Vec<usize>,
    /// Orthonormal columns that were taken out of P.
    removed: Vec<Vec<f64>>,
}

impl AddedTerms<'_> {
    /// Observations, of `each` equations in a row, that do not belong to the others; `level` is the probability of
    /// naming any on data without such.
    ///
    /// Two bad observations hide each other from a test of one. So the worst are taken out one after the other, as many as
    /// may be bad, and the largest number counts whose F test holds against all choices of so many, level/2^k for k of
    /// them, and whose last is significant among those left. Whoever is not significant beside the rest of them is no
    /// longer named.
    ///
    /// **Source** `[Rosner1983]` (as many as may be bad, the largest number that is significant); the deletion formulas
    /// are those of `[CookWeisberg1982] 2.2`.
    pub(crate) fn out_of_line(&self, each: usize, level: f64) -> Vec<(usize, Test)> {
        let n = self.residual.len() / each.max(1);
        let mut deletions = Deletions::of(self, each);
        let all = dot(&self.residual, &self.residual);
        let (mut choices, mut count) = (0.0, 0);
        while deletions.taken.len() < n.div_ceil(5).min(MOST) {
            let Some((worst, explained)) = deletions.worst() else {
                break;
            };
            let taken = deletions.taken.len() + 1;
            let m = each * taken;
            let left = match self.freedom.checked_sub(self.accepted.len() + m) {
                Some(left) if left >= 2 => left,
                _ => break,
            };
            deletions.take(worst);
            choices += ((n + 1 - taken) as f64 / taken as f64).ln();
            let squares = dot(&deletions.residual, &deletions.residual);
            let variance = self.variance(squares, left);
            let probability = |of: f64, terms: usize| {
                let f = of / terms as f64 / variance;
                FisherSnedecor::new(terms as f64, left as f64).map_or(1.0, |d| d.sf(f))
            };
            if probability(explained, each) * n as f64 > level {
                continue;
            }
            let together = probability((all - squares).max(0.0), m).ln() + choices;
            if together <= level.ln() - taken as f64 * std::f64::consts::LN_2 {
                count = taken;
            }
        }
        let mut named = deletions.taken;
        named.truncate(count);
        self.significant(named, each, level / n.max(1) as f64)
    }

    /// Each beside the others of a list, without those that are not significant there, the least one first.
    fn significant(&self, mut named: Vec<usize>, each: usize, level: f64) -> Vec<(usize, Test)> {
        let beside = |named: &[usize], index: usize| {
            let mut terms = self.clone();
            for &other in named.iter().filter(|o| **o != index) {
                let test = terms.test(&terms.columns_of(other, each))?;
                terms.accept(&test);
            }
            terms.test(&terms.columns_of(index, each))
        };
        loop {
            let tests = named.iter().map(|&i| Some((i, beside(&named, i)?)));
            let Some(tests) = tests.collect::<Option<Vec<_>>>() else {
                return Vec::new();
            };
            let least = tests
                .iter()
                .max_by(|a, b| a.1.p_value.total_cmp(&b.1.p_value));
            match least {
                Some((index, test)) if test.p_value > level => {
                    let index = *index;
                    named.retain(|i| *i != index);
                }
                _ => return tests,
            }
        }
    }

    /// Takes an observation out of the residuals.
    pub(crate) fn leave_out(&mut self, index: usize, each: usize) {
        if let Some(test) = self.test(&self.columns_of(index, each)) {
            self.accept(&test);
        }
    }

    /// An error of each equation of one observation.
    fn columns_of(&self, index: usize, each: usize) -> Vec<Vec<f64>> {
        (0..each)
            .map(|k| {
                let mut column = vec![0.0; self.residual.len()];
                column[index * each + k] = 1.0;
                column
            })
            .collect()
    }
}

impl<'a> Deletions<'a> {
    fn of(terms: &'a AddedTerms<'a>, each: usize) -> Self {
        let mut deletions = Self {
            terms,
            each,
            blocks: Vec::with_capacity(terms.residual.len() * each),
            residual: terms.residual.clone(),
            taken: Vec::new(),
            removed: Vec::new(),
        };
        for row in 0..terms.residual.len() {
            let first = row - row % each;
            for column in first..first + each {
                let block = deletions.projection(row, column);
                deletions.blocks.push(block);
            }
        }
        for q in &terms.accepted {
            deletions.shrink(q);
        }
        deletions
    }

    /// P of the model alone.
    fn projection(&self, row: usize, column: usize) -> f64 {
        let t = self.terms;
        let n = t.residual.len();
        let p = t.gain.len() / n;
        let jacobian = &t.jacobian[row * p..(row + 1) * p];
        let along: f64 = (0..p).map(|c| jacobian[c] * t.gain[c * n + column]).sum();
        f64::from(u8::from(row == column)) - along * t.root[row] / t.root[column]
    }

    /// P_II ← P_II − q_I q_Iᵀ.
    fn shrink(&mut self, q: &[f64]) {
        let each = self.each;
        for (row, block) in self.blocks.chunks_mut(each).enumerate() {
            let first = row - row % each;
            for (b, other) in block.iter_mut().zip(&q[first..first + each]) {
                *b -= q[row] * other;
            }
        }
    }

    /// The observation without which the squares fall most, and by how much.
    fn worst(&self) -> Option<(usize, f64)> {
        let each = self.each;
        let explained = |index: usize| {
            let mut block = self.blocks[index * each * each..(index + 1) * each * each].to_vec();
            cholesky(&mut block, each)?;
            let smallest = (0..each).map(|k| block[k * each + k]);
            // An observation that nothing else checks cannot contradict.
            if smallest.fold(f64::INFINITY, f64::min) < SEPARABLE {
                return None;
            }
            let residual = &self.residual[index * each..(index + 1) * each];
            let mut solved = residual.to_vec();
            solve(&block, &mut solved);
            Some(dot(residual, &solved))
        };
        (0..self.residual.len() / each)
            .filter(|i| !self.taken.contains(i))
            .filter_map(|i| Some((i, explained(i)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn take(&mut self, index: usize) {
        let n = self.residual.len();
        for row in index * self.each..(index + 1) * self.each {
            let mut q: Vec<f64> = (0..n).map(|j| self.projection(j, row)).collect();
            for other in self.terms.accepted.iter().chain(&self.removed) {
                let share = other[row];
                q.iter_mut().zip(other).for_each(|(v, o)| *v -= share * o);
            }
            // A projection: its diagonal is the squared length of its columns.
            let length = q[row].max(f64::MIN_POSITIVE).sqrt();
            q.iter_mut().for_each(|v| *v /= length);
            let share = dot(&q, &self.residual);
            let residual = self.residual.iter_mut().zip(&q);
            residual.for_each(|(r, q)| *r -= share * q);
            self.shrink(&q);
            self.removed.push(q);
        }
        self.taken.push(index);
    }
}
