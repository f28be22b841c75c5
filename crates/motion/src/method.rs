//! Every way to a velocity under one name, run over a record by the streaming estimators of `core`.

mod label;
mod streaming;

use crate::counting::Counted;
use crate::timed::{fixed_position, mixed_time};
use crate::{
    CountingModel, KalmanModel, MotionRecord, OffLineIntegration, ReadingSource, integrate,
};
use proofmass_core::Error;
use proofmass_core::velocity::{
    AdaptiveObserver, AdaptiveObserverState, Integrator, IntegratorRule, IntegratorState, Newmark,
    NewmarkState, Observer, ObserverState, TrackingLoop, TwoChannel, TwoChannelState,
};
use serde::{Deserialize, Serialize};
use streaming::{at_readings, at_samples, long_window, observe, resolver_loop, steady, window};

/// Windows for which the one-sided fits are built.
pub const WINDOWS: [usize; 10] = [2, 3, 4, 5, 7, 9, 11, 15, 21, 31];

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "method")]
pub enum Method {
    /// A speed as it was read, held until the next: wheel, tachogenerator.
    SpeedReading,
    /// ΔN δ/T.
    FixedTime,
    /// The same over a window of several readings: resolution δ/(n T), delay n T/2.
    LongWindow {
        /// n
        samples: usize,
    },
    /// n δ over the time between the last edge and the n-th before it; of a recording of timed edges.
    FixedPosition {
        /// n, a whole number of line periods where quarters are unequal: 4 with fourfold decoding.
        edges: usize,
    },
    /// ΔN δ/Δt between the last edges of two samples (M/T); of a recording of timed edges.
    MixedTime {
        /// Time without an edge after which the axis is said to stand, s.
        timeout: f64,
    },
    /// Polynomial through the last order + 1 positions.
    BackwardDifference {
        /// 1, 2 or 3.
        order: usize,
    },
    /// One-sided least-squares polynomial.
    SavitzkyGolay {
        /// One of [`WINDOWS`].
        window: usize,
        /// Below the window.
        degree: usize,
    },
    /// K_p = 2b, K_i = b².
    TrackingLoop {
        /// b, rad/s.
        bandwidth: f64,
    },
    /// The tracking loop of a resolver, fed by sin θ cos θ̂ − cos θ sin θ̂: K_p = 2b, K_i = b².
    ResolverLoop {
        /// b, rad/s.
        bandwidth: f64,
    },
    /// Acceleration alone.
    Integration {
        /// Rule.
        rule: IntegratorRule,
        /// Offset to subtract before: from a still period, or zero.
        offset: f64,
    },
    /// Newmark's method: v_n = v_{n−1} + T [(1−γ) a_{n−1} + γ a_n].
    Newmark {
        /// γ, ½ without delay.
        gamma: f64,
        /// β, of the position.
        beta: f64,
        /// Offset to subtract before.
        offset: f64,
    },
    /// Acceleration alone, and of its integral what lies above a corner (Butterworth); off line where it is zero-phase.
    HighPass {
        /// Rule of the integral.
        rule: IntegratorRule,
        /// Order, of each of the two passes where it is zero-phase.
        order: usize,
        /// Corner, Hz.
        corner: f64,
        /// Forward and backward.
        zero_phase: bool,
    },
    /// Zhu and Lamarche's two channels.
    TwoChannel {
        /// rad/s
        k1: f64,
        /// rad/s
        k2: f64,
    },
    /// Second-order observer.
    Observer {
        /// 1/s
        k_x: f64,
        /// 1/s²
        k_v: f64,
    },
    /// Third-order observer with offset.
    OffsetObserver {
        /// 1/s
        k_x: f64,
        /// 1/s²
        k_v: f64,
        /// 1/s³
        k_b: f64,
    },
    /// Observer that learns the accelerometer's gain.
    AdaptiveObserver {
        /// 1/s
        k_x: f64,
        /// 1/s²
        k_v: f64,
        /// Adaptation, 1/s.
        rate: f64,
        /// Position below which a sensitivity does not count.
        floor: f64,
    },
    /// Kalman filter.
    Kalman {
        /// Its model.
        model: KalmanModel,
    },
    /// Kalman filter with its constant gain, as firmware runs it.
    SteadyKalman {
        /// Its model.
        model: KalmanModel,
    },
    /// Kalman filter that takes a count for what it is: for axes that rest on a count for several samples.
    Counting {
        /// Its model.
        model: CountingModel,
    },
    /// The smoother of the same; off line only.
    CountingSmoother {
        /// Its model.
        model: CountingModel,
    },
    /// Fixed-interval smoother; off line only.
    Smoother {
        /// Its model.
        model: KalmanModel,
    },
}

/// Which sensors a method uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Position (or speed) only.
    Position,
    /// Acceleration only.
    Acceleration,
    /// Both, sample by sample.
    Fused,
    /// Both, with the whole recording at hand.
    OffLine,
}

impl Family {
    /// Stable lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Acceleration => "acceleration",
            Self::Fused => "fused",
            Self::OffLine => "off-line",
        }
    }
}

/// Velocity by one method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VelocityTrace {
    /// Method with its settings.
    pub method: Method,
    /// Short text with the settings, for legends and tables.
    pub label: String,
    /// Velocity per sample of the record.
    pub velocity: Vec<f64>,
    /// Standard uncertainty per sample, where the method knows one.
    pub standard_uncertainty: Option<Vec<f64>>,
    /// Delay the method states for slow motion, s.
    pub stated_delay: f64,
}

impl Method {
    /// Sensors it uses.
    pub fn family(&self) -> Family {
        match self {
            Self::SpeedReading
            | Self::FixedTime
            | Self::LongWindow { .. }
            | Self::FixedPosition { .. }
            | Self::MixedTime { .. }
            | Self::BackwardDifference { .. }
            | Self::SavitzkyGolay { .. }
            | Self::TrackingLoop { .. }
            | Self::ResolverLoop { .. } => Family::Position,
            Self::Integration { .. } | Self::Newmark { .. } | Self::HighPass { .. } => {
                Family::Acceleration
            }
            Self::Smoother { .. } | Self::CountingSmoother { .. } => Family::OffLine,
            _ => Family::Fused,
        }
    }

    /// Whether it says nothing without an accelerometer. Kalman filters and smoothers then take the velocity to change
    /// at random.
    pub fn needs_accelerometer(&self) -> bool {
        match self {
            Self::Kalman { .. } | Self::SteadyKalman { .. } | Self::Counting { .. } => false,
            _ => matches!(self.family(), Family::Fused | Family::Acceleration),
        }
    }

    /// Whether it lives on edges that were timed.
    pub fn needs_edges(&self) -> bool {
        matches!(self, Self::FixedPosition { .. } | Self::MixedTime { .. })
    }

    /// Whether it lives on the sine and the cosine of a resolver.
    pub fn needs_resolver(&self) -> bool {
        matches!(self, Self::ResolverLoop { .. })
    }

    /// Whether it says nothing without readings of position or speed. Kalman filters and smoothers then live on the rests.
    pub fn needs_readings(&self) -> bool {
        match self {
            Self::Kalman { .. } | Self::Smoother { .. } => false,
            _ => self.family() != Family::Acceleration,
        }
    }

    /// Runs over a record.
    ///
    /// Position methods run at the stride of the readings and hold between; a missing reading is bridged with the
    /// last velocity. Fused methods run at every sample and coast on the acceleration where no reading is.
    ///
    /// # Errors
    /// Of the record and of the settings; [`Error::NotFinite`] with the first sample that overflowed.
    pub fn run(&self, record: &MotionRecord) -> Result<VelocityTrace, Error> {
        record.check()?;
        let dt = record.sample_time;
        let slow = record.reading_stride() as f64 * dt;
        let mut uncertainty = None;
        let (velocity, stated_delay) = match *self {
            Self::SpeedReading => {
                if record.source != ReadingSource::Speed {
                    return Err(range("speed as read, of a position", 0.0, 1.0, 1.0));
                }
                let mut last = record.initial_velocity.unwrap_or(0.0);
                if let Some(first) = record.reading.iter().flatten().next()
                    && record.initial_velocity.is_none()
                {
                    last = *first;
                }
                let held = record.reading.iter().map(|r| {
                    last = r.unwrap_or(last);
                    last
                });
                // A reading that is held for n samples is (n − 1)/2 of them old on average.
                (held.collect(), 0.5 * (slow - dt))
            }
            Self::FixedTime => window::<2>(record, 1, slow)?,
            Self::LongWindow { samples } => long_window(record, samples, slow)?,
            Self::FixedPosition { edges } => fixed_position(record, edges)?,
            Self::MixedTime { timeout } => mixed_time(record, timeout)?,
            Self::BackwardDifference { order } => match order {
                1 => window::<2>(record, 1, slow)?,
                2 => window::<3>(record, 2, slow)?,
                3 => window::<4>(record, 3, slow)?,
                _ => return Err(range("order", order as f64, 1.0, 3.0)),
            },
            Self::SavitzkyGolay { window: n, degree } => match n {
                2 => window::<2>(record, degree, slow)?,
                3 => window::<3>(record, degree, slow)?,
                4 => window::<4>(record, degree, slow)?,
                5 => window::<5>(record, degree, slow)?,
                7 => window::<7>(record, degree, slow)?,
                9 => window::<9>(record, degree, slow)?,
                11 => window::<11>(record, degree, slow)?,
                15 => window::<15>(record, degree, slow)?,
                21 => window::<21>(record, degree, slow)?,
                31 => window::<31>(record, degree, slow)?,
                _ => return Err(range("window", n as f64, 2.0, 31.0)),
            },
            Self::TrackingLoop { bandwidth } => {
                let pll = TrackingLoop::<f64>::new(bandwidth, slow)?;
                let mut state: Option<ObserverState<f64>> = None;
                let v0 = record.start_velocity().0;
                let v = at_readings(record, |x, _| match &mut state {
                    None => {
                        state = Some(ObserverState::new(x, v0, 0.0));
                        v0
                    }
                    Some(state) => pll.step(state, x),
                });
                (v, pll.delay())
            }
            Self::ResolverLoop { bandwidth } => resolver_loop(record, bandwidth, slow)?,
            Self::Integration { rule, offset } => {
                let integrator = Integrator::<f64>::new(rule, dt)?;
                let mut state = IntegratorState::new(record.start_velocity().0);
                let v = record
                    .acceleration
                    .iter()
                    .map(|a| integrator.step(&mut state, a - offset));
                (v.collect(), 0.0)
            }
            Self::Newmark {
                gamma,
                beta,
                offset,
            } => {
                let newmark = Newmark::<f64>::new(gamma, beta, dt)?;
                let mut state = NewmarkState::new(0.0, record.start_velocity().0);
                let v = record
                    .acceleration
                    .iter()
                    .map(|a| newmark.step(&mut state, a - offset));
                (v.collect(), (0.5 - gamma) * dt)
            }
            Self::HighPass {
                rule,
                order,
                corner,
                zero_phase,
            } => {
                let method = match zero_phase {
                    false => OffLineIntegration::CausalHighPass {
                        rule,
                        order,
                        corner,
                    },
                    true => OffLineIntegration::ZeroPhase {
                        rule,
                        order,
                        corner,
                    },
                };
                (integrate(&record.acceleration, dt, None, method)?, 0.0)
            }
            Self::TwoChannel { k1, k2 } => {
                let filter = TwoChannel::<f64>::new(k1, k2, dt)?;
                let mut state: Option<TwoChannelState<f64>> = None;
                let v = at_samples(record, |x, a, v| match &mut state {
                    None => {
                        state = Some(TwoChannelState::new(x, v, a));
                        v
                    }
                    Some(state) => filter.step(state, x, a),
                });
                (v, 0.0)
            }
            Self::Observer { k_x, k_v } => (observe(record, &Observer::new(k_x, k_v, dt)?), 0.0),
            Self::OffsetObserver { k_x, k_v, k_b } => {
                let observer = Observer::with_offset(k_x, k_v, k_b, dt)?;
                (observe(record, &observer), 0.0)
            }
            Self::AdaptiveObserver {
                k_x,
                k_v,
                rate,
                floor,
            } => {
                let observer = AdaptiveObserver::<f64>::new(k_x, k_v, rate, floor, dt)?;
                let mut state: Option<AdaptiveObserverState<f64>> = None;
                let v = at_samples(record, |x, a, v| match &mut state {
                    None => {
                        state = Some(AdaptiveObserverState::new(x, v, a));
                        v
                    }
                    Some(state) => observer.step(state, x, a),
                });
                (v, 0.0)
            }
            Self::Kalman { model } => {
                let run = model.filter(record)?;
                uncertainty = Some(run.velocity_uncertainty);
                (run.velocity, 0.0)
            }
            Self::SteadyKalman { model } => (steady(record, &model)?, 0.0),
            Self::Counting { model } | Self::CountingSmoother { model } => {
                let counted = Counted::new(record)
                    .ok_or_else(|| range("counts, of a record without", 0.0, 1.0, 1.0))?;
                let run = counted.run(&model)?;
                let (v, u) = match self {
                    Self::Counting { .. } => run.filtered,
                    _ => run.smoothed,
                };
                uncertainty = Some(u);
                (v, 0.0)
            }
            Self::Smoother { model } => {
                let run = model.smooth(record)?;
                uncertainty = Some(run.velocity_uncertainty);
                (run.velocity, 0.0)
            }
        };
        if let Some(index) = velocity.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "velocity",
                index,
            });
        }
        Ok(VelocityTrace {
            method: *self,
            label: self.label(),
            velocity,
            standard_uncertainty: uncertainty,
            stated_delay,
        })
    }
}

fn range(name: &'static str, value: f64, min: f64, max: f64) -> Error {
    Error::OutOfRange {
        name,
        value,
        min,
        max,
    }
}
