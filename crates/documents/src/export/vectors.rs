//! Outputs and accelerations with which exported code checks itself.

use crate::CalibrationFile;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_io::Unit;
use proofmass_signal::AnyCompensation;

/// Outputs of the sensor, its temperature, and what the desk makes of them.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfCheck {
    /// Output of every axis in the input unit.
    pub(crate) outputs: Vec<Vec<f64>>,
    /// Temperature, °C.
    pub(crate) temperatures: Vec<f64>,
    /// Acceleration in double precision, m/s².
    pub(crate) accelerations: Vec<Vec<f64>>,
    /// Largest rounding error of single precision, m/s².
    pub(crate) single_bound: f64,
    /// Largest rounding error of double precision, m/s².
    pub(crate) double_bound: f64,
}

impl SelfCheck {
    /// Every axis in both senses, all together and nothing, at both ends of the temperature and in its middle.
    pub fn of(file: &CalibrationFile, model: &AnyCompensation) -> Self {
        let tested = file
            .acceleration_range
            .map(|[low, high]| low.abs().max(high.abs()));
        let reach = file
            .curvature
            .as_ref()
            .map(|c| c.reach)
            .or(tested)
            .filter(|r| *r > 0.0)
            .unwrap_or(STANDARD_GRAVITY);
        let temperatures = match &file.temperature {
            Some(block) => vec![block.range[0], block.reference, block.range[1]],
            None => vec![0.0],
        };
        let mut check = Self {
            outputs: Vec::new(),
            temperatures: Vec::new(),
            accelerations: Vec::new(),
            single_bound: 0.0,
            double_bound: 0.0,
        };
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut size = 0.0f64;
        let directions: &[&[f64]] = match model.axes() {
            1 => &[&[0.0], &[1.0], &[-1.0], &[0.5], &[-0.6]],
            _ => &[
                &[0.0, 0.0, 0.0],
                &[1.0, 0.0, 0.0],
                &[-1.0, 0.0, 0.0],
                &[0.0, 1.0, 0.0],
                &[0.0, -1.0, 0.0],
                &[0.0, 0.0, 1.0],
                &[0.0, 0.0, -1.0],
                &[0.5, -0.6, 0.6],
            ],
        };
        for t in temperatures {
            for direction in directions {
                let acceleration: Vec<f64> = direction.iter().map(|c| c * reach).collect();
                let mut output = model.invert(&acceleration, t);
                if file.input_unit == Unit::Count {
                    output.iter_mut().for_each(|v| *v = v.round());
                }
                size = size.max(norm(&output) + norm(&model.bias()));
                let columns: Vec<&[f64]> = output.iter().map(std::slice::from_ref).collect();
                let compensated = model.apply_columns(&columns, Some(&[t]));
                check.accelerations.push(compensated.concat());
                check.outputs.push(output);
                check.temperatures.push(t);
            }
        }
        // Sixteen roundings at most between the output and the acceleration, each relative to the largest number in it.
        let per_epsilon = 16.0 * size * norm(&model.k_inverse().concat());
        check.single_bound = per_epsilon * f64::from(f32::EPSILON);
        check.double_bound = per_epsilon * f64::EPSILON;
        check
    }
}
