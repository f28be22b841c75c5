//! Propagation against Monte Carlo: does the linear budget hold for each term of S?

mod trial;

use super::adjustment::Adjustment;
use super::budget::Budget;
use super::matrix::{AXES, Matrix, row_times};
use super::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side};
use proofmass_core::Error;
use pulp::{Arch, Simd, WithSimd};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;
use trial::{LANES, Lanes, Model, add_columns};

/// One component of S in the comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Component, such as `xx.re`.
    pub component: String,
    /// Standard uncertainty by the law of propagation.
    pub linear: f64,
    /// Standard deviation of the trials.
    pub monte_carlo: f64,
    /// 95 % interval about the estimate by the law of propagation.
    pub linear_interval: [f64; 2],
    /// Probabilistically symmetric 95 % interval of the trials, about the estimate.
    pub interval: [f64; 2],
    /// Numerical tolerance δ: half a unit of the last significant digit of u.
    pub tolerance: f64,
    /// Both ends agree within δ.
    pub holds: bool,
}

/// Bins of a histogram over ±6 standard uncertainties; a quantile is known to a fraction of 0.3 % of u.
const BINS: usize = 4096;
const SPAN: f64 = 6.0;
/// Trials of one stream: blocks are seeded by their number and counted in integers, so the thread count changes
/// nothing.
const BLOCK: u64 = 2048;

#[derive(Clone)]
struct Tally {
    counts: Vec<[u32; 18]>,
    sum: [f64; 18],
    square: [f64; 18],
}

impl Tally {
    #[inline(always)]
    fn add(&mut self, delta: &[Lanes; 18], per_bin: &[f64; 18], trials: usize) {
        for p in 0..18 {
            for &d in &delta[p][..trials] {
                self.sum[p] += d;
                self.square[p] += d * d;
                let position = d * per_bin[p] + 0.5 * BINS as f64;
                let bin = (position.max(0.0) as usize).min(BINS - 1);
                self.counts[bin][p] += 1;
            }
        }
    }
}

/// Verdict of the Supplement 1 to the GUM, clause 8, for the 18 components of S at one frequency.
///
/// Every input of the budget is drawn from its distribution with its grouping keys (normal, or rectangular where
/// it says so); the observations follow exactly, angles through sines and products through products; the
/// estimator is the linear one of the adjustment. Normal errors that belong to one run alone enter linearly. What is tested is whether the second order and the shapes of the
/// distributions matter.
///
/// δ is half a unit of the last of `digits` significant digits of u.
///
/// **Source** `[S1]` 7.9.2, 8.
///
/// # Errors
/// As [`super::complex`]; [`Error::TooFew`] below 10⁴ trials.
pub fn validate(
    rows: &[PhasorRow],
    sensitivity: &Matrix,
    budget: &Budget,
    trials: u64,
    digits: u32,
    seed: u64,
) -> Result<Vec<Verdict>, Error> {
    if trials < 10_000 {
        return Err(Error::TooFew {
            name: "Monte Carlo trials",
            needed: 10_000,
            got: trials as usize,
        });
    }
    // The expectation: a noise-free campaign of this S.
    let frequency = rows.first().map_or(0.0, |r| r.frequency);
    let exact: Vec<PhasorRow> = rows
        .iter()
        .map(|r| {
            let a = r.configuration.direction().map(|d| r.reference * d);
            PhasorRow {
                frequency,
                outputs: row_times(a, sensitivity),
                ..r.clone()
            }
        })
        .collect();
    let adjustment = Adjustment::new(&exact, &SpuriousTable::default(), budget)?;
    let variances = adjustment.contributions(0, &exact, budget);
    let linear: [f64; 18] =
        std::array::from_fn(|p| variances.iter().map(|v| v[19 * p]).sum::<f64>().sqrt());
    let gains: Vec<[[f64; 6]; 18]> = (0..exact.len())
        .map(|row| {
            let gain = adjustment.gain(0, row);
            std::array::from_fn(|p| std::array::from_fn(|k| gain[p][k] * adjustment.scale))
        })
        .collect();
    let within = within_runs(&adjustment, &exact, budget)?;
    let model = Model::new(&exact, sensitivity, budget, adjustment.scale);
    let blocks = trials.div_ceil(BLOCK);
    let per_bin = linear.map(|u| 0.5 * BINS as f64 / (u * SPAN));
    let empty = || Tally {
        counts: vec![[0; 18]; BINS],
        sum: [0.0; 18],
        square: [0.0; 18],
    };
    let arch = Arch::new();
    // Sums in double precision are merged in the order of coarse stretches, counts are integers.
    let stretches: Vec<Tally> = (0..16u64)
        .into_par_iter()
        .map(|stretch| {
            let mut tally = empty();
            let mut draws = vec![[0.0; LANES]; model.shared];
            for block in (stretch..blocks).step_by(16) {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(
                    seed ^ block.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
                );
                let wanted = BLOCK.min(trials - block * BLOCK);
                arch.dispatch(Block {
                    model: &model,
                    gains: &gains,
                    within: &within,
                    per_bin: &per_bin,
                    draws: &mut draws,
                    rng: &mut rng,
                    tally: &mut tally,
                    wanted,
                });
            }
            tally
        })
        .collect();
    let total = stretches.iter().fold(empty(), |mut total, t| {
        for (a, b) in total.counts.iter_mut().zip(&t.counts) {
            for p in 0..18 {
                a[p] += b[p];
            }
        }
        for p in 0..18 {
            total.sum[p] += t.sum[p];
            total.square[p] += t.square[p];
        }
        total
    });
    let n = trials as f64;
    Ok((0..18)
        .map(|p| {
            let quantile = |q: f64| -> f64 {
                let wanted = q * n;
                let mut below = 0.0;
                for (bin, counts) in total.counts.iter().enumerate() {
                    let here = f64::from(counts[p]);
                    if below + here >= wanted && here > 0.0 {
                        let position = bin as f64 + (wanted - below) / here;
                        return (position / (0.5 * BINS as f64) - 1.0) * SPAN * linear[p];
                    }
                    below += here;
                }
                SPAN * linear[p]
            };
            let interval = [quantile(0.025), quantile(0.975)];
            let half = 1.959_963_985 * linear[p];
            let power = linear[p].log10().floor() as i32 - (digits as i32 - 1);
            let tolerance = 0.5 * 10f64.powi(power);
            let mean = total.sum[p] / n;
            Verdict {
                component: format!(
                    "{}{}.{}",
                    AXES[p / 6],
                    AXES[p / 2 % 3],
                    if p % 2 == 0 { "re" } else { "im" }
                ),
                linear: linear[p],
                monte_carlo: (total.square[p] / n - mean * mean).sqrt(),
                linear_interval: [-half, half],
                interval,
                tolerance,
                holds: (interval[0] + half).abs() <= tolerance
                    && (interval[1] - half).abs() <= tolerance,
            }
        })
        .collect())
}

/// Some trials of one stream; a type of its own rather than a closure, so that it is compiled as a whole for the
/// widest vectors.
struct Block<'a> {
    model: &'a Model,
    gains: &'a [[[f64; 6]; 18]],
    within: &'a [[f64; 18]],
    per_bin: &'a [f64; 18],
    draws: &'a mut [Lanes],
    rng: &'a mut Xoshiro256PlusPlus,
    tally: &'a mut Tally,
    wanted: u64,
}

impl WithSimd for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for first in (0..self.wanted).step_by(LANES) {
            let mut delta = self.model.trials(self.gains, self.draws, self.rng);
            add_columns(self.within, &mut delta, self.rng);
            let left = (self.wanted - first) as usize;
            self.tally.add(&delta, self.per_bin, LANES.min(left));
        }
    }
}

/// Columns of a square root of the covariance of S from all normal errors within runs and the noise of the
/// phasors.
///
/// They are normal and act linearly (their products are 1e-5 of an output), so their effect on S is exactly one
/// normal vector of 18; drawing it once stands for a dozen draws in each run.
fn within_runs(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    budget: &Budget,
) -> Result<Vec<[f64; 18]>, Error> {
    let contributions = adjustment.contributions(0, rows, budget);
    let normal = |index: usize| {
        budget
            .inputs
            .get(index)
            .map_or(index == budget.inputs.len(), |i| {
                i.within_a_run() && i.distribution != "rectangular"
            })
    };
    let covariance = Mat::from_fn(18, 18, |p, q| {
        contributions
            .iter()
            .enumerate()
            .filter(|(index, _)| normal(*index))
            .map(|(_, c)| 0.5 * (c[18 * p + q] + c[18 * q + p]))
            .sum::<f64>()
    });
    let eigen = covariance
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::NotConverged {
            name: "eigenvalues of the noise of the runs",
            iterations: 0,
            step: f64::INFINITY,
        })?;
    Ok((0..18)
        .map(|e| {
            let root = eigen.S()[e].max(0.0).sqrt();
            std::array::from_fn(|p| root * eigen.U()[(p, e)])
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::super::geometry::published_plan;
    use super::super::{Acts, Input, Key};
    use super::*;
    use faer::c64;

    fn case() -> (Vec<PhasorRow>, Matrix, Budget) {
        let s: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| c64::new(if i == j { 0.0104 } else { 3e-4 }, 1e-5))
        });
        let rows = published_plan()
            .into_iter()
            .map(|c| {
                let a = c.direction().map(|d| c64::new(10.0 * d, 0.0));
                PhasorRow::new("", 160.0, c, c64::new(10.0, 0.0), row_times(a, &s))
            })
            .collect();
        let mut budget = Budget::published_bench();
        budget.inputs.push(Input::new(
            "noise",
            Acts::OutputAdditive,
            5e-5,
            &[Key::Run, Key::Channel],
        ));
        budget.inputs.push(Input::new(
            "reference.phase",
            Acts::ReferencePhase,
            0.003,
            &[Key::Frequency],
        ));
        (rows, s, budget)
    }

    #[test]
    fn crosscheck_propagation_against_monte_carlo() {
        let (rows, s, budget) = case();
        let start = std::time::Instant::now();
        let verdicts = validate(&rows, &s, &budget, 100_000, 1, 7).unwrap();
        println!("10⁵ trials: {:.2} s", start.elapsed().as_secs_f64());
        for v in &verdicts {
            // A standard deviation from 1e5 trials has 0.22 %; four of them.
            assert!((v.monte_carlo / v.linear - 1.0).abs() < 0.01, "{v:?}");
            assert!(v.holds, "{v:?}");
        }
    }

    #[test]
    fn law_the_seed_alone_decides() {
        let (rows, s, budget) = case();
        let run = || validate(&rows, &s, &budget, 10_000, 1, 3).unwrap();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        assert_eq!(run(), pool.install(run));
    }
}
