//! `proofmass test tilt | sensitivity | zero-g | orthogonality | linearity | centrifuge | stability` on tables.

use crate::support::*;

/// A small reproducible disturbance.
fn noise(i: usize) -> f64 {
    (i * 7919 % 1009) as f64 / 1009.0 - 0.5
}

#[test]
fn known_devices_come_out_of_their_tables_and_render_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // 1 V per g, 10 mV of bias, half a degree beside the zero of the table.
    table(
        &at("tilt.csv"),
        "angle_deg,out_V",
        (0..24).map(|i| {
            let t = f64::from(15 * i as u32);
            vec![t, 0.01 + (t + 0.5).to_radians().cos() + 1e-4 * noise(i)]
        }),
    );
    table(
        &at("ends.csv"),
        "position,out_V",
        (0..6).map(|i| {
            let p = if i % 2 == 0 { 1.0 } else { -1.0 };
            vec![p, 0.01 + p + 1e-5 * noise(i)]
        }),
    );
    table(
        &at("levels.csv"),
        "a_g,out_V,T_degC",
        (0..18).map(|i| {
            let a = -1.0 + 0.25 * (i % 9) as f64;
            vec![
                a,
                0.01 + a + 2e-3 * a * a + 1e-5 * noise(i),
                20.0 + i as f64,
            ]
        }),
    );
    table(
        &at("arm.csv"),
        "speed_rpm,out_V",
        (0..20).map(|i| {
            let rpm = 100.0 + 45.0 * i as f64;
            let a = 0.5 * (rpm * std::f64::consts::TAU / 60.0).powi(2);
            vec![rpm, 0.01 + a / 9.80665 * 0.007 + 1e-5 * noise(i)]
        }),
    );
    table(
        &at("rest.csv"),
        "x_g,y_g,z_g",
        (0..500).map(|i| {
            vec![
                2e-3 + 1e-3 * noise(i),
                -1e-3 + 1e-3 * noise(i + 3),
                1.0 + 1e-3 * noise(i + 7),
            ]
        }),
    );
    type Case<'a> = (&'a str, &'a str, &'a [&'a str], &'a str, f64, f64);
    let cases: [Case; 5] = [
        (
            "tilt",
            "tilt.csv",
            &["--angle", "angle", "--output-column", "out"],
            "misalignment",
            0.5f64.to_radians(),
            1e-4,
        ),
        (
            "sensitivity",
            "ends.csv",
            &["--position", "position", "--output-column", "out"],
            "bias",
            0.01,
            1e-5,
        ),
        (
            "linearity",
            "levels.csv",
            &[
                "--acceleration",
                "a",
                "--output-column",
                "out",
                "--temperature",
                "T",
            ],
            "curvature.2",
            2e-3 / 9.80665,
            1e-5,
        ),
        (
            "centrifuge",
            "arm.csv",
            &[
                "--speed",
                "speed",
                "--output-column",
                "out",
                "--radius",
                "0.5",
            ],
            "sensitivity",
            0.007 / 9.80665,
            1e-6,
        ),
        (
            "zero-g",
            "rest.csv",
            &["--columns", "x,y,z", "--rate", "100", "--levelling", "0.01"],
            "bias.x",
            2e-3 * 9.80665,
            3e-4,
        ),
    ];
    for (test, file, more, name, truth, tolerance) in cases {
        let out = at(test);
        let input = at(file);
        let mut words = vec!["test", test, text(&input), "-o", text(&out)];
        words.extend(more);
        succeed(&words);
        let result = json(&out.join("result.json"));
        assert_eq!(result["model"], test);
        let (value, _, expanded) = quantity(&result, name);
        assert!(
            (value - truth).abs() < tolerance.max(expanded),
            "{test} {name}: {value} {truth}"
        );
        let by = |result: &serde_json::Value| {
            result["inputs"][0]["reading"]["gravity"]["by"]
                .as_str()
                .map(str::to_owned)
        };
        if test == "sensitivity" {
            let page = std::fs::read_to_string(out.join("report.html")).unwrap();
            assert!(
                page.contains("The sensitivity is "),
                "the verdict of another quantity"
            );
            assert!(!page.contains("Bias is "));
        }
        if ["tilt", "sensitivity", "zero-g"].contains(&test) {
            assert_eq!(by(&result).as_deref(), Some("standard gravity"));
            // The same number, stated.
            let stated = [
                "--gravity",
                "9.80665",
                "--gravity-uncertainty",
                "1e-4",
                "--json",
            ];
            let mut words = vec!["test", test, text(&input)];
            words.extend(more.iter().chain(&stated));
            let said = serde_json::from_slice(&succeed(&words).stdout).unwrap();
            assert_eq!(by(&said).as_deref(), Some("as stated"));
        }
        let again = at(&format!("{test}-again"));
        succeed(&["render", text(&out.join("result.json")), "-o", text(&again)]);
        for name in ["report.html", "readings.csv"] {
            let (a, b) = (
                std::fs::read(out.join(name)),
                std::fs::read(again.join(name)),
            );
            assert_eq!(a.unwrap(), b.unwrap(), "{test} {name}");
        }
    }
    let said = refuse(&[
        "test",
        "sensitivity",
        text(&at("tilt.csv")),
        "--position",
        "angle",
        "--output-column",
        "out",
    ]);
    assert!(said.contains("is in °"), "{said}");
}

/// Three calibrations of one unit over half a year, from their own results.
#[test]
fn known_drift_between_calibrations() {
    let folder = tempfile::tempdir().unwrap();
    let mut places = Vec::new();
    for (i, date) in ["2026-01-01", "2026-04-01", "2026-07-01", "2026-10-01"]
        .iter()
        .enumerate()
    {
        let bias = 0.05 + 1e-3 * 3.0 * i as f64;
        let file = format!(
            r#"{{"schema": {{"name": "proofmass.result", "version": 1}}, "software": {{"name": "proofmass", "version": "0.1.0"}},
            "kind": "multi-position", "device": {{}}, "inputs": [], "findings": [], "quantities": [],
            "estimate": {{"components": [{{"name": "bias.x", "unit": "m/s²", "value": {bias}}}], "covariance": [[1e-8]],
            "influences": [{{"key": "noise", "description": "noise", "evaluation": "A", "distribution": "normal", "dof": 40.0,
            "effect": {{"form": "joint", "covariance": [[1e-8]]}}}}]}}, "extra": {{"date": "{date}"}}}}"#
        );
        let path = folder.path().join(format!("{i}.json"));
        std::fs::write(&path, file).unwrap();
        places.push(path);
    }
    let out = folder.path().join("stability");
    let mut words = vec!["test", "stability"];
    words.extend(places.iter().map(|p| text(p)));
    words.extend(["--tolerance", "bias.x=0.01", "-o", text(&out)]);
    succeed(&words);
    let result = json(&out.join("result.json"));
    let (drift, u, _) = quantity(&result, "drift.bias.x");
    assert!((drift - 1e-3).abs() < 3.0 * u && u < 1e-4, "{drift} {u}");
    // 10 mm/s² at 1 mm/s² per month, less what is uncertain: nine months or so.
    let due = result["extra"]["due_in_days"].as_f64().unwrap();
    assert!((240.0..310.0).contains(&due), "{due}");
    assert!(out.join("control_chart.csv").is_file());
    let said = refuse(&["test", "stability", text(&places[0]), text(&places[1])]);
    assert!(said.contains("calibrations"), "{said}");
    assert!(
        said.contains("hint: give the result.json of calibrations of three days"),
        "{said}"
    );
    let same = text(&places[0]);
    let said = refuse(&["test", "stability", same, same, same]);
    assert!(said.contains("all calibrations are of one day"), "{said}");
    // A serial number that another result does not have is no drift of one device.
    let codes = |result: &serde_json::Value| -> Vec<String> {
        let all = result["findings"].as_array().unwrap().iter();
        all.map(|f| f["code"].as_str().unwrap().to_owned())
            .collect()
    };
    assert!(!codes(&result).contains(&"devices-differ".to_owned()));
    for (i, place) in places.iter().enumerate() {
        let serial = format!(
            r#""device": {{"serial": "{}"}}"#,
            if i == 2 { "8" } else { "7" }
        );
        let of_device = std::fs::read_to_string(place).unwrap();
        std::fs::write(place, of_device.replace(r#""device": {}"#, &serial)).unwrap();
    }
    let other = folder.path().join("other");
    let mut words = vec!["test", "stability"];
    words.extend(places.iter().map(|p| text(p)));
    words.extend(["-o", text(&other)]);
    succeed(&words);
    assert!(codes(&json(&other.join("result.json"))).contains(&"devices-differ".to_owned()));
}

/// The example's own calibration: its axes are square within a degree, and the cost is stated.
#[test]
fn law_orthogonality_of_a_calibration_is_stated() {
    const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let folder = tempfile::tempdir().unwrap();
    let calibrated = folder.path().join("calibrated");
    succeed(&["calibrate", EXAMPLE, "-o", text(&calibrated)]);
    let out = folder.path().join("square");
    succeed(&[
        "test",
        "orthogonality",
        text(&calibrated.join("calibration.json")),
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    let (angle, u, _) = quantity(&result, "orthogonality.xy");
    let (error, _, _) = quantity(&result, "cross_axis.xy");
    assert!(u > 0.0 && angle.abs() < 1f64.to_radians());
    assert!((error - 9.80665 * angle.sin()).abs() < 1e-12);
}

#[test]
fn known_gravity_of_a_place_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let rest = folder.path().join("rest.csv");
    let mut chance = Chance(5);
    let mut rows = "t_s,ax_m/s2,ay_m/s2,az_m/s2\n".to_owned();
    for i in 0..2000 {
        let [x, y, z] = [0.0, 0.0, 9.806].map(|mean| mean + 1e-3 * chance.normal());
        rows.push_str(&format!("{:.2},{x},{y},{z}\n", f64::from(i) / 100.0));
    }
    std::fs::write(&rest, rows).unwrap();
    let call = &["test", "zero-g", text(&rest)];
    let place = &["--latitude", "45.07", "--height", "239"];
    let output = succeed(&[call, &place[..], &["--json"]].concat());
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let gravity = &result["inputs"][0]["reading"]["gravity"];
    assert_eq!(gravity["by"], "by latitude 45.07° and height 239 m");
    assert_eq!(gravity["normal_at"][0], 45.07);
    assert!(gravity["standard_uncertainty"].as_f64().unwrap() < 0.001);
    let both = proofmass(&[call, &place[..], &["--gravity", "9.8"]].concat());
    assert!(!both.status.success());
}
