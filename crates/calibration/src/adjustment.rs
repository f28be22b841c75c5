//! Weighted non-linear least squares with the covariance of every cause kept apart.

use faer::prelude::*;
use faer::{Mat, Side};
use proofmass_core::Error;

/// The equations that belong to one observation (a standstill): residuals, their derivatives, their covariance.
#[derive(Clone, Debug)]
pub(crate) struct Equations {
    /// Residuals, d of them.
    pub residual: Vec<f64>,
    /// ∂residual/∂parameter, d rows.
    pub jacobian: Vec<Vec<f64>>,
    /// Covariance of the residuals from everything that is known beforehand, d × d.
    pub covariance: Mat<f64>,
}

/// What came out of an adjustment.
#[derive(Clone, Debug)]
pub(crate) struct Adjustment {
    pub parameters: Vec<f64>,
    /// G = (JᵀWJ)⁻¹JᵀW: how an error of each equation appears in the parameters, p rows.
    pub gain: Mat<f64>,
    /// Residuals divided by their standard uncertainty (whitened), one per equation.
    pub whitened: Vec<f64>,
    /// Diagonal of the hat matrix of the whitened problem.
    pub leverage: Vec<f64>,
    pub chi_square: f64,
    pub degrees_of_freedom: usize,
    /// Condition number of the unweighted Jacobian in natural units.
    pub condition: f64,
    pub iterations: usize,
}

const MAX_ITERATIONS: usize = 60;
/// A step below this share of the parameters (of order one) ends the iteration.
const TOLERANCE: f64 = 1e-12;
/// Condition number beyond which a direction of the parameters counts as undetermined.
const MAX_CONDITION: f64 = 1e4;

/// Gauss–Newton with weights renewed at every step and the step halved while the cost would rise.
///
/// `equations` gives the blocks at a point; `excess` is a variance added to every equation. Parameters are in
/// natural units (of order one).
///
/// # Errors
/// [`Error::Unobservable`] with the parameter that weighs most in the undetermined direction;
/// [`Error::NotConverged`]; [`Error::NotPositiveDefinite`] for a block without weight.
pub(crate) fn adjust(
    start: &[f64],
    excess: f64,
    name: impl Fn(usize) -> &'static str,
    equations: impl Fn(&[f64]) -> Result<Vec<Equations>, Error>,
) -> Result<Adjustment, Error> {
    let p = start.len();
    let mut parameters = start.to_vec();
    let mut step_norm = f64::INFINITY;
    let mut blocks = equations(&parameters)?;
    observability(&blocks, p, &name)?;
    for iteration in 1..=MAX_ITERATIONS {
        let system = System::whiten(&blocks, excess, p)?;
        let step = system.solve()?;
        let cost = system.cost();
        // The weights stay as they are while the step is shortened, so that costs compare.
        let mut factor = 1.0;
        let (next, next_blocks) = loop {
            let trial: Vec<f64> = parameters
                .iter()
                .zip(&step)
                .map(|(x, s)| x + factor * s)
                .collect();
            let trial_blocks = equations(&trial);
            if let Ok(trial_blocks) = trial_blocks {
                let accepted = system.cost_of(&trial_blocks) <= cost * (1.0 + 1e-9) + 1e-18;
                if accepted || factor < 1e-3 {
                    break (trial, trial_blocks);
                }
            } else if factor < 1e-3 {
                return Err(Error::NotConverged {
                    name: "multi-position fit",
                    iterations: iteration,
                    step: step_norm,
                });
            }
            factor *= 0.5;
        };
        step_norm = factor * step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        parameters = next;
        blocks = next_blocks;
        if step_norm < TOLERANCE {
            let condition = observability(&blocks, p, &name)?;
            return System::whiten(&blocks, excess, p)?.finish(parameters, condition, iteration);
        }
    }
    // Rounding of the data may hold the step slightly above the tolerance; a thousand times of it is failure.
    if step_norm < 1e3 * TOLERANCE {
        let condition = observability(&blocks, p, &name)?;
        return System::whiten(&blocks, excess, p)?.finish(parameters, condition, MAX_ITERATIONS);
    }
    Err(Error::NotConverged {
        name: "multi-position fit",
        iterations: MAX_ITERATIONS,
        step: step_norm,
    })
}

/// The excess variance that, added to every equation, brings χ² down to its degrees of freedom.
///
/// Zero when χ² does not exceed its 95 % quantile. **Source** `[PauleMandel1982]`.
pub(crate) fn excess_variance(
    chi_square: f64,
    degrees_of_freedom: usize,
    quantile: f64,
    mut chi_square_at: impl FnMut(f64) -> Result<f64, Error>,
    scale: f64,
) -> Result<f64, Error> {
    if degrees_of_freedom == 0 || chi_square <= quantile {
        return Ok(0.0);
    }
    let target = degrees_of_freedom as f64;
    let mut low = 0.0;
    let mut high = scale * (chi_square / target);
    for _ in 0..60 {
        if chi_square_at(high)? <= target {
            break;
        }
        low = high;
        high *= 4.0;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if chi_square_at(middle)? > target {
            low = middle;
        } else {
            high = middle;
        }
        if high - low < 1e-5 * high {
            break;
        }
    }
    Ok(0.5 * (low + high))
}

/// The stacked problem after division by the Cholesky factor of each block's covariance.
struct System {
    jacobian: Mat<f64>,
    residual: Mat<f64>,
    /// L⁻¹ of each block.
    whiteners: Vec<Mat<f64>>,
}

impl System {
    fn whiten(blocks: &[Equations], excess: f64, p: usize) -> Result<Self, Error> {
        let rows = blocks.iter().map(|b| b.residual.len()).sum();
        let mut jacobian = Mat::zeros(rows, p);
        let mut residual = Mat::zeros(rows, 1);
        let mut whiteners = Vec::with_capacity(blocks.len());
        let mut row = 0;
        for (index, block) in blocks.iter().enumerate() {
            let d = block.residual.len();
            let mut v = block.covariance.clone();
            for i in 0..d {
                v[(i, i)] += excess;
            }
            let whitener = inverse_factor(&v, index)?;
            for i in 0..d {
                for k in 0..=i {
                    let l = whitener[(i, k)];
                    residual[(row + i, 0)] += l * block.residual[k];
                    for (j, value) in block.jacobian[k].iter().enumerate() {
                        jacobian[(row + i, j)] += l * value;
                    }
                }
            }
            whiteners.push(whitener);
            row += d;
        }
        Ok(Self {
            jacobian,
            residual,
            whiteners,
        })
    }

    fn solve(&self) -> Result<Vec<f64>, Error> {
        let step = self.jacobian.qr().solve_lstsq(&self.residual);
        let step: Vec<f64> = (0..self.jacobian.ncols()).map(|i| -step[(i, 0)]).collect();
        match step.iter().position(|s| !s.is_finite()) {
            Some(index) => Err(Error::NotFinite {
                name: "step of the fit",
                index,
            }),
            None => Ok(step),
        }
    }

    fn cost(&self) -> f64 {
        (0..self.residual.nrows())
            .map(|i| self.residual[(i, 0)].powi(2))
            .sum()
    }

    /// Cost of other residuals under the weights of this system.
    fn cost_of(&self, blocks: &[Equations]) -> f64 {
        let mut cost = 0.0;
        for (block, whitener) in blocks.iter().zip(&self.whiteners) {
            for i in 0..block.residual.len() {
                let v: f64 = (0..=i).map(|k| whitener[(i, k)] * block.residual[k]).sum();
                cost += v * v;
            }
        }
        cost
    }

    fn finish(
        self,
        parameters: Vec<f64>,
        condition: f64,
        iterations: usize,
    ) -> Result<Adjustment, Error> {
        let p = parameters.len();
        let rows = self.jacobian.nrows();
        // With J = QR: G = R⁻¹Qᵀ in whitened rows, leverage the squared rows of Q.
        let svd = self.jacobian.thin_svd().map_err(|_| Error::NotConverged {
            name: "singular values",
            iterations: 0,
            step: f64::INFINITY,
        })?;
        let (u, s, v) = (svd.U(), svd.S(), svd.V());
        let leverage = (0..rows)
            .map(|i| (0..p).map(|k| u[(i, k)].powi(2)).sum::<f64>())
            .collect();
        let whitened_gain = Mat::from_fn(p, rows, |i, j| {
            (0..p).map(|k| v[(i, k)] / s[k] * u[(j, k)]).sum::<f64>()
        });
        let mut gain = Mat::zeros(p, rows);
        let mut row = 0;
        for whitener in &self.whiteners {
            let d = whitener.nrows();
            for i in 0..p {
                for k in 0..d {
                    gain[(i, row + k)] = (k..d)
                        .map(|l| whitened_gain[(i, row + l)] * whitener[(l, k)])
                        .sum();
                }
            }
            row += d;
        }
        Ok(Adjustment {
            chi_square: self.cost(),
            whitened: (0..rows).map(|i| self.residual[(i, 0)]).collect(),
            parameters,
            gain,
            leverage,
            degrees_of_freedom: rows.saturating_sub(p),
            condition,
            iterations,
        })
    }
}

/// L⁻¹ of V = L Lᵀ.
fn inverse_factor(v: &Mat<f64>, index: usize) -> Result<Mat<f64>, Error> {
    let d = v.nrows();
    let refuse = |value| Error::NotPositiveDefinite {
        name: "covariance of a standstill",
        row: index,
        column: index,
        value,
    };
    if d == 1 {
        let variance = v[(0, 0)];
        if !(variance > 0.0 && variance.is_finite()) {
            return Err(refuse(variance));
        }
        return Ok(Mat::from_fn(1, 1, |_, _| 1.0 / variance.sqrt()));
    }
    let llt = v.llt(Side::Lower).map_err(|_| refuse(v[(0, 0)]))?;
    let mut inverse = Mat::identity(d, d);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        llt.L(),
        inverse.as_mut(),
        faer::Par::Seq,
    );
    Ok(inverse)
}

/// Condition number of the unweighted Jacobian; an error that names the parameter when it is hopeless.
fn observability(
    blocks: &[Equations],
    p: usize,
    name: &impl Fn(usize) -> &'static str,
) -> Result<f64, Error> {
    let rows: Vec<&Vec<f64>> = blocks.iter().flat_map(|b| &b.jacobian).collect();
    if rows.len() < p {
        return Err(Error::TooFew {
            name: "standstills",
            needed: p,
            got: rows.len(),
        });
    }
    let jacobian = Mat::from_fn(rows.len(), p, |i, j| rows[i][j]);
    let svd = jacobian.thin_svd().map_err(|_| Error::NotConverged {
        name: "singular values",
        iterations: 0,
        step: f64::INFINITY,
    })?;
    let (largest, smallest) = (svd.S()[0], svd.S()[p - 1]);
    let condition = if smallest > 0.0 {
        largest / smallest
    } else {
        f64::INFINITY
    };
    if !(condition < MAX_CONDITION) {
        let weakest = (0..p)
            .max_by(|&a, &b| {
                svd.V()[(a, p - 1)]
                    .abs()
                    .total_cmp(&svd.V()[(b, p - 1)].abs())
            })
            .unwrap_or(0);
        return Err(Error::Unobservable {
            parameter: name(weakest),
            condition,
        });
    }
    Ok(condition)
}
