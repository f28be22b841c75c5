//! The fit of all axes, order by order, and its average.

use super::averaged::{self, Averaged};
use super::branches::Branches;
use super::coefficients::{AxisFit, OrderFit, TemperatureFit};
use super::correlated_noise::{Noise, grid, stationary};
use super::steps;
use super::warm_up::{LEAST, WarmUp, own_part, unexplained};
use super::{Attitude, Blocks, EnvironmentalCourse, Hysteresis, TemperatureSweep, findings};
use proofmass_core::Error;
use proofmass_uncertainty::f_quantile;

/// Columns of one model: nuisance first, then the surroundings, then powers of z for the bias, then those for the scale.
pub(super) struct Design {
    nuisance: Vec<Vec<f64>>,
    /// Quantities of the surroundings, for the bias, and for the scale where it is told from it.
    environment: Vec<Vec<f64>>,
    z: Vec<f64>,
    /// Specific force along each axis at every block, m/s², where scale is told from bias.
    force: Option<Vec<Vec<f64>>>,
    /// Self-heating: its place among the columns, and what may stand there.
    warm_up: Option<(usize, WarmUp)>,
}

impl Design {
    fn columns(&self, order: usize, axis: usize) -> Vec<Vec<f64>> {
        let power = |k: usize, factor: Option<&Vec<f64>>| -> Vec<f64> {
            let powers = self.z.iter().enumerate();
            powers
                .map(|(i, z)| z.powi(k as i32) * factor.map_or(1.0, |f| f[i]))
                .collect()
        };
        let mut columns = self.nuisance.clone();
        columns.extend(self.environment.iter().cloned());
        if let Some(force) = &self.force {
            let along = |e: &Vec<f64>| e.iter().zip(&force[axis]).map(|(e, f)| e * f).collect();
            columns.extend(self.environment.iter().map(along));
        }
        columns.extend((1..=order).map(|k| power(k, None)));
        if let Some(force) = &self.force {
            columns.extend((1..=order).map(|k| power(k, Some(&force[axis]))));
        }
        columns
    }

    /// The forces that the scale multiplies, as the attitudes read them where everything is at its reference: their intercepts. A mean over the
    /// sweep contains what bias and scale do on the way, and the coefficients of the bias would be off by that times those of the scale.
    fn at_references(
        &mut self,
        blocks: &Blocks,
        order: usize,
        noise: &[Noise],
    ) -> Result<(), Error> {
        // Each round is nearer by the change of the scale, a hundredth or less.
        const ROUNDS: usize = 4;
        let rounds = if self.force.is_some() { ROUNDS } else { 0 };
        for _ in 0..rounds {
            let force = (0..blocks.axes).map(|axis| {
                let y: Vec<f64> = blocks.output.iter().map(|o| o[axis]).collect();
                let columns = [self.columns(order, axis)];
                let run = averaged::fit(&columns, &y, noise)?;
                Ok(blocks.attitude.iter().map(|s| run.estimate[*s]).collect())
            });
            self.force = Some(force.collect::<Result<_, Error>>()?);
        }
        Ok(())
    }

    /// The columns with every time constant that self-heating may have.
    fn alternatives(&self, order: usize, axis: usize) -> Vec<Vec<Vec<f64>>> {
        let columns = self.columns(order, axis);
        let Some((at, warm_up)) = &self.warm_up else {
            return vec![columns];
        };
        let with = |decay: &Vec<f64>| {
            let mut columns = columns.clone();
            columns[*at].clone_from(decay);
            columns
        };
        warm_up.decays.iter().map(with).collect()
    }
}

pub(super) fn fit(
    settings: &TemperatureSweep,
    blocks: &Blocks,
    mut environment: Vec<EnvironmentalCourse>,
) -> Result<TemperatureFit, Error> {
    let range = blocks.range();
    let reference = settings.reference.unwrap_or(0.5 * (range[0] + range[1]));
    let half = 0.5 * (range[1] - range[0]);
    if !((reference - range[0]).min(range[1] - reference) >= -half) {
        return Err(Error::OutOfRange {
            name: "reference temperature, °C",
            value: reference,
            min: range[0] - half,
            max: range[1] + half,
        });
    }
    let z: Vec<f64> = blocks
        .temperature
        .iter()
        .map(|t| (t - reference) / half)
        .collect();
    let mut branches = Branches::of(blocks);
    let force = separable(blocks);
    let mut nuisance: Vec<Vec<f64>> = (0..blocks.attitudes.len())
        .map(|s| {
            blocks
                .attitude
                .iter()
                .map(|a| f64::from(u8::from(*a == s)))
                .collect()
        })
        .collect();
    // A few plateaus do not tell powers that no others separate them by; two tell a straight line.
    let power = |k: usize| -> Vec<f64> { z.iter().map(|z| z.powi(k as i32)).collect() };
    let told = |top: usize| {
        let all: Vec<Vec<f64>> = nuisance
            .iter()
            .cloned()
            .chain((1..=top).map(power))
            .collect();
        // Of a power of z, which is of order one.
        (unexplained(&all, all.len() - 1) / z.len() as f64).sqrt() >= LEAST
    };
    let mut settings = settings.clone();
    while settings.largest_order > 1 && !told(settings.largest_order) {
        settings.largest_order -= 1;
    }
    let settings = &settings;
    let gap_at = nuisance.len();
    if branches.common.is_some() {
        let gap = (0..3).map(|k| {
            let signed = branches.sign.iter().zip(&z);
            signed
                .map(|(s, z)| 0.5 * s * z.powi(k))
                .collect::<Vec<f64>>()
        });
        nuisance.extend(gap);
        // A few plateaus, each reached from one side alone, do not tell the branches from the temperature.
        let powers =
            (1..=settings.largest_order as i32).map(|k| z.iter().map(|z| z.powi(k)).collect());
        let all: Vec<Vec<f64>> = nuisance.iter().cloned().chain(powers).collect();
        if (gap_at..gap_at + 3).any(|at| own_part(&all, at) < LEAST) {
            nuisance.truncate(gap_at);
            branches.common = None;
            branches.lag = false;
        }
    }
    let lag_at = nuisance.len();
    if branches.lag {
        let fastest = branches.rate.iter().fold(0.0f64, |m, r| m.max(r.abs()));
        nuisance.push(branches.rate.iter().map(|r| r / fastest).collect());
    }
    let warm_up = settings.warm_up.map(|longest| {
        let warm_up = WarmUp::of(blocks, longest);
        nuisance.extend(warm_up.decays.first().cloned());
        (nuisance.len() - 1, warm_up)
    });
    let environment_at = nuisance.len();
    let column = |(course, means): (&EnvironmentalCourse, &Vec<f64>)| course.column(means);
    let mut design = Design {
        nuisance,
        environment: environment
            .iter()
            .zip(&blocks.environment)
            .map(column)
            .collect(),
        z,
        force,
        warm_up,
    };
    let kinds = if design.force.is_some() { 2 } else { 1 };
    for (j, course) in environment.iter_mut().enumerate() {
        let parts = (0..blocks.axes).flat_map(|axis| {
            let columns = design.columns(settings.largest_order, axis);
            let many = design.environment.len();
            (0..kinds).map(move |kind| own_part(&columns, environment_at + kind * many + j))
        });
        course.own_part = parts.fold(1.0, f64::min);
        course.determined = course.own_part >= LEAST;
    }
    let mut told = environment.iter().map(|course| course.determined);
    design.environment.retain(|_| told.next().unwrap_or(true));
    let fixed = environment_at + kinds * design.environment.len();
    let noises = grid(&blocks.time, blocks.duration);
    design.at_references(blocks, settings.largest_order, &noises[..1])?;
    // A walk follows any loop, so that beside it no form of the branches is missed.
    let stationary = match branches.common {
        Some(_) => stationary(&blocks.time, blocks.duration, 0.5),
        None => Vec::new(),
    };
    let context = Context {
        settings,
        blocks,
        branches: &branches,
        design: &design,
        noises: &noises,
        stationary: &stationary,
        half,
        reference,
        gap_at,
        lag_at,
        environment_at,
        environment: environment.iter().filter(|e| e.determined).collect(),
        fixed,
    };
    let axes: Vec<Axis> = (0..blocks.axes)
        .map(|axis| context.axis(axis))
        .collect::<Result<_, _>>()?;
    let estimate = context.estimate(&axes)?;
    drop(context);
    let scale = design.force.is_some();
    let mut fit = TemperatureFit {
        reference,
        range,
        largest_order: settings.largest_order,
        scale,
        axes: axes.into_iter().map(|a| a.fit).collect(),
        estimate,
        environment,
        blocks: blocks.clone(),
        findings: Vec::new(),
        direction: branches.sign,
    };
    fit.findings = findings::of(&fit, branches.common.is_some(), settings);
    Ok(fit)
}

/// The specific force along each axis, where sweeps in attitudes far from each other tell scale from bias on all axes.
fn separable(blocks: &Blocks) -> Option<Vec<Vec<f64>>> {
    let [low, high] = blocks.range();
    let swept: Vec<&Attitude> = blocks
        .attitudes
        .iter()
        .filter(|a| a.range[1] - a.range[0] > 0.5 * (high - low))
        .collect();
    let cosine = |a: &Attitude, axis: usize| a.output[axis] / blocks.force(a);
    let told = (0..blocks.axes).all(|axis| {
        let c = swept.iter().map(|a| cosine(a, axis));
        let (least, most) = (
            c.clone().fold(f64::INFINITY, f64::min),
            c.fold(f64::NEG_INFINITY, f64::max),
        );
        most - least > 0.5
    });
    told.then(|| {
        let along = |axis: usize| {
            let of = |s: &usize| blocks.attitudes[*s].output[axis];
            blocks.attitude.iter().map(of).collect()
        };
        (0..blocks.axes).map(along).collect()
    })
}

pub(super) struct Context<'a> {
    pub(super) settings: &'a TemperatureSweep,
    pub(super) blocks: &'a Blocks,
    pub(super) branches: &'a Branches,
    pub(super) design: &'a Design,
    pub(super) noises: &'a [Noise],
    /// Those without a walk, where there are branches.
    pub(super) stationary: &'a [Noise],
    pub(super) half: f64,
    pub(super) reference: f64,
    pub(super) gap_at: usize,
    pub(super) lag_at: usize,
    pub(super) environment_at: usize,
    /// The quantities of the surroundings that are in the model.
    pub(super) environment: Vec<&'a EnvironmentalCourse>,
    pub(super) fixed: usize,
}

/// One axis with what the joint estimate needs.
pub(super) struct Axis {
    pub(super) fit: AxisFit,
    /// Coefficients in powers of z: bias, then scale, each up to the largest order; then those of the surroundings, bias and scale.
    pub(super) coefficients: Vec<f64>,
    pub(super) covariance: Vec<f64>,
    /// Half the difference of the branches in the same coefficients.
    pub(super) branch: Vec<f64>,
    /// What a tilt across the jumps of the temperature would do to the same coefficients: one for each cause.
    pub(super) tilt: Vec<Vec<f64>>,
    /// Degrees of freedom of the covariance.
    pub(super) dof: f64,
}

impl Context<'_> {
    pub(super) fn kinds(&self) -> usize {
        if self.design.force.is_some() { 2 } else { 1 }
    }

    fn axis(&self, axis: usize) -> Result<Axis, Error> {
        let y: Vec<f64> = self.blocks.output.iter().map(|o| o[axis]).collect();
        let top = self.settings.largest_order;
        let kinds = self.kinds();
        let (n, fixed) = (y.len(), self.fixed);
        let mut runs: Vec<Averaged> = Vec::with_capacity(top);
        for order in 1..=top {
            runs.push(averaged::fit(
                &self.design.alternatives(order, axis),
                &y,
                self.noises,
            )?);
        }
        let criterion = |order: usize| {
            // The variance and the two of the noise are estimated beside the coefficients.
            let k = (fixed + kinds * order + 3) as f64;
            let correction = 2.0 * k * (k + 1.0) / (n as f64 - k - 1.0).max(1.0);
            -2.0 * runs[order - 1].log_likelihood + 2.0 * k + correction
        };
        let aicc: Vec<f64> = (1..=top).map(criterion).collect();
        let best = aicc.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = aicc.iter().map(|a| (-0.5 * (a - best)).exp()).collect();
        let total: f64 = weights.iter().sum();
        // Padded to the largest order, so that one mixture holds all.
        let size = fixed + kinds * top;
        let place = |order: usize, i: usize| {
            if i < fixed {
                i
            } else {
                let (kind, k) = ((i - fixed) / order, (i - fixed) % order);
                fixed + kind * top + k
            }
        };
        let padded: Vec<(Vec<f64>, Vec<f64>)> = runs
            .iter()
            .enumerate()
            .map(|(index, run)| {
                let (order, p) = (index + 1, run.estimate.len());
                let mut x = vec![0.0; size];
                let mut c = vec![0.0; size * size];
                for a in 0..p {
                    x[place(order, a)] = run.estimate[a];
                    for b in 0..p {
                        c[place(order, a) * size + place(order, b)] = run.covariance[a * p + b];
                    }
                }
                (x, c)
            })
            .collect();
        // The largest order states the result: an average over orders is short of its interval where a power is small.
        let (x, c) = &padded[top - 1];

        let slope_weights = self.slope_weights(top);
        let orders = (1..=top)
            .map(|order| {
                let (px, pc) = &padded[order - 1];
                let (slope, u) = linear(&slope_weights, &px[fixed..], pc, size, fixed);
                let f = (order > 1).then(|| {
                    let at = place(order, fixed + order - 1);
                    let variance = pc[at * size + at];
                    if variance > 0.0 {
                        px[at] * px[at] / variance
                    } else {
                        0.0
                    }
                });
                OrderFit {
                    order,
                    aicc: aicc[order - 1] - best,
                    weight: weights[order - 1] / total,
                    cross_validation: self.cross_validation(order, axis, &y),
                    f,
                    f_limit: f_quantile(0.95, 1.0, (n - fixed - kinds * order) as f64),
                    slope,
                    slope_uncertainty: u,
                }
            })
            .collect();
        let places: Vec<usize> = (fixed..size).chain(self.environment_at..fixed).collect();
        let count = places.len();
        let coefficients: Vec<f64> = places.iter().map(|i| x[*i]).collect();
        let covariance = (0..count * count)
            .map(|i| c[places[i / count] * size + places[i % count]])
            .collect();
        let hysteresis = match self.branches.common {
            Some(common) => {
                let designs = self.design.alternatives(top, axis);
                let without_walk = averaged::fit(&designs, &y, self.stationary)?;
                Some(Hysteresis::new(
                    self.gap(common, x, c, size),
                    &self.gap(
                        common,
                        &without_walk.estimate,
                        &without_walk.covariance,
                        size,
                    ),
                    self.branches.raw(self.blocks, axis),
                ))
            }
            None => None,
        };
        let mut branch = vec![0.0; count];
        if hysteresis.is_some() {
            for k in 1..=top.min(2) {
                branch[k - 1] = 0.5 * x[self.gap_at + k];
            }
        }
        let lag = self.branches.lag.then(|| {
            let fastest = self
                .branches
                .rate
                .iter()
                .fold(0.0f64, |m, r| m.max(r.abs()));
            let at = self.lag_at;
            [x[at] / fastest, c[at * size + at].sqrt() / fastest]
        });
        let best = runs[top - 1].best();
        let mut designs = self.design.alternatives(top, axis);
        let self_heating = self.design.warm_up.as_ref().map(|(at, warm_up)| {
            let [amplitude, standard_uncertainty] = [x[*at], c[at * size + at].max(0.0).sqrt()];
            warm_up.found(
                amplitude,
                standard_uncertainty,
                &runs[top - 1].alternatives,
                &designs,
                *at,
            )
        });
        let columns = designs.swap_remove(best);
        let step = steps::largest(
            self.blocks,
            &columns,
            &y,
            &self.noises[runs[top - 1].noise],
            (fixed, &slope_weights),
        );
        let tilt = self.tilt(axis, &columns)?;
        let residuals = (0..n)
            .map(|i| y[i] - (0..size).map(|a| columns[a][i] * x[a]).sum::<f64>())
            .collect();
        let mean_change = (0..n)
            .map(|i| {
                (1..=top)
                    .map(|k| coefficients[k - 1] * self.design.z[i].powi(k as i32))
                    .sum::<f64>()
            })
            .sum::<f64>()
            / n as f64;
        let powers = |offset: usize| {
            std::array::from_fn(|k| {
                if k < top {
                    coefficients[offset + k] / self.half.powi(k as i32 + 1)
                } else {
                    0.0
                }
            })
        };
        Ok(Axis {
            fit: AxisFit {
                orders,
                bias: powers(0),
                scale: (kinds == 2).then(|| powers(top)),
                hysteresis,
                lag,
                self_heating,
                step,
                mean_change,
                residuals,
            },
            coefficients,
            covariance,
            branch,
            tilt,
            dof: runs[top - 1].dof,
        })
    }

    /// Weights of z, z², z³ in the mean slope over the range, per K.
    pub(super) fn slope_weights(&self, top: usize) -> Vec<f64> {
        let [low, high] = self
            .blocks
            .range()
            .map(|t| (t - self.reference) / self.half);
        (1..=top as i32)
            .map(|k| (high.powi(k) - low.powi(k)) / (2.0 * self.half))
            .collect()
    }

    /// Ten stretches of time left out in turn; what is left fits them, intercepts and branches included.
    fn cross_validation(&self, order: usize, axis: usize, y: &[f64]) -> f64 {
        let designs = self.design.alternatives(order, axis);
        let n = y.len();
        let mut sum = 0.0;
        let mut count = 0usize;
        for fold in 0..10 {
            let out = |i: usize| i * 10 / n == fold;
            let keep: Vec<usize> = (0..n).filter(|i| !out(*i)).collect();
            let pick = |c: &Vec<f64>| keep.iter().map(|i| c[*i]).collect::<Vec<f64>>();
            let x: Vec<Vec<Vec<f64>>> = designs
                .iter()
                .map(|columns| columns.iter().map(pick).collect())
                .collect();
            let white = &self.noises[..1];
            // A stretch that alone holds an attitude or a branch cannot be predicted by the others.
            let Ok(run) = averaged::fit(&x, &pick(&y.to_vec()), white) else {
                continue;
            };
            let columns = &designs[run.best()];
            for i in (0..n).filter(|i| out(*i)) {
                let model: f64 = columns
                    .iter()
                    .zip(&run.estimate)
                    .map(|(c, e)| c[i] * e)
                    .sum();
                sum += (y[i] - model).powi(2);
                count += 1;
            }
        }
        (sum / count.max(1) as f64).sqrt()
    }

    /// Heating less cooling over the common range: temperature, difference, standard uncertainty.
    fn gap(&self, common: [f64; 2], x: &[f64], c: &[f64], size: usize) -> Vec<[f64; 3]> {
        let at = self.gap_at;
        (0..=24)
            .map(|i| {
                let t = common[0] + (common[1] - common[0]) * f64::from(i) / 24.0;
                let z = (t - self.reference) / self.half;
                let w = [1.0, z, z * z];
                let value = (0..3).map(|k| w[k] * x[at + k]).sum();
                let mut variance = 0.0;
                for a in 0..3 {
                    for b in 0..3 {
                        variance += w[a] * w[b] * c[(at + a) * size + at + b];
                    }
                }
                [t, value, variance.max(0.0).sqrt()]
            })
            .collect()
    }
}

/// Σ w_k x_k and its standard uncertainty; `x` and the covariance begin at `offset`.
fn linear(w: &[f64], x: &[f64], c: &[f64], size: usize, offset: usize) -> (f64, f64) {
    let value = w.iter().zip(x).map(|(w, x)| w * x).sum();
    let mut variance = 0.0;
    for (a, wa) in w.iter().enumerate() {
        for (b, wb) in w.iter().enumerate() {
            variance += wa * wb * c[(offset + a) * size + offset + b];
        }
    }
    (value, variance.max(0.0).sqrt())
}
