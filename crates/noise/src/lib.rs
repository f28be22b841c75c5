//! Stability and noise of sensors at rest: the Allan family, noise identification, and coefficients that come with
//! intervals or not at all.
//!
//! [`analyse`] does everything for the channels of a recording. The parts stand on their own: [`deviation`] for a
//! curve of any [`Statistic`], [`LongRecord`] for recordings larger than memory, [`whittle()`] for coefficients,
//! [`disturbances`] for what is not noise, [`proofmass_signal::clock`] for time stamps, [`simulate()`] for records with known coefficients.
//!
//! ```
//! use proofmass_noise::{FitOptions, NoiseModel, Term, Verdict, simulate, whittle};
//! use rand::SeedableRng;
//!
//! let truth = NoiseModel { white: 2.5e-3, random_walk: 5.0e-4, ..Default::default() };
//! let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
//! let rate = simulate(&truth, 50_000, 50.0, &mut rng).unwrap();
//! let fit = whittle(&rate, 50.0, &FitOptions::default()).unwrap();
//! let (low, high) = fit.get(Term::White).unwrap().verdict.interval().unwrap();
//! assert!(low < 2.5e-3 && 2.5e-3 < high);
//! let (low, high) = fit.get(Term::RandomWalk).unwrap().verdict.interval().unwrap();
//! assert!(low < 5.0e-4 && 5.0e-4 < high);
//! // There is no flicker in this record, and none is reported.
//! assert!(matches!(fit.get(Term::Flicker).unwrap().verdict, Verdict::NotIdentifiable { .. }));
//! ```
//!
//! # Conventions
//!
//! - A *rate* is what the sensor gives (acceleration, angular rate), a *phase* its integral. SI inside.
//! - N, the coefficient of white noise, is the Allan deviation at 1 s: a **two-sided** root density. Densities of
//!   [`proofmass_signal`] are **one-sided**; the amplitude density of a data sheet is √2 N. [`in_units`] gives both, named.
//! - B is the coefficient; the floor of the Allan deviation is √(2 ln 2/π) B = 0.664 B.
//! - Every term is in the fit and none is selected; an interval comes from the likelihood at its best over all other terms.
//!   Where it reaches zero the verdict is `NotIdentifiable`, and its upper end is the limit. "Identified" says that chance
//!   brings such a gain in one record of 500.
//! - Bias corrections ([`Bias`]) and formulas for degrees of freedom ([`EdfFormula`]) are named where programs differ.
//! - Gaps are never bridged. Random sources are arguments; results do not depend on the number of threads.
//!
//! # Not covered
//!
//! - Courses beside noise but one exponential from the start, steps, and the cycle of a day; a lag of higher order, or a thermometer that lags
//!   behind the sensor.
//! - Gauss–Markov processes and sinusoids are sought only when named in [`FitOptions::terms`]; sinusoids of fewer than one and a
//!   half cycles are not found.
//! - Degrees of freedom of MTOTDEV and HTOTDEV for flicker phase noise beyond what `[SP1065]` publishes.
//! - Cross-spectra and correlation between channels.

mod allan;
mod allan_covariance;
mod analysis;
mod averaged_record;
mod averages;
mod bias;
mod channel_analysis;
mod choice_words;
mod coefficients;
mod comparison;
mod consistency;
mod converter;
mod cosine_spectrum;
mod course;
mod course_search;
mod curve_findings;
mod curve_model;
mod curve_reading;
mod deviation;
mod disturbance;
mod disturbance_findings;
mod dynamic;
mod edf;
mod effects;
mod expected;
pub mod findings;
mod fit_family;
mod fit_findings;
mod fit_record;
mod fit_verdicts;
mod front_end;
mod gaps;
mod hadamard;
mod known_forms;
mod limit;
mod lines;
mod long_record;
mod markov;
mod model;
mod noise_type;
mod over_temperature;
mod overlapping;
mod parabolic;
mod phase;
mod profile;
mod quick_fit;
mod record;
mod robust;
mod separation;
mod simulate;
mod slow_misfit;
mod slow_sinusoid;
mod spectrum_bins;
mod state_space;
mod statistic;
mod steps;
mod streaming;
mod taus;
mod temperature_effect;
mod temperature_lag;
mod term_density;
mod theo;
mod three_sensors;
mod total;
mod unit_comparison;
mod units;
mod usable_band;
mod variance_fit;
mod whittle;

pub use analysis::{
    Analysis, AnalysisOptions, ChannelAnalysis, NoiseChannel, SpectrumPoint, TermUnits, analyse,
    analyse_beside_temperature, analyse_watched,
};
pub use bias::Bias;
pub use coefficients::{
    BandUse, Coefficient, CoefficientFit, FitOptions, Reason, TermParameter, Verdict,
};
pub use comparison::{CheckedLimit, ComparedChannel, ComparedTerm, UnitComparison, compare_units};
pub use consistency::{ConsistencyPoint, FittedPoint, consistency};
pub use converter::{ConverterTrace, converter_traces};
pub use course::{Course, CourseShape};
pub use curve_reading::{CurveReading, curve_readings};
pub use deviation::{
    DeviationCurve, DeviationOptions, DeviationPoint, allan_deviation, deviation,
    deviation_stretches, deviation_watched,
};
pub use disturbance::{
    Disturbance, DisturbanceKind, JointInfluence, disturbances, joint_influence,
};
pub use dynamic::{DynamicWindow, dynamic_deviation};
pub use edf::{EdfFormula, chi_square_interval, equivalent_dof};
pub use expected::{AskedOfRecord, ExpectedInterval, expected_interval, samples_for_limit};
pub use findings::CATALOGUE;
pub use fit_record::FitRecord;
pub use front_end::{FrontEnd, LowPass};
pub use gaps::{GapKind, Gaps, RecordGap, Stretches, stretches};
pub use limit::{ChannelCheck, Conformity, LimitCheck, NoiseLimit, against_limit};
pub use long_record::{ChannelName, LongRecord};
pub use model::{GaussMarkov, NoiseModel, Sinusoid, Term};
pub use noise_type::{NoiseBasis, NoiseType};
pub use over_temperature::{TermSlope, slope_over_temperature};
pub use record::NoiseRecord;
pub use robust::{RobustFit, robust_fit};
pub use separation::{SeparatedPoint, separated_deviations};
pub use simulate::{SimulatedSensor, simulate, simulated_stamps};
pub use slow_misfit::SlowMisfit;
pub use state_space::{BiasComponent, StateSpace, state_space};
pub use statistic::Statistic;
pub use streaming::StreamingAllan;
pub use taus::Taus;
pub use temperature_effect::TemperatureSensitivity;
pub use three_sensors::{groslambert_covariance, three_cornered_hat};
pub use unit_comparison::{TermComparison, equal_coefficients};
pub use units::{Conservative, InUnit, KalmanNoise, Sensor, conservative, in_units, kalman_noise};
pub use whittle::{whittle, whittle_record, whittle_stretches};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
