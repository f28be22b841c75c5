//! All axes in one joint estimate, with every cause of their uncertainty.

use super::averaged;
use super::fit::{Axis, Context};
use proofmass_core::{Error, norm};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence,
};

impl Context<'_> {
    /// Coefficients that a tilt at the jumps of the temperature would be taken for, one set for each cause.
    ///
    /// Where nobody says how well the attitude was kept, everything that changed across the specific force may be tilt, at
    /// all jumps together, and the biases may have hidden as much of it again, or as much as they changed along the force: on
    /// each axis the whole size; and what these angles, one after the other, take off along the force. Declared, each jump is a
    /// cause of its own.
    pub(super) fn tilt(&self, axis: usize, columns: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
        let n = self.blocks.len();
        let jumps = self.blocks.jumps();
        let mut causes = vec![vec![0.0; n]; if jumps.is_empty() { 0 } else { 2 }];
        let mut turned = [0.0; 3];
        for (at, _, change) in jumps {
            let attitude = self.blocks.attitude[at];
            let force = self.blocks.attitudes[attitude].output;
            let size = self.blocks.force(&self.blocks.attitudes[attitude]);
            let along = proofmass_core::dot(force, change) / size;
            let across: [f64; 3] = std::array::from_fn(|i| change[i] - along * force[i] / size);
            let cosine = (force[axis] / size).clamp(-1.0, 1.0);
            let sine = (1.0 - cosine * cosine).sqrt();
            let behind = (at..n).filter(|i| self.blocks.attitude[*i] == attitude);
            if let Some(angle) = self.settings.tilt {
                let width = size * (angle * sine + 0.5 * angle * angle * cosine.abs());
                let mut step = vec![0.0; n];
                behind.for_each(|i| step[i] = width);
                causes.push(step);
                continue;
            }
            if self.blocks.axes == 1 {
                // Of one axis nobody sees across: all that changed may be tilt, and may have hidden as much again.
                behind.for_each(|i| causes[0][i] += 2.0 * change[axis]);
                continue;
            }
            let seen = norm(across);
            let hidden = seen.max(along.abs());
            let whole = (seen + hidden) / seen.max(f64::MIN_POSITIVE);
            let before = norm(turned);
            turned = std::array::from_fn(|i| turned[i] + whole * across[i]);
            let first = ((seen + hidden) * sine).copysign(across[axis]);
            let second = 0.5 * cosine * (norm(turned).powi(2) - before.powi(2)) / size;
            for i in behind {
                causes[0][i] += first;
                causes[1][i] += second;
            }
        }
        causes.retain(|c| c.iter().any(|v| *v != 0.0));
        let design = [columns.to_vec()];
        let coefficients = |step: &Vec<f64>| {
            let run = averaged::fit(&design, step, &self.noises[..1])?;
            let (surroundings, powers) = run.estimate.split_at(self.fixed);
            Ok([powers, &surroundings[self.environment_at..]].concat())
        };
        causes.iter().map(coefficients).collect()
    }

    /// Mean slopes, then coefficients in powers of d, of all axes.
    pub(super) fn estimate(&self, axes: &[Axis]) -> Result<Estimate, Error> {
        let top = self.settings.largest_order;
        let kinds = self.kinds();
        // Powers of z, then the surroundings.
        let powers = kinds * top;
        let count = powers + kinds * self.environment.len();
        let parts = axes.len();
        let all = parts * count;
        // One covariance in powers of z: within an axis its own, between axes by the correlation of the residuals.
        let correlation = residual_correlation(axes);
        let factors: Vec<Vec<f64>> = axes
            .iter()
            .map(|a| square_root(&a.covariance, count))
            .collect();
        let mut noise = vec![0.0; all * all];
        for a in 0..parts {
            for b in 0..parts {
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
                Component::new(self.blocks.parameter("slope", a), "m/s²/K", value),
                row.collect(),
            );
        }
        let kind = if kinds == 2 { "bias" } else { "output" };
        for (a, axis) in axes.iter().enumerate() {
            for k in 0..powers {
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
                        format!("{}.T{power}", self.blocks.parameter(name, a)),
                        unit_name,
                        axis.coefficients[k] / unit,
                    ),
                    vec![(a * count + k, 1.0 / unit)],
                );
            }
        }
        for (a, axis) in axes.iter().enumerate() {
            for k in 0..count - powers {
                let course = self.environment[k % self.environment.len()];
                let (name, unit) = match k < self.environment.len() {
                    true => (kind, "m/s²"),
                    false => ("scale", "1"),
                };
                push(
                    Component::new(
                        format!("{}.{}", self.blocks.parameter(name, a), course.name),
                        match course.unit.as_str() {
                            "1" => unit.to_owned(),
                            of => format!("{unit}/{of}"),
                        },
                        axis.coefficients[powers + k] / course.half,
                    ),
                    vec![(a * count + powers + k, 1.0 / course.half)],
                );
            }
        }
        // The least of the axes: on the safe side for the others.
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
        let rectangle = |key: String, description: String, a: usize, coefficients: &[f64]| {
            let through = |row: &[f64]| -> f64 {
                let own = &row[a * count..(a + 1) * count];
                own.iter().zip(coefficients).map(|(r, c)| r * c).sum()
            };
            Influence {
                key,
                description,
                evaluation: Evaluation::B,
                distribution: "rectangular".to_owned(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::of_zero(
                    "1",
                    1.0 / 3f64.sqrt(),
                    jacobian.chunks(all).map(through).collect(),
                ),
            }
        };
        for (a, axis) in axes.iter().enumerate() {
            let name = self.blocks.names()[a];
            if axis.fit.hysteresis.is_some() {
                let what = format!("heating and cooling differ ({name})");
                influences.push(rectangle(
                    format!("hysteresis.{name}"),
                    what,
                    a,
                    &axis.branch,
                ));
            }
            for (number, coefficients) in axis.tilt.iter().enumerate() {
                let key = format!("tilt.{name}.{}", number + 1);
                let what = format!("tilt across a jump of the temperature ({name})");
                let mut cause = rectangle(key, what, a, coefficients);
                if let (
                    Some(_),
                    Effect::Scalar {
                        standard_uncertainty,
                        ..
                    },
                ) = (self.settings.tilt, &mut cause.effect)
                {
                    // Declared as a standard uncertainty.
                    *standard_uncertainty = 1.0;
                    cause.distribution = "normal".to_owned();
                }
                influences.push(cause);
            }
        }
        Estimate::new(components, influences)
    }
}

fn residual_correlation(axes: &[Axis]) -> Vec<Vec<f64>> {
    let product = |a: usize, b: usize| -> f64 {
        axes[a]
            .fit
            .residuals
            .iter()
            .zip(&axes[b].fit.residuals)
            .map(|(x, y)| x * y)
            .sum()
    };
    let of = |a: usize, b: usize| {
        let size = (product(a, a) * product(b, b)).sqrt();
        if a == b {
            1.0
        } else if size > 0.0 {
            // Shrunk by a hair, so that three axes with one disturbance stay positive definite.
            0.999 * product(a, b) / size
        } else {
            0.0
        }
    };
    let row = |a: usize| (0..axes.len()).map(|b| of(a, b)).collect();
    (0..axes.len()).map(row).collect()
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
