//! What runs the same on the desk and on the chip: sensor models and their compensation, without `std` and
//! without allocation.
//!
//! ```
//! use proofmass_core::{Matrix3, SensorModel};
//!
//! // Coefficients as a calibration exports them; `f32` for a chip with a single-precision unit.
//! let k = Matrix3([[415.0, 1.2, 0.0], [0.0, 413.0, -0.8], [0.0, 0.0, 415.0]]);
//! let model = SensorModel::<f32>::new(k, [33123.0, 33276.0, 32360.0])?;
//! let a = model.apply([33123.0, 33276.0, 36434.0]);
//! assert!((a[2] - 9.817).abs() < 1e-3);
//! # Ok::<(), proofmass_core::Error>(())
//! ```
//!
//! # Conventions
//! - SI: accelerations in m/s², angles in radians, time in seconds. Degrees stand in the name of an argument.
//! - Specific force: a level sensor at rest with z up reads +g on z.
//! - Column vectors: ã = K a + b.
//!
//! # Features
//! `serde`: values of the models can be written and read. Off by default.
#![cfg_attr(not(test), no_std)]

mod bias_filter;
mod calibration_memory;
pub mod check;
mod compensation;
mod decimator;
pub mod encoder;
mod error;
mod fir_decimator;
mod fixed_point;
mod float;
mod gravity;
mod low_pass;
mod matrix3;
pub mod numeric;
mod octave_allan;
mod sensor_model;
pub mod state_space;
mod tait_bryan;
pub mod velocity;
mod visible;
mod watch;

pub use bias_filter::{BiasFilter, BiasState};
pub use calibration_memory::{
    CalibrationMemory, LARGEST_MEMORY, MEMORY_MAGIC, MEMORY_SERIAL, MemoryError, MemoryUnit,
    StoredCompensation,
};
pub use compensation::{
    AxisCompensation, Compensation, Curvature, LARGEST_NONLINEARITY, THERMAL_ORDER, ThermalTerms,
};
pub use decimator::{Decimator, DecimatorState};
pub use error::Error;
pub use fir_decimator::{FirDecimator, FirDecimatorState, weighted_sum};
pub use fixed_point::{FixedPoint, FixedRange, FixedThermal, TEMPERATURE_BITS};
pub use float::Float;
pub use gravity::{Gravity, STANDARD_GRAVITY};
pub use low_pass::{Butterworth, LowPassState, MovingAverage};
pub use matrix3::{Matrix3, dot, norm};
pub use octave_allan::{AllanSum, OctaveAllan, OctaveDeviation};
pub use sensor_model::SensorModel;
pub use tait_bryan::TaitBryan;
pub use visible::Visible;
pub use watch::{Unwatched, Watch};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
