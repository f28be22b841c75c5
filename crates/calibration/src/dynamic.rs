//! Dynamic tests: shocks and frequency responses of accelerometers.

pub mod deconvolution;
pub mod linearity;
pub mod model;
pub mod modes;
pub mod shock;
pub mod sine_steps;
pub mod step;
