//! A digital sensor that samples by itself beside the recording of the bench.

use super::laboratory::PreparedRun;
use super::waveform::Acquisition;
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// The device of the bench as a digital sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DigitalSensor {
    /// Whether it samples by a clock of its own; else the clock of the bench stamps its samples.
    pub own_clock: bool,
    /// Sampling rate that it states, Hz.
    pub rate: f64,
    /// Samples its own clock takes in a second over those it states, less one.
    pub clock_error: f64,
    /// What that wanders from run to run, relative.
    pub wander: f64,
    /// Delay of its samples by its filter, s.
    pub delay: f64,
    /// Scatter of the instants at which stamped samples are taken, in steps.
    pub jitter: f64,
    /// Full scale in the unit of the device.
    pub full_scale: f64,
    /// Bits of its converter.
    pub bits: u32,
    /// Duration of a recording, s.
    pub duration: f64,
}

impl Default for DigitalSensor {
    /// 4 kHz, 1.23 % fast, 16 bits of ±2 V, a filter of 1.7 ms.
    fn default() -> Self {
        Self {
            own_clock: true,
            rate: 4000.0,
            clock_error: 0.0123,
            wander: 2e-8,
            delay: 1.7e-3,
            jitter: 0.02,
            full_scale: 2.0,
            bits: 16,
            duration: 2.0,
        }
    }
}

/// What a sensor files of a run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SensorRecord {
    /// Time stamps in s; none by a clock of its own.
    pub stamps: Vec<f64>,
    /// Counts along x, y, z.
    pub counts: [Vec<f64>; 3],
}

impl DigitalSensor {
    /// Least significant bit in the unit of the device.
    pub fn lsb(&self) -> f64 {
        2.0 * self.full_scale / 2f64.powi(self.bits as i32)
    }

    /// Samples of a prepared run, which begin when they begin.
    pub fn record(&self, run: usize, seed: u64, prepared: &PreparedRun) -> SensorRecord {
        let stream = (run as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ stream ^ (1 << 61));
        // Even, of standard deviation one.
        let mut even = |size: f64| size * 12f64.sqrt() * (rng.random::<f64>() - 0.5);
        let own = self.own_clock;
        let rate = match own {
            true => self.rate * (1.0 + self.clock_error + even(self.wander)),
            false => self.rate,
        };
        let begin = even(if own { 0.3 } else { 0.001 });
        let daq = Acquisition {
            sampling_frequency: rate,
            duration: self.duration,
            full_scale: self.full_scale,
            bits: self.bits,
            ..Acquisition::default()
        };
        let late: Vec<f64> = (0..daq.samples())
            .map(|_| if own { 0.0 } else { even(self.jitter) / rate })
            .collect();
        let omega = TAU * prepared.seen;
        let counts = [1, 2, 3].map(|k: usize| {
            let volts = prepared.volts[k].iter().enumerate();
            let phasors: Vec<Complex64> = volts
                .map(|(h, z)| {
                    let angle = (h + 1) as f64 * omega * (begin - self.delay);
                    z * Complex64::from_polar(1.0, angle)
                })
                .collect();
            let samples = daq.channel(&phasors, prepared.seen, &mut rng);
            samples
                .iter()
                .zip(&late)
                .enumerate()
                .map(|(i, (v, late))| {
                    // What the fundamental does until the sample is taken.
                    let turn = Complex64::from_polar(1.0, omega * i as f64 / rate);
                    let step = Complex64::from_polar(1.0, omega * late) - 1.0;
                    ((v + (phasors[0] * turn * step).re) / self.lsb()).round()
                })
                .collect()
        });
        let stamps = match own {
            true => vec![],
            false => late
                .iter()
                .enumerate()
                .map(|(i, late)| begin + i as f64 / rate + late)
                .collect(),
        };
        SensorRecord { stamps, counts }
    }
}
