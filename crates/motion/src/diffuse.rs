//! Likelihood, filter and smoother with constants of which nothing is known before: the start, and offset, gain and
//! latency of the accelerometer.
//!
//! Each unknown constant is a column that runs through the same recursion as the data, with the same gains; what they
//! are worth follows from the innovations by least squares. No start variance has to be invented, so that the scale of
//! the noise and an offset of 9.81 m/s² do not meet.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

mod regression;

pub(crate) use regression::{REGRESSORS, Regression};

use crate::filtering::{component, step_inputs};
use crate::{KalmanModel, MotionRecord, ProcessNoise, ReadingSource};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Which constants of the accelerometer are unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unknowns {
    /// A constant is added to its readings.
    pub offset: bool,
    /// Its gain is not one.
    pub gain: bool,
    /// It is later than the readings by a constant time.
    pub latency: bool,
}

/// A part of the readings' error that is correlated in time: a first-order Gauss–Markov process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColouredNoise {
    /// Standard deviation, in the unit of the readings.
    pub deviation: f64,
    /// Correlation time, s.
    pub time: f64,
}

/// Noise of an axis without any start: what the likelihood is a function of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// q after `form`.
    pub q: f64,
    pub form: ProcessNoise,
    /// White part of a reading.
    pub r: f64,
    /// Density of the walk of the offset.
    pub walk: Option<f64>,
    /// Variance and correlation time of the coloured part of a reading.
    pub colour: Option<(f64, f64)>,
}

impl Noise {
    /// The same gains with every variance multiplied.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            q: self.q * factor,
            r: self.r * factor,
            walk: self.walk.map(|s| s * factor),
            colour: self.colour.map(|(v, t)| (v * factor, t)),
            ..self
        }
    }
}

/// Number of columns: the data, and five constants.
const COLUMNS: usize = 6;
const DATA: usize = 0;
const START_VELOCITY: usize = 1;
const START_POSITION: usize = 2;
const OFFSET: usize = 3;
const GAIN: usize = 4;
const LATENCY: usize = 5;

/// A record made ready for many passes.
pub(crate) struct Prepared<'a> {
    record: &'a MotionRecord,
    /// What the acceleration does to position and velocity over the step to each sample.
    steps: Vec<[f64; 2]>,
    first: f64,
}

/// Sums of a pass: everything the likelihood of any subset of the constants needs.
pub(crate) struct Sums {
    /// Number of readings.
    pub n: usize,
    /// Σ ln S.
    pub logs: f64,
    /// Σ e eᵀ/S over the columns.
    g: [[f64; COLUMNS]; COLUMNS],
}

/// The constants of a subset by least squares.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Columns that were solved for.
    columns: Vec<usize>,
    /// Their values.
    beta: Vec<f64>,
    /// Their covariance for the noise of the pass.
    covariance: Vec<Vec<f64>>,
    /// Σ e²/S that is left.
    pub rss: f64,
}

impl Solution {
    fn of(&self, column: usize) -> Option<(f64, f64)> {
        let i = self.columns.iter().position(|c| *c == column)?;
        Some((self.beta[i], self.covariance[i][i].sqrt()))
    }

    /// Offset of the accelerometer (at the start, where it walks) and its standard uncertainty.
    pub fn offset(&self) -> Option<(f64, f64)> {
        self.of(OFFSET)
    }

    /// γ in a = (1 − γ) · reading, and its standard uncertainty.
    pub fn gain(&self) -> Option<(f64, f64)> {
        self.of(GAIN)
    }

    /// Time by which the accelerometer is late, and its standard uncertainty.
    pub fn latency(&self) -> Option<(f64, f64)> {
        self.of(LATENCY)
    }

    /// Multiplies the covariance of gain and latency.
    pub fn widen(&mut self, factor: f64) {
        let root = factor.sqrt();
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
    /// Least squares for a subset; `None` when the readings do not determine it.
    pub fn solve(&self, record: &MotionRecord, unknowns: Unknowns) -> Option<Solution> {
        solve(&self.g, columns(record, unknowns))
    }

    /// ln L with every variance as it was in the pass.
    pub fn log_likelihood(&self, solution: &Solution) -> f64 {
        -0.5 * (self.logs + solution.rss + self.n as f64 * TAU.ln())
    }

    /// ln L at its maximum over a common factor of all variances of at least `least`, and that factor.
    pub fn concentrated(&self, solution: &Solution, least: f64) -> (f64, f64) {
        let n = self.n as f64;
        let factor = (solution.rss / n).max(least);
        let value = -0.5 * (self.logs + n * factor.ln() + solution.rss / factor + n * TAU.ln());
        (value, factor)
    }
}

/// The columns of a subset: always the start, as far as it is unknown.
fn columns(record: &MotionRecord, unknowns: Unknowns) -> Vec<usize> {
    [
        (START_VELOCITY, record.initial_velocity.is_none()),
        (START_POSITION, record.source == ReadingSource::Position),
        (OFFSET, unknowns.offset),
        (GAIN, unknowns.gain),
        (LATENCY, unknowns.latency),
    ]
    .into_iter()
    .filter_map(|(column, wanted)| wanted.then_some(column))
    .collect()
}

/// β = −A⁻¹ G_c0 with A = G_cc by Cholesky, after its diagonal was scaled to one.
fn solve<const C: usize>(g: &[[f64; C]; C], columns: Vec<usize>) -> Option<Solution> {
    let m = columns.len();
    let mut scale = Vec::with_capacity(m);
    for &c in &columns {
        let d = g[c][c];
        if !(d > 0.0 && d.is_finite()) {
            return None;
        }
        scale.push(1.0 / d.sqrt());
    }
    let mut l = [[0.0; C]; C];
    for i in 0..m {
        for j in 0..=i {
            let mut sum = g[columns[i]][columns[j]] * scale[i] * scale[j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                // Below it the columns are one another's copies to the last digits.
                if !(sum > 1e-13) {
                    return None;
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    let forward = |mut x: Vec<f64>| {
        for i in 0..m {
            for k in 0..i {
                x[i] -= l[i][k] * x[k];
            }
            x[i] /= l[i][i];
        }
        x
    };
    let backward = |mut x: Vec<f64>| {
        for i in (0..m).rev() {
            for k in i + 1..m {
                x[i] -= l[k][i] * x[k];
            }
            x[i] /= l[i][i];
        }
        x
    };
    let right: Vec<f64> = (0..m).map(|i| g[columns[i]][DATA] * scale[i]).collect();
    let half = forward(right);
    let rss = (g[DATA][DATA] - half.iter().map(|x| x * x).sum::<f64>()).max(0.0);
    let beta = backward(half)
        .iter()
        .zip(&scale)
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

/// Transition, noise, start and reading of N states: position, velocity, then the walk, then the coloured part.
struct System<const N: usize> {
    f: [[f64; N]; N],
    q: [[f64; N]; N],
    p: [[f64; N]; N],
    at: usize,
    colour: bool,
    r: f64,
}

fn system<const N: usize>(noise: &Noise, source: ReadingSource, t: f64) -> System<N> {
    let [xx, xv, vv] = match noise.form {
        ProcessNoise::SampleConstant => [t.powi(4) / 4.0, t.powi(3) / 2.0, t * t],
        ProcessNoise::Continuous => [t.powi(3) / 3.0, t * t / 2.0, t],
    };
    let mut f = [[0.0; N]; N];
    let mut q = [[0.0; N]; N];
    let mut p = [[0.0; N]; N];
    for i in 0..N {
        f[i][i] = 1.0;
    }
    f[0][1] = t;
    (q[0][0], q[0][1], q[1][0], q[1][1]) = (noise.q * xx, noise.q * xv, noise.q * xv, noise.q * vv);
    if let Some(s) = noise.walk {
        (f[0][2], f[1][2]) = (-0.5 * t * t, -t);
        let row = [t.powi(5) / 20.0, t.powi(4) / 8.0, -t.powi(3) / 6.0];
        let rest = [t.powi(3) / 3.0, -0.5 * t * t, t];
        q[0][0] += s * row[0];
        q[0][1] += s * row[1];
        q[1][0] += s * row[1];
        q[1][1] += s * rest[0];
        (q[0][2], q[2][0]) = (s * row[2], s * row[2]);
        (q[1][2], q[2][1]) = (s * rest[1], s * rest[1]);
        q[2][2] = s * rest[2];
    }
    if let Some((variance, time)) = noise.colour {
        let phi = (-t / time).exp();
        f[N - 1][N - 1] = phi;
        q[N - 1][N - 1] = -variance * (-2.0 * t / time).exp_m1();
        p[N - 1][N - 1] = variance;
    }
    System {
        f,
        q,
        p,
        at: component(source),
        colour: noise.colour.is_some(),
        r: noise.r,
    }
}

/// Columns and covariance at one sample.
#[derive(Clone, Copy)]
struct State<const N: usize> {
    m: [[f64; N]; COLUMNS],
    p: [[f64; N]; N],
}

/// Innovations of the columns and their common variance.
#[derive(Clone, Copy)]
struct Seen {
    e: [f64; COLUMNS],
    s: f64,
}

impl<const N: usize> System<N> {
    fn start(&self, record: &MotionRecord) -> State<N> {
        let mut m = [[0.0; N]; COLUMNS];
        m[DATA][1] = record.initial_velocity.unwrap_or(0.0);
        m[START_VELOCITY][1] = 1.0;
        m[START_POSITION][0] = 1.0;
        State { m, p: self.p }
    }

    fn advance(&self, state: &mut State<N>, prepared: &Prepared<'_>, k: usize, active: usize) {
        let t = prepared.record.sample_time;
        let u = prepared.steps[k];
        let (now, before) = (
            prepared.record.acceleration[k],
            prepared.record.acceleration[k - 1],
        );
        let input = |column: usize| match column {
            DATA => u,
            OFFSET => [-0.5 * t * t, -t],
            GAIN => [-u[0], -u[1]],
            LATENCY => [u[1] - t * before, now - before],
            _ => [0.0; 2],
        };
        for (column, m) in state.m.iter_mut().enumerate().take(active) {
            let mut x = [0.0; N];
            for i in 0..N {
                for j in 0..N {
                    x[i] += self.f[i][j] * m[j];
                }
            }
            let [dx, dv] = input(column);
            x[0] += dx;
            x[1] += dv;
            *m = x;
        }
        let mut half = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                for l in 0..N {
                    half[i][j] += self.f[i][l] * state.p[l][j];
                }
            }
        }
        let mut p = self.q;
        for i in 0..N {
            for j in 0..=i {
                for l in 0..N {
                    p[i][j] += half[i][l] * self.f[j][l];
                }
                p[j][i] = p[i][j];
            }
        }
        state.p = p;
    }

    /// h · x.
    fn shown(&self, x: &[f64; N]) -> f64 {
        x[self.at] + if self.colour { x[N - 1] } else { 0.0 }
    }

    /// P hᵀ.
    fn column(&self, p: &[[f64; N]; N]) -> [f64; N] {
        std::array::from_fn(|i| self.shown(&p[i]))
    }

    fn observe(&self, state: &mut State<N>, reading: f64, active: usize) -> Seen {
        let ph = self.column(&state.p);
        let s = self.shown(&ph) + self.r;
        let mut e = [0.0; COLUMNS];
        for (j, m) in state.m.iter_mut().enumerate().take(active) {
            e[j] = if j == DATA { reading } else { 0.0 } - self.shown(m);
            for i in 0..N {
                m[i] += ph[i] / s * e[j];
            }
        }
        for i in 0..N {
            for j in 0..=i {
                let p = if !self.colour && (i == self.at || j == self.at) {
                    // 1 − P/(P + R) is R/(P + R): the difference would lose an exact reading's digits.
                    state.p[i][j] * (self.r / s)
                } else {
                    state.p[i][j] - ph[i] * ph[j] / s
                };
                state.p[i][j] = p;
                state.p[j][i] = p;
            }
        }
        Seen { e, s }
    }
}

/// Runs a body with the number of states the noise has.
macro_rules! with_states {
    ($noise:expr, $source:expr, $t:expr, |$system:ident| $body:expr) => {
        match 2 + usize::from($noise.walk.is_some()) + usize::from($noise.colour.is_some()) {
            2 => {
                let $system = system::<2>($noise, $source, $t);
                $body
            }
            3 => {
                let $system = system::<3>($noise, $source, $t);
                $body
            }
            _ => {
                let $system = system::<4>($noise, $source, $t);
                $body
            }
        }
    };
}

/// Velocity with the constants found from all readings (smoother) or from those up to each sample (filter).
#[derive(Clone, Debug)]
pub(crate) struct Trajectory {
    pub velocity: Vec<f64>,
    pub uncertainty: Vec<f64>,
    /// Offset of the accelerometer and its standard uncertainty, when it is unknown.
    pub offset: Option<(Vec<f64>, Vec<f64>)>,
    /// Innovation over its standard deviation with the constants of the whole record, per reading.
    pub innovations: Vec<Option<f64>>,
}

impl Trajectory {
    /// The smoother of one model.
    pub fn of(run: crate::KalmanRun) -> Self {
        Self {
            velocity: run.velocity,
            uncertainty: run.velocity_uncertainty,
            offset: run.offset,
            innovations: run.innovations,
        }
    }
}

impl<'a> Prepared<'a> {
    pub fn new(record: &'a MotionRecord, model: &KalmanModel) -> Self {
        let first = match record.source {
            ReadingSource::Position => record.reading.iter().flatten().next().copied(),
            ReadingSource::Speed => None,
        };
        Self {
            record,
            steps: step_inputs(record, model),
            first: first.unwrap_or(0.0),
        }
    }

    /// Sums over the record; `motion` asks for the columns of gain and latency as well.
    pub fn sums(&self, noise: &Noise, motion: bool) -> Sums {
        let active = if motion { COLUMNS } else { GAIN };
        with_states!(noise, self.record.source, self.record.sample_time, |s| self
            .sums_of(&s, active))
    }

    fn sums_of<const N: usize>(&self, system: &System<N>, active: usize) -> Sums {
        let mut state = system.start(self.record);
        let mut sums = Sums {
            n: 0,
            logs: 0.0,
            g: [[0.0; COLUMNS]; COLUMNS],
        };
        for (k, reading) in self.record.reading.iter().enumerate() {
            if k > 0 {
                system.advance(&mut state, self, k, active);
            }
            if let Some(reading) = reading {
                let Seen { e, s } = system.observe(&mut state, reading - self.first, active);
                sums.n += 1;
                sums.logs += s.ln();
                add(&mut sums.g, &e, s, active);
            }
        }
        for i in 0..COLUMNS {
            for j in 0..i {
                sums.g[j][i] = sums.g[i][j];
            }
        }
        sums
    }

    /// Innovations over their standard deviations for constants that were found.
    pub fn innovations(&self, noise: &Noise, solution: &Solution) -> Vec<f64> {
        with_states!(noise, self.record.source, self.record.sample_time, |s| {
            let mut state = s.start(self.record);
            let mut list = Vec::with_capacity(self.record.reading.len());
            for (k, reading) in self.record.reading.iter().enumerate() {
                if k > 0 {
                    s.advance(&mut state, self, k, COLUMNS);
                }
                if let Some(reading) = reading {
                    let seen = s.observe(&mut state, reading - self.first, COLUMNS);
                    list.push(total(&seen.e, solution) / seen.s.sqrt());
                }
            }
            list
        })
    }

    /// Every estimate uses the readings up to its own time; `None` before they determine the constants.
    #[cfg(test)]
    pub fn filter(&self, noise: &Noise, unknowns: Unknowns) -> Vec<Option<(f64, f64)>> {
        with_states!(noise, self.record.source, self.record.sample_time, |s| {
            let mut state = s.start(self.record);
            let mut g = [[0.0; COLUMNS]; COLUMNS];
            let mut list = Vec::with_capacity(self.record.reading.len());
            for (k, reading) in self.record.reading.iter().enumerate() {
                if k > 0 {
                    s.advance(&mut state, self, k, COLUMNS);
                }
                if let Some(reading) = reading {
                    let seen = s.observe(&mut state, reading - self.first, COLUMNS);
                    add(&mut g, &seen.e, seen.s, COLUMNS);
                }
                let mut full = g;
                for i in 0..COLUMNS {
                    for j in 0..i {
                        full[j][i] = full[i][j];
                    }
                }
                list.push(
                    solve(&full, columns(self.record, unknowns)).map(|solution| {
                        let c: Vec<f64> = solution.columns.iter().map(|c| state.m[*c][1]).collect();
                        spread(state.m[DATA][1], state.p[1][1], &c, &solution)
                    }),
                );
            }
            list
        })
    }

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

fn add(g: &mut [[f64; COLUMNS]; COLUMNS], e: &[f64; COLUMNS], s: f64, active: usize) {
    let inverse = 1.0 / s;
    for i in 0..active {
        let scaled = e[i] * inverse;
        for j in 0..=i {
            g[i][j] += scaled * e[j];
        }
    }
}

/// Innovation with the constants put in.
fn total(e: &[f64; COLUMNS], solution: &Solution) -> f64 {
    let constants = solution.columns.iter().zip(&solution.beta);
    e[DATA] + constants.map(|(c, b)| e[*c] * b).sum::<f64>()
}

/// Value and standard uncertainty from the data's own value and variance and the sensitivities to the constants.
fn spread(value: f64, variance: f64, sensitivity: &[f64], solution: &Solution) -> (f64, f64) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn vector() -> MotionRecord {
        let k = |k: usize| k as f64;
        let z = (0..200).map(|i| Some((100.0 * (0.03 * k(i)).sin()).round() / 1000.0));
        let a = (0..200).map(|i| {
            -0.9 * (0.03 * k(i)).sin() + 0.05 + 0.02 * (((7919 * i) % 101) as f64 - 50.0) / 50.0
        });
        MotionRecord::new(0.01, ReadingSource::Position, z.collect(), a.collect()).unwrap()
    }

    fn noise(q: f64) -> Noise {
        Noise {
            q,
            form: ProcessNoise::SampleConstant,
            r: 1e-6 / 12.0,
            walk: None,
            colour: None,
        }
    }

    fn near(ours: f64, theirs: f64, digits: f64) {
        assert!(
            (ours / theirs - 1.0).abs() < digits,
            "{ours} instead of {theirs}"
        );
    }

    /// Against a dense 200 × 200 covariance and an independent programme, printed to the digits that are compared.
    #[test]
    fn crosscheck_likelihood_constants_filter_and_smoother() {
        let record = vector();
        let model = KalmanModel::new(1.0, 1.0);
        let prepared = Prepared::new(&record, &model);
        let none = Unknowns::default();
        let offset = Unknowns {
            offset: true,
            ..none
        };
        let all = Unknowns {
            offset: true,
            gain: true,
            latency: true,
        };
        let q = 4e-4;
        let rows = [
            (
                noise(q),
                none,
                [-3238.68334598, 833.69962690, 1156.06943945, 6.01854339],
                [-0.28890843, 8.1235305e-4, -0.29722533, 4.1211179e-4],
            ),
            (
                noise(q),
                offset,
                [-3238.68334598, 1350.01365398, 1351.17220949, 0.85540312],
                [-0.29710328, 9.0612871e-4, -0.29722607, 4.1211179e-4],
            ),
            (
                noise(1e-4),
                offset,
                [-3245.55896612, 1352.17366560, 1353.12727003, 0.86818111],
                [-0.29693616, 5.9505092e-4, -0.29705999, 2.452114e-4],
            ),
            (
                noise(4e-3),
                offset,
                [-3220.42391353, 1342.73257810, 1344.22732126, 0.83691672],
                [-0.29718559, 2.0071865e-3, -0.29757633, 9.7679946e-4],
            ),
            (
                noise(q),
                all,
                [-3238.68334598, 1350.01954533, 1351.17909695, 0.85534421],
                [-0.29725400, 1.9821874e-3, -0.29722628, 4.1225164e-4],
            ),
            (
                Noise {
                    walk: Some(1e-3),
                    ..noise(q)
                },
                offset,
                [-3221.48051328, 1342.67383368, 1344.05663283, 0.84278716],
                [-0.29746080, 1.7059863e-3, -0.29733851, 5.0510204e-4],
            ),
            (
                Noise {
                    colour: Some((4e-7, 0.1)),
                    ..noise(q)
                },
                offset,
                [-3083.32904635, 1307.03030601, 1325.51268540, 0.50846511],
                [-0.29703490, 2.7569751e-3, -0.29685474, 7.3083557e-4],
            ),
        ];
        for (noise, unknowns, likelihood, velocity) in rows {
            let sums = prepared.sums(&noise, true);
            let solution = sums.solve(&record, unknowns).unwrap();
            let (concentrated, factor) = sums.concentrated(&solution, f64::MIN_POSITIVE);
            // Printed to ten digits and more.
            near(sums.logs, likelihood[0], 1e-11);
            near(sums.log_likelihood(&solution), likelihood[1], 1e-10);
            near(concentrated, likelihood[2], 1e-10);
            near(factor, likelihood[3], 1e-7);
            let filtered = prepared.filter(&noise, unknowns)[100].unwrap();
            let smooth = prepared.smooth(&noise, &solution).unwrap();
            near(filtered.0, velocity[0], 1e-7);
            near(filtered.1, velocity[1], 1e-6);
            near(smooth.velocity[100], velocity[2], 1e-7);
            near(smooth.uncertainty[100], velocity[3], 1e-6);
        }
        let sums = prepared.sums(&noise(q), true);
        let two = sums.solve(&record, offset).unwrap();
        near(two.of(START_VELOCITY).unwrap().0, 0.29970943, 1e-7);
        near(two.of(START_POSITION).unwrap().0, 3.1751178e-5, 1e-6);
        near(two.offset().unwrap().0, 0.049881805, 1e-7);
        near(two.of(START_VELOCITY).unwrap().1, 8.5176e-4, 1e-4);
        near(two.of(START_POSITION).unwrap().1, 9.8484049e-5, 1e-6);
        near(two.offset().unwrap().1, 1.5522805e-3, 1e-6);
        let all = sums.solve(&record, all).unwrap();
        near(all.gain().unwrap().0, 1.1456802e-5, 1e-4);
        near(all.gain().unwrap().1, 2.2927024e-3, 1e-5);
        near(all.latency().unwrap().0, -1.0823359e-4, 1e-4);
        near(all.latency().unwrap().1, 1.006451e-3, 1e-5);
    }

    #[test]
    fn law_an_offset_of_any_size_leaves_the_likelihood_alone() {
        let record = vector();
        let mut upright = record.clone();
        upright.acceleration.iter_mut().for_each(|a| *a += 9.81);
        let unknowns = Unknowns {
            offset: true,
            ..Unknowns::default()
        };
        let value = |record: &MotionRecord| {
            let prepared = Prepared::new(record, &KalmanModel::new(1.0, 1.0));
            let sums = prepared.sums(&noise(4e-4), false);
            let solution = sums.solve(record, unknowns).unwrap();
            (sums.log_likelihood(&solution), solution.offset().unwrap().0)
        };
        let (a, b) = (value(&record), value(&upright));
        // Fourteen digits of squares of 10⁴ standard deviations.
        assert!((a.0 - b.0).abs() < 1e-5, "{} {}", a.0, b.0);
        assert!((b.1 - a.1 - 9.81).abs() < 1e-9);
    }
}
