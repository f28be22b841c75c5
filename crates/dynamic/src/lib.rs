//! Accelerometers over frequency and in time: frequency responses, fitted models, shocks, steps, the inverse filter.

pub mod blows;
pub mod deconvolution;
pub mod findings;
pub mod frequency_response;
pub mod input_noise;
mod limit;
pub mod linearity;
pub mod log_frequency;
pub mod measured;
pub mod model;
pub mod modes;
pub mod reference_table;
pub mod required_density;
pub mod shock;
pub mod sine_steps;
pub mod step;

mod monotone_cubic;

pub use frequency_response::FrequencyResponse;

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
