//! One model of a transducer and its chain, fitted to a frequency response.

mod figures;
mod fit;
pub(crate) mod parameters;
mod response;
#[cfg(test)]
mod tests;

pub use figures::{Bandwidth, DampingReading, ResponseFigures};
pub use fit::{CommonCause, FitProblem, ModelFit, ResponsePoints};
pub use response::{Mode, ModelStructure, TransducerModel};
