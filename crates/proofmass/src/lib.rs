//! The open accelerometer laboratory under one roof: every crate of the project, re-exported, without logic.
//!
//! ```
//! use proofmass::calibration::{MultiPosition, Samples, Standstill, StandstillCalibration};
//! use proofmass::core::Gravity;
//! use proofmass::rig::HandHeld;
//!
//! let recording = HandHeld::default().simulate(1);
//! let [x, y, z] = &recording.outputs;
//! let gravity = Gravity::given(9.80665, 1e-5)?;
//! let calibration = StandstillCalibration::run(
//!     &Samples::new(x, y, z)?,
//!     recording.rate,
//!     &[],
//!     &Standstill::default(),
//!     &MultiPosition::new(gravity),
//! )?;
//! let scale = calibration.fit.estimate().get("scale.x").unwrap();
//! assert!((scale.value - 415.2).abs() < 4.0 * scale.standard_uncertainty);
//! # Ok::<(), proofmass::core::Error>(())
//! ```

pub use proofmass_calibration as calibration;
pub use proofmass_core as core;
pub use proofmass_fixture as fixture;
pub use proofmass_io as io;
pub use proofmass_jobs as jobs;
pub use proofmass_motion as motion;
pub use proofmass_noise as noise;
pub use proofmass_report as report;
pub use proofmass_rig as rig;
pub use proofmass_signal as signal;
pub use proofmass_uncertainty as uncertainty;
