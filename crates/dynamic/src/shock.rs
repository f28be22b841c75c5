//! Shock calibration: the pulse, its measures, and the sensitivity against a reference.

mod after_pulse;
mod doubts;
mod pair_doubts;
mod pulse;
mod quiet;
mod sensitivity;
mod spectrum;
mod spectrum_tolerance;
mod standard;
#[cfg(test)]
mod tests;

pub use after_pulse::ReturnToBaseline;
pub use doubts::{PulseContext, pulse_findings};
pub(crate) use pulse::{Functional, LEVEL};
pub use pulse::{NoPulse, Pulse, PulseMeasures, PulseSearch, Tolerance, ToleranceResult};
pub use sensitivity::{NoCalibration, ShockCalibration, ShockReference, SpectrumLine};
pub use spectrum::{PulseSpectra, SpectrumDoubt, SpectrumRequest};
pub use spectrum_tolerance::{SpectrumTolerance, SpectrumToleranceResult, required_at};
pub use standard::FlatStandard;
