//! Stability and noise of sensors: the Allan family, noise identification, and coefficients that come with
//! intervals or not at all.

mod allan;
mod allan_regression;
mod analysis;
mod bias;
mod coefficients;
mod consistency;
mod deviation;
mod disturbance;
mod edf;
mod gaps;
mod hadamard;
mod model;
mod noise_type;
mod record;
mod simulate;
mod spectrum_bins;
mod statistic;
mod streaming;
mod taus;
mod theo;
mod total;
mod units;
mod whittle;

pub use allan_regression::{allan_regression, fit_curve};
pub use analysis::{
    Analysis, AnalysisOptions, Channel, ChannelAnalysis, SpectrumPoint, TermUnits, analyse,
};
pub use bias::Bias;
pub use coefficients::{Coefficient, CoefficientFit, FitOptions, Method, Reason, Verdict};
pub use consistency::{ConsistencyPoint, consistency};
pub use deviation::{DeviationCurve, DeviationOptions, DeviationPoint, deviation};
pub use disturbance::{Disturbance, DisturbanceKind, disturbances};
pub use edf::{EdfFormula, chi_square_interval, equivalent_dof};
pub use gaps::{Gap, GapKind, Gaps, stretches};
pub use model::{GaussMarkov, NoiseModel, Sinusoid, Term};
pub use noise_type::{NoiseBasis, NoiseType};
pub use record::Record;
pub use simulate::simulate;
pub use statistic::Statistic;
pub use streaming::StreamingAllan;
pub use taus::Taus;
pub use units::{ImuPart, InUnit, KalmanNoise, Sensor, imu_yaml, in_units, kalman_noise};
pub use whittle::whittle;
