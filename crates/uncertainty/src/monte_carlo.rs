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
/// assert!((result.get("median").unwrap().standard_uncertainty / 0.1 - 0.6698).abs() < 0.01);
/// # Ok::<(), Refusal>(())
/// ```
pub trait Trial {
    /// Names and units of the outputs.
    fn names(&self) -> Vec<(String, String)>;
    /// The outputs of one trial: one input per draw, in the order of [`JointInputs::draws`].
    fn trial(&self, x: &[f64], y: &mut [f64]);
}

impl<M: Model> Trial for M {
    fn names(&self) -> Vec<(String, String)> {
        self.outputs()
    }
    fn trial(&self, x: &[f64], y: &mut [f64]) {
        self.evaluate(x, y);
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
/// assert!((y.standard_uncertainty - 2.0).abs() < 0.015);
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
    /// [`Error::NotFinite`] when the model is not finite somewhere in the distribution of its inputs (the index
    /// is that of the output).
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
        let most = match self.trials {
            Trials::Fixed(n) => n,
            Trials::Adaptive { max, .. } => max,
        };
        if most == 0 || m == 0 {
            return Err(Error::TooFew {
                name: "trials or outputs",
                needed: 1,
                got: 0,
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
        let mut stable = false;
        let mut done = 0;
        while done < blocks && !stable {
            let wave = wave.min(blocks - done);
            let values: Vec<Block> = (done..done + wave)
                .into_par_iter()
                .map(|number| self.block(model, &sampler, inputs, m, block, number))
                .collect::<Result<_, Error>>()?;
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
        let mut result = summarise(outputs, columns, p)?;
        if let (Trials::Adaptive { digits, .. }, false) = (self.trials, stable) {
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
        m: usize,
        size: usize,
        number: usize,
    ) -> Result<Block, Error> {
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
        if let Some(index) = columns
            .iter()
            .position(|c| c.iter().any(|v| !v.is_finite()))
        {
            return Err(Error::NotFinite {
                name: "model output in a trial",
                index,
            });
        }
        let figures = match self.trials {
            Trials::Fixed(_) => Vec::new(),
            Trials::Adaptive { .. } => columns
                .iter()
                .map(|column| {
                    let (mean, sd) = mean_and_sd(column);
                    let mut copy = column.clone();
                    let interval = symmetric_interval(&mut copy, self.probability);
                    [mean, sd, interval.lower, interval.upper]
                })
                .collect(),
        };
        Ok(Block { columns, figures })
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
            let asked = tolerances.get(k).map_or(f64::INFINITY, |t| 0.5 * t);
            let delta = numerical_tolerance(mean[1], digits).min(asked);
            squares
                .iter()
                .all(|s| 2.0 * (s / (h * (h - 1.0))).sqrt() <= delta)
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
    /// Mean of the trials.
    pub mean: f64,
    /// Standard deviation of the trials.
    pub standard_uncertainty: f64,
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
    /// Outputs in the order of the model.
    pub outputs: Vec<SampledOutput>,
    /// Joint covariance of the outputs.
    pub covariance: Covariance,
    /// Joint region; absent for one output, or when the covariance is singular.
    pub region: Option<Region>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl Sampled {
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

fn summarise(
    outputs: Vec<(String, String)>,
    columns: Vec<Vec<f64>>,
    p: f64,
) -> Result<Sampled, Refusal> {
    let (m, trials) = (columns.len(), columns[0].len());
    let moments: Vec<(f64, f64)> = columns.iter().map(|c| mean_and_sd(c)).collect();
    let mut rows = vec![0.0; m * m];
    for i in 0..m {
        for j in 0..=i {
            let sum: f64 = if i == j {
                moments[i].1.powi(2) * (trials as f64 - 1.0)
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
            rows[i * m + j] = sum / (trials as f64 - 1.0);
            rows[j * m + i] = rows[i * m + j];
        }
    }
    let covariance = Covariance::try_from_rows(m, &rows)?;
    let region = (m > 1)
        .then(|| region(&columns, &moments, &covariance, p))
        .flatten();
    let (r, q) = ranks(trials, p);
    let outputs = outputs
        .into_iter()
        .zip(&columns)
        .zip(&moments)
        .map(|(((name, unit), column), &(mean, u))| {
            let histogram = Histogram::count(column, mean, u, CHUNK);
            // Only the two tails decide the intervals: ranks 0 to trials − q can be lower ends, q and more upper ends.
            let count = trials - q + 1;
            let (low, high) = rayon::join(
                || smallest(column, count, |v| v),
                || smallest(column, count, |v| -v),
            );
            let (lower, upper) = (
                |rank: usize| low[rank],
                |rank: usize| -high[trials - 1 - rank],
            );
            let shortest = (0..trials - q)
                .min_by(|&a, &b| (upper(a + q) - lower(a)).total_cmp(&(upper(b + q) - lower(b))))
                .unwrap_or(r);
            SampledOutput {
                name,
                unit,
                mean,
                standard_uncertainty: u,
                symmetric: Interval {
                    lower: lower(r),
                    upper: upper(r + q),
                },
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
                histogram,
            }
        })
        .collect();
    Ok(Sampled {
        trials,
        probability: p,
        outputs,
        covariance,
        region,
        findings: Vec::new(),
    })
}
