//! A transducer on a bench: what happens to it, and what a converter writes of it.

use super::Transducer;
use num_complex::Complex64;
use proofmass_core::{Error, check};
use proofmass_signal::{PulseShape, fourier, relative_displacement};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What the bench does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TransducerMotion {
    /// One pulse, a fifth of the record after its beginning.
    Shock {
        /// Shape.
        shape: PulseShape,
        /// m/s².
        peak: f64,
        /// s.
        duration: f64,
    },
    /// Normal noise, white up to half the rate.
    Random {
        /// m/s².
        rms: f64,
    },
    /// Logarithmic sweep over four fifths of the record, with rest before and after it.
    Sweep {
        /// Hz.
        low: f64,
        /// Hz.
        high: f64,
        /// m/s².
        amplitude: f64,
    },
    /// From rest to a constant acceleration, a fifth of the record after its beginning.
    Step {
        /// m/s².
        height: f64,
    },
}

/// A transducer, what happens to it, and its converter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransducerBench {
    /// The device.
    pub transducer: Transducer,
    /// What happens.
    pub motion: TransducerMotion,
    /// Samples per second.
    pub rate: f64,
    /// s.
    pub duration: f64,
    /// Departure from the temperature at which the sensitivity holds, K.
    pub temperature: f64,
    /// Noise of one sample, as a share of the output of the greatest acceleration it measures.
    pub noise: f64,
    /// Noise of one sample of the reference, m/s².
    pub reference_noise: f64,
    /// Bits of the converter over the whole range; none for zero.
    pub bits: u32,
}

/// What was recorded, with the truth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TransducerRecording {
    /// s.
    pub time: Vec<f64>,
    /// True acceleration, m/s².
    pub truth: Vec<f64>,
    /// Reference, m/s².
    pub reference: Vec<f64>,
    /// Output in the transducer's unit.
    pub output: Vec<f64>,
    /// Samples at which the mass met its stop or the principle its end: the output stays at the last it can give.
    pub beyond: usize,
}

impl TransducerBench {
    /// The recording; the same for the same seed.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a rate, duration, noise or motion that makes no sense, or more than 10⁸ samples.
    pub fn simulate(&self, seed: u64) -> Result<TransducerRecording, Error> {
        let positive = |name, value: f64, max: f64| {
            if value > 0.0 && value <= max {
                return Ok(());
            }
            Err(Error::OutOfRange {
                name,
                value,
                min: f64::MIN_POSITIVE,
                max,
            })
        };
        positive("rate", self.rate, 1e9)?;
        positive("duration", self.duration, 1e8 / self.rate)?;
        for (name, value) in [
            ("noise", self.noise),
            ("reference noise", self.reference_noise),
        ] {
            check::not_negative(name, value)?;
        }
        let n = (self.rate * self.duration) as usize;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let start = 0.2 * self.duration;
        let truth: Vec<f64> = match self.motion {
            TransducerMotion::Shock {
                shape,
                peak,
                duration,
            } => {
                positive("duration of the pulse", duration, 0.6 * self.duration)?;
                shape.record(peak, duration, start, n, self.rate)
            }
            TransducerMotion::Random { rms } => (0..n).map(|_| rms * normal()).collect(),
            TransducerMotion::Sweep {
                low,
                high,
                amplitude,
            } => {
                positive("lower end of the sweep", low, 0.5 * self.rate)?;
                positive("upper end of the sweep", high - low, 0.5 * self.rate - low)?;
                let length = 0.8 * self.duration;
                let l = length / (high / low).ln();
                (0..n)
                    .map(|k| k as f64 / self.rate - 0.05 * self.duration)
                    .map(|t| match (0.0..length).contains(&t) {
                        true => amplitude * (TAU * low * l * ((t / l).exp() - 1.0)).sin(),
                        false => 0.0,
                    })
                    .collect()
            }
            TransducerMotion::Step { height } => (0..n)
                .map(|k| {
                    if k as f64 / self.rate >= start {
                        height
                    } else {
                        0.0
                    }
                })
                .collect(),
        };
        let mass = &self.transducer.mass;
        let (f0, zeta) = (mass.natural_frequency(), mass.damping_ratio());
        // Noise and sweeps have no frequency above half the rate, and are not the straight lines between their samples:
        // these would answer (πf/rate)²/3 less.
        let padding = match self.motion {
            TransducerMotion::Random { .. } => Some(0),
            TransducerMotion::Sweep { .. } => Some(n),
            TransducerMotion::Shock { .. } | TransducerMotion::Step { .. } => None,
        };
        let moved = match padding {
            None if zeta > 1.0 => overdamped(&truth, self.rate, f0, zeta),
            None => relative_displacement(&truth, self.rate, f0, zeta)?,
            Some(padding) => {
                positive("natural frequency", f0, f64::MAX)?;
                band_limited(&truth, padding, self.rate, |f| {
                    let r = f / f0;
                    -1.0 / ((TAU * f0).powi(2) * (1.0 - r * r + 2.0 * Complex64::i() * zeta * r))
                })
            }
        };
        let principle = &self.transducer.principle;
        let at = |x| principle.output_at(x, mass, self.temperature);
        let rest = at(0.0).unwrap_or(0.0);
        let (mut beyond, mut last) = (0, rest);
        let mut output: Vec<f64> = moved
            .iter()
            .map(|x| {
                // The mass lags behind the base: a positive acceleration deflects it backwards.
                let inside = (x.abs() < mass.stop).then_some(-x);
                match inside.and_then(at) {
                    Some(v) => last = v,
                    None => beyond += 1,
                }
                last
            })
            .collect();
        if let Some(corner) = principle.high_pass() {
            first_order(&mut output, rest, corner, self.rate, padding, true);
        }
        if let Some(corner) = principle.low_pass() {
            first_order(&mut output, rest, corner, self.rate, padding, false);
        }
        let limits = self.transducer.limits();
        let full = self
            .transducer
            .output(0.999 * limits.acceleration)
            .map_or(1.0, |v| (v - rest).abs());
        let step = if self.bits > 0 {
            2.0 * full / f64::from(self.bits.min(52)).exp2()
        } else {
            0.0
        };
        for v in &mut output {
            *v += self.noise * full * normal();
            if step > 0.0 {
                *v = rest + (((*v - rest) / step).round() * step).clamp(-full, full);
            }
        }
        let reference = truth
            .iter()
            .map(|a| a + self.reference_noise * normal())
            .collect();
        Ok(TransducerRecording {
            time: (0..n).map(|k| k as f64 / self.rate).collect(),
            truth,
            reference,
            output,
            beyond,
        })
    }
}

/// A filter on a signal without frequencies above half the rate, which repeats after so many zeros.
fn band_limited(
    signal: &[f64],
    padding: usize,
    rate: f64,
    response: impl Fn(f64) -> Complex64,
) -> Vec<f64> {
    let n = signal.len();
    let mut long = signal.to_vec();
    long.resize(n + padding, 0.0);
    let line = rate / long.len().max(1) as f64;
    let length = long.len();
    let mut spectrum = fourier::forward_owned(long);
    for (k, v) in spectrum.iter_mut().enumerate() {
        *v *= response(k as f64 * line);
    }
    let mut filtered = fourier::inverse(spectrum, length).unwrap_or_default();
    filtered.truncate(n);
    filtered
}

/// Relative displacement of a mass that does not swing, exact for straight lines between samples: with the poles
/// p = ω(ζ ∓ √(ζ² − 1)), −1/(s² + 2ζωs + ω²) = −(1/(s + p₁) − 1/(s + p₂))/(p₂ − p₁).
fn overdamped(truth: &[f64], rate: f64, f0: f64, zeta: f64) -> Vec<f64> {
    let root = (zeta * zeta - 1.0).sqrt();
    // p₁ p₂ = ω²: the difference ζ − √(ζ² − 1) would lose digits.
    let high = TAU * f0 * (zeta + root);
    let low = (TAU * f0).powi(2) / high;
    let [slow, fast] = [low, high].map(|pole| {
        let mut passed = truth.to_vec();
        first_order(&mut passed, 0.0, pole / TAU, rate, None, false);
        passed.into_iter().map(move |v| v / pole)
    });
    slow.zip(fast)
        .map(|(a, b)| (b - a) / (high - low))
        .collect()
}

/// First-order filter about a level: without frequencies above half the rate where `padding` is given, else exact for straight
/// lines between samples.
fn first_order(
    signal: &mut Vec<f64>,
    level: f64,
    corner: f64,
    rate: f64,
    padding: Option<usize>,
    high: bool,
) {
    signal.iter_mut().for_each(|v| *v -= level);
    match padding {
        Some(padding) => {
            *signal = band_limited(signal, padding, rate, |f| {
                let r = Complex64::new(0.0, f / corner);
                if high { r / (1.0 + r) } else { 1.0 / (1.0 + r) }
            });
        }
        None => {
            let mu = TAU * corner / rate;
            let decay = (-mu).exp();
            let gain = -(-mu).exp_m1() / mu;
            let (mut before, mut passed) = (0.0, 0.0);
            for v in signal.iter_mut() {
                let x = *v;
                passed = decay * passed + gain * (x - before);
                before = x;
                *v = if high { passed } else { x - passed };
            }
        }
    }
    signal.iter_mut().for_each(|v| *v += level);
}

#[cfg(test)]
mod tests {
    use super::super::{Principle, ProofMass};
    use super::*;

    fn bench(transducer: Transducer, motion: TransducerMotion) -> TransducerBench {
        TransducerBench {
            transducer,
            motion,
            rate: 200e3,
            duration: 0.05,
            temperature: 0.0,
            noise: 0.0,
            reference_noise: 0.0,
            bits: 0,
        }
    }

    #[test]
    fn law_a_slow_step_settles_at_the_static_output() {
        for device in Transducer::examples() {
            if device.limits().lowest > 0.0 {
                continue;
            }
            let height = 0.2 * device.limits().acceleration;
            let settle = 60.0 / (device.mass.natural_frequency() * device.mass.damping_ratio())
                + device.principle.low_pass().map_or(0.0, |f| 3.0 / f);
            let mut bench = bench(device.clone(), TransducerMotion::Step { height });
            bench.duration = settle.max(0.01);
            bench.rate = 2e5 / bench.duration;
            let recording = bench.simulate(1).unwrap();
            let end = *recording.output.last().unwrap();
            let expected = device.output(height).unwrap();
            assert!(
                (end / expected - 1.0).abs() < 1e-6,
                "{} {end} {expected}",
                device.name
            );
            assert_eq!(recording.beyond, 0, "{}", device.name);
        }
    }

    /// Just above ζ = 1 as just below it, and a step settles at −a/ω² whatever the damping.
    #[test]
    fn law_a_mass_that_does_not_swing() {
        let truth: Vec<f64> = (0..4000)
            .map(|k| f64::from(u8::from(k > 400)) * f64::from(k % 700) / 700.0)
            .collect();
        let below = relative_displacement(&truth, 1e5, 1000.0, 1.0 - 1e-7).unwrap();
        let above = overdamped(&truth, 1e5, 1000.0, 1.0 + 1e-7);
        let top = below.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for (a, b) in below.iter().zip(&above) {
            assert!((a - b).abs() < 1e-5 * top, "{a} {b}");
        }
        let settled = overdamped(&[2.0; 20_000], 1e5, 1000.0, 5.0);
        let due = -2.0 / (TAU * 1000.0).powi(2);
        assert!((settled[19_999] / due - 1.0).abs() < 1e-9);
    }

    #[test]
    fn law_a_charge_leaks_away_and_a_stop_is_met() {
        let piezo = Transducer {
            name: "piezo".into(),
            mass: ProofMass::of(5e-3, 30_000.0, 0.3, 1e-6),
            principle: Principle::Piezoelectric {
                charge_coefficient: 500e-12,
                capacitance: 1e-9,
                resistance: 1e7,
                temperature: 0.01,
            },
        };
        // 10 ms of time constant: after 40 ms e⁻⁴ is left.
        let mut b = bench(piezo.clone(), TransducerMotion::Step { height: 100.0 });
        let r = b.simulate(1).unwrap();
        let expected = piezo.output(100.0).unwrap() * (-4.0f64).exp();
        assert!((r.output.last().unwrap() / expected - 1.0).abs() < 0.02);
        b.temperature = 10.0;
        let warm = b.simulate(1).unwrap();
        assert!((warm.output.last().unwrap() / r.output.last().unwrap() - 1.1).abs() < 1e-9);
        let limit = piezo.limits().acceleration;
        b.motion = TransducerMotion::Step {
            height: 2.0 * limit,
        };
        assert!(b.simulate(1).unwrap().beyond > 0);
    }

    /// A tone within the sweep's band comes out with the modulus of the model, however few samples its period has.
    #[test]
    fn law_noise_is_answered_as_the_model_answers() {
        let device = Transducer::examples().remove(0);
        let (f0, zeta) = (device.mass.natural_frequency(), device.mass.damping_ratio());
        let mut b = bench(device, TransducerMotion::Random { rms: 1.0 });
        // Eight samples to a period of the resonance.
        b.rate = 8.0 * f0;
        b.duration = 4096.0 / b.rate;
        let r = b.simulate(1).unwrap();
        let (x, y) = (fourier::forward(&r.truth), fourier::forward(&r.output));
        let due = |k: usize| {
            let q = k as f64 / 512.0;
            1.0 / (1.0 - q * q + 2.0 * Complex64::i() * zeta * q)
        };
        // To the first line, which leaves out the static gain.
        let found = |k: usize| y[k] / x[k] / (y[1] / x[1]) * due(1);
        for k in [100, 512, 800] {
            // The comb is not quite linear at 1 m/s².
            let off = (found(k) - due(k)).norm() / due(k).norm();
            assert!(off < 2e-3, "{k}: {off}");
        }
    }

    #[test]
    fn refuses_benches_that_cannot_be() {
        let device = Transducer::examples().remove(0);
        let good = bench(device, TransducerMotion::Random { rms: 1.0 });
        assert!(good.simulate(1).is_ok());
        for bad in [
            TransducerBench {
                rate: 0.0,
                ..good.clone()
            },
            TransducerBench {
                duration: f64::NAN,
                ..good.clone()
            },
            TransducerBench {
                noise: -1.0,
                ..good.clone()
            },
            TransducerBench {
                motion: TransducerMotion::Sweep {
                    low: 10.0,
                    high: 5.0,
                    amplitude: 1.0,
                },
                ..good.clone()
            },
        ] {
            assert!(bad.simulate(1).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn law_every_inverse_undoes_its_relation() {
        for device in Transducer::examples() {
            let top = device.limits().acceleration;
            for share in [-0.95, -0.4, 1e-6, 0.5, 0.95] {
                let a = share * top;
                let back = device.acceleration(device.output(a).unwrap()).unwrap();
                // A resonance or a shutter hides a small displacement behind a large number: sixteen digits of that.
                assert!((back - a).abs() < 1e-9 * top, "{} {share}", device.name);
            }
            assert!(device.output(1.01 * top).is_none(), "{}", device.name);
            assert!(device.acceleration(f64::NAN).is_none());
        }
    }
}
