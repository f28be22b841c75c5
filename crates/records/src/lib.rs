//! Records of an accelerometer laboratory: devices, standards and results over time, forward and backward.
//!
//! A record is a filed outcome: the result as its folder has it, what it was computed from, and the standards behind it. Nothing is
//! changed: an entry follows the other, each with the digest of the one before; a result that was wrong is superseded. What is found fast
//! is made from the entries and can be made again, which is how [`Records::check`] knows that it is right.
//!
//! Records stand in a file (SQLite) or, with the feature `postgres`, in PostgreSQL; statements and tests are the same.

mod candidate;
mod certificate;
mod check;
mod contribution;
mod day;
mod device;
mod digital;
mod doubts;
mod due;
mod engine;
mod entry;
mod export;
mod files;
mod filing;
mod history;
mod index;
mod ledger;
pub mod page;
#[cfg(feature = "postgres")]
mod postgresql;
mod recall;
mod rests;
mod schema;
mod sound;
mod spreadsheet;
mod sqlite;
mod tolerance;
mod used;

pub use candidate::Candidate;
pub use check::{Check, Difference, Recomputed, check_measurement};
pub use day::{date_of, day_of};
pub use device::DeviceRow;
pub use digital::read_digital;
pub use due::Due;
pub use entry::{
    Content, Entry, EventKind, FiledCampaign, FiledCertificate, FiledCheck, FiledDevice,
    FiledEvent, FiledFile, FiledQuantity, FiledResult, FiledRule, FiledSupersession, FiledUse,
    Tolerance, UsedStandard,
};
pub use filing::{Filed, Filing};
pub use history::{History, Point, Series};
pub use ledger::Records;
pub use recall::{Recall, Recalled, RecalledEffect};
pub use rests::Rest;
pub use spreadsheet::read_spreadsheet;

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
