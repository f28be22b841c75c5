//! Samples of a run: what the data acquisition delivers for the phasors of the bench.

use super::normal;
use faer::c64;
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
    /// Harmonic distortion of the shaker: amplitude of the second and third harmonic relative to the first.
    pub distortion: [f64; 2],
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
            distortion: [0.01, 0.003],
        }
    }
}

impl Acquisition {
    /// Samples of a channel whose fundamental is `phasor` (V, peak) at `frequency` (Hz), t = 0 at the first one.
    pub fn channel<R: Rng + ?Sized>(&self, phasor: c64, frequency: f64, rng: &mut R) -> Vec<f64> {
        let n = (self.duration * self.sampling_frequency).round() as usize;
        let step = 2.0 * self.full_scale / 2f64.powi(self.bits as i32);
        (0..n)
            .map(|i| {
                let phase = TAU * (frequency * i as f64 / self.sampling_frequency).fract();
                let (modulus, angle) = (phasor.norm(), phasor.arg());
                let pure = (phase + angle).cos();
                let second = self.distortion[0] * (2.0 * (phase + angle)).cos();
                let third = self.distortion[1] * (3.0 * (phase + angle)).cos();
                let v = modulus * (pure + second + third) + self.offset + self.noise * normal(rng);
                (v.clamp(-self.full_scale, self.full_scale) / step).round() * step
            })
            .collect()
    }

    /// Drives a table of unknown gain (m/s² per V of drive) to a target amplitude as a laboratory does: measure
    /// with the reference, correct the drive, until within `tolerance`. Returns the drive and the amplitude
    /// reached, or `None` after `attempts`.
    pub fn level(
        target: f64,
        tolerance: f64,
        attempts: usize,
        mut amplitude_at: impl FnMut(f64) -> f64,
    ) -> Option<(f64, f64)> {
        let mut drive = 0.1;
        for _ in 0..attempts {
            let reached = amplitude_at(drive);
            if (reached / target - 1.0).abs() <= tolerance {
                return Some((drive, reached));
            }
            if reached <= 0.0 || reached.is_nan() {
                return None;
            }
            // Never more than a factor of four at once, as one protects a shaker.
            drive *= (target / reached).clamp(0.25, 4.0);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn law_the_drive_reaches_its_target() {
        // A table whose gain falls slightly with amplitude.
        let table = |drive: f64| 37.0 * drive / (1.0 + 0.02 * drive);
        let (_, reached) = Acquisition::level(10.0, 1e-3, 20, table).unwrap();
        assert!((reached - 10.0).abs() <= 0.01);
        assert!(Acquisition::level(10.0, 1e-3, 20, |_| 0.0).is_none());
    }

    #[test]
    fn law_samples_are_codes_and_stay_within_full_scale() {
        let daq = Acquisition {
            duration: 0.01,
            ..Acquisition::default()
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let x = daq.channel(c64::new(12.0, 0.0), 160.0, &mut rng);
        assert_eq!(x.len(), 512);
        let step = 20.0 / 2f64.powi(24);
        assert!(
            x.iter()
                .all(|v| v.abs() <= 10.0 && (v / step).fract() == 0.0)
        );
    }
}
