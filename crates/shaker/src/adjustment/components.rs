//! Components of the variance: how large the errors of each kind are, as the runs have them.

use super::{Adjustment, dot6, times};
use crate::budget::Budget;
use crate::observation::{Share, way};
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{cholesky, product};
use rayon::prelude::*;

/// How large one kind of error is, as the runs have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Component {
    /// Its variance over the declared one, φ.
    pub(crate) ratio: f64,
    /// Degrees of freedom of φ: 2 φ² over its variance.
    pub(crate) freedom: f64,
}

/// The kinds of error that the runs can tell apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Components {
    /// What differs from run to run (readings and their noise), by frequency.
    pub(crate) readings: Vec<Option<Component>>,
    /// By input of the budget; `None` for those of which the runs tell nothing.
    pub(crate) inputs: Vec<Option<Component>>,
    /// Motion of the bench that nobody measured; empty where all of it was.
    pub(crate) motion: Vec<MotionComponent>,
}

/// A part of the motion of the bench that nobody measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionComponent {
    pub(crate) share: Share,
    /// Frequency of what each wedge has by itself; `None` of what is common to several.
    pub(crate) frequency: Option<usize>,
    /// Across the excitation, and along it.
    pub(crate) ways: [Option<Component>; 2],
}

/// Degrees of freedom below which a kind of error stays as declared.
const TOLD: f64 = 2.0;
/// Share of the degrees of freedom at the declared variances that an estimate keeps at least: where a variance comes out
/// small by chance its own freedom vanishes with it, and t with it grows beyond reason.
const KEPT: f64 = 2.0 / 3.0;
/// Ratios below are as good as zero: t(1) times the root of this is less than the normal factor.
const LEAST: f64 = 0.02;
/// Likewise of an error that nobody declares, beside the size that it begins with.
const NOTHING: f64 = 1e-5;
/// Scoring gains a digit per step; a component that few runs tell moves slowly at first.
const STEPS: usize = 40;
/// A thousand times the declared uncertainty is a blunder and no scatter.
const MOST: f64 = 1e6;
/// Likewise an angle of 10°: that is another mounting.
const ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Relative change of all ratios at which it ends: a hundredth of a variance is nothing beside its own uncertainty, and the
/// next step would be far smaller.
const SETTLED: f64 = 1e-2;
/// Largest factor of one step.
const REACH: f64 = 4.0;

/// A kind of error.
#[derive(Clone, Debug)]
enum Kind {
    /// Whatever is in the noise N of the runs of a frequency.
    Reading(usize),
    /// What is drawn, with its draws as places among the parameters, and the degrees of freedom it is declared with;
    /// infinite for one that is only declared.
    Drawn(Source, Vec<usize>, f64),
}

/// What draws are of.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// An input of the budget.
    Input(usize),
    /// Motion of the bench that nobody measured, by its place in [`Components::motion`]: across the excitation (0) or along it (1).
    Motion(usize, usize),
}

impl Kind {
    /// Smallest and largest ratio.
    fn bounds(&self, budget: &Budget) -> (f64, f64) {
        let least = match self {
            Self::Drawn(Source::Input(index), ..) if budget.inputs[*index].assumed => NOTHING,
            _ => LEAST,
        };
        let most = match self {
            Self::Drawn(Source::Input(index), ..) if budget.inputs[*index].acts.is_angle() => {
                let u = budget.inputs[*index].standard_uncertainty();
                (ANGLE / u).powi(2).clamp(1.0, MOST)
            }
            _ => MOST,
        };
        (least, most)
    }
}

/// The runs of a frequency in the linearised model.
struct Block {
    /// Parameters they have.
    parameters: Vec<usize>,
    /// Wᵀ N⁻¹ W.
    normal: Mat<f64>,
    /// Wᵀ N⁻¹ r.
    right: Vec<f64>,
    /// rᵀ N⁻¹ r.
    square: f64,
    /// Reals of the runs.
    count: f64,
}

/// What scoring needs at one set of ratios.
struct Score {
    /// T_kl = tr(P V_k P V_l), twice the information.
    information: Mat<f64>,
    /// yᵀ P V_k P y − tr(P V_k).
    gradient: Vec<f64>,
    /// What of T_kk comes from the degrees of freedom of a declaration.
    declared: Vec<f64>,
}

impl Adjustment {
    /// Variance of each kind of error over what is declared, by restricted maximum likelihood: V = Σ φ_k V_k,
    /// scoring with T_kl = tr(P V_k P V_l), φ ≥ 0 and no test in between.
    ///
    /// A declared uncertainty with degrees of freedom ν₀ counts as ν₀ observations of its variance. What stays as
    /// declared, because the runs have less than two degrees of freedom for it, is decided by the plan and not by the
    /// readings. Scoring that has not settled after [`STEPS`] is taken where it is.
    ///
    /// **Source** `[Harville1977]`; T after `[KenwardRoger1997]`.
    pub(crate) fn components(&self, budget: &Budget) -> Result<Components, Error> {
        let blocks: Vec<Block> = (0..self.frequencies.len()).map(|f| self.block(f)).collect();
        let mut kinds = self.kinds(budget);
        let mut bounds: Vec<(f64, f64)> = kinds.iter().map(|k| k.bounds(budget)).collect();
        let mut ratios = vec![1.0; kinds.len()];
        let mut score = self.score_of(&blocks, &kinds, &ratios)?;
        // The least known first: what it leaves may tell the others.
        loop {
            let known = score.told_by_the_runs(&ratios);
            let least = (0..kinds.len()).min_by(|&a, &b| known[a].total_cmp(&known[b]));
            match least {
                Some(k) if !(known[k] >= TOLD) => {
                    kinds.remove(k);
                    bounds.remove(k);
                    ratios.pop();
                    score = score.without(k);
                }
                _ => break,
            }
        }
        let declared = freedoms(&score.information, &ratios);
        for _ in 0..STEPS {
            let next = score.step(&ratios, &bounds);
            let change = |(a, b): (&f64, &f64)| (a / b - 1.0).abs();
            let settled = next.iter().zip(&ratios).map(change).fold(0.0, f64::max) < SETTLED;
            ratios = next;
            if settled {
                break;
            }
            score = self.score_of(&blocks, &kinds, &ratios)?;
        }
        let known = freedoms(&score.information, &ratios);
        let mut components = Components {
            readings: vec![None; self.frequencies.len()],
            inputs: vec![None; budget.inputs.len()],
            motion: self.unmeasured_motion(),
        };
        for (k, kind) in kinds.iter().enumerate() {
            let component = Some(Component {
                ratio: ratios[k],
                freedom: known[k].max(KEPT * declared[k]),
            });
            match kind {
                Kind::Reading(f) => components.readings[*f] = component,
                Kind::Drawn(Source::Input(index), ..) => components.inputs[*index] = component,
                Kind::Drawn(Source::Motion(k, way), ..) => {
                    components.motion[*k].ways[*way] = component;
                }
            }
        }
        Ok(components)
    }

    /// The parts of the motion of the bench that nobody measured, of which nothing is known yet.
    fn unmeasured_motion(&self) -> Vec<MotionComponent> {
        if self.draws.iter().all(|d| d.share.is_none()) {
            return vec![];
        }
        let own = (0..self.frequencies.len()).map(|f| (Share::Own, Some(f)));
        let common = Share::ALL[1..].iter().map(|share| (*share, None));
        own.chain(common)
            .map(|(share, frequency)| MotionComponent {
                share,
                frequency,
                ways: [None; 2],
            })
            .collect()
    }

    /// Frequency in Hz of what each wedge has by itself.
    pub(crate) fn frequency_of(&self, motion: &MotionComponent) -> Option<f64> {
        motion.frequency.map(|f| self.frequencies[f])
    }

    fn kinds(&self, budget: &Budget) -> Vec<Kind> {
        let offset = self.first_draw();
        let readings = (0..self.frequencies.len()).map(Kind::Reading);
        let inputs = budget.inputs.iter().enumerate().map(|(index, input)| {
            let own = self.draws_of(index).map(|d| offset + d);
            Kind::Drawn(Source::Input(index), own.collect(), input.dof.get())
        });
        let motion = self.unmeasured_motion();
        let motion = motion.iter().enumerate().flat_map(|(k, of)| {
            [0, 1].map(|across_or_along| {
                let own = |d: &usize| {
                    let draw = &self.draws[*d];
                    draw.share == Some(of.share)
                        && (of.frequency.is_none() || draw.frequency == of.frequency)
                        && way(draw.part / 2) == across_or_along
                };
                let own = (0..self.draws.len()).filter(own).map(|d| offset + d);
                let source = Source::Motion(k, across_or_along);
                Kind::Drawn(source, own.collect(), f64::INFINITY)
            })
        });
        let some = |kind: &Kind| !matches!(kind, Kind::Drawn(_, draws, _) if draws.len() < 2);
        readings.chain(inputs).chain(motion).filter(some).collect()
    }

    fn block(&self, f: usize) -> Block {
        let rows: Vec<usize> = (0..self.rows.len())
            .filter(|&i| self.of_row[i] == f)
            .collect();
        let mut parameters: Vec<usize> = rows
            .iter()
            .flat_map(|&i| self.rows[i].columns.iter().map(|(p, _)| *p))
            .collect();
        parameters.sort_unstable();
        parameters.dedup();
        let mut place = vec![0; self.parameters.len()];
        for (k, &p) in parameters.iter().enumerate() {
            place[p] = k;
        }
        let mut block = Block {
            normal: Mat::zeros(parameters.len(), parameters.len()),
            right: vec![0.0; parameters.len()],
            square: 0.0,
            count: 0.0,
            parameters,
        };
        for i in rows {
            let (linear, w) = (&self.rows[i], &self.weights[i]);
            let residual = times(w, &linear.residual);
            block.square += dot6(&residual, &linear.residual);
            block.count += self.reals[i];
            for (p, x) in &linear.columns {
                block.right[place[*p]] += dot6(&residual, x);
                let weighted = times(w, x);
                for (q, other) in &linear.columns {
                    block.normal[(place[*p], place[*q])] += dot6(&weighted, other);
                }
            }
        }
        block
    }

    /// The score and its information at some ratios; errors that are no kind have their declared variance.
    fn score_of(&self, blocks: &[Block], kinds: &[Kind], ratios: &[f64]) -> Result<Score, Error> {
        let count = self.parameters.len();
        let mut reading = vec![1.0; blocks.len()];
        let mut variance = vec![1.0; count];
        for (kind, &ratio) in kinds.iter().zip(ratios) {
            match kind {
                Kind::Reading(f) => reading[*f] = ratio,
                Kind::Drawn(_, draws, _) => draws.iter().for_each(|&d| variance[d] = ratio),
            }
        }
        let mut normal = Mat::<f64>::zeros(count, count);
        let mut right = Mat::<f64>::zeros(count, 1);
        for (block, ratio) in blocks.iter().zip(&reading) {
            for (a, &p) in block.parameters.iter().enumerate() {
                right[(p, 0)] += block.right[a] / ratio;
                for (b, &q) in block.parameters.iter().enumerate() {
                    normal[(p, q)] += block.normal[(a, b)] / ratio;
                }
            }
        }
        for p in self.first_draw()..count {
            normal[(p, p)] += 1.0 / variance[p];
            right[(p, 0)] -= self.parameters[p] / variance[p];
        }
        for &p in &self.real {
            normal[(p, p)] += super::REAL;
        }
        let llt = cholesky(&normal).map_err(|_| Error::Unobservable {
            parameter: "sensitivity",
            condition: f64::INFINITY,
        })?;
        let c = llt.inverse();
        let change = product([c.as_ref(), right.as_ref()]);
        // A C over the parameters of each frequency.
        let spread: Vec<Mat<f64>> = blocks
            .par_iter()
            .map(|b| {
                let here = Mat::from_fn(b.parameters.len(), count, |a, q| c[(b.parameters[a], q)]);
                &b.normal * here
            })
            .collect();
        let between = |f: usize, g: usize| -> f64 {
            let (here, there) = (&blocks[f].parameters, &blocks[g].parameters);
            let term = |a: usize| -> f64 {
                let row = there.iter().enumerate();
                row.map(|(b, &q)| spread[f][(a, q)] * spread[g][(b, here[a])])
                    .sum()
            };
            (0..here.len()).map(term).sum()
        };
        let trace = |f: usize| -> f64 {
            let own = blocks[f].parameters.iter().enumerate();
            own.map(|(a, &p)| spread[f][(a, p)]).sum()
        };
        let n = kinds.len();
        let mut score = Score {
            information: Mat::zeros(n, n),
            gradient: vec![0.0; n],
            declared: vec![0.0; n],
        };
        for (k, kind) in kinds.iter().enumerate() {
            let phi = ratios[k];
            score.gradient[k] = match kind {
                Kind::Reading(f) => {
                    let b = &blocks[*f];
                    let moved: Vec<f64> = b.parameters.iter().map(|&p| change[(p, 0)]).collect();
                    let (mut along, mut square) = (0.0, 0.0);
                    for (a, x) in moved.iter().enumerate() {
                        along += x * b.right[a];
                        square += x
                            * (0..moved.len())
                                .map(|i| b.normal[(a, i)] * moved[i])
                                .sum::<f64>();
                    }
                    let left = b.square - 2.0 * along + square;
                    left / (phi * phi) - b.count / phi + trace(*f) / (phi * phi)
                }
                Kind::Drawn(_, draws, declared) => {
                    let one = |&d: &usize| {
                        let z = self.parameters[d] + change[(d, 0)];
                        (z * z + c[(d, d)]) / (phi * phi) - 1.0 / phi
                    };
                    let prior = match declared.is_finite() {
                        true => declared * (1.0 / (phi * phi) - 1.0 / phi),
                        false => 0.0,
                    };
                    if declared.is_finite() {
                        score.declared[k] = declared / (phi * phi);
                    }
                    draws.iter().map(one).sum::<f64>() + prior
                }
            };
            for (l, other) in kinds.iter().enumerate().take(k + 1) {
                let psi = ratios[l];
                let both = phi * phi * psi * psi;
                let value = match (kind, other) {
                    (Kind::Reading(f), Kind::Reading(g)) if f == g => {
                        blocks[*f].count / (phi * phi) - 2.0 * trace(*f) / phi.powi(3)
                            + between(*f, *f) / both
                    }
                    (Kind::Reading(f), Kind::Reading(g)) => between(*f, *g) / both,
                    (Kind::Drawn(_, draws, _), Kind::Reading(f)) => {
                        let one = |&d: &usize| -> f64 {
                            let rows = blocks[*f].parameters.iter().enumerate();
                            rows.map(|(a, &p)| c[(d, p)] * spread[*f][(a, d)]).sum()
                        };
                        draws.iter().map(one).sum::<f64>() / both
                    }
                    (Kind::Drawn(_, draws, _), Kind::Drawn(_, others, _)) => {
                        let pair = |d: usize, e: usize| {
                            (if d == e { 1.0 / phi } else { 0.0 } - c[(d, e)] / (phi * psi)).powi(2)
                        };
                        let row = |&d: &usize| others.iter().map(|&e| pair(d, e)).sum::<f64>();
                        let prior = if k == l { score.declared[k] } else { 0.0 };
                        draws.iter().map(row).sum::<f64>() + prior
                    }
                    // Readings stand first among the kinds.
                    (Kind::Reading(_), Kind::Drawn(..)) => 0.0,
                };
                score.information[(k, l)] = value;
                score.information[(l, k)] = value;
            }
        }
        Ok(score)
    }
}

impl Score {
    fn without(&self, k: usize) -> Self {
        let n = self.gradient.len() - 1;
        let of = |i: usize| if i < k { i } else { i + 1 };
        Self {
            information: Mat::from_fn(n, n, |i, j| self.information[(of(i), of(j))]),
            gradient: (0..n).map(|i| self.gradient[of(i)]).collect(),
            declared: (0..n).map(|i| self.declared[of(i)]).collect(),
        }
    }

    /// Degrees of freedom of each ratio by the runs alone; those that one kind would have by itself as long as there is one
    /// of which they tell nothing, since that one would hide the others.
    fn told_by_the_runs(&self, ratios: &[f64]) -> Vec<f64> {
        let n = ratios.len();
        let runs = Mat::from_fn(n, n, |i, j| {
            self.information[(i, j)] - if i == j { self.declared[i] } else { 0.0 }
        });
        let alone: Vec<f64> = (0..n)
            .map(|k| runs[(k, k)] * ratios[k] * ratios[k])
            .collect();
        if alone.iter().any(|d| *d < TOLD) {
            return alone;
        }
        freedoms(&runs, ratios)
    }

    /// φ + T⁻¹ g within reach and above zero; a ratio at its bound that wants to be less stays there.
    fn step(&self, ratios: &[f64], bounds: &[(f64, f64)]) -> Vec<f64> {
        let free: Vec<usize> = (0..ratios.len())
            .filter(|&k| {
                let (least, most) = bounds[k];
                let inside = ratios[k] > least && ratios[k] < most;
                inside || (self.gradient[k] > 0.0) == (ratios[k] <= least)
            })
            .collect();
        let n = free.len();
        let mut next = ratios.to_vec();
        if n == 0 {
            return next;
        }
        let scaled = Mat::from_fn(n, n, |i, j| {
            self.information[(free[i], free[j])] * ratios[free[i]] * ratios[free[j]]
        });
        let right = Mat::from_fn(n, 1, |i, _| self.gradient[free[i]] * ratios[free[i]]);
        let Ok(llt) = cholesky(&scaled) else {
            return next;
        };
        let step = llt.solve(&right);
        for (i, &k) in free.iter().enumerate() {
            let factor = (1.0 + step[(i, 0)]).clamp(1.0 / REACH, REACH);
            next[k] = (ratios[k] * factor).clamp(bounds[k].0, bounds[k].1);
        }
        next
    }
}

/// Degrees of freedom of each ratio, φ²/(T⁻¹)_kk.
fn freedoms(information: &Mat<f64>, ratios: &[f64]) -> Vec<f64> {
    let n = ratios.len();
    if n == 0 {
        return vec![];
    }
    let scaled = Mat::from_fn(n, n, |i, j| information[(i, j)] * ratios[i] * ratios[j]);
    // Two kinds that act alike have next to none each, instead of an error.
    let lifted = Mat::from_fn(n, n, |i, j| {
        scaled[(i, j)]
            + if i == j {
                1e-9 * (1.0 + scaled[(i, i)])
            } else {
                0.0
            }
    });
    match cholesky(&lifted) {
        Ok(llt) => {
            let inverse = llt.inverse();
            (0..n).map(|k| 1.0 / inverse[(k, k)]).collect()
        }
        Err(_) => vec![0.0; n],
    }
}
