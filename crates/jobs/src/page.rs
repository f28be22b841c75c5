//! What pages of several jobs share.

pub(crate) mod answer;
pub(crate) mod columns;
pub(crate) mod coverage;
pub(crate) mod measures;
pub(crate) mod parameters;
pub(crate) mod polar;
pub(crate) mod shares;
pub(crate) mod stability;
pub(crate) mod words;

use proofmass_core::STANDARD_GRAVITY;

/// Axes of a triaxial sensor.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
/// Thousandths of standard gravity in a m/s².
pub(crate) const MG: f64 = 1e3 / STANDARD_GRAVITY;
