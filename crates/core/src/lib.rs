//! What runs the same on the desk and on the chip: sensor models and their compensation.
#![cfg_attr(not(test), no_std)]

mod error;

pub use error::Error;
