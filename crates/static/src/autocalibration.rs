//! Calibration from the still moments of days of free living: scale, offset and temperature from ‖a‖ = 1.

mod fit;
mod windows;

pub use fit::{AutoCalibration, AutoCalibrationFit, AutoCalibrationQuantities, Stop};
pub use windows::{StillWindow, StillWindows, WindowRule};
