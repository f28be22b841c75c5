//! A sensor that is turned slowly all the time: do the intervals hold although neighbouring samples share errors?

use proofmass_core::{Error, Gravity, Matrix3, SensorModel};
use proofmass_static::{Model, MultiPosition, Samples, StandstillCalibration};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::collections::BTreeMap;

const GRAVITY: f64 = 9.80665;
const RATE: f64 = 50.0;

/// A hand that turns a sensor.
#[derive(Clone, Copy)]
struct Hand {
    /// Duration, s.
    duration: f64,
    /// Standard deviation of its accelerations along each axis, m/s², and for how long they last, s.
    sway: (f64, f64),
    /// Noise of a sample, m/s².
    noise: f64,
    /// Standard deviation of the rate of turning about each axis, rad/s.
    turning: f64,
}

const CALM: Hand = Hand {
    duration: 180.0,
    sway: (0.05, 0.3),
    noise: 0.02,
    turning: 0.3,
};

impl Hand {
    fn recording(&self, seed: u64) -> ([Vec<f64>; 3], SensorModel<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let k = [
            [1.0 + 0.01 * normal(), 0.01 * normal(), 0.01 * normal()],
            [0.0, 1.0 + 0.01 * normal(), 0.01 * normal()],
            [0.0, 0.0, 1.0 + 0.01 * normal()],
        ];
        let bias = [0.2 * normal(), 0.2 * normal(), 0.2 * normal()];
        let sensor = SensorModel::new(Matrix3(k), bias).unwrap();
        let step = 1.0 / RATE;
        // First-order processes: the rate of turning lasts 5 s, the sway as stated.
        let keep = |time: f64| (-step / time).exp();
        let (turn, sway) = (keep(5.0), keep(self.sway.1));
        let mut rate = [0.0; 3].map(|_: f64| self.turning * normal());
        let mut pull = [0.0; 3].map(|_: f64| self.sway.0 * normal());
        let mut up = [0.0, 0.0, 1.0];
        let n = (self.duration * RATE) as usize;
        let mut outputs: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(n));
        for _ in 0..n {
            for axis in 0..3 {
                rate[axis] =
                    turn * rate[axis] + self.turning * (1.0 - turn * turn).sqrt() * normal();
                pull[axis] =
                    sway * pull[axis] + self.sway.0 * (1.0 - sway * sway).sqrt() * normal();
            }
            // u̇ = u × ω in the axes of the sensor.
            let turned: [f64; 3] = std::array::from_fn(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                up[i] + step * (up[j] * rate[k] - up[k] * rate[j])
            });
            let norm = proofmass_core::norm(turned);
            up = turned.map(|v| v / norm);
            let a = std::array::from_fn(|i| GRAVITY * up[i] + pull[i]);
            let output = sensor.invert(a);
            for axis in 0..3 {
                outputs[axis].push(output[axis] + self.noise * normal());
            }
        }
        (outputs, sensor)
    }
}

fn settings() -> MultiPosition {
    MultiPosition::new(Gravity::given(GRAVITY, 1e-5).unwrap())
        .model(Model::Triangular)
        .output_unit("m/s²")
        .nominal_sensitivity(1.0)
}

fn calibrate(outputs: &[Vec<f64>; 3]) -> Result<StandstillCalibration, Error> {
    let [x, y, z] = outputs;
    StandstillCalibration::of_tumble(&Samples::new(x, y, z)?, RATE, &[], &settings())
}

fn truth(sensor: &SensorModel<f64>, name: &str) -> f64 {
    let axis = |c: char| "xyz".find(c).unwrap();
    let (k, b) = (sensor.k().0, sensor.bias());
    let (kind, of) = name.split_once('.').unwrap();
    let mut letters = of.chars().map(axis);
    let i = letters.next().unwrap();
    match kind {
        "bias" => b[i],
        "scale" => k[i][i],
        _ => k[i][letters.next().unwrap()] / k[i][i],
    }
}

/// Share of intervals that hold the truth, over all parameters, U of bias.x in the mean, and how often what is found.
fn coverage(hand: Hand, runs: u64) -> (f64, f64, BTreeMap<String, usize>) {
    let all: Vec<(usize, usize, f64, Vec<String>)> = (0..runs)
        .into_par_iter()
        .map(|seed| {
            let (outputs, sensor) = hand.recording(seed);
            let fit = calibrate(&outputs).unwrap().fit;
            let quantities = fit.quantities();
            let inside = quantities
                .iter()
                .filter(|q| (q.value - truth(&sensor, &q.name)).abs() <= q.expanded(0.95));
            (
                inside.count(),
                quantities.len(),
                quantities[0].expanded(0.95),
                fit.findings().iter().map(|f| f.code().to_owned()).collect(),
            )
        })
        .collect();
    let inside: usize = all.iter().map(|a| a.0).sum();
    let of: usize = all.iter().map(|a| a.1).sum();
    let width = all.iter().map(|a| a.2).sum::<f64>() / runs as f64;
    let mut found = BTreeMap::new();
    for code in all.into_iter().flat_map(|a| a.3) {
        *found.entry(code).or_insert(0) += 1;
    }
    (inside as f64 / of as f64, width, found)
}

#[test]
fn coverage_of_a_tumble() {
    const RUNS: u64 = 200;
    for (name, hand) in [
        ("calm", CALM),
        (
            "noise alone",
            Hand {
                sway: (0.0, 0.3),
                noise: 0.05,
                ..CALM
            },
        ),
        (
            "slow sway",
            Hand {
                sway: (0.05, 1.5),
                ..CALM
            },
        ),
        (
            "short",
            Hand {
                duration: 60.0,
                ..CALM
            },
        ),
        (
            "lively",
            Hand {
                turning: 0.6,
                sway: (0.2, 0.3),
                ..CALM
            },
        ),
    ] {
        let (share, width, found) = coverage(hand, RUNS);
        println!(
            "{name}: {:.1} %, U(bias.x) = {:.1} mm/s², found {found:?} of {RUNS}",
            1e2 * share,
            1e3 * width
        );
        // Nine parameters of a recording are correlated; taken as two independent ones, 95 % scatters by
        // √(0.95 · 0.05/400) = 1.1 %, three of which are allowed below. Above, the rule may be cautious.
        assert!(share > 0.95 - 0.033, "{name}: {share}");
        // Some of the short and lively ones are turned fast, shaken, or leave a side open: so it is told. Of anything else a
        // rate of 1 % shows more than eight times in 200 once in a thousand test runs.
        let may_be = ["tumble-fast", "tumble-shaken", "attitudes-badly-spread"];
        let alarms = found.iter().filter(|(code, _)| {
            !matches!(name, "short" | "lively") || !may_be.contains(&code.as_str())
        });
        assert!(alarms.clone().all(|(_, n)| *n <= 8), "{name}: {found:?}");
    }
}

#[test]
fn law_samples_that_share_errors_do_not_narrow_the_intervals() {
    // The same hand sampled five times as often says nothing new of the sway.
    let (outputs, _) = Hand { noise: 0.0, ..CALM }.recording(3);
    let thinned: [Vec<f64>; 3] = outputs.clone().map(|c| c.into_iter().step_by(5).collect());
    let [x, y, z] = &thinned;
    let samples = Samples::new(x, y, z).unwrap();
    let few = StandstillCalibration::of_tumble(&samples, RATE / 5.0, &[], &settings()).unwrap();
    let many = calibrate(&outputs).unwrap();
    let u = |c: &StandstillCalibration| c.fit.quantities()[0].expanded(0.95);
    assert!(
        (u(&many) / u(&few) - 1.0).abs() < 0.25,
        "{} {}",
        u(&many),
        u(&few)
    );
    let effective = many.fit.effective_readings().unwrap();
    assert!(
        effective < 0.8 * many.fit.poses().len() as f64,
        "{effective}"
    );
}

#[test]
fn refuses_a_tumble_about_one_axis_and_one_that_is_too_short() {
    let n = 3000;
    let about_z = |i: usize| (i as f64 * 0.01).sin_cos();
    let ripple = |i: usize| 0.01 * ((i * 7919 % 1009) as f64 / 1009.0 - 0.5);
    let x: Vec<f64> = (0..n).map(|i| GRAVITY * about_z(i).0 + ripple(i)).collect();
    let y: Vec<f64> = (0..n)
        .map(|i| GRAVITY * about_z(i).1 + ripple(i + 3))
        .collect();
    let z: Vec<f64> = (0..n).map(|i| ripple(i + 7)).collect();
    let error = calibrate(&[x, y, z]).err().unwrap();
    assert!(
        matches!(
            error,
            Error::Unobservable { .. } | Error::TooUncertain { .. } | Error::NotConverged { .. }
        ),
        "{error}"
    );
    let (outputs, _) = Hand {
        duration: 0.5,
        ..CALM
    }
    .recording(1);
    assert!(matches!(calibrate(&outputs), Err(Error::TooFew { .. })));
}
