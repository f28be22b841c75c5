//! Odometry of a vehicle with several wheels: where one of them slips, and whose channel is dead.
//!
//! The velocity of one axis is in [`proofmass_motion`]; there an accelerometer tells the slip of a single wheel. Here the wheels
//! are compared with each other ([`Wheels`]) and with a gyroscope ([`Axle`]).
//!
//! # Conventions
//! - Readings of all wheels in one unit, m or m/s, at equal steps of time; positive where the vehicle goes ahead.
//! - A missing reading is `None`.

mod dead_wheels;
mod findings;
mod rigid_vehicle;
mod several_wheels;
mod wheel_slip;

pub use dead_wheels::dead_wheels;
pub use findings::CATALOGUE;
pub use several_wheels::{Departure, Departures, Wheels};
pub use wheel_slip::{Axle, WheelSlip};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
