//! What each cause does to a result, by Monte Carlo: a budget for models that are not linear within the uncertainties.

use crate::monte_carlo::{circles, nearest_turn};
use crate::sampler::{STRIP, Sampler, Strips};
use crate::{JointInputs, MonteCarlo, Refusal, Trial};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What one cause does to one output. Inputs that are correlated, or drawn together, are one cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CauseEffect {
    /// The inputs that are this cause.
    pub inputs: Vec<String>,
    /// Standard deviation of the output when only this cause varies and the others stay at their estimates. **Source**
    /// `[S1] annex B`.
    pub alone: f64,
    /// Share of the variance that goes when this cause is known: first-order index of Sobol. **Source** `[Saltelli2010]`.
    pub first: f64,
    /// Share of the variance that stays when only this cause is unknown: total index. Over all causes these sum to more
    /// than 1 where causes act through each other. **Source** `[Saltelli2010]`, estimator of Jansen.
    pub total: f64,
}

/// The causes of every output, as [`MonteCarlo::effects`] finds them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OutputEffects {
    /// Name of the output.
    pub name: String,
    /// Trials in which the output was a number.
    pub trials: usize,
    /// Largest total share first.
    pub causes: Vec<CauseEffect>,
}

/// Trials that one thread takes at a time; fixed, so that sums are the same on any number of threads.
const BLOCK: usize = 4096;

/// Sums over trials for one cause and one output.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Trials in which all of the others are numbers.
    count: f64,
    /// Σ (f(A) − f(C))²
    parted: f64,
    /// Σ f(B) (f(C) − f(A))
    kept: f64,
    /// Σ f and Σ f² with only this cause at work.
    alone: [f64; 3],
}

/// Sums over trials for one output.
#[derive(Clone, Copy, Default)]
struct Whole {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Sums {
    /// One trial: f(A), f(B), f(C).
    fn add(&mut self, a: f64, b: f64, c: f64) {
        if a.is_finite() && b.is_finite() && c.is_finite() {
            self.count += 1.0;
            self.parted += (a - c).powi(2);
            self.kept += b * (c - a);
        }
    }

    fn add_alone(&mut self, f: f64) {
        if f.is_finite() {
            self.alone[0] += 1.0;
            self.alone[1] += f;
            self.alone[2] += f * f;
        }
    }
}

impl Whole {
    fn add(&mut self, f: f64) {
        if f.is_finite() {
            self.count += 1.0;
            self.sum += f;
            self.squares += f * f;
        }
    }
}

impl MonteCarlo {
    /// The share of every cause in the variance of every output, from `trials` pairs of trials.
    ///
    /// Two independent sets A and B of all inputs; for each cause a third, C, that is A with this cause from B; and one
    /// with this cause alone. **Cost** 2 + 2 × causes evaluations of the model per trial. **Accuracy** about 1.5/√trials of
    /// the variance for the shares.
    ///
    /// ```
    /// use proofmass_uncertainty::*;
    /// struct Product;
    /// impl Model for Product {
    ///     fn outputs(&self) -> Vec<(String, String)> { vec![("y".into(), "1".into())] }
    ///     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) { y[0] = x[0] * x[1] + x[2]; }
    /// }
    /// let input = |name: &str| Input::new(name, "1", Distribution::Normal { mean: 0.0, u: 1.0 });
    /// let inputs = Inputs::new().add(input("a")).add(input("b")).add(input("c")).single()?;
    /// let effects = MonteCarlo::new(1).effects(&Product, &inputs, 40_000)?;
    /// let of = |name: &str| effects[0].causes.iter().find(|c| c.inputs == [name]).unwrap();
    /// // a and b do nothing alone, and half of the variance together.
    /// assert!(of("a").alone == 0.0 && of("a").first.abs() < 0.03 && (of("a").total - 0.5).abs() < 0.03);
    /// assert!((of("c").first - 0.5).abs() < 0.03 && (of("c").alone - 1.0).abs() < 0.02);
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// As [`MonteCarlo::run`], for what cannot be drawn.
    pub fn effects<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
        trials: usize,
    ) -> Result<Vec<OutputEffects>, Refusal> {
        let sampler = Sampler::new(inputs)?;
        let names = model.names();
        let m = names.len();
        let circles = circles(model, inputs);
        let estimates = inputs.estimates();
        let n = estimates.len();
        let causes = causes(inputs);
        // Sums are taken about the estimate, which keeps the digits of nearly equal values.
        let mut centre = vec![0.0; m];
        model.trial(&estimates, &mut centre);
        centre
            .iter_mut()
            .filter(|c| !c.is_finite())
            .for_each(|c| *c = 0.0);
        let evaluate = |x: &[&[f64]], y: &mut [Vec<f64>]| {
            let mut columns: Vec<&mut [f64]> = y.iter_mut().map(Vec::as_mut_slice).collect();
            model.trials(x, &mut columns);
            for ((column, circle), centre) in y.iter_mut().zip(&circles).zip(&centre) {
                for y in column {
                    *y = nearest_turn(*y, *circle) - centre;
                }
            }
        };
        let constant: Vec<Vec<f64>> = estimates.iter().map(|x| vec![*x; STRIP]).collect();
        let blocks = trials.div_ceil(BLOCK).max(1);
        let parts: Vec<(Vec<Whole>, Vec<Sums>)> = (0..blocks)
            .into_par_iter()
            .map(|block| {
                let mut wholes = vec![Whole::default(); m];
                let mut sums = vec![Sums::default(); m * causes.len()];
                let stream = |set: u64| {
                    let word = self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)
                        ^ (2 * block as u64 + set + 1).wrapping_mul(0xA24B_AED4_963E_E407);
                    Xoshiro256PlusPlus::seed_from_u64(word)
                };
                let mut streams = [stream(0), stream(1)];
                let (mut a, mut b) = (Strips::of(n, STRIP), Strips::of(n, STRIP));
                let room = || vec![vec![0.0; STRIP]; m];
                let (mut fa, mut fb, mut f) = (room(), room(), room());
                for _ in 0..BLOCK / STRIP {
                    sampler.fill(&mut a, &mut streams[0]);
                    sampler.fill(&mut b, &mut streams[1]);
                    let (a, b) = (a.columns(0, STRIP), b.columns(0, STRIP));
                    evaluate(&a, &mut fa);
                    evaluate(&b, &mut fb);
                    for (whole, column) in wholes.iter_mut().zip(&fa) {
                        column.iter().for_each(|v| whole.add(*v));
                    }
                    for (cause, sums) in causes.iter().zip(sums.chunks_exact_mut(m.max(1))) {
                        let mut mixed = a.clone();
                        cause.iter().for_each(|&d| mixed[d] = b[d]);
                        evaluate(&mixed, &mut f);
                        for (k, sums) in sums.iter_mut().enumerate() {
                            let trials = fa[k].iter().zip(&fb[k]).zip(&f[k]);
                            trials.for_each(|((a, b), c)| sums.add(*a, *b, *c));
                        }
                        let mut mixed: Vec<&[f64]> = constant.iter().map(Vec::as_slice).collect();
                        cause.iter().for_each(|&d| mixed[d] = a[d]);
                        evaluate(&mixed, &mut f);
                        for (k, sums) in sums.iter_mut().enumerate() {
                            f[k].iter().for_each(|v| sums.add_alone(*v));
                        }
                    }
                }
                (wholes, sums)
            })
            .collect();
        let mut wholes = vec![Whole::default(); m];
        let mut sums = vec![Sums::default(); m * causes.len()];
        for (whole, part) in &parts {
            for (total, part) in wholes.iter_mut().zip(whole) {
                total.count += part.count;
                total.sum += part.sum;
                total.squares += part.squares;
            }
            for (total, part) in sums.iter_mut().zip(part) {
                total.count += part.count;
                total.parted += part.parted;
                total.kept += part.kept;
                for (total, part) in total.alone.iter_mut().zip(part.alone) {
                    *total += part;
                }
            }
        }
        let draws = inputs.draws();
        let outputs = names.into_iter().enumerate().map(|(k, (name, _))| {
            let whole = wholes[k];
            let variance = variance(whole.count, whole.sum, whole.squares);
            let share = |sum: f64, count: f64| {
                if variance > 0.0 && count > 0.0 {
                    sum / (count * variance)
                } else {
                    0.0
                }
            };
            let mut effects: Vec<CauseEffect> = causes
                .iter()
                .enumerate()
                .map(|(c, cause)| {
                    let sums = sums[c * m + k];
                    let mut names: Vec<String> = Vec::new();
                    for &d in cause {
                        let name = inputs.input_name(draws[d].input);
                        if names.last().is_none_or(|last| last != name) {
                            names.push(name.to_owned());
                        }
                    }
                    CauseEffect {
                        inputs: names,
                        alone: self::variance(sums.alone[0], sums.alone[1], sums.alone[2]).sqrt(),
                        first: share(sums.kept, sums.count),
                        total: 0.5 * share(sums.parted, sums.count),
                    }
                })
                .collect();
            effects.sort_by(|a, b| b.total.total_cmp(&a.total));
            OutputEffects {
                name,
                trials: whole.count as usize,
                causes: effects,
            }
        });
        Ok(outputs.collect())
    }
}

fn variance(count: f64, sum: f64, squares: f64) -> f64 {
    if count < 2.0 {
        return 0.0;
    }
    let variance = (squares - sum * sum / count) / (count - 1.0);
    // What is left of equal values is rounding.
    if variance > 1e-13 * squares / count {
        variance
    } else {
        0.0
    }
}

/// Draws that vary as one: all of a correlated cluster or of an ensemble, else those of one input; constants are none.
fn causes(inputs: &JointInputs) -> Vec<Vec<usize>> {
    let mut causes: Vec<Vec<usize>> = Vec::new();
    for cluster in &inputs.clusters {
        let varies = |d: &&usize| inputs.draws[**d].standard_uncertainty > 0.0;
        let draws: Vec<usize> = cluster.draws.iter().filter(varies).copied().collect();
        if draws.is_empty() {
            continue;
        }
        causes.push(draws);
    }
    causes
}
