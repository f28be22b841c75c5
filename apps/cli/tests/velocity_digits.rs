//! A speed that is logged with few digits, beside an accelerometer and alone: what its rounding makes of the intervals, and which slower
//! sensors are told from it.

use crate::support::axis::*;
use crate::support::*;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// Twelve seconds at 1 kHz of a speed in km/h with decimals, held for rows; the true velocity.
fn logged(
    file: &Path,
    (amplitude, frequency): (f64, f64),
    decimals: usize,
    rows: usize,
) -> Vec<f64> {
    let seed = (1e3 * amplitude * frequency) as u64 + 100 * decimals as u64;
    let mut chance = Chance(seed);
    let phase = TAU * (0..8).map(|_| chance.uniform()).sum::<f64>();
    let at = |t: f64| (TAU * frequency * t + phase).sin_cos();
    let mut text = String::from("time_s;speed_km/h;acceleration_m/s2\n");
    let mut truth = Vec::new();
    for k in 0..12_000 {
        let t = 1e-3 * f64::from(k);
        let seen = 1e-3 * f64::from(k / rows as i32 * rows as i32);
        let noise = chance.normal();
        let a = TAU * frequency * amplitude * at(t).1 + 0.01 + 0.03 * noise;
        let v = 3.6 * amplitude * at(seen).0;
        writeln!(text, "{t:.3};{v:.decimals$};{a:.4}").unwrap();
        truth.push(amplitude * at(t).0);
    }
    std::fs::write(file, text).unwrap();
    truth
}

const BOTH: [&str; 4] = ["--speed", "speed", "--acceleration", "acceleration"];

/// Share of the samples after the first second inside the intervals of filter and smoother.
fn inside(out: &Path, truth: &[f64]) -> [f64; 2] {
    let table = out.join("velocity.csv");
    [
        ("velocity_m/s", "standard_uncertainty_m/s"),
        ("smoothed_m/s", "smoothed_standard_uncertainty_m/s"),
    ]
    .map(|(v, u)| {
        let (v, u) = (column(&table, v), column(&table, u));
        let held = (1000..v.len()).filter(|&k| (v[k] - truth[k]).abs() < 1.96 * u[k]);
        held.count() as f64 / (v.len() - 1000) as f64
    })
}

/// Amplitudes, frequencies and decimals at which a digit lasts two rows and more: no slower sensor, no latency, and the intervals hold.
#[test]
fn coverage_of_a_rounded_speed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("axis.csv");
    let out = folder.path().join("out");
    let mut all = Vec::new();
    for (motion, decimals) in [
        ((0.25, 0.7), 2),
        ((0.25, 0.2), 2),
        ((1.0, 0.2), 2),
        ((0.05, 2.0), 2),
        ((0.25, 0.7), 3),
    ] {
        let truth = logged(&file, motion, decimals, 1);
        let result = estimate(&file, &out, &BOTH);
        let found = codes(&result);
        for code in ["repeated-samples", "latency", "missing-readings"] {
            assert!(!found.iter().any(|c| c == code), "{motion:?}: {found:?}");
        }
        let held = inside(&out, &truth);
        println!("{motion:?}, {decimals} decimals: {held:?} {found:?}");
        // A record of 11 s has some 30 independent values of the smoother.
        assert!(held.iter().all(|h| *h > 0.8), "{motion:?}: {held:?}");
        all.extend(held);
    }
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!(mean > 0.92, "{mean}");
}

/// Sensors that are slower by whole rows are still thinned.
#[test]
fn known_slower_sensors_with_digits() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("axis.csv");
    let out = folder.path().join("out");
    for rows in [2, 3, 5, 10] {
        logged(&file, (1.0, 0.7), 2, rows);
        let found = codes(&estimate(&file, &out, &BOTH));
        assert!(
            found.iter().any(|c| c == "repeated-samples"),
            "{rows}: {found:?}"
        );
    }
}
