//! Calibration of a triaxial accelerometer on a single-axis shaker, by wedges and rotations.
//!
//! The device is glued on a wedge of inclination α, turned by ω about its own z, and shaken along the vertical
//! z′. Rows are observations: o = a S and a = o A, with a (n × 3) the acceleration the device sees, o (n × 3) its
//! outputs, S the sensitivity and A = S⁻¹ the exploitation matrix. `S[i][j]` is the output j per unit
//! acceleration along i.
//!
//! Three methods stand side by side:
//!
//! - [`published`]: ordinary least squares on magnitudes with element-wise uncertainties, as the method was
//!   published; for comparison only.
//! - [`complex`]: generalised least squares on signed phasors with the joint covariance of everything.
//! - [`joint`]: the same for all frequencies at once, with the mounting angles estimated as what they are:
//!   the same at every frequency.

mod adjustment;
mod applied;
pub mod budget;
pub mod campaign;
pub mod check;
pub mod check_standard;
pub mod copied_readings;
pub mod datasheet;
mod departing;
pub mod derived;
pub mod diagnosis;
mod excitation;
pub mod findings;
pub mod fit;
mod flat_top;
mod free_phase;
pub mod geometry;
mod hum;
pub mod interferometer;
pub mod matrix;
pub mod monte_carlo;
mod near_zero;
pub mod observation;
mod output_unit;
mod phase_units;
pub mod plan;
pub mod primary;
pub mod published;
pub mod recording;
mod reference_gap;
mod repeated_runs;
mod robust;
pub mod sample_clock;
pub mod screening;
pub mod single_axis;
pub mod spurious;
mod swapped_cables;
pub mod transverse;
mod unread_phases;

pub use applied::{AppliedAcceleration, AppliedPart, applied};
pub use budget::{Acts, Budget, Key, ShakerInput};
pub use campaign::{
    AngleResult, Contested, FrequencyResult, MethodResult, PublishedResult, RunResult,
    ShakerCalibration, ShakerCampaign, ShakerMethod, TermDifference, calibrate,
};
pub use check::{adopt, check};
pub use diagnosis::{SuspectRun, Suspicion, diagnose};
pub use fit::{
    AngleInformation, BetweenSessions, Fit, FrameTurn, FrequencyFit, GainDrift, Identifiability,
    OutputDelay, Reproducibility, SessionGain, VarianceComponent, complex, joint,
};
pub use geometry::Configuration;
pub use monte_carlo::{ComponentCheck, FrequencyCheck};
pub use observation::{
    Basis, CommonCauses, CommonMotion, Correction, OutputPhases, PhasorRow, Spurious,
    SpuriousTable, UnmeasuredAt, UnmeasuredMotion,
};
pub use output_unit::OutputUnit;
pub use reference_gap::reference_gap;
pub use screening::{Observations, observations, with_certificate};
pub use swapped_cables::swapped_cables;

/// Complex number of the interface.
pub use num_complex::Complex64;

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
