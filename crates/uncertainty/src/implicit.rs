//! Models that are given as an equation to be solved: h(y, x) = 0.

#[cfg(feature = "model")]
mod search;

#[cfg(feature = "model")]
pub(crate) use search::{Found, Lost};

use crate::propagation::{jacobian_of, linear};
use crate::{Dual, JointInputs, Linear, NormalEquations, Number};
use proofmass_core::Error;

/// A measurement model h(y, x) = 0 with as many equations as outputs.
pub trait Implicit {
    /// Names and units of the outputs y.
    fn outputs(&self) -> Vec<(String, String)>;
    /// Computes h from outputs y and inputs x.
    fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]);
}

/// A fit: y minimises Σ r_i(y, x)². Every input that enters the residuals (readings, references, positions,
/// temperatures) propagates, whether it is in a "dependent" or an "independent" variable.
pub trait LeastSquares {
    /// Names and units of the parameters y.
    fn outputs(&self) -> Vec<(String, String)>;
    /// Number of residuals.
    fn residuals(&self) -> usize;
    /// Computes the weighted residuals from parameters y and inputs x.
    fn residual<T: Number>(&self, y: &[T], x: &[T], r: &mut [T]);
}

/// Solves h(y, x) = 0 from a starting point and propagates the inputs: J = −(∂h/∂y)⁻¹ ∂h/∂x.
///
/// **Errors** [`Error::NotConverged`] when Newton's iteration does not settle in 50 steps, [`Error::Singular`]
/// when the equations do not determine y, [`Error::Length`].
/// **Source** `[S2] 6.2.3`, `[S2] 6.3`.
pub fn propagate_implicit<M: Implicit>(
    model: &M,
    start: &[f64],
    inputs: &JointInputs,
) -> Result<Linear, Error> {
    if start.len() != model.outputs().len() {
        return Err(Error::Length {
            name: "starting point",
            expected: model.outputs().len(),
            got: start.len(),
        });
    }
    let x = inputs.estimates();
    let root = Root::find(model, start, &x)?;
    let jacobian = sensitivities(model, &root.y, &x, &root.slope)?;
    let result = linear(model.outputs(), &root.y, &jacobian, inputs)?;
    // A step is judged against the value or, for a value near zero, against its uncertainty.
    for (k, step) in root.step.iter().enumerate() {
        let u = result.estimate().covariance().standard_uncertainty(k);
        if !(step.abs() <= (1e-8 * root.scale[k]).max(1e-6 * u)) {
            return Err(root.not_converged(k));
        }
    }
    Ok(result)
}

/// Refines a fit from a starting point (the fit a caller already made will do) and propagates all inputs
/// through it, by the implicit function theorem on the normal equations Σ r_i ∂r_i/∂y = 0.
///
/// Second derivatives of the residuals are included, so the covariance is right also where residuals are not
/// small. **Errors** as [`propagate_implicit`].
///
/// ```
/// use proofmass_uncertainty::*;
/// /// A straight line through (0, a), (1, b), (2, c), unweighted.
/// struct Line;
/// impl LeastSquares for Line {
///     fn outputs(&self) -> Vec<(String, String)> { vec![("intercept".into(), "1".into()), ("slope".into(), "1".into())] }
///     fn residuals(&self) -> usize { 3 }
///     fn residual<T: Number>(&self, y: &[T], x: &[T], r: &mut [T]) {
///         for i in 0..3 { r[i] = x[i] - y[0] - y[1] * T::from(i as f64); }
///     }
/// }
/// let point = |name: &str, mean| Input::new(name, "1", Distribution::Normal { mean, u: 0.1 });
/// let inputs = Inputs::new().add(point("a", 0.1)).add(point("b", 1.0)).add(point("c", 2.2)).single()?;
/// let fit = propagate_least_squares(&Line, &[0.0, 1.0], &inputs)?;
/// let slope = fit.get("slope").unwrap();
/// assert!((slope.value - 1.05).abs() < 1e-12);
/// assert!((slope.standard_uncertainty - 0.1 / 2f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn propagate_least_squares<M: LeastSquares>(
    model: &M,
    start: &[f64],
    inputs: &JointInputs,
) -> Result<Linear, Error> {
    propagate_implicit(&NormalEquations(model), start, inputs)
}

/// ∂y/∂x = −(∂h/∂y)⁻¹ ∂h/∂x at a root, row by row; `slope` is ∂h/∂y there.
fn sensitivities<M: Implicit>(
    model: &M,
    y: &[f64],
    x: &[f64],
    slope: &Scaled,
) -> Result<Vec<f64>, Error> {
    let (m, n) = (y.len(), x.len());
    let fixed = constants(y);
    let (_, by_x) = jacobian_of::<8>(x, m, |x, out| model.residual(&fixed, x, out))?;
    let mut jacobian = vec![0.0; m * n];
    for l in 0..n {
        let column: Vec<f64> = (0..m).map(|k| by_x[k * n + l]).collect();
        for (k, v) in slope.solve(&column)?.into_iter().enumerate() {
            jacobian[k * n + l] = -v;
        }
    }
    Ok(jacobian)
}

type Partial = Dual<f64, 8>;

fn constants(v: &[f64]) -> Vec<Partial> {
    v.iter().map(|&v| Partial::from(v)).collect()
}

/// Where h(y, x) = 0 for one x.
pub(crate) struct Root {
    pub(crate) y: Vec<f64>,
    /// ∂h/∂y there.
    pub(crate) slope: Scaled,
    /// Last step of the iteration.
    step: Vec<f64>,
    /// Largest value and step met, the measure of a step.
    scale: Vec<f64>,
}

/// A root at the estimates, from which others are followed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Branch {
    /// Inputs there.
    pub x: Vec<f64>,
    /// The root.
    pub y: Vec<f64>,
    /// Sizes that a change of the unknowns is measured by, where the root itself is near zero.
    pub scale: Vec<f64>,
    /// Sign of the determinant of ∂h/∂y.
    pub sign: f64,
}

impl Branch {
    /// Of a root that was found.
    pub fn of<M: Implicit>(model: &M, y: &[f64], x: &[f64], scale: &[f64]) -> Result<Self, Error> {
        let (_, slope) = slopes(model, y.len(), x)(y)?;
        Ok(Self {
            x: x.to_vec(),
            y: y.to_vec(),
            scale: scale.iter().map(|s| s.abs()).collect(),
            sign: scaled(&slope, y.len()).sign,
        })
    }
}

const ITERATIONS: usize = 50;
/// Points at which a root is sought on its way, and the shortest way between two as a part of the whole.
const ATTEMPTS: usize = 200;
const SHORTEST: f64 = 1e-6;

/// Values and derivatives, row by row.
type ValuesAndSlopes = (Vec<f64>, Vec<f64>);

/// The equations and their derivatives by the unknowns, at inputs x.
fn slopes<'a, M: Implicit>(
    model: &'a M,
    m: usize,
    x: &[f64],
) -> impl Fn(&[f64]) -> Result<ValuesAndSlopes, Error> + 'a {
    // Two derivatives travel at a quarter of the cost of eight.
    let (narrow, wide) = if m <= 2 {
        (
            x.iter().map(|&x| Dual::from(x)).collect::<Vec<_>>(),
            Vec::new(),
        )
    } else {
        (Vec::new(), constants(x))
    };
    move |y| {
        if m <= 2 {
            jacobian_of::<2>(y, m, |y, out| model.residual(y, &narrow, out))
        } else {
            jacobian_of::<8>(y, m, |y, out| model.residual(y, &wide, out))
        }
    }
}

impl Root {
    /// Newton's iteration; whether its last step was small enough is for the caller to judge.
    pub fn find<M: Implicit>(model: &M, start: &[f64], x: &[f64]) -> Result<Self, Error> {
        let m = start.len();
        let slope_at = slopes(model, m, x);
        let mut y = start.to_vec();
        let mut scale: Vec<f64> = y.iter().map(|y| y.abs()).collect();
        let mut step = vec![f64::INFINITY; m];
        let mut previous = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let (value, slope) = slope_at(&y)?;
            step = scaled(&slope, m).solve(&value)?;
            let mut relative: f64 = 0.0;
            for k in 0..m {
                y[k] -= step[k];
                scale[k] = scale[k].max(y[k].abs()).max(step[k].abs());
                if step[k] != 0.0 {
                    relative = relative.max(step[k].abs() / scale[k]);
                }
            }
            // Quadratic convergence ends in rounding noise: settled when a small step no longer shrinks.
            if relative < 1e-15 || (relative < 1e-8 && relative >= 0.5 * previous) {
                break;
            }
            previous = relative;
        }
        let (_, slope) = slope_at(&y)?;
        Ok(Self {
            slope: scaled(&slope, m),
            y,
            step,
            scale,
        })
    }

    /// The root at x that the one at the estimates becomes when the inputs go there on a straight line.
    ///
    /// Newton's iteration from a root known at one point of the line is trusted at the next where its steps shrink as they do
    /// close to a root (each at most a quarter of the one before) and ∂h/∂y keeps the sign of its determinant, which changes at
    /// a fold; else the next point is taken nearer. **Errors** [`Error::NotConverged`] where the root ends on the way.
    /// **Source** `[Deuflhard2004] 5.1`.
    pub fn follow<M: Implicit>(model: &M, from: &Branch, x: &[f64]) -> Result<Self, Error> {
        let mut y = from.y.clone();
        let weight: Vec<f64> = y
            .iter()
            .zip(&from.scale)
            .map(|(y, s)| y.abs().max(*s))
            .collect();
        let (mut done, mut part): (f64, f64) = (0.0, 1.0);
        for _ in 0..ATTEMPTS {
            let next = (done + part).min(1.0);
            let at: Vec<f64> = match next < 1.0 {
                true => from
                    .x
                    .iter()
                    .zip(x)
                    .map(|(a, b)| a + next * (b - a))
                    .collect(),
                false => x.to_vec(),
            };
            match Self::near(model, &y, &at, weight.clone(), from.sign) {
                Some(root) if next >= 1.0 => return Ok(root),
                Some(root) => {
                    y = root.y;
                    done = next;
                    part *= 2.0;
                }
                None => part *= 0.5,
            }
            if part < SHORTEST {
                break;
            }
        }
        Err(Error::NotConverged {
            name: "continuation of the solution",
            iterations: ATTEMPTS,
            step: part,
        })
    }

    /// Newton's iteration where it begins close to a root and ends there.
    fn near<M: Implicit>(
        model: &M,
        start: &[f64],
        x: &[f64],
        mut weight: Vec<f64>,
        sign: f64,
    ) -> Option<Self> {
        let m = start.len();
        let slope_at = slopes(model, m, x);
        let mut y = start.to_vec();
        let mut scale: Vec<f64> = y.iter().map(|y| y.abs()).collect();
        let mut previous = f64::INFINITY;
        for count in 0..ITERATIONS {
            let (value, slope) = slope_at(&y).ok()?;
            let slope = scaled(&slope, m);
            if slope.sign != sign {
                return None;
            }
            let step = slope.solve(&value).ok()?;
            let mut size: f64 = 0.0;
            let largest = weight.iter().fold(0.0, |l: f64, w| l.max(*w));
            for k in 0..m {
                y[k] -= step[k];
                scale[k] = scale[k].max(y[k].abs()).max(step[k].abs());
                if count == 0 {
                    weight[k] = weight[k].max(step[k].abs());
                }
                let w = weight[k].max(1e-9 * largest);
                if w > 0.0 {
                    size = size.max(step[k].abs() / w);
                }
            }
            // Rounding noise no longer shrinks.
            if size < 1e-15 || (size < 1e-8 && size >= 0.25 * previous) {
                return Some(Self {
                    slope,
                    y,
                    step,
                    scale,
                });
            }
            if !(size <= 0.25 * previous) {
                return None;
            }
            previous = size;
        }
        None
    }

    /// Whether every step ended small against the values met.
    pub fn settled(&self) -> bool {
        let mut steps = self.step.iter().zip(&self.scale);
        steps.all(|(step, scale)| step.abs() <= 1e-8 * scale)
    }

    fn not_converged(&self, k: usize) -> Error {
        Error::NotConverged {
            name: "implicit model",
            iterations: ITERATIONS,
            step: self.step[k].abs() / self.scale[k],
        }
    }
}

/// The inverse of ∂h/∂y, found with rows and columns brought to size 1, so that units do not spoil it.
pub(crate) struct Scaled {
    inverse: Vec<f64>,
    row: Vec<f64>,
    column: Vec<f64>,
    condition: f64,
    /// Sign of the determinant; 0 where there is no inverse.
    sign: f64,
}

fn scaled(slope: &[f64], m: usize) -> Scaled {
    let inverse = |s: f64| if s > 0.0 { 1.0 / s } else { 1.0 };
    let row: Vec<f64> = (0..m)
        .map(|i| inverse((0..m).map(|j| slope[i * m + j].abs()).fold(0.0, f64::max)))
        .collect();
    let column: Vec<f64> = (0..m)
        .map(|j| {
            inverse(
                (0..m)
                    .map(|i| row[i] * slope[i * m + j].abs())
                    .fold(0.0, f64::max),
            )
        })
        .collect();
    let matrix: Vec<f64> = (0..m * m)
        .map(|k| row[k / m] * slope[k] * column[k % m])
        .collect();
    let (inverse, condition, sign) = match inverted(&matrix, m) {
        Some((inverse, sign)) => {
            let condition = norm(&matrix, m) * norm(&inverse, m);
            (inverse, condition, sign)
        }
        None => (matrix, f64::INFINITY, 0.0),
    };
    Scaled {
        inverse,
        row,
        column,
        condition,
        sign,
    }
}

/// Largest sum of magnitudes along a row.
fn norm(matrix: &[f64], m: usize) -> f64 {
    matrix
        .chunks(m.max(1))
        .map(|row| row.iter().map(|v| v.abs()).sum())
        .fold(0.0, f64::max)
}

/// Inverse and sign of the determinant, by Gauss and Jordan with pivots from all that is left; `None` where none is left.
fn inverted(matrix: &[f64], m: usize) -> Option<(Vec<f64>, f64)> {
    let mut a = matrix.to_vec();
    let mut inverse = vec![0.0; m * m];
    (0..m).for_each(|i| inverse[i * m + i] = 1.0);
    // Column that each row eliminates.
    let mut of_row = vec![usize::MAX; m];
    let mut used = vec![false; m];
    let mut sign = 1.0;
    for _ in 0..m {
        let (mut best, mut r, mut c) = (0.0, 0, 0);
        for i in (0..m).filter(|&i| of_row[i] == usize::MAX) {
            for j in (0..m).filter(|&j| !used[j]) {
                if a[i * m + j].abs() > best {
                    (best, r, c) = (a[i * m + j].abs(), i, j);
                }
            }
        }
        if !(best > 0.0) {
            return None;
        }
        (of_row[r], used[c]) = (c, true);
        let pivot = a[r * m + c];
        sign *= pivot.signum();
        for k in 0..m {
            a[r * m + k] /= pivot;
            inverse[r * m + k] /= pivot;
        }
        for i in (0..m).filter(|&i| i != r) {
            let factor = a[i * m + c];
            if factor == 0.0 {
                continue;
            }
            for k in 0..m {
                a[i * m + k] -= factor * a[r * m + k];
                inverse[i * m + k] -= factor * inverse[r * m + k];
            }
        }
    }
    let mut ordered = vec![0.0; m * m];
    for (i, &c) in of_row.iter().enumerate() {
        ordered[c * m..(c + 1) * m].copy_from_slice(&inverse[i * m..(i + 1) * m]);
    }
    // Each pair of rows whose columns stand the other way round turns the sign.
    for i in 0..m {
        for k in 0..i {
            if of_row[k] > of_row[i] {
                sign = -sign;
            }
        }
    }
    Some((ordered, sign))
}

impl Scaled {
    pub fn solve(&self, b: &[f64]) -> Result<Vec<f64>, Error> {
        // Beyond 1e14 not one digit of the solution is left.
        if !(self.condition < 1e14) {
            return Err(Error::Singular {
                name: "derivative of the equations by the outputs",
                condition: self.condition,
            });
        }
        let m = self.row.len();
        let x = |j: usize| -> f64 {
            let row = &self.inverse[j * m..(j + 1) * m];
            let terms = row.iter().zip(&self.row).zip(b);
            terms.map(|((v, r), b)| v * r * b).sum()
        };
        Ok((0..m).map(|j| self.column[j] * x(j)).collect())
    }
}
