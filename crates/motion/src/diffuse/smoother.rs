//! The smoother of the data and of every column.

use super::constants::{Solution, active};
use super::system::{Seen, State, System};
use super::{COLUMNS, DATA, Noise, OFFSET, Prepared, Trajectory, total};
use proofmass_core::Error;
use proofmass_core::state_space::Adjoint;
use std::array::from_fn;

impl Prepared<'_> {
    /// Every estimate uses all readings.
    ///
    /// [`Adjoint`] goes back over the filter, the columns with their common Λ.
    ///
    /// # Errors
    /// [`Error::NotFinite`] when the arithmetic overflowed.
    ///
    /// **Source** `[DeJong91]`.
    pub fn smooth(&self, noise: &Noise, solution: &Solution) -> Result<Trajectory, Error> {
        with_states!(noise, self.record, |s| {
            self.smooth_of(&s, solution, noise.walk.is_some())
        })
    }

    fn smooth_of<const N: usize>(
        &self,
        system: &System<N>,
        solution: &Solution,
        walk: bool,
    ) -> Result<Trajectory, Error> {
        let n = self.record.reading.len();
        let active = active(&solution.columns);
        let mut state = system.start(self.record);
        let mut prior = Vec::with_capacity(n);
        let mut seen = Vec::with_capacity(n);
        for (k, reading) in self.record.reading.iter().enumerate() {
            if k > 0 {
                system.predict(&mut state, self, k, active);
            }
            prior.push(state);
            seen.push(reading.map(|r| system.update(&mut state, r - self.first, active)));
        }
        let used: Vec<usize> = std::iter::once(DATA)
            .chain(solution.columns.iter().copied())
            .collect();
        let mut after = Adjoint::<f64, N, COLUMNS>::default();
        let (mut velocity, mut uncertainty) = (vec![0.0; n], vec![0.0; n]);
        let mut offset = solution.offset().map(|_| (vec![0.0; n], vec![0.0; n]));
        for k in (0..n).rev() {
            let State { m, p } = &prior[k];
            if let Some(Seen { e, gain }) = &seen[k] {
                let e: [f64; COLUMNS] = from_fn(|i| used.get(i).map_or(0.0, |c| e[*c]));
                after.update(gain, &e[..used.len()]);
            }
            let at = |state: usize| {
                let smoothed = |i: usize| after.value(i, state, &m[used[i]], p);
                let others: Vec<f64> = (1..used.len()).map(smoothed).collect();
                (smoothed(0), after.variance(state, p), others)
            };
            let (v, variance, others) = at(1);
            (velocity[k], uncertainty[k]) = spread(v, variance, &others, solution);
            if let Some((value, u)) = &mut offset {
                let (own, variance, mut others) = if walk {
                    at(2)
                } else {
                    (0.0, 0.0, vec![0.0; solution.columns.len()])
                };
                for (other, c) in others.iter_mut().zip(&solution.columns) {
                    *other += f64::from(u8::from(*c == OFFSET));
                }
                (value[k], u[k]) = spread(own, variance, &others, solution);
            }
            after.predict(&system.f, used.len());
        }
        let bad = |k: &usize| !(velocity[*k].is_finite() && uncertainty[*k].is_finite());
        if let Some(index) = (0..n).find(bad) {
            return Err(Error::NotFinite {
                name: "smoothed velocity",
                index,
            });
        }
        Ok(Trajectory {
            velocity,
            uncertainty,
            offset,
            innovations: seen
                .iter()
                .map(|seen| seen.map(|Seen { e, gain }| total(&e, solution) / gain.variance.sqrt()))
                .collect(),
        })
    }
}

/// Value and standard uncertainty from the data's own value and variance and the sensitivities to the constants.
pub(super) fn spread(
    value: f64,
    variance: f64,
    sensitivity: &[f64],
    solution: &Solution,
) -> (f64, f64) {
    let constants = sensitivity.iter().zip(&solution.beta);
    let value = value + constants.map(|(c, b)| c * b).sum::<f64>();
    let mut variance = variance;
    for (i, a) in sensitivity.iter().enumerate() {
        for (j, b) in sensitivity.iter().enumerate() {
            variance += a * b * solution.covariance[i][j];
        }
    }
    (value, variance.max(0.0).sqrt())
}
