//! proofmass calibration.
