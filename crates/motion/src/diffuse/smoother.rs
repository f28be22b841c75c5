//! The smoother of the data and of every column.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use super::constants::Solution;
use super::system::{Seen, State, System};
use super::{COLUMNS, DATA, Noise, OFFSET, Prepared, Trajectory, total};
use proofmass_core::Error;

impl Prepared<'_> {
    /// Every estimate uses all readings.
    ///
    /// Bryson and Frazier's modified form, for every column with the common Λ: λ̃ = −hᵀe/S + (I − K h)ᵀλ̂,
    /// λ̂ = Fᵀλ̃, x_s = x⁻ − P⁻λ̃, P_s = P⁻ − P⁻Λ̃P⁻.
    ///
    /// # Errors
    /// [`Error::NotFinite`] when the arithmetic overflowed.
    ///
    /// **Source** `[Bierman73]`, `[DeJong91]`.
    pub fn smooth(&self, noise: &Noise, solution: &Solution) -> Result<Trajectory, Error> {
        with_states!(noise, self.record.source, self.record.sample_time, |s| self
            .smooth_of(&s, solution, noise.walk.is_some()))
    }

    fn smooth_of<const N: usize>(
        &self,
        system: &System<N>,
        solution: &Solution,
        walk: bool,
    ) -> Result<Trajectory, Error> {
        let n = self.record.reading.len();
        let last = solution.columns.iter().copied().max().unwrap_or(DATA);
        let active = last + 1;
        let mut state = system.start(self.record);
        let mut prior = Vec::with_capacity(n);
        let mut seen = Vec::with_capacity(n);
        for (k, reading) in self.record.reading.iter().enumerate() {
            if k > 0 {
                system.advance(&mut state, self, k, active);
            }
            prior.push(state);
            seen.push(reading.map(|r| system.observe(&mut state, r - self.first, active)));
        }
        let used: Vec<usize> = std::iter::once(DATA)
            .chain(solution.columns.iter().copied())
            .collect();
        let mut vector = [[0.0; N]; COLUMNS];
        let mut matrix = [[0.0; N]; N];
        let (mut velocity, mut uncertainty) = (vec![0.0; n], vec![0.0; n]);
        let mut offset = solution.offset().map(|_| (vec![0.0; n], vec![0.0; n]));
        for k in (0..n).rev() {
            let State { m, p } = &prior[k];
            if let Some(Seen { e, s }) = seen[k] {
                let gain = system.column(p).map(|x| x / s);
                // (I − K h)ᵀ x = x − hᵀ (K · x).
                let reduce = |x: &mut [f64; N]| {
                    let dot: f64 = (0..N).map(|i| gain[i] * x[i]).sum();
                    x[system.at] -= dot;
                    if system.colour {
                        x[N - 1] -= dot;
                    }
                };
                for &c in &used {
                    reduce(&mut vector[c]);
                    vector[c][system.at] -= e[c] / s;
                    if system.colour {
                        vector[c][N - 1] -= e[c] / s;
                    }
                }
                for row in &mut matrix {
                    reduce(row);
                }
                for j in 0..N {
                    let mut column: [f64; N] = std::array::from_fn(|i| matrix[i][j]);
                    reduce(&mut column);
                    for i in 0..N {
                        matrix[i][j] = column[i];
                    }
                }
                let h = |i: usize| i == system.at || (system.colour && i == N - 1);
                for i in (0..N).filter(|i| h(*i)) {
                    for j in (0..N).filter(|j| h(*j)) {
                        matrix[i][j] += 1.0 / s;
                    }
                }
            }
            let at = |component: usize| {
                let row = &p[component];
                let smoothed = |c: usize| {
                    let change: f64 = (0..N).map(|j| row[j] * vector[c][j]).sum();
                    m[c][component] - change
                };
                let mut variance = row[component];
                for i in 0..N {
                    for j in 0..N {
                        variance -= row[i] * matrix[i][j] * row[j];
                    }
                }
                // A difference of doubles resolves no less of what it is taken from.
                let variance = variance.max(1e-12 * row[component]);
                let others: Vec<f64> = solution.columns.iter().map(|c| smoothed(*c)).collect();
                (smoothed(DATA), variance, others)
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
            // λ̂ = Fᵀ λ̃, Λ̂ = Fᵀ Λ̃ F
            let f = &system.f;
            for &c in &used {
                let x = vector[c];
                vector[c] = std::array::from_fn(|i| (0..N).map(|l| f[l][i] * x[l]).sum());
            }
            let mut half = [[0.0; N]; N];
            for i in 0..N {
                for j in 0..N {
                    half[i][j] = (0..N).map(|l| matrix[i][l] * f[l][j]).sum();
                }
            }
            for i in 0..N {
                for j in 0..N {
                    matrix[i][j] = (0..N).map(|l| f[l][i] * half[l][j]).sum();
                }
            }
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
                .map(|seen| seen.map(|Seen { e, s }| total(&e, solution) / s.sqrt()))
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
