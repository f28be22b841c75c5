//! The live bench: shaker runs measured, watched and recorded while they are made.
//!
//! Two threads do the work. The acquisition owns the device and its drive; it ends a run by itself when a limit is
//! passed, a sample is wrong, somebody stops, or nobody gives a sign of life. The walk follows the plan of an ordinary
//! campaign folder and writes the recordings. The page, a third one, shows and asks; nothing depends on it.

pub mod acquisition;
pub mod clock;
pub mod device;
pub mod doors;
pub mod ending;
pub mod evaluation;
pub mod files;
pub mod guard;
pub mod level;
pub mod limits;
pub mod page;
pub mod plan;
pub mod practice;
pub mod recorder;
pub mod server;
pub mod session;
pub mod simulated;
pub mod status;
pub mod text_device;
pub mod tone;
pub mod view;
pub mod walk;
