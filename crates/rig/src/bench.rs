//! The shaker bench: shaker, wedges, transducers, conditioner, sampling, vibrometers, with known truth.
//!
//! Two depths of the same bench: [`Bench::campaign`] gives phasors, as cheap as the statistics need them; a
//! [`laboratory::Laboratory`] levels the [`shaker`] for every run and records its [`waveform`], with distortion, noise and
//! quantisation.
//!
//! The geometry is composed here from elementary rotations, apart from the formulas of the calibration, so that
//! one checks the other.

mod device;
pub mod laboratory;
pub mod sensor;
pub mod shaker;
mod vibrometer;
pub mod waveform;

pub use device::{BenchDevice, BenchWedge, Bending};
pub use vibrometer::{BenchVibrometer, VibrometerReading};

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;

/// Distribution the bench draws its type B errors from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// Normal with the standard deviation of the half width over √3.
    Normal,
    /// Rectangular with that half width.
    Rectangular,
}

/// A bench with its imperfections; the defaults are those of the published bench.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// What is calibrated.
    pub device: BenchDevice,
    /// Relative standard uncertainty of the reference calibration, one draw per frequency.
    pub reference_modulus: f64,
    /// Standard uncertainty of its phase in radians, one draw per frequency.
    pub reference_phase: f64,
    /// Half width of the wedge angles in radians, one draw per wedge.
    pub wedge_angle: f64,
    /// Half width of the gluing angles in radians, one draw per wedge and rotation.
    pub gluing_angle: f64,
    /// Half width of the relative gain error, one draw per output channel.
    pub gain: f64,
    /// Relative standard deviation of the modulus of one reading of one output.
    pub reading: f64,
    /// Standard deviation of its phase in radians.
    pub reading_phase: f64,
    /// Standard deviation of the additive noise of an output phasor in V, in each part.
    pub floor: f64,
    /// Wedge and shaker motion beside the excitation; `None` for an ideal table.
    pub wedge: Option<BenchWedge>,
    /// Standard deviation of each part of the measured spurious ratios.
    pub spurious_reading: f64,
    /// Distribution of wedge, gluing and gain errors.
    pub spread: Spread,
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            device: BenchDevice::default(),
            reference_modulus: 0.002,
            reference_phase: 0.003,
            wedge_angle: 0.1f64.to_radians(),
            gluing_angle: 1f64.to_radians(),
            gain: 0.0015,
            reading: 0.0034,
            reading_phase: 0.003,
            floor: 5e-5,
            wedge: None,
            spurious_reading: 0.001,
            spread: Spread::Rectangular,
        }
    }
}

/// A run as the laboratory sees it: phasors in volts and m/s².
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// Drive frequency in Hz.
    pub frequency: f64,
    /// Nominal inclination in degrees.
    pub inclination_deg: f64,
    /// Nominal rotation in degrees.
    pub rotation_deg: f64,
    /// Acceleration by the reference standard, with its calibration error, m/s².
    pub reference: Complex64,
    /// Outputs in V.
    pub outputs: [Complex64; 3],
}

/// Spurious motion as measured: relative to the excitation, at one inclination and frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SpuriousReading {
    /// Inclination in degrees.
    pub inclination_deg: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Ratios along x′, y′, z′.
    pub ratio: [Complex64; 3],
    /// Standard deviation of each part.
    pub standard_uncertainty: f64,
}

/// A simulated campaign.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BenchCampaign {
    /// Runs, frequency by frequency in the order of the plan.
    pub runs: Vec<Run>,
    /// Measured spurious motion; empty for an ideal table.
    pub spurious: Vec<SpuriousReading>,
    /// True S of every frequency, V/(m/s²), o = a S.
    pub truth: Vec<[[Complex64; 3]; 3]>,
}

/// Amplitude a laboratory drives at: 3 m/s² below 10 Hz, 10 m/s² from there.
pub fn target_amplitude(frequency: f64) -> f64 {
    if frequency < 10.0 { 3.0 } else { 10.0 }
}

/// R_y then R_z: the columns are the table's axes seen from the device.
pub(crate) fn seen_from_device(inclination: f64, rotation: f64) -> [[f64; 3]; 3] {
    let ((sa, ca), (sw, cw)) = (inclination.sin_cos(), rotation.sin_cos());
    let tip = [[ca, 0.0, sa], [0.0, 1.0, 0.0], [-sa, 0.0, ca]];
    let turn = [[cw, -sw, 0.0], [sw, cw, 0.0], [0.0, 0.0, 1.0]];
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * tip[k][j]).sum()))
}

impl Bench {
    pub(crate) fn type_b<R: Rng + ?Sized>(&self, half_width: f64, rng: &mut R) -> f64 {
        match self.spread {
            Spread::Normal => half_width / 3f64.sqrt() * normal(rng),
            Spread::Rectangular => match Uniform::new_inclusive(-half_width, half_width) {
                Ok(uniform) => uniform.sample(rng),
                Err(_) => 0.0,
            },
        }
    }

    /// A campaign over a plan of (inclination, rotation) in degrees and some frequencies in Hz.
    pub fn campaign<R: Rng + ?Sized>(
        &self,
        plan: &[(f64, f64)],
        frequencies: &[f64],
        rng: &mut R,
    ) -> BenchCampaign {
        let key = |d: f64| (d * 1e6).round() as i64;
        let (mut wedges, mut gluings) = (BTreeMap::new(), BTreeMap::new());
        for &(inclination, rotation) in plan {
            wedges
                .entry(key(inclination))
                .or_insert_with(|| self.type_b(self.wedge_angle, rng));
            gluings
                .entry((key(inclination), key(rotation)))
                .or_insert_with(|| self.type_b(self.gluing_angle, rng));
        }
        let gains: [f64; 3] = std::array::from_fn(|_| 1.0 + self.type_b(self.gain, rng));
        let mut campaign = BenchCampaign {
            runs: vec![],
            spurious: vec![],
            truth: vec![],
        };
        for &frequency in frequencies {
            let truth = self.device.sensitivity(frequency);
            campaign.truth.push(truth);
            let certificate = Complex64::from_polar(
                1.0 + self.reference_modulus * normal(rng),
                self.reference_phase * normal(rng),
            );
            let mut measured = BTreeMap::new();
            for &(inclination, rotation) in plan {
                let ratio = self
                    .wedge
                    .as_ref()
                    .map_or([Complex64::new(0.0, 0.0); 3], |w| {
                        w.ratio(inclination, frequency)
                    });
                if self.wedge.is_some() && !measured.contains_key(&key(inclination)) {
                    let u = self.spurious_reading;
                    let ratio = ratio.map(|e| e + Complex64::new(normal(rng), normal(rng)) * u);
                    measured.insert(key(inclination), ());
                    campaign.spurious.push(SpuriousReading {
                        inclination_deg: inclination,
                        frequency,
                        ratio,
                        standard_uncertainty: u,
                    });
                }
                let r = seen_from_device(
                    inclination.to_radians() + wedges[&key(inclination)],
                    rotation.to_radians() + gluings[&(key(inclination), key(rotation))],
                );
                let mut e = ratio;
                e[2] += 1.0;
                let phase = std::f64::consts::TAU * (0.5 + 0.1 * normal(rng));
                let table = Complex64::from_polar(target_amplitude(frequency), phase);
                let a: [Complex64; 3] = std::array::from_fn(|i| {
                    (0..3).map(|k| e[k] * r[i][k]).sum::<Complex64>() * table
                });
                let outputs = std::array::from_fn(|j| {
                    let o: Complex64 = (0..3).map(|i| a[i] * truth[i][j]).sum();
                    let reading = Complex64::from_polar(
                        1.0 + self.reading * normal(rng),
                        self.reading_phase * normal(rng),
                    );
                    o * gains[j] * reading + Complex64::new(normal(rng), normal(rng)) * self.floor
                });
                campaign.runs.push(Run {
                    frequency,
                    inclination_deg: inclination,
                    rotation_deg: rotation,
                    reference: table * certificate,
                    outputs,
                });
            }
        }
        campaign
    }
}

/// Gains of the outputs in each of some sessions: normal about one in modulus and phase, with this standard deviation (relative, rad).
///
/// They are drawn apart from a campaign of the same seed, whose numbers they leave as they are.
pub fn session_gains(count: usize, u: f64, seed: u64) -> Vec<[Complex64; 3]> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5E55);
    let mut gain = |()| Complex64::from_polar(1.0 + u * normal(&mut rng), u * normal(&mut rng));
    (0..count).map(|_| [(); 3].map(&mut gain)).collect()
}

/// The published 44 configurations, (inclination, rotation) in degrees.
pub fn published_plan() -> Vec<(f64, f64)> {
    let mut plan: Vec<_> = (0..4).map(|i| (0.0, 90.0 * f64::from(i))).collect();
    for inclination in [15.0, 35.0, 55.0, 75.0, 90.0] {
        plan.extend((0..8).map(|i| (inclination, 45.0 * f64::from(i))));
    }
    plan
}

pub(crate) fn normal<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    StandardNormal.sample(rng)
}
