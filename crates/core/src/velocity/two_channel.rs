//! The two channels of Zhu and Lamarche: encoder below a crossover, accelerometer above it.

use super::{not_negative, positive};
use crate::{Error, Float};

/// V̂ = s/(s + k₁) · 1/(s + k₂) · A + W_e(s) · s P with W_e = ((k₁ + k₂)s + k₁k₂)/((s + k₁)(s + k₂)).
///
/// W_e = 1 − s²/((s + k₁)(s + k₂)) is exactly complementary: perfect sensors give the true velocity at every
/// frequency. k₂ is the crossover in rad/s; a small k₁ > 0 removes the accelerometer's offset.
///
/// Discretised by Tustin on the states (V, z): V' = A + αP' − αV + z, z' = βP' − βV with α = k₁ + k₂, β = k₁k₂.
/// Only increments of the position enter, so that a large position costs no digits.
///
/// **Delay** none. **Steady-state error** for an accelerometer offset b: zero for k₁ > 0 (after some 3/k₁),
/// b/k₂ for k₁ = 0. **Source** `[ZhuLamarche07]`.
///
/// ```
/// use proofmass_core::velocity::{TwoChannel, TwoChannelState};
/// let filter = TwoChannel::<f64>::new(0.0, 10.0, 0.001)?;
/// let mut state = TwoChannelState::new(0.0, 0.0, 0.0);
/// let mut v = 0.0;
/// for _ in 0..5000 { v = filter.step(&mut state, 0.0, 0.5); } // at rest, offset 0.5
/// assert!((v - 0.05).abs() < 1e-12); // offset / k₂
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("complementary filter", "sensor fusion"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoChannel<T> {
    alpha: T,
    beta: T,
    h: T,
    inverse: T,
}

/// Memory of [`TwoChannel`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoChannelState<T> {
    position: T,
    acceleration: T,
    velocity: T,
    z: T,
}

impl<T: Float> TwoChannelState<T> {
    /// Starts from the readings of the first sample and the velocity at that time.
    pub fn new(position: T, velocity: T, acceleration: T) -> Self {
        Self {
            position,
            acceleration,
            velocity,
            z: T::ZERO,
        }
    }
}

impl<T: Float> TwoChannel<T> {
    /// k₁ and k₂ in rad/s.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for k₁ < 0, k₂ ≤ 0 or a sample time that is not positive.
    pub fn new(k1: f64, k2: f64, sample_time: f64) -> Result<Self, Error> {
        let k1 = not_negative("k1", k1)?;
        let k2 = positive("k2", k2)?;
        let h = 0.5 * positive("sample time", sample_time)?;
        let (alpha, beta) = (k1 + k2, k1 * k2);
        Ok(Self {
            alpha: T::from_f64(alpha),
            beta: T::from_f64(beta),
            h: T::from_f64(h),
            inverse: T::from_f64(1.0 / (1.0 + h * alpha + h * h * beta)),
        })
    }

    /// The same filter for the time that passed since the last sample, where samples do not come evenly.
    #[must_use]
    pub fn after(&self, time: T) -> Self {
        let h = T::from_f64(0.5) * if time > T::ZERO { time } else { T::ZERO };
        Self {
            h,
            inverse: T::ONE / (T::ONE + h * (self.alpha + h * self.beta)),
            ..*self
        }
    }

    /// Velocity where no position came: on the acceleration, as if the position had gone with it.
    pub fn predict(&self, state: &mut TwoChannelState<T>, acceleration: T) -> T {
        let velocity = state.velocity + self.h * (acceleration + state.acceleration);
        state.position += self.h * (velocity + state.velocity);
        state.velocity = velocity;
        state.acceleration = acceleration;
        velocity
    }

    /// Moves the zero of the positions.
    pub(super) fn rebase(state: &mut TwoChannelState<T>, by: T) {
        state.position -= by;
    }

    /// From exported coefficients: k₁ + k₂, k₁ k₂, half the sample time h, and 1/(1 + h (k₁ + k₂) + h² k₁ k₂).
    pub const fn constant(coefficients: [T; 4]) -> Self {
        let [alpha, beta, h, inverse] = coefficients;
        Self {
            alpha,
            beta,
            h,
            inverse,
        }
    }

    /// The coefficients as [`TwoChannel::constant`] takes them.
    pub fn coefficients(&self) -> [T; 4] {
        [self.alpha, self.beta, self.h, self.inverse]
    }

    /// Velocity at the time of these readings.
    pub fn step(&self, state: &mut TwoChannelState<T>, position: T, acceleration: T) -> T {
        let Self {
            alpha,
            beta,
            h,
            inverse,
        } = *self;
        let step = position - state.position;
        let v = state.velocity;
        let z0 = state.z + beta * (step - h * v);
        let drive = acceleration + state.acceleration - alpha * v + z0 + state.z;
        let velocity = inverse * (v + alpha * step + h * drive);
        *state = TwoChannelState {
            position,
            acceleration,
            velocity,
            z: z0 - beta * h * velocity,
        };
        velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sinusoid through the filter with either channel alone: complex gain on the true velocity.
    fn response(
        filter: &TwoChannel<f64>,
        dt: f64,
        w: f64,
        encoder: bool,
        accel: bool,
    ) -> (f64, f64) {
        let mut state = TwoChannelState::new(if encoder { 1.0 / w } else { 0.0 }, 0.0, 0.0);
        let period = (core::f64::consts::TAU / (w * dt)).round() as usize;
        let (mut re, mut im) = (0.0, 0.0);
        for n in 1..=(400 * period) {
            let angle = w * dt * n as f64;
            // v = sin, x = −cos/ω, a = ω cos
            let x = if encoder { -angle.cos() / w } else { 0.0 };
            let a = if accel { w * angle.cos() } else { 0.0 };
            let v = filter.step(&mut state, x, a);
            if n > 300 * period {
                re += v * angle.sin();
                im += v * angle.cos();
            }
        }
        let scale = 2.0 / (100 * period) as f64;
        (re * scale, im * scale)
    }

    #[test]
    fn law_channels_are_complementary_and_match_the_transfer_functions() {
        let (k1, k2, dt) = (0.5, 10.0, 1e-3);
        let filter = TwoChannel::<f64>::new(k1, k2, dt).unwrap();
        for w in [1.0, 10.0, 100.0].map(|w: f64| {
            core::f64::consts::TAU / ((core::f64::consts::TAU / (w * dt)).round() * dt)
        }) {
            let (re, im) = response(&filter, dt, w, true, true);
            // Tustin warps: x and a of a sinusoid obey the trapezoid to (ωT)²/12.
            let warp = (w * dt).powi(2) / 6.0;
            assert!(
                (re - 1.0).abs() < warp + 1e-9 && im.abs() < warp + 1e-9,
                "{w}: {re} {im}"
            );
            // Accelerometer channel: s²/((s+k1)(s+k2)) of the true velocity.
            let (re, im) = response(&filter, dt, w, false, true);
            let gain = w * w / ((w * w + k1 * k1).sqrt() * (w * w + k2 * k2).sqrt());
            assert!((re.hypot(im) - gain).abs() < warp + 1e-6, "{w}");
        }
    }

    #[test]
    fn law_offset_error_is_offset_over_k2_and_zero_with_k1() {
        for (k1, expected) in [(0.0, 0.01), (0.5, 0.0)] {
            let filter = TwoChannel::<f32>::new(k1, 10.0, 0.001).unwrap();
            let mut state = TwoChannelState::new(5.0, 0.0, 0.1);
            let mut v = 0.0;
            for _ in 0..40_000 {
                v = filter.step(&mut state, 5.0, 0.1);
            }
            assert!((v - expected).abs() < 2e-6, "{k1}: {v}");
        }
    }

    #[test]
    fn refuses_wrong_gains() {
        assert!(TwoChannel::<f64>::new(-1.0, 1.0, 0.1).is_err());
        assert!(TwoChannel::<f64>::new(0.0, 0.0, 0.1).is_err());
        assert!(TwoChannel::<f64>::new(0.0, 1.0, f64::INFINITY).is_err());
    }
}
