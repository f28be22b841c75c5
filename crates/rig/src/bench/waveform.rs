//! Samples of a run: what the data acquisition delivers for the phasors of the bench.

use super::normal;
use num_complex::Complex64;
use rand::Rng;
use std::f64::consts::TAU;

/// A simultaneous data acquisition of 24 bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Acquisition {
    /// Sampling frequency in Hz.
    pub sampling_frequency: f64,
    /// Duration in seconds.
    pub duration: f64,
    /// Full scale in V: samples beyond are clipped.
    pub full_scale: f64,
    /// Bits of the converter.
    pub bits: u32,
    /// White noise in V, rms.
    pub noise: f64,
    /// Offset in V of every channel.
    pub offset: f64,
}

impl Default for Acquisition {
    fn default() -> Self {
        Self {
            sampling_frequency: 51_200.0,
            duration: 2.0,
            full_scale: 10.0,
            bits: 24,
            noise: 2e-5,
            offset: 1e-3,
        }
    }
}

/// Samples between two exact phases: the error of as many turns stays below 1e-14.
const TURNS: usize = 64;

impl Acquisition {
    /// Samples per channel.
    pub fn samples(&self) -> usize {
        (self.duration * self.sampling_frequency).round() as usize
    }

    /// Samples of a channel whose fundamental and harmonics are `phasors` (V, peak) at `frequency` (Hz) and its
    /// multiples, t = 0 at the first one.
    ///
    /// A harmonic at or above half the sampling frequency is taken away by the filter before the converter.
    pub fn channel<R: Rng + ?Sized>(
        &self,
        phasors: &[Complex64],
        frequency: f64,
        rng: &mut R,
    ) -> Vec<f64> {
        let step = 2.0 * self.full_scale / 2f64.powi(self.bits as i32);
        let passed = phasors
            .iter()
            .enumerate()
            .take_while(|(h, _)| (h + 1) as f64 * frequency < 0.5 * self.sampling_frequency)
            .count();
        let phasors = &phasors[..passed];
        let per_sample = frequency / self.sampling_frequency;
        let turn = Complex64::from_polar(1.0, TAU * per_sample);
        let n = self.samples();
        let mut samples = Vec::with_capacity(n);
        let mut e = Complex64::new(1.0, 0.0);
        for i in 0..n {
            if i % TURNS == 0 {
                e = Complex64::from_polar(1.0, TAU * (per_sample * i as f64).fract());
            }
            // Horner's scheme over the powers of e.
            let sum = phasors
                .iter()
                .rev()
                .fold(Complex64::new(0.0, 0.0), |sum, p| (sum + p) * e);
            let v = sum.re + self.offset + self.noise * normal(rng);
            samples.push((v.clamp(-self.full_scale, self.full_scale) / step).round() * step);
            e *= turn;
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn law_samples_are_the_sum_of_their_harmonics() {
        let daq = Acquisition {
            duration: 0.02,
            noise: 0.0,
            offset: 0.0,
            ..Acquisition::default()
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let phasors = [
            Complex64::from_polar(2.0, 0.4),
            Complex64::from_polar(0.1, -1.0),
        ];
        let x = daq.channel(&phasors, 333.3, &mut rng);
        for (i, x) in x.iter().enumerate() {
            let t = TAU * 333.3 * i as f64 / daq.sampling_frequency;
            let wanted = 2.0 * (t + 0.4).cos() + 0.1 * (2.0 * t - 1.0).cos();
            // Half a step of the converter.
            assert!((x - wanted).abs() < 10.0 / 2f64.powi(24) + 1e-12);
        }
        // A harmonic beyond half the sampling frequency does not come through.
        let high = daq.channel(
            &[Complex64::new(0.0, 0.0), Complex64::new(1.0, 0.0)],
            20e3,
            &mut rng,
        );
        assert!(high.iter().all(|v| *v == 0.0));
    }

    #[test]
    fn law_samples_are_codes_and_stay_within_full_scale() {
        let daq = Acquisition {
            duration: 0.01,
            ..Acquisition::default()
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let x = daq.channel(&[Complex64::new(12.0, 0.0)], 160.0, &mut rng);
        assert_eq!(x.len(), 512);
        let step = 20.0 / 2f64.powi(24);
        assert!(
            x.iter()
                .all(|v| v.abs() <= 10.0 && (v / step).fract() == 0.0)
        );
    }
}
