//! Where to hold the sensor next: the attitudes after which the parameters are known best.

use super::MultiPositionFit;
use crate::Triple;
use crate::direction_coverage::{spiral, unit};
use proofmass_uncertainty::DegreesOfFreedom;
use proofmass_uncertainty::adjustment::{cholesky, solve};

/// What one more standstill would do, after those that stand before it in a list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NextAttitude {
    /// Direction of the specific force in the axes of the sensor: what should point up.
    pub direction: Triple,
    /// Root mean square over the parameters of the expanded uncertainty after it, over that of the fit; what varies between
    /// the standstills and what is common to all of them staying as they are.
    pub expected: f64,
}

/// Where most of the uncertainty comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limiting {
    /// Noise within the standstills.
    Noise,
    /// What varies from standstill to standstill.
    Between,
    /// Own errors of the given attitudes.
    Attitudes,
    /// What is common to all standstills: gravity, the frame.
    Common,
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

    /// The cause with the largest share of the variance, in the mean over the quantities.
    pub fn limiting(&self) -> Limiting {
        let mut shares = [
            (Limiting::Noise, 0.0),
            (Limiting::Between, 0.0),
            (Limiting::Attitudes, 0.0),
            (Limiting::Common, 0.0),
        ];
        for part in self.scatter_parts() {
            let common = self.common_variance(&part.name);
            let all = [
                part.noise.powi(2),
                part.between.powi(2),
                part.attitude.powi(2),
                common,
            ];
            let sum: f64 = all.iter().sum();
            if sum > 0.0 {
                for (share, variance) in shares.iter_mut().zip(all) {
                    share.1 += variance / sum;
                }
            }
        }
        let largest = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map_or(Limiting::Noise, |share| share.0)
    }

    /// Of a quantity, from what no residual shows.
    fn common_variance(&self, name: &str) -> f64 {
        let lines = self.estimate.budget(name).unwrap_or_default();
        let common = lines
            .iter()
            .filter(|line| line.key != super::causes::STANDSTILLS);
        common.map(|line| line.contribution.powi(2)).sum()
    }

    fn best_attitudes(&self, count: usize) -> Option<Vec<NextAttitude>> {
        if self.attitudes_given || self.effective.is_some() || self.beyond.is_some() {
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
        let normal = DegreesOfFreedom::INFINITE.coverage_factor(self.probability);
        let factor = |more: usize| {
            let nu = (self.degrees_of_freedom + more) as f64;
            if self.excess > 0.0 && self.degrees_of_freedom > 0 {
                DegreesOfFreedom::new(nu).map_or(normal, |nu| nu.coverage_factor(self.probability))
            } else {
                normal
            }
        };
        let k = self.sensor.k().0;
        let common: Vec<f64> = (0..p)
            .map(|c| {
                let unit = match c {
                    0..3 => k[c][c] * g,
                    _ => match self.model.free_elements()[c - 3] {
                        (i, j) if i == j => k[i][i],
                        _ => 1.0,
                    },
                };
                normal.powi(2) * self.common_variance(self.model.parameter_name(c)) / unit.powi(2)
            })
            .collect();
        let mut now: Option<Vec<f64>> = None;
        let mut next = Vec::with_capacity(count);
        for taken in 1..=count {
            let mut factors = information.clone();
            cholesky(&mut factors, p)?;
            let variances: Vec<f64> = (0..p)
                .map(|c| {
                    let mut column = vec![0.0; p];
                    column[c] = 1.0;
                    solve(&factors, &mut column);
                    column[c]
                })
                .collect();
            let before = now.get_or_insert_with(|| {
                let scatter = variances.iter().map(|v| factor(0).powi(2) * v);
                scatter.zip(&common).map(|(s, c)| s + c).collect()
            });
            let (direction, _) = spiral(CANDIDATES)
                .map(|n| {
                    let r = row(n);
                    let mut c = r.clone();
                    solve(&factors, &mut c);
                    let along: f64 = r.iter().zip(&c).map(|(a, b)| a * b).sum();
                    let squares: f64 = c.iter().map(|v| v * v).sum();
                    (n, squares / (typical + along))
                })
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            let r = row(direction);
            let mut along = r.clone();
            solve(&factors, &mut along);
            let rest = typical + r.iter().zip(&along).map(|(a, b)| a * b).sum::<f64>();
            let shares = (0..p).map(|c| {
                let left = (variances[c] - along[c].powi(2) / rest).max(0.0);
                (factor(taken).powi(2) * left + common[c]) / before[c]
            });
            next.push(NextAttitude {
                direction,
                expected: (shares.sum::<f64>() / p as f64).sqrt(),
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
                    force_uncertainty: None,
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
        assert_eq!(fit.limiting(), super::Limiting::Between);
        // A gravity that is hardly known lies under every scale factor, whatever is recorded.
        let fit = MultiPosition::new(Gravity::given(9.81, 0.05).unwrap())
            .nominal_sensitivity(1.0)
            .output_unit("m/s²")
            .fit(&poses)
            .unwrap();
        let told = fit.next_attitudes(4);
        assert!(told[3].expected > next[3].expected + 0.02, "{told:?}");
    }
}
