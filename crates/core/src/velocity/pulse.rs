//! Velocity from encoder pulses and a clock: fixed time (M), fixed position (T) and mixed (M/T).

use super::positive;
use crate::{Error, Float};

/// M: v = ΔN δ/T, increments counted in a fixed time.
///
/// **Resolution** δ/T. **Delay** T/2. **Uncertainty** δ/(T√6): both ends are rounded to an increment, each with
/// δ/√12. **Steady-state error** none in the mean. Dominated by δ/T at low speed: use [`MixedTime`] there.
/// The counter may roll over: differences are taken modulo 2³².
///
/// ```
/// use proofmass_core::velocity::{FixedTime, FixedTimeState};
/// let m = FixedTime::<f64>::new(1e-3, 0.01)?;
/// let mut state = FixedTimeState::new(i32::MAX);
/// let v = m.update(&mut state, i32::MAX.wrapping_add(5));
/// assert!((v - 0.5).abs() < 1e-12);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedTime<T> {
    resolution: T,
    period: f64,
}

/// Count at the end of the last window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedTimeState {
    count: i32,
}

impl FixedTimeState {
    /// Starts at this count.
    pub fn new(count: i32) -> Self {
        Self { count }
    }
}

impl<T: Float> FixedTime<T> {
    /// Increment δ (2π/4N for N lines decoded fourfold) and window T in seconds.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for values that are not positive.
    pub fn new(increment: f64, period: f64) -> Result<Self, Error> {
        let period = positive("period", period)?;
        Ok(Self {
            resolution: T::from_f64(positive("increment", increment)? / period),
            period,
        })
    }

    /// Mean velocity over the window that ends now.
    pub fn update(&self, state: &mut FixedTimeState, count: i32) -> T {
        let steps = count.wrapping_sub(state.count);
        state.count = count;
        T::from_f64(f64::from(steps)) * self.resolution
    }

    /// δ/T.
    pub fn resolution(&self) -> T {
        self.resolution
    }

    /// T/2 in seconds.
    pub fn delay(&self) -> f64 {
        0.5 * self.period
    }

    /// δ/(T√6).
    pub fn standard_uncertainty(&self) -> T {
        self.resolution * T::from_f64(1.0 / root_six())
    }
}

/// √6 is not a constant of `core`.
fn root_six() -> f64 {
    libm::sqrt(6.0)
}

/// What a [`PulseReading`] rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadingKind {
    /// Whole increments between two timed edges.
    Measured,
    /// No edge came: the axis is slower than one increment in the time since the last; the velocity is the
    /// smaller of the last one and that bound.
    Bounded,
    /// No edge came for longer than the timeout: the velocity is zero by decision.
    Standstill,
}

/// A velocity from timed edges with what limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseReading<T> {
    /// Velocity in the middle of the measured interval.
    pub velocity: T,
    /// Standard uncertainty from the clock (measured) or the bound (otherwise).
    pub standard_uncertainty: T,
    /// Age of that middle at the time of the reading, in seconds.
    pub delay: T,
    /// What it rests on.
    pub kind: ReadingKind,
}

/// T: v = n δ/(M/f), clock ticks M counted over a fixed number n of increments.
///
/// **Resolution** v/M: dominated by the clock at high speed. **Delay** half the interval. **Uncertainty**
/// |v|/(M√6): both ends are rounded to a tick. n should be a whole number of line periods (4 with fourfold
/// decoding), so that the unequal quarters of real encoders cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPosition<T> {
    distance: f64,
    clock: f64,
    tick: T,
}

impl<T: Float> FixedPosition<T> {
    /// Distance n δ and clock frequency in Hz.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for values that are not positive.
    pub fn new(distance: f64, clock: f64) -> Result<Self, Error> {
        let clock = positive("clock frequency", clock)?;
        Ok(Self {
            distance: positive("distance", distance)?,
            clock,
            tick: T::from_f64(1.0 / clock),
        })
    }

    /// Velocity over the interval of this many ticks, in the sense of `forward`; `None` for zero ticks.
    pub fn velocity(&self, ticks: u32, forward: bool) -> Option<PulseReading<T>> {
        if ticks == 0 {
            return None;
        }
        let m = f64::from(ticks);
        let speed = self.distance * self.clock / m;
        Some(PulseReading {
            velocity: T::from_f64(if forward { speed } else { -speed }),
            standard_uncertainty: T::from_f64(speed / (m * root_six())),
            delay: T::from_f64(0.5 * m) * self.tick,
            kind: ReadingKind::Measured,
        })
    }
}

/// The last edge of a window: count after it and clock at it. Both may roll over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Count after the edge.
    pub count: i32,
    /// Free-running clock at the edge.
    pub ticks: u32,
}

/// M/T: whole increments between the last edges of two windows over the clock between them.
///
/// v = ΔN δ f/ΔM. The position of an edge is exact and its time is known to a tick, so that both errors are
/// small at every speed.
///
/// **Resolution** v/ΔM. **Delay** half of ΔM plus the age of the last edge, returned with each reading.
/// **Uncertainty** |v|/(ΔM√6). **Zero speed** with no edge in a window the reading is bounded by one increment
/// since the last edge; after the timeout it is zero, and [`ReadingKind`] says so.
/// **Source** `[Ohmae82]`.
///
/// ```
/// use proofmass_core::velocity::{Edge, MixedTime, MixedTimeState};
/// let mt = MixedTime::<f64>::new(0.001, 1e6, 0.1)?;
/// let mut state = MixedTimeState::new(Edge { count: 0, ticks: u32::MAX - 99 });
/// let reading = mt.update(&mut state, 1000, Some(Edge { count: 3, ticks: 900 }));
/// assert!((reading.velocity - 0.003 / 0.001).abs() < 1e-12); // 1000 ticks across the rollover
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedTime<T> {
    increment: f64,
    tick: f64,
    timeout: u32,
    zero: T,
}

/// Memory of [`MixedTime`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedTimeState<T> {
    edge: Edge,
    velocity: T,
    kind: ReadingKind,
}

impl<T: Float> MixedTimeState<T> {
    /// Starts at rest with this as the last edge.
    pub fn new(edge: Edge) -> Self {
        Self {
            edge,
            velocity: T::ZERO,
            kind: ReadingKind::Standstill,
        }
    }
}

impl<T: Float> MixedTime<T> {
    /// Increment δ, clock frequency in Hz and zero-speed timeout in seconds.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for values that are not positive, or a timeout of 2³² ticks and more.
    pub fn new(increment: f64, clock: f64, timeout: f64) -> Result<Self, Error> {
        let clock = positive("clock frequency", clock)?;
        let ticks = positive("timeout", timeout)? * clock;
        if ticks > f64::from(u32::MAX) {
            return Err(Error::OutOfRange {
                name: "timeout",
                value: timeout,
                min: 0.0,
                max: f64::from(u32::MAX) / clock,
            });
        }
        Ok(Self {
            increment: positive("increment", increment)?,
            tick: 1.0 / clock,
            timeout: ticks as u32,
            zero: T::ZERO,
        })
    }

    /// Reading at clock `now` from the last edge of the window, `None` when the window had none.
    pub fn update(
        &self,
        state: &mut MixedTimeState<T>,
        now: u32,
        edge: Option<Edge>,
    ) -> PulseReading<T> {
        let since = now.wrapping_sub(state.edge.ticks);
        if let Some(edge) = edge {
            let interval = edge.ticks.wrapping_sub(state.edge.ticks);
            let age = now.wrapping_sub(edge.ticks);
            let steps = edge.count.wrapping_sub(state.edge.count);
            let first_after_rest = state.kind == ReadingKind::Standstill;
            state.edge = edge;
            if interval > 0 {
                let m = f64::from(interval);
                let velocity = f64::from(steps) * self.increment / (m * self.tick);
                // After a standstill the interval holds the rest as well: the mean is right, its middle is old.
                let rounding = velocity.abs() / (m * root_six());
                let spread = if first_after_rest {
                    velocity.abs()
                } else {
                    0.0
                };
                state.velocity = T::from_f64(velocity);
                state.kind = ReadingKind::Measured;
                return PulseReading {
                    velocity: state.velocity,
                    standard_uncertainty: T::from_f64(libm::hypot(rounding, spread)),
                    delay: T::from_f64((0.5 * m + f64::from(age)) * self.tick),
                    kind: ReadingKind::Measured,
                };
            }
        }
        let elapsed = f64::from(since.max(1)) * self.tick;
        let bound = T::from_f64(self.increment / elapsed);
        if since >= self.timeout {
            state.kind = ReadingKind::Standstill;
            state.velocity = self.zero;
        } else if state.kind != ReadingKind::Standstill {
            state.kind = ReadingKind::Bounded;
            if state.velocity > bound {
                state.velocity = bound;
            } else if state.velocity < -bound {
                state.velocity = -bound;
            }
        }
        PulseReading {
            velocity: state.velocity,
            // Anywhere between the two bounds with equal probability.
            standard_uncertainty: bound * T::from_f64(1.0 / libm::sqrt(3.0)),
            delay: T::from_f64(0.5 * elapsed),
            kind: state.kind,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_three_methods_read_a_constant_velocity_within_their_uncertainty() {
        let (delta, clock, v) = (1e-3, 1e6, 0.7373);
        let m = FixedTime::<f64>::new(delta, 0.01).unwrap();
        let mut ms = FixedTimeState::new(0);
        let mt = MixedTime::<f64>::new(delta, clock, 0.05).unwrap();
        let mut mts = MixedTimeState::new(Edge { count: 0, ticks: 0 });
        let (mut worst_m, mut worst_mt) = (0.0f64, 0.0f64);
        for n in 1..=1000u32 {
            let t = 0.01 * f64::from(n);
            let count = (v * t / delta).floor() as i32;
            let edge = Edge {
                count,
                ticks: (f64::from(count) * delta / v * clock).floor() as u32,
            };
            worst_m = worst_m.max((m.update(&mut ms, count) - v).abs());
            let reading = mt.update(&mut mts, (t * clock) as u32, Some(edge));
            worst_mt = worst_mt.max((reading.velocity - v).abs());
            assert!(reading.delay < 0.0075 && reading.delay > 0.0049);
        }
        assert!(worst_m <= m.resolution() && worst_m > 0.1 * m.resolution());
        assert!(worst_mt <= v / 9_000.0, "{worst_mt}"); // one tick in the interval
        let t = FixedPosition::<f64>::new(4.0 * delta, clock).unwrap();
        let ticks = (4.0 * delta / v * clock).floor() as u32;
        let reading = t.velocity(ticks, false).unwrap();
        assert!((reading.velocity + v).abs() <= v / f64::from(ticks));
        assert!(t.velocity(0, true).is_none());
    }

    #[test]
    fn law_no_edge_means_bounded_then_standstill() {
        let mt = MixedTime::<f32>::new(1e-3, 1e6, 0.1).unwrap();
        let mut s = MixedTimeState::new(Edge { count: 0, ticks: 0 });
        mt.update(
            &mut s,
            5_000,
            Some(Edge {
                count: 1,
                ticks: 4_000,
            }),
        );
        let first = mt.update(
            &mut s,
            10_000,
            Some(Edge {
                count: 6,
                ticks: 9_000,
            }),
        );
        assert_eq!(first.kind, ReadingKind::Measured);
        assert!((first.velocity - 1.0).abs() < 1e-6);
        let bounded = mt.update(&mut s, 29_000, None);
        assert_eq!(bounded.kind, ReadingKind::Bounded);
        assert!((bounded.velocity - 0.05).abs() < 1e-7);
        let still = mt.update(&mut s, 200_000, None);
        assert_eq!((still.kind, still.velocity), (ReadingKind::Standstill, 0.0));
    }

    #[test]
    fn refuses_a_timeout_the_clock_cannot_count() {
        assert!(MixedTime::<f64>::new(1.0, 1e9, 5.0).is_err());
        assert!(FixedTime::<f64>::new(0.0, 1.0).is_err());
        assert!(FixedPosition::<f64>::new(1.0, 0.0).is_err());
    }
}
