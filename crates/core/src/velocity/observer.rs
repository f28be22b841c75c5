//! The velocity observer: acceleration as input, position as feedback; and the tracking loop without acceleration.

use super::{not_negative, positive};
use crate::{Error, Float};

/// x̂' = v̂ + k_x (p − x̂), v̂' = a − b̂ + k_v (p − x̂), b̂' = −k_b (p − x̂).
///
/// V̂ = [(s + k_x) A + k_v s P]/(s² + k_x s + k_v) for k_b = 0 (second order). The third order estimates the
/// accelerometer's offset b̂. Discretised by Tustin: the implicit equation has one unknown, p − x̂, and is solved
/// exactly.
///
/// **Delay** none. **Steady-state error** for an offset b: b k_x/k_v in the second order, zero in the third.
/// **Source** `[ZhuLamarche07]`.
///
/// ```
/// use proofmass_core::velocity::{Observer, ObserverState};
/// let observer = Observer::<f64>::new(5.0, 25.0, 0.001)?;
/// let mut state = ObserverState::new(0.0, 0.0, 0.0);
/// let mut v = 0.0;
/// for _ in 0..20_000 { v = observer.step(&mut state, 0.0, 0.5); } // at rest, offset 0.5
/// assert!((v - 0.5 * 5.0 / 25.0).abs() < 1e-12);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("Luenberger observer"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer<T> {
    k_x: T,
    k_v: T,
    k_b: T,
    h: T,
    inverse: T,
}

/// Memory of an [`Observer`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ObserverState<T> {
    /// Position x̂.
    pub position: T,
    /// Velocity v̂.
    pub velocity: T,
    /// Offset b̂ of the accelerometer; zero in the second order.
    pub offset: T,
    error: T,
    acceleration: T,
}

impl<T: Float> ObserverState<T> {
    /// Starts from the readings of the first sample and the velocity at that time.
    pub fn new(position: T, velocity: T, acceleration: T) -> Self {
        Self {
            position,
            velocity,
            offset: T::ZERO,
            error: T::ZERO,
            acceleration,
        }
    }

    /// Moves the estimate; the feedback of the next step sees it.
    pub(super) fn shift(&mut self, position: T, velocity: T) {
        self.position += position;
        self.velocity += velocity;
        self.error -= position;
    }
}

impl<T: Float> Observer<T> {
    /// Second order: k_x in 1/s, k_v in 1/s². Damping k_x/(2√k_v), natural frequency √k_v rad/s.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a gain or sample time that is not positive.
    pub fn new(k_x: f64, k_v: f64, sample_time: f64) -> Result<Self, Error> {
        Self::with_offset(k_x, k_v, 0.0, sample_time)
    }

    /// Third order, k_b in 1/s³: characteristic polynomial s³ + k_x s² + k_v s + k_b.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for gains that do not give a stable loop (k_b ≥ k_x k_v) or a sample time that is
    /// not positive.
    pub fn with_offset(k_x: f64, k_v: f64, k_b: f64, sample_time: f64) -> Result<Self, Error> {
        positive("k_x", k_x)?;
        positive("k_v", k_v)?;
        not_negative("k_b", k_b)?;
        let h = 0.5 * positive("sample time", sample_time)?;
        if k_b >= k_x * k_v {
            return Err(Error::OutOfRange {
                name: "k_b",
                value: k_b,
                min: 0.0,
                max: k_x * k_v,
            });
        }
        Ok(Self {
            k_x: T::from_f64(k_x),
            k_v: T::from_f64(k_v),
            k_b: T::from_f64(k_b),
            h: T::from_f64(h),
            inverse: T::from_f64(1.0 / (1.0 + h * (k_x + h * (k_v + h * k_b)))),
        })
    }

    /// From exported coefficients: k_x, k_v, k_b, half the sample time h, and 1/(1 + h (k_x + h (k_v + h k_b))).
    pub const fn constant(coefficients: [T; 5]) -> Self {
        let [k_x, k_v, k_b, h, inverse] = coefficients;
        Self {
            k_x,
            k_v,
            k_b,
            h,
            inverse,
        }
    }

    /// The coefficients as [`Observer::constant`] takes them.
    pub fn coefficients(&self) -> [T; 5] {
        [self.k_x, self.k_v, self.k_b, self.h, self.inverse]
    }

    /// Velocity at the time of these readings.
    pub fn step(&self, state: &mut ObserverState<T>, position: T, acceleration: T) -> T {
        self.step_by(state, acceleration, |predicted| position - predicted)
    }

    /// The same from a sensor that tells a difference: by how much the axis is beyond the position it is given.
    ///
    /// The phase detector of a resolver is one, or a difference of angles wrapped into half a turn.
    pub fn step_by(
        &self,
        state: &mut ObserverState<T>,
        acceleration: T,
        beyond: impl FnOnce(T) -> T,
    ) -> T {
        let Self {
            k_x,
            k_v,
            k_b,
            h,
            inverse,
        } = *self;
        let e = state.error;
        let input = acceleration + state.acceleration;
        // The three trapezoids without the new error, then the new error from the position equation.
        let b = state.offset - h * k_b * e;
        let v = state.velocity + h * (input - b - state.offset + k_v * e);
        let x = state.position + h * (v + state.velocity + k_x * e);
        let difference = beyond(x);
        let error = inverse * difference;
        let offset = b - h * k_b * error;
        let velocity = v + h * (k_v * error + h * k_b * error);
        *state = ObserverState {
            position: x + (difference - error),
            velocity,
            offset,
            error,
            acceleration,
        };
        velocity
    }

    /// Velocity where no position came: on the acceleration alone.
    pub fn predict(&self, state: &mut ObserverState<T>, acceleration: T) -> T {
        let input = acceleration + state.acceleration - state.offset - state.offset;
        let velocity = state.velocity + self.h * input;
        state.position += self.h * (velocity + state.velocity);
        state.velocity = velocity;
        state.error = T::ZERO;
        state.acceleration = acceleration;
        velocity
    }

    /// The same observer for the time that passed since the last sample, where samples do not come evenly.
    ///
    /// One division; a time that is not positive gives an observer that stands still.
    #[must_use]
    pub fn after(&self, time: T) -> Self {
        let h = T::from_f64(0.5) * if time > T::ZERO { time } else { T::ZERO };
        Self {
            h,
            inverse: T::ONE / (T::ONE + h * (self.k_x + h * (self.k_v + h * self.k_b))),
            ..*self
        }
    }

    /// Position error p − x̂ after the last sample.
    pub(super) fn error(state: &ObserverState<T>) -> T {
        state.error
    }
}

/// Velocity from position by a second-order tracking loop with K_p = 2b, K_i = b²: the common firmware choice.
///
/// ω̂ = b² s Θ/(s + b)²: the [`Observer`] without an accelerometer, critically damped.
///
/// **Delay** 2/b. **Steady-state error** zero at constant velocity, 2a/b under constant acceleration a.
///
/// ```
/// use proofmass_core::velocity::{ObserverState, TrackingLoop};
/// let pll = TrackingLoop::<f64>::new(100.0, 0.001)?;
/// let mut state = ObserverState::new(0.0, 0.0, 0.0);
/// let mut w = 0.0;
/// for n in 1..=1000 { w = pll.step(&mut state, 3.0 * 0.001 * n as f64); }
/// assert!((w - 3.0).abs() < 1e-12);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingLoop<T> {
    observer: Observer<T>,
    bandwidth: f64,
}

impl<T: Float> TrackingLoop<T> {
    /// Bandwidth b in rad/s.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a bandwidth or sample time that is not positive.
    pub fn new(bandwidth: f64, sample_time: f64) -> Result<Self, Error> {
        Ok(Self {
            observer: Observer::new(2.0 * bandwidth, bandwidth * bandwidth, sample_time)?,
            bandwidth,
        })
    }

    /// Velocity at the time of this position.
    pub fn step(&self, state: &mut ObserverState<T>, position: T) -> T {
        self.observer.step(state, position, T::ZERO)
    }

    /// The observer it is.
    pub fn observer(&self) -> &Observer<T> {
        &self.observer
    }

    /// The same loop for the time that passed since the last sample, where samples do not come evenly.
    #[must_use]
    pub fn after(&self, time: T) -> Self {
        Self {
            observer: self.observer.after(time),
            bandwidth: self.bandwidth,
        }
    }

    /// Delay of a slow motion, 2/b, in seconds.
    pub fn delay(&self) -> f64 {
        2.0 / self.bandwidth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_constant_acceleration_with_both_sensors_is_exact() {
        for k_b in [0.0, 20.0] {
            let observer = Observer::<f64>::with_offset(5.0, 25.0, k_b, 0.01).unwrap();
            let mut state = ObserverState::new(1.0, -2.0, 3.0);
            for n in 1..2000 {
                let t = 0.01 * n as f64;
                let v = observer.step(&mut state, 1.0 - 2.0 * t + 1.5 * t * t, 3.0);
                assert!((v - (3.0 * t - 2.0)).abs() < 1e-9, "{n}");
            }
        }
    }

    #[test]
    fn law_third_order_finds_the_offset() {
        let observer = Observer::<f64>::with_offset(15.0, 75.0, 125.0, 0.001).unwrap();
        let mut state = ObserverState::new(0.0, 0.0, 0.2);
        let mut v = 1.0;
        for _ in 0..10_000 {
            v = observer.step(&mut state, 0.0, 0.2);
        }
        assert!(v.abs() < 1e-9);
        assert!((state.offset - 0.2).abs() < 1e-9);
    }

    #[test]
    fn law_tracking_loop_lags_by_two_over_b() {
        let (b, a) = (50.0, 4.0);
        let pll = TrackingLoop::<f64>::new(b, 1e-3).unwrap();
        let mut state = ObserverState::new(0.0, 0.0, 0.0);
        let mut w = 0.0;
        for n in 1..=2000 {
            let t = 1e-3 * n as f64;
            w = pll.step(&mut state, 0.5 * a * t * t);
        }
        assert!((a * 2.0 - w - 2.0 * a / b).abs() < 1e-9);
        assert!((pll.delay() - 0.04).abs() < 1e-15);
    }

    #[test]
    fn law_single_precision_follows_double() {
        let (d, s) = (
            Observer::<f64>::new(10.0, 100.0, 1e-3).unwrap(),
            Observer::<f32>::new(10.0, 100.0, 1e-3).unwrap(),
        );
        let (mut sd, mut ss) = (
            ObserverState::new(0.0, 1.0, 0.0),
            ObserverState::new(0.0f32, 1.0, 0.0),
        );
        for n in 1..20_000 {
            let t = 1e-3 * n as f64;
            let (x, a) = (t.sin(), -t.sin());
            let v = d.step(&mut sd, x, a);
            let w = s.step(&mut ss, x as f32, a as f32);
            // Rounding of the position (6e-8) through the loop's gain at its crossover (10 1/s), with margin.
            assert!((v - f64::from(w)).abs() < 2e-5, "{n}");
        }
    }

    #[test]
    fn law_uneven_samples_of_a_parabola_are_exact() {
        let observer = Observer::<f64>::new(10.0, 100.0, 0.01).unwrap();
        let mut state = ObserverState::new(1.0, -2.0, 3.0);
        let mut t = 0.0;
        for n in 1..2000 {
            let step = 0.004 + 0.001 * f64::from((n * 7) % 13);
            t += step;
            let v = observer
                .after(step)
                .step(&mut state, 1.0 - 2.0 * t + 1.5 * t * t, 3.0);
            assert!((v - (3.0 * t - 2.0)).abs() < 1e-9, "{n}");
        }
        // And where positions are missing.
        for _ in 0..50 {
            t += 0.01;
            let v = observer.predict(&mut state, 3.0);
            assert!((v - (3.0 * t - 2.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn refuses_unstable_gains() {
        assert!(Observer::<f64>::with_offset(1.0, 1.0, 1.0, 0.1).is_err());
        assert!(Observer::<f64>::new(0.0, 1.0, 0.1).is_err());
        assert!(TrackingLoop::<f64>::new(-1.0, 0.1).is_err());
    }
}
