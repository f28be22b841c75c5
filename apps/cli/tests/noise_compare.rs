//! `proofmass noise compare`: units beside each other and against the limits of a data sheet.

use crate::support::*;
use std::path::{Path, PathBuf};

/// The noise result of a simulated accelerometer.
fn unit(folder: &Path, name: &str, white: &str, seed: &str) -> PathBuf {
    unit_of("accelerometer", folder, name, white, seed)
}

/// The noise result of a simulated unit.
fn unit_of(sensor: &str, folder: &Path, name: &str, white: &str, seed: &str) -> PathBuf {
    let place = folder.join(name);
    let raw = folder.join(format!("{name}-raw"));
    white_noise(sensor, &raw, &place, white, seed);
    place
}

/// The noise result of a channel that never changes.
fn constant(folder: &Path, name: &str, value: f64) -> PathBuf {
    let recording = folder.join(format!("{name}.csv"));
    let mut content = "time_s,acc_x_m/s2\n".to_owned();
    for k in 0..100 {
        content.push_str(&format!("{:.2},{value}\n", 0.02 * f64::from(k)));
    }
    std::fs::write(&recording, content).unwrap();
    let place = folder.join(name);
    succeed(&["noise", text(&recording), "-o", text(&place)]);
    place
}

#[test]
fn known_batch_against_a_data_sheet() {
    let folder = tempfile::tempdir().unwrap();
    let units: Vec<PathBuf> = (0..5)
        .map(|k| {
            let white = if k == 4 { "1.3e-3" } else { "1e-3" };
            unit(
                folder.path(),
                &format!("unit-{k}"),
                white,
                &(k + 1).to_string(),
            )
        })
        .collect();
    let limits = folder.path().join("limits.toml");
    // N = 1e-3 is 144.2 µg/√Hz one-sided, 1.3e-3 is 187.5; the floor of a unit without flicker is a limit.
    std::fs::write(
        &limits,
        "[[limit]]\nterm = \"N\"\nmost = 160.0\nunit = \"µg/√Hz\"\n\n[[limit]]\nterm = \"B\"\nmost = 1e-6\nunit = \"ug\"\nchannels = [\"acc_x\"]\n",
    )
    .unwrap();
    let out = folder.path().join("batch");
    let mut arguments = vec!["noise", "compare"];
    arguments.extend(units.iter().map(|u| text(u)));
    arguments.extend(["--limits", text(&limits), "-o", text(&out)]);
    let said = succeed(&arguments);
    let terminal = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(
        terminal.contains("one-sided amplitude density"),
        "{terminal}"
    );
    assert!(holds_only(
        &out,
        &[
            "coefficients.csv",
            "limits.csv",
            "manifest.json",
            "quantities.csv",
            "report.html",
            "result.json"
        ]
    ));
    let result = json(&out.join("result.json"));
    let limits = rows(&out.join("limits.csv"));
    let verdicts: Vec<&str> = limits.iter().map(|row| field(row, "conformity")).collect();
    assert_eq!(verdicts[..5], ["pass", "pass", "pass", "pass", "fail"]);
    assert_eq!(verdicts[5..], ["undecided"; 5]);
    let found = codes(&result);
    for code in ["beyond-limit", "limit-undecided", "units-differ"] {
        assert!(found.iter().any(|c| c == code), "{code}: {found:?}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("limit"));
    // Four that are equal are called so, and share a value.
    let four: Vec<&str> = units[..4].iter().map(|u| text(u)).collect();
    let out = folder.path().join("four");
    let mut arguments = vec!["noise", "compare"];
    arguments.extend(&four);
    arguments.extend(["-o", text(&out)]);
    succeed(&arguments);
    let result = json(&out.join("result.json"));
    assert!(codes(&result).is_empty(), "{:?}", codes(&result));
    let (n, _, expanded) = quantity(&result, "acc_x.N");
    assert!(
        (n - 1e-3).abs() < 1.3 * expanded && expanded < 1.5e-5,
        "{n} ± {expanded}"
    );
}

#[test]
fn refuses_what_cannot_be_compared() {
    let folder = tempfile::tempdir().unwrap();
    let one = unit(folder.path(), "one", "1e-3", "1");
    let message = refuse(&["noise", "compare", text(&one)]);
    assert!(message.contains("two noise results or more"), "{message}");
    let limits = folder.path().join("limits.toml");
    for (content, said) in [
        ("", "there is no [[limit]]"),
        (
            "[[limit]]\nterm = \"X\"\nmost = 1\nunit = \"µg\"\n",
            "not one of the terms",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = -1\nunit = \"µg/√Hz\"\n",
            "not positive",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"°/√h\"\n",
            "fits no channel",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"µg/√Hz\"\nleast = 2\n",
            "least",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"furlong\"\n",
            "\"furlong\" is no unit of N",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"µg/√Hz\"\nmeaning = \"on\"\n",
            "meaning = \"on\" of the limit of N is not known",
        ),
        (
            "[[limit]]\nterm = \"B\"\nmost = 1\nunit = \"µg\"\nmeaning = \"one-sided\"\n",
            "a limit of B in µg cannot be one-sided",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"µg/√Hz\"\nchannels = [\"acc_q\"]\n",
            "\"acc_q\", which no result has",
        ),
    ] {
        std::fs::write(&limits, content).unwrap();
        let message = refuse(&["noise", "compare", text(&one), "--limits", text(&limits)]);
        assert!(message.contains(said), "{said}: {message}");
    }
    let file = one.join("result.json");
    let message = refuse(&["noise", "compare", text(&one), text(&file)]);
    assert!(message.contains("given twice"), "{message}");
    assert!(message.contains("counted twice"), "{message}");
    let still = [
        constant(folder.path(), "still-1", 1.0),
        constant(folder.path(), "still-2", 2.0),
    ];
    let message = refuse(&["noise", "compare", text(&still[0]), text(&still[1])]);
    assert!(message.contains("have no coefficients"), "{message}");
    let output = proofmass(&[
        "noise",
        "compare",
        text(&one),
        text(&still[0]),
        "--false-alarm-rate",
        "0",
    ]);
    let message = stderr(&output);
    assert!(!output.status.success());
    assert!(
        message.contains("--false-alarm-rate") && message.contains("lies between 0 and 1"),
        "{message}"
    );
    let raw = folder.path().join("one-raw/recording.csv");
    let message = refuse(&["noise", "compare", text(&one), text(&raw)]);
    assert!(message.contains("proofmass noise"), "{message}");
}

/// A gyroscope beside an accelerometer: limits of accelerations say nothing of it, and that is said.
#[test]
fn known_units_that_no_limit_covers_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let one = unit(folder.path(), "one", "1e-3", "1");
    let other = unit_of("gyroscope", folder.path(), "other", "1e-3", "2");
    let limits = folder.path().join("limits.toml");
    std::fs::write(
        &limits,
        "[[limit]]\nterm = \"N\"\nmost = 160.0\nunit = \"µg/√Hz\"\n",
    )
    .unwrap();
    let out = folder.path().join("out");
    succeed(&[
        "noise",
        "compare",
        text(&one),
        text(&other),
        "--limits",
        text(&limits),
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    let findings = result["findings"].as_array().unwrap();
    let found = findings
        .iter()
        .find(|f| f["code"] == "no-limit-covers")
        .unwrap_or_else(|| panic!("{:?}", codes(&result)));
    let said = found.to_string();
    assert!(said.contains(text(&other)), "{said}");
    assert!(!said.contains(text(&one)), "{said}");
    assert!(said.contains("1 of 2"), "{said}");
}

/// N of one sensor at three temperatures: 1 mU at 0 °C, half as much again at 50 °C, twice at 100 °C.
#[test]
fn known_noise_over_the_temperature() {
    let folder = tempfile::tempdir().unwrap();
    let units: Vec<PathBuf> = [("cold", "1e-3"), ("warm", "1.5e-3"), ("hot", "2e-3")]
        .into_iter()
        .map(|(name, white)| unit(folder.path(), name, white, "7"))
        .collect();
    let out = folder.path().join("over");
    let mut arguments = vec!["noise", "compare"];
    arguments.extend(units.iter().map(|u| text(u)));
    let mut typed = arguments.clone();
    typed.extend(["--temperatures", "0,50,100", "-o", text(&out)]);
    succeed(&typed);
    let result = json(&out.join("result.json"));
    let (slope, u, _) = quantity(&result, "acc_x.N.slope");
    assert!((slope - 1e-5).abs() < 2.0 * u && u < 1e-6, "{slope} {u}");
    let table = std::fs::read_to_string(out.join("temperature.csv")).unwrap();
    assert!(
        table.starts_with("channel,coefficient,temperature_degC,value,slope,"),
        "{table}"
    );
    for (words, said) in [
        ("0,50", "2 temperatures are stated for 3"),
        ("20,20,20", "at one temperature"),
        ("-300,0,20", "is not a number"),
    ] {
        let mut typed = arguments.clone();
        typed.extend(["--temperatures", words]);
        let refused = refuse(&typed);
        assert!(refused.contains(said), "{refused}");
    }
}
