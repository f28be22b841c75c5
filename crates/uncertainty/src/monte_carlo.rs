//! Propagation of distributions by Monte Carlo.

use crate::region::{Region, region};
use crate::sampler::{STRIP, Sampler};
use crate::{
    Covariance, Finding, Histogram, JointInputs, Model, Refusal, Severity, numerical_tolerance,
};
use proofmass_core::Error;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

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
    fn circles(&self) -> Vec<Option<f64>> {
        self.periods()
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
        if !(p > 0.0 && p < 1.0) {
            return Err(Error::OutOfRange {
                name: "probability",
                value: p,
                min: 0.0,
                max: 1.0,
            }
            .into());
        }
        let outputs = model.names();
        let m = outputs.len();
        let sampler = Sampler::new(inputs)?;
        // `[S1]` 7.9.4: a block must hold enough trials outside the interval to have quantiles at all.
        let block = BLOCK.max((100.0 / (1.0 - p)).ceil().min(1e7) as usize);
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
        // A number of trials that no memory holds must fail when it is reached, not before it begins.
        let room = room.min(1 << 24);
        let mut columns: Vec<Vec<f64>> = (0..m).map(|_| Vec::with_capacity(room)).collect();
        let mut stability = Stability::new(m);
        let circles = circles(model, inputs);
        let mut stable = false;
        let mut done = 0;
        while done < blocks && !stable {
            let wave = wave.min(blocks - done);
            let values: Vec<Block> = (done..done + wave)
                .into_par_iter()
                .map(|number| self.block(model, &sampler, inputs, &circles, block, number))
                .collect();
            for block in values {
                for (column, values) in columns.iter_mut().zip(&block.columns) {
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
                most: blocks * block,
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
            result.findings.push(
                Finding::new(
                    Severity::Warning,
                    "monte-carlo-not-stable",
                    format!("the result is not stable to {digits} digits of u"),
                )
                .evidence(format!("{} trials", done * block))
                .advice("allow more trials or ask for fewer digits"),
            );
        }
        if !sampler.copula.is_empty() {
            result.findings.push(
                Finding::new(
                    Severity::Note,
                    "normal-copula",
                    "correlated inputs that are not normal were joined by a normal copula",
                )
                .evidence(sampler.copula.join(", "))
                .advice("their correlation coefficient then differs a little from the one given"),
            );
        }
        Ok(result)
    }

    fn block<M: Trial + Sync>(
        &self,
        model: &M,
        sampler: &Sampler,
        inputs: &JointInputs,
        circles: &[Option<(f64, f64)>],
        size: usize,
        number: usize,
    ) -> Block {
        let m = circles.len();
        // Two odd constants keep neighbouring seeds and blocks apart before seed_from_u64 mixes them again.
        let stream = self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (number as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(stream);
        let n = inputs.draws().len();
        let mut columns = vec![vec![0.0; size]; m];
        let mut y = vec![0.0; m];
        let width = n.max(1); // a model of constants has no inputs
        let mut rows = vec![0.0; width * STRIP];
        let mut start = 0;
        while start < size {
            sampler.fill(&mut rows, &mut rng);
            let count = STRIP.min(size - start);
            for (t, x) in rows.chunks_exact(width).take(count).enumerate() {
                model.trial(&x[..n], &mut y);
                for (column, y) in columns.iter_mut().zip(&y) {
                    column[start + t] = *y;
                }
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

struct Block {
    columns: Vec<Vec<f64>>,
    /// Per output: mean, u, lower and upper end.
    figures: Vec<[f64; 4]>,
}

/// The stopping rule of `[S1] 7.9.4`: twice the standard deviation of the average over blocks below δ.
struct Stability {
    count: f64,
    mean: Vec<[f64; 4]>,
    squares: Vec<[f64; 4]>,
}

impl Stability {
    fn new(m: usize) -> Self {
        Self {
            count: 0.0,
            mean: vec![[0.0; 4]; m],
            squares: vec![[0.0; 4]; m],
        }
    }

    fn add(&mut self, figures: &[[f64; 4]]) {
        self.count += 1.0;
        for (k, figures) in figures.iter().enumerate() {
            for (f, value) in figures.iter().enumerate() {
                let step = value - self.mean[k][f];
                self.mean[k][f] += step / self.count;
                self.squares[k][f] += step * (value - self.mean[k][f]);
            }
        }
    }

    fn stable(&self, digits: u32, tolerances: &[f64]) -> bool {
        let h = self.count;
        let columns = self.mean.iter().zip(&self.squares).enumerate();
        columns.into_iter().all(|(k, (mean, squares))| {
            let asked = tolerances.get(k).filter(|t| **t > 0.0);
            let asked = asked.map_or(f64::INFINITY, |t| 0.5 * t);
            let delta = numerical_tolerance(mean[1], digits).min(asked);
            // An output without valid trials has nothing to wait for.
            squares
                .iter()
                .all(|s| s.is_nan() || 2.0 * (s / (h * (h - 1.0))).sqrt() <= delta)
        })
    }
}

/// Two ends of a coverage interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Upper minus lower end.
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }
}

/// One output of a Monte Carlo calculation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampledOutput {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Trials in which it was not a finite number; everything below is of the others.
    pub invalid: usize,
    /// Mean of the trials; without meaning where there is no standard uncertainty.
    pub mean: f64,
    /// Value that half of the trials exceed.
    pub median: f64,
    /// Standard deviation of the trials; absent where their tails are so heavy that it does not settle however many
    /// are made.
    pub standard_uncertainty: Option<f64>,
    /// Probabilistically symmetric interval.
    pub symmetric: Interval,
    /// Standard uncertainty of its ends from the number of trials, the larger of the two.
    pub symmetric_scatter: f64,
    /// Shortest interval.
    pub shortest: Interval,
    /// The distribution, for drawing.
    pub histogram: Histogram,
}

/// Result of a Monte Carlo calculation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampled {
    /// Trials made.
    pub trials: usize,
    /// Coverage probability of intervals and region.
    pub probability: f64,
    /// Outputs in the order of the model; one that is finite in too few trials to have an interval is absent.
    pub outputs: Vec<SampledOutput>,
    /// Joint covariance of these outputs, over the trials in which all are finite.
    pub covariance: Covariance,
    /// Joint region; absent for one output, or when the covariance is singular.
    pub region: Option<Region>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl Sampled {
    /// Of no trials.
    #[cfg(feature = "model")]
    pub(crate) fn none(probability: f64) -> Self {
        Self {
            trials: 0,
            probability,
            outputs: Vec::new(),
            covariance: Covariance::zeros(0),
            region: None,
            findings: Vec::new(),
        }
    }

    /// One output by name.
    pub fn get(&self, name: &str) -> Option<&SampledOutput> {
        self.outputs.iter().find(|o| o.name == name)
    }
}

/// Sum in partial sums: rounding grows with the number of partial sums, not of terms, and the order of the
/// additions does not depend on the number of threads.
fn total(values: &[f64], term: impl Fn(f64) -> f64 + Sync) -> f64 {
    let partial: Vec<f64> = values
        .par_chunks(CHUNK)
        .map(|chunk| {
            // Eight sums side by side do not wait for each other.
            let mut sums = [0.0; 8];
            let (eights, rest) = chunk.as_chunks::<8>();
            for eight in eights {
                for (sum, v) in sums.iter_mut().zip(eight) {
                    *sum += term(*v);
                }
            }
            sums.iter().sum::<f64>() + rest.iter().map(|v| term(*v)).sum::<f64>()
        })
        .collect();
    partial.iter().sum()
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let first = values[0]; // an offset keeps the digits of nearly equal values
    let mean = first + total(values, |v| v - first) / n;
    let variance = total(values, |v| (v - mean) * (v - mean)) / (n - 1.0);
    (mean, variance.max(0.0).sqrt())
}

/// Ranks of the symmetric interval among M sorted values: q = pM inside, (M − q)/2 below. **Source** `[S1] 7.7.2`.
fn ranks(n: usize, p: f64) -> (usize, usize) {
    let q = ((p * n as f64 + 0.5).floor() as usize).clamp(1, n - 1);
    let r = (n - q).div_ceil(2).max(1) - 1;
    (r, q)
}

fn symmetric_interval(values: &mut [f64], p: f64) -> Interval {
    let (r, q) = ranks(values.len(), p);
    let (_, lower, rest) = values.select_nth_unstable_by(r, f64::total_cmp);
    let lower = *lower;
    let (_, upper, _) = rest.select_nth_unstable_by(q - 1, f64::total_cmp);
    Interval {
        lower,
        upper: *upper,
    }
}

/// The `count` smallest of `side(value)`, in ascending order.
///
/// A sample tells below which value they must lie, so that only those below are sorted; when the sample errs,
/// everything is.
fn smallest(values: &[f64], count: usize, side: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let below = |limit: f64| -> Vec<f64> {
        let chunks = values.par_chunks(CHUNK);
        chunks
            .flat_map_iter(|chunk| chunk.iter().map(|v| side(*v)).filter(|v| *v <= limit))
            .collect()
    };
    let mut sample: Vec<f64> = values
        .iter()
        .step_by((values.len() >> 13).max(1))
        .map(|v| side(*v))
        .collect();
    let expected = count as f64 * sample.len() as f64 / values.len() as f64;
    // Five standard deviations of the number in the sample.
    let rank = (expected + 5.0 * expected.sqrt() + 8.0) as usize;
    let mut tail = Vec::new();
    if rank < sample.len() {
        let (_, limit, _) = sample.select_nth_unstable_by(rank, f64::total_cmp);
        tail = below(*limit);
    }
    if tail.len() < count {
        tail = below(f64::INFINITY);
    }
    tail.par_sort_unstable_by(f64::total_cmp);
    tail.truncate(count);
    tail
}

/// The value counted half a period to either side of the estimate, for an output that lives on a circle.
pub(crate) fn nearest_turn(y: f64, circle: Option<(f64, f64)>) -> f64 {
    circle.map_or(y, |(centre, period)| {
        y - period * ((y - centre) / period).round()
    })
}

/// Estimate and period of the outputs that live on a circle.
pub(crate) fn circles<M: Trial>(model: &M, inputs: &JointInputs) -> Vec<Option<(f64, f64)>> {
    let m = model.names().len();
    let periods = model.circles();
    let mut centre = vec![0.0; m];
    if periods.iter().any(Option::is_some) {
        model.trial(&inputs.estimates(), &mut centre);
    }
    (0..m)
        .map(|k| {
            let period = periods.get(k).copied().flatten()?;
            (centre[k].is_finite() && period > 0.0).then_some((centre[k], period))
        })
        .collect()
}

/// The trials without those in which an output is not finite.
struct Valid {
    outputs: Vec<(String, String)>,
    /// One column per output that keeps enough trials, and how many it lost.
    columns: Vec<(Vec<f64>, usize)>,
    /// The trials in which all of these are finite, where any was lost.
    joint: Option<Vec<Vec<f64>>>,
    findings: Vec<Finding>,
}

impl Valid {
    fn of(outputs: Vec<(String, String)>, columns: Vec<Vec<f64>>, p: f64) -> Result<Self, Refusal> {
        let trials = columns[0].len();
        // Ten trials outside the interval are the least that can place its ends.
        let needed = (10.0 / (1.0 - p)).ceil().max(2.0) as usize;
        let mut result = Self {
            outputs: Vec::new(),
            columns: Vec::new(),
            joint: None,
            findings: Vec::new(),
        };
        let mut kept = Vec::new();
        for ((name, unit), column) in outputs.into_iter().zip(columns) {
            let valid = column.par_iter().filter(|v| v.is_finite()).count();
            let invalid = trials - valid;
            result
                .findings
                .extend(left_out(&name, invalid, trials, p, valid >= needed));
            if valid >= needed {
                result.outputs.push((name, unit));
                kept.push((column, invalid));
            }
        }
        if kept.is_empty() {
            return Err(Error::NotFinite {
                name: "model output in a trial",
                index: 0,
            }
            .into());
        }
        if kept.iter().any(|(_, invalid)| *invalid > 0) {
            let whole: Vec<usize> = (0..trials)
                .filter(|&t| kept.iter().all(|(column, _)| column[t].is_finite()))
                .collect();
            let pick = |column: &Vec<f64>| whole.iter().map(|&t| column[t]).collect();
            result.joint = Some(kept.iter().map(|(column, _)| pick(column)).collect());
            for (column, _) in &mut kept {
                column.retain(|v| v.is_finite());
            }
        }
        result.columns = kept;
        Ok(result)
    }
}

/// Says how many trials had to be left out.
fn left_out(name: &str, invalid: usize, trials: usize, p: f64, enough: bool) -> Option<Finding> {
    if invalid == 0 {
        return None;
    }
    let share = invalid as f64 / trials as f64;
    // Below a hundredth of what lies outside the interval they cannot move its ends visibly.
    let severity = if share > 0.01 * (1.0 - p) {
        Severity::Decision
    } else {
        Severity::Note
    };
    let what = if enough {
        format!(
            "{name} is not a finite number in some trials; its Monte Carlo result is that of the others"
        )
    } else {
        format!("{name} is not a finite number in almost all trials; it has no Monte Carlo result")
    };
    Some(
        Finding::new(severity, "invalid-trials", what)
            .evidence(format!("{invalid} of {trials}, {} %", crate::scientific(100.0 * share, 2)))
            .advice(
                "state the distributions of the inputs so that they keep to what is possible: truncated, rectangular, \
                 lognormal",
            ),
    )
}

fn summarise(
    outputs: Vec<(String, String)>,
    columns: Vec<Vec<f64>>,
    p: f64,
    heavy: bool,
) -> Result<Sampled, Refusal> {
    let trials = columns[0].len();
    let valid = Valid::of(outputs, columns, p)?;
    let mut findings = valid.findings;
    let joint = valid.joint.as_ref().filter(|joint| joint[0].len() > 1);
    let own: Vec<&Vec<f64>> = valid.columns.iter().map(|(column, _)| column).collect();
    let columns: Vec<&Vec<f64>> = joint.map_or_else(|| own.clone(), |joint| joint.iter().collect());
    let m = columns.len();
    let moments: Vec<(f64, f64)> = columns.iter().map(|c| mean_and_sd(c)).collect();
    let mut rows = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            let last = columns[i].len() as f64 - 1.0;
            // Columns of unequal length exist only where no trial is valid in all of them.
            let sum: f64 = if i == j {
                moments[i].1.powi(2) * last
            } else if columns[i].len() != columns[j].len() {
                0.0
            } else {
                let products =
                    columns[i]
                        .chunks(4096)
                        .zip(columns[j].chunks(4096))
                        .map(|(a, b)| {
                            let pairs = a.iter().zip(b);
                            pairs
                                .map(|(a, b)| (a - moments[i].0) * (b - moments[j].0))
                                .sum::<f64>()
                        });
                products.sum()
            };
            rows[i * m + j] = sum / last;
            rows[j * m + i] = rows[i * m + j];
        }
    }
    let covariance = Covariance::try_from_rows(m, &rows)?;
    let equal = columns.iter().all(|c| c.len() == columns[0].len());
    let region = (m > 1 && equal)
        .then(|| region(&columns, &moments, &covariance, p))
        .flatten();
    let outputs: Vec<SampledOutput> = valid
        .outputs
        .iter()
        .zip(&valid.columns)
        .map(|((name, unit), (column, invalid))| {
            let output = output(name.clone(), unit.clone(), column, *invalid, p, heavy);
            if output.standard_uncertainty.is_none() {
                findings.push(no_standard_deviation(name));
            }
            output
        })
        .collect();
    Ok(Sampled {
        trials,
        probability: p,
        outputs,
        covariance,
        region,
        findings,
    })
}

fn no_standard_deviation(name: &str) -> Finding {
    Finding::new(
        Severity::Warning,
        "no-standard-deviation",
        format!("the trials of {name} have tails so heavy that their standard deviation does not settle"),
    )
    .advice(
        "state the Monte Carlo interval with the median; look for a division by something that reaches zero, and for \
         inputs from three observations or fewer",
    )
}

fn output(
    name: String,
    unit: String,
    column: &[f64],
    invalid: usize,
    p: f64,
    heavy: bool,
) -> SampledOutput {
    let trials = column.len();
    let (r, q) = ranks(trials, p);
    let (mean, u) = mean_and_sd(column);
    // Only the two tails decide the intervals: ranks 0 to trials − q can be lower ends, q and more upper ends.
    let count = trials - q + 1;
    let ((low, high), median) = rayon::join(
        || {
            rayon::join(
                || smallest(column, count, |v| v),
                || smallest(column, count, |v| -v),
            )
        },
        || {
            let mut copy = column.to_vec();
            *copy.select_nth_unstable_by(trials / 2, f64::total_cmp).1
        },
    );
    let (lower, upper) = (
        |rank: usize| low[rank],
        |rank: usize| -high[trials - 1 - rank],
    );
    let shortest = (0..trials - q)
        .min_by(|&a, &b| (upper(a + q) - lower(a)).total_cmp(&(upper(b + q) - lower(b))))
        .unwrap_or(r);
    let symmetric = Interval {
        lower: lower(r),
        upper: upper(r + q),
    };
    let settles = u.is_finite() && !heavy_tails(&low, &high, median, trials, heavy);
    // Bins about the middle that exists.
    let (centre, spread) = if settles {
        (mean, u)
    } else {
        (median, 0.25 * symmetric.width())
    };
    SampledOutput {
        name,
        unit,
        invalid,
        mean: if mean.is_finite() { mean } else { median },
        median,
        standard_uncertainty: settles.then_some(u),
        symmetric,
        symmetric_scatter: {
            // The rank of a quantile is binomial: one standard deviation of it to either side.
            let share = (r + 1) as f64 / trials as f64;
            let step = (trials as f64 * share * (1.0 - share)).sqrt().ceil() as usize;
            let (below, above) = (r.saturating_sub(step), (r + step).min(count - 1));
            0.5 * (low[above] - low[below]).max(high[above] - high[below])
        },
        shortest: Interval {
            lower: lower(shortest),
            upper: upper(shortest + q),
        },
        histogram: Histogram::count(column, centre, spread, CHUNK),
    }
}

/// Whether the standard deviation of the trials has no limit: the tail index of Hill, from the thousandth of the trials
/// that lies farthest out, is below 2 by more than twice its standard error. Where an input is known to have none
/// (Student t with ν ≤ 2) an index that may well be 2 suffices.
///
/// **Accuracy** on Student t with ν = 3, whose index is 3, a false alarm in fewer than one of a thousand runs of 20 000
/// trials; 1/x with x from N(3, 1), whose index is 1, is found in 95 %. **Source** `[Hill1975]`.
fn heavy_tails(low: &[f64], high: &[f64], median: f64, trials: usize, known: bool) -> bool {
    let k = (trials / 1000).clamp(20, 2000);
    let (mut i, mut j) = (0, 0);
    let mut farthest = Vec::with_capacity(k + 1);
    while farthest.len() <= k {
        let below = low.get(i).map(|v| median - v);
        let above = high.get(j).map(|v| -v - median);
        match (below, above) {
            (Some(b), Some(a)) if b >= a => {
                farthest.push(b);
                i += 1;
            }
            (_, Some(a)) => {
                farthest.push(a);
                j += 1;
            }
            (Some(b), None) => {
                farthest.push(b);
                i += 1;
            }
            (None, None) => return false,
        }
    }
    let last = farthest[k];
    if !(last > 0.0) {
        return false;
    }
    let mean_log = farthest[..k].iter().map(|d| (d / last).ln()).sum::<f64>() / k as f64;
    let error = 2.0 / (k as f64).sqrt();
    let index = 1.0 / mean_log;
    if known {
        index * (1.0 - error) < 2.0
    } else {
        index * (1.0 + error) < 2.0
    }
}
