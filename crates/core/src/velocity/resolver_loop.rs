//! A tracking loop on the voltages of a resolver.

use super::{Observer, ObserverState};
use crate::encoder::resolver_error;
use crate::{Error, Float};

/// Angle and velocity from the demodulated voltages V sin θ and V cos θ, by an [`Observer`] whose error is the phase detector
/// sin(θ − θ̂): no arc tangent, and no place where the angle begins anew.
///
/// The error is divided by the amplitude, so that the bandwidth does not follow the excitation. Below a third of the nominal
/// amplitude (a broken winding) the loop coasts and says so. With an accelerometer the loop is the observer of both sensors.
///
/// **Delay** 2/b of a velocity that changes, as the tracking loop; none with an accelerometer. **Steady-state error** as the
/// [`Observer`]. **Capture** from a start that is half a turn off the loop leaves slowly: start from
/// [`resolver_angle`](crate::encoder::resolver_angle).
///
/// ```
/// use proofmass_core::velocity::ResolverLoop;
/// let resolver = ResolverLoop::<f32>::tracking(200.0, 2.0, 1e-4)?;
/// let mut state = resolver.start(0.0);
/// let mut v = 0.0;
/// for n in 1..=5000 {
///     let angle = 300.0 * 1e-4 * n as f32;
///     v = resolver.step(&mut state, 2.0 * angle.sin(), 2.0 * angle.cos(), 0.0).velocity;
/// }
/// assert!((v - 300.0).abs() < 0.05);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolverLoop<T> {
    observer: Observer<T>,
    /// Square of the least amplitude.
    least: T,
    pi: T,
    turn: T,
}

/// What a [`ResolverLoop`] says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResolverReading<T> {
    /// Angle, −π…π.
    pub angle: T,
    /// rad/s
    pub velocity: T,
    /// Amplitude of the voltages.
    pub amplitude: T,
    /// Whether there was a signal; without one the loop coasts.
    pub signal: bool,
}

impl<T: Float> ResolverLoop<T> {
    /// A tracking loop of bandwidth b in rad/s for a nominal amplitude, in the unit of the voltages.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a bandwidth, an amplitude or a sample time that is not positive.
    pub fn tracking(bandwidth: f64, amplitude: f64, sample_time: f64) -> Result<Self, Error> {
        let observer = Observer::new(2.0 * bandwidth, bandwidth * bandwidth, sample_time)?;
        Self::new(observer, amplitude)
    }

    /// With the gains of an observer, as beside an accelerometer.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an amplitude that is not positive.
    pub fn new(observer: Observer<T>, amplitude: f64) -> Result<Self, Error> {
        let least = super::positive("amplitude of the resolver", amplitude)? / 3.0;
        Ok(Self {
            observer,
            least: T::from_f64(least * least),
            pi: T::from_f64(core::f64::consts::PI),
            turn: T::from_f64(core::f64::consts::TAU),
        })
    }

    /// At rest at an angle.
    pub fn start(&self, angle: T) -> ObserverState<T> {
        ObserverState::new(angle, T::ZERO, T::ZERO)
    }

    /// Angle and velocity at the time of these voltages; the acceleration is angular, zero without an accelerometer.
    pub fn step(
        &self,
        state: &mut ObserverState<T>,
        sine: T,
        cosine: T,
        acceleration: T,
    ) -> ResolverReading<T> {
        let square = sine * sine + cosine * cosine;
        let signal = square >= self.least && square.is_finite();
        let amplitude = if square.is_finite() {
            square.sqrt()
        } else {
            T::ZERO
        };
        let velocity = if signal {
            let inverse = T::ONE / amplitude;
            self.observer.step_by(state, acceleration, |predicted| {
                inverse * resolver_error(sine, cosine, predicted)
            })
        } else {
            self.observer.predict(state, acceleration)
        };
        // One turn less where there is one: the angle never grows, and the error does not feel it.
        if state.position > self.pi {
            state.position -= self.turn;
        } else if state.position < -self.pi {
            state.position += self.turn;
        }
        ResolverReading {
            angle: state.position,
            velocity,
            amplitude,
            signal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosscheck_the_loop_on_unwrapped_angles() {
        let dt = 1e-4;
        let resolver = ResolverLoop::<f64>::tracking(300.0, 1.0, dt).unwrap();
        let plain = super::super::TrackingLoop::<f64>::new(300.0, dt).unwrap();
        let (mut a, mut b) = (resolver.start(0.0), ObserverState::new(0.0, 0.0, 0.0));
        for n in 1..50_000 {
            let t = dt * f64::from(n);
            let angle = 50.0 * libm::sin(2.0 * t);
            let reading =
                resolver.step(&mut a, 0.8 * libm::sin(angle), 0.8 * libm::cos(angle), 0.0);
            let v = plain.step(&mut b, angle);
            // Thirty time constants after a start at 100 rad/s; sin e is e less e³/6, and the lag a/b² is 2 mrad here.
            assert!(n < 1000 || (reading.velocity - v).abs() < 1e-3, "{n}");
            assert!(reading.angle.abs() <= 3.2 && (reading.amplitude - 0.8).abs() < 1e-12);
        }
    }

    #[test]
    fn law_without_a_signal_it_coasts() {
        let resolver = ResolverLoop::<f32>::tracking(100.0, 1.0, 1e-3).unwrap();
        let mut state = resolver.start(0.0);
        let at = |n: i32| (0.05 * n as f32).sin_cos();
        for n in 1..=2000 {
            let (sine, cosine) = at(n);
            resolver.step(&mut state, sine, cosine, 0.0);
        }
        for voltage in [0.0, 0.1, f32::NAN, f32::INFINITY] {
            let reading = resolver.step(&mut state, voltage, voltage, 0.0);
            assert!(
                !reading.signal && (reading.velocity - 50.0).abs() < 0.1,
                "{reading:?}"
            );
            assert!(reading.angle.is_finite() && reading.amplitude.is_finite());
        }
        for n in 2005..=3000 {
            let (sine, cosine) = at(n);
            let reading = resolver.step(&mut state, sine, cosine, 0.0);
            assert!((reading.velocity - 50.0).abs() < 0.2, "{reading:?}");
        }
        assert!(ResolverLoop::<f32>::tracking(100.0, 0.0, 1e-3).is_err());
        assert!(ResolverLoop::<f32>::tracking(f64::NAN, 1.0, 1e-3).is_err());
    }
}
