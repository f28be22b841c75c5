//! Accelerations of a calibration with what it leaves open of them.

use super::{CalibrationFile, EnvironmentBlock, axis_names};
use proofmass_uncertainty::{Component, Effect, Estimate, Influence, Quantity};

impl CalibrationFile {
    /// Accelerations that this calibration gives, one of each axis, with what the calibration leaves open of them; `None` where it states
    /// no uncertainty.
    ///
    /// Each output is o = b(T, E) + k(T, E)(x + k₂ x² + k₃ x³) of x = a along its own sensitive axis, and x = M a with ones on the diagonal
    /// of M and the misalignments beside it. So ∂a/∂p = −M⁻¹((∂o/∂p)/(∂o/∂x) + (∂M/∂p) a) for every parameter p, with the joint covariance.
    ///
    /// **Units** accelerations in m/s², temperature in °C; other quantities of the surroundings in their units, in the order of
    /// [`CalibrationFile::environment`], at their references where none are given.
    ///
    /// **Shapes** one acceleration of each axis.
    pub fn accelerations(
        &self,
        a: &[f64],
        temperature: Option<f64>,
        environment: &[f64],
    ) -> Option<Vec<Quantity>> {
        let n = self.axes();
        if a.len() != n || self.estimate.influences().is_empty() {
            return None;
        }
        let axes = axis_names(n);
        let rows: Vec<Row<'_>> = (0..n)
            .map(|i| self.row(i, a, temperature, environment))
            .collect();
        // M⁻¹ = K⁻¹ with each column times the diagonal element of K.
        let inverse: Vec<Vec<f64>> = match n {
            1 => vec![vec![1.0]],
            _ => {
                let k = self.sensor().ok()?.k_inverse().0;
                let scaled = |row: [f64; 3]| (0..n).map(|j| row[j] * self.k[j][j]).collect();
                k.map(scaled).to_vec()
            }
        };
        let parameters = self.estimate.components();
        let effects: Vec<Vec<f64>> = parameters
            .iter()
            .map(|c| {
                let turned = |i: usize| -> f64 {
                    let of = |j: &usize| {
                        let b = axes[*j].trim_start_matches('.');
                        c.name == format!("misalignment{}{b}", axes[i])
                    };
                    (0..n).filter(|j| *j != i).find(of).map_or(0.0, |j| a[j])
                };
                let open = |i: usize| rows[i].effect(&c.name) / rows[i].slope + turned(i);
                (0..n).map(open).collect()
            })
            .collect();
        let jacobian: Vec<f64> = inverse
            .iter()
            .flat_map(|row| {
                let of =
                    |effect: &Vec<f64>| -row.iter().zip(effect).map(|(m, e)| m * e).sum::<f64>();
                effects.iter().map(of).collect::<Vec<f64>>()
            })
            .collect();
        // On which branch between heating and cooling a reading lies is not known.
        let hysteresis = match (&self.temperature, temperature) {
            (Some(block), Some(_)) => block.hysteresis.as_deref().unwrap_or_default(),
            _ => &[],
        };
        let branches = hysteresis.iter().enumerate().map(|(j, u)| {
            let of = inverse.iter().map(|row| row[j] / rows[j].slope).collect();
            let effect = Effect::of_zero(self.input_unit.to_string(), *u, of);
            Influence::normal(
                format!("hysteresis{}", axes[j]),
                "heating and cooling",
                effect,
            )
        });
        let name = |i: usize| format!("acceleration{}", axes[i]);
        let components = (0..n)
            .map(|i| Component::new(name(i), "m/s²", a[i]))
            .collect();
        let propagated = self.estimate.propagate(components, &jacobian).ok()?;
        let influences = propagated.influences().iter().cloned().chain(branches);
        let estimate =
            Estimate::new(propagated.components().to_vec(), influences.collect()).ok()?;
        (0..n).map(|i| estimate.get(&name(i))).collect()
    }

    /// The output of one axis at these accelerations.
    fn row(
        &self,
        axis: usize,
        a: &[f64],
        temperature: Option<f64>,
        environment: &[f64],
    ) -> Row<'_> {
        let k = self.k[axis][axis];
        let along = self.k[axis].iter().zip(a);
        let x = along.map(|(element, a)| element / k * a).sum::<f64>();
        let curvature = self.curvature.as_ref();
        let (k2, k3) = curvature.map_or((0.0, 0.0), |c| (c.quadratic[axis], c.cubic[axis]));
        let block = self.temperature.as_ref();
        let d = match (block, temperature) {
            (Some(block), Some(t)) => block.deviation(t),
            _ => 0.0,
        };
        let around: Vec<(&EnvironmentBlock, f64)> = self
            .environment
            .iter()
            .zip(environment)
            .map(|(block, value)| (block, block.deviation(*value)))
            .collect();
        let by_environment: f64 = around.iter().map(|(block, e)| block.scale[axis] * e).sum();
        let warm = 1.0 + by_environment + block.map_or(0.0, |block| block.changes(axis, d)[1]);
        Row {
            axis,
            name: axis_names(self.axes())[axis],
            k,
            x,
            shape: x * (1.0 + x * (k2 + x * k3)),
            warm,
            slope: k * warm * (1.0 + x * (2.0 * k2 + 3.0 * k3 * x)),
            powers: [d, d * d, d * d * d],
            around,
        }
    }
}

/// One output at one acceleration, where its parameters are varied.
struct Row<'a> {
    axis: usize,
    /// Of the axis, as in the names of its parameters.
    name: &'static str,
    /// Scale factor.
    k: f64,
    /// Acceleration along its own sensitive axis.
    x: f64,
    /// x + k₂ x² + k₃ x³.
    shape: f64,
    /// Relative scale factor at this temperature and in these surroundings.
    warm: f64,
    /// ∂o/∂x.
    slope: f64,
    /// Powers of the temperature difference.
    powers: [f64; 3],
    around: Vec<(&'a EnvironmentBlock, f64)>,
}

impl Row<'_> {
    /// ∂o/∂p of a parameter; zero of those of other axes.
    fn effect(&self, name: &str) -> f64 {
        let Self { k, x, warm, .. } = *self;
        let own = |kind: &str| name.strip_prefix(kind)?.strip_prefix(self.name);
        if let Some(rest) = own("curvature") {
            return match rest {
                ".2" => k * warm * x * x,
                ".3" => k * warm * x * x * x,
                _ => 0.0,
            };
        }
        let power = |rest: &str| rest.strip_prefix(".T")?.parse::<usize>().ok();
        let of_environment = || {
            self.around.iter().find_map(|(block, e)| {
                let [bias, scale] = block.names(self.axis);
                match name {
                    _ if name == bias => Some(*e),
                    _ if name == scale => Some(k * self.shape * e),
                    _ => None,
                }
            })
        };
        match (own("bias"), own("scale")) {
            (Some(""), _) => 1.0,
            (_, Some("")) => warm * self.shape,
            (bias, scale) => match (bias.and_then(power), scale.and_then(power)) {
                (Some(power @ 1..=3), _) => self.powers[power - 1],
                (_, Some(power @ 1..=3)) => k * self.shape * self.powers[power - 1],
                _ => of_environment().unwrap_or(0.0),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CurvatureBlock, ThermalBlock};
    use proofmass_io::Unit;

    /// Values of the parameters of three axes, in the order of their names.
    const NAMES: [&str; 15] = [
        "bias.x",
        "bias.y",
        "bias.z",
        "scale.x",
        "scale.y",
        "scale.z",
        "misalignment.xy",
        "misalignment.xz",
        "misalignment.yz",
        "misalignment.yx",
        "bias.y.T1",
        "scale.y.T2",
        "curvature.x.2",
        "curvature.z.3",
        "scale.z.humidity",
    ];
    const VALUES: [f64; 15] = [
        3.0, -7.0, 2.0, 100.0, 102.0, 98.0, 0.01, -0.02, 0.015, 0.03, 0.05, 1e-5, 2e-4, 1e-6, 3e-4,
    ];

    /// With the parameters at these values, and the one of this number uncertain by u.
    fn calibration(v: &[f64; 15], uncertain: usize, u: f64) -> CalibrationFile {
        let k = [
            [v[3], v[3] * v[6], v[3] * v[7]],
            [v[4] * v[9], v[4], v[4] * v[8]],
            [0.0, 0.0, v[5]],
        ];
        let components = NAMES
            .iter()
            .zip(v)
            .map(|(n, v)| Component::new(*n, "1", *v));
        let shares = (0..15)
            .map(|i| f64::from(u8::from(i == uncertain)))
            .collect();
        let influence = Influence::normal("one", "one", Effect::of_zero("1", u, shares));
        let estimate = Estimate::new(components.collect(), vec![influence]).unwrap();
        let mut file = CalibrationFile::new("full", Unit::Count, k, [v[0], v[1], v[2]], estimate);
        file.temperature = Some(ThermalBlock {
            reference: 25.0,
            bias: vec![[0.0; 3], [v[10], 0.0, 0.0], [0.0; 3]],
            scale: vec![[0.0; 3], [0.0, v[11], 0.0], [0.0; 3]],
            range: [0.0, 60.0],
            hysteresis: None,
        });
        file.curvature = Some(CurvatureBlock {
            quadratic: vec![v[12], 0.0, 0.0],
            cubic: vec![0.0, 0.0, v[13]],
            reach: 20.0,
        });
        file.environment = vec![EnvironmentBlock {
            name: "humidity".into(),
            unit: "%".into(),
            reference: 50.0,
            bias: vec![0.0; 3],
            scale: vec![0.0, 0.0, v[14]],
            range: [20.0, 80.0],
        }];
        file
    }

    /// The same output, read by a calibration of which one parameter is another, is another acceleration: by the difference that is stated.
    #[test]
    fn law_an_acceleration_moves_with_each_parameter_as_stated() {
        let (a, t, humidity) = ([4.0, -9.0, 7.0], 44.0, 64.0);
        let read = |v: &[f64; 15], outputs: &[Vec<f64>]| -> Vec<f64> {
            let file = calibration(v, 0, 1.0);
            let mut moved = outputs.to_vec();
            file.at_reference(&mut moved, Some(&[t]), &[vec![humidity]]);
            let columns: Vec<&[f64]> = moved.iter().map(Vec::as_slice).collect();
            let back = file
                .compensation()
                .unwrap()
                .apply_columns(&columns, Some(&[t]));
            back.into_iter().map(|column| column[0]).collect()
        };
        // The output that reads as a, by Newton's method on the compensation itself.
        let mut outputs = vec![vec![0.0]; 3];
        for _ in 0..40 {
            let back = read(&VALUES, &outputs);
            for (o, (back, a)) in outputs.iter_mut().zip(back.iter().zip(a)) {
                o[0] += 100.0 * (a - back);
            }
        }
        for p in 0..15 {
            let step = 1e-4 * VALUES[p].abs();
            let u = |sign: f64| {
                let mut v = VALUES;
                v[p] += sign * step;
                read(&v, &outputs)
            };
            let (up, down) = (u(1.0), u(-1.0));
            let file = calibration(&VALUES, p, step);
            let stated = file.accelerations(&a, Some(t), &[humidity]).unwrap();
            for i in 0..3 {
                let moved = 0.5 * (up[i] - down[i]).abs();
                let off = stated[i].standard_uncertainty - moved;
                assert!(
                    off.abs() < 1e-4 * moved + 1e-10,
                    "{} {i}: {moved} {off}",
                    NAMES[p]
                );
            }
        }
    }
}
