//! The live bench on simulated benches.

mod bench;
mod walk;
