//! What the runs tell of the mounting, and what no run can.

use super::FrequencyFit;
use crate::adjustment::Adjustment;
use crate::budget::Budget;
use crate::matrix::AXES;
use faer::Mat;
use proofmass_uncertainty::algebra::symmetric_eigenvalues;
use serde::Serialize;

/// What the runs tell of the mounting, and what no run can.
///
/// A small turn θ of the frame of the device, d → d + d × θ, and S → S + \[θ\]× S give the same outputs at any number of
/// runs and frequencies: three turns are told by the declared uncertainties alone. What they do not change, the angles
/// between the sensitive axes, the runs do tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Identifiability {
    /// Angles of each input of the budget.
    pub inputs: Vec<AngleInformation>,
    /// Directions among all angles by λ, the information of the runs over that of the declaration: above 10, 1 to 10,
    /// 0.1 to 1, 0.01 to 0.1 and below.
    pub directions: [usize; 5],
    /// Turns of the device about its axes x, y, z.
    pub turns: Vec<FrameTurn>,
}

/// Angles of one input of the budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AngleInformation {
    /// Key of the input.
    pub key: String,
    /// Number of angles.
    pub count: usize,
    /// Degrees of freedom that the runs have for them, Σ λ/(1 + λ): of `count`, so many are told by the runs.
    pub freedom: f64,
    /// Declared standard uncertainty, rad.
    pub declared: f64,
    /// Root mean square of the standard uncertainties after the runs, rad.
    pub after: f64,
}

/// A turn of the device about one of its axes, at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FrameTurn {
    /// Frequency in Hz.
    pub frequency: f64,
    /// The axis.
    pub about: String,
    /// Standard uncertainty of the turn, ½ (S_ik/S_kk − S_ki/S_ii), rad: what the declaration says, and no run.
    pub turn: f64,
    /// Standard uncertainty of the departure of the two sensitive axes from a right angle, ½ (S_ik/S_kk + S_ki/S_ii), rad.
    pub right_angle: f64,
}

impl Identifiability {
    /// `None` without an angle in the budget.
    pub(super) fn new(
        adjustment: &Adjustment,
        frequencies: &[FrequencyFit],
        budget: &Budget,
    ) -> Option<Self> {
        let offset = adjustment.first_draw();
        let of_input = |d: usize| adjustment.draws[d].input.map(|k| &budget.inputs[k]);
        let angles: Vec<usize> = (0..adjustment.draws.len())
            .filter(|&d| of_input(d).is_some_and(|i| i.acts.is_angle()))
            .collect();
        if angles.is_empty() {
            return None;
        }
        let c = Mat::from_fn(angles.len(), angles.len(), |i, j| {
            adjustment.covariance(offset + angles[i], offset + angles[j])
        });
        let mut directions = [0; 5];
        if let Ok(eigen) = symmetric_eigenvalues(&c, "eigenvalues of the angles") {
            for c in eigen {
                let lambda = (1.0 / c.max(1e-300) - 1.0).max(0.0);
                let place = [10.0, 1.0, 0.1, 0.01]
                    .iter()
                    .take_while(|&&limit| lambda <= limit)
                    .count();
                directions[place] += 1;
            }
        }
        let inputs = budget
            .inputs
            .iter()
            .enumerate()
            .filter_map(|(index, input)| {
                let own: Vec<f64> = angles
                    .iter()
                    .filter(|&&d| adjustment.draws[d].input == Some(index))
                    .map(|&d| adjustment.covariance(offset + d, offset + d))
                    .collect();
                let count = own.len();
                let left: f64 = own.iter().sum();
                let declared = input.standard_uncertainty();
                (count > 0).then(|| AngleInformation {
                    key: input.key.clone(),
                    count,
                    freedom: (count as f64 - left).max(0.0),
                    declared,
                    after: declared * (left / count as f64).sqrt(),
                })
            })
            .collect();
        Some(Self {
            inputs,
            directions,
            turns: frequencies.iter().flat_map(turns).collect(),
        })
    }

    /// Number of angles.
    pub fn count(&self) -> usize {
        self.inputs.iter().map(|i| i.count).sum()
    }

    /// Degrees of freedom that the runs have for all of them.
    pub fn freedom(&self) -> f64 {
        self.inputs.iter().map(|i| i.freedom).sum()
    }
}

/// θ_x turns S_yz and S_zy, θ_y S_zx and S_xz, θ_z S_xy and S_yx.
fn turns(f: &FrequencyFit) -> Vec<FrameTurn> {
    (0..3)
        .filter_map(|about| {
            let (i, k) = ((about + 1) % 3, (about + 2) % 3);
            let s = &f.sensitivity;
            let of = |sign: f64| {
                let mut v = 0.0;
                // Real parts of S_ik/S_kk and S_ki/S_ii; their denominators are the main terms, known far better.
                let parts = [
                    (3 * i + k, s[k][k].inv() * 0.5),
                    (3 * k + i, s[i][i].inv() * 0.5 * sign),
                ];
                let gradient: Vec<(usize, f64)> = parts
                    .iter()
                    .flat_map(|(term, g)| [(2 * term, g.re), (2 * term + 1, -g.im)])
                    .collect();
                let covariance = f.estimate.covariance();
                for (p, a) in &gradient {
                    for (q, b) in &gradient {
                        v += a * b * covariance[(*p, *q)];
                    }
                }
                v.max(0.0).sqrt()
            };
            let finite = s[i][i].norm() > 0.0 && s[k][k].norm() > 0.0;
            finite.then(|| FrameTurn {
                frequency: f.frequency,
                about: AXES[about].to_owned(),
                turn: of(-1.0),
                right_angle: of(1.0),
            })
        })
        .collect()
}
