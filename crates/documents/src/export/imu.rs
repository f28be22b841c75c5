//! The accelerometer intrinsics of an IMU as Kalibr writes them.

use super::{Plan, unable};
use proofmass_io::{Result, Unit};
use std::fmt::Write;

/// Scale and misalignment M of a_measured = M a + b, with the bias as a comment: those programs estimate it themselves.
///
/// **Source** `[Kalibr]` (scale-misalignment model of the IMU).
pub(super) fn text(plan: &Plan<'_>) -> Result<String> {
    if plan.file.input_unit != Unit::MetrePerSecondSquared {
        return Err(unable(
            &format!(
                "imu.yaml takes outputs in m/s^2, the calibration takes {}",
                plan.file.input_unit.ascii()
            ),
            "convert the recording with the nominal sensitivity, calibrate it in m/s², export that",
        ));
    }
    let sensor = plan.file.sensor()?;
    let mut text = String::new();
    for line in plan.heading() {
        let _ = writeln!(text, "# {line}");
    }
    if plan.needs_temperature() {
        let _ = writeln!(
            text,
            "# The form has no place for temperature: this is the model at {:?} degC.",
            plan.model.reference().unwrap_or(0.0)
        );
    }
    if plan.file.curvature.is_some() {
        let _ = writeln!(
            text,
            "# The form has no place for curvature: it is left out."
        );
    }
    let [x, y, z] = sensor.bias();
    let _ = writeln!(
        text,
        "# Measured = M * true + bias; bias x, y, z: {x:e}, {y:e}, {z:e} m/s^2.\n\
         # Noise densities: `proofmass noise RECORDING` writes them from a recording at rest.\n\
         imu0:\n  accelerometers:\n    M:"
    );
    for row in sensor.k().0 {
        let _ = writeln!(text, "    - [{:e}, {:e}, {:e}]", row[0], row[1], row[2]);
    }
    text.push_str("  model: scale-misalignment\n");
    Ok(text)
}
