//! Stability and noise of sensors: the Allan family, noise identification, and coefficients that come with
//! intervals or not at all.

mod allan;
mod bias;
mod coefficients;
mod deviation;
mod edf;
mod hadamard;
mod model;
mod noise_type;
mod record;
mod simulate;
mod spectrum_bins;
mod statistic;
mod taus;
mod theo;
mod total;
mod whittle;

pub use bias::Bias;
pub use coefficients::{Coefficient, CoefficientFit, FitOptions, Method, Reason, Verdict};
pub use deviation::{DeviationCurve, DeviationOptions, DeviationPoint, deviation};
pub use edf::{EdfFormula, chi_square_interval, equivalent_dof};
pub use model::{GaussMarkov, NoiseModel, Sinusoid, Term};
pub use noise_type::{NoiseBasis, NoiseType};
pub use record::Record;
pub use simulate::simulate;
pub use statistic::Statistic;
pub use taus::Taus;
pub use whittle::whittle;
