//! Response of an oscillator to a step, and to one that takes some time to rise.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// Response of an oscillator to a step, as a share of its final value, t seconds after the step.
///
/// 1 − e^{−ζω t}(cos ω_d t + ζ/√(1 − ζ²) sin ω_d t), ω_d = ω√(1 − ζ²), continued to ζ ≥ 1.
///
/// ```
/// use proofmass_dynamic::step::step_response;
/// assert!((step_response(0.5, 1.0, 0.0) - 2.0).abs() < 1e-12);
/// assert!((step_response(0.25, 1.0, 1.0) - (1.0 - (-1.570_796_3f64).exp() * 2.570_796_3)).abs() < 1e-7);
/// ```
pub fn step_response(t: f64, frequency: f64, damping: f64) -> f64 {
    Oscillator::new(frequency, damping).step(t)
}

/// Response of an oscillator to a step that takes some time, as a share of its final value, t seconds after its middle.
///
/// A rise that is short beside the period, of whatever shape, and a filter behind the device, act by the mean and the variance v of their
/// impulse response: the mean delays, and the variance adds v/2 times the second derivative. Here the rise is straight and takes
/// √(12 v); a negative v, of a filter that overshoots, has the opposite effect.
///
/// ```
/// use proofmass_dynamic::step::{risen_response, step_response};
/// // A rise as long as the period of an undamped oscillator leaves no swing.
/// assert!((risen_response(0.7, 1.0, 0.0, 1.0 / 12.0) - 1.0).abs() < 1e-12);
/// assert_eq!(risen_response(0.7, 1.0, 0.1, 0.0), step_response(0.7, 1.0, 0.1));
/// ```
pub fn risen_response(t: f64, frequency: f64, damping: f64, variance: f64) -> f64 {
    Oscillator::new(frequency, damping).risen(t, variance)
}

/// An oscillator with what does not depend on time.
pub(super) struct Oscillator {
    w: f64,
    damping: f64,
    /// √(1 − ζ²): imaginary above critical damping, so that one formula holds on either side.
    d: Complex64,
    /// Rate of the slowest decay, 1/s.
    slowest: f64,
}

/// e^{−45}: nothing is left of the swing.
const DECAYED: f64 = 45.0;

impl Oscillator {
    pub(super) fn new(frequency: f64, damping: f64) -> Self {
        let w = TAU * frequency;
        let d = Complex64::new(1.0 - damping * damping, 0.0).sqrt();
        Self {
            w,
            damping,
            d,
            slowest: w * (damping - d.im.abs()),
        }
    }

    /// e^{−ζωt} cos ω_d t and e^{−ζωt} sin ω_d t/√(1 − ζ²).
    fn swing(&self, t: f64) -> [f64; 2] {
        if self.slowest * t > DECAYED {
            return [0.0; 2];
        }
        let decay = -self.damping * self.w * t;
        let angle = self.w * t;
        if self.d.im == 0.0 {
            let size = decay.exp();
            let turned = self.d.re * angle;
            let over = match turned.abs() < 1e-4 {
                true => angle,
                false => turned.sin() / self.d.re,
            };
            return [size * turned.cos(), size * over];
        }
        // e^{−ζωt} cosh overflows before it decays: the two exponentials are taken apart.
        let turned = self.d.im.abs() * angle;
        let (slow, fast) = ((decay + turned).exp(), (decay - turned).exp());
        let over = match turned < 1e-4 {
            true => angle * decay.exp(),
            false => 0.5 * (slow - fast) / self.d.im.abs(),
        };
        [0.5 * (slow + fast), over]
    }

    pub(super) fn step(&self, t: f64) -> f64 {
        if t <= 0.0 {
            return 0.0;
        }
        let [cosine, sine] = self.swing(t);
        1.0 - (cosine + self.damping * sine)
    }

    pub(super) fn risen(&self, t: f64, variance: f64) -> f64 {
        // Differences of integrals lose their digits there, and the second derivative is enough.
        if variance.abs() * self.w * self.w < 1e-8 {
            if t <= 0.0 {
                return 0.0;
            }
            let [cosine, sine] = self.swing(t);
            let second = self.w * self.w * (cosine - self.damping * sine);
            return 1.0 - (cosine + self.damping * sine) + 0.5 * variance * second;
        }
        let rise = (12.0 * variance.abs()).sqrt();
        if t <= -0.5 * rise {
            return 0.0;
        }
        if self.slowest * (t - 0.5 * rise) > DECAYED {
            return 1.0;
        }
        let straight = (self.integral(t + 0.5 * rise) - self.integral(t - 0.5 * rise)) / rise;
        match variance > 0.0 {
            true => straight,
            false => 2.0 * self.step(t) - straight,
        }
    }

    /// Of the step response: t − (h′ + 2ζω h)/ω², from its differential equation.
    fn integral(&self, t: f64) -> f64 {
        if t <= 0.0 {
            return 0.0;
        }
        let [cosine, sine] = self.swing(t);
        let step = 1.0 - (cosine + self.damping * sine);
        t - (sine + 2.0 * self.damping * step) / self.w
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosscheck_a_rise_is_the_mean_of_steps() {
        // Midpoints of 4000 steps: their mean is off by the jump of the slope over 4000², 1e-7.
        for damping in [0.0, 0.05, 0.7, 1.0, 1.0 + 1e-9, 3.0] {
            for (t, rise) in [
                (-0.1, 0.3),
                (0.05, 0.3),
                (0.4, 0.3),
                (3.0, 0.02),
                (9.0, 1.0),
            ] {
                let mean = (0..4000)
                    .map(|k| t - rise * ((f64::from(k) + 0.5) / 4000.0 - 0.5))
                    .map(|t| step_response(t, 1.0, damping))
                    .sum::<f64>()
                    / 4000.0;
                let risen = risen_response(t, 1.0, damping, rise * rise / 12.0);
                assert!(
                    (risen - mean).abs() < 1e-6,
                    "{damping} {t} {rise}: {risen} {mean}"
                );
            }
        }
    }

    #[test]
    fn law_short_rises_join_without_a_step() {
        for damping in [0.02, 0.5, 1.5] {
            for sign in [-1.0, 1.0] {
                let v = sign * 1e-8 / TAU.powi(2);
                let [below, above] =
                    [0.999, 1.001].map(|s| risen_response(0.3, 1.0, damping, s * v));
                assert!((below - above).abs() < 1e-10, "{damping} {sign}");
            }
        }
    }
}
