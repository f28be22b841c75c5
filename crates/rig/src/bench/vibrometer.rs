//! Laser vibrometers: velocity of a spot, with or without the clock of the reference.

use num_complex::Complex64;
use rand::{Rng, RngExt};

use super::normal;

/// A vibrometer that looks along one axis of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchVibrometer {
    /// Relative standard deviation of one reading of the ratio to the reference.
    pub reading: f64,
    /// Additive standard deviation of the ratio, in each part.
    pub floor: f64,
    /// Whether its samples share the clock of the reference. Without, every repeat has its own phase.
    pub common_clock: bool,
}

/// One repeat: velocity and reference acceleration as phasors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VibrometerReading {
    /// Velocity phasor in m/s.
    pub velocity: Complex64,
    /// Reference acceleration phasor in m/s².
    pub reference: Complex64,
}

impl Default for BenchVibrometer {
    fn default() -> Self {
        Self {
            reading: 0.01,
            floor: 2e-4,
            common_clock: true,
        }
    }
}

impl BenchVibrometer {
    /// Repeats of a motion that is `ratio` times a reference acceleration of 1 m/s².
    pub fn repeats<R: Rng + ?Sized>(
        &self,
        ratio: Complex64,
        frequency: f64,
        count: usize,
        rng: &mut R,
    ) -> Vec<VibrometerReading> {
        let omega = std::f64::consts::TAU * frequency;
        (0..count)
            .map(|_| {
                let turn = std::f64::consts::TAU * rng.random::<f64>();
                let reference = Complex64::from_polar(1.0, turn);
                let seen = ratio * (1.0 + self.reading * normal(rng))
                    + Complex64::new(normal(rng), normal(rng)) * self.floor;
                let clock = if self.common_clock {
                    0.0
                } else {
                    std::f64::consts::TAU * rng.random::<f64>()
                };
                VibrometerReading {
                    velocity: seen * reference * Complex64::from_polar(1.0, clock)
                        / Complex64::new(0.0, omega),
                    reference,
                }
            })
            .collect()
    }
}
