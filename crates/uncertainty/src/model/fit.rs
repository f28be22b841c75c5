//! Least squares of a model file: polynomials, straight lines with errors in both variables, and curves.

use super::curve::Curve;
use super::entries::{FitEntry, FitScatter, FitWeights};
use crate::findings;
use crate::{Covariance, Finding, LeastSquares, Model, NormalEquations, Number, Solved};

/// A polynomial or a curve through points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fit {
    pub(crate) entry: FitEntry,
    /// Results that are the abscissae and the ordinates.
    pub(crate) x: Vec<u32>,
    pub(crate) y: Vec<u32>,
    /// One less than there are parameters.
    pub(crate) degree: usize,
    pub(crate) weighing: Weighing,
    /// What is fitted instead of a polynomial.
    pub(crate) curve: Option<Curve>,
    /// Middle and half-width of the abscissae at the estimates: the powers are taken of (x − middle)/half.
    middle: f64,
    half: f64,
}

/// How residuals are made comparable.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Weighing {
    Equal,
    /// L⁻¹ with L Lᵀ the covariance of the ordinates: its diagonal where nothing else is there, else lower triangular by
    /// rows.
    Ordinates(Vec<f64>),
    /// Errors in variables, and where the search begins.
    Both(BothVariables, Vec<f64>),
}

/// Covariances among the abscissae, between ordinates and abscissae, among the ordinates: n × n, or of each point by itself where no
/// point is correlated with another.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BothVariables {
    n: usize,
    xx: Vec<f64>,
    yx: Vec<f64>,
    yy: Vec<f64>,
    /// No point is correlated with another.
    separate: bool,
}

impl Fit {
    pub fn new(entry: &FitEntry, x: Vec<u32>, y: Vec<u32>, degree: usize) -> Self {
        Self {
            entry: entry.clone(),
            x,
            y,
            degree,
            weighing: Weighing::Equal,
            curve: None,
            middle: 0.0,
            half: 1.0,
        }
    }

    /// The parameters.
    pub fn evaluate<T: Number>(&self, before: &[T], parameters: &mut [T]) {
        if let Some(curve) = &self.curve {
            return curve.evaluate(before, parameters);
        }
        let pick =
            |places: &[u32]| -> Vec<T> { places.iter().map(|&k| before[k as usize]).collect() };
        let (x, y) = (pick(&self.x), pick(&self.y));
        match &self.weighing {
            Weighing::Equal => self.polynomial(&x, y, None, parameters),
            Weighing::Ordinates(rows) => self.polynomial(&x, y, Some(rows), parameters),
            Weighing::Both(line, start) => {
                let all: Vec<T> = x.into_iter().chain(y).collect();
                let plain: Vec<f64> = all.iter().map(|v| v.value()).collect();
                let solved = match line.york(&plain, start[1]) {
                    Some(found) => Solved::at(NormalEquations(line), found.to_vec()),
                    None => Solved::new(NormalEquations(line), start.clone()),
                };
                solved.evaluate(&all, parameters);
            }
        }
    }

    /// Weighted least squares by orthogonal columns, exactly as differentiable as the points are.
    fn polynomial<T: Number>(
        &self,
        x: &[T],
        y: Vec<T>,
        rows: Option<&Vec<f64>>,
        parameters: &mut [T],
    ) {
        let p = self.degree + 1;
        let half = T::from(1.0 / self.half);
        let t: Vec<T> = x
            .iter()
            .map(|&x| (x - T::from(self.middle)) * half)
            .collect();
        let mut z = whitened(rows, y);
        let mut power = vec![T::from(1.0); t.len()];
        let mut columns: Vec<Vec<T>> = Vec::new();
        // R of the columns, and Qᵀz.
        let mut upper = vec![T::from(0.0); p * p];
        let mut right = Vec::new();
        for j in 0..p {
            let mut column = whitened(rows, power.clone());
            for (i, known) in columns.iter().enumerate() {
                let r = dot(known, &column);
                subtract(&mut column, r, known);
                upper[i * p + j] = r;
            }
            let size = dot(&column, &column).sqrt();
            upper[j * p + j] = size;
            column.iter_mut().for_each(|c| *c = *c / size);
            let share = dot(&column, &z);
            subtract(&mut z, share, &column);
            right.push(share);
            columns.push(column);
            for (power, t) in power.iter_mut().zip(&t) {
                *power = *power * *t;
            }
        }
        for i in (0..p).rev() {
            for j in i + 1..p {
                right[i] = right[i] - upper[i * p + j] * right[j];
            }
            right[i] = right[i] / upper[i * p + i];
        }
        // From powers of (x − m)/h to powers of x, by Horner's rule on polynomials.
        parameters.fill(T::from(0.0));
        for &q in right.iter().rev() {
            for k in (0..p).rev() {
                let lower = if k > 0 {
                    parameters[k - 1]
                } else {
                    T::from(0.0)
                };
                parameters[k] = (lower - T::from(self.middle) * parameters[k]) * half;
            }
            parameters[0] = parameters[0] + q;
        }
    }

    /// Where the points lie, and how they are weighed: `covariance` is that of the abscissae, then the ordinates.
    ///
    /// What is wrong with the points or their covariance, in words.
    pub fn prepare(
        &mut self,
        before: &[f64],
        covariance: Option<&Covariance>,
    ) -> Result<(), String> {
        if let Some(curve) = &mut self.curve {
            let both = self.entry.weights == FitWeights::Both;
            let scatter = self.entry.scatter == FitScatter::Residuals;
            return curve.prepare(before, covariance, both, scatter);
        }
        let n = self.x.len();
        let x: Vec<f64> = self.x.iter().map(|&k| before[k as usize]).collect();
        let (low, high) = x
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
                (l.min(x), h.max(x))
            });
        if !(high - low).is_finite() {
            return Err("the points are not finite numbers at the estimates".to_owned());
        }
        let mut distinct = x.clone();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        if distinct.len() <= self.degree {
            return Err(format!(
                "{} parameters need as many different abscissae; there are {}",
                self.degree + 1,
                distinct.len()
            ));
        }
        self.middle = 0.5 * (low + high);
        self.half = if high > low { 0.5 * (high - low) } else { 1.0 };
        let Some(covariance) = covariance else {
            return Ok(());
        };
        let part = |first: usize, second: usize| -> Vec<f64> {
            (0..n * n)
                .map(|k| covariance[(first + k / n, second + k % n)])
                .collect()
        };
        let yy = part(n, n);
        let indefinite = "the covariance of the points is not positive definite: each point needs an uncertainty of its own, or \
             weights = \"equal\"";
        if self.entry.weights == FitWeights::Y {
            let alone = (0..n * n).all(|k| k / n == k % n || yy[k] == 0.0);
            self.weighing = Weighing::Ordinates(if alone {
                let own = (0..n).map(|i| 1.0 / yy[i * n + i].sqrt());
                own.map(|w| w.is_finite().then_some(w))
                    .collect::<Option<_>>()
                    .ok_or(indefinite)?
            } else {
                inverse_root(&yy, n).ok_or(indefinite)?
            });
            return Ok(());
        }
        let (xx, yx) = (part(0, 0), part(n, 0));
        let off = |c: &[f64]| (0..n * n).all(|k| k / n == k % n || c[k] == 0.0);
        let separate = off(&xx) && off(&yx) && off(&yy);
        let kept = |c: Vec<f64>| match separate {
            true => (0..n).map(|i| c[i * n + i]).collect(),
            false => c,
        };
        let (xx, yx, yy) = (kept(xx), kept(yx), kept(yy));
        let line = BothVariables {
            n,
            xx,
            yx,
            yy,
            separate,
        };
        // The plain line is near enough to start from.
        let mut start = vec![0.0; 2];
        let y: Vec<f64> = self.y.iter().map(|&k| before[k as usize]).collect();
        self.polynomial(&x, y.clone(), None, &mut start);
        if line.inverse_root(start[1]).is_none() {
            return Err(indefinite.to_owned());
        }
        self.weighing = Weighing::Both(line, start);
        let mut found = vec![0.0; 2];
        self.evaluate(before, &mut found);
        if found.iter().any(|p| !p.is_finite()) {
            return Err(
                "the line with errors in both variables was not found from the plain one"
                    .to_owned(),
            );
        }
        if let Weighing::Both(_, start) = &mut self.weighing {
            *start = found;
        }
        Ok(())
    }

    /// Residuals of the points, not weighed where the fit is not.
    fn residuals(&self, before: &[f64], parameters: &[f64]) -> Vec<f64> {
        if let Some(curve) = &self.curve {
            return curve.residuals_of(before, parameters);
        }
        let x = self.x.iter().map(|&k| before[k as usize]);
        x.zip(&self.y)
            .map(|(x, &y)| {
                before[y as usize] - parameters.iter().rev().fold(0.0, |sum, p| sum * x + p)
            })
            .collect()
    }

    /// Weighted sum of the squared residuals, and its degrees of freedom.
    pub fn chi_squared(&self, before: &[f64], parameters: &[f64]) -> (f64, usize) {
        let dof = self.x.len() - parameters.len();
        if let Some(curve) = &self.curve {
            return (curve.sum_of_squares(before, parameters), dof);
        }
        let residuals = self.residuals(before, parameters);
        let whitened = match &self.weighing {
            Weighing::Equal => residuals,
            Weighing::Ordinates(rows) => whitened(Some(rows), residuals),
            Weighing::Both(line, _) => {
                whitened(line.inverse_root(parameters[1]).as_ref(), residuals)
            }
        };
        (whitened.iter().map(|r| r * r).sum(), dof)
    }

    /// Standard deviation of the residuals; what rounding leaves of a perfect fit is none.
    pub fn scatter(&self, before: &[f64], parameters: &[f64]) -> f64 {
        let (sum, dof) = self.chi_squared(before, parameters);
        let s = (sum / dof as f64).sqrt();
        let y = self.y.iter().map(|&k| before[k as usize].abs());
        if s <= 1e-13 * y.fold(0.0, f64::max) {
            0.0
        } else {
            s
        }
    }

    /// Operations of one trial, roughly.
    pub fn cost(&self) -> f64 {
        if let Some(curve) = &self.curve {
            return curve.cost();
        }
        let n = self.x.len() as f64;
        match &self.weighing {
            Weighing::Both(line, _) if line.separate => 2000.0 * n,
            Weighing::Both(..) => 200.0 * n * n * n,
            Weighing::Ordinates(rows) => rows.len() as f64 * (self.degree + 2) as f64,
            Weighing::Equal => n * (self.degree + 2) as f64,
        }
    }

    /// Residuals that are larger than the uncertainties of the points.
    ///
    /// χ² exceeds its quantile of 99.9 %: one healthy fit in a thousand. With equal weights the sum of squares is held against the sum
    /// of the variances of the points (`u`: abscissae, then ordinates), with Satterthwaite's degrees of freedom: fewer false alarms.
    pub fn doubt(&self, before: &[f64], parameters: &[f64], u: Option<&[f64]>) -> Option<Finding> {
        let (chi, dof) = self.chi_squared(before, parameters);
        if dof == 0 {
            return None;
        }
        let (ratio, nu) = if self.entry.weights == FitWeights::Equal {
            let variances = self.variances(before, parameters, u?);
            let (sum, squares) = variances
                .iter()
                .fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
            let rounding = self.scatter(before, parameters) == 0.0;
            match (sum > 0.0, rounding) {
                (true, _) => (chi / sum, sum * sum / squares),
                (false, true) => return None,
                (false, false) => (f64::INFINITY, dof as f64),
            }
        } else {
            (chi / dof as f64, dof as f64)
        };
        let limit = crate::chi_squared_quantile(0.999, nu) / nu;
        (ratio > limit).then(|| {
            let told = match ratio.is_finite() {
                true => crate::scientific(ratio, 2),
                false => "∞ (the points have no uncertainty)".to_owned(),
            };
            let nu = nu.round() as usize;
            let limit = crate::scientific(limit, 2);
            findings::residuals_exceed_uncertainty(&self.entry.name, &told, nu, &limit)
        })
    }

    /// Variance of each residual by its own point: an abscissa counts by the slope there.
    fn variances(&self, before: &[f64], parameters: &[f64], u: &[f64]) -> Vec<f64> {
        let (ux, uy) = u.split_at(self.x.len());
        let mut moved = before.to_vec();
        for (&k, u) in self.x.iter().zip(ux) {
            moved[k as usize] += u;
        }
        let (here, there) = (
            self.residuals(before, parameters),
            self.residuals(&moved, parameters),
        );
        let slopes = there.iter().zip(&here).map(|(b, a)| b - a);
        slopes
            .zip(uy)
            .map(|(by_x, uy)| by_x * by_x + uy * uy)
            .collect()
    }
}

impl BothVariables {
    /// Of the residuals y − a − b x, by rows.
    fn covariance<T: Number>(&self, b: T) -> Vec<T> {
        let n = self.n;
        (0..n * n)
            .map(|k| {
                let turned = (k % n) * n + k / n;
                T::from(self.yy[k]) - b * T::from(self.yx[k] + self.yx[turned])
                    + b * b * T::from(self.xx[k])
            })
            .collect()
    }
}

/// Steps of York's iteration at most.
const STEPS: usize = 100;

impl BothVariables {
    /// L⁻¹ with L Lᵀ the covariance of the residuals at this slope; its diagonal alone where the points are separate.
    fn inverse_root(&self, b: f64) -> Option<Vec<f64>> {
        if !self.separate {
            return inverse_root(&self.covariance(b), self.n);
        }
        let own = |i: usize| {
            let variance = self.yy[i] - 2.0 * b * self.yx[i] + b * b * self.xx[i];
            let w = 1.0 / variance.sqrt();
            w.is_finite().then_some(w)
        };
        (0..self.n).map(own).collect()
    }

    /// Intercept and slope through separate points, without derivatives; `None` where the iteration does not settle.
    ///
    /// **Source** `[York2004]`.
    fn york(&self, points: &[f64], start: f64) -> Option<[f64; 2]> {
        if !self.separate {
            return None;
        }
        let (x, y) = points.split_at(self.n);
        let mut b = start;
        let mut previous = f64::INFINITY;
        for _ in 0..STEPS {
            let weight = |i: usize| 1.0 / (self.yy[i] - 2.0 * b * self.yx[i] + b * b * self.xx[i]);
            let (mut sum, mut sx, mut sy) = (0.0, 0.0, 0.0);
            for i in 0..self.n {
                let w = weight(i);
                (sum, sx, sy) = (sum + w, sx + w * x[i], sy + w * y[i]);
            }
            let (mx, my) = (sx / sum, sy / sum);
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..self.n {
                let w = weight(i);
                let (u, v) = (x[i] - mx, y[i] - my);
                let beta = w * (u * self.yy[i] + b * v * self.xx[i] - (b * u + v) * self.yx[i]);
                (above, below) = (above + w * beta * v, below + w * beta * u);
            }
            let next = above / below;
            let step = (next - b).abs();
            if !step.is_finite() {
                return None;
            }
            b = next;
            // Rounding noise no longer shrinks.
            if step <= 1e-15 * b.abs() || (step <= 1e-11 * b.abs() && step >= 0.5 * previous) {
                return Some([my - b * mx, b]);
            }
            previous = step;
        }
        None
    }
}

impl LeastSquares for BothVariables {
    fn outputs(&self) -> Vec<(String, String)> {
        ["intercept", "slope"]
            .map(|name| (name.to_owned(), String::new()))
            .to_vec()
    }

    fn residuals(&self) -> usize {
        self.n
    }

    /// L⁻¹(y − a − b x) with L Lᵀ the covariance of that at b: least over the unknown true points.
    fn residual<T: Number>(&self, parameters: &[T], points: &[T], r: &mut [T]) {
        let (a, b) = (parameters[0], parameters[1]);
        let (x, y) = points.split_at(self.n);
        if self.separate {
            for (i, r) in r.iter_mut().enumerate() {
                let variance = T::from(self.yy[i]) - b * T::from(2.0 * self.yx[i])
                    + b * b * T::from(self.xx[i]);
                *r = (y[i] - a - b * x[i]) / variance.sqrt();
            }
            return;
        }
        let mut root = self.covariance(b);
        cholesky(&mut root, self.n);
        for i in 0..self.n {
            let mut rest = y[i] - a - b * x[i];
            for k in 0..i {
                rest = rest - root[i * self.n + k] * r[k];
            }
            r[i] = rest / root[i * self.n + i];
        }
    }
}

/// Lower triangular root of a covariance, in place of its lower half.
fn cholesky<T: Number>(c: &mut [T], n: usize) {
    for i in 0..n {
        for j in 0..=i {
            let mut sum = c[i * n + j];
            for k in 0..j {
                sum = sum - c[i * n + k] * c[j * n + k];
            }
            c[i * n + j] = if i == j {
                sum.sqrt()
            } else {
                sum / c[j * n + j]
            };
        }
    }
}

/// L⁻¹ with L Lᵀ = C; `None` where C is not positive definite to rounding.
pub(super) fn inverse_root(c: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut root = c.to_vec();
    cholesky(&mut root, n);
    let sound = |i: usize| {
        let pivot = root[i * n + i];
        pivot.is_finite() && pivot * pivot > 1e-13 * c[i * n + i]
    };
    if !(0..n).all(sound) {
        return None;
    }
    let mut inverse = vec![0.0; n * n];
    for j in 0..n {
        for i in j..n {
            let unit = if i == j { 1.0 } else { 0.0 };
            let sum: f64 = (j..i).map(|k| root[i * n + k] * inverse[k * n + j]).sum();
            inverse[i * n + j] = (unit - sum) / root[i * n + i];
        }
    }
    Some(inverse)
}

pub(super) fn whitened<T: Number>(rows: Option<&Vec<f64>>, v: Vec<T>) -> Vec<T> {
    let Some(rows) = rows else { return v };
    let n = v.len();
    if rows.len() == n {
        return v.iter().zip(rows).map(|(&v, &w)| T::from(w) * v).collect();
    }
    (0..n)
        .map(|i| {
            let row = &rows[i * n..i * n + i + 1];
            row.iter()
                .zip(&v)
                .filter(|(w, _)| **w != 0.0)
                .fold(T::from(0.0), |sum, (&w, &v)| sum + T::from(w) * v)
        })
        .collect()
}

fn dot<T: Number>(a: &[T], b: &[T]) -> T {
    a.iter()
        .zip(b)
        .fold(T::from(0.0), |sum, (&a, &b)| sum + a * b)
}

fn subtract<T: Number>(from: &mut [T], factor: T, what: &[T]) {
    for (from, &what) in from.iter_mut().zip(what) {
        *from = *from - factor * what;
    }
}
