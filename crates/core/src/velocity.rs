//! Velocity from position, from acceleration, and from both: streaming estimators in constant time and memory.
//!
//! Every estimator is two values: coefficients, designed once in double precision, and a state of a few
//! numbers. The desk program and the chip run the same functions, in `f32` or `f64`.
//!
//! | from | estimator | delay at low frequency | steady-state error |
//! |---|---|---|---|
//! | position | [`FixedTime`] (M) | T/2 | none; quantised to δ/T |
//! | position | [`FixedPosition`] (T) | half the interval | none; quantised to v/M |
//! | position | [`MixedTime`] (M/T) | half the interval of whole increments | none |
//! | position | [`PositionDifference`] of degree 1 | (N−1)T/2 | a · delay under constant acceleration |
//! | position | [`PositionDifference`] of degree ≥ 2 | 0 | 0 under constant acceleration |
//! | position | [`TrackingLoop`] of bandwidth b | 2/b | 2a/b under constant acceleration |
//! | acceleration | [`Integrator`], [`Newmark`] | 0 | grows as offset · t |
//! | both | [`TwoChannel`] | 0 | 0 for k₁ > 0, offset/k₂ for k₁ = 0 |
//! | both | [`Observer`] | 0 | offset · k_x/k_v; 0 with the offset state |
//! | both | [`AdaptiveObserver`] | 0 | as the observer, with the gain learnt |
//! | both | [`Kalman`], [`SteadyKalman`] | 0 | as the observer; 0 with a bias state |
//!
//! # Conventions
//! - Position, velocity and acceleration share one length (or angle) unit and one sense.
//! - One set of verbs: `predict` is the time update, where no reading came; `update` the measurement update alone; `step` a whole
//!   sample with the readings that the estimator is made for; [`Estimator::estimate`] a whole sample of the axis.
//! - Delay is that of the velocity of a slow motion: minus the slope of the phase at zero frequency.
//! - [`Estimator`] is the one face of all of them: it takes the way since the last sample, which [`Counter`] and [`Circle`]
//!   make of counters and angles that roll over, so that `f32` keeps its digits however far a motor turns. Fed with positions
//!   themselves, `f32` wants them counted from nearby: a position of 10⁷ increments leaves no fraction.
//! - Samples that come unevenly: `after(time)` of [`Observer`], [`TrackingLoop`], [`TwoChannel`] and [`Kalman`] with two states.
//! - [`InputGuard`] takes out what no axis can have made; [`ResolverLoop`] runs on a resolver's voltages.
//!
//! # Not covered
//! Sensors that share no axis (a rotating accelerometer feels the centripetal term), flexible couplings, and
//! latency between the sensors, which the caller removes by delaying the faster one.

mod adaptive_observer;
mod counting;
mod estimator;
mod input_guard;
mod integrator;
mod kalman;
mod low_corner;
mod observer;
mod position_difference;
mod pulse;
mod resolver_loop;
mod two_channel;
mod way;

pub use adaptive_observer::{AdaptiveObserver, AdaptiveObserverState};
pub use counting::{
    CountUpdate, CountUse, CountingKalman, CountingNoise, CountingState, PassedEdge, TURNING,
};
pub use estimator::{AxisSample, Estimator, Last, MixedTimeMemory};
pub use input_guard::{InputFault, InputGuard, InputGuardState};
pub use integrator::{Integrator, IntegratorRule, IntegratorState, Newmark, NewmarkState};
pub use kalman::{BiasModel, Hold, Kalman, KalmanState, MotionNoise, ProcessNoise, SteadyKalman};
pub use observer::{Observer, ObserverState, TrackingLoop};
pub use position_difference::{PositionDifference, PositionDifferenceState};
pub use pulse::{
    Edge, FixedPosition, FixedTime, FixedTimeState, MixedTime, MixedTimeState, PulseReading,
    ReadingKind, pulse_rate,
};
pub use resolver_loop::{ResolverLoop, ResolverReading};
pub use two_channel::{TwoChannel, TwoChannelState};
pub use way::{Circle, CircleState, Counter, CounterState};

use crate::check::{not_negative, positive};
