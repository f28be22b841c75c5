//! Every source is read once: files, pipes and packed files give the same numbers, and time is what the stamps say.

use crate::support::*;
use std::fmt::Write as _;
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs with bytes at standard input, fed slowly enough that every read comes back short.
fn fed(bytes: &[u8], arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let bytes = bytes.to_vec();
    let feeder = std::thread::spawn(move || {
        for piece in bytes.chunks(10_007) {
            if pipe.write_all(piece).is_err() {
                break;
            }
        }
    });
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    output
}

fn shown(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn regress_a_pipe_keeps_its_head() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fixed.csv");
    let mut rows = String::new();
    for i in 0..100_000_i64 {
        let _ = writeln!(rows, "{},{}", (i * 7919) % 1000, (i * 104_729) % 1000);
    }
    fs::write(&file, &rows).unwrap();
    let json = |output: &Output| -> serde_json::Value {
        assert!(output.status.success(), "{}", stderr(output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let of_file = json(&proofmass(&["inspect", text(&file), "--json"]));
    for name in ["-", "/dev/stdin"] {
        let of_pipe = json(&fed(rows.as_bytes(), &["inspect", name, "--json"]));
        for key in ["rows", "sha256", "columns"] {
            assert_eq!(of_pipe[key], of_file[key], "{name}, {key}");
        }
    }
    assert_eq!(of_file["rows"], 100_000);
    // A recording without its last line end, cut within a number.
    let cut = rows
        .trim_end()
        .trim_end_matches(|c: char| c.is_ascii_digit());
    let output = fed(format!("{cut}1").as_bytes(), &["inspect", "-"]);
    let all = shown(&output) + &stderr(&output);
    assert!(all.contains("line end"), "{all}");
}

#[test]
fn regress_apply_reads_a_pipe_as_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let result = folder.path().join("result");
    succeed(&["calibrate", example, "-o", text(&result)]);
    let calibration = result.join("calibration.json");
    let raw = Path::new(example).join("recording.csv");
    let from_file = shown(&proofmass(&[
        "apply",
        text(&calibration),
        text(&raw),
        "-o",
        "-",
    ]));
    let from_pipe = shown(&fed(
        &fs::read(&raw).unwrap(),
        &["apply", text(&calibration), "-", "-o", "-"],
    ));
    assert_eq!(from_file, from_pipe);
    // `apply … -o - | head -1`: whoever has seen enough is told nothing.
    let mut child = Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(["apply", text(&calibration), text(&raw), "-o", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 16];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    assert!(from_file.as_bytes().starts_with(&first));
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(!stderr(&output).contains("error"), "{}", stderr(&output));
}

/// Stamps of a true rate, rounded to so many decimals of a second.
fn stamped(rate: f64, decimals: usize, rows: u32) -> String {
    let mut text = "time_s,acc\n".to_owned();
    for i in 0..rows {
        let _ = writeln!(text, "{:.decimals$},{}", f64::from(i) / rate, (i * 31) % 17);
    }
    text
}

#[test]
fn regress_rates_behind_rounded_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.csv");
    for (rate, decimals) in [(300.0, 3), (512.0, 3), (400.0, 3), (800.0, 3), (3000.0, 4)] {
        fs::write(&file, stamped(rate, decimals, 60_000)).unwrap();
        let output = proofmass(&["inspect", text(&file), "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let all: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = all["time"]["rate_hz"].as_f64().unwrap();
        assert!((found / rate - 1.0).abs() < 1e-6, "{rate} Hz: {found}");
        assert_eq!(all["time"]["gap_count"], 0, "{rate} Hz: {}", all["time"]);
    }
    for rate in [10_000_u64, 50_000] {
        let mut rows = "time_ns,acc\n".to_owned();
        for i in 0..60_000 {
            let stamp = 1_753_000_000_123_456_789 + i * 1_000_000_000 / rate;
            let _ = writeln!(rows, "{stamp},{}", (i * 31) % 17);
        }
        fs::write(&file, rows).unwrap();
        let output = proofmass(&["inspect", text(&file), "--json"]);
        let all: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = all["time"]["rate_hz"].as_f64().unwrap();
        assert!(
            (found / rate as f64 - 1.0).abs() < 1e-6,
            "{rate} Hz: {found}"
        );
    }
}

/// Nobody knows how long a pipe is: what goes on beyond 48 MiB is not held.
#[test]
fn regress_a_long_pipe_is_not_held_in_memory() {
    let mut rows = String::from("acc_x_m/s2\n");
    let mut state = 1_u64;
    while rows.len() < 49 << 20 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let _ = writeln!(
            rows,
            "{}.{:09}",
            (state >> 60) % 3,
            (state >> 30) % 1_000_000_000
        );
    }
    let arguments = ["noise", "-", "--rate", "100", "--json"];
    let output = fed(rows.as_bytes(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("read as a stream"),
        "{}",
        stderr(&output)
    );
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let digest = |bytes: &[u8]| {
        let all = fed(bytes, &["inspect", "-", "--json"]);
        serde_json::from_slice::<serde_json::Value>(&all.stdout).unwrap()["sha256"].clone()
    };
    assert_eq!(result["inputs"][0]["sha256"], digest(rows.as_bytes()));
}

#[test]
fn law_a_streamed_validation_of_a_short_recording_is_the_plain_one() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let campaign = |seed: &str| {
        let place = folder.join(seed);
        succeed(&[
            "simulate",
            "multi-position",
            "--seed",
            seed,
            "-o",
            text(&place),
        ]);
        place
    };
    let (first, second) = (campaign("1"), campaign("2"));
    let result = folder.join("result");
    succeed(&["calibrate", text(&first), "-o", text(&result)]);
    let calibration = result.join("calibration.json");
    let recording = second.join("recording.csv");
    let validated = |name: &str, more: &[&str]| {
        let place = folder.join(name);
        let mut all = vec!["validate", text(&calibration), text(&recording)];
        all.extend(["-o", text(&place)]);
        all.extend(more);
        succeed(&all);
        json(&place.join("result.json"))["extra"]["validation"].clone()
    };
    let plain = validated("plain", &[]);
    assert!(plain["attitudes"].as_array().is_some_and(|a| a.len() > 10));
    assert_eq!(plain, validated("streamed", &["--stream"]));
}
