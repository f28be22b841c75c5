//! Further regressors of the readings: what repeats with the position, beside the unknown constants.

use super::constants::{Solution, columns, solve};
use super::system::{Seen, System};
use super::{COLUMNS, GAIN, LATENCY, Noise, Prepared, Unknowns};
use proofmass_core::state_space::predict;
use std::array::from_fn;

/// Most regressors of one pass.
pub(crate) const REGRESSORS: usize = 18;

const ALL: usize = COLUMNS + REGRESSORS;

/// Coefficients of the regressors by least squares, the constants found with them.
#[derive(Clone, Debug)]
pub(crate) struct Regressed {
    /// One for each regressor.
    pub(crate) coefficients: Vec<f64>,
    /// Their covariance for the noise of the pass.
    pub(crate) covariance: Vec<Vec<f64>>,
}

/// Normal equations of stretches of one record: gain, latency and regressors are common to them, start and offset are of
/// each stretch alone.
#[derive(Clone, Debug)]
pub(crate) struct Regression {
    g: [[f64; ALL]; ALL],
    count: usize,
}

impl Regression {
    /// Of no stretch yet, for so many regressors.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            g: [[0.0; ALL]; ALL],
            count: count.min(REGRESSORS),
        }
    }

    /// Takes in a stretch; every regressor has one value for each of its samples.
    ///
    /// Every regressor runs through the filter as the data do; the innovations of both are independent, so that
    /// ordinary least squares of them is the best estimate.
    pub(crate) fn add(
        &mut self,
        stretch: &Prepared<'_>,
        noise: &Noise,
        unknowns: Unknowns,
        regressors: &[&[f64]],
    ) {
        let mut g = with_states!(noise, stretch.record, |s| {
            stretch.normal(&s, unknowns, regressors)
        });
        let own = Unknowns {
            gain: false,
            latency: false,
            ..unknowns
        };
        let before: [f64; ALL] = from_fn(|i| g[i][i]);
        for c in columns(stretch.record, own) {
            // Below it a column is a copy of those taken out before, to the last digits: it tells nothing more.
            let told = g[c][c] > 1e-13 * before[c] && before[c].is_finite();
            eliminate(&mut g, c, told);
        }
        for (sum, row) in self.g.iter_mut().zip(&g) {
            for (s, x) in sum.iter_mut().zip(row) {
                *s += x;
            }
        }
    }

    /// Coefficients of the regressors; `None` where the readings do not tell them apart.
    pub(crate) fn solve(&self, unknowns: Unknowns) -> Option<Regressed> {
        let common = [(GAIN, unknowns.gain), (LATENCY, unknowns.latency)];
        let common = common.into_iter().filter(|c| c.1).map(|c| c.0);
        let wanted: Vec<usize> = common.chain((0..self.count).map(|j| COLUMNS + j)).collect();
        let from = wanted.len() - self.count;
        let Solution {
            beta, covariance, ..
        } = solve(&self.g, wanted)?;
        Some(Regressed {
            coefficients: beta[from..].to_vec(),
            covariance: covariance[from..]
                .iter()
                .map(|row| row[from..].to_vec())
                .collect(),
        })
    }
}

/// Takes an unknown out of the normal equations: by least squares where they tell it.
fn eliminate(g: &mut [[f64; ALL]; ALL], c: usize, told: bool) {
    let row = g[c];
    if told {
        for other in g.iter_mut() {
            let factor = other[c] / row[c];
            for (x, r) in other.iter_mut().zip(&row) {
                *x -= factor * r;
            }
        }
    }
    g[c] = [0.0; ALL];
    for other in g.iter_mut() {
        other[c] = 0.0;
    }
}

impl Prepared<'_> {
    fn normal<const N: usize>(
        &self,
        system: &System<N>,
        unknowns: Unknowns,
        regressors: &[&[f64]],
    ) -> [[f64; ALL]; ALL] {
        let count = regressors.len().min(REGRESSORS);
        let active = match unknowns.gain || unknowns.latency {
            true => COLUMNS,
            false => GAIN,
        };
        let mut state = system.start(self.record);
        let mut further = [[0.0; N]; REGRESSORS];
        let mut g = [[0.0; ALL]; ALL];
        for (k, reading) in self.record.reading.iter().enumerate() {
            if k > 0 {
                system.predict(&mut state, self, k, active);
                for m in &mut further[..count] {
                    *m = predict(&system.f, m, [0.0; N]);
                }
            }
            let Some(reading) = reading else { continue };
            let Seen { e, gain } = system.update(&mut state, reading - self.first, active);
            let mut all = [0.0; ALL];
            all[..active].copy_from_slice(&e[..active]);
            for (j, m) in further[..count].iter_mut().enumerate() {
                // The reading is the position plus the regressor times its coefficient.
                let innovation = -regressors[j][k] - system.reading.of(m);
                gain.correct(m, innovation);
                all[COLUMNS + j] = innovation;
            }
            for i in 0..COLUMNS + count {
                let scaled = all[i] / gain.variance;
                for j in 0..=i {
                    g[i][j] += scaled * all[j];
                }
            }
        }
        for i in 0..ALL {
            for j in 0..i {
                g[j][i] = g[i][j];
            }
        }
        g
    }
}
