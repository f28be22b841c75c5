//! A recording written anew in another format: what a target can hold, what a recording holds, and the rows on their way.
//!
//! A [`Survey`] goes over the recordings once and tells their clock, their gaps and what the target could not hold. Then [`Conversion`]
//! takes the same rows again and writes them; memory is that of a block.

mod survey;
mod target;
mod timed_rows;
mod writer;

pub use survey::{Survey, Surveyed};
pub use target::TargetForm;
pub use timed_rows::{RowClock, TimedLayout, TimedRows};
pub use writer::{Conversion, ConversionPlan, Filling};

#[cfg(test)]
mod tests;
