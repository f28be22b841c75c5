//! Propagation of distributions by Monte Carlo.

mod circle;
mod drawn;
mod order;
mod sampled;
mod stability;
mod summary;
mod valid;

pub(crate) use circle::{circles, nearest_turn};
pub use drawn::Drawn;
pub use sampled::{Interval, Sampled, SampledOutput};

use crate::findings;
use crate::propagation::one_by_one;
use crate::sampler::{Sampler, Strips};
use crate::{JointInputs, Model, Refusal};
use order::{mean_and_sd, symmetric_interval};
use proofmass_core::{Error, check};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stability::Stability;
use std::ops::ControlFlow;
use summary::summarise;

/// What one trial computes from its draws.
///
/// Every [`Model`] is one. A procedure that has a value but no derivatives at hand, such as an estimator that
/// iterates, implements it directly.
///
/// ```
/// use proofmass_uncertainty::*;
/// struct Median; // of three readings
/// impl Trial for Median {
///     fn names(&self) -> Vec<(String, String)> { vec![("median".into(), "V".into())] }
///     fn trial(&self, x: &[f64], y: &mut [f64]) { y[0] = x[0].max(x[1]).min(x[2]).max(x[0].min(x[1])); }
/// }
/// let reading = |name| Input::new(name, "V", Distribution::Normal { mean: 1.0, u: 0.1 });
/// let inputs = Inputs::new().add(reading("a")).add(reading("b")).add(reading("c")).single()?;
/// let result = MonteCarlo::new(1).trials(Trials::Fixed(100_000)).run(&Median, &inputs)?;
/// assert!((result.get("median").unwrap().standard_uncertainty.unwrap() / 0.1 - 0.6698).abs() < 0.01);
/// # Ok::<(), Refusal>(())
/// ```
pub trait Trial {
    /// Names and units of the outputs.
    fn names(&self) -> Vec<(String, String)>;
    /// The outputs of one trial: one input per draw, in the order of [`JointInputs::draws`].
    fn trial(&self, x: &[f64], y: &mut [f64]);
    /// The outputs of several trials: a column of equal length per draw and per output. One after the other, unless the
    /// procedure knows better.
    fn trials(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        one_by_one(x, y, |x, y| self.trial(x, y));
    }
    /// Period of each output that lives on a circle, as [`Model::periods`]; none by default.
    fn circles(&self) -> Vec<Option<f64>> {
        Vec::new()
    }
}

impl<M: Model> Trial for M {
    fn names(&self) -> Vec<(String, String)> {
        self.outputs()
    }
    fn trial(&self, x: &[f64], y: &mut [f64]) {
        self.evaluate(x, y);
    }
    fn trials(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        self.evaluate_columns(x, y);
    }
    fn circles(&self) -> Vec<Option<f64>> {
        self.periods()
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Trials {
    /// This many trials, rounded up to whole blocks.
    Fixed(usize),
    /// Until mean, u and both ends of the interval are stable to the numerical tolerance of `digits` digits of u.
    /// **Source** `[S1] 7.9`.
    Adaptive {
        /// Significant digits of u that must be stable.
        digits: u32,
        /// Give up (with a finding) here.
        max: usize,
    },
}

/// A Monte Carlo calculation; the default is adaptive to two digits at 95 %.
///
/// Each block of trials has its own random stream, seeded by (seed, number of the block), and blocks are put
/// together in their order: the same seed gives the same bits on any number of threads.
///
/// **Memory** The inputs of a block and one double per output and trial: 8 bytes × outputs × trials at most.
///
/// ```
/// use proofmass_uncertainty::*;
/// struct Sum;
/// impl Model for Sum {
///     fn outputs(&self) -> Vec<(String, String)> { vec![("y".into(), "1".into())] }
///     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) { y[0] = x.iter().fold(T::from(0.0), |s, &x| s + x); }
/// }
/// let mut inputs = Inputs::new();
/// for name in ["a", "b", "c", "d"] {
///     let a = 3f64.sqrt();
///     inputs = inputs.add(Input::new(name, "1", Distribution::Rectangular { lower: -a, upper: a }));
/// }
/// let result = MonteCarlo::new(1).trials(Trials::Fixed(200_000)).run(&Sum, &inputs.single()?)?;
/// let y = result.get("y").unwrap();
/// assert!((y.standard_uncertainty.unwrap() - 2.0).abs() < 0.015);
/// assert!((y.symmetric.upper - 3.88).abs() < 0.04); // `[S1]` 9.2.3
/// # Ok::<(), Refusal>(())
/// ```
#[doc(alias("propagation of distributions", "MCM", "GUM Supplement 1"))]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MonteCarlo {
    /// Seed of all streams.
    pub seed: u64,
    /// Coverage probability of the intervals and regions.
    pub probability: f64,
    /// When to stop.
    pub trials: Trials,
}

/// How far a calculation has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Trials made.
    pub done: usize,
    /// Trials at which it ends at the latest.
    pub most: usize,
}

/// Trials per block at least. **Source** `[S1] 7.9.4 b`.
const BLOCK: usize = 10_000;
/// Trials that one thread takes at a time where several share a block.
const LEAST_SHARE: usize = 16;
/// Blocks between two looks at the stopping rule; fixed, so that the number of threads cannot matter.
const WAVE: usize = 8;
/// Blocks between two words on progress where nothing can stop the calculation early.
const LONG_WAVE: usize = 64;
/// Trials of a column that one thread takes at a time; fixed, so that sums are the same on any number of threads.
const CHUNK: usize = 1 << 14;

impl MonteCarlo {
    /// Values that are kept at most, all outputs together: 4 GiB.
    pub const MOST_VALUES: usize = 1 << 29;

    /// Adaptive to two digits of u, at most 10⁷ trials, 95 %.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            probability: 0.95,
            trials: Trials::Adaptive {
                digits: 2,
                max: 10_000_000,
            },
        }
    }

    /// Another coverage probability.
    #[must_use]
    pub fn probability(self, probability: f64) -> Self {
        Self {
            probability,
            ..self
        }
    }

    /// Another stopping rule.
    #[must_use]
    pub fn trials(self, trials: Trials) -> Self {
        Self { trials, ..self }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// As [`MonteCarlo::run_with`].
    pub fn run<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
    ) -> Result<Sampled, Refusal> {
        self.run_with(model, inputs, &mut |_| ControlFlow::Continue(()))
    }

    /// Runs and reports progress; `ControlFlow::Break` stops it.
    ///
    /// # Errors
    /// [`Refusal::Cancelled`]; [`Error::OutOfRange`] for a probability not inside (0, 1) or no trials;
    /// [`Error::NotFinite`] when no output is finite in enough trials to have an interval. Trials in which an output is
    /// not finite are left out of it, counted, and said in a finding.
    pub fn run_with<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Sampled, Refusal> {
        self.run_resolving(model, inputs, &[], progress)
    }

    /// As [`MonteCarlo::run_with`]; an adaptive run also goes on until the figures of each output are stable to half
    /// of these tolerances, one per output, so that a comparison with them can be decided. **Source** `[S1] 8.2`.
    ///
    /// # Errors
    /// As [`MonteCarlo::run_with`].
    pub fn run_resolving<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
        tolerances: &[f64],
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Sampled, Refusal> {
        let p = self.probability;
        check::probability(p)?;
        let outputs = model.names();
        let m = outputs.len();
        let sampler = Sampler::new(inputs)?;
        let block = self.block_size();
        // The values of every output are kept for their quantiles.
        let kept = Self::MOST_VALUES / m.max(1);
        let most = match self.trials {
            Trials::Fixed(n) => n,
            Trials::Adaptive { max, .. } => max.min(kept),
        };
        if most == 0 || m == 0 {
            return Err(Error::TooFew {
                name: "trials or outputs",
                needed: 1,
                got: 0,
            }
            .into());
        }
        if most > kept {
            return Err(Error::TooMany {
                name: "trials for the number of outputs",
                most: kept,
                got: most,
            }
            .into());
        }
        let blocks = most.div_ceil(block);
        let (wave, room) = match self.trials {
            Trials::Fixed(_) => (LONG_WAVE, blocks * block),
            Trials::Adaptive { .. } => (WAVE, 0),
        };
        let mut columns = columns_with_room(m, room)?;
        let mut stability = Stability::new(m);
        let circles = circles(model, inputs);
        let mut stable = false;
        let mut done = 0;
        while done < blocks && !stable {
            let wave = wave.min(blocks - done);
            // Fewer blocks than threads: the trials within a block are made by several.
            let portion = Portion {
                trials: block,
                shared: wave < rayon::current_num_threads(),
            };
            let values: Vec<Block> = (done..done + wave)
                .into_par_iter()
                .map(|number| self.block(model, &sampler, inputs, &circles, portion, number))
                .collect();
            for block in values {
                for (column, values) in columns.iter_mut().zip(&block.columns) {
                    let made = column.len();
                    if column.try_reserve(values.len()).is_err() {
                        return Err(no_memory(made, made + values.len()).into());
                    }
                    column.extend_from_slice(values);
                }
                stability.add(&block.figures);
            }
            done += wave;
            if let Trials::Adaptive { digits, .. } = self.trials {
                stable = stability.stable(digits, tolerances);
            }
            if progress(Progress {
                done: done * block,
                // What is stable makes no more.
                most: if stable { done } else { blocks } * block,
            })
            .is_break()
            {
                return Err(Refusal::Cancelled);
            }
        }
        let mut result = summarise(outputs, columns, p, sampler.heavy)?;
        let settled = result
            .outputs
            .iter()
            .all(|o| o.standard_uncertainty.is_some());
        if let (Trials::Adaptive { digits, .. }, false, true) = (self.trials, stable, settled) {
            result.findings.push(findings::too_few_trials(
                &format!("for a result that is stable to {digits} digits of u"),
                &format!("{} trials", done * block),
            ));
        }
        if !sampler.copula.is_empty() {
            result
                .findings
                .push(findings::normal_copula(&sampler.copula.join(", ")));
        }
        Ok(result)
    }

    /// Makes the trials of a calculation with this seed and probability again, a block at a time: one column per output.
    /// They are the same whenever it stops.
    ///
    /// # Errors
    /// [`Refusal::Cancelled`] where `each` breaks off; as [`MonteCarlo::run_with`] for probability and inputs.
    pub fn draws<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
        trials: usize,
        each: &mut dyn FnMut(&[Vec<f64>]) -> ControlFlow<()>,
    ) -> Result<(), Refusal> {
        check::probability(self.probability)?;
        let sampler = Sampler::new(inputs)?;
        let size = self.block_size();
        let circles = circles(model, inputs);
        // A fixed number needs no figures of each block.
        let plain = self.trials(Trials::Fixed(trials));
        let portion = Portion {
            trials: size,
            shared: true,
        };
        for number in 0..trials.div_ceil(size) {
            let mut block = plain.block(model, &sampler, inputs, &circles, portion, number);
            let left = trials - number * size;
            block.columns.iter_mut().for_each(|c| c.truncate(left));
            if each(&block.columns).is_break() {
                return Err(Refusal::Cancelled);
            }
        }
        Ok(())
    }

    /// Trials of a block. **Source** `[S1] 7.9.4`: it must hold enough outside the interval to have quantiles at all.
    fn block_size(&self) -> usize {
        BLOCK.max((100.0 / (1.0 - self.probability)).ceil().min(1e7) as usize)
    }

    fn block<M: Trial + Sync>(
        &self,
        model: &M,
        sampler: &Sampler,
        inputs: &JointInputs,
        circles: &[Option<(f64, f64)>],
        portion: Portion,
        number: usize,
    ) -> Block {
        let Portion {
            trials: size,
            shared,
        } = portion;
        let m = circles.len();
        // Two odd constants keep neighbouring seeds and blocks apart before seed_from_u64 mixes them again.
        let stream = self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (number as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(stream);
        let mut columns = vec![vec![0.0; size]; m];
        let mut strips = Strips::new(inputs.draws().len());
        let mut ahead = shared.then(|| Strips::new(inputs.draws().len()));
        let mut start = 0;
        while start < size {
            if start == 0 || ahead.is_none() {
                sampler.fill(&mut strips, &mut rng);
            }
            let count = strips.trials.min(size - start);
            let y: Columns = columns
                .iter_mut()
                .map(|column| &mut column[start..start + count])
                .collect();
            if let Some(ahead) = &mut ahead {
                // The next draws are made meanwhile.
                let more = start + count < size;
                rayon::join(
                    || shared_out(model, &strips, 0, y),
                    || more.then(|| sampler.fill(ahead, &mut rng)),
                );
                std::mem::swap(&mut strips, ahead);
            } else {
                in_turn(model, &strips, y);
            }
            start += count;
        }
        for (column, circle) in columns.iter_mut().zip(circles) {
            if circle.is_some() {
                for y in column {
                    *y = nearest_turn(*y, *circle);
                }
            }
        }
        let figures = match self.trials {
            Trials::Fixed(_) => Vec::new(),
            Trials::Adaptive { .. } => columns
                .iter()
                .map(|column| {
                    let mut copy: Vec<f64> =
                        column.iter().copied().filter(|v| v.is_finite()).collect();
                    if copy.len() < 2 {
                        return [f64::NAN; 4];
                    }
                    let (mean, sd) = mean_and_sd(&copy);
                    let interval = symmetric_interval(&mut copy, self.probability);
                    [mean, sd, interval.lower, interval.upper]
                })
                .collect(),
        };
        Block { columns, figures }
    }
}

/// How much is made at a time.
#[derive(Clone, Copy)]
struct Portion {
    /// Trials of a block.
    trials: usize,
    /// Whether several threads make it.
    shared: bool,
}

/// Trials by as many threads as have nothing else to do, a group of the strips at a time or some of it; `y` begins with a
/// group.
fn shared_out<M: Trial + Sync>(model: &M, strips: &Strips, group: usize, y: Columns) {
    let count = y.first().map_or(0, |y| y.len());
    if count <= strips.group {
        share_group(model, &strips.columns(group, count), y);
        return;
    }
    let groups = count.div_ceil(strips.group) / 2;
    let (y0, y1) = halves(y, groups * strips.group);
    rayon::join(
        || shared_out(model, strips, group, y0),
        || shared_out(model, strips, group + groups, y1),
    );
}

/// The trials of a group, likewise, about [`LEAST_SHARE`] at a time.
fn share_group<M: Trial + Sync>(model: &M, x: &[&[f64]], mut y: Columns) {
    let count = y.first().map_or(0, |y| y.len());
    if count / 2 < LEAST_SHARE {
        model.trials(x, &mut y);
        return;
    }
    // At a whole share, so that what is vectorised within the trials stays whole.
    let middle = (count / 2).next_multiple_of(LEAST_SHARE);
    let (x0, x1): (Vec<&[f64]>, Vec<&[f64]>) = x.iter().map(|x| x.split_at(middle)).unzip();
    let (y0, y1) = halves(y, middle);
    rayon::join(
        || share_group(model, &x0, y0),
        || share_group(model, &x1, y1),
    );
}

/// All trials of the strips, group by group.
fn in_turn<M: Trial>(model: &M, strips: &Strips, mut y: Columns) {
    for group in 0.. {
        let count = y.first().map_or(0, |y| y.len());
        if count <= strips.group {
            model.trials(&strips.columns(group, count), &mut y);
            return;
        }
        let (mut here, rest) = halves(y, strips.group);
        model.trials(&strips.columns(group, strips.group), &mut here);
        y = rest;
    }
}

/// Outputs of some trials, a column each.
type Columns<'a> = Vec<&'a mut [f64]>;

/// The trials before one, and those from it on.
fn halves(y: Columns<'_>, middle: usize) -> (Columns<'_>, Columns<'_>) {
    y.into_iter().map(|y| y.split_at_mut(middle)).unzip()
}

struct Block {
    columns: Vec<Vec<f64>>,
    /// Per output: mean, u, lower and upper end.
    figures: Vec<[f64; 4]>,
}

/// A column for the trials of each output, whose memory is there before the first trial is made.
fn columns_with_room(outputs: usize, room: usize) -> Result<Vec<Vec<f64>>, Error> {
    let reserved = |room: usize| -> Option<Vec<Vec<f64>>> {
        let column = |_| {
            let mut column = Vec::new();
            column.try_reserve_exact(room).is_ok().then_some(column)
        };
        (0..outputs).map(column).collect()
    };
    reserved(room).ok_or_else(|| {
        let mut fits = room;
        while fits > 0 && reserved(fits).is_none() {
            fits /= 2;
        }
        no_memory(fits, room)
    })
}

fn no_memory(most: usize, got: usize) -> Error {
    Error::TooMany {
        name: "trials for the memory that this process may have",
        most,
        got,
    }
}
