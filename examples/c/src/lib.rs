//! A calibration for a C program, and the proof that the exported header computes what the desk computes.
//!
//! ```text
//! proofmass export calibration.json --c --name accelerometer -o accelerometer.h
//! cc -std=c99 accelerometer.c -o accelerometer
//! ```

mod chain;
mod filters;

pub use chain::{chain, chained};
pub use filters::{filters, raised_cosine};

use proofmass_documents::{CalibrationFile, CurvatureBlock, ThermalBlock};
use proofmass_io::Unit;
use proofmass_uncertainty::Estimate;

/// A 16-bit sensor with everything a calibration can hold, as far as asked for.
///
/// # Errors
/// None for these numbers; an estimate of nothing is one.
pub fn calibration(
    thermal: bool,
    curvature: bool,
) -> Result<CalibrationFile, proofmass_core::Error> {
    let k = [[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [-0.5, 0.25, 414.0]];
    let estimate = Estimate::new(Vec::new(), Vec::new())?;
    let bias = [33_120.0, 33_271.0, 32_366.0];
    let mut file = CalibrationFile::new("full", Unit::Count, k, bias, estimate);
    file.device.model = Some("example".into());
    if thermal {
        file.temperature = Some(ThermalBlock {
            reference: 23.5,
            bias: vec![
                [0.41, -1.1e-3, 2e-6],
                [-0.22, 3e-4, 0.0],
                [0.13, 0.0, -1e-6],
            ],
            scale: vec![[2e-4, 1e-7, 0.0], [-1e-4, 0.0, 1e-9], [3e-4, -2e-7, 0.0]],
            range: [-40.0, 85.0],
            hysteresis: None,
        });
    }
    if curvature {
        file.curvature = Some(CurvatureBlock {
            quadratic: vec![5e-5, -3e-5, 2e-5],
            cubic: vec![1e-6, 0.0, -2e-7],
            reach: 78.0,
        });
    }
    Ok(file)
}
