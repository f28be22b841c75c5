//! The fit of all three axes, order by order, and its average.

use super::averaged::{self, Averaged};
use super::branches::Branches;
use super::correlated_noise::{Noise, grid};
use super::{Attitude, Blocks, Hysteresis, TemperatureSweep, findings};
use proofmass_core::{Error, THERMAL_ORDER, norm};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    f_quantile,
};
use serde::{Deserialize, Serialize};

const AXES: [&str; 3] = ["x", "y", "z"];

/// One order of the polynomial on one axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrderFit {
    /// Largest power.
    pub order: usize,
    /// Akaike's criterion, corrected for the number of blocks, less that of the best order.
    pub aicc: f64,
    /// Weight by AICc among the orders.
    pub weight: f64,
    /// RMS error of blocks that were left out, ten stretches of time in turn, m/s².
    pub cross_validation: f64,
    /// F of the last power against the order below, correlated noise accounted for; `None` for the first.
    pub f: Option<f64>,
    /// Value of F that one in twenty such tests exceeds without such a power.
    pub f_limit: f64,
    /// Mean slope over the range, m/s² per K.
    pub slope: f64,
    /// Its standard uncertainty at this order.
    pub slope_uncertainty: f64,
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisFit {
    /// Every order that was fitted.
    pub orders: Vec<OrderFit>,
    /// Coefficients of d, d², d³ of the bias (of the output, in one attitude), m/s² per Kᵏ.
    pub bias: [f64; THERMAL_ORDER],
    /// Coefficients of d, d², d³ of the relative scale, 1/Kᵏ, where attitudes tell them apart.
    pub scale: Option<[f64; THERMAL_ORDER]>,
    /// What heating and cooling do differently, where both are there.
    pub hysteresis: Option<Hysteresis>,
    /// λ: output per rate of the temperature, m/s² per K/s, and its standard uncertainty, where it can be told.
    pub lag: Option<[f64; 2]>,
    /// Mean of the fitted change over the blocks, m/s².
    pub mean_change: f64,
    /// Residuals of the blocks, m/s².
    pub residuals: Vec<f64>,
}

impl AxisFit {
    /// Change of the bias (of the output, in one attitude) from the reference, m/s².
    pub fn change(&self, d: f64) -> f64 {
        let [a, b, c] = self.bias;
        d * (a + d * (b + d * c))
    }
}

/// Temperature coefficients with one joint covariance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TemperatureFit {
    /// T₀, °C.
    pub reference: f64,
    /// Lowest and highest temperature, °C.
    pub range: [f64; 2],
    /// Largest order.
    pub largest_order: usize,
    /// Whether scale and bias could be told apart: the sensor was swept in attitudes far enough from each other.
    pub scale: bool,
    /// The axes.
    pub axes: [AxisFit; 3],
    /// `slope.x` … (mean over the range), `bias.x.T1` … (`output.x.T1` … in one attitude), `scale.x.T1` …
    pub estimate: Estimate,
    /// The block means.
    pub blocks: Blocks,
    /// What to doubt.
    pub findings: Vec<Finding>,
    /// +1 heating, −1 cooling of every block.
    pub direction: Vec<f64>,
}

impl TemperatureFit {
    /// The attitudes the sensor was found in.
    pub fn attitudes(&self) -> &[Attitude] {
        &self.blocks.attitudes
    }
}

/// Columns of one model: nuisance first, then powers of z for the bias, then those for the scale.
struct Design {
    nuisance: Vec<Vec<f64>>,
    z: Vec<f64>,
    /// Specific force along each axis at every block, m/s², where scale is told from bias.
    force: Option<[Vec<f64>; 3]>,
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
        columns.extend((1..=order).map(|k| power(k, None)));
        if let Some(force) = &self.force {
            columns.extend((1..=order).map(|k| power(k, Some(&force[axis]))));
        }
        columns
    }
}

pub(super) fn fit(settings: &TemperatureSweep, blocks: &Blocks) -> Result<TemperatureFit, Error> {
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
    let branches = Branches::of(blocks);
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
    let gap_at = nuisance.len();
    if branches.common.is_some() {
        for k in 0..3 {
            let signed = branches.sign.iter().zip(&z);
            nuisance.push(signed.map(|(s, z)| 0.5 * s * z.powi(k)).collect());
        }
    }
    let lag_at = nuisance.len();
    if branches.lag {
        let fastest = branches.rate.iter().fold(0.0f64, |m, r| m.max(r.abs()));
        nuisance.push(branches.rate.iter().map(|r| r / fastest).collect());
    }
    let fixed = nuisance.len();
    let design = Design { nuisance, z, force };
    let noises = grid(&blocks.time, blocks.duration);
    let context = Context {
        settings,
        blocks,
        branches: &branches,
        design: &design,
        noises: &noises,
        half,
        reference,
        gap_at,
        lag_at,
        fixed,
    };
    let axes = [context.axis(0)?, context.axis(1)?, context.axis(2)?];
    let estimate = context.estimate(&axes)?;
    let scale = design.force.is_some();
    let mut fit = TemperatureFit {
        reference,
        range,
        largest_order: settings.largest_order,
        scale,
        axes: axes.map(|a| a.fit),
        estimate,
        blocks: blocks.clone(),
        findings: Vec::new(),
        direction: branches.sign,
    };
    fit.findings = findings::of(&fit, branches.common.is_some(), settings.probability);
    Ok(fit)
}

/// The specific force along each axis, where sweeps in attitudes far from each other tell scale from bias on all axes.
fn separable(blocks: &Blocks) -> Option<[Vec<f64>; 3]> {
    let [low, high] = blocks.range();
    let swept: Vec<&Attitude> = blocks
        .attitudes
        .iter()
        .filter(|a| a.range[1] - a.range[0] > 0.5 * (high - low))
        .collect();
    let cosine = |a: &Attitude, axis: usize| a.output[axis] / norm(a.output).max(f64::MIN_POSITIVE);
    let told = (0..3).all(|axis| {
        let c = swept.iter().map(|a| cosine(a, axis));
        let (least, most) = (
            c.clone().fold(f64::INFINITY, f64::min),
            c.fold(f64::NEG_INFINITY, f64::max),
        );
        most - least > 0.5
    });
    told.then(|| {
        std::array::from_fn(|axis| {
            let of = |s: &usize| blocks.attitudes[*s].output[axis];
            blocks.attitude.iter().map(of).collect()
        })
    })
}

struct Context<'a> {
    settings: &'a TemperatureSweep,
    blocks: &'a Blocks,
    branches: &'a Branches,
    design: &'a Design,
    noises: &'a [Noise],
    half: f64,
    reference: f64,
    gap_at: usize,
    lag_at: usize,
    fixed: usize,
}

/// One axis with what the joint estimate needs.
struct Axis {
    fit: AxisFit,
    /// Coefficients in powers of z: bias, then scale, each up to the largest order.
    coefficients: Vec<f64>,
    covariance: Vec<f64>,
    /// Half the difference of the branches in the same coefficients.
    branch: Vec<f64>,
    /// Degrees of freedom of the covariance.
    dof: f64,
}

impl Context<'_> {
    fn kinds(&self) -> usize {
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
                &self.design.columns(order, axis),
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
        let count = kinds * top;
        let coefficients = x[fixed..].to_vec();
        let covariance = (0..count * count)
            .map(|i| c[(fixed + i / count) * size + fixed + i % count])
            .collect();
        let hysteresis = self
            .branches
            .common
            .map(|common| self.hysteresis(common, x, c, size));
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
        let columns = self.design.columns(top, axis);
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
                mean_change,
                residuals,
            },
            coefficients,
            covariance,
            branch,
            dof: runs[top - 1].dof,
        })
    }

    /// Weights of z, z², z³ in the mean slope over the range, per K.
    fn slope_weights(&self, top: usize) -> Vec<f64> {
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
        let columns = self.design.columns(order, axis);
        let n = y.len();
        let mut sum = 0.0;
        let mut count = 0usize;
        for fold in 0..10 {
            let out = |i: usize| i * 10 / n == fold;
            let keep: Vec<usize> = (0..n).filter(|i| !out(*i)).collect();
            let pick = |c: &Vec<f64>| keep.iter().map(|i| c[*i]).collect::<Vec<f64>>();
            let x: Vec<Vec<f64>> = columns.iter().map(pick).collect();
            let white = &self.noises[..1];
            // A stretch that alone holds an attitude or a branch cannot be predicted by the others.
            let Ok(run) = averaged::fit(&x, &pick(&y.to_vec()), white) else {
                continue;
            };
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

    fn hysteresis(&self, common: [f64; 2], x: &[f64], c: &[f64], size: usize) -> Hysteresis {
        let at = self.gap_at;
        let curve: Vec<[f64; 3]> = (0..=24)
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
            .collect();
        let worst = curve.iter().fold(
            curve[0],
            |m, p| if p[1].abs() > m[1].abs() { *p } else { m },
        );
        Hysteresis {
            difference: worst[1],
            standard_uncertainty: worst[2],
            temperature: worst[0],
            curve,
        }
    }

    /// Mean slopes, then coefficients in powers of d, of all axes.
    fn estimate(&self, axes: &[Axis]) -> Result<Estimate, Error> {
        let top = self.settings.largest_order;
        let kinds = self.kinds();
        let count = kinds * top;
        let all = 3 * count;
        // One covariance in powers of z: within an axis its own, between axes by the correlation of the residuals.
        let correlation = residual_correlation(axes);
        let factors: Vec<Vec<f64>> = axes
            .iter()
            .map(|a| square_root(&a.covariance, count))
            .collect();
        let mut noise = vec![0.0; all * all];
        for a in 0..3 {
            for b in 0..3 {
                for i in 0..count {
                    for j in 0..count {
                        let sum: f64 = (0..count)
                            .map(|k| factors[a][i * count + k] * factors[b][j * count + k])
                            .sum();
                        noise[(a * count + i) * all + b * count + j] = correlation[a][b] * sum;
                    }
                }
            }
        }
        let weights = self.slope_weights(top);
        let mut components = Vec::new();
        let mut jacobian: Vec<f64> = Vec::new();
        let mut push = |component: Component, row: Vec<(usize, f64)>| {
            let mut dense = vec![0.0; all];
            for (i, v) in row {
                dense[i] = v;
            }
            jacobian.extend(dense);
            components.push(component);
        };
        for (a, axis) in axes.iter().enumerate() {
            let row = weights.iter().enumerate().map(|(k, w)| (a * count + k, *w));
            let value = weights
                .iter()
                .zip(&axis.coefficients)
                .map(|(w, c)| w * c)
                .sum();
            push(
                Component::new(format!("slope.{}", AXES[a]), "m/s²/K", value),
                row.collect(),
            );
        }
        let kind = if kinds == 2 { "bias" } else { "output" };
        for (a, axis) in axes.iter().enumerate() {
            for k in 0..count {
                let power = k % top + 1;
                let unit = self.half.powi(power as i32);
                let exponent = ["", "²", "³"][power - 1];
                let (name, unit_name) = if k < top {
                    (kind, format!("m/s²/K{exponent}"))
                } else {
                    ("scale", format!("1/K{exponent}"))
                };
                push(
                    Component::new(
                        format!("{name}.{}.T{power}", AXES[a]),
                        unit_name,
                        axis.coefficients[k] / unit,
                    ),
                    vec![(a * count + k, 1.0 / unit)],
                );
            }
        }
        // The least of the three axes: on the safe side for the others.
        let dof = axes.iter().map(|a| a.dof).fold(f64::INFINITY, f64::min);
        let mut influences = vec![Influence {
            key: "noise".to_owned(),
            description: "noise and wander of the outputs, over orders and noises by evidence"
                .to_owned(),
            evaluation: Evaluation::A,
            distribution: "t".to_owned(),
            dof: DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(all, &noise)?.propagate(&jacobian)?,
            },
        }];
        for (a, axis) in axes.iter().enumerate() {
            if axis.fit.hysteresis.is_none() {
                continue;
            }
            let sensitivity: Vec<f64> = jacobian
                .chunks(all)
                .map(|row| {
                    (0..count)
                        .map(|k| row[a * count + k] * axis.branch[k])
                        .sum()
                })
                .collect();
            influences.push(Influence {
                key: format!("hysteresis.{}", AXES[a]),
                description: format!("heating and cooling differ ({})", AXES[a]),
                evaluation: Evaluation::B,
                distribution: "rectangular".to_owned(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Scalar {
                    value: 0.0,
                    unit: "1".to_owned(),
                    standard_uncertainty: 1.0 / 3f64.sqrt(),
                    sensitivity,
                },
            });
        }
        Estimate::new(components, influences)
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

fn residual_correlation(axes: &[Axis]) -> [[f64; 3]; 3] {
    let product = |a: usize, b: usize| -> f64 {
        axes[a]
            .fit
            .residuals
            .iter()
            .zip(&axes[b].fit.residuals)
            .map(|(x, y)| x * y)
            .sum()
    };
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let size = (product(a, a) * product(b, b)).sqrt();
            if a == b {
                1.0
            } else if size > 0.0 {
                // Shrunk by a hair, so that three axes with one disturbance stay positive definite.
                0.999 * product(a, b) / size
            } else {
                0.0
            }
        })
    })
}

/// L with L Lᵀ = C of a covariance that may be singular, by rows.
fn square_root(covariance: &[f64], n: usize) -> Vec<f64> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            let rest = covariance[i * n + j] - sum;
            if i == j {
                l[i * n + i] = rest.max(0.0).sqrt();
            } else if l[j * n + j] > 0.0 {
                l[i * n + j] = rest / l[j * n + j];
            }
        }
    }
    l
}
