//! Forms that are known but for their size beside noise: taken at their best, or integrated out (restricted likelihood).

use crate::cosine_spectrum::pair;
use proofmass_uncertainty::adjustment::ScaledRoot;

/// What is done about the known forms of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effects {
    /// Their sizes are unknown: at their best, and the likelihood of what is left (REML).
    Restricted,
    /// The same for all but the first so many, which are at their best (ML).
    Best(usize),
    /// The same for all but the first, which has this size.
    FirstAt(f64),
}

/// Below this share of its own square a form is a sum of others.
const DEPENDENT: f64 = 1e-10;

/// Weighted sums of products of the record and its known forms, the forms taken out one by one from the last.
///
/// Row j keeps what it was when form j was taken out.
#[derive(Clone, Debug)]
pub(crate) struct Eliminated {
    sums: Vec<f64>,
    /// How many forms.
    forms: usize,
    /// Forms that have a size of their own.
    independent: Vec<bool>,
    given: Option<f64>,
    /// ln of the determinant of the forms that are integrated out.
    pub(crate) determinant: f64,
}

impl Eliminated {
    /// From the packed sums of x_a x_b, x_0 the record.
    pub(crate) fn new(mut sums: Vec<f64>, forms: usize, effects: Effects) -> Self {
        let given = match effects {
            Effects::FirstAt(size) if forms > 0 => Some(size),
            _ => None,
        };
        if let Some(size) = given {
            sums[0] += size * (size * sums[pair(1, 1)] - 2.0 * sums[pair(1, 0)]);
            for a in 1..=forms {
                let own = sums[pair(a, 1)];
                sums[pair(a, 0)] -= size * own;
            }
        }
        let restricted = match effects {
            Effects::Restricted => 1,
            Effects::Best(n) => 1 + n.min(forms),
            Effects::FirstAt(_) => 2,
        };
        let whole: Vec<f64> = (1..=forms).map(|j| sums[pair(j, j)]).collect();
        let mut independent = vec![true; forms];
        let mut determinant = 0.0;
        for j in (1..=forms).rev() {
            if j == 1 && given.is_some() {
                continue;
            }
            let pivot = sums[pair(j, j)];
            if !(pivot > DEPENDENT * whole[j - 1]) {
                independent[j - 1] = false;
                continue;
            }
            if j >= restricted {
                determinant += pivot.ln();
            }
            for a in 0..j {
                let share = sums[pair(j, a)] / pivot;
                for b in 0..=a {
                    sums[pair(a, b)] -= share * sums[pair(j, b)];
                }
            }
        }
        Self {
            sums,
            forms,
            independent,
            given,
            determinant,
        }
    }

    /// Weighted square of what is left of the record.
    pub(crate) fn left(&self) -> f64 {
        self.sums[0]
    }

    /// Size of the first form and its standard uncertainty, all others at their best.
    pub(crate) fn first(&self) -> Option<(f64, f64)> {
        let square = *self.sums.get(pair(1, 1))?;
        (self.forms > 0 && self.independent[0] && square > 0.0)
            .then(|| (self.sums[pair(1, 0)] / square, square.sqrt().recip()))
    }

    /// Sizes of all forms.
    pub(crate) fn sizes(&self) -> Vec<f64> {
        let mut sizes = vec![0.0; self.forms];
        for j in 1..=self.forms {
            if j == 1
                && let Some(size) = self.given
            {
                sizes[0] = size;
                continue;
            }
            if !self.independent[j - 1] {
                continue;
            }
            // Where the first has a size given, the products with the record are already without it.
            let from = if self.given.is_some() { 2 } else { 1 };
            let known: f64 = (from..j)
                .map(|l| self.sums[pair(j, l)] * sizes[l - 1])
                .sum();
            sizes[j - 1] = (self.sums[pair(j, 0)] - known) / self.sums[pair(j, j)];
        }
        sizes
    }
}

/// Inverse of a symmetric positive definite matrix of few rows, row by row; `None` when it is none.
pub(crate) fn inverse(matrix: &[f64], q: usize) -> Option<Vec<f64>> {
    let root = ScaledRoot::new(q, |i, j| matrix[i * q + j])?;
    let unit = |i: usize| -> Vec<f64> { (0..q).map(|j| f64::from(u8::from(i == j))).collect() };
    Some((0..q).flat_map(|i| root.solve(&unit(i))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three forms over five places, against the normal equations solved as a whole.
    #[test]
    fn known_elimination_of_three_forms() {
        let x: [[f64; 5]; 4] = [
            [1.0, 2.5, 2.0, 4.0, 7.0],
            [1.0, 1.0, 1.0, 1.0, 1.0],
            [0.0, 1.0, 2.0, 3.0, 4.0],
            [0.0, 1.0, -1.0, 2.0, 0.5],
        ];
        let dot = |a: &[f64; 5], b: &[f64; 5]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut sums = vec![0.0; pair(4, 0)];
        for a in 0..4 {
            for b in 0..=a {
                sums[pair(a, b)] = dot(&x[a], &x[b]);
            }
        }
        let gram: Vec<f64> = (0..9).map(|k| dot(&x[1 + k / 3], &x[1 + k % 3])).collect();
        let right: Vec<f64> = (1..4).map(|a| dot(&x[a], &x[0])).collect();
        let solved = crate::variance_fit::solve(&gram, &right).unwrap();
        let all = Eliminated::new(sums.clone(), 3, Effects::Restricted);
        for (a, b) in all.sizes().iter().zip(&solved) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        let left: f64 = (0..5)
            .map(|i| (x[0][i] - (0..3).map(|j| solved[j] * x[1 + j][i]).sum::<f64>()).powi(2))
            .sum();
        assert!((all.left() - left).abs() < 1e-12);
        let u = inverse(&gram, 3).unwrap()[0].sqrt();
        let (size, of_size) = all.first().unwrap();
        assert!((size - solved[0]).abs() < 1e-12 && (of_size - u).abs() < 1e-12);
        // With the first at its best value nothing changes but the determinant.
        let at = Eliminated::new(sums, 3, Effects::FirstAt(solved[0]));
        assert!((at.left() - left).abs() < 1e-12);
        for (a, b) in at.sizes().iter().zip(&solved) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        assert!(at.determinant < all.determinant);
    }
}
