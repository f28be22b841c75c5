//! `proofmass simulate noise`: what is put in comes out of `proofmass noise`.

use crate::support::*;

/// Three axes with all that a recording may suffer from: every interval holds the truth, and nothing is thrown away.
#[test]
fn known_simulated_noise_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("rest");
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(&place),
        "--axes",
        "2",
        "--duration",
        "1000",
        "--rate",
        "20",
        "--white",
        "1e-3",
        "--random-walk",
        "2e-4",
        "--sinusoid",
        "2e-3,1.5",
        "--jitter",
        "0.1",
        "--gap",
        "300,310",
        "--seed",
        "4",
    ]);
    assert!(holds_only(
        &place,
        &["manifest.json", "recording.csv", "truth.json"]
    ));
    let truth = json(&place.join("truth.json"));
    assert_eq!(
        (truth["samples"].as_u64(), truth["rows"].as_u64()),
        (Some(20_000), Some(19_800))
    );
    let out = folder.path().join("out");
    succeed(&[
        "noise",
        text(&place.join("recording.csv")),
        "--sinusoids",
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    let channels = result["extra"]["noise"]["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 2);
    for channel in channels {
        assert_eq!(channel["samples"], 19_800);
    }
    let known = truth["quantities"].as_object().unwrap();
    assert_eq!(known.len(), 6);
    for (name, q) in known {
        let stated = result["quantities"].as_array().unwrap();
        let found = stated
            .iter()
            .find(|s| s["name"] == name.as_str())
            .unwrap_or_else(|| panic!("no {name}"));
        assert_eq!(found["unit"], q["unit"], "{name}");
        let (value, _, expanded) = quantity(&result, name);
        let true_value = q["value"].as_f64().unwrap();
        // U is half the interval, which lies a little skew.
        assert!(
            (value - true_value).abs() < 1.3 * expanded,
            "{name}: {value} ± {expanded}, {true_value}"
        );
        assert!(expanded < 0.6 * true_value, "{name}: {expanded}");
    }
}

/// Three axes over time, by themselves, as states of a filter, and by THEOH.
#[test]
fn known_further_curves_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("rest");
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(&place),
        "--axes",
        "3",
        "--duration",
        "60",
        "--rate",
        "20",
        "--flicker",
        "1e-3",
    ]);
    let out = folder.path().join("out");
    let recording = place.join("recording.csv");
    succeed(&[
        "noise",
        text(&recording),
        "--windows",
        "4",
        "--separate",
        "--statistic",
        "oadev,theoh",
        "-o",
        text(&out),
    ]);
    let windows = rows(&out.join("dynamic.csv"));
    let ends: Vec<f64> = windows.iter().map(|r| number(r, "to_s")).collect();
    assert!(ends.contains(&15.0) && ends.contains(&60.0));
    let separated = rows(&out.join("separated.csv"));
    let first = separated
        .iter()
        .find(|r| field(r, "sensor") == "acc_z")
        .unwrap();
    // White noise of 2.5e-3 at 20 Hz: 1.25e-4 at one sample, and the flicker beside it.
    let (variance, u) = (number(first, "variance"), number(first, "u_variance"));
    assert!(
        (variance - 1.26e-4).abs() < 5.0 * u && u < 2e-5,
        "{variance} ± {u}"
    );
    let deviations = rows(&out.join("deviation.csv"));
    let longest = deviations
        .iter()
        .filter(|r| field(r, "statistic") == "THEOH")
        .map(|r| number(r, "tau_s"))
        .fold(0.0, f64::max);
    assert!(longest > 24.0, "{longest}");
    let states = json(&out.join("state_space.json"));
    assert!(
        states["acc_x"]["components"]
            .as_array()
            .is_some_and(|c| !c.is_empty())
    );
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<figure") && page.contains("Dynamic Allan deviation"));
    let message = refuse(&[
        "noise",
        text(&recording),
        "--columns",
        "acc_x_m/s2",
        "--separate",
    ]);
    assert!(message.contains("channels to be separated"), "{message}");
    assert!(message.contains("three channels side by side"), "{message}");
}

/// Two channels are clocks only as phases; units that differ and columns that are the same have no difference that says anything.
#[test]
fn refuses_channels_that_cannot_be_separated() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("rest.csv");
    let mut content = "time_s,acc_x_m/s2,acc_y_m/s2,acc_same_m/s2,gyro_x_rad/s\n".to_owned();
    let mut chance = Chance(3);
    for k in 0..400 {
        let (x, y, w) = (chance.uniform(), chance.uniform(), chance.uniform());
        let t = 0.02 * f64::from(k);
        content.push_str(&format!("{t:.2},{x:.6},{y:.6},{x:.6},{w:.6}\n"));
    }
    std::fs::write(&recording, content).unwrap();
    for (columns, said) in [
        ("acc_x_m/s2,acc_y_m/s2", "two channels"),
        ("acc_x_m/s2,acc_y_m/s2", "three channels side by side"),
        ("acc_x_m/s2,acc_y_m/s2,gyro_x_rad/s", "different units"),
        (
            "acc_x_m/s2,acc_y_m/s2,acc_same_m/s2",
            "their difference never changes",
        ),
    ] {
        let message = refuse(&[
            "noise",
            text(&recording),
            "--separate",
            "--columns",
            columns,
        ]);
        assert!(message.contains(said), "{columns}: {message}");
    }
}

/// A filter before the converter is seen, and N behind it is right; outliers are seen as heavy tails.
#[test]
fn known_simulated_filters_and_outliers_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let simulated = |name: &str, more: &[&str]| {
        let place = folder.path().join(name);
        let mut arguments = vec![
            "simulate",
            "noise",
            "-o",
            text(&place),
            "--rate",
            "50",
            "--random-walk",
            "0",
        ];
        arguments.extend(more);
        succeed(&arguments);
        let out = folder.path().join(format!("{name}-result"));
        succeed(&[
            "noise",
            text(&place.join("recording.csv")),
            "-o",
            text(&out),
        ]);
        json(&out.join("result.json"))
    };
    let filtered = simulated("filter", &["--corner", "5", "--sensor", "gyroscope"]);
    assert!(codes(&filtered).iter().any(|c| c == "band-limited"));
    let (n, _, expanded) = quantity(&filtered, "gyro_x.N");
    assert!(
        (n - 2.5e-3).abs() < 1.3 * expanded && expanded < 2e-4,
        "{n} ± {expanded}"
    );
    let spiked = simulated("outliers", &["--outliers", "0.001"]);
    assert!(codes(&spiked).iter().any(|c| c == "heavy-tails"));
}

/// The same seed gives the same bytes, another seed others.
#[test]
fn law_a_seed_is_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let simulated = |name: &str, seed: &str| {
        let place = folder.path().join(name);
        succeed(&[
            "simulate",
            "noise",
            "-o",
            text(&place),
            "--duration",
            "10",
            "--flicker",
            "1e-3",
            "--step",
            "1e-4",
            "--seed",
            seed,
        ]);
        std::fs::read(place.join("recording.csv")).unwrap()
    };
    let first = simulated("a", "7");
    assert_eq!(first, simulated("b", "7"));
    assert_ne!(first, simulated("c", "8"));
    // Every value is a multiple of the step.
    let second = String::from_utf8(first)
        .unwrap()
        .lines()
        .nth(1)
        .unwrap()
        .to_owned();
    let value = second.split(',').nth(1).unwrap();
    assert_eq!(value.split('.').nth(1).unwrap().len(), 4, "{second}");
}

#[test]
fn refuses_noise_without_meaning() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("none");
    for (option, value, said) in [
        ("--white=-1", "", "white"),
        ("--corner", "80", "corner frequency"),
        ("--duration", "1e12", "a hundred million"),
        ("--outliers", "2", "share of outliers"),
    ] {
        let mut arguments = vec!["simulate", "noise", "-o", text(&place), option];
        arguments.extend((!value.is_empty()).then_some(value));
        let message = refuse(&arguments);
        assert!(message.contains(said), "{option} {value}: {message}");
        assert!(!place.exists());
    }
}
