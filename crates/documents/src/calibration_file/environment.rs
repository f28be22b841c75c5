//! Other quantities of the surroundings in a calibration: humidity, pressure, supply voltage.

use super::{CalibrationFile, axis_names};
use proofmass_io::{Error, ErrorKind, Result};
use proofmass_uncertainty::Component;
use serde::{Deserialize, Serialize};

/// How bias and scale of each axis follow another quantity E of the surroundings than the temperature: with e = E − E₀,
/// b_i(T, E) = b_i(T) + ε_i e and K(T, E) = diag(1 + Σ γ_ik dᵏ + σ_i e) K.
///
/// In the estimate the coefficients are named `bias.x.humidity`, `scale.x.humidity`, … (`bias.humidity`, … of a single axis). Beyond
/// the range in which they were measured they are held at its nearer end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EnvironmentBlock {
    /// Name of the quantity.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// E₀: its value at which bias and scale are those of the calibration.
    pub reference: f64,
    /// ε: per axis the coefficient of the bias, input unit per unit of the quantity.
    pub bias: Vec<f64>,
    /// σ: per axis the coefficient of the relative scale, 1 per unit of the quantity.
    pub scale: Vec<f64>,
    /// Values between which they were measured.
    pub range: [f64; 2],
}

impl EnvironmentBlock {
    /// e: a value less the reference, held within the range.
    pub fn deviation(&self, value: f64) -> f64 {
        value.clamp(self.range[0], self.range[1]) - self.reference
    }

    pub(super) fn is_of(&self, axes: usize) -> bool {
        [self.bias.len(), self.scale.len()] == [axes; 2]
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        let mut all = [self.bias.as_slice(), &self.scale, &self.range].concat();
        all.push(self.reference);
        all
    }

    /// Names of the coefficients of bias and scale of an axis in the estimate.
    pub fn names(&self, i: usize) -> [String; 2] {
        let axis = axis_names(self.bias.len())[i];
        ["bias", "scale"].map(|kind| format!("{kind}{axis}.{}", self.name))
    }

    /// The same with their values here.
    pub(super) fn named(&self, i: usize) -> Vec<(String, f64)> {
        let values = [self.bias[i], self.scale[i]];
        self.names(i).into_iter().zip(values).collect()
    }

    /// What keeps it from being used.
    pub(super) fn fault(&self) -> Option<String> {
        let plain = |c: char| !c.is_control() && !matches!(c, '.' | '=');
        if self.name.trim().is_empty() || !self.name.chars().all(plain) {
            return Some(format!("{:?} is no name of a quantity", self.name));
        }
        if self.unit.trim().is_empty() {
            return Some(format!("{} has no unit", self.name));
        }
        if !(self.range[0] < self.range[1]) {
            return Some(format!("the range of {} is empty or reversed", self.name));
        }
        let far = self.range.map(|end| (end - self.reference).abs());
        let far = far[0].max(far[1]);
        let large = self.scale.iter().find(|s| s.abs() * far > 0.5)?;
        Some(format!(
            "the scale changes by {:.0} % over the range of {}, which is no small correction",
            100.0 * large.abs() * far,
            self.name
        ))
    }
}

impl CalibrationFile {
    /// The calibration at stated values of quantities of the surroundings, which it then follows no more: bias and scale are those
    /// there, with their uncertainty.
    ///
    /// # Errors
    /// A quantity that it does not follow, one that is stated twice, a value beyond the range in which it was measured.
    pub fn at_environment(&self, values: &[(String, f64)]) -> Result<Self> {
        let refuse = |what: String, hint: String| {
            Err(Error::new(ErrorKind::Configuration, what).with_hint(hint))
        };
        let mut file = self.clone();
        for (name, value) in values {
            let Some(at) = file.environment.iter().position(|e| e.name == *name) else {
                let known: Vec<&str> = self.environment.iter().map(|e| e.name.as_str()).collect();
                return refuse(
                    match known.contains(&name.as_str()) {
                        true => format!("{name} is stated twice"),
                        false => format!("the calibration does not follow {name}"),
                    },
                    match known.is_empty() {
                        true => "leave it out: `proofmass test temperature --environment` measures how a sensor follows it".to_owned(),
                        false => format!("it follows {}: state each once", known.join(" and ")),
                    },
                );
            };
            let block = file.environment.remove(at);
            let [low, high] = block.range;
            if !(low..=high).contains(value) {
                return refuse(
                    format!(
                        "{name} of {value} {} is beyond what was measured",
                        block.unit
                    ),
                    format!("state a value from {low:.6} to {high:.6} {}", block.unit),
                );
            }
            file.fix(&block, *value)?;
        }
        Ok(file)
    }

    /// Whether it is at one value of everything but the temperature, for what has no place for other quantities.
    ///
    /// # Errors
    /// It follows quantities of the surroundings beside the temperature.
    pub fn at_one_environment(&self) -> Result<()> {
        let Some(block) = self.environment.first() else {
            return Ok(());
        };
        Err(Error::new(
            ErrorKind::Configuration,
            format!(
                "the calibration follows {}, which has no place here",
                block.name
            ),
        )
        .with_hint(format!(
            "state at which value it is to hold: --at {}=VALUE, in {}",
            block.name, block.unit
        )))
    }

    /// One quantity at one value, which is no longer among those that it follows.
    fn fix(&mut self, block: &EnvironmentBlock, value: f64) -> Result<()> {
        let e = block.deviation(value);
        let old = self.estimate.components();
        let gone: Vec<String> = (0..self.axes()).flat_map(|i| block.names(i)).collect();
        let kept: Vec<usize> = (0..old.len())
            .filter(|k| !gone.contains(&old[*k].name))
            .collect();
        let mut components: Vec<Component> = kept.iter().map(|k| old[*k].clone()).collect();
        let mut jacobian = vec![0.0; kept.len() * old.len()];
        for (row, k) in kept.iter().enumerate() {
            jacobian[row * old.len() + k] = 1.0;
        }
        for (i, axis) in axis_names(self.axes()).iter().enumerate() {
            let [of_bias, of_scale] = block.names(i).map(|name| self.estimate.index_of(&name));
            let factor = 1.0 + block.scale[i] * e;
            let gain = self.k[i][i];
            self.b[i] += block.bias[i] * e;
            self.k[i].iter_mut().for_each(|k| *k *= factor);
            if let Some(thermal) = &mut self.temperature {
                thermal.scale[i].iter_mut().for_each(|c| *c /= factor);
            }
            let terms = components
                .iter_mut()
                .zip(jacobian.chunks_mut(old.len().max(1)));
            for ((component, row), k) in terms.zip(&kept) {
                if component.name == format!("bias{axis}") {
                    component.value += block.bias[i] * e;
                    of_bias.into_iter().for_each(|at| row[at] = e);
                } else if component.name == format!("scale{axis}") {
                    component.value *= factor;
                    row[*k] = factor;
                    of_scale.into_iter().for_each(|at| row[at] = gain * e);
                } else if component.name.starts_with(&format!("scale{axis}.")) {
                    // Those of the temperature and of other quantities are relative to the scale here.
                    component.value /= factor;
                    row[*k] = 1.0 / factor;
                    let slope = -component.value / factor * e;
                    of_scale.into_iter().for_each(|at| row[at] = slope);
                }
            }
            for other in &mut self.environment {
                other.scale[i] /= factor;
            }
        }
        let estimate = self.estimate.propagate(components, &jacobian);
        self.estimate =
            estimate.map_err(|e| Error::new(ErrorKind::Configuration, e.to_string()))?;
        Ok(())
    }

    /// Outputs as the sensor would give them at the reference of the other quantities of the surroundings.
    ///
    /// **Shapes** a column of outputs for each axis, a column of values for each quantity that it follows, in their order, and one of
    /// temperatures in °C, all of one length.
    pub fn at_reference(
        &self,
        outputs: &mut [Vec<f64>],
        temperature: Option<&[f64]>,
        values: &[Vec<f64>],
    ) {
        for (i, column) in outputs.iter_mut().enumerate() {
            for (row, output) in column.iter_mut().enumerate() {
                let (mut bias, mut scale) = (self.b[i], 1.0);
                if let (Some(block), Some(t)) = (&self.temperature, temperature) {
                    let [of_bias, of_scale] = block.changes(i, block.deviation(t[row]));
                    bias += of_bias;
                    scale += of_scale;
                }
                let (mut added, mut factor) = (0.0, scale);
                for (block, values) in self.environment.iter().zip(values) {
                    let e = block.deviation(values[row]);
                    added += block.bias[i] * e;
                    factor += block.scale[i] * e;
                }
                *output = bias + (*output - bias - added) * scale / factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ThermalBlock;
    use proofmass_io::Unit;
    use proofmass_uncertainty::{
        Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence,
    };

    /// One axis that follows temperature, humidity and supply in bias and scale, with a covariance that is not diagonal.
    fn calibration() -> CalibrationFile {
        let values = [
            ("bias", "V", 0.01),
            ("scale", "V/(m/s²)", 0.013),
            ("bias.T1", "V/K", 2e-4),
            ("scale.T1", "1/K", 1e-4),
            ("bias.humidity", "V/%", 3e-5),
            ("scale.humidity", "1/%", 2e-4),
            ("bias.supply", "V/V", 0.02),
            ("scale.supply", "1/V", -0.1),
        ];
        let components: Vec<Component> = values
            .iter()
            .map(|(name, unit, value)| Component::new(*name, *unit, *value))
            .collect();
        let n = components.len();
        let cell = |i: usize, j: usize| {
            let part = 1e-3 * values[i].2 * 1e-3 * values[j].2;
            if i == j { part } else { 0.2 * part }
        };
        let rows: Vec<f64> = (0..n * n).map(|k| cell(k / n, k % n)).collect();
        let influence = Influence {
            key: "fit".into(),
            description: "fit".into(),
            evaluation: Evaluation::A,
            distribution: "normal".into(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(n, &rows).unwrap(),
            },
        };
        let estimate = Estimate::new(components, vec![influence]).unwrap();
        let mut file = CalibrationFile::new("line", Unit::Volt, [[0.013]], [0.01], estimate);
        file.temperature = Some(ThermalBlock {
            reference: 25.0,
            bias: vec![[2e-4, 0.0, 0.0]],
            scale: vec![[1e-4, 0.0, 0.0]],
            range: [0.0, 60.0],
            hysteresis: None,
        });
        let block = |name: &str, unit: &str, reference, bias, scale, range| EnvironmentBlock {
            name: name.into(),
            unit: unit.into(),
            reference,
            bias: vec![bias],
            scale: vec![scale],
            range,
        };
        file.environment = vec![
            block("humidity", "%", 50.0, 3e-5, 2e-4, [20.0, 80.0]),
            block("supply", "V", 3.3, 0.02, -0.1, [3.0, 3.6]),
        ];
        file
    }

    /// At a value it is what it is with a column of that value, and its uncertainty is that of the acceleration there.
    #[test]
    fn law_a_value_is_a_column_of_it() {
        let file = calibration();
        let back = CalibrationFile::from_json(&file.to_json().unwrap()).unwrap();
        assert_eq!(back.environment, file.environment);
        let values = [("supply".to_owned(), 3.45), ("humidity".to_owned(), 64.0)];
        let fixed = file.at_environment(&values).unwrap();
        assert!(fixed.environment.is_empty());
        fixed.to_json().unwrap();
        let (t, outputs) = ([44.0; 3], vec![vec![-0.2, 0.014, 0.31]]);
        let slices = |columns: &[Vec<f64>]| {
            fixed
                .compensation()
                .unwrap()
                .apply_columns(&[&columns[0]], Some(&t))
        };
        let by_value = slices(&outputs);
        let mut moved = outputs.clone();
        file.at_reference(&mut moved, Some(&t), &[vec![64.0; 3], vec![3.45; 3]]);
        let by_column = file
            .compensation()
            .unwrap()
            .apply_columns(&[&moved[0]], Some(&t));
        for (k, a) in by_value[0].iter().enumerate() {
            assert!((a - by_column[0][k]).abs() < 1e-12 * a.abs());
            // The equation itself.
            let gain = 0.013 * (1.0 + 1e-4 * 19.0 + 2e-4 * 14.0 - 0.1 * 0.15);
            let bias = 0.01 + 2e-4 * 19.0 + 3e-5 * 14.0 + 0.02 * 0.15;
            assert!((a - (outputs[0][k] - bias) / gain).abs() < 1e-11 * a.abs());
            let there = &file
                .accelerations(&[*a], Some(44.0), &[64.0, 3.45])
                .unwrap()[0];
            let here = &fixed.accelerations(&[*a], Some(44.0), &[]).unwrap()[0];
            let ratio = there.standard_uncertainty / here.standard_uncertainty;
            assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        }
    }

    #[test]
    fn known_blocks_that_cannot_be_used() {
        let refused = |change: &dyn Fn(&mut CalibrationFile), word: &str| {
            let mut file = calibration();
            change(&mut file);
            let said = file.to_json().unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        };
        refused(&|f| f.environment[0].range = [80.0, 20.0], "reversed");
        refused(&|f| f.environment[0].scale[0] = 0.05, "no small correction");
        refused(&|f| f.environment[1].bias[0] = f64::NAN, "finite");
        refused(
            &|f| f.environment[1].bias.push(0.0),
            "another number of axes",
        );
        refused(&|f| f.environment[1].name = "humidity".into(), "twice");
        refused(&|f| f.environment[0].bias[0] = 1e-5, "disagrees");
        refused(
            &|f| f.environment[0].name = "pressure".into(),
            "stands in no estimate",
        );
        refused(&|f| f.environment[0].name = String::new(), "no name");
        refused(&|f| f.environment[0].unit = String::new(), "no unit");
    }
}
