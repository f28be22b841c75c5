//! Scale, offset and temperature coefficient in multiples of local gravity as a calibration in m/s².

use super::FreeLivingOutcome;
use crate::page::AXES;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::{STANDARD_GRAVITY, THERMAL_ORDER};
use proofmass_documents::{CalibrationFile, ThermalBlock};
use proofmass_io::Unit;
use proofmass_uncertainty::{Component, DegreesOfFreedom, Effect, Estimate, Influence, Quantity};

impl FreeLivingOutcome {
    /// ã = K a + b with K = g₀/(s g), b = −o g₀ and β = −c g₀/s, from a/g = s (ã/g₀ + o) + c (T − T̄).
    ///
    /// **Units** ã and a in m/s²: a recording in g holds multiples of g₀ = 9.80665 m/s², whatever the place; g is gravity
    /// where it was worn, of which the sphere has the radius.
    pub(super) fn file(&self, record: &Record) -> Result<CalibrationFile> {
        let q = &self.fit.parameters;
        let (g0, g) = (STANDARD_GRAVITY, self.gravity.value());
        let k: [f64; 3] = std::array::from_fn(|i| g0 / (q.scale[i] * g));
        let b = q.offset.map(|o| -o * g0);
        let matrix =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { k[i] } else { 0.0 }));
        let estimate = self.in_si(k)?;
        let mut file = CalibrationFile::new(
            "free-living",
            Unit::MetrePerSecondSquared,
            matrix,
            b,
            estimate,
        );
        file.software = record.software.clone();
        file.device = record.device.clone();
        file.inputs = record.inputs.clone();
        file.columns = self.columns.as_ref().map(|c| c.to_vec());
        file.gravity = Some(Quantity {
            name: "gravity".to_owned(),
            unit: "m/s²".to_owned(),
            value: g,
            standard_uncertainty: self.gravity.standard_uncertainty(),
            dof: DegreesOfFreedom::INFINITE,
        });
        file.temperature_range = self.temperature_range;
        file.acceleration_range = Some([-g, g]);
        file.temperature =
            self.fit
                .mean_temperature
                .zip(self.temperature_range)
                .map(|(reference, range)| ThermalBlock {
                    reference,
                    bias: (0..3)
                        .map(|i| linear(-q.temperature[i] * g0 / q.scale[i]))
                        .collect(),
                    scale: vec![[0.0; THERMAL_ORDER]; 3],
                    range,
                    hysteresis: None,
                });
        Ok(file)
    }

    /// `bias.x` …, `scale.x` …, `bias.x.T1` … with everything that the fit knows of them, and gravity.
    fn in_si(&self, k: [f64; 3]) -> Result<Estimate> {
        let q = &self.fit.parameters;
        let g0 = STANDARD_GRAVITY;
        let width = self.fit.estimate.components().len();
        let index = |name: String| {
            self.fit
                .estimate
                .index_of(&name)
                .ok_or_else(|| Trouble::data(format!("the fit lacks {name}")))
        };
        let (mut components, mut rows) = (Vec::new(), Vec::new());
        let mut add = |component: Component, entries: &[(usize, f64)]| {
            components.push(component);
            let mut row = vec![0.0; width];
            for (column, value) in entries {
                row[*column] = *value;
            }
            rows.extend(row);
        };
        for (i, axis) in AXES.iter().enumerate() {
            let offset = index(format!("offset.{axis}"))?;
            let value = -q.offset[i] * g0;
            add(
                Component::new(format!("bias.{axis}"), "m/s²", value),
                &[(offset, -g0)],
            );
        }
        for (i, axis) in AXES.iter().enumerate() {
            let scale = index(format!("scale.{axis}"))?;
            add(
                Component::new(format!("scale.{axis}"), "1", k[i]),
                &[(scale, -k[i] / q.scale[i])],
            );
        }
        if self.fit.mean_temperature.is_some() {
            for (i, axis) in AXES.iter().enumerate() {
                let (s, c) = (q.scale[i], q.temperature[i]);
                let value = -c * g0 / s;
                add(
                    Component::new(format!("bias.{axis}.T1"), "m/s²/K", value),
                    &[
                        (index(format!("temperature.{axis}"))?, -g0 / s),
                        (index(format!("scale.{axis}"))?, -value / s),
                    ],
                );
            }
        }
        let n = components.len();
        let estimate = self.fit.estimate.propagate(components, &rows)?;
        let mut influences = estimate.influences().to_vec();
        let mut sensitivity = vec![0.0; n];
        for (axis, value) in k.into_iter().enumerate() {
            sensitivity[3 + axis] = -value / self.gravity.value();
        }
        influences.push(Influence::normal(
            "gravity",
            "gravity where it was worn",
            Effect::Scalar {
                value: self.gravity.value(),
                unit: "m/s²".to_owned(),
                standard_uncertainty: self.gravity.standard_uncertainty(),
                sensitivity,
            },
        ));
        Ok(Estimate::new(estimate.components().to_vec(), influences)?)
    }
}

fn linear(coefficient: f64) -> [f64; THERMAL_ORDER] {
    let mut powers = [0.0; THERMAL_ORDER];
    powers[0] = coefficient;
    powers
}
