//! Spectra, transforms and the analysis of recorded signals.
//!
//! # Conventions
//!
//! Densities are **one-sided**, in U²/Hz for a signal in U, from 0 to half the sample rate: their sum times the bin
//! width is the mean square. Amplitude densities are their square roots, U/√Hz. Windows are periodic. A trend is
//! removed only when it is named ([`Detrend`]).

mod any_compensation;
pub mod clock;
mod density;
mod detrend;
pub mod fourier;
mod linear_phase;
mod multitaper;
mod oscillator;
mod power_sum;
mod pulse_shape;
pub mod saturation;
mod shock_spectrum;
pub mod sine;
mod strong_motion;
mod trace;
pub mod transfer;
mod vibration;
mod welch;
mod window;

pub use any_compensation::AnyCompensation;
pub use density::Density;
pub use detrend::{Detrend, Trend};
pub use linear_phase::LinearPhase;
pub use multitaper::{Multitaper, Tapers, slepian};
pub use oscillator::relative_displacement;
pub use pulse_shape::PulseShape;
pub use shock_spectrum::{Extremes, Peaks, Response, ResponseSpectrum, ShockSpectrum, octaves};
pub use strong_motion::{Baseline, Motion, StrongMotion};
pub use trace::Trace;
pub use vibration::Vibration;
pub use welch::Welch;
pub use window::{Window, equivalent_noise_bandwidth};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
