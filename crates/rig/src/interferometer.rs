//! A primary bench: a shaker, a sensor on it, and a laser interferometer with quadrature outputs.

use crate::bench::normal;
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{PI, TAU};

/// A homodyne interferometer with two outputs a quarter of a turn apart, and what is wrong with them.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureInterferometer {
    /// Wavelength, m.
    pub wavelength: f64,
    /// Offsets of the two signals, V.
    pub offset: [f64; 2],
    /// Their amplitudes, V.
    pub amplitude: [f64; 2],
    /// By how much the second leads a quarter of a turn, rad.
    pub phase: f64,
    /// White noise of each, V.
    pub noise: f64,
    /// Amplitude (m) and frequency (Hz) of the vibration of its base.
    pub vibration: [f64; 2],
    /// Drift of its path, m/s.
    pub drift: f64,
}

/// The bench.
#[derive(Clone, Debug, PartialEq)]
pub struct PrimaryBench {
    /// The interferometer.
    pub interferometer: QuadratureInterferometer,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Second harmonic of the acceleration, relative.
    pub distortion: f64,
    /// Relative error of the voltage measurement of the output.
    pub voltage: f64,
    /// Offset of the output, V.
    pub output_offset: f64,
    /// White noise of the output, V.
    pub output_noise: f64,
    /// Amplitude (V) and frequency (Hz) of the hum in it.
    pub hum: [f64; 2],
}

impl Default for QuadratureInterferometer {
    /// Amplitudes a tenth apart, offsets of a tenth, 5° of phase error, half a per cent of noise, 0.3 µm at 23 Hz, 1 µm/s.
    fn default() -> Self {
        Self {
            wavelength: 632.8e-9,
            offset: [0.08, -0.05],
            amplitude: [1.0, 0.9],
            phase: 0.087,
            noise: 5e-3,
            vibration: [0.3e-6, 23.0],
            drift: 1e-6,
        }
    }
}

impl Default for PrimaryBench {
    /// 200 kHz, 0.3 % of distortion, 50 µV of noise and 100 µV of hum at 50 Hz.
    fn default() -> Self {
        Self {
            interferometer: QuadratureInterferometer::default(),
            rate: 200e3,
            distortion: 3e-3,
            voltage: 0.0,
            output_offset: 2e-3,
            output_noise: 5e-5,
            hum: [1e-4, 50.0],
        }
    }
}

/// Response of a mass on a spring behind a high-pass, relative to its middle: natural frequency and corner in Hz.
pub fn device_response(frequency: f64, natural: f64, damping: f64, corner: f64) -> Complex64 {
    let (r, low) = (frequency / natural, Complex64::new(0.0, frequency / corner));
    low / (1.0 + low) / Complex64::new(1.0 - r * r, 2.0 * damping * r)
}

impl PrimaryBench {
    /// The bench with errors that are drawn: wavelength and voltage by their relative standard uncertainties, offsets by a twentieth,
    /// the second amplitude by a twentieth about nine tenths, the phase by 0.08 rad.
    #[must_use]
    pub fn drawn(mut self, wavelength: f64, voltage: f64, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut draw = |u: f64| u * normal(&mut rng);
        self.voltage = draw(voltage);
        let laser = &mut self.interferometer;
        laser.wavelength *= 1.0 + draw(wavelength);
        laser.offset = [draw(0.05), draw(0.05)];
        laser.amplitude = [1.0, 0.9 + draw(0.05)];
        laser.phase = draw(0.08);
        self
    }

    /// The two signals and the output of a sensor of this sensitivity (V/(m/s²) at a frequency in Hz) while the table moves with a
    /// displacement of this amplitude (m). Phases are drawn.
    ///
    /// ```
    /// use num_complex::Complex64;
    /// use proofmass_rig::PrimaryBench;
    /// let bench = PrimaryBench::default();
    /// let [cosine, ..] = bench.record(160.0, 1e-5, 0.1, |_| Complex64::new(0.01, 0.0), 1);
    /// assert_eq!(cosine.len(), 20_000);
    /// ```
    pub fn record(
        &self,
        frequency: f64,
        amplitude: f64,
        duration: f64,
        sensitivity: impl Fn(f64) -> Complex64,
        seed: u64,
    ) -> [Vec<f64>; 3] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut turn = || TAU * rng.random::<f64>();
        let [drive, second, base, hum, start] = std::array::from_fn(|_| turn());
        let laser = &self.interferometer;
        let samples = (duration * self.rate).round() as usize;
        let omega = TAU * frequency;
        // Displacement at Ω and 2Ω, and what the sensor makes of their accelerations.
        let lines = [
            (1.0, Complex64::from_polar(amplitude, drive)),
            (
                2.0,
                Complex64::from_polar(0.25 * self.distortion * amplitude, second),
            ),
        ];
        let outputs = lines.map(|(order, s)| {
            (
                order,
                s * -(order * omega).powi(2)
                    * sensitivity(order * frequency)
                    * (1.0 + self.voltage),
            )
        });
        let sine = |[amplitude, frequency]: [f64; 2], at: f64, t: f64| {
            amplitude * libm::sin(TAU * (frequency * t).fract() + at)
        };
        let at = |lines: &[(f64, Complex64); 2], t: f64| -> f64 {
            let each = lines.iter().map(|(order, z)| {
                let angle = TAU * (order * frequency * t).fract();
                z.re * libm::cos(angle) - z.im * libm::sin(angle)
            });
            each.sum()
        };
        let mut channels: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(samples));
        for k in 0..samples {
            let t = k as f64 / self.rate;
            let path = at(&lines, t) + sine(laser.vibration, base, t) + laser.drift * t;
            let phase = start + 4.0 * PI * path / laser.wavelength;
            let (a, b) = (libm::cos(phase), libm::sin(phase + laser.phase));
            channels[0]
                .push(laser.offset[0] + laser.amplitude[0] * a + laser.noise * normal(&mut rng));
            channels[1]
                .push(laser.offset[1] + laser.amplitude[1] * b + laser.noise * normal(&mut rng));
            channels[2].push(
                self.output_offset
                    + at(&outputs, t)
                    + sine(self.hum, hum, t)
                    + self.output_noise * normal(&mut rng),
            );
        }
        channels
    }
}
