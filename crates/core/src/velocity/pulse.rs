//! Velocity from encoder pulses and a clock: fixed time (M), fixed position (T) and mixed (M/T).

use super::{not_negative, positive};
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
/// let v = m.step(&mut state, i32::MAX.wrapping_add(5));
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
    pub fn step(&self, state: &mut FixedTimeState, count: i32) -> T {
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
#[non_exhaustive]
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

/// The last edge of a window: count after it, sense and clock at it. Count and clock may roll over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Count after the edge.
    pub count: i32,
    /// Free-running clock captured at the edge.
    pub ticks: u32,
    /// Whether the count rose.
    pub upwards: bool,
}

impl Edge {
    /// Place of the edge, in counts: the larger of the counts before and after it, in both senses.
    ///
    /// The count after an edge is another one when the edge is passed back; its place is not.
    ///
    /// ```
    /// use proofmass_core::velocity::Edge;
    /// let up = Edge { count: 8, ticks: 0, upwards: true };
    /// let down = Edge { count: 7, ticks: 100, upwards: false };
    /// assert_eq!(up.place(), down.place());
    /// ```
    pub fn place(self) -> i32 {
        self.count.wrapping_add(i32::from(!self.upwards))
    }
}

/// Counts per second in units of 1/256 from whole increments and clock ticks between two edges; integers alone, for chips
/// without floating point. `None` for no ticks, or where 64 bits do not hold it.
///
/// **Resolution** 1/256 count per second. **Delay** half the interval.
///
/// ```
/// use proofmass_core::velocity::pulse_rate;
/// // Three increments in 1000 ticks of a clock of 1 MHz.
/// assert_eq!(pulse_rate(-3, 1000, 1_000_000), Some(-3000 * 256));
/// ```
pub fn pulse_rate(steps: i32, ticks: u32, clock: u32) -> Option<i64> {
    let product = i64::from(steps).checked_mul(i64::from(clock))?;
    product.checked_mul(256)?.checked_div(i64::from(ticks))
}

/// M/T: whole increments between the last edges of two windows over the clock between them.
///
/// v = ΔN δ f/ΔM, ΔN between the places of the edges, which do not depend on the sense in which they are passed: an axis
/// that trembles on one edge reads zero. Times are known to a tick, so that the error is small at every speed. In `f32`
/// everything is single precision; [`pulse_rate`] is the same in integers.
///
/// **Reading** the mean velocity between the two edges; of a motion that bends, the velocity in the middle differs.
/// **Resolution** v/ΔM. **Delay** half of ΔM plus the age of the last edge, returned with each reading.
/// **Uncertainty** √(s² θ²/6 + 2u²)/Δt: both ends are captured to a tick θ, at speeds of which s, the larger of this mean
/// and the last one plus four increments per interval (what a parabola within one increment has at its ends), is an estimate,
/// and each edge stands where it should to the standard
/// uncertainty u of [`with_edge_uncertainty`](Self::with_edge_uncertainty). Unequal quarters of 10 % are u = 0.07 δ: more
/// than the clock by far. **Zero speed** with no edge in a window the reading is bounded by one increment since the last
/// edge; after the timeout it is zero, and [`ReadingKind`] says so.
/// **Source** `[Ohmae82]`.
///
/// ```
/// use proofmass_core::velocity::{Edge, MixedTime, MixedTimeState};
/// let mt = MixedTime::<f64>::new(0.001, 1e6, 0.1)?;
/// let mut state = MixedTimeState::new(Edge { count: 0, ticks: u32::MAX - 99, upwards: true });
/// let reading = mt.step(&mut state, 1000, Some(Edge { count: 3, ticks: 900, upwards: true }));
/// assert!((reading.velocity - 0.003 / 0.001).abs() < 1e-12); // 1000 ticks across the rollover
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedTime<T> {
    /// δ
    increment: T,
    /// δ f
    rate: T,
    /// 1/f
    tick: T,
    /// 2u²
    edges: T,
    timeout: u32,
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

    /// The last edge.
    pub fn edge(&self) -> Edge {
        self.edge
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
        let increment = positive("increment", increment)?;
        Ok(Self {
            increment: T::from_f64(increment),
            rate: T::from_f64(increment * clock),
            tick: T::from_f64(1.0 / clock),
            edges: T::ZERO,
            timeout: ticks as u32,
        })
    }

    /// Standard uncertainty of the place of an edge, in the unit of the increment; zero until it is said.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where it is negative or not finite.
    pub fn with_edge_uncertainty(self, uncertainty: f64) -> Result<Self, Error> {
        let u = not_negative("uncertainty of an edge", uncertainty)?;
        Ok(Self {
            edges: T::from_f64(2.0 * u * u),
            ..self
        })
    }

    /// Reading at clock `now` from the last edge of the window, `None` when the window had none.
    pub fn step(
        &self,
        state: &mut MixedTimeState<T>,
        now: u32,
        edge: Option<Edge>,
    ) -> PulseReading<T> {
        let half = T::from_f64(0.5);
        let since = now.wrapping_sub(state.edge.ticks);
        if let Some(edge) = edge {
            let interval = edge.ticks.wrapping_sub(state.edge.ticks);
            let age = now.wrapping_sub(edge.ticks);
            let steps = edge.place().wrapping_sub(state.edge.place());
            let first_after_rest = state.kind == ReadingKind::Standstill;
            state.edge = edge;
            if interval > 0 {
                let m = T::from_u32(interval);
                let inverse = T::ONE / m;
                let velocity = T::from_i32(steps) * self.rate * inverse;
                let (fast, last) = (velocity.abs(), state.velocity.abs());
                let speed =
                    if fast > last { fast } else { last } + T::from_f64(4.0) * self.rate * inverse;
                let clock = speed * inverse;
                let place = self.edges * inverse * inverse / (self.tick * self.tick);
                // After a standstill the interval holds the rest as well: the mean is right, its middle is old.
                let spread = if first_after_rest { fast } else { T::ZERO };
                let variance = clock * clock * T::from_f64(1.0 / 6.0) + place + spread * spread;
                state.velocity = velocity;
                state.kind = ReadingKind::Measured;
                return PulseReading {
                    velocity,
                    standard_uncertainty: variance.sqrt(),
                    // A captured tick is on average half a tick late.
                    delay: (half * m + T::from_u32(age) + half) * self.tick,
                    kind: ReadingKind::Measured,
                };
            }
        }
        let elapsed = T::from_u32(since.max(1)) * self.tick;
        let bound = self.increment / elapsed;
        if since >= self.timeout {
            state.kind = ReadingKind::Standstill;
            state.velocity = T::ZERO;
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
            delay: half * elapsed,
            kind: state.kind,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: Edge = Edge {
        count: 0,
        ticks: 0,
        upwards: true,
    };

    /// Edges of an axis as a timer captures them: place, ticks and sense of every crossing.
    fn crossings(x: impl Fn(f64) -> f64, delta: f64, until: f64) -> impl Iterator<Item = Edge> {
        let cell = move |t: f64| (x(t) / delta).floor() as i32;
        let steps = (until / 1e-5) as u32;
        (1..steps).filter_map(move |n| {
            let (a, b) = (1e-5 * f64::from(n - 1), 1e-5 * f64::from(n));
            let (from, to) = (cell(a), cell(b));
            if from == to {
                return None;
            }
            let (mut low, mut high) = (a, b);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if cell(middle) == from {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            // A timer of 1 MHz counts whole ticks.
            Some(Edge {
                count: to,
                ticks: libm::ceil(high * 1e6) as u32,
                upwards: to > from,
            })
        })
    }

    /// Mean velocity between the captured times: place and clock are all that is wrong.
    fn share_inside<T: Float>(x: impl Fn(f64) -> f64 + Copy, unequal: f64, told: f64) -> f64 {
        let delta = 1e-3;
        let mt = MixedTime::<T>::new(delta, 1e6, 1.0)
            .unwrap()
            .with_edge_uncertainty(told)
            .unwrap();
        // Every other edge stands too far: the axis is shown by a scale of its own.
        let bent = move |t: f64| {
            let y = x(t) / delta;
            delta * y + unequal * libm::sin(core::f64::consts::PI * y)
        };
        let mut state = None::<MixedTimeState<T>>;
        let mut last = 0.0;
        let (mut inside, mut all) = (0u32, 0u32);
        for edge in crossings(bent, delta, 4.0) {
            // The true time lies half a tick before the captured one, on average.
            let t = (f64::from(edge.ticks) - 0.5) * 1e-6;
            if let Some(state) = &mut state {
                let reading = mt.step(state, edge.ticks, Some(edge));
                let truth = (x(t) - x(last)) / (t - last);
                if all > 0 {
                    let error = (reading.velocity.to_f64() - truth).abs();
                    inside += u32::from(error <= 1.96 * reading.standard_uncertainty.to_f64());
                }
                all += 1;
            } else {
                state = Some(MixedTimeState::new(edge));
            }
            last = t;
        }
        f64::from(inside) / f64::from(all - 1)
    }

    #[test]
    fn coverage_of_timed_edges_at_reversals() {
        let dither = |t: f64| 1e-3 * (0.1 + 0.7 * libm::sin(44.0 * t));
        let slow = |t: f64| 1e-2 * libm::sin(3.1 * t);
        let fast = |t: f64| 1e-2 * libm::sin(31.0 * t) + 0.02 * t;
        for share in [
            share_inside::<f64>(dither, 0.0, 0.0),
            share_inside::<f64>(slow, 0.0, 0.0),
            share_inside::<f64>(fast, 0.0, 0.0),
        ] {
            assert!(share > 0.94, "{share}");
        }
    }

    #[test]
    fn law_an_axis_that_trembles_on_an_edge_stands() {
        let mt = MixedTime::<f32>::new(1e-3, 1e6, 1.0).unwrap();
        let mut state = MixedTimeState::new(EDGE);
        for n in 1..100 {
            let upwards = n % 2 == 0;
            let edge = Edge {
                count: if upwards { 0 } else { -1 },
                ticks: 10_000 * n,
                upwards,
            };
            assert_eq!(mt.step(&mut state, 10_000 * n, Some(edge)).velocity, 0.0);
        }
    }

    #[test]
    fn law_integers_are_the_same() {
        let mt = MixedTime::<f64>::new(1.0, 1e6, 1.0).unwrap();
        for (steps, ticks) in [(1, 7), (-5, 9_999), (40_000, 1_000_000)] {
            let mut state = MixedTimeState::new(EDGE);
            let edge = Edge {
                count: steps,
                ticks,
                upwards: true,
            };
            let reading = mt.step(&mut state, ticks, Some(edge));
            let rate = pulse_rate(steps, ticks, 1_000_000).unwrap();
            assert!((reading.velocity - rate as f64 / 256.0).abs() < 1.0 / 256.0);
        }
        assert_eq!(pulse_rate(1, 0, 1), None);
        assert_eq!(pulse_rate(i32::MAX, 1, u32::MAX), None);
    }

    #[test]
    fn law_the_three_methods_read_a_constant_velocity_within_their_uncertainty() {
        let (delta, clock, v) = (1e-3, 1e6, 0.7373);
        let m = FixedTime::<f64>::new(delta, 0.01).unwrap();
        let mut ms = FixedTimeState::new(0);
        let mt = MixedTime::<f64>::new(delta, clock, 0.05).unwrap();
        let mut mts = MixedTimeState::new(EDGE);
        let (mut worst_m, mut worst_mt) = (0.0f64, 0.0f64);
        for n in 1..=1000u32 {
            let t = 0.01 * f64::from(n);
            let count = (v * t / delta).floor() as i32;
            let edge = Edge {
                count,
                ticks: (f64::from(count) * delta / v * clock).floor() as u32,
                upwards: true,
            };
            worst_m = worst_m.max((m.step(&mut ms, count) - v).abs());
            let reading = mt.step(&mut mts, (t * clock) as u32, Some(edge));
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
        let mut s = MixedTimeState::new(EDGE);
        mt.step(
            &mut s,
            5_000,
            Some(Edge {
                count: 1,
                ticks: 4_000,
                upwards: true,
            }),
        );
        let first = mt.step(
            &mut s,
            10_000,
            Some(Edge {
                count: 6,
                ticks: 9_000,
                upwards: true,
            }),
        );
        assert_eq!(first.kind, ReadingKind::Measured);
        assert!((first.velocity - 1.0).abs() < 1e-6);
        let bounded = mt.step(&mut s, 29_000, None);
        assert_eq!(bounded.kind, ReadingKind::Bounded);
        assert!((bounded.velocity - 0.05).abs() < 1e-7);
        let still = mt.step(&mut s, 200_000, None);
        assert_eq!((still.kind, still.velocity), (ReadingKind::Standstill, 0.0));
    }

    #[test]
    fn refuses_a_timeout_the_clock_cannot_count() {
        assert!(MixedTime::<f64>::new(1.0, 1e9, 5.0).is_err());
        assert!(FixedTime::<f64>::new(0.0, 1.0).is_err());
        assert!(FixedPosition::<f64>::new(1.0, 0.0).is_err());
    }
}
