//! `proofmass velocity` and `proofmass simulate axis`: simulated axes with truth, logs of a robot, bad files.

mod support;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use support::*;

/// Columns of a CSV file; an empty field is `None`.
fn columns(path: &Path) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names: Vec<String> = lines
        .next()
        .expect("headings")
        .split(',')
        .map(str::to_owned)
        .collect();
    let mut data = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, field) in data.iter_mut().zip(line.split(',')) {
            column.push(field.parse().ok());
        }
    }
    (names, data)
}

fn column(path: &Path, name: &str) -> Vec<f64> {
    let (names, data) = columns(path);
    let at = names.iter().position(|n| n == name);
    let at = at.unwrap_or_else(|| panic!("no {name} in {names:?}"));
    data[at].iter().map(|v| v.expect("a number")).collect()
}

/// Simulates an axis into `folder/axis` and gives that folder back.
fn axis(folder: &Path, arguments: &[&str]) -> PathBuf {
    let place = folder.join("axis");
    let mut all = vec!["simulate", "axis", "-o", text(&place)];
    all.extend(arguments);
    succeed(&all);
    place
}

/// Arguments that tell the simulated sensors.
const SENSORS: [&str; 8] = [
    "--position",
    "encoder",
    "--counts-per-turn",
    "2000",
    "--radius",
    "0.3",
    "--acceleration",
    "acceleration",
];

fn run(question: &str, recording: &Path, arguments: &[&str]) -> Vec<String> {
    let mut all = vec!["velocity", question, text(recording)];
    all.extend(arguments);
    all.into_iter().map(str::to_owned).collect()
}

fn estimate(recording: &Path, out: &Path, arguments: &[&str]) -> serde_json::Value {
    let mut all = run("estimate", recording, arguments);
    all.extend(["-o".to_owned(), text(out).to_owned()]);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let said = succeed(&all);
    let shown = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(!shown.contains("NaN") && !shown.contains("inf"), "{shown}");
    json(&out.join("result.json"))
}

fn rms(a: &[f64], b: &[f64], skip: usize) -> f64 {
    let sum: f64 = a
        .iter()
        .zip(b)
        .skip(skip)
        .map(|(a, b)| (a - b) * (a - b))
        .sum();
    (sum / (a.len() - skip) as f64).sqrt()
}

#[test]
fn an_estimate_holds_the_truth_in_its_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let out = folder.path().join("out");
    let result = estimate(
        &place.join("recording.csv"),
        &out,
        &[&SENSORS[..], &["--at-rest"]].concat(),
    );
    assert!(holds_only(
        &out,
        &[
            "manifest.json",
            "report.html",
            "result.json",
            "velocity.csv"
        ]
    ));
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let table = out.join("velocity.csv");
    let (v, u) = (
        column(&table, "velocity_m/s"),
        column(&table, "standard_uncertainty_m/s"),
    );
    // 0.02 m/s² of noise and increments of 0.94 mm against a velocity of 0.65 m/s amplitude.
    assert!(rms(&v, &truth, 500) < 0.002, "{}", rms(&v, &truth, 500));
    let smoothed = column(&table, "smoothed_m/s");
    assert!(rms(&smoothed, &truth, 500) < 0.001);
    let inside = (500..v.len())
        .filter(|&k| (v[k] - truth[k]).abs() < 2.5 * u[k])
        .count() as f64
        / (v.len() - 500) as f64;
    // Samples are correlated over some 0.1 s: 35 independent ones; two and a half σ hold 98.8 %.
    assert!(inside > 0.85, "{inside}");
    let gain = result["extra"]["outcome"]["result"]["pairing"]["gain"]
        .as_f64()
        .unwrap();
    assert!((gain - 1.0).abs() < 0.01, "{gain}");
    assert!(!codes(&result).iter().any(|c| c == "slip"));
}

#[test]
fn a_comparison_at_three_rates_shows_the_fused_methods_ahead() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &[]);
    let out = folder.path().join("out");
    let truth = place.join("truth.csv");
    let mut all = run("compare", &place.join("recording.csv"), &SENSORS);
    all.extend(
        [
            "--reference",
            "velocity",
            "--reference-file",
            text(&truth),
            "--rates",
            "1000,100,20",
            "-o",
            text(&out),
        ]
        .map(str::to_owned),
    );
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    succeed(&all);
    assert!(holds_only(
        &out,
        &[
            "errors.csv",
            "manifest.json",
            "report.html",
            "result.json",
            "velocities.csv"
        ]
    ));
    let result = json(&out.join("result.json"));
    let comparison = &result["extra"]["outcome"]["result"];
    assert_eq!(comparison["reference_is_truth"], true);
    let rows = comparison["rows"].as_array().unwrap();
    for rate in [1000.0, 100.0, 20.0] {
        let best = |families: &[&str], tuned: bool| {
            rows.iter()
                .filter(|r| (r["rate"].as_f64().unwrap() / rate - 1.0).abs() < 1e-6)
                .filter(|r| families.contains(&r["family"].as_str().unwrap()))
                .filter(|r| !tuned || r["method"]["method"] == "kalman")
                .map(|r| r["agreement"]["rms"].as_f64().unwrap())
                .fold(f64::INFINITY, f64::min)
        };
        let single = best(&["position", "acceleration"], false);
        let fused = best(&["fused"], true);
        assert!(fused < 0.7 * single, "{rate}: {fused} {single}");
    }
    // Without a reference the smoother stands in, and it is said.
    let output = succeed(
        &run("compare", &place.join("recording.csv"), &SENSORS)
            .iter()
            .map(String::as_str)
            .chain(["--json", "--rates", "100"])
            .collect::<Vec<_>>(),
    );
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).iter().any(|c| c == "smoother-as-reference"));
    let said = refuse(
        &run("compare", &place.join("recording.csv"), &SENSORS)
            .iter()
            .map(String::as_str)
            .chain(["--rates", "300"])
            .collect::<Vec<_>>(),
    );
    assert!(said.contains("333.33") && said.contains("250"), "{said}");
}

#[test]
fn tuning_finds_the_noise_that_was_put_in() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--noise", "0.3", "--motion", "motor"]);
    let out = folder.path().join("out");
    let mut all = run("tune", &place.join("recording.csv"), &SENSORS);
    all.extend(["-o".to_owned(), text(&out).to_owned()]);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    succeed(&all);
    assert!(holds_only(
        &out,
        &[
            "likelihood.csv",
            "manifest.json",
            "quantities.csv",
            "report.html",
            "result.json"
        ]
    ));
    let result = json(&out.join("result.json"));
    let tuned = &result["extra"]["outcome"]["result"]["tuned"];
    let q = tuned["model"]["acceleration_noise"].as_f64().unwrap();
    // q of 5000 samples seen through increments of 0.94 mm: its 95 % interval is some ±25 %; twice that.
    assert!((q.sqrt() / 0.3 - 1.0).abs() < 0.3, "{q}");
    let r = tuned["model"]["reading_noise"].as_f64().unwrap();
    let delta = 0.3 * std::f64::consts::TAU / 2000.0;
    assert!((r * 12.0 / (delta * delta) - 1.0).abs() < 0.2, "{r}");
}

#[test]
fn counters_of_16_and_32_bits_roll_over_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let plain = axis(folder.path(), &["--duration", "2"]);
    let method = ["--method", "observer:10,100"];
    let one = folder.path().join("plain-out");
    estimate(
        &plain.join("recording.csv"),
        &one,
        &[&SENSORS[..], &method].concat(),
    );
    let expected = column(&one.join("velocity.csv"), "velocity_m/s");
    for bits in ["16", "32"] {
        let inner = folder.path().join(bits);
        std::fs::create_dir(&inner).unwrap();
        let place = axis(&inner, &["--duration", "2", "--counter-bits", bits]);
        let recording = place.join("recording.csv");
        let out = inner.join("out");
        let with = [&SENSORS[..], &method, &["--bits", bits]].concat();
        estimate(&recording, &out, &with);
        let found = column(&out.join("velocity.csv"), "velocity_m/s");
        // Positions differ by a constant, which costs digits.
        assert!(rms(&found, &expected, 0) < 1e-6, "{bits}");
        let without = [&SENSORS[..], &method, &["--json", "--strict"]].concat();
        let all = run("estimate", &recording, &without);
        let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(codes(&result).iter().any(|c| c == "rollover-suspected"));
    }
}

#[test]
fn missing_and_slow_readings_are_carried_from_one_file_or_two() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(
        folder.path(),
        &["--motion", "motor", "--every", "5", "--missing", "0.1"],
    );
    let recording = place.join("recording.csv");
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let out = folder.path().join("one");
    let result = estimate(&recording, &out, &SENSORS);
    assert!(codes(&result).iter().any(|c| c == "missing-readings"));
    let one = column(&out.join("velocity.csv"), "velocity_m/s");
    // Against 0.65 m/s amplitude, with readings 5 ms apart and every tenth of them missing.
    assert!(
        rms(&one, &truth, 1000) < 0.02,
        "{}",
        rms(&one, &truth, 1000)
    );

    // The same sensors in a file each.
    let (_, data) = columns(&recording);
    let mut encoder = "t_ms;count\n".to_owned();
    let mut accelerometer = "time_s;a_m/s2\n".to_owned();
    for k in 0..data[0].len() {
        let t = data[0][k].unwrap();
        if let Some(count) = data[1][k] {
            writeln!(encoder, "{};{count}", 1e3 * t).unwrap();
        }
        writeln!(accelerometer, "{t};{}", data[2][k].unwrap()).unwrap();
    }
    let (first, second) = (
        folder.path().join("encoder.csv"),
        folder.path().join("accelerometer.csv"),
    );
    std::fs::write(&first, encoder).unwrap();
    std::fs::write(&second, accelerometer).unwrap();
    let out = folder.path().join("two");
    estimate(
        &first,
        &out,
        &[
            "--position",
            "count",
            "--counts-per-turn",
            "2000",
            "--radius",
            "0.3",
            "--acceleration",
            "a",
            "--acceleration-file",
            text(&second),
        ],
    );
    let two = column(&out.join("velocity.csv"), "velocity_m/s");
    let n = two.len().min(one.len());
    assert!(rms(&two[..n], &one[..n], 1000) < 0.005);
}

#[test]
fn time_stamped_edges_beat_samples() {
    let folder = tempfile::tempdir().unwrap();
    // A slow sine of 20 mm: 42 increments of 0.47 mm; edges at the times at which the position crosses them.
    let (delta, amplitude, w) = (4.7e-4f64, 0.02f64, 2.0f64);
    let mut places = "time_s,count\n".to_owned();
    let mut counts = places.clone();
    let (mut last, fine) = (0i64, 200_000);
    for k in 1..fine {
        let t = 10.0 * f64::from(k) / f64::from(fine);
        let count = (amplitude * (w * t).sin() / delta).floor() as i64;
        if count != last {
            // The edge lies between two counts: at the upper of them going up, at the lower going down.
            writeln!(places, "{t:.9},{}", count.max(last)).unwrap();
            writeln!(counts, "{t:.9},{count}").unwrap();
            last = count;
        }
    }
    let mut accelerometer = "time_s,a_m/s2\n".to_owned();
    for k in 0..2000 {
        let t = 0.005 * f64::from(k);
        writeln!(
            accelerometer,
            "{t:.3},{:.9}",
            -amplitude * w * w * (w * t).sin()
        )
        .unwrap();
    }
    let second = folder.path().join("a.csv");
    std::fs::write(&second, accelerometer).unwrap();
    let told = [
        "--position",
        "count",
        "--edges",
        "--counts-per-metre",
        "2127.6595744680853",
    ];
    let both = ["--acceleration", "a", "--acceleration-file"];
    let mut errors = Vec::new();
    // The place of each edge, or the count after it: the same velocity.
    for (name, edges) in [("places", &places), ("counts", &counts)] {
        let first = folder.path().join(format!("{name}.csv"));
        std::fs::write(&first, edges).unwrap();
        let out = folder.path().join(name);
        let arguments: Vec<&str> = told
            .into_iter()
            .chain(both)
            .chain([text(&second)])
            .collect();
        estimate(&first, &out, &arguments);
        let table = out.join("velocity.csv");
        let (t, v) = (column(&table, "time_s"), column(&table, "velocity_m/s"));
        let truth: Vec<f64> = t.iter().map(|t| amplitude * w * (w * t).cos()).collect();
        errors.push(rms(&v, &truth, 400));
    }
    // Of 0.04 m/s; edges are known to 50 µs.
    assert!(errors.iter().all(|e| *e < 2e-5), "{errors:?}");
    assert!((errors[0] / errors[1] - 1.0).abs() < 1e-6, "{errors:?}");
    // Without an accelerometer, and by the methods of drives.
    let first = folder.path().join("counts.csv");
    for (method, most) in [
        (None, 5e-3),
        (Some("mixed-time:0.5"), 5e-3),
        (Some("fixed-position:4"), 2e-2),
    ] {
        let out = folder
            .path()
            .join(method.unwrap_or("alone").replace(':', "-"));
        let mut arguments = told.to_vec();
        arguments.extend(method.into_iter().flat_map(|m| ["--method", m]));
        estimate(&first, &out, &arguments);
        let table = out.join("velocity.csv");
        let (t, v) = (column(&table, "time_s"), column(&table, "velocity_m/s"));
        let truth: Vec<f64> = t.iter().map(|t| amplitude * w * (w * t).cos()).collect();
        let error = rms(&v, &truth, 100);
        assert!(error < most, "{method:?}: {error}");
    }
}

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
        "--json",
    ];
    let all = run("compare", &path, &sensors);
    let output = succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let codes = codes(&result);
    for code in ["repeated-readings", "slow-reference"] {
        assert!(codes.iter().any(|c| c == code), "{code}: {codes:?}");
    }
    for code in ["unit-suspected", "gain-mismatch", "opposite-sense"] {
        assert!(!codes.iter().any(|c| c == code), "{code}: {codes:?}");
    }
    let rows = result["extra"]["outcome"]["result"]["rows"]
        .as_array()
        .unwrap();
    let rms = |method: &str| {
        let row = rows.iter().find(|r| r["method"]["method"] == method);
        let row = row.unwrap_or_else(|| panic!("no {method}"));
        row["agreement"]["rms"].as_f64().unwrap()
    };
    let (wheel, kalman) = (rms("speed-reading"), rms("kalman"));
    println!(
        "wheel {wheel}, integral {}, Kalman {kalman}, smoother {}",
        rms("integration"),
        rms("smoother")
    );
    assert!(kalman < 0.7 * wheel, "{kalman} {wheel}");
    assert!(kalman < 0.1 * rms("integration"));
    assert!(rms("smoother") < kalman);
}

#[test]
fn a_wrong_unit_is_a_finding_that_needs_a_decision() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "3"]);
    let recording = place.join("recording.csv");
    let text_of = std::fs::read_to_string(&recording).unwrap();
    let in_g: String = text_of
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((head, a)) if !a.contains('a') => {
                format!("{head},{:.6}\n", a.parse::<f64>().unwrap() / 9.80665)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    std::fs::write(&recording, in_g).unwrap();
    let all = run(
        "estimate",
        &recording,
        &[&SENSORS[..], &["--json", "--strict"]].concat(),
    );
    let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let findings = result["findings"].as_array().unwrap();
    let found = findings.iter().find(|f| f["code"] == "unit-suspected");
    let what = found.expect("unit-suspected")["what"].as_str().unwrap();
    assert!(what.contains("in g"), "{what}");
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--duration", "1"]);
    let good = std::fs::read_to_string(place.join("recording.csv")).unwrap();
    let path = folder.path().join("bad.csv");
    let out = folder.path().join("out");
    let said = |lines: &[String]| {
        std::fs::write(&path, lines.join("\n")).unwrap();
        let mut all = run("estimate", &path, &SENSORS);
        all.extend(["-o".to_owned(), text(&out).to_owned()]);
        let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(said.contains("hint:"), "{said}");
        assert!(!out.exists(), "{said}");
        said
    };
    let lines: Vec<String> = good.lines().map(str::to_owned).collect();
    let with = |at: usize, line: &str| {
        let mut lines = lines.clone();
        lines[at] = line.to_owned();
        lines
    };
    assert!(said(&[]).contains("bad.csv"));
    assert!(said(&lines[..1]).contains("bad.csv"));
    assert!(said(&lines[..4]).contains("bad.csv"));
    // Cut off within a row.
    let mut cut = lines[..500].to_vec();
    cut[499].truncate(4);
    assert!(said(&cut).contains("bad.csv:500"));
    for (line, word) in [
        ("0.199,12,NaN", "NaN"),
        ("0.199,12,inf", "inf"),
        ("0.199,x,0.1", "x"),
        ("0.099,12,0.1", "backwards"),
        ("0.198,12,0.1", "repeats"),
        ("0.199,12.5,0.1", "12.5"),
    ] {
        let said = said(&with(200, line));
        assert!(
            said.contains("bad.csv:201") && said.contains(word),
            "{line}: {said}"
        );
    }
    // A unit that is no acceleration, a column that is not there.
    let renamed = |heading: &str| with(0, heading);
    let volts = said(&renamed("time_s,encoder_count,acceleration_V"));
    assert!(
        volts.contains("V") && volts.contains("calibration"),
        "{volts}"
    );
    let bare = said(&renamed("time_s,encoder_count,acceleration"));
    assert!(bare.contains("--acceleration-unit"), "{bare}");
    let other = said(&renamed("time_s,encoder_count,accel_m/s2"));
    assert!(other.contains("accel_m/s2"), "{other}");
}

#[test]
fn dead_channels_need_a_decision_and_a_standstill_cannot_be_tuned() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dead.csv");
    let mut lines = "time_s,encoder_count,acceleration_m/s2\n".to_owned();
    for k in 0..2000 {
        writeln!(lines, "{:.3},{},0.5", 0.001 * f64::from(k), k / 3).unwrap();
    }
    std::fs::write(&path, lines).unwrap();
    let all = run(
        "estimate",
        &path,
        &[&SENSORS[..], &["--json", "--strict"]].concat(),
    );
    let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).iter().any(|c| c == "constant-channel"));
    let place = axis(
        folder.path(),
        &["--motion", "standstill", "--duration", "2"],
    );
    let recording = place.join("recording.csv");
    let out = folder.path().join("out");
    let result = estimate(&recording, &out, &[&SENSORS[..], &["--at-rest"]].concat());
    assert!(codes(&result).iter().any(|c| c == "readings-never-change"));
    let v = column(&out.join("velocity.csv"), "smoothed_m/s");
    assert!(v.iter().all(|v| v.abs() < 0.01));
    let all = run("tune", &recording, &SENSORS);
    let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("standstill"), "{said}");
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
        let found = &result["extra"]["outcome"]["result"];
        // 95 % are due of a matched model.
        assert!(found["agreement"].as_f64().unwrap() > 0.9, "{name}");
        assert!(codes.iter().any(|c| c == "encoder-ripple"), "{name}");
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
    assert!(said(&[]).contains("a stretch at rest is needed"));
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

/// One corrupted word in four seconds: left out and told, the velocity stays where it was.
#[test]
fn law_a_glitch_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let recording = place.join("recording.csv");
    let lines = std::fs::read_to_string(&recording).unwrap();
    let bad: String = lines
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k == 2001 {
                let count: i64 = fields[1].parse().unwrap();
                fields[1] = (count ^ 0x100).to_string();
            }
            fields.join(",") + "\n"
        })
        .collect();
    std::fs::write(&recording, bad).unwrap();
    let out = folder.path().join("out");
    let result = estimate(&recording, &out, &[&SENSORS[..], &["--at-rest"]].concat());
    let found = codes(&result);
    assert!(
        found.iter().any(|c| c == "glitches") && !found.iter().any(|c| c == "slip"),
        "{found:?}"
    );
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let v = column(&out.join("velocity.csv"), "velocity_m/s");
    assert!(rms(&v, &truth, 500) < 0.002, "{}", rms(&v, &truth, 500));
}

#[test]
fn law_a_map_that_is_subtracted_is_not_found_again() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    // A wheel of 2 cm swings through several turns on a disc that is 0.02 rad off its axis.
    let place = axis(
        folder,
        &[
            "--radius",
            "0.02",
            "--eccentricity",
            "0.02",
            "--duration",
            "4",
        ],
    );
    let recording = place.join("recording.csv");
    let mut sensors = SENSORS.to_vec();
    sensors[5] = "0.02";
    let ask = |question: &str, more: &[&str]| {
        let mut all = vec!["velocity", question, text(&recording)];
        all.extend(&sensors);
        all.extend(more);
        all.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let run = |arguments: Vec<String>| {
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        succeed(&words);
    };
    let (first, second) = (folder.join("first"), folder.join("second"));
    run(ask("map", &["--orders", "1,2", "-o", text(&first)]));
    let result = first.join("result.json");
    let (amplitude, u, _) = quantity(&json(&result), "amplitude.1");
    assert!((amplitude - 4e-4).abs() < 4.0 * u, "{amplitude} {u}");
    run(ask(
        "map",
        &[
            "--orders",
            "1,2",
            "--encoder-map",
            text(&result),
            "-o",
            text(&second),
        ],
    ));
    let left = json(&second.join("result.json"));
    assert_eq!(left["quantities"].as_array().map(Vec::len), Some(0));
    // Equal quarters are no line.
    let third = folder.join("third");
    run(ask(
        "map",
        &["--orders", "1", "--quarters", "-o", text(&third)],
    ));
    let quarters = json(&third.join("result.json"));
    assert_eq!(quarters["quantities"].as_array().map(Vec::len), Some(1));
    assert!(
        std::fs::read_to_string(third.join("lines.csv"))
            .unwrap()
            .contains("\n500.0,")
    );
    // Another file is no map, and a map of lengths none of angles.
    let mut wrong = ask("estimate", &["--encoder-map", text(&recording)]);
    let words: Vec<&str> = wrong.iter().map(String::as_str).collect();
    assert!(refuse(&words).contains("velocity map"));
    wrong.pop();
    wrong.extend([text(&result).to_owned(), "--angular".to_owned()]);
    let words: Vec<&str> = wrong.iter().map(String::as_str).collect();
    assert!(refuse(&words).contains("the map is in m"));
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
fn refuses_edges_that_say_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("edges.csv");
    let told = [
        "--position",
        "count",
        "--edges",
        "--counts-per-metre",
        "1000",
    ];
    let said = |rows: &str, more: &[&str]| {
        std::fs::write(&path, format!("time_s,count\n{rows}")).unwrap();
        let arguments = [&told[..], more].concat();
        let words = run("estimate", &path, &arguments);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        refuse(&words)
    };
    // No motion, time that runs back, no edges, a method of edges on samples.
    said("0.0,1\n0.1,1\n0.2,1\n", &[]);
    said("0.0,1\n0.2,2\n0.1,3\n0.3,4\n", &[]);
    said("0.0,1\n", &[]);
    said("0.0,1\n0.1,2.5\n0.2,3\n", &[]);
    let ramp: String = (0..200)
        .map(|k| format!("{},{k}\n", 0.01 * f64::from(k)))
        .collect();
    said(&ramp, &["--method", "mixed-time:0"]);
    said(&ramp, &["--method", "mixed-time:1e9"]);
    said(&ramp, &["--method", "fixed-position:0"]);
    std::fs::write(&path, format!("time_s,count\n{ramp}")).unwrap();
    let samples = ["--position", "count", "--counts-per-metre", "1000"];
    let words = run(
        "estimate",
        &path,
        &[&samples[..], &["--method", "mixed-time:0.1"]].concat(),
    );
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    assert!(refuse(&words).contains("edges"));
}

#[test]
fn edges_that_are_missing_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("edges.csv");
    let told = [
        "--position",
        "count",
        "--edges",
        "--counts-per-metre",
        "1000",
    ];
    for (name, lost) in [("whole", None), ("one", Some(70)), ("reset", Some(100))] {
        let rows: String = (0..200)
            .filter(|k| Some(*k) != lost)
            .map(|k| {
                let count = if name == "reset" && k > 100 {
                    k - 101
                } else {
                    k
                };
                format!(
                    "{:.6},{count}\n",
                    0.01 * f64::from(k) + 1e-3 * (0.1 * f64::from(k)).sin()
                )
            })
            .collect();
        std::fs::write(&path, format!("time_s,count\n{rows}")).unwrap();
        let result = estimate(&path, &folder.path().join(name), &told);
        let found = codes(&result).contains(&"edges-lost".to_owned());
        assert_eq!(found, lost.is_some(), "{name}: {:?}", codes(&result));
    }
}
