//! Method 3 of ISO 16063-11: sines through the phase of the interferometer and the output of the sensor.

use super::{Quadrature, QuadratureFit, Unusable, count_fringes, minimum_point, unwrap};
use crate::recording::{PhasorReading, Phasors};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::sine::{Frequency, SineApproximation};
use proofmass_signal::transfer::turned;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Periods that a record needs: one is given away for the mean, and four are fitted.
const PERIODS: f64 = 5.0;
/// Relative standard uncertainty of the motion by the correction of the quadrature from which on it is not determined.
const UNDETERMINED: f64 = 0.05;
/// Up to this frequency fringes are counted, above it the minimum point is used, Hz.
const COUNTED: f64 = 800.0;

/// How a recording of an interferometer becomes phasors.
///
/// The ellipse of the two signals is made a circle, the phase is unwrapped, and φ λ/4π is the displacement. The mean over one period is
/// taken away from it: drift and slow vibration of the interferometer go with it, and the drive stays but for a known factor. Sines are
/// fitted to it and to the output at one frequency ([`PhasorReading`]), and a = −Ω² s.
///
/// **Units** metres; signals in volts.
///
/// **Assumes** the phase grows when the surface moves along the positive axis of the sensor.
///
/// **Source** `[ISO16063-11]` method 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SineApproximationMethod {
    /// Wavelength of the light in the air of the path, m.
    pub wavelength: f64,
    /// How the sines are fitted.
    pub reading: PhasorReading,
}

/// Which method told an amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckMethod {
    /// Method 1.
    FringeCounting,
    /// Method 2.
    MinimumPoint,
}

/// Amplitude of the displacement by another method, from the same samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AmplitudeCheck {
    /// The method.
    pub method: CheckMethod,
    /// Amplitude of the acceleration, m/s².
    pub acceleration: f64,
    /// Its standard uncertainty.
    pub uncertainty: f64,
}

/// What a recording of an interferometer and a sensor tells.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InterferometerRun {
    /// Displacement and output as they were fitted.
    pub phasors: Phasors,
    /// Acceleration, m/s², complex peak amplitude at the first fitted sample.
    pub acceleration: Complex64,
    /// Output, complex peak amplitude at the same instant.
    pub output: Complex64,
    /// Covariance rr, ri, ii of the two by the noise beside the drive.
    pub noise: [[f64; 3]; 2],
    /// Covariance of the acceleration by that of the ellipse.
    pub correction: [f64; 3],
    /// Relative standard uncertainty of the acceleration by what is left of the quadrature after the correction.
    pub remainder: f64,
    /// The ellipse.
    pub quadrature: QuadratureFit,
    /// Other methods, where the data allow.
    pub checks: Vec<AmplitudeCheck>,
}

impl SineApproximationMethod {
    /// Phasors of acceleration and output of one run at `frequency` (Hz).
    ///
    /// **Shapes** all three of one length.
    ///
    /// **Accuracy** bias below 1e-5 and 0.001° in simulations from 10 Hz to 10 kHz
    /// (`law_method_3_returns_the_truth`, and the map in docs/primary.md).
    ///
    /// # Errors
    /// [`Unusable`].
    pub fn evaluate(
        &self,
        frequency: f64,
        pair: [&[f64]; 2],
        output: &[f64],
    ) -> Result<InterferometerRun, Unusable> {
        let rate = self.reading.sampling_frequency;
        let samples = output.len();
        for u in pair {
            if u.len() != samples {
                return Err(Unusable::Fit(Error::Length {
                    name: "channels",
                    expected: samples,
                    got: u.len(),
                }));
            }
        }
        let periods = samples as f64 * frequency / rate;
        if periods < PERIODS {
            return Err(Unusable::Short(periods, PERIODS));
        }
        let quadrature = Quadrature::fit(pair[0], pair[1])?;
        let circle = &quadrature.quadrature;
        let pairs = || pair[0].iter().zip(pair[1]).map(|(a, b)| [*a, *b]);
        let phase = unwrap(&pairs().map(|u| circle.phase_of(u)).collect::<Vec<_>>())?;
        // An odd number of samples, next to a period.
        let half = ((0.5 * (rate / frequency - 1.0)).round() as usize).max(1);
        let slow = sliding_mean(&phase, half);
        let metres = self.wavelength / (4.0 * PI);
        let inner = half..samples - half;
        let motion: Vec<f64> = phase[inner.clone()]
            .iter()
            .zip(&slow)
            .map(|(p, mean)| (p - mean) * metres)
            .collect();
        let mut phasors = self
            .reading
            .phasors(frequency, &[&motion, &output[inner]])?;
        // Where another line is stronger the fit was made at the nominal frequency.
        let fitted = match phasors.frequency_uncertainty {
            Some(_) => phasors.measured_frequency,
            None => frequency,
        };
        let step = TAU * fitted / rate;
        let width = (2 * half + 1) as f64;
        let kept = 1.0 - (0.5 * width * step).sin() / (width * (0.5 * step).sin());
        let omega = TAU * fitted;
        let factor = Complex64::new(-omega * omega / kept, 0.0);
        let acceleration = phasors.amplitudes[0] * factor;
        let noise = [
            turned(phasors.covariances[0], factor),
            phasors.covariances[1],
        ];
        // What the ellipse and its remainder do to the phasor, at the same instant.
        let begin = Complex64::from_polar(1.0, step * half as f64);
        let scale = begin * (-omega * omega * metres);
        let derivatives = pairs().map(|u| circle.phase_derivatives(u));
        let effect = projections(derivatives, samples, step).map(|h| h * scale);
        let correction = spread(&effect, &quadrature.covariance);
        let size = acceleration.norm();
        let relative = (correction[0] + correction[2]).sqrt() / size;
        if !(relative < UNDETERMINED) {
            return Err(Unusable::Arc(quadrature.arc, relative));
        }
        let shapes = phase.iter().map(|p| {
            let (s, c) = (3.0 * p).sin_cos();
            let (s4, c4) = (4.0 * p).sin_cos();
            [c, s, c4, s4, 0.0]
        });
        let shapes = projections(shapes, samples, step).map(|h| h * scale);
        let floor = 4.0 * quadrature.residual.powi(2) / samples as f64;
        let remainder = quadrature.shape.iter().zip(shapes.chunks(2)).map(|(r, h)| {
            let beyond = (r.norm_sqr() - floor).max(0.0);
            // In one of two directions at a time.
            0.25 * beyond * (h[0].norm_sqr() + h[1].norm_sqr())
        });
        let remainder = remainder.sum::<f64>().sqrt() / size;
        let checks = if fitted <= COUNTED {
            let cosine: Vec<f64> = pairs().map(|u| circle.corrected(u)[0]).collect();
            count_fringes(&cosine, rate / fitted)
                .map(|(waves, u)| (CheckMethod::FringeCounting, [waves, u], self.wavelength))
        } else {
            // The mean took a known part of the drive away here too.
            let about = kept * size / (omega * omega * metres);
            let turns = phase[half..].iter().zip(&slow).map(|(p, m)| (p - m).sin());
            let at = phasors.amplitudes[0].arg();
            self.minimum(&turns.collect::<Vec<_>>(), fitted, at, about)
                .map(|(turn, u)| {
                    (
                        CheckMethod::MinimumPoint,
                        [turn / kept, u / kept.abs()],
                        metres,
                    )
                })
        };
        let checks = checks.map(|(method, [amplitude, u], unit)| AmplitudeCheck {
            method,
            acceleration: amplitude * unit * omega * omega,
            uncertainty: u * unit * omega * omega,
        });
        phasors.signal_to_noise.truncate(2);
        Ok(InterferometerRun {
            acceleration,
            output: phasors.amplitudes[1],
            noise,
            correction,
            remainder,
            quadrature,
            checks: checks.into_iter().collect(),
            phasors,
        })
    }

    /// Phase amplitude at the nearest zero of J₁.
    fn minimum(&self, turns: &[f64], frequency: f64, at: f64, about: f64) -> Option<(f64, f64)> {
        let rate = self.reading.sampling_frequency;
        let below = ((0.5 * rate / frequency).ceil() as usize).saturating_sub(1);
        let harmonics = (about.ceil() as usize + 3).min(below).clamp(1, 50);
        let fit = SineApproximation::new(frequency)
            .frequency(Frequency::Known)
            .harmonics(harmonics)
            .fit(rate, &[turns])
            .ok()?;
        let turn = Complex64::from_polar(1.0, -at);
        let component = fit.channels[0].amplitude * turn;
        let u = turned(fit.channels[0].covariance, turn)[0].max(0.0).sqrt();
        minimum_point(component.re, u, about)
    }
}

/// Means over 2 h + 1 samples about each sample that has h on both sides.
fn sliding_mean(values: &[f64], half: usize) -> Vec<f64> {
    let width = 2 * half + 1;
    if values.len() < width {
        return Vec::new();
    }
    // About a middle value: the sums stay small.
    let middle = values[values.len() / 2];
    let mut sum: f64 = values[..width].iter().map(|v| v - middle).sum();
    let mut means = Vec::with_capacity(values.len() - width + 1);
    means.push(middle + sum / width as f64);
    for k in width..values.len() {
        sum += values[k] - values[k - width];
        means.push(middle + sum / width as f64);
    }
    means
}

/// Complex amplitudes at a frequency (rad per sample) of five series, under a Hann window.
fn projections(rows: impl Iterator<Item = [f64; 5]>, samples: usize, step: f64) -> [Complex64; 5] {
    let mut sums = [Complex64::ZERO; 5];
    let mut weights = 0.0;
    for (k, row) in rows.enumerate() {
        let place = (k as f64 + 0.5) / samples as f64;
        let weight = (PI * place).sin().powi(2);
        weights += weight;
        let turn = Complex64::from_polar(weight, -(step * k as f64) % TAU);
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += turn * value;
        }
    }
    sums.map(|s| s * (2.0 / weights))
}

/// Covariance rr, ri, ii of Σ h_k θ_k.
fn spread(effect: &[Complex64; 5], covariance: &[[f64; 5]; 5]) -> [f64; 3] {
    let mut v = [0.0; 3];
    for (i, a) in effect.iter().enumerate() {
        for (j, b) in effect.iter().enumerate() {
            let c = covariance[i][j];
            v[0] += a.re * c * b.re;
            v[1] += a.re * c * b.im;
            v[2] += a.im * c * b.im;
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 100e3;

    /// Quadrature signals and output of a motion without noise.
    fn record(frequency: f64, motion: Complex64, drift: f64) -> [Vec<f64>; 3] {
        let samples = (RATE * (12.3 / frequency).max(0.02)) as usize;
        let mut channels = [vec![], vec![], vec![]];
        for k in 0..samples {
            let t = k as f64 / RATE;
            let turn = Complex64::from_polar(1.0, TAU * frequency * t);
            let s = (motion * turn).re + drift * t + 0.4e-6 * (TAU * 7.0 * t).sin();
            let phase = 4.0 * PI * s / 632.8e-9;
            channels[0].push(0.1 + phase.cos());
            channels[1].push(-0.2 + 0.9 * (phase + 0.1).sin());
            let out = motion * turn * (-(TAU * frequency).powi(2)) * Complex64::new(0.01, 0.002);
            channels[2].push(out.re + 0.5);
        }
        channels
    }

    fn method() -> SineApproximationMethod {
        SineApproximationMethod {
            wavelength: 632.8e-9,
            reading: PhasorReading::new(RATE),
        }
    }

    #[test]
    fn law_method_3_returns_the_truth() {
        for (frequency, amplitude) in [
            (80.0, 12e-6),
            (315.0, 3e-6),
            (2000.0, 0.56e-6),
            (8000.0, 0.19e-6),
        ] {
            let motion = Complex64::from_polar(amplitude, 0.7);
            let [a, b, out] = record(frequency, motion, 2e-6);
            let run = method().evaluate(frequency, [&a, &b], &out).unwrap();
            let s = run.output / run.acceleration;
            let truth = Complex64::new(0.01, 0.002);
            assert!(
                ((s / truth) - 1.0).norm() < 1e-5,
                "{frequency}: {}",
                s / truth
            );
            let reached = run.acceleration.norm() / (amplitude * (TAU * frequency).powi(2));
            assert!((reached - 1.0).abs() < 1e-5, "{frequency}: {reached}");
            // The other methods agree within their own uncertainty.
            for check in &run.checks {
                let apart = check.acceleration - run.acceleration.norm();
                assert!(
                    apart.abs() < 2.0 * check.uncertainty + 1e-3 * check.acceleration,
                    "{check:?} {}",
                    run.acceleration.norm()
                );
            }
        }
    }

    #[test]
    fn refuses_what_cannot_be_followed() {
        let at = |frequency: f64, amplitude: f64| {
            let [a, b, out] = record(frequency, Complex64::new(amplitude, 0.0), 0.0);
            method().evaluate(frequency, [&a, &b], &out)
        };
        assert!(matches!(at(80.0, 60e-6), Err(Unusable::TooFast(..))));
        let [a, b, out] = record(80.0, Complex64::new(1e-6, 0.0), 0.0);
        let short = method().evaluate(80.0, [&a[..5000], &b[..5000]], &out[..5000]);
        assert!(matches!(short, Err(Unusable::Short(p, _)) if (p - 4.0).abs() < 1e-9));
        let flat = vec![0.0; a.len()];
        let constant = method().evaluate(80.0, [&a, &flat], &out);
        assert_eq!(constant, Err(Unusable::Constant(1)));
        // The output in place of one of the pair.
        let swapped = method().evaluate(80.0, [&a, &out], &b);
        assert!(swapped.is_err(), "{swapped:?}");
    }
}
