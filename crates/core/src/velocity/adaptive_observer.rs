//! The observer that also learns the accelerometer's gain.

use super::positive;
use crate::{Error, Float, velocity::Observer, velocity::ObserverState};

/// v̂' = ĝ a + k_v (p − x̂) with a gain ĝ that is learnt while the axis moves.
///
/// The sensitivity Υ of the state to the gain runs through the observer's own error dynamics
/// (υ_x' = υ_v − k_x υ_x, υ_v' = a − k_v υ_x); the gain follows ĝ' = μ υ_x (p − x̂)/(c² + υ_x²) and the state is
/// moved along Υ with it. Without motion υ_x is zero and the gain stays.
///
/// **Assumes** an accelerometer without offset (an offset acts as a gain error of sign a). μ well below k_x.
/// **Delay** none. **Steady-state error** as the second-order observer.
/// **Source** `[Zhang02]` for the structure and its exponential convergence; the adaptation of `[ZhuLamarche07]` is
/// another law for the same purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveObserver<T> {
    observer: Observer<T>,
    step: T,
    floor: T,
}

/// Memory of an [`AdaptiveObserver`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveObserverState<T> {
    /// Position and velocity.
    pub(crate) motion: ObserverState<T>,
    /// Learnt factor ĝ on the accelerometer's reading; starts at one.
    pub(crate) gain: T,
    sensitivity: ObserverState<T>,
}

impl<T: Float> AdaptiveObserverState<T> {
    /// Starts from the readings of the first sample and the velocity at that time.
    pub fn new(position: T, velocity: T, acceleration: T) -> Self {
        Self {
            motion: ObserverState::new(position, velocity, acceleration),
            gain: T::ONE,
            sensitivity: ObserverState::new(T::ZERO, T::ZERO, acceleration),
        }
    }
}

impl<T: Float> AdaptiveObserver<T> {
    /// Observer gains, adaptation rate μ in 1/s, and the position c below which a sensitivity does not count
    /// (the encoder's increment is a good choice).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for any value that is not positive.
    pub fn new(k_x: f64, k_v: f64, rate: f64, floor: f64, sample_time: f64) -> Result<Self, Error> {
        let observer = Observer::new(k_x, k_v, sample_time)?;
        let step = positive("rate", rate)? * sample_time;
        let floor = positive("floor", floor)?;
        Ok(Self {
            observer,
            step: T::from_f64(step),
            floor: T::from_f64(floor * floor),
        })
    }

    /// Velocity where no position came: on the acceleration times the learnt gain, which stays as it is.
    pub fn predict(&self, state: &mut AdaptiveObserverState<T>, acceleration: T) -> T {
        self.observer.predict(&mut state.sensitivity, acceleration);
        self.observer
            .predict(&mut state.motion, state.gain * acceleration)
    }

    /// Velocity at the time of these readings.
    pub fn step(&self, state: &mut AdaptiveObserverState<T>, position: T, acceleration: T) -> T {
        self.observer
            .step(&mut state.motion, position, state.gain * acceleration);
        // The same observer with a position of zero is the sensitivity: its error is p − x̂ with p = 0.
        self.observer
            .step(&mut state.sensitivity, T::ZERO, acceleration);
        let (ux, uv) = (state.sensitivity.position, state.sensitivity.velocity);
        let e = Observer::error(&state.motion);
        let change = self.step * ux * e / (self.floor + ux * ux);
        state.gain += change;
        state.motion.shift(ux * change, uv * change);
        state.motion.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_gain_is_learnt_and_the_velocity_becomes_right() {
        let (dt, w) = (1e-3, 30.0);
        let adaptive = AdaptiveObserver::<f64>::new(10.0, 100.0, 1.0, 1e-4, dt).unwrap();
        let plain = Observer::<f64>::new(10.0, 100.0, dt).unwrap();
        // The accelerometer reads 8 % low: the factor to learn is 1/0.92.
        let (mut s, mut p) = (
            AdaptiveObserverState::new(0.0, 1.0, 0.0),
            ObserverState::new(0.0, 1.0, 0.0),
        );
        let (mut worst, mut worst_plain) = (0.0f64, 0.0f64);
        for n in 1..=30_000 {
            let t = dt * n as f64;
            let (x, v, a) = ((w * t).sin() / w, (w * t).cos(), -0.92 * w * (w * t).sin());
            let e = adaptive.step(&mut s, x, a) - v;
            let f = plain.step(&mut p, x, a) - v;
            if n > 25_000 {
                worst = worst.max(e.abs());
                worst_plain = worst_plain.max(f.abs());
            }
        }
        // Tustin's warp at ωT = 0.03 is (ωT)²/12 = 7.5e-5 of the gain.
        assert!((s.gain * 0.92 - 1.0).abs() < 2e-4, "{}", s.gain);
        assert!(worst < 2e-4 && worst_plain > 0.05, "{worst} {worst_plain}");
    }

    #[test]
    fn law_gain_rests_when_the_axis_rests() {
        let adaptive = AdaptiveObserver::<f32>::new(10.0, 100.0, 1.0, 1e-3, 1e-3).unwrap();
        let mut s = AdaptiveObserverState::new(3.0, 0.0, 0.0);
        for _ in 0..10_000 {
            adaptive.step(&mut s, 3.0, 0.0);
        }
        assert_eq!(s.gain, 1.0);
    }
}
