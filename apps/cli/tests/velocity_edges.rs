//! `proofmass velocity`: edges, counters that roll over, and slower encoders.

use crate::support::axis::*;
use crate::support::*;
use std::fmt::Write as _;

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
        let found = codes(&result);
        assert_eq!(
            found.contains(&"edges-lost".to_owned()),
            lost.is_some(),
            "{name}: {found:?}"
        );
    }
}
