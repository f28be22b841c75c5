//! A sensor that was moved while its temperature changed: told, or held by the interval.

use proofmass_static::{SweepData, TemperatureFit, TemperatureSweep};
use proofmass_uncertainty::{Finding, Severity};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const G: f64 = 9.80665;
const MG: f64 = G * 1e-3;
const N: usize = 4000;
/// Slopes of x, y, z, m/s² per K.
const SLOPE: [f64; 3] = [0.05 * MG, -0.2 * MG, 1.0 * MG];

struct Recording {
    outputs: [Vec<f64>; 3],
    temperature: Vec<f64>,
}

impl Recording {
    /// White noise of 5 mg a sample, a wander of `wander` m/s² over 200 samples, the thermometer good to 0.06 K.
    fn at(temperature: impl Fn(f64) -> f64, wander: f64, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = move || -> f64 { random.sample(StandardNormal) };
        let path: Vec<f64> = (0..N).map(|i| temperature(i as f64 / N as f64)).collect();
        let level = [0.01 * G, -0.02 * G, 1.002 * G];
        let keep = (-1.0f64 / 200.0).exp();
        let outputs = [0, 1, 2].map(|axis| {
            let mut slow = wander * normal();
            path.iter()
                .map(|t| {
                    slow = keep * slow + wander * (1.0 - keep * keep).sqrt() * normal();
                    level[axis] + SLOPE[axis] * (t - 28.0) + slow + 0.05 * normal()
                })
                .collect()
        });
        Self {
            outputs,
            temperature: path.iter().map(|t| t + 0.06 * normal()).collect(),
        }
    }

    fn fit(&self, settings: &TemperatureSweep) -> TemperatureFit {
        let [x, y, z] = &self.outputs;
        let data = SweepData {
            outputs: vec![x, y, z],
            temperature: &self.temperature,
            rate: 1.0,
        };
        settings.fit(&data).unwrap()
    }
}

/// Half the blocks of the default: the same rule in an eighth of the time.
fn settings() -> TemperatureSweep {
    let mut settings = TemperatureSweep::default();
    settings.blocks = 100;
    settings
}

fn sweep(s: f64) -> f64 {
    -18.0 + 92.0 * s
}

fn cycle(s: f64) -> f64 {
    74.0 - 92.0 * (1.0 - 2.0 * s).abs()
}

/// Plateaus in one file, the temperature jumps between them; the board was tilted meanwhile, in a direction by chance.
fn plateaus(count: f64, tilt: f64, seed: u64) -> Recording {
    let level = |s: f64| -18.0 + 92.0 * (s * count).floor() / (count - 1.0);
    let mut recording = Recording::at(level, 0.0, seed);
    let angle =
        Xoshiro256PlusPlus::seed_from_u64(9000 + seed).random_range(0.0..std::f64::consts::TAU);
    for i in 0..N {
        let turned = tilt * (i as f64 / N as f64 * count).floor();
        let moved = [
            G * turned.sin() * f64::cos(angle),
            G * turned.sin() * f64::sin(angle),
            G * (turned.cos() - 1.0),
        ];
        for (column, moved) in recording.outputs.iter_mut().zip(moved) {
            column[i] += moved;
        }
    }
    recording
}

/// The intervals hold the truth all the same, and somebody has to decide. Of 120 intervals 114 ± 2.4 hold if they are just
/// wide enough; these are wider. With two plateaus and with six, turned on by the same angle each time.
#[test]
fn coverage_across_jumps_of_the_temperature() {
    for (count, degrees) in [
        (2.0, 0.0),
        (2.0, 0.1f64),
        (2.0, 0.5),
        (2.0, 1.1),
        (2.0, 2.0),
        (6.0, 0.5),
    ] {
        let held: usize = (0..40u64)
            .into_par_iter()
            .map(|seed| {
                let fit = plateaus(count, degrees.to_radians(), seed).fit(&settings());
                let told = |f: &Finding| {
                    f.code() == "temperature-jump" && f.severity() == Severity::Decision
                };
                assert!(fit.findings.iter().any(told), "{:?}", fit.findings);
                let axes = ["x", "y", "z"].into_iter().zip(SLOPE);
                axes.filter(|(name, truth)| {
                    let q = fit.estimate.get(&format!("slope.{name}")).unwrap();
                    (q.value - truth).abs() <= q.expanded(0.95)
                })
                .count()
            })
            .sum();
        println!("{count} plateaus, {degrees}°: {held} of 120");
        assert!(held >= 106, "{count} plateaus, {degrees}°: {held} of 120");
    }
}

/// Two plateaus tell a straight line, six a cubic.
#[test]
fn known_order_of_plateaus() {
    assert_eq!(plateaus(2.0, 0.0, 1).fit(&settings()).largest_order, 1);
    assert_eq!(plateaus(6.0, 0.0, 1).fit(&settings()).largest_order, 3);
    assert_eq!(
        Recording::at(sweep, 0.0, 1).fit(&settings()).largest_order,
        3
    );
}

/// Declared as well kept, the intervals are narrow again, and no narrower than the declaration.
#[test]
fn known_tilt_that_is_declared() {
    let mut settings = settings();
    settings.tilt = Some(0.01f64.to_radians());
    let fit = plateaus(2.0, 0.0, 1).fit(&settings);
    let y = fit.estimate.get("slope.y").unwrap();
    assert!(y.standard_uncertainty < 0.01 * MG);
    assert!(y.standard_uncertainty > 0.9 * 0.01f64.to_radians() * G / 92.0);
    assert!((y.value - SLOPE[1]).abs() < y.expanded(0.999));
    let told = |f: &Finding| f.code() == "temperature-jump" && f.severity() == Severity::Note;
    assert!(fit.findings.iter().any(told), "{:?}", fit.findings);
}

/// Moved by half a degree, 8.7 mg, during the sweep: told in seven of ten at least; not moved, in one of a hundred at most
/// (4 of 120 once in three hundred times).
#[test]
fn known_small_turns_are_told_as_steps() {
    let told = |recording: &Recording| {
        let fit = recording.fit(&settings());
        usize::from(fit.findings.iter().any(|f| f.code() == "output-step"))
    };
    let counts: Vec<[usize; 2]> = (0..40u64)
        .into_par_iter()
        .map(|seed| {
            let mut moved = Recording::at(sweep, 0.0, 500 + seed);
            let at = N / 4 + 50 * seed as usize % (N / 2);
            moved.outputs[1][at..]
                .iter_mut()
                .for_each(|v| *v += 8.7 * MG);
            let healthy = [
                Recording::at(sweep, 0.0, 600 + seed),
                Recording::at(cycle, 0.0, 700 + seed),
                Recording::at(sweep, 0.01, 800 + seed),
            ];
            [told(&moved), healthy.iter().map(told).sum()]
        })
        .collect();
    let total = |k: usize| counts.iter().map(|c| c[k]).sum::<usize>();
    let (found, false_alarms) = (total(0), total(1));
    println!("{found} of 40 moved, {false_alarms} of 120 healthy told");
    assert!(found >= 28, "{found} of 40");
    assert!(false_alarms <= 3, "{false_alarms} of 120");
}

#[test]
fn refuses_a_tilt_without_meaning() {
    let recording = plateaus(2.0, 0.0, 1);
    let [x, y, z] = &recording.outputs;
    let data = SweepData {
        outputs: vec![x, y, z],
        temperature: &recording.temperature,
        rate: 1.0,
    };
    for tilt in [-1.0, 1.0, f64::NAN] {
        let mut settings = settings();
        settings.tilt = Some(tilt);
        assert!(settings.fit(&data).is_err());
    }
}
