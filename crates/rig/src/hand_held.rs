//! A sensor turned by hand from rest to rest, as for a multi-position calibration.

use proofmass_core::{Matrix3, SensorModel};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is simulated.
///
/// **Units** sensor: output unit per m/s² and output unit; times in s; `noise` and `resolution` in output units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandHeld {
    /// The sensor, ã = K a + b.
    pub sensor: SensorModel<f64>,
    /// Local gravity, m/s².
    pub gravity: f64,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Number of rests in different attitudes.
    pub rests: usize,
    /// Duration of each rest, s; the actual ones vary by ±20 %.
    pub rest: f64,
    /// Duration of each turn between rests, s.
    pub turn: f64,
    /// How far the attitudes are off the intended ones, largest component of a unit vector: 0.15 for a hand, 0
    /// for a precise fixture.
    pub askew: f64,
    /// Standard deviation of the noise of one sample.
    pub noise: f64,
    /// Correlation of the noise of neighbouring samples, first-order autoregression.
    pub correlation: f64,
    /// Standard deviation of an error common to all samples of a rest and new at the next, in m/s²: hysteresis
    /// and wander.
    pub wander: f64,
    /// Step of the output; zero for none.
    pub resolution: f64,
    /// Standard deviation of a tremor or of gusts that come and go within a rest, m/s²; correlated over half a second.
    pub tremor: f64,
    /// Probability that a rest is touched: half a second of motion of 0.1 to 1 m/s² somewhere in it.
    pub touched: f64,
    /// Random walk of the biases from the beginning to the end, the same on every axis, m/s²/√s.
    pub walk: f64,
    /// A bias with the sign of the last change of each axis from rest to rest, m/s².
    pub hysteresis: f64,
    /// Terms of each axis in the square and the third power of its acceleration, shares of 1 g at 1 g.
    pub curvature: [f64; 2],
}

impl Default for HandHeld {
    /// A 16-bit sensor of 415 counts/(m/s²) with offsets at mid-scale, as motion trackers have.
    fn default() -> Self {
        let k = Matrix3([[415.2, 1.4, 3.9], [0.0, 412.6, 8.7], [0.0, 0.0, 414.1]]);
        // The matrix above is invertible, so its model exists.
        let sensor = SensorModel::new(k, [33_120.0, 33_271.0, 32_366.0])
            .unwrap_or_else(|error| unreachable!("{error}"));
        Self {
            sensor,
            gravity: 9.80665,
            rate: 100.0,
            rests: 24,
            rest: 4.0,
            turn: 2.0,
            askew: 0.15,
            noise: 4.0,
            correlation: 0.0,
            wander: 0.0,
            resolution: 1.0,
            tremor: 0.0,
            touched: 0.0,
            walk: 0.0,
            hysteresis: 0.0,
            curvature: [0.0; 2],
        }
    }
}

/// A stretch of the recording during which the sensor rested.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Rest {
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Direction of the specific force in the axes of the sensor.
    pub attitude: [f64; 3],
}

/// A simulated recording with its truth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HandHeldRecording {
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Outputs x, y, z.
    pub outputs: [Vec<f64>; 3],
    /// True rests.
    pub rests: Vec<Rest>,
    /// Mean over the rests of what the biases walked, m/s².
    pub walked: [f64; 3],
}

impl HandHeld {
    /// Makes the recording that belongs to a seed.
    pub fn simulate(&self, seed: u64) -> HandHeldRecording {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let attitudes = attitudes(self.rests, self.askew, &mut rng);
        let mut outputs: [Vec<f64>; 3] = Default::default();
        let mut rests = Vec::with_capacity(self.rests);
        let mut noise = [0.0; 3];
        let innovation = self.noise * (1.0 - self.correlation.powi(2)).max(0.0).sqrt();
        let mut walk = [0.0; 3];
        let mut walked = [0.0; 3];
        let mut last = attitudes.first().copied().unwrap_or_default();
        let step = self.walk / self.rate.sqrt();
        let mut push =
            |force: [f64; 3], outputs: &mut [Vec<f64>; 3], rng: &mut Xoshiro256PlusPlus| {
                let clean = self.sensor.invert(force);
                for axis in 0..3 {
                    let w: f64 = StandardNormal.sample(rng);
                    noise[axis] = self.correlation * noise[axis] + innovation * w;
                    let value = clean[axis] + noise[axis];
                    outputs[axis].push(if self.resolution > 0.0 {
                        (value / self.resolution).round() * self.resolution
                    } else {
                        value
                    });
                }
            };
        for (index, attitude) in attitudes.iter().enumerate() {
            let start = outputs[0].len();
            let duration = self.rest * (0.8 + 0.4 * rng.random::<f64>());
            let wander: [f64; 3] = std::array::from_fn(|_| {
                let w: f64 = StandardNormal.sample(&mut rng);
                self.wander * w
            });
            let n = (duration * self.rate).round() as usize;
            let mut unrest = Unrest::of(self, n, &mut rng);
            let [square, cube] = self.curvature;
            let systematic: [f64; 3] = std::array::from_fn(|i| {
                let u = attitude[i];
                let change = if index == 0 {
                    0.0
                } else {
                    (u - last[i]).signum()
                };
                self.hysteresis * change + self.gravity * (square * u * u + cube * u.powi(3))
            });
            last = *attitude;
            let mut mean = [0.0; 3];
            for sample in 0..n {
                let moved = unrest.next(sample, &mut rng);
                walk_on(&mut walk, step, &mut rng);
                let force = std::array::from_fn(|i| {
                    mean[i] += walk[i] / n as f64;
                    self.gravity * attitude[i] + wander[i] + moved[i] + systematic[i] + walk[i]
                });
                push(force, &mut outputs, &mut rng);
            }
            for (sum, m) in walked.iter_mut().zip(mean) {
                *sum += m / self.rests as f64;
            }
            rests.push(Rest {
                start,
                end: outputs[0].len(),
                attitude: *attitude,
            });
            let Some(next) = attitudes.get(index + 1) else {
                break;
            };
            let n = (self.turn * self.rate).round() as usize;
            let jolt: [f64; 3] = std::array::from_fn(|_| 2.0 + 3.0 * rng.random::<f64>());
            let frequency: [f64; 3] = std::array::from_fn(|_| 1.0 + 2.0 * rng.random::<f64>());
            for i in 0..n {
                let share = (i as f64 + 0.5) / n as f64;
                let direction = between(*attitude, *next, share);
                walk_on(&mut walk, step, &mut rng);
                // A hand does not only turn: it swings, most in the middle of the turn.
                let swing = (std::f64::consts::PI * share).sin();
                let force = std::array::from_fn(|axis| {
                    let phase = std::f64::consts::TAU * frequency[axis] * share * self.turn;
                    self.gravity * direction[axis] + jolt[axis] * swing * phase.sin()
                });
                push(force, &mut outputs, &mut rng);
            }
        }
        HandHeldRecording {
            rate: self.rate,
            outputs,
            rests,
            walked,
        }
    }
}

/// One step of a random walk; nothing is drawn where there is none.
fn walk_on(walk: &mut [f64; 3], step: f64, rng: &mut Xoshiro256PlusPlus) {
    if step > 0.0 {
        for value in walk {
            let w: f64 = StandardNormal.sample(rng);
            *value += step * w;
        }
    }
}

/// Motion within a rest. It draws nothing where there is none, so that a seed stays the recording that it was.
struct Unrest {
    rate: f64,
    /// Standard deviation and what is left of it from sample to sample.
    tremor: f64,
    kept: f64,
    sway: [f64; 3],
    /// Middle of a touch, samples, its direction and size.
    touch: Option<(f64, [f64; 3])>,
    /// Length of a swell, samples.
    swell: f64,
}

impl Unrest {
    fn of(rig: &HandHeld, samples: usize, rng: &mut Xoshiro256PlusPlus) -> Self {
        let touch = (rig.touched > 0.0 && rng.random::<f64>() < rig.touched).then(|| {
            let size = 0.1 * 10f64.powf(rng.random::<f64>());
            let way = unit(std::array::from_fn(|_| StandardNormal.sample(rng)));
            (rng.random::<f64>() * samples as f64, way.map(|v| v * size))
        });
        Self {
            rate: rig.rate,
            tremor: rig.tremor,
            kept: (-2.0 / rig.rate).exp(),
            sway: [0.0; 3],
            touch,
            swell: rig.rate * rig.rest.max(2.0),
        }
    }

    fn next(&mut self, sample: usize, rng: &mut Xoshiro256PlusPlus) -> [f64; 3] {
        let mut moved = [0.0; 3];
        if self.tremor > 0.0 {
            let fresh = self.tremor * (1.0 - self.kept * self.kept).sqrt();
            let swell = (std::f64::consts::TAU * sample as f64 / self.swell)
                .sin()
                .powi(2);
            for axis in 0..3 {
                let w: f64 = StandardNormal.sample(rng);
                self.sway[axis] = self.kept * self.sway[axis] + fresh * w;
                moved[axis] = swell * self.sway[axis];
            }
        }
        if let Some((at, way)) = &self.touch {
            let near = (sample as f64 - at) / (0.25 * self.rate).max(1.0);
            if near.abs() < 1.0 {
                let push = (std::f64::consts::PI * near).sin();
                moved = std::array::from_fn(|i| moved[i] + push * way[i]);
            }
        }
        moved
    }
}

/// Each axis up and down first, then evenly over the sphere; all as far askew as told.
fn attitudes(count: usize, askew: f64, rng: &mut Xoshiro256PlusPlus) -> Vec<[f64; 3]> {
    let spread = count.saturating_sub(6).max(1);
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let turn = std::f64::consts::TAU * rng.random::<f64>();
    (0..count)
        .map(|i| {
            let target = if i < 6 {
                let mut unit = [0.0; 3];
                unit[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
                unit
            } else {
                let z = 1.0 - (2.0 * (i - 6) as f64 + 1.0) / spread as f64;
                let r = (1.0 - z * z).sqrt();
                let angle = golden * i as f64 + turn;
                [r * angle.cos(), r * angle.sin(), z]
            };
            unit(target.map(|v| v + askew * (2.0 * rng.random::<f64>() - 1.0)))
        })
        .collect()
}

/// Directions on the way from one to another; opposite ones go by way of the axis least aligned with them.
fn between(from: [f64; 3], to: [f64; 3], share: f64) -> [f64; 3] {
    let cosine: f64 = (0..3).map(|i| from[i] * to[i]).sum();
    if cosine < -0.95 {
        let axis = (0..3)
            .min_by(|&a, &b| from[a].abs().total_cmp(&from[b].abs()))
            .unwrap_or(0);
        let mut way = [0.1; 3];
        way[axis] = 1.0;
        let way = unit(way);
        return if share < 0.5 {
            between(from, way, 2.0 * share)
        } else {
            between(way, to, 2.0 * share - 1.0)
        };
    }
    // A cosine ramp: no jump in angular rate at either end.
    let s = 0.5 - 0.5 * (std::f64::consts::PI * share).cos();
    unit(std::array::from_fn(|i| (1.0 - s) * from[i] + s * to[i]))
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = proofmass_core::norm(v);
    v.map(|x| x / norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_rest_means_equal_the_sensor_under_gravity() {
        let rig = HandHeld::default();
        let recording = rig.simulate(3);
        for rest in &recording.rests {
            let expected = rig.sensor.invert(rest.attitude.map(|u| rig.gravity * u));
            let n = (rest.end - rest.start) as f64;
            for axis in 0..3 {
                let mean = recording.outputs[axis][rest.start..rest.end]
                    .iter()
                    .sum::<f64>()
                    / n;
                // 24 × 3 means of n samples: five standard deviations leave 4e-5 for a false alarm.
                assert!((mean - expected[axis]).abs() < 5.0 * rig.noise / n.sqrt());
            }
        }
    }

    #[test]
    fn law_a_seed_is_a_recording() {
        let rig = HandHeld::default();
        assert_eq!(rig.simulate(5), rig.simulate(5));
        assert_ne!(rig.simulate(5), rig.simulate(6));
    }
}
