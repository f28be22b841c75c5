//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod analysis;
mod beside_noise;
mod coefficients;
mod comparison;
mod courses;
mod data;
mod disturbance;
mod edf;
mod findings;
mod further_curves;
mod published;
mod simulated_sensor;
