//! A campaign as a laboratory runs it: the device glued, the shaker levelled, every run recorded, and the truth.

use super::shaker::{Levelling, Shaker};
use super::waveform::Acquisition;
use super::{
    Bench, BenchVibrometer, VibrometerReading, normal, seen_from_device, target_amplitude,
};
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Serialize;
use std::collections::BTreeMap;

/// The reference standard under the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceStandard {
    /// Sensitivity on its certificate far below resonance, V/(m/s²).
    pub(crate) sensitivity: f64,
    /// Resonance in Hz.
    pub(crate) resonance: f64,
    /// Low corner of its amplifier in Hz.
    pub(crate) corner: f64,
}

impl Default for ReferenceStandard {
    fn default() -> Self {
        Self {
            sensitivity: 9.9e-3,
            resonance: 40e3,
            corner: 0.3,
        }
    }
}

impl ReferenceStandard {
    /// Sensitivity at a frequency in Hz as an ideal certificate states it.
    pub fn at(&self, frequency: f64) -> Complex64 {
        let x = frequency / self.resonance;
        let corner = Complex64::new(1.0, -self.corner / frequency).inv();
        corner * (self.sensitivity / (1.0 - x * x))
    }
}

/// Everything on the bench.
#[derive(Clone, Debug, PartialEq)]
pub struct Laboratory {
    /// Device, wedges and errors.
    pub bench: Bench,
    /// The shaker.
    pub shaker: Shaker,
    /// Its closed loop.
    pub levelling: Levelling,
    /// The reference standard.
    pub reference: ReferenceStandard,
    /// The acquisition.
    pub acquisition: Acquisition,
    /// Relative difference of the clocks of generator and acquisition.
    pub clock: f64,
    /// The vibrometer.
    pub vibrometer: BenchVibrometer,
}

impl Default for Laboratory {
    /// The published bench with its wedges, a generator 20 ppm off, a vibrometer that repeats to 0.2 %.
    fn default() -> Self {
        Self {
            bench: Bench {
                wedge: Some(super::BenchWedge::default()),
                ..Bench::default()
            },
            shaker: Shaker::default(),
            levelling: Levelling::default(),
            reference: ReferenceStandard::default(),
            acquisition: Acquisition::default(),
            clock: 2e-5,
            vibrometer: BenchVibrometer {
                reading: 0.002,
                ..BenchVibrometer::default()
            },
        }
    }
}

/// What goes wrong in one run, for practice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BenchFault {
    /// The cables of x and y are exchanged.
    SwappedCables,
    /// The output z is inverted.
    InvertedChannel,
    /// The gain of x drives the acquisition beyond full scale.
    Clipped,
    /// The generator runs a tenth above the frequency of the table.
    WrongFrequency,
    /// The device is glued 45° further than the table says.
    WrongMounting,
}

/// Why a run could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Unreached {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Amplitude wanted in m/s².
    pub target: f64,
}

/// One run before its samples are taken.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PreparedRun {
    /// Nominal frequency in Hz.
    pub frequency: f64,
    /// Nominal inclination in degrees.
    pub inclination_deg: f64,
    /// Nominal rotation in degrees.
    pub rotation_deg: f64,
    /// Amplitude wanted, m/s².
    pub target: f64,
    /// Drive that the closed loop ended at, V.
    pub drive: f64,
    /// Transverse motion relative to the excitation.
    pub transverse: f64,
    /// Frequency the acquisition sees, Hz.
    pub(crate) seen: f64,
    /// Reference, x, y, z in V: the fundamental and its harmonics.
    pub volts: [[Complex64; 3]; 4],
}

/// True values of one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FrequencyTruth {
    /// Frequency in Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency: f64,
    /// S, o = a S: real and imaginary parts, row by row, V/(m/s²).
    #[serde(rename = "S_V_per_m_per_s2")]
    pub sensitivity: [[[f64; 2]; 3]; 3],
    /// True sensitivity of the reference over that of its certificate, real and imaginary part.
    pub reference_over_certificate: [f64; 2],
}

/// True error of a mounting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AngleTruth {
    /// Nominal inclination in degrees.
    pub inclination_deg: f64,
    /// Nominal rotation in degrees; `None` for a wedge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<f64>,
    /// Error in degrees.
    pub error_deg: f64,
}

/// What only a simulation knows.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Truth {
    /// Seed of everything random.
    pub seed: u64,
    /// By frequency.
    pub frequencies: Vec<FrequencyTruth>,
    /// Errors of the wedges.
    pub wedges: Vec<AngleTruth>,
    /// Errors of the gluings.
    pub gluings: Vec<AngleTruth>,
    /// Gain errors of the conditioner, x, y, z.
    pub gains: [f64; 3],
}

/// A laboratory with its device glued and its errors drawn; runs are made one at a time, each from a random source of
/// its own, so that they may be made in any order and none needs the memory of another.
#[derive(Clone, Debug)]
pub struct Setup {
    laboratory: Laboratory,
    plan: Vec<(f64, f64)>,
    frequencies: Vec<f64>,
    seed: u64,
    wedges: BTreeMap<i64, f64>,
    gluings: BTreeMap<(i64, i64), f64>,
    gains: [f64; 3],
    certificates: Vec<Complex64>,
}

fn key(degrees: f64) -> i64 {
    (degrees * 1e6).round() as i64
}

impl Laboratory {
    /// Draws what stays the same over a campaign: angles of wedges and gluings, gains, errors of the certificate.
    ///
    /// **Units** plan in degrees (inclination, rotation), frequencies in Hz.
    pub fn set_up(&self, plan: &[(f64, f64)], frequencies: &[f64], seed: u64) -> Setup {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let bench = &self.bench;
        let (mut wedges, mut gluings) = (BTreeMap::new(), BTreeMap::new());
        for &(inclination, rotation) in plan {
            wedges
                .entry(key(inclination))
                .or_insert_with(|| bench.type_b(bench.wedge_angle, &mut rng));
            gluings
                .entry((key(inclination), key(rotation)))
                .or_insert_with(|| bench.type_b(bench.gluing_angle, &mut rng));
        }
        Setup {
            plan: plan.to_vec(),
            frequencies: frequencies.to_vec(),
            seed,
            wedges,
            gluings,
            gains: std::array::from_fn(|_| 1.0 + bench.type_b(bench.gain, &mut rng)),
            certificates: frequencies
                .iter()
                .map(|_| {
                    Complex64::from_polar(
                        1.0 + bench.reference_modulus * normal(&mut rng),
                        bench.reference_phase * normal(&mut rng),
                    )
                })
                .collect(),
            laboratory: self.clone(),
        }
    }
}

impl Setup {
    /// Number of runs: every configuration at every frequency, frequency by frequency.
    pub fn len(&self) -> usize {
        self.plan.len() * self.frequencies.len()
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What only a simulation knows.
    pub fn truth(&self) -> Truth {
        let pair = |z: Complex64| [z.re, z.im];
        Truth {
            seed: self.seed,
            frequencies: self
                .frequencies
                .iter()
                .zip(&self.certificates)
                .map(|(&frequency, &c)| FrequencyTruth {
                    frequency,
                    sensitivity: self
                        .laboratory
                        .bench
                        .device
                        .sensitivity(frequency)
                        .map(|row| row.map(pair)),
                    reference_over_certificate: pair(c),
                })
                .collect(),
            wedges: self
                .wedges
                .iter()
                .map(|(&inclination, error)| AngleTruth {
                    inclination_deg: inclination as f64 * 1e-6,
                    rotation_deg: None,
                    error_deg: error.to_degrees(),
                })
                .collect(),
            gluings: self
                .gluings
                .iter()
                .map(|(&(inclination, rotation), error)| AngleTruth {
                    inclination_deg: inclination as f64 * 1e-6,
                    rotation_deg: Some(rotation as f64 * 1e-6),
                    error_deg: error.to_degrees(),
                })
                .collect(),
            gains: self.gains,
        }
    }

    /// A random source for one thing, apart from all others of the campaign.
    fn source(&self, stream: u64) -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(
            self.seed ^ stream.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
        )
    }

    /// Levels the shaker for a run and gives the phasors of its four channels.
    ///
    /// # Errors
    /// [`Unreached`] when the closed loop does not end at the target.
    pub fn prepare(&self, run: usize, fault: Option<BenchFault>) -> Result<PreparedRun, Unreached> {
        let lab = &self.laboratory;
        let bench = &lab.bench;
        let mut rng = self.source(2 * run as u64);
        let place = run / self.plan.len();
        let (frequency, certificate) = (self.frequencies[place], self.certificates[place]);
        let (inclination, rotation) = self.plan[run % self.plan.len()];
        let driven = match fault {
            Some(BenchFault::WrongFrequency) => 1.1 * frequency,
            _ => frequency,
        };
        let target = target_amplitude(frequency);
        // What the operator reads: the reference through its certificate, with a little noise.
        let reading_at = |drive: f64| {
            let a = lab.shaker.motion(drive, driven)[0].norm();
            a * certificate.norm() * (1.0 + 1e-3 * normal(&mut rng))
        };
        let levelled = lab
            .levelling
            .run(target, reading_at)
            .ok_or(Unreached { frequency, target })?;
        let start = std::f64::consts::TAU * rng.random::<f64>();
        let motion = lab.shaker.motion(levelled.drive, driven);
        let further = match fault {
            Some(BenchFault::WrongMounting) => 45f64.to_radians(),
            _ => 0.0,
        };
        let r = seen_from_device(
            inclination.to_radians() + self.wedges[&key(inclination)],
            rotation.to_radians() + further + self.gluings[&(key(inclination), key(rotation))],
        );
        let reading: [Complex64; 3] = std::array::from_fn(|_| {
            Complex64::from_polar(
                1.0 + bench.reading * normal(&mut rng),
                bench.reading_phase * normal(&mut rng),
            )
        });
        let mut volts = [[Complex64::new(0.0, 0.0); 3]; 4];
        for (h, motion) in motion.iter().enumerate() {
            let f = (h + 1) as f64 * driven;
            let table = motion * Complex64::from_polar(1.0, (h + 1) as f64 * start);
            let mut e = bench
                .wedge
                .as_ref()
                .map_or([Complex64::new(0.0, 0.0); 3], |w| w.ratio(inclination, f));
            e[2] += 1.0;
            let a: [Complex64; 3] =
                std::array::from_fn(|i| (0..3).map(|k| e[k] * r[i][k]).sum::<Complex64>() * table);
            let s = bench.device.sensitivity(f);
            volts[0][h] = table * certificate * lab.reference.at(f);
            for j in 0..3 {
                let o: Complex64 = (0..3).map(|i| a[i] * s[i][j]).sum();
                volts[j + 1][h] = o * self.gains[j] * reading[j];
            }
        }
        for output in &mut volts[1..] {
            output[0] += Complex64::new(normal(&mut rng), normal(&mut rng)) * bench.floor;
        }
        match fault {
            Some(BenchFault::SwappedCables) => volts.swap(1, 2),
            Some(BenchFault::InvertedChannel) => volts[3] = volts[3].map(|v| -v),
            Some(BenchFault::Clipped) => {
                let gain = 1.3 * lab.acquisition.full_scale / volts[1][0].norm().max(1e-9);
                volts[1] = volts[1].map(|v| v * gain);
            }
            _ => {}
        }
        Ok(PreparedRun {
            frequency,
            inclination_deg: inclination,
            rotation_deg: rotation,
            target,
            drive: levelled.drive,
            transverse: bench
                .wedge
                .as_ref()
                .map_or(0.0, |w| w.transverse_motion(inclination, frequency)),
            seen: driven * (1.0 + lab.clock),
            volts,
        })
    }

    /// The samples of a prepared run: reference, x, y, z.
    pub fn record(&self, run: usize, prepared: &PreparedRun) -> [Vec<f64>; 4] {
        let mut rng = self.source(2 * run as u64 + 1);
        let daq = &self.laboratory.acquisition;
        std::array::from_fn(|k| daq.channel(&prepared.volts[k], prepared.seen, &mut rng))
    }

    /// Repeated vibrometer readings along an axis of the table (0 for x′ to 2 for z′), at an inclination and a
    /// frequency of the campaign. Along z′ the whole motion is seen.
    pub fn vibrometer(
        &self,
        inclination_deg: f64,
        frequency: f64,
        axis: usize,
        repeats: usize,
    ) -> Vec<VibrometerReading> {
        let lab = &self.laboratory;
        let stream = key(inclination_deg) as u64 ^ ((key(frequency) as u64) << 20) ^ axis as u64;
        let mut rng = self.source(stream ^ (1 << 62));
        let ratio = lab
            .bench
            .wedge
            .as_ref()
            .map_or([Complex64::new(0.0, 0.0); 3], |w| {
                w.ratio(inclination_deg, frequency)
            });
        let whole = f64::from(axis == 2);
        let seen = ratio
            .get(axis)
            .map_or(Complex64::new(0.0, 0.0), |r| r + whole);
        lab.vibrometer.repeats(seen, frequency, repeats, &mut rng)
    }
}

#[cfg(test)]
mod tests {
    use super::super::published_plan;
    use super::*;

    #[test]
    fn law_every_run_reaches_its_target_and_holds_the_device() {
        let setup = Laboratory::default().set_up(&published_plan(), &[5.0, 160.0, 1000.0], 3);
        assert_eq!(setup.len(), 132);
        for run in [0, 40, 60, 131] {
            let p = setup.prepare(run, None).unwrap();
            let a = p.volts[0][0] / Laboratory::default().reference.at(p.frequency);
            // 1 % of the loop and three times 0.1 % of its noise.
            assert!((a.norm() / p.target - 1.0).abs() < 0.013);
            // The same run twice is the same run.
            assert_eq!(setup.prepare(run, None).unwrap(), p);
        }
        // Flat on the table z alone sees the excitation: 0.34 % of reading, 1° of tilt and the cross terms aside.
        let flat = setup.prepare(44, None).unwrap();
        let truth = setup.truth().frequencies[1].sensitivity[2][2];
        let a = flat.volts[0][0] / Laboratory::default().reference.at(160.0);
        let s = (flat.volts[3][0] / a).norm();
        assert!((s / truth[0].hypot(truth[1]) - 1.0).abs() < 0.03);
    }

    #[test]
    fn law_faults_are_what_they_are_called() {
        let setup = Laboratory::default().set_up(&published_plan(), &[160.0], 3);
        let good = setup.prepare(20, None).unwrap();
        let swapped = setup.prepare(20, Some(BenchFault::SwappedCables)).unwrap();
        assert_eq!(good.volts[1], swapped.volts[2]);
        let inverted = setup
            .prepare(20, Some(BenchFault::InvertedChannel))
            .unwrap();
        assert_eq!(good.volts[3][0], -inverted.volts[3][0]);
        let clipped = setup.prepare(20, Some(BenchFault::Clipped)).unwrap();
        let samples = setup.record(20, &clipped);
        assert!(samples[1].iter().any(|v| v.abs() == 10.0));
    }
}
