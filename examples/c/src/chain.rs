//! A calibration in the frame of a machine, with a low-pass and a decimation behind it.

use proofmass_core::{Error, TaitBryan};
use proofmass_documents::{CalibrationFile, LowPassBehind};

/// What stands behind the calibration.
pub fn chain() -> LowPassBehind {
    LowPassBehind::butterworth(10.0, 1000.0, 5)
}

/// The linear calibration, turned by roll 0.1, pitch −0.5 and yaw 2 rad.
///
/// # Errors
/// None for these numbers.
pub fn chained() -> Result<CalibrationFile, Box<dyn std::error::Error>> {
    let turn = TaitBryan::new(0.1, -0.5, 2.0).map_err(|e: Error| e.to_string())?;
    Ok(crate::calibration(false, false)
        .map_err(|e| e.to_string())?
        .turned(&turn.matrix())?)
}
