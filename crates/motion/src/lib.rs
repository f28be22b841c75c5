//! Velocity from an encoder and an accelerometer: decoding, estimation, smoothing, tuning and comparison.
//!
//! The estimators themselves live in [`proofmass_core::velocity`] and run unchanged on a chip; this crate runs
//! them over records, finds their gains, and says what they are worth.
//!
//! ```
//! use proofmass_motion::{MotionRecord, ReadingSource, estimate};
//!
//! let dt = 0.001;
//! let t = |k: usize| dt * k as f64;
//! let encoder = (0..2000).map(|k| Some(((0.1 * (9.0 * t(k)).sin()) / 1e-4).round() * 1e-4)).collect();
//! let accelerometer = (0..2000).map(|k| -8.1 * (9.0 * t(k)).sin()).collect();
//! let record = MotionRecord::new(dt, ReadingSource::Position, encoder, accelerometer)?;
//! let result = estimate(&record, None, None, &proofmass_core::Unwatched)?;
//! let v = result.trace.velocity[1500];
//! assert!((v - 0.9 * (9.0 * t(1500)).cos()).abs() < 2e-3);
//! # Ok::<(), proofmass_core::Error>(())
//! ```
//!
//! # Conventions
//! - One length unit (or rad) for position, velocity and acceleration; seconds.
//! - Both sensors positive in the same sense. A record is on one uniform time base; [`align`] makes it.
//! - q is the variance of an acceleration sample unless the model says it is a density; R the variance of a reading.
//! - Standard uncertainties are those of the model: the whiteness test and the findings say whether to trust it.
//!
//! # Not covered
//! Motion in a plane (a robot's yaw enters through two wheels that the caller averages) and flexible couplings. The wheels of a
//! vehicle are compared with each other in `proofmass-odometry`.

mod comparison;
mod condition;
mod counting;
mod crossover;
mod decode;
mod diffuse;
mod drift;
mod edges;
mod encoder_aiding;
mod encoder_map;
pub mod episode;
mod excerpt;
mod filtering;
mod findings;
mod floor;
mod glitch;
mod held;
mod hole;
mod index_pulse;
mod integration;
mod integrator_design;
mod low_corner;
mod method;
mod method_word;
mod pairing;
mod record;
mod resolver;
mod rest;
mod ripple;
mod rollover;
mod samples;
mod search;
mod slip;
mod small_matrix;
mod smoother;
mod start_velocity;
mod steady_gain;
mod step_input;
mod stretch;
mod threshold;
mod timed;
mod tuning;
mod velocity;
mod whiteness;

pub use comparison::{Agreement, MethodRow, agreement, compare_methods};
pub use condition::{conditions, repetition};
pub use counting::CountingModel;
pub use crossover::{
    ChannelGain, Criterion, Crossover, Filter, SensorNoise, channels, crossover,
    crossover_by_smoother, kalman_by_smoother, noise_of, predicted_error, spectrum_error,
};
pub use decode::{
    AbsoluteCode, Decoded, TimedEdge, absolute, counter_words, levels, quadrature,
    quadrature_edges, teeth,
};
pub use diffuse::{ColouredNoise, Unknowns};
pub use drift::{DriftBudget, DriftSources};
pub use encoder_aiding::{AidedDrift, EncoderAiding};
pub use encoder_map::{EncoderMap, FoundMap, MapLine, MapSearch};
pub use episode::Episode;
pub use excerpt::excerpt;
pub use filtering::{KalmanModel, KalmanRun};
pub use findings::CATALOGUE;
pub use glitch::{drop_glitches, drop_wild_accelerations};
pub use held::{Held, held};
pub use hole::Hole;
pub use index_pulse::{IndexPassage, Indexed, indexed};
pub use integration::{HighPass, OffLineIntegration, integrate};
pub use integrator_design::{FittedHighPass, IntegratorDesign, IntegratorTask};
pub use low_corner::LowCorner;
pub use method::{Family, Method, VelocityTrace, WINDOWS};
pub use method_word::METHODS;
pub use pairing::Pairing;
pub use proofmass_core::velocity::{BiasModel, Hold, IntegratorRule, ProcessNoise};
pub use record::{
    Blow, HoledClock, MotionRecord, PassedAt, ReadingSource, Stamped, TimedEdges, Timing, align,
    common_start, even_clock, even_rows, interval, out_of_order, stamp_digit,
};
pub use resolver::{Demodulated, Excitation, ResolverAngles, demodulated, resolver};
pub use rest::moves_while_still;
pub use ripple::{Ripple, RippleLine, ripple};
pub use rollover::{continued, rollover, turns_anew};
pub use samples::{OnLines, Samples, even_step, mean_of};
pub use slip::{SlipReport, SlipSearch};
pub use steady_gain::steady_gain;
pub use stretch::{Ungapped, even_times, longest_stretch, mean_between, thin, ungapped};
pub use threshold::{leave_out_threshold, speed_increment};
pub use timed::{edge_counts, edge_places, time_edges};
pub use tuning::{BiasChoice, NoiseNode, ReadingNoise, Tuned, TunedValue, Tuning};
pub use velocity::{
    BesideReference, CompareResult, EstimateResult, LargestSpeed, TuneResult, TunedAtRate, compare,
    compare_turning, estimate, estimate_turning, published_sweep, single_sensor_methods, tune,
    tune_turning,
};
pub use whiteness::Whiteness;

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
