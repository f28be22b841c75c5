//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod clock;
mod spectra;
mod strong_motion;
