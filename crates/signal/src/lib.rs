//! proofmass signal.

pub mod sine;
