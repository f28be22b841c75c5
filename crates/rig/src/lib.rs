//! The simulated laboratory: recordings as a real bench makes them, with the truth beside them.
//!
//! ```
//! use proofmass_rig::HandHeld;
//!
//! let recording = HandHeld::default().simulate(1);
//! assert_eq!(recording.rests.len(), 24);
//! ```
//!
//! # Conventions
//! - Every simulation is a function of its settings and a seed: the same on every machine.
//! - Truth is in SI; outputs are in the unit of the simulated sensor.

mod axis;
pub mod bench;

mod hand_held;
mod interferometer;
mod transducer;
mod turned_axis;

pub use axis::{
    AxisAccelerometer, AxisEncoder, AxisMotion, AxisRecording, DrivenAxis, MotionPoint,
};
pub use hand_held::{HandHeld, HandHeldRecording, Rest};
pub use interferometer::{PrimaryBench, QuadratureInterferometer, device_response};
pub use transducer::{
    Beam, BridgeArms, PiezoCut, PiezoElement, Principle, ProofMass, SqueezeFilm, TipPlate,
    Transducer, TransducerBench, TransducerLimits, TransducerMotion, TransducerRecording,
    plate_capacitance,
};
pub use turned_axis::{TurnedAxis, TurnedAxisRecording};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
