//! Quantities of the surroundings beside the temperature, and the soak at each temperature.

use proofmass_static::{EnvironmentalQuantity, SweepData, TemperatureFit, TemperatureSweep};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const G: f64 = 9.80665;
const MG: f64 = G / 1e3;

/// Temperature, humidity and supply voltage of a day in a chamber at 1 Hz: two cycles of the temperature at different humidities, the
/// voltage going its own way.
fn surroundings(n: usize) -> [Vec<f64>; 3] {
    let at = |k: usize| k as f64 / n as f64;
    let temperature = (0..n).map(|k| 20.0 + 30.0 * (std::f64::consts::TAU * 2.0 * at(k)).sin());
    let humidity =
        (0..n).map(|k| if at(k) < 0.5 { 30.0 } else { 70.0 } + 5.0 * (40.0 * at(k)).cos());
    let supply = (0..n).map(|k| 3.3 + 0.2 * (std::f64::consts::TAU * 3.3 * at(k)).cos());
    [temperature.collect(), humidity.collect(), supply.collect()]
}

/// mg/K, mg/%, mg/V of x, y, z.
const SLOPES: [[f64; 3]; 3] = [[0.3, 0.05, 4.0], [-0.2, 0.0, -2.0], [0.1, -0.02, 0.0]];

fn fit(seed: u64, environment: bool) -> TemperatureFit {
    let n = 7200;
    let [t, h, v] = surroundings(n);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut column = |axis: usize| -> Vec<f64> {
        let level = [0.0, 0.0, G][axis];
        let [kt, kh, kv] = SLOPES[axis];
        (0..n)
            .map(|k| {
                let w: f64 = StandardNormal.sample(&mut rng);
                level + MG * (kt * (t[k] - 20.0) + kh * (h[k] - 50.0) + kv * (v[k] - 3.3) + 3.0 * w)
            })
            .collect()
    };
    let outputs = [column(0), column(1), column(2)];
    let data = SweepData {
        outputs: outputs.iter().map(Vec::as_slice).collect(),
        temperature: &t,
        rate: 1.0,
    };
    let quantities = [
        EnvironmentalQuantity {
            name: "humidity",
            unit: "%",
            values: &h,
            reference: Some(50.0),
        },
        EnvironmentalQuantity {
            name: "supply",
            unit: "V",
            values: &v,
            reference: Some(3.3),
        },
    ];
    let mut sweep = TemperatureSweep::default();
    sweep.largest_order = 1;
    sweep
        .fit_beside(&data, if environment { &quantities } else { &[] })
        .unwrap()
}

/// Coefficients of temperature, humidity and supply in one covariance hold the truth.
#[test]
fn coverage_of_coefficients_of_the_surroundings() {
    let mut held = 0;
    let mut all = 0;
    for seed in 0..30 {
        let fit = fit(seed, true);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            for (k, of) in ["T1", "humidity", "supply"].into_iter().enumerate() {
                let q = fit.estimate.get(&format!("output.{name}.{of}")).unwrap();
                assert_eq!(q.unit, ["m/s²/K", "m/s²/%", "m/s²/V"][k]);
                all += 1;
                let off = (q.value - MG * SLOPES[axis][k]).abs();
                held += usize::from(off <= q.expanded(0.95));
                // Known to a tenth of what it does over the range, and not by a useless interval.
                let range = [60.0, 50.0, 0.4][k];
                assert!(
                    q.expanded(0.95) * range < 2.5 * MG,
                    "{} {}",
                    q.name,
                    q.expanded(0.95) * range / MG
                );
            }
        }
    }
    // 270 intervals of 95 %, wide because every noise has a weight: at least 250.
    println!("{held} of {all} held");
    assert!(held >= 250, "{held} of {all}");
}

/// A supply that is stepped from cycle to cycle in one attitude: what its steps do is no turn of the sensor, and both coefficients are held.
#[test]
fn coverage_of_a_supply_in_steps() {
    let (mut held, mut all) = (0, 0);
    for seed in 0..20 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(900 + seed);
        let n = 7200;
        let at = |k: usize| k as f64 / n as f64;
        let temperature: Vec<f64> = (0..n)
            .map(|k| 20.0 + 30.0 * (std::f64::consts::TAU * 3.0 * at(k)).sin())
            .collect();
        let supply: Vec<f64> = (0..n).map(|k| 3.0 + 0.3 * (3.0 * at(k)).floor()).collect();
        let mut column = |level: f64, slopes: [f64; 2]| -> Vec<f64> {
            (0..n)
                .map(|k| {
                    let w: f64 = StandardNormal.sample(&mut rng);
                    let moved = slopes[0] * (temperature[k] - 20.0) + slopes[1] * (supply[k] - 3.3);
                    level + MG * (moved + 0.5 * w)
                })
                .collect()
        };
        // 20 mg/V: six times what passes for a turn of 0.3°.
        let slopes = [[0.1, 20.0], [-0.2, -15.0], [0.05, 30.0]];
        let outputs = [
            column(0.0, slopes[0]),
            column(0.0, slopes[1]),
            column(G, slopes[2]),
        ];
        let data = SweepData {
            outputs: outputs.iter().map(Vec::as_slice).collect(),
            temperature: &temperature,
            rate: 1.0,
        };
        let quantity = EnvironmentalQuantity {
            name: "supply",
            unit: "V",
            values: &supply,
            reference: Some(3.3),
        };
        let mut sweep = TemperatureSweep::default();
        sweep.largest_order = 1;
        let fit = sweep.fit_beside(&data, &[quantity]).unwrap();
        for (axis, slopes) in ["x", "y", "z"].into_iter().zip(slopes) {
            for (of, slope) in ["T1", "supply"].into_iter().zip(slopes) {
                let q = fit.estimate.get(&format!("output.{axis}.{of}")).unwrap();
                all += 1;
                held += usize::from((q.value - MG * slope).abs() <= q.expanded(0.95));
            }
        }
    }
    println!("{held} of {all} held");
    assert!(held >= 108, "{held} of {all}");
}

/// One axis up and down, two cycles of the temperature in each, with the reference at one end of the sweep: what bias and scale do on the
/// way is no force of the attitude, and every coefficient is held.
#[test]
fn coverage_where_attitudes_tell_the_scale_far_from_the_reference() {
    for range in [[23.0, 60.0], [-40.0, 23.0], [-10.0, 60.0]] {
        let (mut held, mut all) = (0, 0);
        for seed in 0..12 {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(700 + seed);
            let n = 8000;
            let (mut y, mut t, mut v) = (Vec::new(), Vec::new(), Vec::new());
            for k in 0..n {
                let within = 2 * (k % (n / 2));
                let at = within as f64 / n as f64;
                let swing = 0.5 - 0.5 * (std::f64::consts::TAU * 2.0 * at).cos();
                let temperature = range[0] + (range[1] - range[0]) * swing;
                let supply = 3.3 + 0.3 * (std::f64::consts::TAU * 3.3 * at).cos();
                let a = if k < n / 2 { G } else { -G };
                let gain = 1.0 + (supply - 3.3) / 30.0 + 2e-4 * (temperature - 23.0);
                let bias = 0.02 * (temperature - 23.0) + 0.5 * (supply - 3.3);
                let noise: f64 = StandardNormal.sample(&mut rng);
                y.push(bias + gain * a + 2e-3 * noise);
                t.push(temperature);
                v.push(supply);
            }
            let data = SweepData {
                outputs: vec![&y],
                temperature: &t,
                rate: 1.0,
            };
            let quantity = EnvironmentalQuantity {
                name: "supply",
                unit: "V",
                values: &v,
                reference: Some(3.3),
            };
            let mut sweep = TemperatureSweep::default();
            sweep.largest_order = 1;
            sweep.reference = Some(23.0);
            let fit = sweep.fit_beside(&data, &[quantity]).unwrap();
            for (name, truth) in [
                ("slope", 0.02),
                ("bias.T1", 0.02),
                ("scale.T1", 2e-4),
                ("bias.supply", 0.5),
                ("scale.supply", 1.0 / 30.0),
            ] {
                let q = fit.estimate.get(name).unwrap();
                all += 1;
                held += usize::from((q.value - truth).abs() <= q.expanded(0.95));
                assert!(
                    q.expanded(0.95) < 0.02 * truth,
                    "{name} {}",
                    q.expanded(0.95)
                );
            }
        }
        // 60 intervals of 95 %, three standard deviations of that below.
        assert!(held >= 52, "{range:?}: {held} of {all}");
    }
}

/// Without them the coefficient of the temperature takes what they did, and its interval is no wider.
#[test]
fn known_surroundings_left_out_are_in_the_residuals() {
    let (with, without) = (fit(1, true), fit(1, false));
    let scatter = |f: &TemperatureFit| f.axes[0].residuals.iter().map(|r| r * r).sum::<f64>();
    assert!(scatter(&without) > 5.0 * scatter(&with));
    assert!(without.estimate.get("output.x.humidity").is_none());
}

/// One covariance: coefficients of what goes half with the temperature are correlated.
#[test]
fn law_one_joint_covariance() {
    let fit = fit(2, true);
    let estimate = &fit.estimate;
    let [a, b] = ["output.x.T1", "output.x.supply"].map(|n| estimate.index_of(n).unwrap());
    let c = estimate.covariance();
    let r = c[(a, b)] / (c[(a, a)] * c[(b, b)]).sqrt();
    assert!(r.is_finite() && r.abs() > 0.01 && r.abs() < 0.9, "{r}");
}

fn found(fit: &TemperatureFit, code: &str) -> bool {
    fit.findings.iter().any(|f| f.code() == code)
}

fn follows(own: f64) -> TemperatureFit {
    let n = 4000;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let t: Vec<f64> = (0..n)
        .map(|k| 20.0 + 20.0 * (6.0 * k as f64 / n as f64).sin())
        .collect();
    let h: Vec<f64> = (0..n)
        .map(|k| 80.0 - t[k] + own * (40.0 * k as f64 / n as f64).cos())
        .collect();
    let x: Vec<f64> = t
        .iter()
        .map(|t| {
            let w: f64 = StandardNormal.sample(&mut rng);
            MG * (0.2 * t + w)
        })
        .collect();
    let data = SweepData {
        outputs: vec![&x],
        temperature: &t,
        rate: 1.0,
    };
    let humidity = EnvironmentalQuantity {
        name: "humidity",
        unit: "%",
        values: &h,
        reference: None,
    };
    TemperatureSweep::default()
        .fit_beside(&data, &[humidity])
        .unwrap()
}

#[test]
fn known_humidity_that_follows_the_temperature() {
    let alone = follows(0.0);
    assert!(!alone.environment[0].determined && alone.estimate.get("output.humidity").is_none());
    let hardly = follows(1.0);
    assert!(hardly.environment[0].determined);
    assert!(found(&hardly, "environment-follows"));
    let told = follows(20.0);
    assert!(told.environment[0].determined);
    assert!(!found(&told, "environment-follows"));
}

/// Plateaus up and back, the sensor behind its thermometer by a first-order lag.
fn plateaus(minutes: f64, lag: f64, seed: u64) -> TemperatureFit {
    let levels = [
        20.0, 40.0, 60.0, 80.0, 60.0, 40.0, 20.0, 0.0, -20.0, 0.0, 20.0,
    ];
    let (rest, ramp) = ((60.0 * minutes) as usize, 300);
    let mut t: Vec<f64> = Vec::new();
    for (k, level) in levels.iter().enumerate() {
        if k > 0 {
            let before = levels[k - 1];
            t.extend(
                (0..ramp).map(|i| before + (level - before) * f64::from(i as u32) / ramp as f64),
            );
        }
        t.extend(std::iter::repeat_n(*level, rest));
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut inner = t[0];
    let x: Vec<f64> = t
        .iter()
        .map(|outer| {
            inner += (outer - inner) / lag;
            let w: f64 = StandardNormal.sample(&mut rng);
            MG * (0.5 * inner + 2.0 * w)
        })
        .collect();
    let data = SweepData {
        outputs: vec![&x],
        temperature: &t,
        rate: 1.0,
    };
    TemperatureSweep::default().fit(&data).unwrap()
}

#[test]
fn known_soak_that_is_too_short() {
    // A sensor that takes five minutes, after rests of eight; and one that takes ten seconds, after rests of 15 minutes.
    assert!(found(&plateaus(8.0, 300.0, 50), "soak-too-short"));
    let told = |minutes, lag, seed| found(&plateaus(minutes, lag, seed), "soak-too-short");
    let short = (0..10).filter(|s| told(8.0, 300.0, *s)).count();
    assert!(short >= 9, "{short}");
    let healthy = (0..60).filter(|s| told(15.0, 10.0, 100 + s)).count();
    println!("{short} of 10 short soaks, {healthy} of 60 long ones");
    assert!(healthy <= 2, "{healthy}");
}
