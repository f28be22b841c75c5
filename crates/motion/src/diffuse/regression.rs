//! Further regressors of the readings: what repeats with the position, beside the unknown constants.

use super::{
    COLUMNS, DATA, GAIN, Noise, Prepared, Seen, Solution, System, Unknowns, columns, solve, system,
};
use std::array::from_fn;

/// Most regressors of one pass.
pub(crate) const REGRESSORS: usize = 18;

const ALL: usize = COLUMNS + REGRESSORS;

/// Coefficients of the regressors by least squares, the constants found with them.
#[derive(Clone, Debug)]
pub(crate) struct Regressed {
    /// One for each regressor.
    pub coefficients: Vec<f64>,
    /// Their covariance for the noise of the pass.
    pub covariance: Vec<Vec<f64>>,
}

impl Prepared<'_> {
    /// Generalised least squares of the readings on regressors, one value per sample each.
    ///
    /// Every regressor runs through the filter as the data do; the innovations of both are independent, so that
    /// ordinary least squares of them is the best estimate. `None` where the readings do not tell them apart.
    pub(crate) fn regress(
        &self,
        noise: &Noise,
        unknowns: Unknowns,
        regressors: &[Vec<f64>],
    ) -> Option<Regressed> {
        let source = self.record.source;
        let time = self.record.sample_time;
        match 2 + usize::from(noise.walk.is_some()) + usize::from(noise.colour.is_some()) {
            2 => self.regress_in(&system::<2>(noise, source, time), unknowns, regressors),
            3 => self.regress_in(&system::<3>(noise, source, time), unknowns, regressors),
            _ => self.regress_in(&system::<4>(noise, source, time), unknowns, regressors),
        }
    }

    fn regress_in<const N: usize>(
        &self,
        system: &System<N>,
        unknowns: Unknowns,
        regressors: &[Vec<f64>],
    ) -> Option<Regressed> {
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
                system.advance(&mut state, self, k, active);
                for m in &mut further[..count] {
                    *m = system.carried(m);
                }
            }
            let Some(reading) = reading else { continue };
            // The gain of the data, before their covariance is updated.
            let column = system.column(&state.p);
            let Seen { e, s } = system.observe(&mut state, reading - self.first, active);
            let gain: [f64; N] = from_fn(|i| column[i] / s);
            let mut all = [0.0; ALL];
            all[..active].copy_from_slice(&e[..active]);
            for (j, m) in further[..count].iter_mut().enumerate() {
                // The reading is the position plus the regressor times its coefficient.
                let innovation = -regressors[j][k] - system.shown(m);
                for i in 0..N {
                    m[i] += gain[i] * innovation;
                }
                all[COLUMNS + j] = innovation;
            }
            for i in 0..COLUMNS + count {
                let scaled = all[i] / s;
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
        let constants = columns(self.record, unknowns);
        let from = constants.len();
        let wanted = constants
            .into_iter()
            .chain((0..count).map(|j| COLUMNS + j))
            .collect();
        let Solution {
            beta, covariance, ..
        } = solve(&g, wanted)?;
        debug_assert_eq!(DATA, 0);
        Some(Regressed {
            coefficients: beta[from..].to_vec(),
            covariance: covariance[from..]
                .iter()
                .map(|row| row[from..].to_vec())
                .collect(),
        })
    }
}

impl<const N: usize> System<N> {
    /// F m.
    fn carried(&self, m: &[f64; N]) -> [f64; N] {
        from_fn(|i| (0..N).map(|j| self.f[i][j] * m[j]).sum())
    }
}
