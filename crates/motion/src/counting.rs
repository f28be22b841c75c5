//! Slow counted positions off line: the filter of `core` that takes a count for what it is, tuned and smoothed.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use crate::filtering::step_inputs;
use crate::floor::{noise_floor, variance};
use crate::search::{line, simplex};
use crate::{KalmanModel, MotionRecord, ReadingSource};
use proofmass_core::velocity::{CountUse, CountingKalman, CountingNoise, CountingState};
use proofmass_core::{Error, Watch};
use serde::{Deserialize, Serialize};
use std::f64::consts::{LN_10, PI, TAU};

/// Noise of a counted axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CountingModel {
    /// q: variance of an acceleration sample, (m/s²)².
    pub acceleration_noise: f64,
    /// Variance of the place of an edge over the increment squared.
    pub edge: f64,
    /// Standard deviation of the accelerometer's offset at the start, m/s².
    pub offset: f64,
    /// Density of the walk of the offset, (m/s²)²/s; without an accelerometer that of the acceleration.
    #[serde(default)]
    pub walk: f64,
}

/// Velocities of a counted axis, on line and off.
#[derive(Clone, Debug)]
pub(crate) struct CountingRun {
    /// Velocity and standard uncertainty from the counts up to each sample, in the cell of that sample.
    pub filtered: (Vec<f64>, Vec<f64>),
    /// From all counts.
    pub smoothed: (Vec<f64>, Vec<f64>),
    /// Innovation over its standard deviation at every edge and new cell.
    pub innovations: Vec<f64>,
}

/// A counted axis whose noise was found.
#[derive(Clone, Debug)]
pub(crate) struct CountingTuned {
    pub model: CountingModel,
    /// Half width of ln q, below and above.
    pub log_q_interval: Option<(f64, f64)>,
    /// Models at which the smoother is averaged.
    pub nodes: Vec<CountingModel>,
}

/// Counts from the first one on, where all readings lie on the increment's grid.
pub(crate) fn counts(record: &MotionRecord) -> Option<Vec<Option<i32>>> {
    let increment = record.increment?;
    if record.source != ReadingSource::Position {
        return None;
    }
    let first = *record.reading.iter().flatten().next()?;
    let mut on_grid = true;
    let list = record
        .reading
        .iter()
        .map(|r| {
            r.map(|r| {
                let n = (r - first) / increment;
                on_grid &= (n - n.round()).abs() < 1e-3 && n.abs() < 2e9;
                n.round() as i32
            })
        })
        .collect();
    on_grid.then_some(list)
}

/// Whether more than half of the counts are those of the sample before: rounding is then no noise.
pub(crate) fn is_slow(counts: &[Option<i32>]) -> bool {
    let known: Vec<i32> = counts.iter().flatten().copied().collect();
    let same = known.windows(2).filter(|w| w[0] == w[1]).count();
    known.len() > 2 && 2 * same > known.len() - 1
}

/// Mills' ratio (1 − Φ)/φ for x ≥ 0, to 9e-7.
fn mills(x: f64) -> f64 {
    if x > 12.0 {
        // 1/x − 1/x³ + 3/x⁵.
        let s = 1.0 / (x * x);
        return (1.0 - s * (1.0 - 3.0 * s)) / x;
    }
    let top = 1.253_313_0 + x * (0.898_608_46 + x * (0.294_837_31 + x * 0.041_683_536));
    let bottom =
        1.0 + x * (1.514_845_9 + x * (0.944_079_73 + x * (0.294_594_62 + x * 0.041_690_084)));
    top / bottom
}

/// Mean and variance of a standard normal variable that is known to lie between two bounds.
///
/// Bounds closer than half a standard deviation are taken as a uniform distribution.
fn truncated(alpha: f64, beta: f64) -> (f64, f64) {
    if alpha + beta < 0.0 {
        let (mean, variance) = truncated(-beta, -alpha);
        return (-mean, variance);
    }
    let width = beta - alpha;
    if width < 0.5 {
        return (0.5 * (alpha + beta), width * width / 12.0);
    }
    let (scale, g) = if alpha >= 0.0 {
        let g = (-0.5 * (beta * beta - alpha * alpha)).exp();
        (mills(alpha) - g * mills(beta), g)
    } else {
        let g = (-0.5 * (beta * beta - alpha * alpha)).exp();
        let all = (2.0 * PI).sqrt() * (0.5 * alpha * alpha).exp();
        (all - mills(-alpha) - g * mills(beta), g)
    };
    let mean = (1.0 - g) / scale;
    let tail = if g > 0.0 { g * beta } else { 0.0 };
    let variance = 1.0 + (alpha - tail) / scale - mean * mean;
    (mean, variance.clamp(0.0, 1.0))
}

impl CountingModel {
    fn kalman(&self, increment: f64, dt: f64) -> Result<CountingKalman<f64>, Error> {
        CountingKalman::new(
            increment,
            dt,
            &CountingNoise {
                acceleration: self.acceleration_noise,
                walk: self.walk,
                edge: self.edge,
                tick: None,
            },
        )
    }
}

/// Filter of one sample as it is stored for the smoother.
#[derive(Clone, Copy)]
struct Step {
    predicted: CountingState<f64>,
    filtered: CountingState<f64>,
    /// Change of the count at this sample.
    change: f64,
}

/// A record made ready for passes.
pub(crate) struct Counted<'a> {
    record: &'a MotionRecord,
    counts: Vec<Option<i32>>,
    increment: f64,
    /// Input of each step and mean acceleration over it, counts and samples.
    steps: Vec<([f64; 2], f64)>,
}

impl<'a> Counted<'a> {
    /// `None` for records that are no counts.
    pub fn new(record: &'a MotionRecord) -> Option<Self> {
        let counts = counts(record)?;
        let increment = record.increment?;
        let dt = record.sample_time;
        let inputs = step_inputs(record, &KalmanModel::new(0.0, 1.0));
        let a = &record.acceleration;
        let scale = dt * dt / increment;
        let steps = (0..a.len())
            .map(|k| {
                let before = a[k.saturating_sub(1)];
                let [x, v] = inputs[k];
                (
                    [x / increment, v * dt / increment],
                    0.5 * scale * (before + a[k]),
                )
            })
            .collect();
        Some(Self {
            record,
            counts,
            increment,
            steps,
        })
    }

    pub fn is_slow(&self) -> bool {
        is_slow(&self.counts)
    }

    /// One pass; `keep` is shown every sample, and ln L of the edges and new cells comes back.
    fn pass(
        &self,
        model: &CountingModel,
        mut keep: impl FnMut(&Step, bool),
        mut innovation: impl FnMut(f64),
    ) -> Result<f64, Error> {
        let dt = self.record.sample_time;
        let filter = model.kalman(self.increment, dt)?;
        let mut last = self.counts.iter().flatten().next().copied().unwrap_or(0);
        let mut fastest = 1.0f64;
        let mut before: Option<(usize, i32)> = None;
        for (k, count) in self.counts.iter().enumerate() {
            if let Some(count) = *count {
                if let Some((j, c)) = before {
                    fastest = fastest.max(f64::from((count - c).abs()) / (k - j) as f64);
                }
                before = Some((k, count));
            }
        }
        let velocity = match self.record.initial_velocity {
            Some(v) => (v, 0.0),
            None => (0.0, 3.0 * fastest * self.increment / dt),
        };
        let mut state = filter.start(last, velocity, (0.0, model.offset), 0.0);
        let (mut log_likelihood, mut age) = (0.0, 0usize);
        for (k, count) in self.counts.iter().enumerate() {
            if k > 0 {
                filter.advance(&mut state, self.steps[k].0);
            }
            age += 1;
            let predicted = state;
            let mut change = 0.0;
            if let Some(count) = *count {
                let moved = count.wrapping_sub(last);
                change = f64::from(moved);
                let (nu, s, used) = if moved != 0 && (age > 1 || moved.abs() > 1) {
                    state.x[0] -= change;
                    state.count = count;
                    let (nu, s) = cell(&mut state, model.edge);
                    (nu, s, true)
                } else {
                    let update = filter.observe(&mut state, count, None, self.steps[k].1);
                    let used = update.kind == CountUse::Edge;
                    (update.innovation, update.variance, used)
                };
                if used && k > 0 {
                    log_likelihood -= 0.5 * ((TAU * s).ln() + nu * nu / s);
                    innovation(nu / s.sqrt());
                }
                (last, age) = (count, 0);
            }
            keep(
                &Step {
                    predicted,
                    filtered: state,
                    change,
                },
                count.is_some(),
            );
        }
        Ok(if log_likelihood.is_finite() {
            log_likelihood
        } else {
            -1e300
        })
    }

    /// ln L of the edges and new cells.
    ///
    /// # Errors
    /// Of the model.
    pub fn log_likelihood(&self, model: &CountingModel) -> Result<f64, Error> {
        self.pass(model, |_, _| {}, |_| {})
    }

    /// Finds q and the variance of an edge's place from the counts, q held by the accelerometer's own floor: that of
    /// its samples as they were recorded (`heard`), since putting a latency right takes noise off them.
    ///
    /// # Errors
    /// [`Error::Cancelled`], and of the record.
    pub fn tune(&self, heard: &[f64], watch: &dyn Watch) -> Result<CountingTuned, Error> {
        let a = heard;
        if !self.record.accelerometer {
            return self.tune_alone(watch);
        }
        let ceiling = variance(a).max(f64::MIN_POSITIVE);
        let floor = noise_floor(a)
            .filter(|q| *q > 0.0)
            .unwrap_or(1e-3 * ceiling);
        let mean = a.iter().sum::<f64>() / a.len() as f64;
        let offset = 3.0 * mean.abs() + 3.0 * ceiling.sqrt();
        let prior = |q: f64| {
            let off = (q / floor).ln();
            -0.5 * (off / if off < 0.0 { 0.8 } else { 0.5 }).powi(2)
        };
        let mut passes = 0;
        let mut value = |log: f64, edge: f64| -> Result<f64, Error> {
            passes += 1;
            watch.step("likelihood of the edges", passes, 0)?;
            let q = 10f64.powf(log);
            let model = CountingModel {
                acceleration_noise: q,
                edge,
                offset,
                walk: 0.0,
            };
            Ok(self.pass(&model, |_, _| {}, |_| {})? + prior(q))
        };
        let centre = floor.log10();
        let high = ceiling.log10().min(centre + 2.0).max(centre + 0.1);
        let mut best = (f64::NEG_INFINITY, centre, 1e-6);
        for edge in [1e-6, 1e-4, 5e-4, 2e-3, 5e-3, 2e-2] {
            let found = line(centre - 2.0, high, 0.5, 0.02, |log| value(log, edge))?;
            // An edge is where it should be unless the likelihood says otherwise.
            if found.value > best.0 + if edge > 1e-6 { 2.0 } else { 0.0 } {
                best = (found.value, found.at, edge);
            }
        }
        let (top, at, edge) = best;
        let curvature = -(value(at + 0.1, edge)? - 2.0 * top + value(at - 0.1, edge)?) / 0.01;
        let sigma = (1.0 / curvature.max(4.0)).sqrt();
        let half = 1.96 * sigma * LN_10;
        let model = |log: f64| CountingModel {
            acceleration_noise: 10f64.powf(log),
            edge,
            offset,
            walk: 0.0,
        };
        Ok(CountingTuned {
            model: model(at),
            log_q_interval: Some((half, half)),
            nodes: vec![model(at - sigma), model(at + sigma)],
        })
    }

    /// The same where there is no accelerometer: the acceleration is a random walk with noise beside it, and the counts
    /// alone tell how much of each.
    fn tune_alone(&self, watch: &dyn Watch) -> Result<CountingTuned, Error> {
        let dt = self.record.sample_time;
        // One count per sample squared.
        let unit = self.increment / (dt * dt);
        let model = |x: &[f64; 2], edge: f64| CountingModel {
            acceleration_noise: 10f64.powf(x[0]) * unit * unit,
            edge,
            offset: unit,
            walk: 10f64.powf(x[1]) * unit * unit / dt,
        };
        let mut passes = 0;
        let mut value = |x: &[f64; 2], edge: f64| -> Result<f64, Error> {
            passes += 1;
            watch.step("likelihood of the edges", passes, 0)?;
            if x.iter().any(|x| !(-24.0..3.0).contains(x)) {
                return Ok(-1e300);
            }
            self.pass(&model(x, edge), |_, _| {}, |_| {})
        };
        let mut best = (f64::NEG_INFINITY, [-6.0, -9.0], 1e-6);
        for edge in [1e-6, 5e-3] {
            let mut start = ([-6.0, -9.0], f64::NEG_INFINITY);
            for q in [-12.0, -8.0, -4.0, -1.0] {
                for walk in [-16.0, -13.0, -10.0, -7.0, -4.0] {
                    let found = value(&[q, walk], edge)?;
                    if found > start.1 {
                        start = ([q, walk], found);
                    }
                }
            }
            let found = simplex(start.0, 1.0, 150, |x| value(x, edge))?;
            if found.value > best.0 + if edge > 1e-6 { 2.0 } else { 0.0 } {
                best = (found.value, found.at, edge);
            }
        }
        let (top, at, edge) = best;
        let mut nodes = Vec::new();
        let mut half = 0.0;
        for i in 0..2 {
            let moved = |by: f64| {
                let mut x = at;
                x[i] += by;
                x
            };
            let bend = -(value(&moved(0.1), edge)? - 2.0 * top + value(&moved(-0.1), edge)?) / 0.01;
            // Half a decade at most, also where the difference found no maximum.
            let sigma = (1.0 / bend.max(4.0)).sqrt();
            if i == 0 {
                half = 1.96 * sigma * LN_10;
            }
            let by = 2f64.sqrt() * sigma;
            nodes.extend([model(&moved(-by), edge), model(&moved(by), edge)]);
        }
        Ok(CountingTuned {
            model: model(&at, edge),
            log_q_interval: Some((half, half)),
            nodes,
        })
    }

    /// Filter and smoother of one model.
    ///
    /// # Errors
    /// Of the model; [`Error::NotFinite`] when the arithmetic overflowed.
    pub fn run(&self, model: &CountingModel) -> Result<CountingRun, Error> {
        let n = self.counts.len();
        let unit = self.increment / self.record.sample_time;
        let mut steps = Vec::with_capacity(n);
        let mut innovations = Vec::new();
        let (mut v, mut u) = (Vec::with_capacity(n), Vec::with_capacity(n));
        self.pass(
            model,
            |step, seen| {
                let (value, spread) = shown(&step.filtered, seen);
                v.push(value * unit);
                u.push(spread * unit);
                steps.push(*step);
            },
            |z| innovations.push(z),
        )?;
        let smoothed = smooth(&steps, unit);
        if let Some(index) = (0..n).find(|&k| {
            let all = [v[k], u[k], smoothed.0[k], smoothed.1[k]];
            all.iter().any(|x| !x.is_finite())
        }) {
            return Err(Error::NotFinite {
                name: "velocity",
                index,
            });
        }
        Ok(CountingRun {
            filtered: (v, u),
            smoothed,
            innovations,
        })
    }

    /// The same with the uncertainty of q.
    ///
    /// # Errors
    /// As [`Counted::run`].
    pub fn run_tuned(&self, tuned: &CountingTuned) -> Result<CountingRun, Error> {
        let mut main = self.run(&tuned.model)?;
        let share = 1.0 / tuned.nodes.len() as f64;
        let n = self.counts.len();
        let mut spread = [vec![0.0; n], vec![0.0; n]];
        for node in &tuned.nodes {
            let run = self.run(node)?;
            let pairs = [
                (&run.filtered, &main.filtered),
                (&run.smoothed, &main.smoothed),
            ];
            for (sum, (node, main)) in spread.iter_mut().zip(pairs) {
                for k in 0..n {
                    sum[k] += share * (node.1[k].powi(2) + (node.0[k] - main.0[k]).powi(2));
                }
            }
        }
        let [f, s] = spread.map(|sum| sum.into_iter().map(f64::sqrt).collect());
        (main.filtered.1, main.smoothed.1) = (f, s);
        Ok(main)
    }
}

/// The state is somewhere in its cell: moments of the normal distribution cut at both edges. Innovation and variance
/// are those of the cell's middle.
fn cell(state: &mut CountingState<f64>, edge: f64) -> (f64, f64) {
    let row = state.p[0];
    let x = state.x[0];
    let innovation = (0.5 - x, row[0] + 1.0 / 12.0 + edge);
    let s = (row[0] + edge).sqrt();
    let (mean, rest) = truncated(-x / s, (1.0 - x) / s);
    for i in 0..3 {
        let gain = row[i] / (s * s);
        state.x[i] += gain * s * mean;
        for j in 0..3 {
            state.p[i][j] -= gain * row[j] * (1.0 - rest);
        }
    }
    innovation
}

/// Velocity and uncertainty of a state that is known to lie in its cell, counts per sample; nothing of it is fed back.
fn shown(state: &CountingState<f64>, seen: bool) -> (f64, f64) {
    let (x, v) = (state.x[0], state.x[1]);
    let [xx, xv, _] = state.p[0];
    let vv = state.p[1][1];
    let s = xx.sqrt();
    let (alpha, beta) = (-x / s, (1.0 - x) / s);
    if !seen || !(s > 0.0) || (alpha < -3.0 && beta > 3.0) {
        return (v, vv.max(0.0).sqrt());
    }
    let (mean, rest) = truncated(alpha, beta);
    let value = v + xv / xx * s * mean;
    let variance = vv - xv * xv / xx * (1.0 - rest);
    (value, variance.max(1e-9 * vv).sqrt())
}

/// Rauch, Tung and Striebel's smoother on the stored moments.
///
/// **Source** `[RauchTungStriebel65]`.
fn smooth(steps: &[Step], unit: f64) -> (Vec<f64>, Vec<f64>) {
    let n = steps.len();
    let (mut v, mut u) = (vec![0.0; n], vec![0.0; n]);
    let Some(last) = steps.last() else {
        return (v, u);
    };
    let (mut x, mut p) = (last.filtered.x, last.filtered.p);
    for k in (0..n).rev() {
        if k + 1 < n {
            let (here, next) = (&steps[k].filtered, &steps[k + 1]);
            // C = P Fᵀ (P⁻)⁻¹, row by row; F = [[1, 1, −½], [0, 1, −1], [0, 0, 1]].
            let pf = here
                .p
                .map(|r| [r[0] + r[1] - 0.5 * r[2], r[1] - r[2], r[2]]);
            let Some(c) = divided(&pf, &next.predicted.p) else {
                (x, p) = (here.x, here.p);
                v[k] = x[1] * unit;
                u[k] = p[1][1].max(0.0).sqrt() * unit;
                continue;
            };
            // The cell's frame moves with the count.
            let mut off: [f64; 3] = std::array::from_fn(|i| x[i] - next.predicted.x[i]);
            off[0] += next.change;
            let gap: [[f64; 3]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - next.predicted.p[i][j]));
            let mut new = here.p;
            for i in 0..3 {
                for j in 0..3 {
                    for l in 0..3 {
                        for m in 0..3 {
                            new[i][j] += c[i][l] * gap[l][m] * c[j][m];
                        }
                    }
                }
            }
            x = std::array::from_fn(|i| here.x[i] + (0..3).map(|j| c[i][j] * off[j]).sum::<f64>());
            p = new;
        }
        v[k] = x[1] * unit;
        u[k] = p[1][1].max(1e-12 * steps[k].filtered.p[1][1]).sqrt() * unit;
    }
    (v, u)
}

/// A B⁻¹ for a covariance B, by Cholesky after its diagonal was scaled to one; `None` when it is singular.
fn divided(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let mut d = [0.0; 3];
    for i in 0..3 {
        if !(b[i][i] > 0.0) {
            return None;
        }
        d[i] = 1.0 / b[i][i].sqrt();
    }
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let mut sum = b[i][j] * d[i] * d[j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > 1e-14) {
                    return None;
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    Some(std::array::from_fn(|row| {
        let mut y: [f64; 3] = std::array::from_fn(|j| a[row][j] * d[j]);
        for i in 0..3 {
            for k in 0..i {
                y[i] -= l[i][k] * y[k];
            }
            y[i] /= l[i][i];
        }
        for i in (0..3).rev() {
            for k in i + 1..3 {
                y[i] -= l[k][i] * y[k];
            }
            y[i] /= l[i][i];
        }
        std::array::from_fn(|j| y[j] * d[j])
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments_of_a_truncated_normal_variable() {
        for (a, b, mean, variance) in [
            (-1.0, 1.0, 0.0, 0.291125095),
            (-0.5, 2.0, 0.445743778, 0.376593836),
            (0.5, 3.0, 1.13166492, 0.249099034),
            (2.0, 6.0, 2.37321537, 0.114278483),
            (4.0, 9.0, 4.22560714, 0.0466728384),
            (-0.1, 0.1, 0.0, 0.00332889101),
        ] {
            // The ratio is right to 9e-7, its differences to 3e-4 for half a deviation.
            let (m, v) = truncated(a, b);
            assert!(
                (m - mean).abs() < 3e-4 && (v - variance).abs() < 3e-4,
                "{a} {b} {m} {v}"
            );
            let (m, v) = truncated(-b, -a);
            assert!((m + mean).abs() < 3e-4 && (v - variance).abs() < 3e-4);
        }
    }

    #[test]
    fn crosscheck_velocity_in_the_present_cell() {
        for (x, v, xx, xv, vv, value, variance) in [
            (0.9, 0.004, 0.04, 2e-4, 2e-6, 0.00349086018, 1.48609115e-6),
            (1.2, 0.006, 0.01, 1e-4, 4e-6, 0.00362678447, 3.11427910e-6),
        ] {
            let mut p = [[0.0; 3]; 3];
            (p[0][0], p[0][1], p[1][0], p[1][1]) = (xx, xv, xv, vv);
            let state = CountingState {
                x: [x, v, 0.0],
                p,
                acceleration: 0.0,
                count: 0,
            };
            let (ours, u) = shown(&state, true);
            assert!(
                (ours - value).abs() < 1e-7 && (u * u - variance).abs() < 1e-10,
                "{ours} {u}"
            );
        }
    }
}
