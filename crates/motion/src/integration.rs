//! Velocity from acceleration alone, off line: offset removal and high-pass.

use proofmass_core::Error;
use proofmass_core::velocity::{Integrator, IntegratorRule, IntegratorState};
use proofmass_signal::fourier;
use std::f64::consts::{PI, TAU};

/// Butterworth high-pass as second-order sections, by Tustin with the corner prewarped.
///
/// |H|² = 1/(1 + (tan(ω_cT/2)/tan(ωT/2))^{2n}). **Delay** of the causal filter: a lead at low frequency,
/// none above the corner; zero-phase use doubles the attenuation (−6 dB at the corner) and has none anywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct HighPass {
    sections: Vec<[f64; 3]>, // common gain g, then a₁, a₂; numerator g (1 − z⁻¹)²
}

impl HighPass {
    /// Even order and corner in Hz at this sample time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an order that is odd, zero or above 8, or a corner outside 0…Nyquist.
    pub fn butterworth(order: usize, corner: f64, sample_time: f64) -> Result<Self, Error> {
        if !(2..=8).contains(&order) || !order.is_multiple_of(2) {
            return Err(Error::OutOfRange {
                name: "order (2, 4, 6 or 8)",
                value: order as f64,
                min: 2.0,
                max: 8.0,
            });
        }
        let nyquist = 0.5 / sample_time;
        if !(corner > 0.0 && corner < nyquist) {
            return Err(Error::OutOfRange {
                name: "corner",
                value: corner,
                min: 0.0,
                max: nyquist,
            });
        }
        let k = (PI * corner * sample_time).tan();
        let sections = (0..order / 2).map(|i| {
            let damping = (PI * (2 * i + 1) as f64 / (2 * order) as f64).sin();
            let norm = 1.0 / (1.0 + 2.0 * damping * k + k * k);
            [
                norm,
                2.0 * (k * k - 1.0) * norm,
                (1.0 - 2.0 * damping * k + k * k) * norm,
            ]
        });
        Ok(Self {
            sections: sections.collect(),
        })
    }

    /// H(e^{jθ}) of the causal filter at θ = ωT.
    pub fn response(&self, theta: f64) -> fourier::Complex<f64> {
        use fourier::Complex;
        let z = Complex::from_polar(1.0, -theta);
        // (1 − z⁻¹)² without cancellation at small angles.
        let double = z * (-4.0 * (0.5 * theta).sin().powi(2));
        self.sections
            .iter()
            .fold(Complex::new(1.0, 0.0), |h, &[g, a1, a2]| {
                h * (double * g / (z * a1 + z * z * a2 + 1.0))
            })
    }

    /// Causal: as it would run while recording.
    pub fn filter(&self, x: &[f64]) -> Vec<f64> {
        let mut y = x.to_vec();
        for &[g, a1, a2] in &self.sections {
            // Transposed form II, started in the steady state of a constant at the first value (output zero).
            let first = y.first().copied().unwrap_or(0.0);
            let (mut s1, mut s2) = (-g * first, g * first);
            // With input c and output 0: s1 = −2g·(−…): y = g c + s1 = 0 → s1 = −g c; s2 = g c.
            for v in &mut y {
                let input = *v;
                let output = g * input + s1;
                s1 = -2.0 * g * input - a1 * output + s2;
                s2 = g * input - a2 * output;
                *v = output;
            }
        }
        y
    }

    /// Forward and backward over the record, continued at both ends by its point reflection.
    pub fn zero_phase(&self, x: &[f64], padding: usize) -> Vec<f64> {
        let n = x.len();
        if n < 2 {
            return vec![0.0; n];
        }
        let pad = padding.min(n - 1);
        let head = (1..=pad).rev().map(|k| 2.0 * x[0] - x[k]);
        let tail = (1..=pad).map(|k| 2.0 * x[n - 1] - x[n - 1 - k]);
        let long: Vec<f64> = head.chain(x.iter().copied()).chain(tail).collect();
        let mut y = self.filter(&long);
        y.reverse();
        let mut y = self.filter(&y);
        y.reverse();
        y[pad..pad + n].to_vec()
    }
}

/// How acceleration becomes velocity off line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OffLineIntegration {
    /// A rule of the streaming integrators, then a causal Butterworth high-pass.
    CausalHighPass {
        /// Rule.
        rule: IntegratorRule,
        /// Order of the high-pass.
        order: usize,
        /// Corner, Hz.
        corner: f64,
    },
    /// The same with the high-pass forward and backward.
    ZeroPhase {
        /// Rule.
        rule: IntegratorRule,
        /// Order of the high-pass, run twice.
        order: usize,
        /// Corner, Hz.
        corner: f64,
    },
    /// Division by jω in the frequency domain, nothing below the corner. The record is taken as periodic: it
    /// should begin and end at rest.
    FrequencyDomain {
        /// Corner, Hz.
        corner: f64,
    },
}

/// Velocity from acceleration, without the drift and without what the motion has below the corner.
///
/// `still` is a range of samples at rest whose mean is taken off first.
///
/// # Errors
/// [`Error::TooFew`] below four samples or for an empty still range, [`Error::NotFinite`],
/// [`Error::OutOfRange`] for the settings.
pub fn integrate(
    acceleration: &[f64],
    sample_time: f64,
    still: Option<std::ops::Range<usize>>,
    method: OffLineIntegration,
) -> Result<Vec<f64>, Error> {
    let n = acceleration.len();
    if n < 4 {
        return Err(Error::TooFew {
            name: "samples",
            needed: 4,
            got: n,
        });
    }
    if let Some(index) = acceleration.iter().position(|a| !a.is_finite()) {
        return Err(Error::NotFinite {
            name: "acceleration",
            index,
        });
    }
    let offset = match still {
        None => 0.0,
        Some(range) => {
            let part = acceleration.get(range).unwrap_or(&[]);
            if part.is_empty() {
                return Err(Error::TooFew {
                    name: "samples at rest",
                    needed: 1,
                    got: 0,
                });
            }
            part.iter().sum::<f64>() / part.len() as f64
        }
    };
    let a: Vec<f64> = acceleration.iter().map(|a| a - offset).collect();
    let run = |rule| -> Result<Vec<f64>, Error> {
        let integrator = Integrator::<f64>::new(rule, sample_time)?;
        let mut state = IntegratorState::new(0.0);
        Ok(a.iter().map(|a| integrator.step(&mut state, *a)).collect())
    };
    match method {
        OffLineIntegration::CausalHighPass {
            rule,
            order,
            corner,
        } => Ok(HighPass::butterworth(order, corner, sample_time)?.filter(&run(rule)?)),
        OffLineIntegration::ZeroPhase {
            rule,
            order,
            corner,
        } => {
            let filter = HighPass::butterworth(order, corner, sample_time)?;
            Ok(filter.zero_phase(&run(rule)?, (3.0 / (corner * sample_time)) as usize))
        }
        OffLineIntegration::FrequencyDomain { corner } => {
            if !(corner >= 0.0 && corner.is_finite()) {
                return Err(Error::OutOfRange {
                    name: "corner",
                    value: corner,
                    min: 0.0,
                    max: f64::MAX,
                });
            }
            let mut spectrum = fourier::forward_owned(a);
            let bins = spectrum.len();
            for (k, s) in spectrum.iter_mut().enumerate() {
                let frequency = k as f64 / (n as f64 * sample_time);
                let nyquist = n.is_multiple_of(2) && k + 1 == bins;
                *s = if k == 0 || frequency < corner || nyquist {
                    Default::default()
                } else {
                    *s / fourier::Complex::new(0.0, TAU * frequency)
                };
            }
            fourier::inverse(spectrum, n).ok_or(Error::TooFew {
                name: "acceleration",
                needed: 1,
                got: n,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(y: &[f64], x: &[f64]) -> f64 {
        let m = x.len() / 4;
        let p = |v: &[f64]| v[m..3 * m].iter().map(|v| v * v).sum::<f64>();
        (p(y) / p(x)).sqrt()
    }

    #[test]
    fn law_butterworth_has_its_magnitude_and_kills_constants() {
        let dt = 1e-3;
        for order in [2, 4, 6] {
            let filter = HighPass::butterworth(order, 5.0, dt).unwrap();
            for f in [2.5, 5.0, 20.0] {
                let x: Vec<f64> = (0..40_000)
                    .map(|k| (TAU * f * dt * k as f64).sin())
                    .collect();
                let ratio = (PI * 5.0 * dt).tan() / (PI * f * dt).tan();
                let expected = 1.0 / (1.0 + ratio.powi(2 * order as i32)).sqrt();
                assert!(
                    (gain(&filter.filter(&x), &x) - expected).abs() < 1e-4,
                    "{order} {f}"
                );
                let response = filter.response(TAU * f * dt).norm();
                assert!(
                    (response - expected).abs() < 1e-9,
                    "{order} {f}: {response}"
                );
                let twice = gain(&filter.zero_phase(&x, 2000), &x);
                assert!((twice - expected * expected).abs() < 1e-4, "{order} {f}");
            }
            let constant = filter.filter(&[3.0; 100]);
            assert!(constant.iter().all(|y| y.abs() < 1e-12));
        }
        assert!(HighPass::butterworth(3, 5.0, dt).is_err());
        assert!(HighPass::butterworth(2, 600.0, dt).is_err());
    }

    #[test]
    fn law_off_line_methods_recover_a_band_limited_velocity() {
        let (dt, n) = (1e-3, 8000);
        let w = TAU * 5.0;
        let envelope = |t: f64| (-(t - 4.0f64).powi(2) / 0.5).exp();
        let v = |t: f64| envelope(t) * (w * t).sin();
        let a = |t: f64| envelope(t) * (w * (w * t).cos() - 4.0 * (t - 4.0) * (w * t).sin());
        let truth: Vec<f64> = (0..n).map(|k| v(dt * k as f64)).collect();
        let x: Vec<f64> = (0..n).map(|k| a(dt * k as f64) + 0.3).collect();
        for (method, bound) in [
            (OffLineIntegration::FrequencyDomain { corner: 0.5 }, 1e-6),
            // The trapezoid's (ωT)²/12 = 8e-5, and the filter's skirt at ten times its corner, (1/10)⁸.
            (
                OffLineIntegration::ZeroPhase {
                    rule: IntegratorRule::Trapezoid,
                    order: 4,
                    corner: 0.5,
                },
                2e-3,
            ),
            // The causal filter leads by some 2.6·(0.5/5) rad.
            (
                OffLineIntegration::CausalHighPass {
                    rule: IntegratorRule::Trapezoid,
                    order: 2,
                    corner: 0.5,
                },
                0.2,
            ),
        ] {
            let found = integrate(&x, dt, Some(0..1000), method).unwrap();
            let worst = (1000..7000).fold(0.0f64, |m, k| m.max((found[k] - truth[k]).abs()));
            assert!(worst < bound, "{method:?}: {worst}");
        }
    }
}
