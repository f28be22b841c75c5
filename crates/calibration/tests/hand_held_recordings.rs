//! Real hand-held recordings against published and independently computed values.

use proofmass_calibration::*;
use proofmass_core::Gravity;
use std::path::PathBuf;

/// A recording of the reference data as columns, or `None` with the reason printed.
fn columns(path: &str) -> Option<Vec<Vec<f64>>> {
    let root = std::env::var_os("PROOFMASS_REFERENCE_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let file = root.join(path);
    let Ok(text) = std::fs::read_to_string(&file) else {
        println!("skipped: no reference data at {}", file.display());
        return None;
    };
    let rows: Vec<Vec<f64>> = text
        .lines()
        .map(|line| {
            line.split_whitespace()
                .map(|f| f.parse().expect("number"))
                .collect()
        })
        .collect();
    Some(
        (0..rows[0].len())
            .map(|c| rows.iter().map(|r| r[c]).collect())
            .collect(),
    )
}

fn calibrate(x: &[f64], y: &[f64], z: &[f64], fit: MultiPosition) -> MultiPositionFit {
    let samples = Samples::new(x, y, z).unwrap();
    let sweep = ThresholdSweep::run(&samples, 100.0, &[], &Standstill::default(), &fit).unwrap();
    let noise = MeanNoise::estimate(&samples, &sweep.segments).unwrap();
    let fit = fit
        .noise_dof(noise.dof())
        .fit(&noise.poses(&samples, &sweep.segments))
        .unwrap();
    println!(
        "threshold {} standstills {}",
        sweep.threshold,
        sweep.segments.len()
    );
    for c in &sweep.candidates {
        println!("{c:?}");
    }
    for q in fit.estimate().quantities() {
        println!(
            "{} = {} ± {} {} (ν {})",
            q.name, q.value, q.standard_uncertainty, q.unit, q.dof
        );
    }
    println!(
        "rms {} excess {} chi2 {} birge {:?}",
        fit.residual_rms(),
        fit.excess(),
        fit.chi_square(),
        fit.birge_ratio()
    );
    println!(
        "inflation {:?} dof {}",
        noise.variance_inflation(),
        noise.dof()
    );
    for f in fit.findings() {
        println!("{f}");
    }
    fit
}

#[test]
fn crosscheck_xsens_against_an_independent_refit() {
    let Some(c) = columns("xsens-mti/xsens_acc.txt") else {
        return;
    };
    let gravity = Gravity::given(9.81744, 1e-4).unwrap();
    let fit = calibrate(&c[1], &c[2], &c[3], MultiPosition::new(gravity));
    for (name, expected) in [
        ("scale.x", 414.42),
        ("scale.y", 412.03),
        ("scale.z", 414.62),
    ] {
        let got = fit.estimate().get(name).unwrap().value;
        assert!((got / expected - 1.0).abs() < 2e-4, "{name}: {got}");
    }
    for (name, expected) in [
        ("bias.x", 33123.9),
        ("bias.y", 33275.2),
        ("bias.z", 32364.5),
    ] {
        let got = fit.estimate().get(name).unwrap().value;
        assert!((got - expected).abs() < 2.0, "{name}: {got}");
    }
}

#[test]
fn published_mikov_mpu9150() {
    let cases = [
        (
            "imu0",
            [0.363, 0.315, 0.647],
            [0.020, 0.317, 0.123],
            [0.103, 0.097, 0.344],
        ),
        (
            "imu1",
            [0.471, 0.482, 0.932],
            [-0.010, 0.145, -0.284],
            [0.090, 0.070, 0.338],
        ),
    ];
    for (name, scale, angle, bias) in cases {
        let Some(c) = columns(&format!("mikov-mpu9150/{name}.log")) else {
            return;
        };
        let gravity = Gravity::given(9.81, 1e-4).unwrap();
        let fit = calibrate(
            &c[0],
            &c[1],
            &c[2],
            MultiPosition::new(gravity)
                .nominal_sensitivity(1.0)
                .output_unit("m/s²"),
        );
        let get = |n: &str| fit.estimate().get(n).unwrap().value;
        for (axis, expected) in ["x", "y", "z"].iter().zip(scale) {
            let got = 100.0 * (get(&format!("scale.{axis}")) - 1.0);
            println!("{name} S{axis} {got} {expected}");
        }
        for (axis, expected) in ["xy", "xz", "yz"].iter().zip(angle) {
            println!(
                "{name} m{axis} {} {expected}",
                get(&format!("misalignment.{axis}")).to_degrees()
            );
        }
        for (axis, expected) in ["x", "y", "z"].iter().zip(bias) {
            println!("{name} b{axis} {} {expected}", get(&format!("bias.{axis}")));
        }
    }
}
