//! proofmass rig.

pub mod bench;
