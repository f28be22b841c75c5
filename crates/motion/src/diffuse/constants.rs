//! Unknown constants by least squares: start, offset, gain, latency.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use super::{
    COLUMNS, DATA, GAIN, LATENCY, OFFSET, PARABOLA, RAMP, START_POSITION, START_VELOCITY, Unknowns,
};
use crate::{MotionRecord, ReadingSource};
use proofmass_uncertainty::adjustment::ScaledRoot;
use std::f64::consts::TAU;

/// Sums of a pass: everything the likelihood of any subset of the constants needs.
pub(crate) struct Sums {
    /// Number of readings.
    pub(crate) n: usize,
    /// Σ ln S.
    pub(crate) logs: f64,
    /// Σ e eᵀ/S over the columns.
    pub(super) g: [[f64; COLUMNS]; COLUMNS],
}

/// The constants of a subset by least squares.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Columns that were solved for.
    pub(super) columns: Vec<usize>,
    /// Their values.
    pub(super) beta: Vec<f64>,
    /// Their covariance for the noise of the pass.
    pub(super) covariance: Vec<Vec<f64>>,
    /// Σ e²/S that is left.
    pub(crate) rss: f64,
}

impl Solution {
    pub(super) fn of(&self, column: usize) -> Option<(f64, f64)> {
        let i = self.columns.iter().position(|c| *c == column)?;
        Some((self.beta[i], self.covariance[i][i].sqrt()))
    }

    /// Offset of the accelerometer (at the start, where it walks) and its standard uncertainty.
    pub fn offset(&self) -> Option<(f64, f64)> {
        self.of(OFFSET)
    }

    /// Slope of the offset over time and its standard uncertainty, where it may have one.
    pub fn ramp(&self) -> Option<(f64, f64)> {
        self.of(RAMP)
    }

    /// Bend of the offset over time and its standard uncertainty, where it may have one.
    pub fn parabola(&self) -> Option<(f64, f64)> {
        self.of(PARABOLA)
    }

    /// γ in a = (1 − γ) · reading, and its standard uncertainty.
    pub fn gain(&self) -> Option<(f64, f64)> {
        self.of(GAIN)
    }

    /// Time by which the accelerometer is late, and its standard uncertainty.
    pub fn latency(&self) -> Option<(f64, f64)> {
        self.of(LATENCY)
    }

    /// The covariance for noise of a common factor times that of the pass.
    pub fn scale(&mut self, factor: f64) {
        self.covariance
            .iter_mut()
            .flatten()
            .for_each(|c| *c *= factor);
    }

    /// Multiplies the covariance of gain and latency; a gain that is held by `held` is never less certain than that.
    pub fn widen(&mut self, factor: f64, held: Option<f64>) {
        let mut root = factor.sqrt();
        if let (Some(held), Some((_, u))) = (held, self.gain()) {
            root = root.min((held / u).max(1.0));
        }
        for (i, a) in self.columns.iter().enumerate() {
            for (j, b) in self.columns.iter().enumerate() {
                for c in [a, b] {
                    if matches!(*c, GAIN | LATENCY) {
                        self.covariance[i][j] *= root;
                    }
                }
            }
        }
    }
}

impl Sums {
    /// Least squares for a subset; `None` when the readings do not determine it. A stated uncertainty of the gain or of the
    /// start is one more reading of it.
    pub fn solve(&self, record: &MotionRecord, unknowns: Unknowns) -> Option<Solution> {
        self.solve_held(record, unknowns, 1.0)
    }

    /// The same for variances of a common factor times those of the pass, in the unit of the pass.
    fn solve_held(
        &self,
        record: &MotionRecord,
        unknowns: Unknowns,
        factor: f64,
    ) -> Option<Solution> {
        let mut g = self.g;
        for (column, u) in held(record, unknowns) {
            g[column][column] += factor / (u * u);
        }
        solve(&g, columns(record, unknowns))
    }

    /// Least squares for a subset with the common factor of at least `least` at which ln L is largest, ln L there, and the
    /// factor.
    pub fn solve_concentrated(
        &self,
        record: &MotionRecord,
        unknowns: Unknowns,
        least: f64,
    ) -> Option<(Solution, f64, f64)> {
        let mut solution = self.solve_held(record, unknowns, 0.0)?;
        let (mut value, mut factor) = self.concentrated(solution.rss, 0.0, least);
        let holds = held(record, unknowns);
        if !holds.is_empty() {
            // What holds a constant counts in the unit of the pass, which follows from what is left of the readings.
            for _ in 0..4 {
                solution = self.solve_held(record, unknowns, factor)?;
                let square = |&(column, u): &(usize, f64)| {
                    let found = solution.of(column).map_or(0.0, |(value, _)| value / u);
                    found * found
                };
                let held: f64 = holds.iter().map(square).sum();
                let left = (solution.rss - factor * held).max(0.0);
                (value, factor) = self.concentrated(left, held, least);
            }
        }
        solution.scale(factor);
        Some((solution, value, factor))
    }

    /// ln L with every variance as it was in the pass.
    pub fn log_likelihood(&self, solution: &Solution) -> f64 {
        -0.5 * (self.logs + solution.rss + self.n as f64 * TAU.ln())
    }

    /// ln L at its maximum over a common factor of all variances of at least `least`, and that factor. `held` is the square
    /// of the gain and of the start over their stated uncertainties, which no factor of the noise moves.
    fn concentrated(&self, rss: f64, held: f64, least: f64) -> (f64, f64) {
        let n = self.n as f64;
        let factor = (rss / n).max(least);
        let value = -0.5 * (self.logs + n * factor.ln() + rss / factor + held + n * TAU.ln());
        (value, factor)
    }
}

/// Standard uncertainty of a start that is stated as not exact.
fn held_start(record: &MotionRecord) -> Option<f64> {
    let u = record.initial_velocity_uncertainty;
    record.initial_velocity.map(|_| u).filter(|u| *u > 0.0)
}

/// The constants of a subset that a stated uncertainty holds, each by one more reading of it.
fn held(record: &MotionRecord, unknowns: Unknowns) -> Vec<(usize, f64)> {
    let gain = record.gain_uncertainty.filter(|_| unknowns.gain);
    let gain = gain.map(|u| (GAIN, u));
    let start = held_start(record).map(|u| (START_VELOCITY, u));
    gain.into_iter().chain(start).collect()
}

/// The columns of a subset: always the start, as far as it is unknown.
pub(super) fn columns(record: &MotionRecord, unknowns: Unknowns) -> Vec<usize> {
    [
        (
            START_VELOCITY,
            record.initial_velocity.is_none() || held_start(record).is_some(),
        ),
        (START_POSITION, record.source == ReadingSource::Position),
        (OFFSET, unknowns.offset),
        (GAIN, unknowns.gain),
        (LATENCY, unknowns.latency),
        (RAMP, unknowns.offset && record.given_back.is_some()),
        (
            PARABOLA,
            unknowns.offset && record.behind_two_stages().is_some(),
        ),
    ]
    .into_iter()
    .filter_map(|(column, wanted)| wanted.then_some(column))
    .collect()
}

/// How many columns run where these are wanted: the data's, and all up to the last.
pub(super) fn active(columns: &[usize]) -> usize {
    columns.iter().copied().max().unwrap_or(DATA) + 1
}

/// β = −A⁻¹ G_c0 with A = G_cc by Cholesky, after its diagonal was scaled to one.
pub(super) fn solve<const C: usize>(g: &[[f64; C]; C], columns: Vec<usize>) -> Option<Solution> {
    let m = columns.len();
    let root = ScaledRoot::new(m, |i, j| g[columns[i]][columns[j]])?;
    let scale = &root.scale;
    let forward = |mut x: Vec<f64>| {
        root.forward(&mut x);
        x
    };
    let backward = |mut x: Vec<f64>| {
        root.backward(&mut x);
        x
    };
    let right: Vec<f64> = (0..m).map(|i| g[columns[i]][DATA] * scale[i]).collect();
    let half = forward(right);
    let rss = (g[DATA][DATA] - half.iter().map(|x| x * x).sum::<f64>()).max(0.0);
    let beta = backward(half)
        .iter()
        .zip(scale)
        .map(|(x, s)| -x * s)
        .collect();
    let covariance = (0..m)
        .map(|j| {
            let unit = (0..m).map(|i| f64::from(u8::from(i == j))).collect();
            let column = backward(forward(unit));
            (0..m).map(|i| column[i] * scale[i] * scale[j]).collect()
        })
        .collect();
    Some(Solution {
        columns,
        beta,
        covariance,
        rss,
    })
}
