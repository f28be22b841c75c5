//! Calibration certificates: those of others read, our own drafted, checked and released.

pub mod reading;
