//! Static calibration of accelerometers: from standstills to parameters with one joint covariance.

pub mod static_test;

mod added_terms;
mod autocalibration;
mod bias_tracking;
mod direction_coverage;
mod ellipsoid;
mod findings;
mod hold;
mod mean_noise;
mod multi_position;
mod pose;
mod recording_quality;
mod six_position;
mod standstill;
mod standstill_calibration;
mod temperature;
mod threshold_sweep;
mod tumble;
mod validation;

pub use autocalibration::{
    AutoCalibration, AutoCalibrationFit, AutoCalibrationQuantities, StillWindow, StillWindows,
    Stop, WindowRule,
};
pub use bias_tracking::{
    AxisTrack, BiasEstimate, BiasNoise, BiasObservations, BiasTrack, BiasTracking, Consistency,
    DeviatingRest, RestMean,
};
pub use direction_coverage::{Direction, DirectionCoverage};
pub use ellipsoid::Ellipsoid;
pub use findings::CATALOGUE;
pub use mean_noise::MeanNoise;
pub use multi_position::{
    AttitudeUncertainty, BeyondMatrix, CompensatedReading, FormWeight, Limiting, Misfit,
    MisfitCause, Model, ModelEvidence, MultiPosition, MultiPositionFit, NextAttitude, PoseResidual,
    ScatterForm, ScatterParts, Suspect, Terms, WithoutSuspects,
};
pub use pose::{ForceUncertainty, Pose, Samples, Segment};
pub use recording_quality::{clipping, frozen, temperature_drift};
pub use six_position::Ferraris;
pub use standstill::{Standstill, WindowedVariance};
pub use standstill_calibration::{StandstillCalibration, StandstillEstimator, calibrate};
pub use temperature::{
    Attitude as SweepAttitude, AxisFit, Blocks, EnvironmentalCourse, EnvironmentalQuantity,
    Hysteresis, OrderFit, OutputStep, SelfHeating, SweepData, TemperatureFit, TemperatureSweep,
};
pub use threshold_sweep::{Candidate, ThresholdSweep};
pub use validation::{AttitudeCheck, Calibrated, NominalOutput, Validation};

/// Three components in the order x, y, z.
pub type Triple = [f64; 3];

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
