//! Auto-calibration against a published result, an independent rewrite, and a week with truth.

use proofmass_core::Error;
use proofmass_static::{AutoCalibration, AutoCalibrationFit, StillWindow, Stop};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Still windows of 84 h of one person, published with the data of the GGIR package.
fn windows() -> Vec<StillWindow> {
    let root = std::env::var("PROOFMASS_REFERENCE_DATA")
        .expect("PROOFMASS_REFERENCE_DATA is not set, see docs/reference-data.md");
    let text = std::fs::read_to_string(format!("{root}/wearable/ggir/calibrate_windows.csv"))
        .expect("wearable/ggir/calibrate_windows.csv");
    text.lines()
        .skip(1)
        .map(|line| {
            let v: Vec<f64> = line
                .split(',')
                .map(|f| f.trim().parse().expect("number"))
                .collect();
            StillWindow {
                time: 10.0 * v[0],
                mean: [v[2], v[3], v[4]],
                temperature: Some(v[8]),
            }
        })
        .collect()
}

fn fit(windows: &[StillWindow], stop: Stop) -> AutoCalibrationFit {
    let settings = AutoCalibration {
        stop,
        ..AutoCalibration::default()
    };
    settings.fit(windows).unwrap()
}

/// To the six decimals that are printed.
fn near(fit: &AutoCalibrationFit, s: [f64; 3], o: [f64; 3], c: [f64; 3]) {
    let q = fit.parameters;
    for (got, expected) in [(q.scale, s), (q.offset, o), (q.temperature, c)] {
        for k in 0..3 {
            assert!(
                (got[k] - expected[k]).abs() < 1.01e-6,
                "{got:?} {expected:?}"
            );
        }
    }
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_autocalibration_of_84_hours() {
    let windows = windows();
    let published = fit(&windows, Stop::Published);
    near(
        &published,
        [1.000875, 0.995245, 0.997732],
        [-0.006805, 0.003756, 0.015288],
        [0.000991, 0.000384, 0.001338],
    );
    assert_eq!(published.iterations, 5);
    assert!((published.error_before_mg - 14.891980).abs() < 1e-6);
    assert!((published.error_after_mg - 2.293689).abs() < 1e-6);
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_autocalibration_converged() {
    let windows = windows();
    let converged = fit(&windows, Stop::Converged);
    near(
        &converged,
        [0.999653, 0.996057, 0.999412],
        [-0.007707, 0.000055, 0.018399],
        [0.000196, 0.000284, 0.001349],
    );
    assert!((converged.error_after_mg - 1.959081).abs() < 1e-6);
    // A bootstrap of 84 blocks of an hour gave 0.44, 0.37, 0.38 mg; 498, 607, 377 ppm; 0.17, 0.22, 0.16 mg/K. Sixty
    // draws scatter by 9 %. Ours are wider: blocks end where the posture changes and are left out in turn, which the map `worn_sensors` asks for.
    for (name, expected) in [
        ("offset.x", 0.44e-3),
        ("offset.y", 0.37e-3),
        ("offset.z", 0.38e-3),
        ("scale.x", 498e-6),
        ("scale.y", 607e-6),
        ("scale.z", 377e-6),
        ("temperature.x", 0.17e-3),
        ("temperature.y", 0.22e-3),
        ("temperature.z", 0.16e-3),
    ] {
        let u = converged.estimate.get(name).unwrap().standard_uncertainty;
        assert!(
            (0.7..1.6).contains(&(u / expected)),
            "{name}: {u} against {expected}"
        );
    }
    let odd: Vec<StillWindow> = windows.iter().step_by(2).copied().collect();
    let half = fit(&odd, Stop::Published);
    assert_eq!(half.iterations, 7);
    near(
        &half,
        [1.000865, 0.995122, 0.998175],
        [-0.007117, 0.003001, 0.015998],
        [0.000871, 0.000375, 0.001364],
    );
    near(
        &fit(&odd, Stop::Converged),
        [0.999644, 0.996052, 0.999408],
        [-0.007725, 0.000016, 0.018420],
        [0.000197, 0.000303, 0.001334],
    );
}

/// A week with truth: still windows drawn from postures that last, with the temperature of a worn logger.
fn week(seed: u64) -> (Vec<StillWindow>, [[f64; 3]; 3]) {
    let (s, o, c) = (
        [0.990, 1.012, 0.985],
        [-0.020, 0.035, 0.050],
        [0.8e-3, -0.4e-3, 1.2e-3],
    );
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut windows = Vec::new();
    let (mut posture, mut temperature) = ([0.0, 0.0, 1.0], 30.0);
    for window in 0..60_480 {
        let hour = (window as f64 / 360.0) % 24.0;
        let night = hour < 7.0;
        let worn = !(window / 8640 == 2 && (18.0..21.0).contains(&hour)
            || window / 8640 == 5 && (8.0..13.0).contains(&hour));
        let turn = std::f64::consts::TAU * (hour - 17.0) / 24.0;
        let target = if worn {
            31.0 + 1.5 * turn.sin() + if night { 1.5 } else { 0.0 }
        } else {
            21.0
        };
        temperature += (target - temperature) * 10.0 / 1200.0;
        if rng.random::<f64>() < if night { 1.0 / 72.0 } else { 1.0 / 12.0 } {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let v = [normal(), 0.8 * normal(), normal() - 0.3];
            let norm = proofmass_core::norm(v);
            posture = v.map(|x| x / norm);
        }
        let a = if worn {
            posture
        } else {
            [0.02, -0.01, -0.99975]
        };
        if rng.random::<f64>() < if night || !worn { 0.85 } else { 0.4 } {
            // The mean of 200 samples of 4 mg.
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let t = (temperature * 256.0 / 75.0).round() * 75.0 / 256.0;
            let mean = std::array::from_fn(|k| {
                (a[k] - (temperature - 25.0) * c[k]) / s[k] - o[k] + 2.8e-4 * normal()
            });
            windows.push(StillWindow {
                time: 10.0 * window as f64,
                mean,
                temperature: Some(t),
            });
        }
    }
    let mean = windows.iter().filter_map(|w| w.temperature).sum::<f64>() / windows.len() as f64;
    let expected = std::array::from_fn(|k| o[k] + (mean - 25.0) * c[k] / s[k]);
    (windows, [expected, s, c])
}

#[test]
fn known_week_with_truth() {
    for seed in 0..2 {
        let (windows, [o, s, c]) = week(seed);
        let converged = fit(&windows, Stop::Converged).parameters;
        let published = fit(&windows, Stop::Published).parameters;
        for k in 0..3 {
            assert!(
                (converged.offset[k] - o[k]).abs() < 5e-5,
                "{converged:?} {o:?}"
            );
            assert!((converged.scale[k] - s[k]).abs() < 5e-5, "{converged:?}");
            assert!(
                (converged.temperature[k] - c[k]).abs() < 5e-5,
                "{converged:?}"
            );
        }
        // The negative control: stopped where the publication stops, the offsets miss what is asked for.
        assert!((0..3).any(|k| (published.offset[k] - o[k]).abs() > 5e-5));
    }
}

#[test]
fn refuses_few_windows_and_one_side_of_the_sphere() {
    let (windows, _) = week(3);
    let settings = AutoCalibration::default();
    assert!(matches!(
        settings.fit(&windows[..9]),
        Err(Error::TooFew { .. })
    ));
    let one_side: Vec<StillWindow> = windows.into_iter().filter(|w| w.mean[0] < 0.0).collect();
    assert!(matches!(
        settings.fit(&one_side),
        Err(Error::Unobservable {
            parameter: "scale.x",
            ..
        })
    ));
}
