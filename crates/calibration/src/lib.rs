//! proofmass calibration.

pub mod shaker;
