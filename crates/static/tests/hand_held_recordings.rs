//! Real hand-held recordings against published and independently computed values.

use proofmass_core::Gravity;
use proofmass_static::*;
use std::path::PathBuf;

/// A recording of the reference data as columns.
fn columns(path: &str) -> Option<Vec<Vec<f64>>> {
    let root = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    let root = PathBuf::from(
        root.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md"),
    );
    let text = std::fs::read_to_string(root.join(path)).expect("the recording");
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

fn calibrate(x: &[f64], y: &[f64], z: &[f64], settings: MultiPosition) -> MultiPositionFit {
    let samples = Samples::new(x, y, z).unwrap();
    let search = Standstill::default();
    let calibration = StandstillCalibration::run(&samples, 100.0, &[], &search, &settings);
    calibration.unwrap().fit
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
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

/// `[Mikov2020]` table: scale factors in percent, misalignments in degrees, biases in m/s². Tolerances are the
/// agreement two evaluations of one recording can be asked for: 0.02 %, 0.02°, 3 mm/s².
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
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
        let settings = MultiPosition::new(Gravity::given(9.81, 1e-4).unwrap())
            .nominal_sensitivity(1.0)
            .output_unit("m/s²");
        let fit = calibrate(&c[0], &c[1], &c[2], settings);
        let get = |quantity: String| fit.estimate().get(&quantity).unwrap().value;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let got = 100.0 * (get(format!("scale.{axis}")) - 1.0);
            assert!(
                (got - scale[i]).abs() < 0.02,
                "{name} scale.{axis}: {got} %"
            );
            let got = get(format!("bias.{axis}"));
            assert!(
                (got - bias[i]).abs() < 3e-3,
                "{name} bias.{axis}: {got} m/s²"
            );
        }
        for (i, pair) in ["xy", "xz", "yz"].iter().enumerate() {
            let got = get(format!("misalignment.{pair}")).to_degrees();
            assert!(
                (got - angle[i]).abs() < 0.02,
                "{name} misalignment.{pair}: {got}°"
            );
        }
    }
}
