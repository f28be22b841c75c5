//! `proofmass noise` beside a temperature, with slow sinusoids, and without outliers.

use crate::support::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const RATE: f64 = 20.0;

/// A simulated recording with a column of temperature, which the output follows with 0.01 (m/s²)/K.
fn recording(folder: &Path, heading: &str, temperature: impl Fn(f64) -> String) -> PathBuf {
    let place = folder.join("rest");
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(&place),
        "--duration",
        "1000",
        "--rate",
        "20",
        "--white",
        "2.5e-3",
        "--random-walk",
        "1e-4",
        "--seed",
        "8",
    ]);
    let plain = std::fs::read_to_string(place.join("recording.csv")).unwrap();
    let mut lines = plain.lines();
    let mut all = format!("{},{heading}\n", lines.next().unwrap());
    for line in lines {
        let (time, y) = line.split_once(',').unwrap();
        let (time, y): (f64, f64) = (time.parse().unwrap(), y.parse().unwrap());
        let y = y + 0.01 * celsius(time);
        writeln!(all, "{time},{y:.9},{}", temperature(time)).unwrap();
    }
    let path = folder.join("warm.csv");
    std::fs::write(&path, all).unwrap();
    path
}

/// Four periods of an air conditioning.
fn celsius(time: f64) -> f64 {
    (std::f64::consts::TAU * time / 250.0).sin()
}

fn analysed(arguments: &[&str], out: &Path) -> serde_json::Value {
    let all = [&["noise"], arguments, &["-o", text(out)]].concat();
    succeed(&all);
    json(&out.join("result.json"))
}

/// With the temperature its sensitivity is found and the walk is the true one; without it, the walk is many times as large.
#[test]
fn known_sensitivity_to_temperature() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path(), "T_degC", |t| {
        format!("{:.4}", 20.0 + celsius(t))
    });
    let out = folder.path().join("out");
    let result = analysed(&[text(&path), "--temperature", "T"], &out);
    let (value, u, expanded) = quantity(&result, "acc_x.K_T");
    assert!((value - 0.01).abs() < expanded && u < 1e-3, "{value} {u}");
    let walk = |result: &serde_json::Value| {
        result["extra"]["noise"]["channels"][0]["whittle"]["model"]["random_walk"]
            .as_f64()
            .unwrap()
    };
    let plain = analysed(
        &[text(&path), "--columns", "acc_x"],
        &folder.path().join("plain"),
    );
    assert!(
        walk(&result) < 3e-4 && walk(&plain) > 5e-4,
        "{} {}",
        walk(&result),
        walk(&plain)
    );
    let table = std::fs::read_to_string(out.join("coefficients.csv")).unwrap();
    assert!(table.contains("acc_x,K_T,identified,"), "{table}");
    let curves = std::fs::read_to_string(out.join("deviation.csv")).unwrap();
    assert!(curves.contains("OADEV without temperature"));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("without temperature") && page.contains("sensitivity to temperature"));
}

/// In °F, and with fields that only a slow thermometer fills, the coefficient per kelvin is the same.
#[test]
fn law_the_unit_and_rate_of_the_thermometer_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path(), "temp_degF", |t| {
        if ((t * RATE).round() as u64).is_multiple_of(10) {
            format!("{:.4}", 68.0 + 1.8 * celsius(t))
        } else {
            String::new()
        }
    });
    let result = analysed(
        &[
            text(&path),
            "--columns",
            "acc_x",
            "--temperature",
            "temp_degF",
        ],
        &folder.path().join("out"),
    );
    let (value, _, expanded) = quantity(&result, "acc_x.K_T");
    assert!((value - 0.01).abs() < 1.2 * expanded, "{value} {expanded}");
}

#[test]
fn refuses_what_is_no_temperature() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path(), "T_degC", |_| "21.5".to_owned());
    let said = refuse(&["noise", text(&path), "--temperature", "T"]);
    assert!(
        said.contains("never changes") && said.contains("leave --temperature out"),
        "{said}"
    );
    let said = refuse(&[
        "noise",
        text(&path),
        "--columns",
        "acc_x",
        "--temperature",
        "acc_x",
    ]);
    assert!(
        said.contains("by its heading: no temperature") || said.contains("cannot be a channel"),
        "{said}"
    );
    let said = refuse(&[
        "noise",
        text(&path),
        "--columns",
        "acc_x,T",
        "--temperature",
        "T",
    ]);
    assert!(said.contains("cannot be a channel as well"), "{said}");
    let said = refuse(&["noise", text(&path), "--temperature", "nothing"]);
    assert!(said.contains("nothing"), "{said}");
    let said = refuse(&["noise", text(&path), "--temperature", "T", "--stream"]);
    assert!(said.contains("stream"), "{said}");
    let varying = tempfile::tempdir().unwrap();
    let path = recording(varying.path(), "T_degC", |t| format!("{:.4}", celsius(t)));
    let said = refuse(&[
        "noise",
        text(&path),
        "--temperature",
        "T",
        "--temperature-lag",
        "-3",
    ]);
    assert!(said.contains("lag"), "{said}");
    let said = refuse(&[
        "simulate",
        "noise",
        "-o",
        text(&folder.path().join("fast")),
        "--rate",
        "10",
        "--sinusoid",
        "1e-3,7",
    ]);
    assert!(said.contains("cannot be sampled"), "{said}");
}

/// The same oscillation without a thermometer: a sinusoid of four cycles, with intervals for amplitude and frequency.
#[test]
fn known_slow_sinusoid() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path(), "T_degC", |_| "21.5".to_owned());
    let out = folder.path().join("out");
    let result = analysed(&[text(&path), "--columns", "acc_x", "--sinusoids"], &out);
    let (value, _, expanded) = quantity(&result, "acc_x.A1");
    assert!((value - 0.01).abs() < 1.2 * expanded, "{value} {expanded}");
    let parameter = &result["extra"]["noise"]["channels"][0]["whittle"]["coefficients"];
    let line = parameter
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["term"] == "sinusoid")
        .unwrap();
    let at = |k: usize| line["parameter"]["interval"][k].as_f64().unwrap();
    assert!(
        at(0) < 0.004 && 0.004 < at(1) && at(1) - at(0) < 2e-4,
        "{line}"
    );
}

/// Outliers in one sample of a thousand: the robust N stands beside the ordinary one and holds the truth.
#[test]
fn known_noise_without_outliers() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("rest");
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(&place),
        "--duration",
        "1000",
        "--rate",
        "20",
        "--white",
        "2.5e-3",
        "--random-walk",
        "1e-4",
        "--outliers",
        "0.001",
        "--seed",
        "8",
    ]);
    let path = place.join("recording.csv");
    let out = folder.path().join("out");
    let result = analysed(&[text(&path), "--robust"], &out);
    let (ordinary, ..) = quantity(&result, "acc_x.N");
    let (robust, u, expanded) = quantity(&result, "acc_x.robust.N");
    assert!(
        (robust - 2.5e-3).abs() < expanded && ordinary > robust + 2.0 * u,
        "{ordinary} {robust} {u}"
    );
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("without gross outliers"));
}
