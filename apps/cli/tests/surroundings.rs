//! Humidity and supply voltage from the chamber to the compensated recording and to the chip: measured, applied, exported.

use crate::support::axis::column;
use crate::support::*;
use std::path::{Path, PathBuf};

const G: f64 = 9.80665;

/// o = b + β (T − 25 °C) + ε (H − 50 %) + ς (U − 3.3 V) + k a, in volts.
fn output(a: f64, [t, humidity, supply]: [f64; 3]) -> f64 {
    0.004 + 2e-4 * (t - 25.0) + 4e-5 * (humidity - 50.0) + 0.012 * (supply - 3.3) + 0.0131 * a
}

/// Linearity at the reference of everything, then a day in the chamber that completes it.
fn calibration(folder: &Path, seed: u64) -> PathBuf {
    let mut noise = Chance(seed);
    let (levels, line) = (folder.join("levels.csv"), folder.join("line"));
    table(
        &levels,
        "a_m/s2,out_V",
        (0..40).map(|i| {
            let a = -60.0 + 3.0 * f64::from(i);
            vec![a, output(a, [25.0, 50.0, 3.3]) + 2e-5 * noise.normal()]
        }),
    );
    let mut words = vec!["test", "linearity", text(&levels), "--acceleration", "a"];
    words.extend(["--output-column", "out", "--order", "1", "-o", text(&line)]);
    succeed(&words);
    let (day, out) = (folder.join("day.csv"), folder.join("chamber"));
    let n = 3600;
    table(
        &day,
        "acc_V,temp_degC,humidity_%,supply_V",
        (0..n).map(|i| {
            let at = f64::from(i) / f64::from(n);
            let t = 25.0 + 30.0 * (std::f64::consts::TAU * 2.0 * at).sin();
            let humidity = if at < 0.5 { 30.0 } else { 70.0 } + 5.0 * (40.0 * at).cos();
            let supply = 3.3 + 0.2 * (std::f64::consts::TAU * 3.3 * at).cos();
            let o = output(G, [t, humidity, supply]) + 4e-5 * noise.normal();
            vec![o, t, humidity, supply]
        }),
    );
    let from = line.join("calibration.json");
    let mut words = vec!["test", "temperature", text(&day), "--columns", "acc_V"];
    words.extend(["--temperature", "temp_degC", "--order", "1"]);
    words.extend(["--rate", "1", "--reference", "25"]);
    words.extend(["--environment", "humidity_%=50", "--environment"]);
    words.extend(["supply_V=3.3", "--calibration", text(&from), "-o"]);
    words.push(text(&out));
    succeed(&words);
    out.join("calibration.json")
}

/// Where it is used: 45 °C, 68 %, 3.44 V, −50 to 50 m/s².
const PLACE: [f64; 3] = [45.0, 68.0, 3.44];

fn recording(folder: &Path, heading: &str) -> (PathBuf, Vec<f64>) {
    let path = folder.join("used.csv");
    let truth: Vec<f64> = (0..=100).map(|i| f64::from(i) - 50.0).collect();
    let [t, humidity, supply] = PLACE;
    table(
        &path,
        heading,
        truth.iter().enumerate().map(|(i, a)| {
            let o = output(*a, PLACE);
            // Per cent as a part of one, volts as millivolts.
            vec![1e-3 * i as f64, o, t, humidity / 100.0, 1e3 * supply]
        }),
    );
    (path, truth)
}

const HEADING: &str = "t_s,acc_V,temp_degC,rh,supply_mV";

fn apply(folder: &Path, calibration: &Path, recording: &Path, more: &[&str]) -> (Vec<f64>, String) {
    let out = folder.join("compensated.csv");
    let mut words = vec!["apply", text(calibration), text(recording)];
    words.extend(["-o", text(&out), "--columns", "acc_V"]);
    words.extend(["--temperature", "temp_degC"]);
    words.extend(more);
    let said = stderr(&succeed(&words));
    (column(&out, "acc_m/s2"), said)
}

fn stated(said: &str) -> f64 {
    let behind = said.split("by the calibration: at most ").nth(1).unwrap();
    behind.split(' ').next().unwrap().parse().unwrap()
}

const COLUMNS: [&str; 4] = ["--environment", "humidity=rh:1", "--environment", "supply"];

/// From the readings to the compensated acceleration, twenty sensors: each error within what is stated, and without the two columns
/// beyond it.
#[test]
fn coverage_from_the_chamber_to_the_recording() {
    let mut held = 0;
    for seed in 0..20 {
        let folder = tempfile::tempdir().unwrap();
        let made = calibration(folder.path(), 7 + seed);
        let (used, truth) = recording(folder.path(), HEADING);
        let (found, said) = apply(folder.path(), &made, &used, &COLUMNS);
        let largest = |found: &[f64]| {
            let off = found.iter().zip(&truth).map(|(x, y)| (x - y).abs());
            off.fold(0.0, f64::max)
        };
        let expanded = stated(&said);
        // With what heating and cooling were seen to do differently, by the noise alone some hundredths.
        assert!(expanded < 0.15, "{said}");
        held += usize::from(largest(&found) <= expanded);
        let at = ["--at", "humidity=50", "--at", "supply=3.3"];
        let (without, _) = apply(folder.path(), &made, &used, &at);
        assert!(
            largest(&without) > expanded.max(0.15),
            "{}",
            largest(&without)
        );
    }
    // The interval of 95 % holds for the worst of 101 accelerations of one recording.
    assert!(held >= 17, "{held} of 20");
}

/// A column that does not change is the same as its value, and the same on the chip.
#[test]
fn law_a_value_is_a_column_that_does_not_change() {
    let folder = tempfile::tempdir().unwrap();
    let made = calibration(folder.path(), 3);
    let (used, _) = recording(folder.path(), HEADING);
    let (by_column, said) = apply(folder.path(), &made, &used, &COLUMNS);
    let at = ["--at", "humidity=68", "--at", "supply=3.44"];
    let (by_value, of_value) = apply(folder.path(), &made, &used, &at);
    for (x, y) in by_column.iter().zip(&by_value) {
        assert!((x - y).abs() < 1e-9, "{x} {y}");
    }
    assert!((stated(&said) / stated(&of_value) - 1.0).abs() < 2e-3);

    let out = folder.path().join("chip.json");
    let mut words = vec!["export", text(&made), "--json", "-o", text(&out)];
    words.extend(at);
    succeed(&words);
    let chip = json(&out);
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let (k, b) = (number(&chip["K"][0][0]), number(&chip["b"][0]));
    let beta = number(&chip["temperature"]["bias"][0][0]);
    let raw = column(&used, "acc_V");
    for (o, a) in raw.iter().zip(&by_value) {
        let by_hand = (o - b - beta * (PLACE[0] - 25.0)) / k;
        assert!(
            (by_hand - a).abs() < 1e-9 * a.abs().max(1.0),
            "{by_hand} {a}"
        );
    }
    assert!(
        chip["notes"].to_string().contains("at humidity = 68 %"),
        "{chip}"
    );
}

#[test]
fn known_words_on_what_is_missing_or_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let made = calibration(folder.path(), 5);
    let (used, _) = recording(folder.path(), HEADING);
    let out = folder.path().join("compensated.csv");
    let refused = |more: &[&str], words: &[&str]| {
        let mut all = vec!["apply", text(&made), text(&used), "-o", text(&out)];
        all.extend(["--columns", "acc_V", "--temperature", "temp_degC"]);
        all.extend(more);
        let said = refuse(&all);
        for word in words {
            assert!(said.contains(word), "{more:?}: {said}");
        }
        assert!(!out.exists());
    };
    refused(&[], &["humidity and supply", "--at humidity=VALUE"]);
    let one = ["--environment", "humidity=rh:%"];
    refused(&one, &["follows supply, and no column"]);
    refused(
        &["--environment", "rh"],
        &["does not follow rh", "humidity=COLUMN"],
    );
    refused(
        &["--environment", "humidity=rh"],
        &["unit of humidity", "=rh:%"],
    );
    refused(&["--environment", "humidity=rh:V"], &["in V", "in %"]);
    refused(&["--at", "humidity=95"], &["beyond what was measured"]);
    refused(&["--at", "pressure=1013"], &["does not follow pressure"]);
    refused(&["--at", "humidity=50", "--at", "humidity=51"], &["twice"]);
    refused(
        &[
            "--at",
            "supply=3.4",
            "--environment",
            "supply=supply_mV",
            "--environment",
            "humidity=rh:1",
        ],
        &["--at and read with --environment"],
    );
    let said = refuse(&["export", text(&made), "--c"]);
    assert!(said.contains("--at humidity=VALUE, in %"), "{said}");
    // Columns beyond the range are told, and refused where that is asked for.
    let hot = recording(folder.path(), "t_s,acc_V,temp_degC,rh,supply_V").0;
    let (_, said) = apply(folder.path(), &made, &hot, &COLUMNS);
    assert!(said.contains("supply from 3440.0 to 3440.0 V"), "{said}");
    assert!(
        said.contains(
            "humidity by column 4 rh in 1 as stated; supply by column 5 in V by the heading"
        ),
        "{said}"
    );
    let mut strict = vec!["--within-range"];
    strict.extend(COLUMNS);
    std::fs::remove_file(&out).unwrap();
    refused(&strict, &["supply is beyond the range", "used.csv:2"]);
}

/// What does not ask for the columns says at which values it is.
#[test]
fn known_finding_where_the_surroundings_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let made = calibration(folder.path(), 9);
    let rests = folder.path().join("rests.csv");
    let mut noise = Chance(4);
    table(
        &rests,
        "t_s,acc_V",
        (0..1200).map(|i| {
            let o = output(G, [25.0, 50.0, 3.3]) + 2e-5 * noise.normal();
            vec![0.01 * f64::from(i), o]
        }),
    );
    let out = folder.path().join("validation");
    let mut words = vec!["validate", text(&made), text(&rests), "--columns", "acc_V"];
    words.extend(["--gravity", "9.80665", "--gravity-uncertainty", "1e-5"]);
    words.extend(["-o", text(&out)]);
    proofmass(&words);
    let result = json(&out.join("result.json"));
    let found = codes(&result);
    let of = |code: &str| found.iter().filter(|c| *c == code).count();
    assert_eq!(of("environment-not-followed"), 2, "{result}");
    assert!(
        result["findings"].to_string().contains("50.0000 %"),
        "{result}"
    );
}
