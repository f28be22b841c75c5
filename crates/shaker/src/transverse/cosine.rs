//! The cosine of the rotation that runs across the axis follow.

use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::DegreesOfFreedom;
use proofmass_uncertainty::algebra::{Cholesky, cholesky, product};
use std::f64::consts::TAU;

/// Directions that differ, modulo a turn.
pub(super) fn directions(across: &[(f64, Complex64)]) -> Vec<f64> {
    let mut list: Vec<f64> = Vec::new();
    for (rotation, _) in across {
        if !list.iter().any(|other| same(*rotation, *other)) {
            list.push(*rotation);
        }
    }
    list
}

fn same(a: f64, b: f64) -> bool {
    let apart = (a - b).rem_euclid(TAU);
    apart.min(TAU - apart) <= 1e-6
}

/// Sum of the squared residuals (both parts), the parameters, and the factor of XᵀX.
pub(super) fn least_squares(
    design: &Mat<f64>,
    across: &[(f64, Complex64)],
) -> Result<(f64, Vec<Complex64>, Cholesky), Error> {
    let n = across.len();
    let values = Mat::from_fn(n, 2, |i, part| {
        if part == 0 {
            across[i].1.re
        } else {
            across[i].1.im
        }
    });
    let normal = product([design.transpose(), design.as_ref()]);
    let llt = cholesky(&normal).map_err(|_| Error::TooFew {
        name: "directions across the axis that are neither one line nor opposite",
        needed: 2,
        got: directions(across).len(),
    })?;
    let solution = llt.solve(&product([design.transpose(), values.as_ref()]));
    let rest = &values - product([design.as_ref(), solution.as_ref()]);
    Ok((
        rest.squared_norm_l2(),
        (0..design.ncols())
            .map(|j| Complex64::new(solution[(j, 0)], solution[(j, 1)]))
            .collect(),
        llt,
    ))
}

/// c, S_x and S_y.
pub(super) struct Fit {
    pub(super) constant: Option<Complex64>,
    pub(super) transverse: [Complex64; 2],
    pub(super) directions: Vec<f64>,
    /// (XᵀX)⁻¹ of the two.
    pub(super) cofactor: [[f64; 2]; 2],
    /// What a constant error of each direction does to the two.
    pub(super) weights: Vec<[f64; 2]>,
    /// (XᵀX)⁻¹ of all parameters, the constant first where there is one.
    inverse: Mat<f64>,
    square: f64,
    pub(super) runs: usize,
}

/// Smallest share of a circle that the directions have to span: below it cosine and sine are one.
const SMALLEST_SPAN: f64 = 1e-3;

impl Fit {
    pub(super) fn new(across: &[(f64, Complex64)]) -> Result<Self, Error> {
        let directions = directions(across);
        let spread = directions
            .iter()
            .fold(0.0_f64, |most, a| most.max((a - directions[0]).sin().abs()));
        if spread < SMALLEST_SPAN {
            return Err(Error::TooFew {
                name: "directions across the axis that are neither one line nor opposite",
                needed: 2,
                got: directions.len().min(1),
            });
        }
        let free = usize::from(directions.len() > 2);
        let design = Mat::from_fn(across.len(), 2 + free, |i, j| match j + 1 - free {
            0 => 1.0,
            1 => across[i].0.cos(),
            _ => across[i].0.sin(),
        });
        let (square, parameters, normal) = least_squares(&design, across)?;
        let inverse = normal.inverse();
        let cofactor =
            std::array::from_fn(|a| std::array::from_fn(|b| inverse[(a + free, b + free)]));
        let gain = product([inverse.as_ref(), design.transpose()]);
        let weights = directions
            .iter()
            .map(|d| {
                std::array::from_fn(|a| {
                    (0..across.len())
                        .filter(|&i| same(across[i].0, *d))
                        .map(|i| gain[(a + free, i)])
                        .sum()
                })
            })
            .collect();
        Ok(Self {
            constant: (free == 1).then(|| parameters[0]),
            transverse: [parameters[free], parameters[free + 1]],
            directions,
            cofactor,
            weights,
            inverse,
            square,
            runs: across.len(),
        })
    }

    /// What the runs say of this rotation, and its variance in units of that of a run.
    pub(super) fn at(&self, rotation: f64) -> (Complex64, f64) {
        let [x, y] = self.transverse;
        let value = self.constant.unwrap_or_default() + x * rotation.cos() + y * rotation.sin();
        let mut design = vec![rotation.cos(), rotation.sin()];
        if self.constant.is_some() {
            design.insert(0, 1.0);
        }
        let mut variance = 0.0;
        for (a, p) in design.iter().enumerate() {
            for (b, q) in design.iter().enumerate() {
                variance += p * q * self.inverse[(a, b)];
            }
        }
        (value, variance)
    }

    pub(super) fn parameters(&self) -> usize {
        2 + usize::from(self.constant.is_some())
    }

    /// Standard deviation of each part of a run, and its degrees of freedom.
    pub(super) fn scatter(&self) -> Option<(f64, DegreesOfFreedom)> {
        let freedom = 2.0 * (self.runs as f64 - self.parameters() as f64);
        let dof = DegreesOfFreedom::new(freedom)?;
        (freedom > 0.0).then(|| ((self.square / freedom).sqrt(), dof))
    }
}
