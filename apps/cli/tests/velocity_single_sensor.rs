//! `proofmass velocity`: one sensor alone, and sensors other than an incremental encoder.

use crate::support::axis::*;
use crate::support::*;
use std::fmt::Write as _;
use std::path::Path;

/// The encoder of a motor without its accelerometer, in m/s and in rad/s: the same numbers but for the radius.
#[test]
fn law_an_encoder_alone_in_metres_and_in_radians() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let recording = place.join("recording.csv");
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let alone = ["--position", "encoder", "--counts-per-turn", "2000"];
    let (length, angle) = (folder.path().join("length"), folder.path().join("angle"));
    let result = estimate(
        &recording,
        &length,
        &[&alone[..], &["--radius", "0.3"]].concat(),
    );
    assert!(!codes(&result).iter().any(|c| c == "constant-channel"));
    let table = length.join("velocity.csv");
    let (v, u) = (
        column(&table, "velocity_m/s"),
        column(&table, "standard_uncertainty_m/s"),
    );
    // Increments of 0.94 mm at 1 kHz make 0.38 m/s of noise in a difference.
    assert!(rms(&v, &truth, 500) < 0.1, "{}", rms(&v, &truth, 500));
    let inside = (500..v.len())
        .filter(|&k| (v[k] - truth[k]).abs() < 2.5 * u[k])
        .count() as f64;
    assert!(inside / (v.len() - 500) as f64 > 0.85, "{inside}");
    let result = estimate(&recording, &angle, &alone);
    assert_eq!(result["quantities"][0]["unit"], "rad/s");
    let turning = column(&angle.join("velocity.csv"), "velocity_rad/s");
    for (w, v) in turning.iter().zip(&v).skip(500) {
        assert!((0.3 * w - v).abs() < 1e-3 * v.abs().max(0.1), "{w} {v}");
    }
    let html = std::fs::read_to_string(angle.join("report.html")).unwrap();
    assert!(html.contains("r/min") && !html.contains("m/s<"), "units");
    // Both sensors, as an angle.
    let both = [&SENSORS[..], &["--angular"]].concat();
    estimate(&recording, &folder.path().join("both"), &both);
    let fused = column(&folder.path().join("both/velocity.csv"), "velocity_rad/s");
    let due: Vec<f64> = truth.iter().map(|v| v / 0.3).collect();
    assert!(rms(&fused, &due, 500) < 0.007, "{}", rms(&fused, &due, 500));

    let said = |question: &str, more: &[&str]| {
        let all = run(question, &recording, &[&alone[..], more].concat());
        refuse(&all.iter().map(String::as_str).collect::<Vec<_>>())
    };
    assert!(said("estimate", &["--method", "observer:10,100"]).contains("needs an accelerometer"));
    assert!(said("estimate", &["--still", "0,1"]).contains("--still is about an accelerometer"));
    assert!(said("tune", &[]).contains("two sensors"));
    let all = run("compare", &recording, &alone);
    succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
}

/// An accelerometer alone, at rest for a second: the velocity drifts within what it states; a stretch that moves is told.
#[test]
fn law_an_accelerometer_alone_states_its_drift() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("lone.csv");
    let mut lines = "time_s,acceleration_m/s2\n".to_owned();
    let mut noise = 1u64;
    let mut truth = Vec::new();
    for k in 0..5000 {
        noise = noise
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let t = 1e-3 * f64::from(k);
        let (s, c) = (9.0 * (t - 1.0)).sin_cos();
        let (a, v) = if t < 1.0 {
            (0.0, 0.0)
        } else {
            (9.0 * s, 1.0 - c)
        };
        let e = 0.02 * 12f64.sqrt() * ((noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
        writeln!(lines, "{t:.3},{:.6}", a + 0.3 + e).unwrap();
        truth.push(v);
    }
    std::fs::write(&recording, lines).unwrap();
    let sensor = ["--acceleration", "acceleration"];
    for method in [None, Some("trapezoid")] {
        let out = folder.path().join(method.unwrap_or("none"));
        let chosen: Vec<&str> = method.iter().flat_map(|m| ["--method", *m]).collect();
        let result = estimate(
            &recording,
            &out,
            &[&sensor[..], &["--still", "0,1"], &chosen].concat(),
        );
        assert!(codes(&result).is_empty(), "{:?}", codes(&result));
        let table = out.join("velocity.csv");
        let (v, u) = (
            column(&table, "velocity_m/s"),
            column(&table, "standard_uncertainty_m/s"),
        );
        let end = v.len() - 1;
        // The mean of 1000 samples at 0.02 m/s² is uncertain by 0.63 mm/s², over four seconds 2.5 mm/s.
        assert!((2e-3..5e-3).contains(&u[end]), "{}", u[end]);
        let inside = (1000..=end).filter(|&k| (v[k] - truth[k]).abs() < 2.5 * u[k]);
        assert!(inside.count() as f64 > 0.95 * (end - 999) as f64);
    }
    let out = folder.path().join("moving");
    let result = estimate(
        &recording,
        &out,
        &[&sensor[..], &["--still", "1.1,1.3"]].concat(),
    );
    assert!(codes(&result).iter().any(|c| c == "still-stretch-moves"));
    let said = |more: &[&str]| {
        let all = run("estimate", &recording, &[&sensor[..], more].concat());
        refuse(&all.iter().map(String::as_str).collect::<Vec<_>>())
    };
    assert!(said(&[]).contains("an interval at rest is needed"));
    assert!(
        said(&["--still", "0,1", "--method", "fixed-time"]).contains("needs a position or a speed")
    );
    assert!(said(&["--still", "7,8"]).contains("no sample lies"));
}

#[test]
fn angles_of_an_absolute_encoder_are_suspected_and_continued() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("angle.csv");
    let mut lines = "time_s,angle_deg\n".to_owned();
    for k in 0..3000 {
        let t = 1e-3 * f64::from(k);
        let angle = 700.0 * t + 40.0 * (3.0 * t).sin();
        writeln!(lines, "{t:.3},{:.2}", angle.rem_euclid(360.0)).unwrap();
    }
    std::fs::write(&recording, lines).unwrap();
    let (plain, wrapped) = (folder.path().join("plain"), folder.path().join("wrapped"));
    let result = estimate(&recording, &plain, &["--position", "angle_deg"]);
    assert!(codes(&result).iter().any(|c| c == "rollover-suspected"));
    let result = estimate(
        &recording,
        &wrapped,
        &["--position", "angle_deg", "--wraps"],
    );
    assert!(!codes(&result).iter().any(|c| c == "rollover-suspected"));
    let v = column(&wrapped.join("velocity.csv"), "velocity_rad/s");
    let due: Vec<f64> = (0..3000)
        .map(|k| (700.0 + 120.0 * (3e-3 * f64::from(k)).cos()).to_radians())
        .collect();
    assert!(rms(&v, &due, 500) < 0.1, "{}", rms(&v, &due, 500));
}

/// A tachogenerator of 7 V per 1000 r/min and a laser Doppler of 633 nm see one motion.
#[test]
fn crosscheck_tachogenerator_and_laser_doppler() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("speeds.csv");
    let mut lines = "time_s,tacho_V,doppler\n".to_owned();
    let speed = |k: u32| 20.0 + 5.0 * (0.01 * f64::from(k)).sin();
    for k in 0..2000 {
        let w = speed(k);
        let volts = w * 30.0 / std::f64::consts::PI * 7e-3;
        let wobble = 1e-4 * f64::from((k * 7919) % 101) / 101.0;
        writeln!(
            lines,
            "{:.3},{:.6},{:.1}",
            1e-3 * f64::from(k),
            volts + wobble,
            2.0 * 0.05 * w / 633e-9 + 2e7 * wobble
        )
        .unwrap();
    }
    std::fs::write(&recording, lines).unwrap();
    let per_volt = (1.0 / 7e-3).to_string();
    let tacho = [
        "--speed", "tacho_V", "--unit", "r/min", "--scale", &per_volt, "--method", "speed",
    ];
    let doppler = [
        "--speed", "doppler", "--unit", "m/s", "--scale", "3.165e-7", "--method", "speed",
    ];
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    estimate(&recording, &a, &tacho);
    estimate(&recording, &b, &doppler);
    let w = column(&a.join("velocity.csv"), "velocity_rad/s");
    let v = column(&b.join("velocity.csv"), "velocity_m/s");
    for k in 10..2000 {
        assert!(
            (w[k] - speed(k as u32)).abs() < 3e-3,
            "{} {}",
            w[k],
            speed(k as u32)
        );
        assert!((v[k] - 0.05 * speed(k as u32)).abs() < 1e-3, "{}", v[k]);
    }
}

/// A resolver at 5 kHz that sways and turns, sampled at 50 kHz, beside its excitation, and its demodulated voltages.
fn resolver_voltages(path: &Path, demodulated: &Path) {
    let mut lines = "time_s,sin_V,cos_V,exc_V\n".to_owned();
    let mut slow = "time_s,sin_V,cos_V\n".to_owned();
    for k in 0..25_000 {
        let t = 2e-5 * f64::from(k);
        let (s, c) = angle_of(t).0.sin_cos();
        let carrier = (std::f64::consts::TAU * 5000.0 * t - 0.3).sin();
        let wobble = |n: u32| 2e-3 * (f64::from((k as u32 * n) % 101) / 101.0 - 0.5);
        writeln!(
            lines,
            "{t:.5},{:.5},{:.5},{:.5}",
            2.0 * carrier * s + wobble(7919),
            2.0 * carrier * c + wobble(6841),
            5.0 * (std::f64::consts::TAU * 5000.0 * t).sin()
        )
        .unwrap();
        if k % 10 == 0 {
            writeln!(
                slow,
                "{t:.5},{:.5},{:.5}",
                2.0 * s + wobble(31),
                2.0 * c + wobble(37)
            )
            .unwrap();
        }
    }
    std::fs::write(path, lines).unwrap();
    std::fs::write(demodulated, slow).unwrap();
}

/// Angle and speed: some eight turns, faster and slower.
fn angle_of(t: f64) -> (f64, f64) {
    let w = 12.0;
    (
        0.7 + 100.0 * t + 3.0 * (w * t).sin(),
        100.0 + 3.0 * w * (w * t).cos(),
    )
}

#[test]
fn law_a_resolver_with_and_without_its_carrier() {
    let folder = tempfile::tempdir().unwrap();
    let (raw, plain) = (
        folder.path().join("raw.csv"),
        folder.path().join("plain.csv"),
    );
    resolver_voltages(&raw, &plain);
    let windings = ["--resolver", "sin_V,cos_V"];
    let cases: [(&str, &Path, &[&str]); 4] = [
        ("plain", &plain, &[]),
        ("excitation", &raw, &["--excitation", "exc_V"]),
        ("carrier", &raw, &["--carrier", "5000"]),
        (
            "loop",
            &raw,
            &["--excitation", "exc_V", "--method", "resolver-loop:300"],
        ),
    ];
    for (name, recording, more) in cases {
        let out = folder.path().join(name);
        let result = estimate(recording, &out, &[&windings[..], more].concat());
        let wound = name != "plain";
        assert_eq!(
            codes(&result).iter().any(|c| c == "resolver-demodulated"),
            wound,
            "{name}"
        );
        let table = out.join("velocity.csv");
        let (t, w) = (column(&table, "time_s"), column(&table, "velocity_rad/s"));
        // A loop follows 400 rad/s² with twice that over 300 rad/s.
        let allowed = if name == "loop" { 4.0 } else { 0.6 };
        let due: Vec<f64> = t.iter().map(|t| angle_of(*t).1).collect();
        assert!(
            rms(&w, &due, 500) < allowed,
            "{name}: {}",
            rms(&w, &due, 500)
        );
    }
    // The loop on voltages is the tracking loop on the angle, but for sin e in place of e.
    let mut both = run("compare", &raw, &windings);
    let out = folder.path().join("compared");
    both.extend(
        [
            "--carrier",
            "5000",
            "--method",
            "resolver-loop:300",
            "--method",
            "tracking-loop:300",
        ]
        .map(str::to_owned),
    );
    both.extend(["-o".to_owned(), text(&out).to_owned()]);
    succeed(&both.iter().map(String::as_str).collect::<Vec<_>>());
    let all = rows(&out.join("errors.csv"));
    let of = |i: usize| number(&all[i], "rms_rad/s");
    assert!((of(0) / of(1) - 1.0).abs() < 0.01, "{} {}", of(0), of(1));

    let said = |recording: &Path, more: &[&str]| {
        let all = run("estimate", recording, more);
        refuse(&all.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let asked = |more: &[&'static str]| said(&raw, &[&windings[..], more].concat());
    assert!(asked(&["--carrier", "40000"]).contains("carrier frequency"));
    assert!(asked(&["--carrier", "nan"]).contains("carrier"));
    let place = axis(folder.path(), &["--duration", "1"]);
    let other = [&SENSORS[..], &["--method", "resolver-loop:300"]].concat();
    assert!(said(&place.join("recording.csv"), &other).contains("the voltages of a resolver"));
}

/// Sixty teeth at 5 to 15 turns a second, the level sampled at 20 kHz, and the moments at which it changes.
#[test]
fn crosscheck_a_toothed_wheel_as_samples_and_as_edges() {
    let folder = tempfile::tempdir().unwrap();
    let (samples, edges) = (
        folder.path().join("samples.csv"),
        folder.path().join("edges.csv"),
    );
    let turns = |t: f64| 10.0 * t - 2.5 * (2.0 * t).cos();
    let (mut a, mut b) = ("time_s,level_V\n".to_owned(), "time_s,level_V\n".to_owned());
    let mut before = 0.0;
    for k in 0..40_000 {
        let t = 5e-5 * f64::from(k);
        let level = |t: f64| {
            if (60.0 * turns(t)).rem_euclid(1.0) < 0.5 {
                4.8
            } else {
                0.3
            }
        };
        let noise = 0.2 * (f64::from((k * 7919) % 101) / 101.0 - 0.5);
        writeln!(a, "{t:.5},{:.3}", level(t) + noise).unwrap();
        // Edges to a microsecond.
        for n in 0..50 {
            let t = t + 1e-6 * f64::from(n);
            if level(t) != before {
                before = level(t);
                writeln!(b, "{t:.6},{before}").unwrap();
            }
        }
    }
    std::fs::write(&samples, a).unwrap();
    std::fs::write(&edges, b).unwrap();
    let teeth = ["--teeth", "level_V", "--counts-per-turn", "60"];
    let due = |t: f64| std::f64::consts::TAU * (10.0 + 5.0 * (2.0 * t).sin());
    for (recording, more, allowed) in [
        (&samples, &["--method", "fixed-time:400"][..], 4.0),
        (&edges, &["--edges", "--method", "mixed-time:0.1"][..], 1.0),
    ] {
        let out = folder.path().join(format!("out{allowed}"));
        let result = estimate(recording, &out, &[&teeth[..], more].concat());
        assert!(!codes(&result).iter().any(|c| c == "edges-lost"));
        let table = out.join("velocity.csv");
        let (t, w) = (column(&table, "time_s"), column(&table, "velocity_rad/s"));
        let truth: Vec<f64> = t.iter().map(|t| due(*t)).collect();
        let skip = t.len() / 10;
        assert!(
            rms(&w, &truth, skip) < allowed,
            "{more:?}: {}",
            rms(&w, &truth, skip)
        );
    }
}

#[test]
fn crosscheck_the_drift_of_an_accelerometer() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drift");
    succeed(&[
        "velocity",
        "drift",
        "--tilt",
        "1",
        "--offset",
        "-0.01",
        "--noise",
        "0.02",
        "--rate",
        "1000",
        "--gain-uncertainty",
        "2",
        "--speed",
        "3",
        "--times",
        "10,100",
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    assert!(codes(&result).is_empty());
    let (value, u, _) = quantity(&result, "drift.10s");
    // g sin 1° · 10 s is 1.711497 m/s; 0.02 m/s² over 10 000 samples of 1 ms, and 2 % of 3 m/s.
    assert!((value - (1.711_497 - 0.1)).abs() < 1e-5, "{value}");
    assert!((u - (0.02f64 * 0.1).hypot(0.06)).abs() < 1e-9, "{u}");
    assert_eq!(column(&out.join("drift.csv"), "time_s"), [10.0, 100.0]);
    // A density n is samples of n √(f/2).
    let told = |arguments: &[&str]| {
        let mut all = vec![
            "velocity",
            "drift",
            "--json",
            "--tilt-uncertainty",
            "0.1",
            "--times",
            "10",
        ];
        all.extend(arguments);
        let said = succeed(&all).stdout;
        let result: serde_json::Value = serde_json::from_slice(&said).expect("JSON");
        quantity(&result, "drift.10s").1
    };
    let density = (0.02 * (2.0f64 / 1000.0).sqrt()).to_string();
    let pair = [
        told(&["--noise", "0.02", "--rate", "1000"]),
        told(&["--noise-density", &density]),
    ];
    assert!((pair[0] / pair[1] - 1.0).abs() < 1e-12, "{pair:?}");
    for (wrong, why) in [
        (&["--times", "1"][..], "no source"),
        (&["--offset", "nan"], "not a finite number"),
        (&["--offset", "1", "--times", "0"], "above zero"),
        (
            &["--offset", "1e300", "--times", "1e300"],
            "the drift overflows",
        ),
        (&["--noise", "1", "--rate", "0"], "sample time"),
        (&["--tilt", "200"], "inclination"),
    ] {
        let all: Vec<&str> = ["velocity", "drift"].iter().chain(wrong).copied().collect();
        let said = refuse(&all);
        assert!(said.contains(why), "{wrong:?}: {said}");
    }
}

/// Every method by its word, on a recording that suits it.
#[test]
fn every_method_is_reached_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "1"]);
    let recording = place.join("recording.csv");
    let mut all = run("compare", &recording, &SENSORS);
    for word in [
        "fixed-time",
        "fixed-time:20",
        "backward-difference:1",
        "backward-difference:2",
        "backward-difference:3",
        "savitzky-golay:9,2",
        "tracking-loop:100",
        "trapezoid",
        "simpson",
        "tick",
        "adams-moulton-3",
        "trapezoid:0.01",
        "newmark:0.5,0.25",
        "newmark:0.6,0.3,0.01",
        "high-pass:0.5,2",
        "zero-phase:0.5,2",
        "two-channel:0,10",
        "two-channel:1,10",
        "observer:10,100",
        "offset-observer:15,75,125",
        "adaptive-observer:10,100,1,0.001",
        "kalman:4e-4,7.4e-8",
        "kalman:4e-4,7.4e-8,1e-6,0.1",
        "gauss-markov:4e-4,7.4e-8,0.02,30",
        "steady-kalman:4e-4,7.4e-8",
        "smoother:4e-4,7.4e-8",
        "counting:4e-4,1e-6,0.1",
        "counting-smoother:4e-4,1e-6,0.1",
    ] {
        all.extend(["--method".to_owned(), word.to_owned()]);
    }
    let truth = place.join("truth.csv");
    all.extend(["--reference", "velocity", "--reference-file", text(&truth)].map(str::to_owned));
    let out = folder.path().join("out");
    all.extend(["-o".to_owned(), text(&out).to_owned()]);
    succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
    // Those that were named, and the five that are tuned of an axis that is slow for its counts.
    assert_eq!(rows(&out.join("errors.csv")).len(), 28 + 5);
}
