//! Where to hold the sensor next: the attitudes after which the parameters are known best.

use super::MultiPositionFit;
use crate::Triple;
use crate::adjustment::{cholesky, solve};
use crate::direction_coverage::{spiral, unit};
use proofmass_uncertainty::DegreesOfFreedom;
use serde::{Deserialize, Serialize};

/// What one more standstill would do, after those that stand before it in a list.
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
    /// The next best attitudes, each given those before it, and what all up to it make of the uncertainties. None where
    /// attitudes are given, for then a bench decides, and none after a tumble.
    ///
    /// The rows of the equations are those of a nearly ideal sensor, −(n, n nᵀ) for the free elements. A row r of
    /// variance v takes C r rᵀ C/(v + rᵀ C r) off the covariance C; the factor k falls with every degree of freedom.
    ///
    /// **Source** the rank-one update of `[GolubVanLoan2013]` 2.1.4; trace criterion (A-optimality).
    pub fn next_attitudes(&self, count: usize) -> Vec<NextAttitude> {
        self.best_attitudes(count).unwrap_or_default()
    }

    fn best_attitudes(&self, count: usize) -> Option<Vec<NextAttitude>> {
        if self.attitudes_given || self.effective.is_some() {
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
        let add = |information: &mut [f64], r: &[f64], v: f64| {
            for a in 0..p {
                for b in 0..=a {
                    information[a * p + b] += r[a] * r[b] / v;
                }
            }
        };
        let mut typical = 0.0;
        for residual in &self.residuals {
            let v = variance(residual.noise);
            typical += v / self.residuals.len() as f64;
            add(&mut information, &row(unit(residual.acceleration)?), v);
        }
        if !(typical > 0.0 && typical.is_finite()) {
            return None;
        }
        let factor = |more: usize| {
            let nu = (self.degrees_of_freedom + more) as f64;
            if self.excess > 0.0 && self.degrees_of_freedom > 0 {
                DegreesOfFreedom::new(nu).map_or(1.96, |nu| nu.coverage_factor(self.probability))
            } else {
                1.0
            }
        };
        let mut now = None;
        let mut next = Vec::with_capacity(count);
        for taken in 1..=count {
            let mut factors = information.clone();
            cholesky(&mut factors, p)?;
            let trace: f64 = (0..p)
                .map(|c| {
                    let mut column = vec![0.0; p];
                    column[c] = 1.0;
                    solve(&factors, &mut column);
                    column[c]
                })
                .sum();
            let before = *now.get_or_insert(trace);
            let (direction, gain) = spiral(CANDIDATES)
                .map(|n| {
                    let r = row(n);
                    let mut c = r.clone();
                    solve(&factors, &mut c);
                    let along: f64 = r.iter().zip(&c).map(|(a, b)| a * b).sum();
                    let squares: f64 = c.iter().map(|v| v * v).sum();
                    (n, squares / (typical + along))
                })
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            next.push(NextAttitude {
                direction,
                expected: factor(taken) / factor(0) * ((trace - gain).max(0.0) / before).sqrt(),
            });
            add(&mut information, &row(direction), typical);
        }
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use crate::{MultiPosition, Pose, Segment};
    use proofmass_core::Gravity;

    #[test]
    fn law_attitudes_of_a_list_fill_the_hole_and_each_narrows_further() {
        // Attitudes of the upper half alone, with a little scatter.
        let poses: Vec<Pose> = crate::direction_coverage::spiral(28)
            .filter(|d| d[2] > -0.05)
            .enumerate()
            .map(|(i, d)| {
                let segment = Segment {
                    start: i,
                    end: i + 1,
                    attitude: None,
                    label: None,
                };
                let scatter = 1e-3 * ((i * 7919 % 13) as f64 / 6.0 - 1.0);
                Pose::reading(segment, d.map(|v| (9.81 + scatter) * v))
            })
            .collect();
        let gravity = Gravity::given(9.81, 1e-5).unwrap();
        let fit = MultiPosition::new(gravity)
            .nominal_sensitivity(1.0)
            .output_unit("m/s²")
            .fit(&poses)
            .unwrap();
        let next = fit.next_attitudes(4);
        assert_eq!(next.len(), 4);
        assert!(next[0].direction[2] < -0.5, "{:?}", next[0]);
        assert!(next.windows(2).all(|w| w[1].expected < w[0].expected));
        assert!(next[0].expected < 0.9, "{:?}", next[0]);
    }
}
