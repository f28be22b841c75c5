//! The open accelerometer laboratory under one roof: every crate of the project, re-exported, without logic.
//!
//! # Which question, which door
//!
//! | question | door |
//! |---|---|
//! | What are bias, scale and misalignment of my triaxial sensor? | [`jobs::multi_position`], or [`statics::MultiPosition`] on means of your own |
//! | What is its sensitivity matrix at each frequency on the shaker? | [`jobs::campaign`], [`shaker`] |
//! | How do I compensate, on the desk and on the chip? | [`core::SensorModel`], a file by [`documents::CalibrationFile`] |
//! | How noisy is it, and what goes into my filter? | [`noise::analyse`] |
//! | How fast does my axis move? | [`core::velocity`] sample by sample, [`motion`] with the whole record at hand |
//! | Which wheel of my vehicle slips? | [`odometry`] |
//! | How uncertain is a result of my own equations? | [`uncertainty::propagate`], [`uncertainty::MonteCarlo`] |
//! | What do the samples of a sine, a spectrum say? | [`signal`] |
//! | What would my plan achieve? Does my code recover a known truth? | [`rig`] |
//! | How do I read this recording, write that result? | [`io::Recording`], [`jobs::StoredResult`] |
//! | How do I run a job from a server, a notebook, a batch? | [`jobs::Job`], [`jobs::Outcome`], [`jobs::Memory`] |
//!
//! The words of the field and those of this project stand side by side in [`glossary`].
//!
//! # Five questions in a few lines
//!
//! Calibrate a triaxial accelerometer from arrays:
//!
//! ```
//! use proofmass::core::Gravity;
//!
//! let recording = proofmass::rig::HandHeld::default().simulate(1);
//! let [x, y, z] = &recording.outputs;
//! let fit = proofmass::statics::calibrate([x, y, z], recording.rate, Gravity::given(9.80665, 1e-5)?)?;
//! let scale = fit.quantity("scale.x").unwrap();
//! assert!((scale.value - 415.2).abs() < 4.0 * scale.standard_uncertainty);
//! # Ok::<(), proofmass::core::Error>(())
//! ```
//!
//! The Allan deviation of a slice, with its intervals:
//!
//! ```
//! let gyro: Vec<f64> = (0..4096).map(|k| f64::from(k * 7919 % 4093) / 4093.0 - 0.5).collect();
//! let curve = proofmass::noise::allan_deviation(&gyro, 100.0)?;
//! assert!(curve.points.iter().all(|p| p.deviation > 0.0));
//! # Ok::<(), proofmass::core::Error>(())
//! ```
//!
//! A sine fit with three parameters, or with four:
//!
//! ```
//! use proofmass::signal::sine::{four_parameter_fit, three_parameter_fit};
//!
//! let x: Vec<f64> = (0..500).map(|n| 2.0 * (0.7 * f64::from(n) + 0.5).cos()).collect();
//! let (frequency, sine) = four_parameter_fit(&x, 1000.0)?;
//! assert!((sine.modulus() - 2.0).abs() < 1e-9);
//! assert!((three_parameter_fit(&x, 1000.0, frequency)?.phase() - 0.5).abs() < 1e-9);
//! # Ok::<(), proofmass::core::Error>(())
//! ```
//!
//! Numbers that carry their uncertainty:
//!
//! ```
//! use proofmass::uncertainty::Uncertain;
//!
//! let r = Uncertain::new("V", 5.0, 0.01)? / Uncertain::new("I", 0.02, 0.0001)?;
//! assert_eq!(r.in_unit("Ω").to_string(), "250.0(1.3) Ω");
//! # Ok::<(), proofmass::core::Error>(())
//! ```
//!
//! Velocity on a chip, from counts and an accelerometer, sample by sample without allocation:
//!
//! ```
//! use proofmass::core::velocity::{Counter, CounterState, Estimator, Hold, Kalman, MotionNoise, ProcessNoise};
//!
//! const COUNT: f64 = 1e-5; // metres
//! let noise = MotionNoise { acceleration: 0.01, form: ProcessNoise::SampleConstant, position: 1e-11 };
//! let filter = Kalman::<f32, 2>::new(&noise, Hold::First, 1e-3)?;
//! let counter = Counter::<f32>::new(COUNT, 16)?;
//! let (mut words, mut state) = (CounterState::new(0), filter.start(0.0));
//! let mut velocity = 0.0;
//! for k in 0..3000_u32 {
//!     velocity = filter.estimate(&mut state, &counter.sample(&mut words, 20 * k, 0.0));
//! }
//! assert!((velocity - 0.2).abs() < 1e-3); // 20 counts of 10 µm in each millisecond
//! # Ok::<(), proofmass::core::Error>(())
//! ```
//!
//! # Features
//! Each room is a feature, `full` (the default) is all of them; [`core`](mod@core) is always there. With
//! `default-features = false` nothing but the crate for firmware is built. `parquet` reads Parquet files as recordings; it is not a default.

pub use proofmass_core as core;
#[cfg(feature = "documents")]
pub use proofmass_documents as documents;
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
#[cfg(feature = "records")]
pub use proofmass_records as records;
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

/// The example of the README, so that it stays true.
#[cfg(all(doctest, feature = "full"))]
#[doc = include_str!("../README.md")]
struct Readme;
