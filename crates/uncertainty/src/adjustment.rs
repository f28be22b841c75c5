//! Weighted non-linear least squares whose weights may be renewed from outside.

use proofmass_core::Error;

/// Residuals of all equations at a point, and their derivatives.
#[derive(Clone, Debug, Default)]
pub struct Equations {
    /// r, one per equation.
    pub residual: Vec<f64>,
    /// ∂r/∂θ, by rows.
    pub jacobian: Vec<f64>,
}

/// Where an adjustment ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solution {
    /// θ.
    pub parameters: Vec<f64>,
    /// Residuals and derivatives there.
    pub equations: Equations,
    /// Steps that were taken.
    pub iterations: usize,
}

const MAX_ITERATIONS: usize = 60;
/// A step below this share of the parameters (of order one) ends the iteration.
const TOLERANCE: f64 = 1e-11;

/// Gauss–Newton at fixed weights, the step halved while the cost would rise.
///
/// Parameters are in natural units (of order one); `name` stands in the error.
///
/// # Errors
/// [`Error::NotConverged`]; those of `equations` at the start.
pub fn adjust(
    name: &'static str,
    start: &[f64],
    weights: &[f64],
    equations: impl Fn(&[f64]) -> Result<Equations, Error>,
) -> Result<Solution, Error> {
    let cost = |e: &Equations| -> f64 {
        weights
            .iter()
            .zip(&e.residual)
            .map(|(w, r)| w * r * r)
            .sum()
    };
    let mut parameters = start.to_vec();
    let mut here = equations(&parameters)?;
    let mut step_norm = f64::INFINITY;
    for iteration in 1..=MAX_ITERATIONS {
        let diverged = Error::NotConverged {
            name,
            iterations: iteration,
            step: step_norm,
        };
        let step = step(&here, weights, parameters.len()).ok_or(diverged)?;
        let taken = descend(
            &parameters,
            &step,
            cost(&here),
            1e-18,
            &equations,
            |e, _| cost(e),
        )
        .map_err(|_| diverged)?;
        (parameters, here) = (taken.parameters, taken.equations);
        step_norm = taken.share * step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        // Rounding of the data may hold the step slightly above the tolerance; a thousand times of it is failure.
        if step_norm < TOLERANCE || (iteration == MAX_ITERATIONS && step_norm < 1e3 * TOLERANCE) {
            return Ok(Solution {
                parameters,
                equations: here,
                iterations: iteration,
            });
        }
    }
    Err(Error::NotConverged {
        name,
        iterations: MAX_ITERATIONS,
        step: step_norm,
    })
}

/// Where a damped step ended.
#[non_exhaustive]
pub struct Taken<L> {
    /// θ after the step.
    pub parameters: Vec<f64>,
    /// The equations there.
    pub equations: L,
    /// Share of the full step that was taken.
    pub share: f64,
}

/// Takes θ − share · step, the share halved while the sum of squares rises above `before` by more than `rounding`,
/// or the equations cannot be evaluated; a thousandth is taken whatever it gives.
///
/// # Errors
/// Those of `equations` at a thousandth of the step.
pub fn descend<L>(
    parameters: &[f64],
    step: &[f64],
    before: f64,
    rounding: f64,
    equations: impl Fn(&[f64]) -> Result<L, Error>,
    sum_of_squares: impl Fn(&L, &[f64]) -> f64,
) -> Result<Taken<L>, Error> {
    let mut share = 1.0;
    loop {
        let trial: Vec<f64> = parameters
            .iter()
            .zip(step)
            .map(|(x, s)| x - share * s)
            .collect();
        match equations(&trial) {
            Ok(there) if sum_of_squares(&there, &trial) <= before + rounding || share < 1e-3 => {
                return Ok(Taken {
                    parameters: trial,
                    equations: there,
                    share,
                });
            }
            Err(error) if share < 1e-3 => return Err(error),
            _ => share *= 0.5,
        }
    }
}

/// The least-squares solution s of √w J s = √w r; `None` where the equations do not determine it.
///
/// By the normal equations in plain arrays: a dozen unknowns, scaled to order one, with a condition number below 10⁴, so
/// that a step keeps eight digits, and the next step corrects it.
fn step(equations: &Equations, weights: &[f64], p: usize) -> Option<Vec<f64>> {
    let mut normal = vec![0.0; p * p];
    let mut step = vec![0.0; p];
    let rows = equations.jacobian.chunks_exact(p);
    for ((row, r), w) in rows.zip(&equations.residual).zip(weights) {
        for a in 0..p {
            let weighted = w * row[a];
            step[a] += weighted * r;
            for b in 0..=a {
                normal[a * p + b] += weighted * row[b];
            }
        }
    }
    cholesky(&mut normal, p)?;
    solve(&normal, &mut step);
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// L of A = L Lᵀ in place of the lower triangle; `None` for a matrix that is not positive definite.
pub fn cholesky(a: &mut [f64], p: usize) -> Option<()> {
    for i in 0..p {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i * p + k] * a[j * p + k]).sum();
            let rest = a[i * p + j] - sum;
            if i == j {
                if !(rest > 1e-14 * a[i * p + i] && rest.is_finite()) {
                    return None;
                }
                a[i * p + i] = rest.sqrt();
            } else {
                a[i * p + j] = rest / a[j * p + j];
            }
        }
    }
    Some(())
}

/// Solves L Lᵀ x = b in place.
pub fn solve(l: &[f64], b: &mut [f64]) {
    let p = b.len();
    for i in 0..p {
        let sum: f64 = (0..i).map(|k| l[i * p + k] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i * p + i];
    }
    for i in (0..p).rev() {
        let sum: f64 = (i + 1..p).map(|k| l[k * p + i] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i * p + i];
    }
}

/// The root of a symmetric positive definite matrix of few unknowns whose diagonal was scaled to one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ScaledRoot {
    /// What each unknown was scaled with.
    pub scale: Vec<f64>,
    l: Vec<f64>,
}

impl ScaledRoot {
    /// Of the matrix with these elements, of which the lower half is looked at; `None` when it is none, or one unknown is the copy of
    /// others to the last digits.
    pub fn new(n: usize, at: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let diagonal: Vec<f64> = (0..n).map(|i| at(i, i)).collect();
        if !diagonal.iter().all(|d| *d > 0.0 && d.is_finite()) {
            return None;
        }
        let scale: Vec<f64> = diagonal.iter().map(|d| d.sqrt().recip()).collect();
        let mut l = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let mut sum = at(i, j) * scale[i] * scale[j];
                for k in 0..j {
                    sum -= l[i * n + k] * l[j * n + k];
                }
                if i == j {
                    if !(sum > 1e-13) {
                        return None;
                    }
                    l[i * n + i] = sum.sqrt();
                } else {
                    l[i * n + j] = sum / l[j * n + j];
                }
            }
        }
        Some(Self { scale, l })
    }

    /// L⁻¹ x, in place.
    pub fn forward(&self, x: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            for k in 0..i {
                x[i] -= self.l[i * n + k] * x[k];
            }
            x[i] /= self.l[i * n + i];
        }
    }

    /// L⁻ᵀ x, in place.
    pub fn backward(&self, x: &mut [f64]) {
        let n = x.len();
        for i in (0..n).rev() {
            for k in i + 1..n {
                x[i] -= self.l[k * n + i] * x[k];
            }
            x[i] /= self.l[i * n + i];
        }
    }

    /// Solution of the unscaled system.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let scaled =
            |x: &[f64]| -> Vec<f64> { x.iter().zip(&self.scale).map(|(x, s)| x * s).collect() };
        let mut x = scaled(right);
        self.forward(&mut x);
        self.backward(&mut x);
        scaled(&x)
    }
}
