//! `velocity drift` from a noise result and a calibration in place of typed numbers.

use crate::support::axis::column;
use crate::support::*;
use std::path::{Path, PathBuf};

/// A rest of white noise and a random walk, and what `noise` finds of it.
fn noise(folder: &Path, axes: &str) -> PathBuf {
    let (place, out) = (folder.join("rest"), folder.join("noise"));
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(&place),
        "--axes",
        axes,
        "--duration",
        "2000",
        "--rate",
        "20",
        "--white",
        "1e-3",
        "--random-walk",
        "2e-4",
        "--seed",
        "4",
    ]);
    let recording = place.join("recording.csv");
    succeed(&["noise", text(&recording), "-o", text(&out)]);
    out.join("result.json")
}

/// Coefficients of the first channel of a noise result: most likely values of N, B, K.
fn model(result: &Path) -> [f64; 3] {
    let fit = &json(result)["extra"]["noise"]["channels"][0]["whittle"]["model"];
    ["white", "flicker", "random_walk"].map(|k| fit[k].as_f64().unwrap())
}

fn drift(arguments: &[&str], out: &Path) -> serde_json::Value {
    let mut all = vec!["velocity", "drift", "-o", text(out)];
    all.extend(arguments);
    succeed(&all);
    json(&out.join("result.json"))
}

/// What the results say is what is computed: N √t, K √(t³/3), and of the calibration u(b) t with u(k) Δv and their covariance.
#[test]
fn known_drift_from_noise_and_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let noise = noise(folder.path(), "1");
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let three = folder.path().join("three");
    succeed(&["calibrate", example, "-o", text(&three)]);
    let calibration = three.join("calibration.json");
    let out = folder.path().join("drift");
    let arguments = [
        "--noise-result",
        text(&noise),
        "--calibration",
        text(&calibration),
        "--axis",
        "x",
        "--speed",
        "5",
        "--times",
        "1,10,100",
        "--rest",
        "20",
    ];
    let result = drift(&arguments, &out);
    let [n, b, k] = model(&noise);
    let file = json(&calibration);
    let of = |name: &str| quantity(&json(&three.join("result.json")), name);
    let scale = file["K"][0][0].as_f64().unwrap();
    let (u_b, u_k) = (of("bias.x").1 / scale, of("scale.x").1 / scale);
    let table = out.join("drift.csv");
    let columns = |name: &str| column(&table, name);
    for (row, t) in [1.0f64, 10.0, 100.0].into_iter().enumerate() {
        let flicker = (4.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt() * b * t;
        for (name, known) in [
            ("u_noise_m/s", n * t.sqrt()),
            ("u_walk_m/s", k * (t.powi(3) / 3.0).sqrt()),
            ("u_flicker_m/s", flicker),
            ("u_offset_m/s", u_b * t),
            ("u_gain_m/s", u_k * 5.0),
        ] {
            let value = columns(name)[row];
            assert!(
                (value - known).abs() <= 1e-9 * known.abs(),
                "{name} after {t}: {value} {known}"
            );
        }
        // The covariance of bias and scale lies between −1 and 1 of the product.
        let independent: f64 = [n * t.sqrt(), k * (t.powi(3) / 3.0).sqrt(), flicker]
            .iter()
            .map(|v| v * v)
            .sum();
        let (least, most) = ((u_b * t - u_k * 5.0).powi(2), (u_b * t + u_k * 5.0).powi(2));
        let whole = columns("standard_uncertainty_m/s")[row].powi(2);
        assert!(whole >= independent + least - 1e-15 && whole <= independent + most + 1e-15);
        // With the rest the offset goes, and its mean errs by the white noise and the walk of 20 s.
        let aided = columns("u_drift_aided_m/s")[row].powi(2);
        let known = n * n * (t + t * t / 20.0)
            + k * k * (t.powi(3) + 20.0 * t * t) / 3.0
            + (u_k * 5.0).powi(2);
        assert!(aided >= known * (1.0 - 1e-9), "{aided} {known}");
        assert!(b > 0.0 || (aided / known - 1.0).abs() < 1e-9);
        let high = columns("standard_uncertainty_upper_m/s")[row];
        assert!(high >= whole.sqrt() * (1.0 - 1e-12));
    }
    // The true noise gives a drift that lies within what the intervals allow.
    let truth = (1e-6f64 * 100.0 + 4e-8 * 1e6 / 3.0).sqrt();
    let without = (columns("standard_uncertainty_upper_m/s")[2].powi(2)
        - (u_b * 100.0 - u_k * 5.0).powi(2))
    .sqrt();
    assert!(truth < without, "{truth} {without}");
    // What was taken from where, in the result and on the page.
    let taken = result["extra"]["taken"].as_array().unwrap();
    assert!(taken.len() >= 6, "{taken:?}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for words in [
        "white noise N",
        "bias instability B",
        "random walk K",
        "u of bias.x",
        "calibration.json",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let inputs = result["inputs"].as_array().map_or(0, Vec::len)
        + result["provenance"]["inputs"]
            .as_array()
            .map_or(0, Vec::len);
    assert!(inputs >= 2, "{}", result["inputs"]);
    // The place: u(b) t²/2 and so on, never below the velocity's share.
    assert!(quantity(&result, "place.100s").1 > quantity(&result, "drift.100s").1);
    assert!(quantity(&result, "drift_aided.100s").1 > 0.0);
}

/// Typed numbers that are those of the result give the same drift.
#[test]
fn law_a_noise_result_is_its_typed_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let noise = noise(folder.path(), "1");
    let [n, b, k] = model(&noise);
    let taken = drift(
        &["--noise-result", text(&noise), "--times", "50"],
        &folder.path().join("a"),
    );
    // Two-sided N is the one-sided density n/√2.
    let (density, walk) = (format!("{}", n * std::f64::consts::SQRT_2), format!("{k}"));
    let typed = drift(
        &[
            "--noise-density",
            &density,
            "--offset-walk",
            &walk,
            "--times",
            "50",
        ],
        &folder.path().join("b"),
    );
    let (a, t) = (
        quantity(&taken, "drift.50s").1,
        quantity(&typed, "drift.50s").1,
    );
    let flicker = (4.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt() * b * 50.0;
    assert!((a / t.hypot(flicker) - 1.0).abs() < 1e-9, "{a} {t}");
}

#[test]
fn refuses_results_that_say_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let three = noise(folder.path(), "3");
    let out = folder.path().join("out");
    for (arguments, why) in [
        (
            &["--noise-result", text(&three)][..],
            "which channel of the noise result",
        ),
        (
            &["--noise-result", text(&three), "--noise-channel", "w"],
            "no channel \"w\"",
        ),
        (&["--calibration", text(&three)], "without a calibration"),
        (&["--noise-result", "/nowhere.json"], "/nowhere.json"),
        (&["--rest", "5"], "no source"),
    ] {
        let mut all = vec!["velocity", "drift", "-o", text(&out)];
        all.extend(arguments);
        let said = refuse(&all);
        assert!(said.contains(why), "{why}: {said}");
        assert!(!out.exists());
    }
    let both = proofmass(&[
        "velocity",
        "drift",
        "--noise-result",
        text(&three),
        "--offset-walk",
        "1",
    ]);
    assert_eq!(both.status.code(), Some(2), "{}", stderr(&both));
    succeed(&[
        "velocity",
        "drift",
        "--noise-result",
        text(&three),
        "--axis",
        "y",
    ]);
}
