//! Likelihood of squared noise coefficients, none of them negative, and its least point.

use crate::cosine_spectrum::{CosineSpectrum, pair};
use crate::effects::{Effects, Eliminated, inverse};
use proofmass_uncertainty::adjustment::ScaledRoot;
use std::borrow::Cow;

/// Mean squares of cosine coefficients with what they are expected to be.
#[derive(Clone, Debug)]
pub(crate) struct Likelihood {
    pub(crate) count: Vec<f64>,
    /// Mean products of the record (0) and its known forms (1 …) at [`pair`], each over the bins.
    pub(crate) products: Vec<Vec<f64>>,
    /// How many forms.
    pub(crate) forms: usize,
    /// Density of a unit square of each term over the bins.
    pub(crate) columns: Vec<Vec<f64>>,
    /// What the sum of the terms is divided by: 1 + Σ a w, the w over the bins. The a stand behind the squares and are fitted with them.
    pub(crate) divisors: Vec<Vec<f64>>,
    /// Where the search for the a begins.
    pub(crate) divisor_start: Vec<f64>,
}

/// The squares and −2 ln L there, up to a constant.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub(crate) squares: Vec<f64>,
    pub(crate) value: f64,
}

/// Gradient and expected Hessian (row by row).
struct Local {
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

const ITERATIONS: usize = 80;

/// A decrease of −2 ln L below which the search ends.
const CONVERGED: f64 = 1e-7;

impl Likelihood {
    pub(crate) fn new(spectrum: &CosineSpectrum, columns: Vec<Vec<f64>>) -> Self {
        let forms = spectrum.forms;
        let bins = &spectrum.bins;
        Self {
            count: bins.iter().map(|b| b.count).collect(),
            products: (0..pair(forms + 1, 0))
                .map(|at| bins.iter().map(|b| b.products[at]).collect())
                .collect(),
            forms,
            columns,
            divisors: Vec::new(),
            divisor_start: Vec::new(),
        }
    }

    /// Parameters: squares, then what the divisors are multiplied with.
    pub(crate) fn terms(&self) -> usize {
        self.columns.len() + self.divisors.len()
    }

    /// With its forms in another order, or some of them left out.
    pub(crate) fn with_forms(&self, order: &[usize]) -> Self {
        let old = |a: usize| if a == 0 { 0 } else { 1 + order[a - 1] };
        let mut products = Vec::with_capacity(pair(order.len() + 1, 0));
        for a in 0..=order.len() {
            for b in 0..=a {
                products.push(self.products[pair(old(a), old(b))].clone());
            }
        }
        Self {
            count: self.count.clone(),
            products,
            forms: order.len(),
            columns: self.columns.clone(),
            divisors: self.divisors.clone(),
            divisor_start: self.divisor_start.clone(),
        }
    }

    /// With a form ahead of all others.
    pub(crate) fn led_by(&self, form: usize) -> Self {
        let mut order: Vec<usize> = (0..self.forms).filter(|f| *f != form).collect();
        order.insert(0, form);
        self.with_forms(&order)
    }

    /// With forms a and b replaced by a cos φ + b sin φ and b cos φ − a sin φ.
    pub(crate) fn turned(&self, a: usize, b: usize, phase: f64) -> Self {
        let (sin, cos) = phase.sin_cos();
        let (a, b) = (a + 1, b + 1);
        let mut turned = self.clone();
        for i in 0..self.count.len() {
            let at = |j: usize, l: usize| self.products[pair(j, l)][i];
            for j in (0..=self.forms).filter(|j| *j != a && *j != b) {
                turned.products[pair(a, j)][i] = cos * at(a, j) + sin * at(b, j);
                turned.products[pair(b, j)][i] = cos * at(b, j) - sin * at(a, j);
            }
            let (aa, ab, bb) = (at(a, a), at(a, b), at(b, b));
            turned.products[pair(a, a)][i] = cos * cos * aa + 2.0 * sin * cos * ab + sin * sin * bb;
            turned.products[pair(b, b)][i] = sin * sin * aa - 2.0 * sin * cos * ab + cos * cos * bb;
            turned.products[pair(a, b)][i] = (cos * cos - sin * sin) * ab + sin * cos * (bb - aa);
        }
        turned
    }

    /// Without a form whose size is known.
    pub(crate) fn given(&self, form: usize, size: f64) -> Self {
        let mut freed = self.clone();
        for i in 0..self.count.len() {
            let with = |a: usize| self.products[pair(a, 1 + form)][i];
            freed.products[0][i] += size * (size * with(1 + form) - 2.0 * with(0));
            for a in 1..=self.forms {
                freed.products[pair(a, 0)][i] -= size * with(a);
            }
        }
        let order: Vec<usize> = (0..self.forms).filter(|f| *f != form).collect();
        freed.with_forms(&order)
    }

    /// Density over the bins; `None` when it is not positive everywhere.
    pub(crate) fn density(&self, squares: &[f64]) -> Option<Vec<f64>> {
        let mut s = vec![0.0; self.count.len()];
        for (column, v) in self.columns.iter().zip(squares) {
            if *v > 0.0 {
                for (s, g) in s.iter_mut().zip(column) {
                    *s += v * g;
                }
            }
        }
        if !self.divisors.is_empty() {
            for (s, p) in s.iter_mut().zip(self.divisor(squares)) {
                *s /= p;
            }
        }
        s.iter().all(|s| *s > 0.0 && s.is_finite()).then_some(s)
    }

    /// 1 + Σ a w over the bins.
    fn divisor(&self, squares: &[f64]) -> Vec<f64> {
        let mut divisor = vec![1.0; self.count.len()];
        for (w, a) in self.divisors.iter().zip(&squares[self.columns.len()..]) {
            for (p, w) in divisor.iter_mut().zip(w) {
                *p += a * w;
            }
        }
        divisor
    }

    /// Derivatives of the density by every parameter, over the bins.
    fn slopes(&self, squares: &[f64], density: &[f64]) -> Cow<'_, [Vec<f64>]> {
        if self.divisors.is_empty() {
            return Cow::Borrowed(&self.columns);
        }
        let divisor = self.divisor(squares);
        let by_squares = self
            .columns
            .iter()
            .map(|g| g.iter().zip(&divisor).map(|(g, p)| g / p).collect());
        let by_divisors = self.divisors.iter().map(|w| {
            let each = w.iter().zip(density).zip(&divisor);
            each.map(|((w, s), p)| -w * s / p).collect()
        });
        Cow::Owned(by_squares.chain(by_divisors).collect())
    }

    /// Sums over the bins, each weighted with its count over the density, and the forms taken out of them.
    pub(crate) fn eliminated(&self, density: &[f64], effects: Effects) -> Eliminated {
        let weights: Vec<f64> = self.count.iter().zip(density).map(|(n, s)| n / s).collect();
        let sums = self
            .products
            .iter()
            .map(|row| row.iter().zip(&weights).map(|(p, w)| p * w).sum())
            .collect();
        Eliminated::new(sums, self.forms, effects)
    }

    /// Best size of the first form and its standard uncertainty as if the squares were known.
    pub(crate) fn first(&self, squares: &[f64]) -> Option<(f64, f64)> {
        let s = self.density(squares)?;
        self.eliminated(&s, Effects::Best(1)).first()
    }

    /// Σ ν x_a x_b/S of the forms themselves, packed as [`pair`] without the record.
    pub(crate) fn information_of_forms(&self, density: &[f64]) -> Vec<f64> {
        let mut packed = Vec::new();
        for a in 1..=self.forms {
            for b in 1..=a {
                let row = &self.products[pair(a, b)];
                let terms = row.iter().zip(&self.count).zip(density);
                packed.push(terms.map(|((p, n), s)| n * p / s).sum());
            }
        }
        packed
    }

    /// Mean squares over the bins of what is left without the forms at their best.
    pub(crate) fn freed(&self, density: &[f64]) -> Vec<f64> {
        self.freed_of(&self.eliminated(density, Effects::Restricted).sizes())
    }

    fn freed_of(&self, sizes: &[f64]) -> Vec<f64> {
        let mut seen = self.products[0].clone();
        for (j, size) in sizes.iter().enumerate() {
            let mut add = |row: &[f64], factor: f64| {
                for (s, p) in seen.iter_mut().zip(row) {
                    *s += factor * p;
                }
            };
            add(&self.products[pair(j + 1, 0)], -2.0 * size);
            add(&self.products[pair(j + 1, j + 1)], size * size);
            for (l, other) in sizes[..j].iter().enumerate() {
                add(&self.products[pair(j + 1, l + 1)], 2.0 * size * other);
            }
        }
        // A difference of large numbers may come out below zero.
        seen.iter_mut().for_each(|s| *s = s.max(0.0));
        seen
    }

    /// −2 ln L = Σ ν (ln S + I/S), I the mean square without the forms; plus ln det Σ ν x xᵀ/S of those integrated out.
    pub(crate) fn value(&self, squares: &[f64], effects: Effects) -> f64 {
        let Some(s) = self.density(squares) else {
            return f64::INFINITY;
        };
        let logs: f64 = self.count.iter().zip(&s).map(|(n, s)| n * s.ln()).sum();
        let eliminated = self.eliminated(&s, effects);
        logs + eliminated.left() + eliminated.determinant
    }

    fn local(&self, squares: &[f64], effects: Effects) -> Option<Local> {
        let s = self.density(squares)?;
        let p = self.terms();
        let seen = self.freed_of(&self.eliminated(&s, effects).sizes());
        let slopes = self.slopes(squares, &s);
        let mut gradient = vec![0.0; p];
        let mut hessian = vec![0.0; p * p];
        let mut g = vec![0.0; p];
        for (i, s) in s.iter().enumerate() {
            let inverse = 1.0 / s;
            let w = self.count[i] * inverse;
            let pull = w * (1.0 - seen[i] * inverse);
            for (g, column) in g.iter_mut().zip(slopes.iter()) {
                *g = column[i];
            }
            for a in 0..p {
                gradient[a] += pull * g[a];
                for b in 0..=a {
                    hessian[a * p + b] += w * inverse * g[a] * g[b];
                }
            }
        }
        let free = match effects {
            Effects::Restricted => 0,
            Effects::Best(n) => n.min(self.forms),
            Effects::FirstAt(_) => 1,
        };
        if free < self.forms {
            self.restrict(&s, &slopes, free, &mut gradient, &mut hessian);
        }
        for a in 0..p {
            for b in 0..a {
                hessian[b * p + a] = hessian[a * p + b];
            }
        }
        Some(Local { gradient, hessian })
    }

    /// Adds what ln det A of the forms from `first` on brings, A = Σ ν x xᵀ/S, to the gradient and the expected Hessian.
    fn restrict(
        &self,
        s: &[f64],
        by: &[Vec<f64>],
        first: usize,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        let p = self.terms();
        let q = self.forms - first;
        let row = |j: usize, l: usize| &self.products[pair(1 + first + j, 1 + first + l)];
        let mut matrix = vec![0.0; q * q];
        // ∂A/∂v_a, one after the other.
        let mut slopes = vec![0.0; p * q * q];
        for j in 0..q {
            for l in 0..=j {
                let x = row(j, l);
                for (i, s) in s.iter().enumerate() {
                    let w = self.count[i] / s * x[i];
                    matrix[j * q + l] += w;
                    for (a, column) in by.iter().enumerate() {
                        slopes[(a * q + j) * q + l] += w / s * column[i];
                    }
                }
                matrix[l * q + j] = matrix[j * q + l];
                for a in 0..p {
                    slopes[(a * q + l) * q + j] = slopes[(a * q + j) * q + l];
                }
            }
        }
        // Forms that are sums of others: the likelihood without the restriction serves.
        let Some(inverse) = inverse(&matrix, q) else {
            return;
        };
        let times = |m: &[f64]| -> Vec<f64> {
            (0..q * q)
                .map(|k| {
                    (0..q)
                        .map(|l| inverse[k / q * q + l] * m[l * q + k % q])
                        .sum()
                })
                .collect()
        };
        let products: Vec<Vec<f64>> = slopes.chunks(q * q).map(times).collect();
        let mut second = vec![0.0; p * p];
        for (i, s) in s.iter().enumerate() {
            let mut h = 0.0;
            for j in 0..q {
                for l in 0..q {
                    h += inverse[j * q + l] * row(j, l)[i];
                }
            }
            let w = self.count[i] * h / (s * s * s);
            for a in 0..p {
                for b in 0..=a {
                    second[a * p + b] += w * by[a][i] * by[b][i];
                }
            }
        }
        let plain = hessian.to_vec();
        for a in 0..p {
            gradient[a] -= (0..q).map(|j| products[a][j * q + j]).sum::<f64>();
            for b in 0..=a {
                let both: f64 = (0..q * q)
                    .map(|k| products[a][k] * products[b][k % q * q + k / q])
                    .sum();
                hessian[a * p + b] += both - 2.0 * second[a * p + b];
            }
        }
        // With very few cosines the expectation can lose its sign: then that without the forms serves.
        if (0..p).any(|a| hessian[a * p + a] <= 1e-6 * plain[a * p + a]) {
            hessian.copy_from_slice(&plain);
        }
    }

    /// Expected Hessian of −2 ln L at these squares, row by row.
    pub(crate) fn information(&self, squares: &[f64], effects: Effects) -> Option<Vec<f64>> {
        self.local(squares, effects).map(|l| l.hessian)
    }

    /// A start below the data everywhere: of each term half of what the lowest octave admits.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.columns
            .iter()
            .map(|g| {
                let (mut smallest, mut cc, mut gg, mut count) = (f64::INFINITY, 0.0, 0.0, 0.0);
                for i in 0..self.count.len() {
                    cc += self.count[i] * self.products[0][i];
                    gg += self.count[i] * g[i];
                    count += self.count[i];
                    if count >= 12.0 {
                        if gg > 0.0 {
                            smallest = f64::min(smallest, cc / gg);
                        }
                        (cc, gg, count) = (0.0, 0.0, 0.0);
                    }
                }
                if smallest.is_finite() {
                    0.5 * smallest
                } else if gg > 0.0 {
                    0.5 * cc / gg
                } else {
                    0.0
                }
            })
            .chain(self.divisor_start.iter().copied())
            .collect()
    }

    /// Least −2 ln L over squares ≥ 0, those in `held` as they are, from a start.
    ///
    /// Fisher scoring; each step is the least point of its quadratic within the bounds, halved until it helps.
    pub(crate) fn minimise_from(
        &self,
        start: &[f64],
        held: &[Option<f64>],
        effects: Effects,
    ) -> Option<Minimum> {
        let p = self.terms();
        let mut squares: Vec<f64> = (0..p).map(|t| held[t].unwrap_or(start[t])).collect();
        if self.density(&squares).is_none() {
            // Everything at zero: the crude start stands in.
            let crude = self.start();
            for t in 0..p {
                squares[t] = held[t].unwrap_or(crude[t]);
            }
        }
        let mut value = self.value(&squares, effects);
        if !value.is_finite() {
            return None;
        }
        let free: Vec<usize> = (0..p).filter(|t| held[*t].is_none()).collect();
        if free.is_empty() {
            return Some(Minimum { squares, value });
        }
        for _ in 0..ITERATIONS {
            let Some(local) = self.local(&squares, effects) else {
                break;
            };
            let step = bounded_step(&local, &squares, &free);
            let mut share = 1.0;
            let mut gained = 0.0;
            for _ in 0..20 {
                let trial: Vec<f64> = (0..p)
                    .map(|t| (squares[t] + share * step[t]).max(0.0))
                    .collect();
                let found = self.value(&trial, effects);
                if found < value {
                    gained = value - found;
                    value = found;
                    squares = trial;
                    break;
                }
                share *= 0.5;
            }
            if gained < CONVERGED {
                break;
            }
        }
        Some(Minimum { squares, value })
    }

    /// The least of several starts.
    pub(crate) fn minimise(
        &self,
        starts: &[&[f64]],
        held: &[Option<f64>],
        effects: Effects,
    ) -> Option<Minimum> {
        starts
            .iter()
            .filter_map(|s| self.minimise_from(s, held, effects))
            .min_by(|a, b| a.value.total_cmp(&b.value))
    }
}

/// Least point of g·δ + δᵀHδ/2 with squares + δ ≥ 0, over every choice of terms at the bound.
fn bounded_step(local: &Local, squares: &[f64], free: &[usize]) -> Vec<f64> {
    let p = squares.len();
    let f = free.len();
    let mut best = vec![0.0; p];
    let mut least = 0.0;
    for bound in 0..1_usize << f {
        let inside: Vec<usize> = (0..f)
            .filter(|i| bound >> i & 1 == 0)
            .map(|i| free[i])
            .collect();
        let mut step = vec![0.0; p];
        for i in (0..f).filter(|i| bound >> i & 1 == 1) {
            step[free[i]] = -squares[free[i]];
        }
        let q = inside.len();
        let right: Vec<f64> = inside
            .iter()
            .map(|&a| {
                -local.gradient[a]
                    - (0..p)
                        .map(|b| local.hessian[a * p + b] * step[b])
                        .sum::<f64>()
            })
            .collect();
        let matrix: Vec<f64> = (0..q * q)
            .map(|k| local.hessian[inside[k / q] * p + inside[k % q]])
            .collect();
        let Some(solved) = solve(&matrix, &right) else {
            continue;
        };
        for (&a, d) in inside.iter().zip(&solved) {
            step[a] = *d;
        }
        if (0..p).any(|a| squares[a] + step[a] < -1e-12 * squares[a].abs()) {
            continue;
        }
        let quadratic: f64 = (0..p)
            .map(|a| {
                let hessian: f64 = (0..p).map(|b| local.hessian[a * p + b] * step[b]).sum();
                step[a] * (local.gradient[a] + 0.5 * hessian)
            })
            .sum();
        if quadratic < least {
            least = quadratic;
            best = step;
        }
    }
    best
}

/// Solution of a symmetric positive definite system of a few unknowns, scaled to a unit diagonal; `None` when it is none.
pub(crate) fn solve(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let q = right.len();
    ScaledRoot::new(q, |i, j| matrix[i * q + j]).map(|root| root.solve(right))
}
