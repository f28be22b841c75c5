//! `proofmass velocity` on simulated logs of cars: wheel speeds and accelerometer at their own rates, a reference.

use crate::support::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::fmt::Write as _;
use std::path::Path;

/// Step of the simulated drive, s.
const STEP: f64 = 0.005;
/// Length of a log, s, and what is driven before it.
const LENGTH: f64 = 60.0;
const BEFORE: f64 = 1.0;

/// A minute of a car with what its sensors add.
struct Car {
    /// True speed every `STEP`, from `BEFORE` seconds before the log.
    speed: Vec<f64>,
    /// Wheel speed over true speed, and the time by which it is late.
    scale: f64,
    lag: f64,
}

/// A normal deviate by Box and Muller.
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (radius, turn): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
}

/// First-order noise of this deviation and correlation time.
fn coloured(
    rng: &mut Xoshiro256PlusPlus,
    n: usize,
    step: f64,
    deviation: f64,
    time: f64,
) -> Vec<f64> {
    let alike = (-step / time).exp();
    let mut value = 0.0;
    (0..n)
        .map(|_| {
            let new = normal(rng);
            value = alike * value + (1.0 - alike * alike).sqrt() * new;
            deviation * value
        })
        .collect()
}

impl Car {
    /// Speeds up with pauses of the gear box, cruises unevenly, brakes, waits at lights.
    fn drive(rng: &mut Xoshiro256PlusPlus) -> Self {
        let n = ((LENGTH + 2.0 * BEFORE) / STEP) as usize;
        let uneven = coloured(rng, n, STEP, 0.15, 2.0);
        let bumps = coloured(rng, n, STEP, 0.05, 0.15);
        let town = rng.random_bool(0.65);
        let mut v: f64 = if town {
            rng.random_range(5.0..14.0)
        } else {
            rng.random_range(20.0..30.0)
        };
        let (mut target, mut hardest, mut jerk) = (v, 2.0, 1.5);
        let (mut change, mut shift) = (rng.random_range(1.0..4.0), -9.0);
        let mut a = 0.0f64;
        let mut raw = Vec::with_capacity(n);
        for k in 0..n {
            let t = STEP * k as f64;
            if t >= change {
                target = match town {
                    true if target > 0.0 && rng.random_bool(0.45) => 0.0,
                    true => rng.random_range(4.0..16.0),
                    false => (v + rng.random_range(-6.0..6.0)).max(15.0),
                };
                hardest = rng.random_range(1.0..3.0);
                jerk = rng.random_range(1.5..6.0);
                change = t + rng.random_range(5.0..12.0);
            }
            let mut due = (0.9 * (target - v)).clamp(-hardest, hardest);
            if target == 0.0 && v > 0.0 {
                due = due.min(-0.6);
            }
            if due > 0.5 && v > 3.0 && t - shift > 2.0 && rng.random_bool(0.35 * STEP) {
                shift = t;
            }
            let quick = match t - shift {
                s if s < 0.35 => {
                    due = due.min(-0.2);
                    15.0
                }
                s if s < 0.6 => 12.0,
                _ => jerk,
            };
            a += (due - a).clamp(-quick * STEP, quick * STEP);
            let own = a + (uneven[k] + bumps[k]) * (v / 3.0).min(1.0);
            v = (v + STEP * own).max(0.0);
            if target == 0.0 && v < 0.02 {
                (v, a) = (0.0, 0.0);
            }
            raw.push(v);
        }
        // No car has corners in its speed: a mean over 0.1 s.
        let side = 10;
        let speed = (0..n)
            .map(|k| {
                let part = &raw[k.saturating_sub(side)..(k + side + 1).min(n)];
                part.iter().sum::<f64>() / part.len() as f64
            })
            .collect();
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        Self {
            speed,
            scale: 1.0 + sign * rng.random_range(0.01..0.02),
            lag: rng.random_range(0.05..0.15),
        }
    }

    fn at(&self, t: f64) -> f64 {
        let x = ((t + BEFORE) / STEP).clamp(0.0, (self.speed.len() - 2) as f64);
        let k = x.floor() as usize;
        self.speed[k] + (x - k as f64) * (self.speed[k + 1] - self.speed[k])
    }

    fn acceleration(&self, t: f64) -> f64 {
        (self.at(t + STEP) - self.at(t - STEP)) / (2.0 * STEP)
    }

    /// Wheel speed of a bus that stamps unevenly; in km/h, zero below a threshold.
    fn wheel(&self, rng: &mut Xoshiro256PlusPlus, path: &Path) {
        let rate: f64 = [50.0, 83.0, 100.0][rng.random_range(0..3)];
        let jitter = if rate == 83.0 { 0.35 } else { 0.0 };
        let n = (LENGTH * rate) as usize;
        let (deviation, time) = (rng.random_range(0.01..0.04), rng.random_range(0.1..0.5));
        let noise = coloured(rng, n, 1.0 / rate, deviation, time);
        let white = rng.random_range(0.0..0.015);
        let quantum = [0.036, 0.03125, 0.01, 0.03, 0.1][rng.random_range(0..5)];
        let threshold = [0.0, 0.3, 0.6][rng.random_range(0..3)];
        let creep = rng.random_range(0.0..0.003);
        let mut text = "time_s,wheel_km/h\n".to_owned();
        for (k, noise) in noise.iter().enumerate() {
            let t = (k as f64 + 0.5 + jitter * rng.random_range(-1.0..1.0)) / rate;
            let v = self.scale * self.at(t - self.lag);
            let grip = 1.0 + creep * self.acceleration(t - self.lag) / 10.0;
            let new = normal(rng);
            let v = v * grip + (noise + white * new) * (0.5 * v).min(1.0);
            let read = if v < threshold {
                0.0
            } else {
                (3.6 * v / quantum).round() * quantum
            };
            writeln!(text, "{t:.6},{:.5}", read.max(0.0)).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }

    /// Acceleration along the car: slope of the road, pitch on its springs, vibration with the speed, offset and gain.
    fn accelerometer(&self, rng: &mut Xoshiro256PlusPlus, path: &Path) {
        let rate: f64 = [50.0, 100.0, 104.0, 200.0][rng.random_range(0..4)];
        let dt = 1.0 / rate;
        let (slope, length) = (rng.random_range(0.005..0.03), rng.random_range(80.0..300.0));
        let waves: Vec<(f64, f64)> = (0..12)
            .map(|_| (normal(rng) / length, rng.random_range(0.0..6.3)))
            .collect();
        let (spring, damping) = (
            6.3 * rng.random_range(1.0..1.6),
            rng.random_range(0.25..0.45),
        );
        let nods = rng.random_range(0.002..0.005);
        let vibration = rng.random_range(0.05..0.25);
        let (gain, offset) = (
            1.0 + rng.random_range(-0.01..0.01),
            rng.random_range(-0.3..0.3),
        );
        let (mut pitch, mut rate_of_pitch, mut way) = (0.0, 0.0, 0.0);
        let mut text = "time_s,along_m/s2\n".to_owned();
        for k in 0..(LENGTH * rate) as usize {
            let t = dt * k as f64;
            let (v, a) = (self.at(t), self.acceleration(t));
            way += dt * v;
            let road: f64 = waves.iter().map(|(w, p)| (w * way + p).cos()).sum::<f64>();
            let road = slope * (2.0f64 / 12.0).sqrt() * road;
            let bend =
                spring * spring * (nods * a - pitch) - 2.0 * damping * spring * rate_of_pitch;
            rate_of_pitch += dt * bend;
            pitch += dt * rate_of_pitch;
            let new = normal(rng);
            let shakes = vibration * new * (0.25 + v / 12.0).min(1.0);
            let felt = gain * (a + 9.81 * (road + pitch)) + shakes + offset;
            writeln!(text, "{t:.6},{felt:.5}").unwrap();
        }
        std::fs::write(path, text).unwrap();
    }

    /// Satellite velocity at 10 Hz.
    fn satellite(&self, rng: &mut Xoshiro256PlusPlus, path: &Path) {
        let noise = coloured(rng, 600, 0.1, 0.015, 0.3);
        let mut text = "time_s,satellite_m/s\n".to_owned();
        for (k, noise) in noise.iter().enumerate() {
            let t = 0.1 * k as f64;
            writeln!(text, "{t:.1},{:.5}", self.at(t) + noise).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }

    /// What is left of values at times after the scale and lag that fit the truth best; the first two seconds are not counted.
    fn errors(&self, time: &[f64], value: &[f64]) -> (Vec<f64>, f64) {
        let kept: Vec<usize> = (0..time.len())
            .filter(|k| (2.0..LENGTH - 1.0).contains(&time[*k]))
            .collect();
        let at = |lag: f64| {
            let pairs = || kept.iter().map(|k| (value[*k], self.at(time[*k] - lag)));
            let (vr, rr) = pairs().fold((0.0, 0.0), |(a, b), (v, r)| (a + v * r, b + r * r));
            pairs().map(|(v, r)| v - vr / rr * r).collect::<Vec<f64>>()
        };
        let (mut best, mut lag, mut step) = (f64::INFINITY, 0.0, 0.02);
        for _ in 0..4 {
            let middle = lag;
            for k in -20..=20 {
                let here = middle + step * f64::from(k);
                let rms = root(&at(here));
                if rms < best {
                    (best, lag) = (rms, here);
                }
            }
            step /= 10.0;
        }
        (at(lag), best)
    }
}

fn root(e: &[f64]) -> f64 {
    (e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt()
}

/// First-order low-pass, run forward and backward as often as `order`.
fn low_pass(value: &[f64], corner: f64, dt: f64, order: usize) -> Vec<f64> {
    let share = 1.0 - (-std::f64::consts::TAU * corner * dt).exp();
    let pass = |x: &mut Vec<f64>| {
        let mut y = x[0];
        for v in x.iter_mut() {
            y += share * (*v - y);
            *v = y;
        }
        x.reverse();
    };
    let mut x = value.to_vec();
    for _ in 0..2 * order {
        pass(&mut x);
    }
    x
}

fn table(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip(1) {
        for (i, field) in line.split(',').enumerate() {
            if columns.len() <= i {
                columns.push(Vec::new());
            }
            columns[i].push(field.parse().unwrap_or(f64::NAN));
        }
    }
    columns
}

#[test]
fn coverage_of_car_logs_and_errors_below_the_best_low_pass() {
    let folder = tempfile::tempdir().unwrap();
    let [wheel, along, satellite] =
        ["wheel.csv", "along.csv", "satellite.csv"].map(|n| folder.path().join(n));
    let (mut filters, mut smoothers, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..8 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let car = Car::drive(&mut rng);
        car.wheel(&mut rng, &wheel);
        car.accelerometer(&mut rng, &along);
        let out = folder.path().join(format!("{seed}"));
        succeed(&[
            "velocity",
            "estimate",
            text(&wheel),
            "--speed",
            "wheel",
            "--acceleration-file",
            text(&along),
            "--acceleration",
            "along",
            "-o",
            text(&out),
        ]);
        let found = table(&out.join("velocity.csv"));
        let held = |value: usize| {
            let (errors, rms) = car.errors(&found[0], &found[value]);
            let first = found[0].iter().position(|t| *t >= 2.0).unwrap();
            let inside = errors
                .iter()
                .zip(&found[value + 1][first..])
                .filter(|(e, u)| e.abs() < 1.96 * **u);
            (inside.count() as f64 / errors.len() as f64, rms)
        };
        let (filter, smoother) = (held(1), held(3));
        // The wheel on an even clock, as the best of twenty low-passes that know the truth makes it.
        let raw = table(&wheel);
        let clock: Vec<f64> = (0..6000).map(|k| 0.01 * f64::from(k)).collect();
        let even: Vec<f64> = clock
            .iter()
            .map(|t| {
                let k = raw[0]
                    .partition_point(|s| s <= t)
                    .clamp(1, raw[0].len() - 1);
                let (a, b) = (raw[0][k - 1], raw[0][k]);
                let share = ((t - a) / (b - a)).clamp(0.0, 1.0);
                (raw[1][k - 1] * (1.0 - share) + raw[1][k] * share) / 3.6
            })
            .collect();
        let best = (0..10)
            .flat_map(|i| [(i, 1), (i, 2)])
            .map(|(i, order)| {
                let corner = 0.3 * 1.5f64.powi(i);
                car.errors(&clock, &low_pass(&even, corner, 0.01, order)).1
            })
            .fold(f64::INFINITY, f64::min);
        println!(
            "{seed}: low-pass {:.1} mm/s; filter {:.1} mm/s {:.3}; smoother {:.1} mm/s {:.3}",
            1e3 * best,
            1e3 * filter.1,
            filter.0,
            1e3 * smoother.1,
            smoother.0
        );
        filters.push(filter.0);
        smoothers.push(smoother.0);
        ratios.push(smoother.1 / best);
        if seed == 0 {
            car.satellite(&mut rng, &satellite);
            compared(&car, &wheel, &along, &satellite);
        }
    }
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let within = |x: &[f64]| x.iter().filter(|c| (0.85..=0.99).contains(*c)).count();
    println!(
        "filters {:.3}, smoothers {:.3}, ratios {ratios:.2?}",
        mean(&filters),
        mean(&smoothers)
    );
    assert!((0.88..0.99).contains(&mean(&filters)), "{filters:?}");
    assert!((0.88..0.99).contains(&mean(&smoothers)), "{smoothers:?}");
    assert!(
        within(&filters) >= 5 && within(&smoothers) >= 5,
        "{filters:?} {smoothers:?}"
    );
    // On a motorway the slope of the road may outweigh the motion: the accelerometer then helps little.
    let better = ratios.iter().filter(|r| **r < 1.0).count();
    assert!(better >= 7 && ratios.iter().all(|r| *r < 1.1), "{ratios:?}");
}

/// A minute on a motorway, whose slope outweighs its motion: without a data sheet the gain is found at 1.49, with one nearer to the truth of 1.
#[test]
fn a_gain_that_is_stated_holds_on_a_motorway() {
    let folder = tempfile::tempdir().unwrap();
    let [wheel, along] = ["wheel.csv", "along.csv"].map(|n| folder.path().join(n));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let car = Car::drive(&mut rng);
    car.wheel(&mut rng, &wheel);
    car.accelerometer(&mut rng, &along);
    let out = folder.path().join("out");
    succeed(&[
        "velocity",
        "estimate",
        text(&wheel),
        "--speed",
        "wheel",
        "--acceleration-file",
        text(&along),
        "--acceleration",
        "along",
        "--gain-uncertainty",
        "2.9",
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    let (gain, u, _) = quantity(&result, "gain");
    let found = table(&out.join("velocity.csv"));
    let (errors, rms) = car.errors(&found[0], &found[3]);
    let first = found[0].iter().position(|t| *t >= 2.0).unwrap();
    let pairs = errors.iter().zip(&found[4][first..]);
    let inside = pairs.filter(|(e, u)| e.abs() < 1.96 * **u).count() as f64 / errors.len() as f64;
    println!(
        "gain {gain:.4} ± {u:.4}, smoother {:.1} mm/s, {inside:.3}",
        1e3 * rms
    );
    assert!((gain - 1.0).abs() < 0.25 && u < 0.03, "{gain} {u}");
}

/// The comparison says by how much the wheels are wrong, and how late.
fn compared(car: &Car, wheel: &Path, along: &Path, satellite: &Path) {
    let output = succeed(&[
        "velocity",
        "compare",
        text(wheel),
        "--speed",
        "wheel",
        "--acceleration-file",
        text(along),
        "--acceleration",
        "along",
        "--reference",
        "satellite",
        "--reference-file",
        text(satellite),
        "--json",
    ]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let codes = codes(&result);
    assert!(codes.contains(&"reference-scale".to_owned()), "{codes:?}");
    let beside = &result["extra"]["beside_reference"];
    let value = |name: &str| beside[name].as_f64().unwrap();
    let scale = (value("scale") - car.scale) / value("scale_uncertainty");
    println!("{beside}, scale {}, lag {}", car.scale, car.lag);
    assert!(scale.abs() < 4.0, "{beside} {}", car.scale);
    // Ten milliseconds: pitch and slope pull the time a little.
    assert!(
        (value("delay") - car.lag).abs() < 0.02,
        "{beside} {}",
        car.lag
    );
}
