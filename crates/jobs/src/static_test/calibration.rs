//! The calibration that a test of one axis makes.

use super::{StaticTest, StaticTestInput};
use crate::record::gravity_quantity;
use crate::trouble::{Result, Trouble};
use crate::value_range::widened;
use proofmass_core::THERMAL_ORDER;
use proofmass_documents::{CalibrationFile, CurvatureBlock, ThermalBlock};
use proofmass_io::Unit;
use proofmass_static::static_test::StaticFit;
use proofmass_uncertainty::Component;

/// Scale factor, bias and what else the test measured of the output of one axis, in SI with the joint covariance of the fit; `None`
/// where the test measures no axis through its output.
///
/// # Errors
/// A sensitivity that is not told from zero, curvature that is no correction, a unit that is none.
pub(super) fn calibration(
    test: &StaticTest,
    fit: &StaticFit,
    input: &StaticTestInput<'_>,
    probability: f64,
) -> Result<Option<CalibrationFile>> {
    let StaticTestInput::Readings { temperature, .. } = input else {
        return Ok(None);
    };
    let estimate = &fit.estimate;
    let (Some(bias), Some(sensitivity)) = (estimate.get("bias"), estimate.get("sensitivity"))
    else {
        return Ok(None);
    };
    if sensitivity.value.abs() <= sensitivity.expanded(probability) {
        return Err(Trouble::data(
            "the sensitivity is zero within its uncertainty",
        ));
    }
    let unit: Unit = fit.unit.parse().map_err(|e: String| Trouble::data(e))?;
    let (unit, factor) = unit.si();
    let mut components = Vec::new();
    let mut jacobian = Vec::new();
    let mut take = |from: &str, to: &str, unit: String, factor: f64| -> Option<f64> {
        let index = estimate.index_of(from)?;
        let value = factor * estimate.components()[index].value;
        components.push(Component::new(to, unit, value));
        let row = (0..estimate.components().len()).map(|i| if i == index { factor } else { 0.0 });
        jacobian.extend(row);
        Some(value)
    };
    take("bias", "bias", unit.to_string(), factor);
    take("sensitivity", "scale", format!("{unit}/(m/s²)"), factor);
    let quadratic = take("curvature.2", "curvature.2", "1/(m/s²)".to_owned(), 1.0);
    let cubic = take("curvature.3", "curvature.3", "1/(m/s²)²".to_owned(), 1.0);
    let warming = take("temperature", "bias.T1", format!("{unit}/K"), factor);
    let estimate = estimate.propagate(components, &jacobian)?;
    let phase = fit.estimate.get("misalignment").map_or(0.0, |q| q.value);
    let acceleration = |input: f64| match test {
        StaticTest::Tilt(tilt) => tilt.gravity.value() * (input + phase).cos(),
        _ => input,
    };
    let nothing = || Trouble::data("the test has no reading");
    let inputs = fit.readings.iter().map(|r| acceleration(r.input));
    let [low, high] = widened(None, inputs).ok_or_else(nothing)?;
    let mut file = CalibrationFile::new(
        test.name(),
        unit,
        [[factor * sensitivity.value]],
        [factor * bias.value],
        estimate,
    );
    file.acceleration_range = Some([low, high]);
    file.gravity = match test {
        StaticTest::Tilt(t) => Some(gravity_quantity(t.gravity)),
        StaticTest::Sensitivity(t) => Some(gravity_quantity(t.gravity)),
        _ => None,
    };
    if quadratic.is_some() || cubic.is_some() {
        file.curvature = Some(CurvatureBlock {
            quadratic: vec![quadratic.unwrap_or(0.0)],
            cubic: vec![cubic.unwrap_or(0.0)],
            reach: low.abs().max(high.abs()),
        });
    }
    if let (Some(slope), Some(temperature)) = (warming, temperature) {
        let range = widened(None, temperature.iter().copied()).ok_or_else(nothing)?;
        file.temperature_range = Some(range);
        file.temperature = Some(ThermalBlock {
            // Where the linearity test sets it: the mean of its readings.
            reference: temperature.iter().sum::<f64>() / temperature.len() as f64,
            bias: vec![[slope, 0.0, 0.0]],
            scale: vec![[0.0; THERMAL_ORDER]],
            range,
            hysteresis: None,
        });
    }
    // What cannot be written cannot be applied either.
    file.to_json()?;
    Ok(Some(file))
}
