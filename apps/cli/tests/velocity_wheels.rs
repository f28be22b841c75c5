//! `proofmass velocity`: wheels of vehicles and robots, and what they tell of one another.

use crate::support::axis::*;
use crate::support::*;
use std::fmt::Write as _;
use std::path::Path;

/// A drive: wheel speed in km/h at 20 Hz, held in a log at 100 Hz, accelerometer with an offset, reference in m/s.
fn drive(path: &Path) {
    let mut noise = 1u64;
    let mut uniform = move || {
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let speed = |t: f64| 10.0 + 4.0 * (0.3 * t).sin() + 1.5 * (1.1 * t).sin();
    let mut lines = "time_s,wheel_km/h,acc_long_m/s2,gps_m/s\n".to_owned();
    let mut wheel = 0.0;
    for k in 0..6000 {
        let t = 1e9 + 0.01 * f64::from(k);
        let s = 0.01 * f64::from(k);
        if k % 5 == 0 {
            wheel = (3.6 * (speed(s) + 0.1 * uniform()) / 0.05).round() * 0.05;
        }
        let a = 1.2 * (0.3 * s).cos() + 1.65 * (1.1 * s).cos() + 0.3 + 0.4 * uniform();
        let gps = if k % 10 == 0 {
            format!("{:.4}", speed(s))
        } else {
            String::new()
        };
        writeln!(lines, "{t:.2},{wheel:.2},{a:.6},{gps}").unwrap();
    }
    std::fs::write(path, lines).unwrap();
}

#[test]
fn a_wheel_speed_is_fused_against_a_slow_reference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.csv");
    drive(&path);
    let sensors = [
        "--speed",
        "wheel",
        "--acceleration",
        "acc_long",
        "--reference",
        "gps",
    ];
    let out = tempfile::tempdir().unwrap();
    let mut all = run("compare", &path, &sensors);
    all.extend(["-o".to_owned(), text(&out.path().join("out")).to_owned()]);
    succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let result = json(&out.path().join("out/result.json"));
    let codes = codes(&result);
    for code in ["repeated-samples", "slow-reference"] {
        assert!(codes.iter().any(|c| c == code), "{code}: {codes:?}");
    }
    for code in ["unit-suspected", "gain-mismatch", "opposite-sense"] {
        assert!(!codes.iter().any(|c| c == code), "{code}: {codes:?}");
    }
    let rows = rows(&out.path().join("out/errors.csv"));
    let rms = |method: &str| {
        let row = rows.iter().find(|r| field(r, "method").contains(method));
        number(row.unwrap_or_else(|| panic!("no {method}")), "rms_m/s")
    };
    let (wheel, kalman) = (rms("speed as read"), rms("Kalman"));
    println!(
        "wheel {wheel}, integral {}, Kalman {kalman}, smoother {}",
        rms("integration"),
        rms("smoother")
    );
    assert!(kalman < 0.7 * wheel, "{kalman} {wheel}");
    assert!(kalman < 0.1 * rms("integration"));
    assert!(rms("smoother") < kalman);
}

/// A minute of a car in curves: two wheels, an accelerometer along it and a gyroscope; the right wheel spins at 30 s.
fn car(path: &Path, spin: f64) {
    let mut lines = "time_s,left_m/s,right_m/s,along_m/s2,yaw_deg/s\n".to_owned();
    let mut noise = 7u64;
    let mut uniform = move || {
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for k in 0..6000 {
        let t = 0.01 * f64::from(k);
        let v = 12.0 + 6.0 * (0.35 * t).sin();
        let turn = 0.3 * (0.5 * t).sin();
        let extra = spin * ((t - 30.0).clamp(0.0, 0.3) - (t - 31.0).clamp(0.0, 0.3)) / 0.3;
        let read = |v: f64| (100.0 * v).round() / 100.0;
        let (left, right) = (v - 0.75 * turn, v + 0.75 * turn + extra);
        writeln!(
            lines,
            "{t:.2},{:.2},{:.2},{:.5},{:.4}",
            read(left + 0.05 * uniform()),
            read(right + 0.05 * uniform()),
            2.1 * (0.35 * t).cos() + 0.1 * uniform(),
            (turn + 0.01 * uniform() + 0.004).to_degrees()
        )
        .unwrap();
    }
    std::fs::write(path, lines).unwrap();
}

#[test]
fn a_wheel_that_spins_is_told_by_the_gyroscope() {
    let folder = tempfile::tempdir().unwrap();
    let told = ["--speed", "left,right", "--acceleration", "along"];
    let gyroscope = ["--yaw-rate", "yaw", "--track", "1.5"];
    for (name, spin) in [("spinning", 1.5), ("healthy", 0.0)] {
        let recording = folder.path().join(format!("{name}.csv"));
        car(&recording, spin);
        let arguments = [&told[..], &gyroscope].concat();
        let result = estimate(&recording, &folder.path().join(name), &arguments);
        let found = codes(&result).contains(&"wheel-slip".to_owned());
        assert_eq!(found, spin > 0.0, "{name}: {:?}", codes(&result));
    }
    // A track of nothing, one wheel, a column that is no rate.
    let recording = folder.path().join("healthy.csv");
    for (wrong, word) in [
        (
            vec!["--speed", "left,right", "--yaw-rate", "yaw", "--track", "0"],
            "track",
        ),
        (
            vec!["--speed", "left", "--yaw-rate", "yaw", "--track", "1.5"],
            "two wheels",
        ),
        (
            vec![
                "--speed",
                "left,right",
                "--yaw-rate",
                "along",
                "--track",
                "1.5",
            ],
            "no rate of turning",
        ),
    ] {
        let words = run("estimate", &recording, &wrong);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let said = refuse(&words);
        assert!(said.contains(word), "{wrong:?}: {said}");
    }
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_logs_of_a_robot() {
    let root = reference_data();
    let folder = tempfile::tempdir().unwrap();
    for (name, from, to) in [
        ("t0.2.tab", None, None),
        ("0.2-2.tab", Some(1.3), Some(0.7)),
        ("20190427-v4-t0.3-2.csv", Some(1.9), Some(1.0)),
    ] {
        let log = root.join("encoder-robot").join(name);
        let out = folder.path().join(name);
        let result = estimate(
            &log,
            &out,
            &[
                "--rate",
                "1000",
                "--position",
                "1,2",
                "--unit",
                "mm",
                "--acceleration",
                "4",
                "--acceleration-unit",
                "mm/s2",
                "--at-rest",
                "--circumference",
                "0.04",
            ],
        );
        let codes = codes(&result);
        println!("{name}: {codes:?}");
        // 95 % are due of a matched model.
        assert!(
            result["extra"]["agreement"].as_f64().unwrap() > 0.9,
            "{name}"
        );
        // The part of the second log without slip is 29 turns of the wheel, whose line does not stand out of the motion around it.
        let told = codes.iter().any(|c| c == "encoder-ripple");
        assert!(told || name == "0.2-2.tab", "{name}");
        let slip = column(&out.join("velocity.csv"), "slip");
        let at = |t: f64| slip[(1000.0 * t) as usize] > 0.0;
        match (from, to) {
            (Some(slipping), Some(rolling)) => {
                assert!(at(slipping) && !at(rolling), "{name}");
                assert!(codes.iter().any(|c| c == "slip"), "{name}");
            }
            _ => assert!(
                !codes.iter().any(|c| c == "slip" || c == "collision"),
                "{name}"
            ),
        }
    }
}
