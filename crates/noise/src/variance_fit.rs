//! Likelihood of squared noise coefficients, none of them negative, and its least point.

/// What is done about a straight line in the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Line {
    /// Its slope is unknown: taken at its best, and the likelihood of what is left (REML).
    Restricted,
    /// Its slope is unknown: taken at its best (ML).
    Best,
    /// It is this.
    At(f64),
}

/// Mean squares of cosine coefficients with what they are expected to be.
#[derive(Clone, Debug)]
pub(crate) struct Likelihood {
    pub(crate) count: Vec<f64>,
    pub(crate) cc: Vec<f64>,
    pub(crate) cd: Vec<f64>,
    pub(crate) dd: Vec<f64>,
    /// Density of a unit square of each term over the bins.
    pub(crate) columns: Vec<Vec<f64>>,
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
    pub(crate) fn terms(&self) -> usize {
        self.columns.len()
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
        s.iter().all(|s| *s > 0.0 && s.is_finite()).then_some(s)
    }

    /// Best slope and its standard uncertainty as if the squares were known.
    pub(crate) fn slope(&self, squares: &[f64]) -> Option<(f64, f64)> {
        let s = self.density(squares)?;
        let (mut a, mut b) = (0.0, 0.0);
        for (i, s) in s.iter().enumerate() {
            let w = self.count[i] / s;
            a += w * self.dd[i];
            b += w * self.cd[i];
        }
        (a > 0.0).then(|| (b / a, a.sqrt().recip()))
    }

    /// −2 ln L = Σ ν (ln S + I/S) with I = mean of (c − R d)²; restricted, + ln Σ ν d²/S.
    pub(crate) fn value(&self, squares: &[f64], line: Line) -> f64 {
        self.density(squares)
            .map_or(f64::INFINITY, |s| self.value_at(&s, line).0)
    }

    /// Value, slope used and Σ ν d²/S.
    fn value_at(&self, s: &[f64], line: Line) -> (f64, f64, f64) {
        let (mut logs, mut cc, mut cd, mut dd) = (0.0, 0.0, 0.0, 0.0);
        for (i, s) in s.iter().enumerate() {
            let w = self.count[i] / s;
            logs += self.count[i] * s.ln();
            cc += w * self.cc[i];
            cd += w * self.cd[i];
            dd += w * self.dd[i];
        }
        let slope = match line {
            Line::At(r) => r,
            _ if dd > 0.0 => cd / dd,
            _ => 0.0,
        };
        let mut value = logs + cc - 2.0 * slope * cd + slope * slope * dd;
        if line == Line::Restricted && dd > 0.0 {
            value += dd.ln();
        }
        (value, slope, dd)
    }

    fn local(&self, squares: &[f64], line: Line) -> Option<Local> {
        let s = self.density(squares)?;
        let (_, slope, dd) = self.value_at(&s, line);
        let p = self.terms();
        let restricted = line == Line::Restricted && dd > 0.0;
        let mut gradient = vec![0.0; p];
        let mut hessian = vec![0.0; p * p];
        let mut first = vec![0.0; p];
        let mut second = vec![0.0; p * p];
        let mut g = vec![0.0; p];
        for (i, s) in s.iter().enumerate() {
            let inverse = 1.0 / s;
            let w = self.count[i] * inverse;
            let seen = self.cc[i] - 2.0 * slope * self.cd[i] + slope * slope * self.dd[i];
            let pull = w * (1.0 - seen * inverse);
            let line_pull = w * inverse * self.dd[i];
            for (g, column) in g.iter_mut().zip(&self.columns) {
                *g = column[i];
            }
            for a in 0..p {
                gradient[a] += pull * g[a];
                for b in 0..=a {
                    hessian[a * p + b] += w * inverse * g[a] * g[b];
                }
            }
            if restricted && line_pull > 0.0 {
                for a in 0..p {
                    first[a] += line_pull * g[a];
                    for b in 0..=a {
                        second[a * p + b] += line_pull * inverse * g[a] * g[b];
                    }
                }
            }
        }
        let plain = hessian.clone();
        if restricted {
            for a in 0..p {
                gradient[a] -= first[a] / dd;
                for b in 0..=a {
                    hessian[a * p + b] +=
                        -2.0 * second[a * p + b] / dd + first[a] * first[b] / (dd * dd);
                }
            }
            // With very few cosines the expectation can lose its sign: then that without the line serves.
            if (0..p).any(|a| hessian[a * p + a] <= 1e-6 * plain[a * p + a]) {
                hessian = plain;
            }
        }
        for a in 0..p {
            for b in 0..a {
                hessian[b * p + a] = hessian[a * p + b];
            }
        }
        Some(Local { gradient, hessian })
    }

    /// Expected Hessian of −2 ln L at these squares, row by row.
    pub(crate) fn information(&self, squares: &[f64], line: Line) -> Option<Vec<f64>> {
        self.local(squares, line).map(|l| l.hessian)
    }

    /// A start below the data everywhere: of each term half of what the lowest octave admits.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.columns
            .iter()
            .map(|g| {
                let (mut smallest, mut cc, mut gg, mut count) = (f64::INFINITY, 0.0, 0.0, 0.0);
                for i in 0..self.count.len() {
                    cc += self.count[i] * self.cc[i];
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
            .collect()
    }

    /// Least −2 ln L over squares ≥ 0, those in `held` as they are, from a start.
    ///
    /// Fisher scoring; each step is the least point of its quadratic within the bounds, halved until it helps.
    pub(crate) fn minimise_from(
        &self,
        start: &[f64],
        held: &[Option<f64>],
        line: Line,
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
        let mut value = self.value(&squares, line);
        if !value.is_finite() {
            return None;
        }
        let free: Vec<usize> = (0..p).filter(|t| held[*t].is_none()).collect();
        if free.is_empty() {
            return Some(Minimum { squares, value });
        }
        for _ in 0..ITERATIONS {
            let Some(local) = self.local(&squares, line) else {
                break;
            };
            let step = bounded_step(&local, &squares, &free);
            let mut share = 1.0;
            let mut gained = 0.0;
            for _ in 0..20 {
                let trial: Vec<f64> = (0..p)
                    .map(|t| (squares[t] + share * step[t]).max(0.0))
                    .collect();
                let found = self.value(&trial, line);
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
        line: Line,
    ) -> Option<Minimum> {
        starts
            .iter()
            .filter_map(|s| self.minimise_from(s, held, line))
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
    let scale: Vec<f64> = (0..q).map(|i| matrix[i * q + i].sqrt().recip()).collect();
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let mut l = vec![0.0; q * q];
    for i in 0..q {
        for j in 0..=i {
            let mut sum = matrix[i * q + j] * scale[i] * scale[j];
            for k in 0..j {
                sum -= l[i * q + k] * l[j * q + k];
            }
            if i == j {
                if sum <= 1e-13 {
                    return None;
                }
                l[i * q + i] = sum.sqrt();
            } else {
                l[i * q + j] = sum / l[j * q + j];
            }
        }
    }
    let mut x: Vec<f64> = (0..q).map(|i| right[i] * scale[i]).collect();
    for i in 0..q {
        for k in 0..i {
            x[i] -= l[i * q + k] * x[k];
        }
        x[i] /= l[i * q + i];
    }
    for i in (0..q).rev() {
        for k in i + 1..q {
            x[i] -= l[k * q + i] * x[k];
        }
        x[i] /= l[i * q + i];
    }
    Some((0..q).map(|i| x[i] * scale[i]).collect())
}
