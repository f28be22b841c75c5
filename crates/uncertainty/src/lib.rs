//! Measurement uncertainty after the GUM and its supplements, with correlation kept.
//!
//! A result is not a number but an [`Estimate`]: named components, one joint covariance, and the independent causes
//! it is made of. From inputs to a result there are two roads, and this crate takes both and compares them: the law
//! of propagation ([`propagate`], derivatives by [`Dual`] numbers) and the propagation of distributions
//! ([`MonteCarlo`]). Correlation enters in one way only: an [`Input`] says which keys it *varies with*
//! ([`Inputs::joint`]).
//!
//! # GUM H.1: an end gauge
//!
//! A model is written once, over any [`Number`].
//!
//! ```
//! use proofmass_uncertainty::*;
//!
//! struct EndGauge; // lengths in nm
//! impl Model for EndGauge {
//!     fn outputs(&self) -> Vec<(String, String)> { vec![("l".into(), "nm".into())] }
//!     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
//!         let [l_s, d, alpha, theta, d_alpha, d_theta] = [x[0], x[1], x[2], x[3], x[4], x[5]];
//!         y[0] = l_s + d - l_s * (d_alpha * theta + alpha * d_theta);
//!     }
//! }
//! let nu = |n| DegreesOfFreedom::new(n).unwrap();
//! let t = |location, scale, dof| Distribution::StudentT { location, scale, dof };
//! let flat = |lower: f64, upper: f64| Distribution::Rectangular { lower, upper };
//! let joint = Inputs::new()
//!     .add(Input::new("l_s", "nm", t(50_000_623.0, 25.0, 18.0)))
//!     .add(Input::new("d", "nm", t(215.0, 9.7, 25.6)))
//!     .add(Input::new("alpha", "1/°C", flat(9.5e-6, 13.5e-6)))
//!     .add(Input::new("theta", "°C", Distribution::Normal { mean: -0.1, u: 0.41 }))
//!     .add(Input::new("d_alpha", "1/°C", flat(-1e-6, 1e-6)).dof(nu(50.0)))
//!     .add(Input::new("d_theta", "°C", flat(-0.05, 0.05)).dof(nu(2.0)))
//!     .single()?;
//!
//! let linear = propagate(&EndGauge, &joint)?;
//! let l = linear.get("l").unwrap();
//! assert_eq!(l.to_string(), "50000838(32) nm");
//! assert!((l.dof.get() - 16.7).abs() < 0.15);
//! assert_eq!(l.display(&Format::expanded(0.99)).to_string(), "50000838 ± 92 nm (k = 2.90, 99 %)");
//! let first = &linear.budget("l").unwrap()[0];
//! assert_eq!((first.key.as_str(), first.contribution), ("l_s", 25.0));
//! # Ok::<(), Refusal>(())
//! ```
//!
//! The GUM truncates ν to 16 and finds U = 93 nm; ν is kept here as it comes.
//!
//! # GUM H.2: readings made together
//!
//! ```
//! use proofmass_uncertainty::*;
//!
//! struct Impedance;
//! impl Model for Impedance {
//!     fn outputs(&self) -> Vec<(String, String)> { vec![("R".into(), "Ω".into()), ("X".into(), "Ω".into())] }
//!     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
//!         let z = Complex::from_polar(x[0] / x[1], x[2]);
//!         (y[0], y[1]) = (z.re, z.im);
//!     }
//! }
//! let joint = Inputs::new()
//!     .observed(&[
//!         ("V", "V", &[5.007, 4.994, 5.005, 4.990, 4.999]),
//!         ("I", "A", &[19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3]),
//!         ("phi", "rad", &[1.0456, 1.0438, 1.0468, 1.0428, 1.0433]),
//!     ])?
//!     .single()?;
//! let z = propagate(&Impedance, &joint)?;
//! assert_eq!(z.get("R").unwrap().to_string(), "127.732(71) Ω");
//! assert_eq!(z.get("X").unwrap().to_string(), "219.85(30) Ω");
//! assert!((z.estimate().covariance().correlation(0, 1).unwrap() + 0.588).abs() < 5e-4);
//! # Ok::<(), Refusal>(())
//! ```
//!
//! # GUM H.3: a straight line
//!
//! A fit is an equation to be solved; its covariance from every input is one call.
//!
//! ```
//! use proofmass_uncertainty::*;
//!
//! const T: [f64; 11] = [21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511];
//! const B: [f64; 11] = [-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160];
//! struct Thermometer;
//! impl LeastSquares for Thermometer {
//!     fn outputs(&self) -> Vec<(String, String)> { vec![("y1".into(), "°C".into()), ("y2".into(), "1".into())] }
//!     fn residuals(&self) -> usize { 11 }
//!     fn residual<N: Number>(&self, y: &[N], x: &[N], r: &mut [N]) {
//!         for i in 0..11 {
//!             r[i] = N::from(B[i]) + x[i] - y[0] - y[1] * N::from(T[i] - 20.0);
//!         }
//!     }
//! }
//! // The scatter of one reading, s = 0.0035 °C with 9 degrees of freedom, is drawn anew for each.
//! let readings: Vec<Labels> = (0..11).map(|i| Labels::new().with("reading", i)).collect();
//! let scatter = Distribution::StudentT { location: 0.0, scale: 0.0035, dof: 9.0 };
//! let joint = Inputs::new().add(Input::new("scatter", "°C", scatter).varies_with(["reading"])).joint(&readings)?;
//! let fit = propagate_least_squares(&Thermometer, &[0.0, 0.0], &joint)?;
//! assert_eq!(fit.get("y1").unwrap().to_string(), "-0.1712(29) °C");
//! assert_eq!(fit.get("y2").unwrap().to_string(), "0.00218(67)");
//! assert!((fit.estimate().covariance().correlation(0, 1).unwrap() + 0.930).abs() < 5e-4);
//! # Ok::<(), Refusal>(())
//! ```
//!
//! # Conventions
//!
//! - *u* is a standard uncertainty, *U = k u* an expanded one; k comes from Student's t at the effective degrees of
//!   freedom, which are not truncated to an integer.
//! - The u of a mean of n readings is s/√n with ν = n − 1. Monte Carlo draws Student's t for it, whose standard
//!   deviation is larger by √(ν/(ν − 2)); the two results differ by that much, and the validation says so.
//! - All draws of one input share the one estimate of its σ; inputs observed together share one covariance.
//! - A complex quantity is two real components. Covariances are row-major.
//! - A budget share of a correlated input holds half of each covariance term, so shares sum to one.
//! - Trials have one random stream per block; the same seed gives the same bits on any number of threads.
//! - What cannot be computed is an [`Error`](proofmass_core::Error) or, with names, a [`Refusal`]; what can be
//!   doubted is a [`Finding`].
//!
//! # Not covered
//!
//! - Bayesian type A evaluation with informative priors, and interval-valued (imprecise) probability.
//! - Marginals other than normal and Student t are joined under correlation by a normal copula with the product-moment
//!   coefficient that is stated; other copulas are not offered.
//! - Errors in variables for polynomials beyond the straight line in model files; in Rust [`LeastSquares`] takes them.

#![allow(
    clippy::needless_range_loop,
    reason = "indices stand as in the equations"
)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "!(x < bound) refuses NaN as well"
)]

pub mod adjustment;
#[cfg(feature = "estimate")]
pub mod algebra;
pub mod findings;

mod agreement;
mod between_scatter;
mod conformity;
mod coverage;
mod distribution;
mod effective_dof;
mod expression;
mod finding;
mod fixed_size;
mod format;
mod notation;
mod number;
mod quantile;
mod quantity;
mod refusal;
mod student;

pub use agreement::En;
pub use between_scatter::{
    BetweenScatter, CommonErrors, Linearised, MeanOfRepeats, NoiseDof, Repeats, WithCommonErrors,
};
pub use conformity::{Conformity, DecisionRule, GlobalRisk, Judgement, Limits, Measured};
pub use coverage::DegreesOfFreedom;
pub use distribution::Distribution;
pub use effective_dof::welch_satterthwaite;
pub use expression::Expression;
pub use finding::{EvidenceValue, Figure, Finding, FindingKind, Severity};
pub use findings::CATALOGUE;
pub use fixed_size::{propagate_fixed, propagate_independent, propagate_jacobian};
pub use format::{
    Alphabet, DecimalMark, Format, Formatted, Notation, Rounded, ShowDof, numerical_tolerance,
};
pub use notation::{scientific, superscript};
pub use number::{Complex, Dual, Number};
pub use quantile::{
    chi_squared_chance, chi_squared_quantile, dof_of_coverage_factor, f_quantile, normal_quantile,
    student_quantile,
};
pub use quantity::{Evaluation, Quantity};
pub use refusal::Refusal;

/// Joint covariances, estimates and the law of propagation.
#[cfg(feature = "estimate")]
mod joint {
    pub use crate::covariance::Covariance;
    pub use crate::effective_dof::{CorrelatedGroup, GroupDof, willink, willink_hall};
    pub use crate::estimate::{
        BudgetInput, BudgetLine, Component, Effect, Estimate, Influence, Member,
    };
    pub use crate::estimate_series::{EstimateSeries, SeriesPoint, SharedEffect};
    pub use crate::implicit::{
        Implicit, LeastSquares, propagate_implicit, propagate_least_squares,
    };
    pub use crate::input::{Draw, Input, Inputs, JointInputs, JointReadings, Labels};
    pub use crate::propagation::{
        Linear, Model, SecondOrder, jacobian, linear, propagate, propagate_second_order,
    };
    pub use crate::solved::{NormalEquations, Solved};
    pub use crate::uncertain::{Uncertain, UncertainComplex, UncertainMatrix};
}
#[cfg(feature = "estimate")]
mod covariance;
#[cfg(feature = "estimate")]
mod estimate;
#[cfg(feature = "estimate")]
mod estimate_series;
#[cfg(feature = "estimate")]
mod implicit;
#[cfg(feature = "estimate")]
mod input;
#[cfg(feature = "estimate")]
mod propagation;
#[cfg(feature = "estimate")]
mod solved;
#[cfg(feature = "estimate")]
mod uncertain;
#[cfg(feature = "estimate")]
pub use joint::*;

/// Propagation of distributions.
#[cfg(feature = "monte-carlo")]
mod trials {
    pub use crate::effects::{CauseEffect, OutputEffects};
    pub use crate::histogram::Histogram;
    pub use crate::monte_carlo::{
        Drawn, Interval, MonteCarlo, Progress, Sampled, SampledOutput, Trial, Trials,
    };
    pub use crate::reference_value::{Deviation, MedianDeviation, MedianValue, WeightedMean};
    pub use crate::region::Region;
    pub use crate::trial_table::{TrialColumn, TrialTable};
    pub use crate::validation::{ENDS, Validation, Verdict};
}
#[cfg(feature = "monte-carlo")]
mod effects;
#[cfg(feature = "monte-carlo")]
mod histogram;
#[cfg(feature = "monte-carlo")]
mod monte_carlo;
#[cfg(feature = "monte-carlo")]
mod reference_value;
#[cfg(feature = "monte-carlo")]
mod region;
#[cfg(feature = "monte-carlo")]
mod sampler;
#[cfg(feature = "monte-carlo")]
mod trial_table;
#[cfg(feature = "monte-carlo")]
mod validation;
#[cfg(feature = "monte-carlo")]
mod ziggurat;
#[cfg(feature = "monte-carlo")]
pub use trials::*;

#[cfg(feature = "model")]
mod dimension;
#[cfg(feature = "model")]
mod evaluation;
#[cfg(feature = "model")]
mod model;
#[cfg(feature = "model")]
pub use dimension::{UnitSymbol, unit_ratio, unit_symbols};
#[cfg(feature = "model")]
pub use evaluation::{
    Evaluate, LinearOutput, Method, ModelResult, OutputConformity, OutputResult, Statement,
    StatementMethod, Sweep, SweepPoint, Target, TargetInput,
};
#[cfg(feature = "model")]
pub use model::{
    Accuracy, BudgetEntries, ColumnContent, ConformityEntry, CorrelationEntry, EarlierEntry,
    Equations, FitEntry, FitScatter, FitWeights, InputEntry, IntermediateEntry, OutputEntry,
    SolveEntry, SweepEntry, TargetEntry, UncertaintyModel, UnitRule,
};

/// The example of the README, so that it stays true.
#[cfg(all(doctest, feature = "model"))]
#[doc = include_str!("../README.md")]
struct Readme;
