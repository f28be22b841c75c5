//! Stability and noise of sensors: the Allan family, noise identification, and coefficients that come with
//! intervals or not at all.

mod allan;
mod bias;
mod deviation;
mod edf;
mod hadamard;
mod noise_type;
mod record;
mod statistic;
mod taus;
mod theo;
mod total;

pub use bias::Bias;
pub use deviation::{DeviationCurve, DeviationOptions, DeviationPoint, deviation};
pub use edf::{EdfFormula, chi_square_interval, equivalent_dof};
pub use noise_type::{NoiseBasis, NoiseType};
pub use record::Record;
pub use statistic::Statistic;
pub use taus::Taus;
