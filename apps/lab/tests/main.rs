//! The live bench on simulated benches.

mod bench;
mod doors;
mod kills;
mod text_device;
mod walk;
