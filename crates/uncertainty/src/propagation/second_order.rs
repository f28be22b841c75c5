//! Terms of second order.

use super::{CHUNK, Linear, Model, derivatives, propagate, square_root};
use crate::{Dual, JointInputs, Quantity, numerical_tolerance};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// What the curvature of the model adds to one output, for jointly normal inputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SecondOrder {
    /// ½ tr(H U): how far the mean of y lies from f(mean of x).
    pub shift: f64,
    /// Standard uncertainty with the second-order terms.
    pub standard_uncertainty: f64,
}

impl SecondOrder {
    /// How far an end of the linear y ± U lies from that with these terms, at the same degrees of freedom.
    pub fn departure(&self, linear: &Quantity, probability: f64) -> f64 {
        let widening = self.standard_uncertainty - linear.standard_uncertainty;
        self.shift.abs() + linear.coverage_factor(probability) * widening.abs()
    }

    /// Whether the linear y ± U may stand beside these terms: by the rule that judges it beside Monte Carlo,
    /// half a unit of the last digit of u that counts. **Source** `[S1] 8.1`, for normal inputs.
    pub fn agrees(&self, linear: &Quantity, probability: f64, digits: u32) -> bool {
        // A linear u of zero sets no tolerance.
        let u = match linear.standard_uncertainty {
            u if u > 1e-9 * self.standard_uncertainty => u,
            _ => self.standard_uncertainty,
        };
        self.departure(linear, probability) <= numerical_tolerance(u, digits)
    }
}

/// Propagates with the terms of second order as well, for jointly normal inputs:
///
/// ```text
/// u² = gᵀUg + ½ tr(HUHU) + gᵀU t,   t_l = Σ_jk U_jk ∂³f/∂x_j∂x_k∂x_l
/// ```
///
/// [`SecondOrder::agrees`] says whether the first order alone may stand. Terms that cannot be had (a
/// derivative that does not exist, a variance below zero) leave the first order as it is.
///
/// **Cost** n²/8 evaluations of the model for n inputs with uncertainty. **Source** `[GUM] 5.1.2 note`, extended to correlated inputs.
pub fn propagate_second_order<M: Model>(model: &M, inputs: &JointInputs) -> Result<Linear, Error> {
    type First = Dual<f64, CHUNK>;
    type Third = Dual<Dual<First, 1>, 1>;
    let mut result = propagate(model, inputs)?;
    let x = inputs.estimates();
    let (n, m) = (x.len(), result.dof.len());
    let covariance = inputs.covariance();
    let root = square_root(&covariance)?;
    let diagonal = (0..n).all(|i| (0..n).all(|j| i == j || root[i * n + j] == 0.0));
    // Uᵀg, one row per output.
    let gradient = derivatives::<CHUNK>(&x, m, |x, y| model.evaluate(x, y)).1;
    let mut weighted = vec![0.0; m * n];
    for k in 0..m {
        let varies = |i: &usize| covariance[(*i, *i)] > 0.0;
        for i in (0..n).filter(varies) {
            for l in 0..n {
                weighted[k * n + l] += gradient[k * n + i] * covariance[(i, l)];
            }
        }
    }
    let mut shift = vec![0.0; m];
    let mut extra = vec![0.0; m];
    // Along each column s of the square root of U: s·H·e_l gives half of LᵀHL, ∂_l(sᵀHs) gives t.
    let mut y = vec![Third::from(0.0); m];
    for a in 0..n {
        let direction: Vec<f64> = (0..n).map(|i| root[i * n + a]).collect();
        if direction.iter().all(|s| *s == 0.0) {
            continue;
        }
        let mut hessian_row = vec![0.0; m * n];
        for start in (0..n).step_by(CHUNK) {
            let seeded: Vec<Third> = (0..n)
                .map(|i| {
                    let inner = First::variable(x[i], i.wrapping_sub(start));
                    let s = First::from(direction[i]);
                    let middle = Dual {
                        real: inner,
                        partials: [s],
                    };
                    Dual {
                        real: middle,
                        partials: [Dual {
                            real: s,
                            partials: [First::from(0.0)],
                        }],
                    }
                })
                .collect();
            model.evaluate(&seeded, &mut y);
            for k in 0..m {
                let slope = y[k].real.partials[0]; // ∂_s f with its gradient
                let bend = y[k].partials[0].partials[0]; // sᵀHs with its gradient
                if start == 0 {
                    shift[k] += 0.5 * bend.real;
                }
                for l in start..n.min(start + CHUNK) {
                    hessian_row[k * n + l] = slope.partials[l - start];
                    // What does not vary has no say, even where its derivative does not exist.
                    if weighted[k * n + l] != 0.0 {
                        extra[k] += weighted[k * n + l] * bend.partials[l - start];
                    }
                }
            }
        }
        for k in 0..m {
            let row = &hessian_row[k * n..(k + 1) * n];
            if diagonal {
                let bends = row
                    .iter()
                    .enumerate()
                    .filter(|(b, _)| root[b * n + b] != 0.0);
                extra[k] += bends
                    .map(|(b, h)| 0.5 * (h * root[b * n + b]).powi(2))
                    .sum::<f64>();
                continue;
            }
            for b in 0..n {
                let varies = (0..n).filter(|&l| root[l * n + b] != 0.0);
                let h: f64 = varies.map(|l| row[l] * root[l * n + b]).sum();
                extra[k] += 0.5 * h * h;
            }
        }
    }
    for k in 0..m {
        let variance = result.estimate.covariance()[(k, k)] + extra[k];
        let known = variance >= 0.0 && variance.is_finite() && shift[k].is_finite();
        result.second_order.push(known.then(|| SecondOrder {
            shift: shift[k],
            standard_uncertainty: variance.sqrt(),
        }));
    }
    Ok(result)
}
