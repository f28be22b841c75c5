//! Slow counted positions off line: the filter of `core` that takes a count for what it is, tuned and smoothed.

mod cell;
mod smoother;
mod tuning;

use self::cell::{cell, shown};
use self::smoother::smooth;
use crate::step_input::{shake, step_inputs};
use crate::{KalmanModel, MotionRecord, PassedAt, ReadingSource};
use proofmass_core::Error;
use proofmass_core::state_space::Gain;
use proofmass_core::velocity::{
    CountUse, CountingKalman, CountingNoise, CountingState, PassedEdge, TURNING,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Noise of a counted axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    pub(crate) filtered: (Vec<f64>, Vec<f64>),
    /// From all counts.
    pub(crate) smoothed: (Vec<f64>, Vec<f64>),
    /// Innovation over its standard deviation at every edge and new cell, with its sample.
    pub(crate) innovations: Vec<(usize, f64)>,
}

/// A counted axis whose noise was found.
#[derive(Clone, Debug)]
pub(crate) struct CountingTuned {
    pub(crate) model: CountingModel,
    /// Half width of ln q, below and above.
    pub(crate) log_q_interval: Option<(f64, f64)>,
    /// Models at which the smoother is averaged.
    pub(crate) nodes: Vec<CountingModel>,
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

/// Equal counts in a row that count as a rest.
pub(crate) const LONG_RUN: usize = 20;

/// Whether more than half of the counts are those of the sample before, or a tenth of them lie in rests: rounding is then no noise.
pub(crate) fn is_slow(counts: &[Option<i32>]) -> bool {
    let known: Vec<i32> = counts.iter().flatten().copied().collect();
    let same = known.windows(2).filter(|w| w[0] == w[1]).count();
    let runs = known.chunk_by(|a, b| a == b).map(<[i32]>::len);
    let resting: usize = runs.filter(|n| *n >= LONG_RUN).sum();
    known.len() > 2 && (2 * same > known.len() - 1 || 10 * resting > known.len())
}

/// A reading as the smoother goes back over it: its gain and its innovation.
type Read<const N: usize> = (Gain<f64, N>, f64);

/// The filter at one sample.
struct Step<'a, const N: usize> {
    predicted: CountingState<f64, N>,
    filtered: CountingState<f64, N>,
    /// What was read of it.
    read: &'a [Read<N>],
    /// Whether there was a count.
    seen: bool,
}

/// A record made ready for passes.
pub(crate) struct Counted<'a> {
    record: &'a MotionRecord,
    counts: Vec<Option<i32>>,
    increment: f64,
    /// Input of each step and mean acceleration over it, counts and samples.
    steps: Vec<([f64; 2], f64)>,
    /// What the steps do not have, counts and samples.
    unseen: Vec<[f64; 3]>,
    /// Where the edges of each sample begin in the record's list; empty where they are not timed.
    first: Vec<usize>,
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
                let [x, v] = inputs.steps[k];
                (
                    [x / increment, v * dt / increment],
                    0.5 * scale * (before + a[k]),
                )
            })
            .collect();
        let in_counts = |[xx, xv, vv]: &[f64; 3]| {
            [xx, &(xv * dt), &(vv * dt * dt)].map(|v| v / (increment * increment))
        };
        let unseen = inputs.unseen.iter().map(in_counts).collect();
        let first = record.edges.as_ref().map_or_else(Vec::new, |edges| {
            (0..=counts.len())
                .map(|k| edges.list.partition_point(|e| e.sample < k))
                .collect()
        });
        Some(Self {
            record,
            counts,
            increment,
            steps,
            unseen,
            first,
        })
    }

    /// Whether counts are to be taken for what they are: slow ones, and those whose edges were timed.
    pub fn is_slow(&self) -> bool {
        self.record.edges.is_some() || is_slow(&self.counts)
    }

    /// Edges in the step to a sample, where their senses add up to the change of the count.
    fn edges(&self, k: usize, change: i32) -> &[PassedAt] {
        let Some(timed) = &self.record.edges else {
            return &[];
        };
        let list = &timed.list[self.first[k]..self.first[k + 1]];
        let sum: i32 = list.iter().map(|e| if e.upwards { 1 } else { -1 }).sum();
        if sum == change { list } else { &[] }
    }

    /// The noise of a model as the filter takes it.
    fn noise(&self, model: &CountingModel) -> CountingNoise {
        CountingNoise {
            acceleration: model.acceleration_noise,
            walk: model.walk,
            edge: model.edge,
            tick: self.record.edges.as_ref().map(|e| e.tick),
        }
    }

    /// Its filter, where the offset has no slope.
    fn filter(&self, model: &CountingModel) -> Result<CountingKalman<f64>, Error> {
        CountingKalman::new(self.increment, self.record.sample_time, &self.noise(model))
    }

    /// Its filter behind two stages of a corner, where it has one; the density of its walk over that of the offset is ω²/4.
    fn filter_with_slope(
        &self,
        model: &CountingModel,
    ) -> Result<Option<CountingKalman<f64, 4>>, Error> {
        let Some(corner) = self.record.behind_two_stages() else {
            return Ok(None);
        };
        let (noise, dt) = (self.noise(model), self.record.sample_time);
        let slope = corner.slope_of_walk(model.walk);
        CountingKalman::with_slope(self.increment, dt, &noise, slope).map(Some)
    }

    /// One pass; `keep` is shown every sample, and ln L of the edges and new cells comes back.
    fn pass<const N: usize>(
        &self,
        filter: &CountingKalman<f64, N>,
        model: &CountingModel,
        mut keep: impl FnMut(&Step<'_, N>),
        mut innovation: impl FnMut(usize, f64),
    ) -> Result<f64, Error> {
        let dt = self.record.sample_time;
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
            Some(v) => (v, self.record.initial_velocity_uncertainty),
            None => (0.0, 3.0 * fastest * self.increment / dt),
        };
        let mut state = filter.start(last, velocity, (0.0, model.offset), 0.0);
        let (mut log_likelihood, mut age) = (0.0, 0usize);
        let mut read: Vec<Read<N>> = Vec::new();
        for (k, count) in self.counts.iter().enumerate() {
            if k > 0 {
                filter.predict_by(&mut state, self.steps[k].0);
                shake(&mut state.p, self.unseen[k]);
            }
            age += 1;
            let predicted = state;
            read.clear();
            let mut used = |nu: f64, s: f64| {
                log_likelihood -= 0.5 * ((TAU * s).ln() + nu * nu / s);
                innovation(k, nu / s.sqrt());
            };
            if let Some(count) = *count {
                let moved = count.wrapping_sub(last);
                let edges = match age == 1 && k > 0 {
                    true => self.edges(k, moved),
                    false => &[],
                };
                let mean = self.steps[k].1;
                let turning = (mean - state.x[2]).abs() > TURNING;
                let mut at = last;
                for edge in edges {
                    at = at.wrapping_add(if edge.upwards { 1 } else { -1 });
                    let passed = PassedEdge {
                        age: edge.age,
                        upwards: edge.upwards,
                    };
                    if let Some(u) = filter.update(&mut state, at, Some(passed), mean) {
                        read.push((u.gain, u.innovation));
                        used(u.innovation, u.gain.variance);
                    }
                }
                let sampled = edges.is_empty();
                if sampled && moved != 0 && (age > 1 || moved.abs() > 1 || turning) {
                    state.x[0] -= f64::from(moved);
                    state.count = count;
                    let (cut, (nu, s)) = cell(&mut state, model.edge);
                    read.push(cut);
                    if k > 0 {
                        used(nu, s);
                    }
                } else if sampled && let Some(u) = filter.update(&mut state, count, None, mean) {
                    read.push((u.gain, u.innovation));
                    if u.kind == CountUse::Edge && k > 0 {
                        used(u.innovation, u.gain.variance);
                    }
                }
                (last, age) = (count, 0);
            }
            keep(&Step {
                predicted,
                filtered: state,
                read: &read,
                seen: count.is_some(),
            });
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
        match self.filter_with_slope(model)? {
            Some(filter) => self.pass(&filter, model, |_| {}, |_, _| {}),
            None => self.pass(&self.filter(model)?, model, |_| {}, |_, _| {}),
        }
    }

    /// Filter and smoother of one model.
    ///
    /// # Errors
    /// Of the model; [`Error::NotFinite`] when the arithmetic overflowed.
    pub fn run(&self, model: &CountingModel) -> Result<CountingRun, Error> {
        match self.filter_with_slope(model)? {
            Some(filter) => self.run_of(&filter, model),
            None => self.run_of(&self.filter(model)?, model),
        }
    }

    fn run_of<const N: usize>(
        &self,
        filter: &CountingKalman<f64, N>,
        model: &CountingModel,
    ) -> Result<CountingRun, Error> {
        let n = self.counts.len();
        let unit = self.increment / self.record.sample_time;
        let mut predicted = Vec::with_capacity(n);
        let (mut read, mut innovations) = (Vec::new(), Vec::new());
        let (mut v, mut u) = (Vec::with_capacity(n), Vec::with_capacity(n));
        self.pass(
            filter,
            model,
            |step| {
                let (value, spread) = shown(&step.filtered, step.seen);
                v.push(value * unit);
                u.push(spread * unit);
                predicted.push((step.predicted, read.len()));
                read.extend_from_slice(step.read);
            },
            |k, z| innovations.push((k, z)),
        )?;
        let smoothed = smooth(&predicted, &read, unit);
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
