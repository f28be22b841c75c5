//! Low-pass filters against noise: second-order Butterworth and moving average, designed once, run anywhere.

use crate::{Error, Float, check};

/// Second-order Butterworth low-pass, by the bilinear transform with its corner where it is asked for.
///
/// ```text
/// H(z) = (β₀ + β₁ z⁻¹ + β₂ z⁻²)/(1 + α₁ z⁻¹ + α₂ z⁻²),  w = tan(π f_c T),  n = 1 + √2 w + w²
/// β₀ = β₂ = w²/n,  β₁ = 2 w²/n,  α₁ = 2 (w² − 1)/n,  α₂ = (1 − √2 w + w²)/n
/// ```
///
/// **Delay** at low frequency [`Butterworth::group_delay`] samples, about √2/(2π f_c) = 0.225/f_c seconds.
/// **Accuracy** unit gain at zero frequency, −3.01 dB at f_c (`known_corner_and_delay`).
/// **Source** `[OppenheimSchafer2010]` 7.3.
///
/// ```
/// use proofmass_core::{Butterworth, LowPassState};
/// let filter = Butterworth::<f32>::new(50.0, 1000.0)?;
/// let mut state = LowPassState::at(9.8);
/// assert!((filter.step(&mut state, 9.8) - 9.8).abs() < 1e-5); // begins where it is, without a transient
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("IIR", "biquad"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Butterworth<F> {
    /// β₀, β₁, β₂.
    pub numerator: [F; 3],
    /// α₁, α₂.
    pub denominator: [F; 2],
}

/// The last two inputs and outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassState<F> {
    input: [F; 2],
    output: [F; 2],
}

impl<F: Float> LowPassState<F> {
    /// As after a long time at one value.
    pub fn at(value: F) -> Self {
        Self {
            input: [value; 2],
            output: [value; 2],
        }
    }
}

impl<F: Float> Butterworth<F> {
    /// Corner frequency and sampling rate in Hz.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the corner lies between a 10⁻⁴ and 0.49 of the rate: below, single precision has no
    /// digits left for it.
    pub fn new(corner: f64, rate: f64) -> Result<Self, Error> {
        check::positive("sampling rate, Hz", rate)?;
        if !(corner >= 1e-4 * rate && corner <= 0.49 * rate) {
            return Err(Error::OutOfRange {
                name: "corner frequency, Hz",
                value: corner,
                min: 1e-4 * rate,
                max: 0.49 * rate,
            });
        }
        let w = libm::tan(core::f64::consts::PI * corner / rate);
        let root = core::f64::consts::SQRT_2 * w;
        let n = 1.0 + root + w * w;
        let of = |v: f64| F::from_f64(v / n);
        Ok(Self {
            numerator: [of(w * w), of(2.0 * w * w), of(w * w)],
            denominator: [of(2.0 * (w * w - 1.0)), of(1.0 - root + w * w)],
        })
    }

    /// From exported coefficients: nothing is computed and nothing is checked.
    pub const fn constant(numerator: [F; 3], denominator: [F; 2]) -> Self {
        Self {
            numerator,
            denominator,
        }
    }

    /// One sample.
    ///
    /// About its last output, so that a large constant (gravity) costs no digits in single precision.
    #[inline]
    pub fn step(&self, state: &mut LowPassState<F>, input: F) -> F {
        let (b, a) = (&self.numerator, &self.denominator);
        let at = state.output[0];
        let y = b[0] * (input - at) + b[1] * (state.input[0] - at) + b[2] * (state.input[1] - at)
            - a[1] * (state.output[1] - at)
            + at;
        state.input = [input, state.input[0]];
        state.output = [y, state.output[0]];
        y
    }

    /// Group delay at zero frequency in samples, Σ k β_k / Σ β_k − Σ k α_k / Σ α_k.
    pub fn group_delay(&self) -> F {
        let two = F::ONE + F::ONE;
        let (b, a) = (&self.numerator, &self.denominator);
        (b[1] + two * b[2]) / (b[0] + b[1] + b[2]) - (a[0] + two * a[1]) / (F::ONE + a[0] + a[1])
    }

    /// |H| at a frequency over the sampling rate.
    pub fn gain(&self, frequency: f64) -> f64 {
        let angle = core::f64::consts::TAU * frequency;
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        let size = |k: [f64; 3]| {
            // k₀ + k₁ z⁻¹ + k₂ z⁻², turned by z: its modulus is the same.
            libm::hypot((k[0] + k[2]) * c + k[1], (k[0] - k[2]) * s)
        };
        let b = self.numerator.map(|v| v.to_f64());
        let [first, second] = self.denominator.map(|v| v.to_f64());
        size(b) / size([1.0, first, second])
    }

    /// Samples after which less than a share of any step is left to come: 2 |p|ⁿ of the pair of poles p bounds it.
    ///
    /// **Accuracy** `law_no_more_than_the_share_is_left`.
    pub fn settling(&self, share: f64) -> f64 {
        let radius = 0.5 * libm::log(self.denominator[1].to_f64());
        1.0 + libm::ceil(libm::log(0.5 * share) / radius)
    }
}

/// Mean of the last N samples.
///
/// **Delay** (N − 1)/2 samples at every frequency; zeros at the multiples of rate/N.
///
/// ```
/// use proofmass_core::MovingAverage;
/// let mut mean = MovingAverage::<f32, 4>::new();
/// let out: [f32; 5] = [1.0, 2.0, 3.0, 4.0, 5.0].map(|v| mean.step(v));
/// assert_eq!(out, [1.0, 1.5, 2.0, 2.5, 3.5]);
/// ```
#[doc(alias("FIR", "boxcar"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingAverage<F, const N: usize> {
    samples: [F; N],
    next: usize,
    filled: usize,
}

impl<F: Float, const N: usize> MovingAverage<F, N> {
    /// Without a sample yet.
    pub fn new() -> Self {
        Self {
            samples: [F::ZERO; N],
            next: 0,
            filled: 0,
        }
    }

    /// Mean of the samples so far, of the last N from then on. Summed anew each time: rounding does not pile up.
    pub fn step(&mut self, input: F) -> F {
        if N == 0 {
            return input;
        }
        self.samples[self.next] = input;
        self.next = (self.next + 1) % N;
        self.filled = (self.filled + 1).min(N);
        let mut sum = F::ZERO;
        let mut count = F::ZERO;
        for sample in &self.samples[..self.filled] {
            sum += *sample;
            count += F::ONE;
        }
        sum / count
    }

    /// Delay in samples.
    pub fn group_delay(&self) -> f64 {
        (N as f64 - 1.0) / 2.0
    }
}

impl<F: Float, const N: usize> Default for MovingAverage<F, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// |H| and phase at a frequency, from the coefficients.
    fn response(f: &Butterworth<f64>, x: f64) -> (f64, f64) {
        let (c, s) = (x.cos(), x.sin());
        let (c2, s2) = ((2.0 * x).cos(), (2.0 * x).sin());
        let [b0, b1, b2] = f.numerator;
        let [a1, a2] = f.denominator;
        let (nr, ni) = (b0 + b1 * c + b2 * c2, -(b1 * s + b2 * s2));
        let (dr, di) = (1.0 + a1 * c + a2 * c2, -(a1 * s + a2 * s2));
        (nr.hypot(ni) / dr.hypot(di), ni.atan2(nr) - di.atan2(dr))
    }

    #[test]
    fn known_corner_and_delay() {
        for corner in [0.1, 1.0, 20.0, 200.0, 480.0] {
            let f = Butterworth::<f64>::new(corner, 1000.0).unwrap();
            let at = std::f64::consts::TAU * corner / 1000.0;
            let (gain, _) = response(&f, at);
            assert!((gain - 0.5f64.sqrt()).abs() < 1e-7, "{corner}: {gain}");
            let (flat, _) = response(&f, 0.0);
            assert!((flat - 1.0).abs() < 1e-7);
            let small = 1e-4 * at;
            let (_, phase) = response(&f, small);
            assert!((-phase / small / f.group_delay() - 1.0).abs() < 1e-4);
            if corner < 50.0 {
                let analogue = std::f64::consts::SQRT_2 / (std::f64::consts::TAU * corner) * 1000.0;
                assert!((f.group_delay() / analogue - 1.0).abs() < 0.01);
            }
        }
    }

    /// The recursion is the transfer function: its response to a step rises by 4.3 % at most and ends at one.
    #[test]
    fn known_step_response() {
        let f = Butterworth::<f64>::new(10.0, 1000.0).unwrap();
        let mut state = LowPassState::at(0.0);
        let response: Vec<f64> = (0..2000).map(|_| f.step(&mut state, 1.0)).collect();
        let highest = response.iter().copied().fold(0.0, f64::max);
        // Overshoot of ζ = 1/√2: e^{−π}.
        assert!(
            (highest - 1.0 - (-std::f64::consts::PI).exp()).abs() < 1e-3,
            "{highest}"
        );
        assert!((response[1999] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn law_no_more_than_the_share_is_left() {
        for corner in [0.2, 1.0, 20.0, 200.0, 400.0, 490.0] {
            let f = Butterworth::<f64>::new(corner, 1000.0).unwrap();
            for share in [1e-1, 1e-3] {
                let settled = f.settling(share) as usize;
                let mut state = LowPassState::at(0.0);
                let rest = (0..settled + 20_000)
                    .map(|_| f.step(&mut state, 1.0) - 1.0)
                    .skip(settled)
                    .fold(0.0f64, |a, v| a.max(v.abs()));
                assert!(rest <= share, "{corner} {share}: {rest}");
                // Nor is it given up much later than needed: a third of it is not enough.
                let mut state = LowPassState::at(0.0);
                let early = (0..settled)
                    .map(|_| f.step(&mut state, 1.0) - 1.0)
                    .skip(settled / 3)
                    .fold(0.0f64, |a, v| a.max(v.abs()));
                assert!(
                    corner > 200.0 || settled < 12 || early > share,
                    "{corner} {share}: {early}"
                );
            }
        }
    }

    #[test]
    fn crosscheck_gain_from_the_complex_response() {
        for corner in [1.0, 20.0, 400.0] {
            let f = Butterworth::<f64>::new(corner, 1000.0).unwrap();
            for frequency in [0.0, 0.3, 20.0, 200.0, 499.0] {
                let (gain, _) = response(&f, std::f64::consts::TAU * frequency / 1000.0);
                assert!((f.gain(frequency / 1000.0) - gain).abs() < 1e-8, "{gain}");
            }
        }
    }

    #[test]
    fn law_single_precision_follows_double_on_top_of_gravity() {
        let single = Butterworth::<f32>::new(2.0, 1000.0).unwrap();
        let double = Butterworth::<f64>::new(2.0, 1000.0).unwrap();
        let (mut a, mut b) = (
            LowPassState::at(9.8f32),
            LowPassState::at(f64::from(9.8f32)),
        );
        let mut worst = 0.0f64;
        for i in 0..20_000 {
            let x = 9.8 + 0.1 * (f64::from(i) * 0.01).sin();
            let y = single.step(&mut a, x as f32);
            worst = worst.max((f64::from(y) - double.step(&mut b, f64::from(x as f32))).abs());
        }
        // A corner of rate/500 amplifies rounding (ε · 10 = 1e-6) by the five hundred samples it holds, and its square
        // root where errors are not alike; coefficients add ε/(4 w²) of the change.
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn refuses_corners_beyond_nyquist() {
        assert!(Butterworth::<f32>::new(600.0, 1000.0).is_err());
        assert!(Butterworth::<f32>::new(0.0, 1000.0).is_err());
        assert!(Butterworth::<f32>::new(1.0, f64::NAN).is_err());
        assert_eq!(MovingAverage::<f64, 5>::default().group_delay(), 2.0);
    }
}
