//! One axis turned from rest to rest at known angles.

use crate::hand_held::Rest;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is simulated: the output b + S g cos(θ + φ) of one axis, in m/s² where S is about 1.
///
/// **Units** angles in rad, times in s, everything else in the unit of the output.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TurnedAxis {
    /// Angles between the axis and the vertical, in order.
    pub angles: Vec<f64>,
    /// Bias.
    pub bias: f64,
    /// Sensitivity.
    pub sensitivity: f64,
    /// Angle of the axis beside the zero of the scale.
    pub misalignment: f64,
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Mean duration of a rest; the actual ones vary by ±20 %.
    pub rest: f64,
    /// Duration of a turn.
    pub turn: f64,
    /// Standard deviation of an angle about its nominal value.
    pub setting: f64,
    /// Standard deviation of the noise of one sample.
    pub noise: f64,
    /// Step of the output; zero for none.
    pub resolution: f64,
    /// Amplitude of the swing while it turns; a turntable has hardly any, a hand some m/s².
    pub jolt: f64,
    /// Probability that a rest is touched: half a second of motion of 0.1 to 1 m/s² somewhere in it.
    pub touched: f64,
    /// Standard deviation of a tremor that comes and goes, about 1 s long, in every rest.
    pub tremor: f64,
}

impl Default for TurnedAxis {
    /// Twelve angles by a turntable.
    fn default() -> Self {
        Self {
            angles: (0..12).map(|i| f64::from(30 * i).to_radians()).collect(),
            bias: 0.05,
            sensitivity: 1.01,
            misalignment: 0.01,
            gravity: 9.80665,
            rate: 100.0,
            rest: 5.0,
            turn: 1.0,
            setting: 0.0,
            noise: 0.01,
            resolution: 0.0,
            jolt: 1.0,
            touched: 0.0,
            tremor: 0.0,
        }
    }
}

/// A simulated recording of one axis with its truth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TurnedAxisRecording {
    /// Outputs.
    pub output: Vec<f64>,
    /// True rests; the attitude is the cosine and the sine of the true angle.
    pub rests: Vec<Rest>,
}

impl TurnedAxis {
    /// Makes the recording that belongs to a seed.
    pub fn simulate(&self, seed: u64) -> TurnedAxisRecording {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let normal = |rng: &mut Xoshiro256PlusPlus| -> f64 { StandardNormal.sample(rng) };
        let mut output: Vec<f64> = Vec::new();
        let mut rests = Vec::with_capacity(self.angles.len());
        let actual: Vec<f64> = self
            .angles
            .iter()
            .map(|a| a + self.setting * normal(&mut rng))
            .collect();
        let read = |angle: f64, added: f64, rng: &mut Xoshiro256PlusPlus| {
            let force = self.gravity * (angle + self.misalignment).cos() + added;
            let value = self.bias + self.sensitivity * force + self.noise * normal(rng);
            if self.resolution > 0.0 {
                (value / self.resolution).round() * self.resolution
            } else {
                value
            }
        };
        let half = (0.25 * self.rate).round().max(1.0);
        let mut sway = 0.0;
        // A first-order process of half a second.
        let kept = (-2.0 / self.rate).exp();
        for (index, angle) in actual.iter().enumerate() {
            let start = output.len();
            let n = (self.rest * (0.8 + 0.4 * rng.random::<f64>()) * self.rate).round() as usize;
            let touch = (rng.random::<f64>() < self.touched).then(|| {
                let size = 0.1 * 10f64.powf(rng.random::<f64>());
                let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
                (rng.random::<f64>() * n as f64, side * size)
            });
            for i in 0..n {
                sway = kept * sway + self.tremor * (1.0 - kept * kept).sqrt() * normal(&mut rng);
                let swell =
                    (std::f64::consts::TAU * i as f64 / self.rate / self.rest.max(2.0)).sin();
                let touched = touch.map_or(0.0, |(at, size)| {
                    let near = ((i as f64 - at) / half).abs();
                    if near < 1.0 {
                        size * (std::f64::consts::PI * (1.0 + near)).sin()
                    } else {
                        0.0
                    }
                });
                let value = read(*angle, sway * swell * swell + touched, &mut rng);
                output.push(value);
            }
            rests.push(Rest {
                start,
                end: output.len(),
                attitude: [angle.cos(), angle.sin(), 0.0],
            });
            let Some(next) = actual.get(index + 1) else {
                break;
            };
            let n = (self.turn * self.rate).round() as usize;
            let jolt = self.jolt * (0.4 + 0.6 * rng.random::<f64>());
            let turns = 1.0 + 2.0 * rng.random::<f64>();
            for i in 0..n {
                let share = (i as f64 + 0.5) / n as f64;
                let ramp = 0.5 - 0.5 * (std::f64::consts::PI * share).cos();
                let swing = (std::f64::consts::PI * share).sin()
                    * (std::f64::consts::TAU * turns * share).sin();
                let value = read(angle + ramp * (next - angle), jolt * swing, &mut rng);
                output.push(value);
            }
        }
        TurnedAxisRecording { output, rests }
    }
}
