//! Low-pass filters with one delay at all frequencies.

use proofmass_core::{Error, check};
use std::f64::consts::{LN_10, PI};

/// Longest impulse response.
const LONGEST: usize = 8191;
/// Frequencies at which the gain is looked at, for each sample of the impulse response: ripples are one over its length apart.
const LOOKS: usize = 32;

/// Finite impulse response of odd length, symmetric: a low-pass whose delay is half of its length at every frequency.
///
/// ```text
/// h_k = w_k sin(ω_c k)/(π k),  k = −n … n,  ω_c half way between the edges,  w Kaiser's window
/// ```
///
/// The window is chosen for the attenuation, and the response made longer until its gain, looked at thirty-two times per ripple, stays within
/// 10^(−A/20) in both bands. That gain is stated, not the formula's.
///
/// **Accuracy** `law_gain_stays_within_what_is_stated`. **Source** `[OppenheimSchafer2010]` 7.5.3.
///
/// ```
/// use proofmass_signal::LinearPhase;
/// let filter = LinearPhase::low_pass([40.0, 60.0], 1000.0, 60.0)?;
/// assert!(filter.ripple() <= 1e-3 && filter.stop_gain() <= 1e-3);
/// assert!((filter.gain(0.0) - 1.0).abs() < 1e-12);
/// assert_eq!(filter.taps().len(), 2 * filter.delay() + 1);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("FIR", "Kaiser window", "anti-aliasing"))]
#[derive(Clone, Debug, PartialEq)]
pub struct LinearPhase {
    taps: Vec<f64>,
    ripple: f64,
    stop_gain: f64,
}

impl LinearPhase {
    /// Gain one up to the first edge and none from the second on, both in Hz at this sampling rate, but for 10^(−A/20) with the attenuation
    /// A in dB.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for edges that are not between zero and half of the rate and apart, and for an attenuation outside 20 to
    /// 160 dB; [`Error::NotConverged`] for edges so near each other that 8191 samples do not tell them apart.
    pub fn low_pass([pass, stop]: [f64; 2], rate: f64, attenuation: f64) -> Result<Self, Error> {
        check::positive("sampling rate, Hz", rate)?;
        let range = |name, value, min, max| match value > min && value < max {
            true => Ok(()),
            false => Err(Error::OutOfRange {
                name,
                value,
                min,
                max,
            }),
        };
        range("edge of the passed band, Hz", pass, 0.0, 0.5 * rate)?;
        range("edge of the stopped band, Hz", stop, pass, rate - pass)?;
        range("attenuation, dB", attenuation, 20.0 - 1e-9, 160.0 + 1e-9)?;
        let most = (-attenuation * LN_10 / 20.0).exp();
        let width = 2.0 * PI * (stop - pass) / rate;
        let mut half = ((attenuation - 7.95).max(10.0) / (2.0 * 2.285 * width)).ceil();
        while half <= (LONGEST / 2) as f64 {
            let filter = Self::of_half(half as usize, [pass / rate, stop / rate], attenuation);
            if filter.ripple <= most && filter.stop_gain <= most {
                return Ok(filter);
            }
            half = (1.02 * half).ceil().max(half + 1.0);
        }
        Err(Error::NotConverged {
            name: "low-pass of linear phase",
            iterations: LONGEST,
            step: (stop - pass) / rate,
        })
    }

    /// With so many samples on either side of the middle; edges over the sampling rate.
    fn of_half(half: usize, [pass, stop]: [f64; 2], attenuation: f64) -> Self {
        let beta = match attenuation {
            a if a > 50.0 => 0.1102 * (a - 8.7),
            a if a > 21.0 => 0.5842 * (a - 21.0).powf(0.4) + 0.07886 * (a - 21.0),
            _ => 0.0,
        };
        let cut = PI * (pass + stop);
        let one_side = |k: usize| {
            let x = k as f64 / (half as f64 + 1.0);
            let ideal = match k {
                0 => cut / PI,
                _ => (cut * k as f64).sin() / (PI * k as f64),
            };
            ideal * bessel_i0(beta * (1.0 - x * x).sqrt())
        };
        let mut side: Vec<f64> = (0..=half).map(one_side).collect();
        let sum = side[0] + 2.0 * side[1..].iter().sum::<f64>();
        side.iter_mut().for_each(|v| *v /= sum);
        let taps = side[1..].iter().rev().chain(&side).copied().collect();
        let mut filter = Self {
            taps,
            ripple: 0.0,
            stop_gain: 0.0,
        };
        let steps = (LOOKS * half).max(64);
        let within = |from: f64, to: f64| {
            let n = ((to - from) * 2.0 * steps as f64).ceil().max(1.0);
            (0..=n as usize).map(move |i| from + (to - from) * i as f64 / n)
        };
        filter.ripple = within(0.0, pass)
            .map(|f| (filter.gain(f) - 1.0).abs())
            .fold(0.0, f64::max);
        filter.stop_gain = within(stop.min(0.5), 0.5)
            .map(|f| filter.gain(f).abs())
            .fold(0.0, f64::max);
        filter
    }

    /// The impulse response.
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// Samples by which the result comes late.
    pub fn delay(&self) -> usize {
        self.taps.len() / 2
    }

    /// Largest difference of the gain from one in the passed band.
    pub fn ripple(&self) -> f64 {
        self.ripple
    }

    /// Largest gain in the stopped band.
    pub fn stop_gain(&self) -> f64 {
        self.stop_gain
    }

    /// Gain at a frequency over the sampling rate, negative where the sign turns; the phase is that of the delay.
    pub fn gain(&self, frequency: f64) -> f64 {
        let half = self.delay();
        let twice = 2.0 * (2.0 * PI * frequency).cos();
        // Σ h_k cos kω by Clenshaw's recurrence.
        let (mut next, mut after) = (0.0, 0.0);
        for h in self.taps[half + 1..].iter().rev() {
            (next, after) = (2.0 * h + twice * next - after, next);
        }
        self.taps[half] + 0.5 * twice * next - after
    }
}

/// Modified Bessel function of the first kind and order zero, by its series, whose terms are all positive.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_bessel_function() {
        assert!((bessel_i0(1.0) / 1.266_065_877_752_008 - 1.0).abs() < 1e-14);
        assert!((bessel_i0(10.0) / 2_815.716_628_466_254 - 1.0).abs() < 1e-14);
    }

    /// Looked at by the defining sum, at other frequencies than those of the design.
    #[test]
    fn law_gain_stays_within_what_is_stated() {
        for (pass, stop, attenuation) in [
            (0.04, 0.06, 60.0),
            (0.2, 0.3, 40.0),
            (0.001, 0.009, 80.0),
            (0.3, 0.65, 100.0),
            (0.1, 0.12, 25.0),
        ] {
            let f = LinearPhase::low_pass([pass, stop], 1.0, attenuation).expect("a filter");
            let most = 10f64.powf(-attenuation / 20.0);
            assert!(f.ripple() <= most && f.stop_gain() <= most);
            let half = f.delay() as f64;
            let gain = |x: f64| -> f64 {
                let of = |(k, h): (usize, &f64)| h * (2.0 * PI * x * (k as f64 - half)).cos();
                f.taps().iter().enumerate().map(of).sum()
            };
            for i in 0..3000 {
                let x = 0.5 * (f64::from(i) + 0.37) / 3000.0;
                let g = gain(x);
                assert!((g - f.gain(x)).abs() < 1e-11);
                // Between two looks, a thirty-second of a ripple apart, it rises by 1 − cos(π/64) = 0.1 %; the first ripple is steeper.
                if x <= pass {
                    assert!((g - 1.0).abs() <= 1.02 * f.ripple() + 1e-12, "{x}: {g}");
                }
                if x >= stop {
                    assert!(g.abs() <= 1.02 * f.stop_gain() + 1e-12, "{x}: {g}");
                }
            }
            // Nor is it much longer than Kaiser's formula has it, which is of edges below half of the rate and is met for the passed band
            // within a seventh.
            let formula = (attenuation - 7.95) / (2.285 * 2.0 * PI * (stop - pass));
            let length = f.taps().len() as f64;
            assert!(
                stop > 0.5 || length <= 8.0 / 7.0 * formula + 8.0,
                "{length} {formula}"
            );
        }
    }

    #[test]
    fn refuses_edges_without_room() {
        let refused = |edges, attenuation| LinearPhase::low_pass(edges, 1000.0, attenuation);
        assert!(refused([60.0, 40.0], 60.0).is_err());
        assert!(refused([500.0, 600.0], 60.0).is_err());
        assert!(refused([f64::NAN, 600.0], 60.0).is_err());
        assert!(refused([40.0, 60.0], 0.0).is_err());
        assert!(matches!(
            refused([40.0, 40.001], 60.0),
            Err(Error::NotConverged { .. })
        ));
    }
}
