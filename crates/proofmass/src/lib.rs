//! The open accelerometer laboratory under one roof: every crate of the project, re-exported, without logic.
//!
//! # Which question, which door
//!
//! | question | door |
//! |---|---|
//! | What are bias, scale and misalignment of my triaxial sensor? | [`jobs::multi_position`], or [`statics::MultiPosition`] on means of your own |
//! | What is its sensitivity matrix at each frequency on the shaker? | [`jobs::campaign`], [`shaker`] |
//! | How do I compensate, on the desk and on the chip? | [`core::SensorModel`], a file by [`io::CalibrationFile`] |
//! | How noisy is it, and what goes into my filter? | [`noise::analyse`] |
//! | How fast does my axis move? | [`core::velocity`] sample by sample, [`motion`] with the whole record at hand |
//! | Which wheel of my vehicle slips? | [`odometry`] |
//! | How uncertain is a result of my own equations? | [`uncertainty::propagate`], [`uncertainty::MonteCarlo`] |
//! | What do the samples of a sine, a spectrum say? | [`signal`] |
//! | What would my plan achieve? Does my code recover a known truth? | [`rig`] |
//! | How do I read this recording, write that result? | [`io::Recording`], [`jobs::Filed`] |
//! | How do I run a job from a server, a notebook, a batch? | [`jobs::Job`], [`jobs::Outcome`], [`jobs::Memory`] |
//!
//! The words of the field and those of this project stand side by side in [`glossary`].
//!
//! # From samples to a calibration
//!
//! ```
//! use proofmass::statics::{MultiPosition, Samples, Standstill, StandstillCalibration};
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
//!
//! # Features
//! Each room is a feature, `full` (the default) is all of them; [`core`](mod@core) is always there. With
//! `default-features = false` nothing but the crate for firmware is built.

pub use proofmass_core as core;
#[cfg(feature = "dynamic")]
pub use proofmass_dynamic as dynamic;
#[cfg(feature = "fixture")]
pub use proofmass_fixture as fixture;
#[cfg(feature = "io")]
pub use proofmass_io as io;
#[cfg(feature = "jobs")]
pub use proofmass_jobs as jobs;
#[cfg(feature = "motion")]
pub use proofmass_motion as motion;
#[cfg(feature = "noise")]
pub use proofmass_noise as noise;
#[cfg(feature = "odometry")]
pub use proofmass_odometry as odometry;
#[cfg(feature = "report")]
pub use proofmass_report as report;
#[cfg(feature = "rig")]
pub use proofmass_rig as rig;
#[cfg(feature = "shaker")]
pub use proofmass_shaker as shaker;
#[cfg(feature = "signal")]
pub use proofmass_signal as signal;
#[cfg(feature = "static")]
pub use proofmass_static as statics;
#[cfg(feature = "uncertainty")]
pub use proofmass_uncertainty as uncertainty;

#[doc = include_str!("../GLOSSARY.md")]
pub mod glossary {}

#[doc = include_str!("../REFERENCES.md")]
pub mod references {}
