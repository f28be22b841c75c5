//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod calibration_blocks;
mod calibration_files;
mod certificates;
mod foreign_coefficients;
mod model_files;
