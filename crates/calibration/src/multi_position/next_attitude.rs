//! Where to hold the sensor next: the attitude after which the parameters are known best.

use super::MultiPositionFit;
use crate::Triple;
use crate::adjustment::{cholesky, solve};
use crate::direction_coverage::{spiral, unit};
use proofmass_uncertainty::DegreesOfFreedom;
use serde::{Deserialize, Serialize};

/// What one more standstill would do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextAttitude {
    /// Direction of the specific force in the axes of the sensor: what should point up.
    pub direction: Triple,
    /// Root mean square over the parameters of the expanded uncertainty after it, over that before; what varies between
    /// the standstills staying as it is.
    pub expected: f64,
}

/// Candidates: none further than 6° from any direction.
const CANDIDATES: usize = 500;

impl MultiPositionFit {
    /// The next best attitude of all; `None` where attitudes are given, for then a bench decides.
    ///
    /// The rows of the equations are those of a nearly ideal sensor, −(n, n nᵀ) for the free elements. A row r of
    /// variance v takes C r rᵀ C/(v + rᵀ C r) off the covariance C; the factor k falls with one more degree of freedom.
    ///
    /// **Source** the rank-one update of `[GolubVanLoan2013]` 2.1.4; trace criterion (A-optimality).
    pub fn next_attitude(&self) -> Option<NextAttitude> {
        if self.attitudes_given {
            return None;
        }
        let p = self.model.parameters();
        let row = |n: Triple| {
            let mut row = vec![0.0; p];
            self.model.derivative(n, n, -1.0, &mut row);
            row
        };
        let g = self.gravity.value();
        let variance = |noise: f64| (noise.powi(2) + self.excess.powi(2)) / (g * g);
        let mut information = vec![0.0; p * p];
        let mut typical = 0.0;
        for residual in &self.residuals {
            let r = row(unit(residual.acceleration)?);
            let v = variance(residual.noise);
            typical += v / self.residuals.len() as f64;
            for a in 0..p {
                for b in 0..=a {
                    information[a * p + b] += r[a] * r[b] / v;
                }
            }
        }
        if !(typical > 0.0 && typical.is_finite()) {
            return None;
        }
        cholesky(&mut information, p)?;
        let trace: f64 = (0..p)
            .map(|c| {
                let mut column = vec![0.0; p];
                column[c] = 1.0;
                solve(&information, &mut column);
                column[c]
            })
            .sum();
        let (direction, gain) = spiral(CANDIDATES)
            .map(|n| {
                let r = row(n);
                let mut c = r.clone();
                solve(&information, &mut c);
                let along: f64 = r.iter().zip(&c).map(|(a, b)| a * b).sum();
                let squares: f64 = c.iter().map(|v| v * v).sum();
                (n, squares / (typical + along))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let factor = |nu: f64| {
            DegreesOfFreedom::new(nu).map_or(1.96, |nu| nu.coverage_factor(self.probability))
        };
        let nu = self.degrees_of_freedom as f64;
        let fewer = if self.excess > 0.0 && nu > 0.0 {
            factor(nu + 1.0) / factor(nu)
        } else {
            1.0
        };
        Some(NextAttitude {
            direction,
            expected: fewer * ((trace - gain).max(0.0) / trace).sqrt(),
        })
    }
}
