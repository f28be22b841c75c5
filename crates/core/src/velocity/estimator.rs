//! One face of all estimators: a sample in, a velocity out, however far the motor has turned.

use super::{
    AdaptiveObserver, AdaptiveObserverState, CountingKalman, CountingState, Edge, FixedTime,
    FixedTimeState, Integrator, IntegratorState, Kalman, KalmanState, MixedTime, MixedTimeState,
    Newmark, NewmarkState, Observer, ObserverState, PassedEdge, PositionDifference,
    PositionDifferenceState, SteadyKalman, TrackingLoop, TwoChannel, TwoChannelState,
};
use crate::Float;

/// What an axis shows at one sample: the way since the last reading, not where it is.
///
/// A position of 10⁷ turns leaves single precision no fraction; the way since the last sample has all its digits.
/// [`Counter`](super::Counter) and [`Circle`](super::Circle) make it from counters and angles that roll over.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AxisSample<T> {
    /// Counts since the last reading; `None` where this sample has no reading.
    pub counts: Option<i32>,
    /// The same as a way or angle.
    pub way: Option<T>,
    /// Acceleration; zero without an accelerometer.
    pub acceleration: T,
    /// Free-running clock at this sample, where edges are timed.
    pub clock: u32,
    /// Last edge before this sample, where edges are timed and one came.
    pub edge: Option<Edge>,
}

impl<T: Float> AxisSample<T> {
    /// A sample without a reading of the position: estimators go on with the acceleration.
    pub fn unread(acceleration: T) -> Self {
        Self {
            counts: None,
            way: None,
            acceleration,
            clock: 0,
            edge: None,
        }
    }

    /// The same with the clock, and the last edge where one came.
    #[must_use]
    pub fn timed(self, clock: u32, edge: Option<Edge>) -> Self {
        Self {
            clock,
            edge,
            ..self
        }
    }
}

/// A velocity from the samples of an axis, in constant time and memory.
///
/// The state knows positions from the last reading on only, so that nothing grows while a motor turns.
///
/// ```
/// use proofmass_core::velocity::{Counter, CounterState, Estimator, Observer, TrackingLoop};
///
/// fn drive<E: Estimator<f32>>(estimator: &E) -> f32 {
///     let counter = Counter::<f32>::new(1e-3, 16).unwrap();
///     let mut last = CounterState::new(65_000);
///     let mut state = estimator.start(0.0);
///     let mut v = 0.0;
///     for n in 1..=3000u32 {
///         let sample = counter.sample(&mut last, (65_000 + 20 * n) & 0xffff, 0.0);
///         v = estimator.estimate(&mut state, &sample);
///     }
///     v
/// }
/// // Twenty counts of 1 mm in a millisecond are 20 m/s.
/// assert!((drive(&TrackingLoop::new(100.0, 1e-3)?) - 20.0).abs() < 1e-3);
/// assert!((drive(&Observer::new(10.0, 100.0, 1e-3)?) - 20.0).abs() < 1e-3);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub trait Estimator<T: Float> {
    /// What it remembers.
    type State: Copy;

    /// At rest, with this acceleration; the position is where the last reading was.
    fn start(&self, acceleration: T) -> Self::State;

    /// In motion, at this velocity with its standard uncertainty. What knows no uncertainty takes the velocity as it is; the Kalman
    /// filters weigh it against the readings.
    fn start_moving(&self, velocity: (T, T), acceleration: T) -> Self::State;

    /// Velocity at the time of this sample, less the delay the estimator states.
    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T;

    /// Standard uncertainty of the velocity, where the estimator knows one.
    fn standard_uncertainty(&self, _state: &Self::State) -> Option<T> {
        None
    }
}

/// Position estimators keep the last velocity where no reading came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Last<S, T> {
    /// Of the estimator.
    pub(crate) inner: S,
    /// Last velocity.
    pub(crate) velocity: T,
}

impl<T: Float, const N: usize> Estimator<T> for PositionDifference<T, N> {
    type State = Last<PositionDifferenceState<T, N>, T>;

    fn start(&self, _acceleration: T) -> Self::State {
        Last {
            inner: PositionDifferenceState::new(T::ZERO),
            velocity: T::ZERO,
        }
    }

    fn start_moving(&self, (velocity, _): (T, T), _acceleration: T) -> Self::State {
        Last {
            inner: self.window_of(velocity),
            velocity,
        }
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        if let Some(way) = sample.way {
            Self::rebase(&mut state.inner, way);
            state.velocity = self.step(&mut state.inner, T::ZERO);
        }
        state.velocity
    }
}

impl<T: Float> Estimator<T> for FixedTime<T> {
    type State = Last<FixedTimeState, T>;

    fn start(&self, _acceleration: T) -> Self::State {
        Last {
            inner: FixedTimeState::new(0),
            velocity: T::ZERO,
        }
    }

    fn start_moving(&self, (velocity, _): (T, T), _acceleration: T) -> Self::State {
        Last {
            inner: FixedTimeState::new(0),
            velocity,
        }
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        if let Some(counts) = sample.counts {
            state.inner = FixedTimeState::new(0);
            state.velocity = self.step(&mut state.inner, counts);
        }
        state.velocity
    }

    fn standard_uncertainty(&self, _state: &Self::State) -> Option<T> {
        Some(FixedTime::standard_uncertainty(self))
    }
}

/// Memory of M/T and what it read last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedTimeMemory<T> {
    /// From the first edge on.
    pub(crate) inner: Option<MixedTimeState<T>>,
    /// Last velocity and its standard uncertainty, once there was one.
    pub reading: Option<(T, T)>,
}

impl<T: Float> Estimator<T> for MixedTime<T> {
    type State = MixedTimeMemory<T>;

    fn start(&self, _acceleration: T) -> Self::State {
        MixedTimeMemory {
            inner: None,
            reading: None,
        }
    }

    fn start_moving(&self, velocity: (T, T), _acceleration: T) -> Self::State {
        MixedTimeMemory {
            inner: None,
            reading: Some(velocity),
        }
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        match (&mut state.inner, sample.edge) {
            (Some(inner), edge) => {
                let reading = self.step(inner, sample.clock, edge);
                state.reading = Some((reading.velocity, reading.standard_uncertainty));
            }
            (None, Some(edge)) => state.inner = Some(MixedTimeState::new(edge)),
            (None, None) => {}
        }
        state.reading.map_or(T::ZERO, |r| r.0)
    }

    fn standard_uncertainty(&self, state: &Self::State) -> Option<T> {
        state.reading.map(|r| r.1)
    }
}

impl<T: Float> Estimator<T> for Observer<T> {
    type State = ObserverState<T>;

    fn start(&self, acceleration: T) -> Self::State {
        ObserverState::new(T::ZERO, T::ZERO, acceleration)
    }

    fn start_moving(&self, (velocity, _): (T, T), acceleration: T) -> Self::State {
        ObserverState::new(T::ZERO, velocity, acceleration)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        match sample.way {
            Some(way) => {
                state.position -= way;
                self.step(state, T::ZERO, sample.acceleration)
            }
            None => self.predict(state, sample.acceleration),
        }
    }
}

impl<T: Float> Estimator<T> for TrackingLoop<T> {
    type State = ObserverState<T>;

    fn start(&self, _acceleration: T) -> Self::State {
        ObserverState::new(T::ZERO, T::ZERO, T::ZERO)
    }

    fn start_moving(&self, (velocity, _): (T, T), _acceleration: T) -> Self::State {
        ObserverState::new(T::ZERO, velocity, T::ZERO)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        let alone = AxisSample {
            acceleration: T::ZERO,
            ..*sample
        };
        self.observer().estimate(state, &alone)
    }
}

impl<T: Float> Estimator<T> for AdaptiveObserver<T> {
    type State = AdaptiveObserverState<T>;

    fn start(&self, acceleration: T) -> Self::State {
        AdaptiveObserverState::new(T::ZERO, T::ZERO, acceleration)
    }

    fn start_moving(&self, (velocity, _): (T, T), acceleration: T) -> Self::State {
        AdaptiveObserverState::new(T::ZERO, velocity, acceleration)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        match sample.way {
            Some(way) => {
                state.motion.position -= way;
                self.step(state, T::ZERO, sample.acceleration)
            }
            None => self.predict(state, sample.acceleration),
        }
    }
}

impl<T: Float> Estimator<T> for TwoChannel<T> {
    type State = TwoChannelState<T>;

    fn start(&self, acceleration: T) -> Self::State {
        TwoChannelState::new(T::ZERO, T::ZERO, acceleration)
    }

    fn start_moving(&self, (velocity, _): (T, T), acceleration: T) -> Self::State {
        TwoChannelState::new(T::ZERO, velocity, acceleration)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        match sample.way {
            Some(way) => {
                Self::rebase(state, way);
                self.step(state, T::ZERO, sample.acceleration)
            }
            None => self.predict(state, sample.acceleration),
        }
    }
}

impl<T: Float, const N: usize> Estimator<T> for Kalman<T, N> {
    type State = KalmanState<T, N>;

    /// Before the first readings nothing is known: the variances are those of a hundred times the noise of a position, of a
    /// velocity that changes by it within a step, and of an offset that would move the axis by it.
    fn start(&self, acceleration: T) -> Self::State {
        let wide = T::from_f64(1e4) * self.r;
        // The step of a velocity of one, and of an offset of one.
        let step = self.f[0][1];
        let variances = core::array::from_fn(|i| match i {
            0 => wide,
            1 => wide / (step * step),
            _ => wide / (step * step * step * step),
        });
        KalmanState::new([T::ZERO; N], variances, acceleration)
    }

    fn start_moving(&self, (velocity, uncertainty): (T, T), acceleration: T) -> Self::State {
        let mut state = self.start(acceleration);
        state.x[1] = velocity;
        state.p[1][1] = uncertainty * uncertainty;
        state
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        self.predict(state, sample.acceleration);
        if let Some(way) = sample.way {
            // Zero is where this reading is.
            state.x[0] -= way;
            self.update(state, T::ZERO);
        }
        state.x[1]
    }

    fn standard_uncertainty(&self, state: &Self::State) -> Option<T> {
        Some(state.velocity_uncertainty())
    }
}

impl<T: Float, const N: usize> Estimator<T> for SteadyKalman<T, N> {
    type State = KalmanState<T, N>;

    fn start(&self, acceleration: T) -> Self::State {
        KalmanState::new([T::ZERO; N], [T::ZERO; N], acceleration)
    }

    fn start_moving(&self, (velocity, _): (T, T), acceleration: T) -> Self::State {
        let mut state = self.start(acceleration);
        state.x[1] = velocity;
        state
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        if let Some(way) = sample.way {
            state.x[0] -= way;
        }
        self.step(state, sample.way.map(|_| T::ZERO), sample.acceleration)
    }

    fn standard_uncertainty(&self, _state: &Self::State) -> Option<T> {
        Some(self.velocity_variance.sqrt())
    }
}

impl<T: Float> Estimator<T> for CountingKalman<T> {
    type State = CountingState<T>;

    /// Velocity and offset are known to nothing: to a thousand counts in a sample, and what moves the axis by one.
    fn start(&self, acceleration: T) -> Self::State {
        let wide = T::from_f64(1e3) * self.velocity_unit();
        let offset = self.acceleration_unit();
        CountingKalman::start(self, 0, (T::ZERO, wide), (T::ZERO, offset), acceleration)
    }

    fn start_moving(&self, velocity: (T, T), acceleration: T) -> Self::State {
        let offset = self.acceleration_unit();
        CountingKalman::start(self, 0, velocity, (T::ZERO, offset), acceleration)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        match sample.counts {
            Some(counts) => {
                let edge = sample.edge.map(|edge| PassedEdge {
                    age: self.age(sample.clock.wrapping_sub(edge.ticks)),
                    upwards: edge.upwards,
                });
                let count = state.count.wrapping_add(counts);
                self.step(state, count, edge, sample.acceleration);
            }
            None => self.predict(state, sample.acceleration),
        }
        self.velocity(state).0
    }

    fn standard_uncertainty(&self, state: &Self::State) -> Option<T> {
        Some(self.velocity(state).1)
    }
}

impl<T: Float> Estimator<T> for Integrator<T> {
    type State = IntegratorState<T>;

    fn start(&self, _acceleration: T) -> Self::State {
        IntegratorState::new(T::ZERO)
    }

    fn start_moving(&self, (velocity, _): (T, T), _acceleration: T) -> Self::State {
        IntegratorState::new(velocity)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        self.step(state, sample.acceleration)
    }
}

impl<T: Float> Estimator<T> for Newmark<T> {
    type State = NewmarkState<T>;

    fn start(&self, _acceleration: T) -> Self::State {
        NewmarkState::new(T::ZERO, T::ZERO)
    }

    fn start_moving(&self, (velocity, _): (T, T), _acceleration: T) -> Self::State {
        NewmarkState::new(T::ZERO, velocity)
    }

    fn estimate(&self, state: &mut Self::State, sample: &AxisSample<T>) -> T {
        self.step(state, sample.acceleration)
    }
}
