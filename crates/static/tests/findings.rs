//! Findings of this room: what is wrong with a recording is told, and its sound twin is left in peace.

use proofmass_core::{Gravity, Matrix3, SensorModel};
use proofmass_static::*;
use proofmass_uncertainty::{Finding, Severity};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

const G: f64 = 9.80665;
/// Noise of a mean, m/s².
const NOISE: f64 = 3e-4;
const SKEW: [[f64; 3]; 3] = [
    [1.004, 0.003, -0.006],
    [0.0, 0.997, 0.004],
    [0.0, 0.0, 1.009],
];
const SQUARE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn insist(code: &str, found: &[Finding]) {
    assert!(found.iter().any(|f| f.code() == code), "{code}: {found:#?}");
}

fn spare(code: &str, found: &[Finding]) {
    assert!(
        !found.iter().any(|f| f.code() == code),
        "{code}: {found:#?}"
    );
}

struct Normal(Xoshiro256PlusPlus);

impl Normal {
    fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    fn draw(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    fn direction(&mut self) -> [f64; 3] {
        let v = [self.draw(), self.draw(), self.draw()];
        let norm = proofmass_core::norm(v);
        v.map(|x| x / norm)
    }
}

/// Standstills on both sides of each axis, then anywhere; `length` is the specific force of each over g.
fn poses(k: [[f64; 3]; 3], n: usize, seed: u64, length: impl Fn(usize) -> f64) -> Vec<Pose> {
    let mut normal = Normal::new(seed);
    let sensor = SensorModel::new(Matrix3(k), [0.1, -0.2, 0.15]).unwrap();
    (0..n)
        .map(|index| {
            let mut up = [0.0; 3];
            match index {
                0..6 => up[index / 2] = if index % 2 == 0 { 1.0 } else { -1.0 },
                _ => up = normal.direction(),
            }
            let force = up.map(|u| G * u * length(index) + NOISE * normal.draw());
            let v = NOISE * NOISE;
            Pose {
                covariance: Some([[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                deviation: Some([1e-2; 3]),
                ..Pose::reading(
                    Segment {
                        start: 400 * index,
                        end: 400 * index + 400,
                        attitude: None,
                        force_uncertainty: None,
                        label: None,
                    },
                    sensor.invert(force),
                )
            }
        })
        .collect()
}

fn fit(poses: &[Pose]) -> MultiPositionFit {
    MultiPosition::new(Gravity::given(G, 1e-5).unwrap())
        .model(Model::Triangular)
        .nominal_sensitivity(1.0)
        .output_unit("m/s²")
        .fit(poses)
        .unwrap()
}

fn sound(_: usize) -> f64 {
    1.0
}

#[test]
fn known_attitudes_that_are_few() {
    let found = |n: usize| fit(&poses(SKEW, n, 1, sound)).findings().to_vec();
    insist("few-attitudes", &found(10));
    spare("few-attitudes", &found(24));
    let unchecked = found(9);
    let gravest = unchecked.iter().map(|f| f.severity()).max();
    assert_eq!(gravest, Some(Severity::Decision), "{unchecked:#?}");
}

#[test]
fn known_model_with_more_than_it_needs() {
    let found = |k| fit(&poses(k, 16, 2, sound)).findings().to_vec();
    insist("smaller-model-suffices", &found(SQUARE));
    spare("smaller-model-suffices", &found(SKEW));
}

/// Biases that walk by 3 mm/s² from one standstill to the next, ten times the noise of a mean.
#[test]
fn known_biases_that_walk() {
    let walked = |step: f64| {
        let mut normal = Normal::new(8);
        let mut poses = poses(SKEW, 40, 8, sound);
        let mut walk = [0.0; 3];
        for (index, pose) in poses.iter_mut().enumerate() {
            pose.time = Some(4.0 * index as f64);
            walk = walk.map(|w| w + step * normal.draw());
            pose.mean = std::array::from_fn(|i| pose.mean[i] + walk[i]);
        }
        fit(&poses).findings().to_vec()
    };
    insist("bias-walk", &walked(3e-3));
    spare("bias-walk", &walked(0.0));
}

#[test]
fn known_standstill_that_was_not_still() {
    let mut still = poses(SKEW, 24, 3, sound);
    spare("restless-standstill", fit(&still).findings());
    still[7].deviation = Some([1e-2, 8e-2, 1e-2]);
    insist("restless-standstill", fit(&still).findings());
}

#[test]
fn known_standstill_that_contradicts_the_others() {
    let of = |off: f64| poses(SKEW, 24, 4, move |i| if i == 15 { 1.0 + off } else { 1.0 });
    insist("standstill-out-of-line", fit(&of(0.01)).findings());
    spare("standstill-out-of-line", fit(&of(0.0)).findings());
}

#[test]
fn known_calibration_that_does_not_hold_any_more() {
    let calibration = fit(&poses(SKEW, 24, 5, sound));
    let sensor = calibration.model();
    let calibrated = Calibrated {
        sensor: &sensor,
        estimate: calibration.estimate(),
        gravity: calibration.gravity(),
        repeatability: 0.0,
        nominal: None,
    };
    let validate = |length: f64| {
        let new = poses(SKEW, 12, 6, move |_| length);
        Validation::run(&calibrated, None, &new).unwrap().findings
    };
    let changed = validate(1.003);
    insist("beyond-one-per-mille", &changed);
    insist("inconsistent-with-covariance", &changed);
    assert!(validate(1.0).is_empty());
}

/// Still windows all around, with a scatter about the sphere.
fn windows(scatter: f64) -> Vec<StillWindow> {
    let mut normal = Normal::new(7);
    (0..2000)
        .map(|i| {
            let length = 1.0 + scatter * normal.draw();
            StillWindow {
                time: 10.0 * f64::from(i),
                mean: normal.direction().map(|u| 1.01 * length * u + 0.02),
                temperature: None,
            }
        })
        .collect()
}

#[test]
fn known_still_windows_that_lie_on_no_sphere() {
    let of = |scatter: f64, stop: Stop| {
        let settings = AutoCalibration {
            stop,
            ..AutoCalibration::default()
        };
        settings.fit(&windows(scatter)).unwrap().findings
    };
    insist("auto-calibration-failed", &of(0.05, Stop::Converged));
    insist("published-stop", &of(1e-3, Stop::Published));
    assert!(of(1e-3, Stop::Converged).is_empty());
}

/// A sensor that is turned all the time, at so many rad/s and with so many m/s² of sway.
fn tumble(turning: f64, sway: f64) -> Vec<Finding> {
    let mut normal = Normal::new(8);
    let step = 0.02;
    let keep = |time: f64| f64::exp(-step / time);
    let (turn, hold) = (keep(5.0), keep(0.3));
    let mut rate = [0.0; 3].map(|_: f64| turning * normal.draw());
    let mut pull = [0.0; 3].map(|_: f64| sway * normal.draw());
    let mut up = [0.0, 0.0, 1.0];
    let sensor = SensorModel::new(Matrix3(SKEW), [0.1, -0.2, 0.15]).unwrap();
    let mut outputs: [Vec<f64>; 3] = Default::default();
    for _ in 0..9000 {
        for axis in 0..3 {
            rate[axis] = turn * rate[axis] + turning * (1.0 - turn * turn).sqrt() * normal.draw();
            pull[axis] = hold * pull[axis] + sway * (1.0 - hold * hold).sqrt() * normal.draw();
        }
        // u̇ = u × ω in the axes of the sensor.
        let turned: [f64; 3] = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            up[i] + step * (up[j] * rate[k] - up[k] * rate[j])
        });
        let norm = proofmass_core::norm(turned);
        up = turned.map(|v| v / norm);
        let output = sensor.invert(std::array::from_fn(|i| G * up[i] + pull[i]));
        for axis in 0..3 {
            outputs[axis].push(output[axis] + 0.02 * normal.draw());
        }
    }
    let [x, y, z] = &outputs;
    let settings = MultiPosition::new(Gravity::given(G, 1e-5).unwrap())
        .model(Model::Triangular)
        .output_unit("m/s²")
        .nominal_sensitivity(1.0);
    let samples = Samples::new(x, y, z).unwrap();
    let calibration = StandstillCalibration::of_tumble(&samples, 50.0, &[], &settings).unwrap();
    calibration.fit.findings().to_vec()
}

#[test]
fn known_tumbles_that_are_fast_or_shaken() {
    insist("tumble-fast", &tumble(0.6, 0.05));
    insist("tumble-shaken", &tumble(0.3, 0.5));
    assert!(tumble(0.2, 0.05).is_empty());
}

/// A sweep of the temperature over time between 0 and 1: noise of the output (m/s²) and of the thermometer (K), and a step of
/// x at three tenths.
fn sweep(path: impl Fn(f64) -> f64, noise: [f64; 2], step: f64) -> Vec<Finding> {
    const N: usize = 4000;
    let mut normal = Normal::new(9);
    let true_temperature: Vec<f64> = (0..N).map(|i| path(i as f64 / N as f64)).collect();
    let level = [0.01 * G, -0.02 * G, 1.002 * G];
    let slope = [5e-4, -2e-3, 1e-2];
    let outputs = [0, 1, 2].map(|axis| -> Vec<f64> {
        (0..N)
            .map(|i| {
                let moved = if axis == 0 && i > 3 * N / 10 {
                    step
                } else {
                    0.0
                };
                level[axis]
                    + slope[axis] * (true_temperature[i] - 28.0)
                    + moved
                    + noise[0] * normal.draw()
            })
            .collect()
    });
    let temperature: Vec<f64> = true_temperature
        .iter()
        .map(|t| t + noise[1] * normal.draw())
        .collect();
    let [x, y, z] = &outputs;
    let mut settings = TemperatureSweep::default();
    settings.blocks = 100;
    let data = SweepData {
        outputs: vec![x, y, z],
        temperature: &temperature,
        rate: 1.0,
    };
    settings.fit(&data).unwrap().findings
}

#[test]
fn known_sweeps_that_tell_less_than_they_seem_to() {
    let up = |s: f64| -18.0 + 92.0 * s;
    // A chamber is fast at first and slow towards the end.
    let shape = |s: f64| (1.0 - f64::exp(-2.0 * s)) / (1.0 - f64::exp(-2.0));
    let chamber = move |s: f64| match s < 0.5 {
        true => -18.0 + 92.0 * shape(2.0 * s),
        false => 74.0 - 92.0 * shape(2.0 * s - 1.0),
    };
    let even = |s: f64| 74.0 - 92.0 * (1.0 - 2.0 * s).abs();
    let healthy = sweep(chamber, [0.05, 0.06], 0.0);
    insist("bias-and-scale-together", &healthy);
    for code in [
        "lag-not-determined",
        "output-step",
        "noisy-thermometer",
        "one-direction",
    ] {
        spare(code, &healthy);
    }
    insist("lag-not-determined", &sweep(even, [0.05, 0.06], 0.0));
    // Moved by half a degree.
    insist("output-step", &sweep(up, [0.02, 0.06], 0.087));
}

/// A thermometer that scatters by two kelvins over one kelvin of a room, and over eighty in a chamber.
#[test]
fn known_thermometer_that_flattens_a_slope() {
    let room = sweep(|s| 22.0 + s, [0.002, 2.0], 0.0);
    insist("noisy-thermometer", &room);
    let chamber = sweep(|s| -18.0 + 80.0 * s, [0.002, 2.0], 0.0);
    spare("noisy-thermometer", &chamber);
}
