//! `proofmass test temperature` on simulated recordings.

use crate::support::*;
use std::fmt::Write;
use std::path::Path;

/// Up and down between −10 and 60 °C: z follows with 1.2 mg/K, heating lies `gap` mg above cooling; turned half-way if asked.
fn write_recording(path: &Path, gap: f64, turned: bool) {
    let mut noise = Chance(5);
    let mut text = String::from("acc_x_mg,acc_y_mg,acc_z_mg,temp_degC\n");
    for i in 0..6000 {
        let s = f64::from(i) / 3000.0;
        let heating = s < 1.0;
        let u = if heating { s } else { 2.0 - s };
        let t = if turned {
            if heating { -10.0 } else { 60.0 }
        } else {
            -10.0 + 70.0 * u
        };
        let d = t - 25.0;
        let sign = if heating { 0.5 } else { -0.5 };
        let z = 1002.0 + 1.2 * d + sign * gap * (1.0 - (d / 35.0f64).powi(2));
        let (x, y) = (12.0 + 0.05 * d, -7.0);
        let (y, z) = if turned && !heating { (z, -y) } else { (y, z) };
        let mut n = || 2.0 * noise.normal();
        let _ = writeln!(
            text,
            "{:.3},{:.3},{:.3},{:.3}",
            x + n(),
            y + n(),
            z + n(),
            t + 0.02 * n()
        );
    }
    std::fs::write(path, text).unwrap();
}

const COLUMNS: [&str; 6] = [
    "--columns",
    "acc_x,acc_y,acc_z",
    "--temperature",
    "temp",
    "--rate",
    "10",
];

#[test]
fn known_slope_and_hysteresis_and_the_same_files_again() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("sweep.csv");
    write_recording(&recording, 6.0, false);
    let out = folder.path().join("result");
    let mut words = vec!["test", "temperature", text(&recording), "-o", text(&out)];
    words.extend(COLUMNS);
    succeed(&words);
    let result = json(&out.join("result.json"));
    let mg = 9.80665e-3;
    let (z, u, _) = quantity(&result, "slope.z");
    assert!(
        (z / mg - 1.2).abs() < 4.0 * u / mg && u / mg < 0.1,
        "{} {}",
        z / mg,
        u / mg
    );
    let gap = result["extra"]["axes"][2]["hysteresis"]["difference"]
        .as_f64()
        .unwrap()
        / mg;
    assert!((gap - 6.0).abs() < 1.0, "{gap}");
    let codes = codes(&result);
    assert!(codes.iter().any(|c| c == "hysteresis"), "{codes:?}");
    let again = folder.path().join("again");
    succeed(&["render", text(&out.join("result.json")), "-o", text(&again)]);
    for name in ["report.html", "blocks.csv"] {
        assert_eq!(
            std::fs::read(out.join(name)).unwrap(),
            std::fs::read(again.join(name)).unwrap(),
            "{name}"
        );
    }
}

#[test]
fn refuses_a_turned_sensor_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("turned.csv");
    write_recording(&recording, 0.0, true);
    let mut words = vec!["test", "temperature", text(&recording)];
    words.extend(COLUMNS);
    let said = refuse(&words);
    assert!(said.contains("turned between the temperatures"), "{said}");
    assert!(said.contains("hint"), "{said}");
}

/// Tilted by two degrees while nobody recorded: no coefficient with a confident interval, and somebody has to decide.
#[test]
fn refuses_to_be_sure_of_a_sensor_that_was_tilted_between_two_temperatures() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("tilted.csv");
    let mut noise = Chance(11);
    let mut rows = String::from("acc_x_mg,acc_y_mg,acc_z_mg,temp_degC\n");
    for i in 0..6000 {
        let (t, tilt): (f64, f64) = if i < 3000 { (-18.0, 0.0) } else { (74.0, 2.0) };
        let (y, z) = tilt.to_radians().sin_cos();
        let mut n = || 2.0 * noise.normal();
        let (x, y, z) = (12.0 + n(), 1000.0 * y - 7.0 + n(), 1000.0 * z + n());
        let _ = writeln!(rows, "{x:.3},{y:.3},{z:.3},{:.3}", t + 0.02 * n());
    }
    std::fs::write(&recording, rows).unwrap();
    let out = folder.path().join("result");
    let mut words = vec!["test", "temperature", text(&recording), "-o", text(&out)];
    words.extend(COLUMNS);
    let said = succeed(&words);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(
        said.contains("decision needed: the temperature jumps"),
        "{said}"
    );
    let result = json(&out.join("result.json"));
    let (y, u, _) = quantity(&result, "slope.y");
    // 34.9 mg over 92 K are none of the sensor's: its coefficient is zero.
    assert!((y / 9.80665e-3 - 0.379).abs() < 0.01, "{y}");
    assert!(2.0 * u > y, "{y} {u}");
    // Declared as kept, it is taken at its word.
    words.extend(["--tilt", "0.02", "--force"]);
    succeed(&words);
    let (_, u, _) = quantity(&json(&out.join("result.json")), "slope.y");
    assert!((u / 9.80665e-3 - 0.0038).abs() < 0.001, "{u}");
}

/// A file without a header: columns by their number, as in docs/temperature.md.
#[test]
fn regress_columns_by_number() {
    let folder = tempfile::tempdir().unwrap();
    let named = folder.path().join("named.csv");
    write_recording(&named, 0.0, false);
    let rows = std::fs::read_to_string(&named).unwrap();
    let recording = folder.path().join("numbers.csv");
    std::fs::write(&recording, rows.split_once('\n').unwrap().1).unwrap();
    let out = folder.path().join("result");
    let words = [
        "test",
        "temperature",
        text(&recording),
        "-o",
        text(&out),
        "--rate",
        "10",
    ];
    let numbers = ["--columns", "1,2,3", "--unit", "mg", "--temperature", "4"];
    succeed(&[&words[..], &numbers].concat());
    let (z, u, _) = quantity(&json(&out.join("result.json")), "slope.z");
    assert!((z / 9.80665e-3 - 1.2).abs() < 4.0 * u / 9.80665e-3);
}

/// Switched on with the recording: 8 mg that decay within a minute are told apart from the temperature.
#[test]
fn known_self_heating() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("warm.csv");
    write_recording(&recording, 0.0, false);
    let written = std::fs::read_to_string(&recording).unwrap();
    let mut rows = String::new();
    for (i, line) in written.lines().enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(z) = cells[2].parse::<f64>() {
            cells[2] = format!("{:.3}", z + 8.0 * (-(i as f64) / 200.0).exp());
        }
        let _ = writeln!(rows, "{}", cells.join(","));
    }
    std::fs::write(&recording, rows).unwrap();
    let out = folder.path().join("result");
    let mut words = vec!["test", "temperature", text(&recording), "-o", text(&out)];
    words.extend(COLUMNS);
    words.extend(["--warm-up", "60"]);
    let said = succeed(&[&words[..], &["--details"]].concat());
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("self-heating of z"), "{said}");
    let result = json(&out.join("result.json"));
    let found = &result["extra"]["axes"][2]["self_heating"];
    let value = |name: &str| found[name].as_f64().unwrap();
    let off = value("amplitude") / 9.80665e-3 - 8.0;
    let u = value("standard_uncertainty") / 9.80665e-3;
    assert!(off.abs() < 3.0 * u && u < 3.0, "{off} {u}");
}

/// A calibration at 25 °C and a sweep make one calibration, which is exported with its temperature.
#[test]
fn law_a_calibration_is_completed_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("sweep.csv");
    write_recording(&recording, 0.0, false);
    let base = folder.path().join("base.json");
    let file = r#"{"schema": {"name": "proofmass.calibration", "version": 1}, "kind": "triaxial",
        "software": {"name": "proofmass", "version": "0.1.0"}, "device": {"model": "unit"},
        "input_unit": "m/s²", "output_unit": "m/s²", "model": "full",
        "K": [[1.01, 0.0, 0.0], [0.0, 0.99, 0.0], [0.0, 0.0, 1.002]], "b": [0.1, -0.07, 0.02],
        "estimate": {"components": [{"name": "bias.z", "unit": "m/s²", "value": 0.02}],
            "covariance": [[1e-8]], "influences": [{"key": "noise", "description": "noise", "evaluation": "A",
            "distribution": "normal", "dof": 20.0, "effect": {"form": "joint", "covariance": [[1e-8]]}}]},
        "temperature_range_degC": [24.8, 25.2], "inputs": []}"#;
    std::fs::write(&base, file).unwrap();
    let out = folder.path().join("result");
    let mut words = vec![
        "test",
        "temperature",
        text(&recording),
        "--calibration",
        text(&base),
        "-o",
        text(&out),
    ];
    words.extend(COLUMNS);
    succeed(&words);
    let written = json(&out.join("calibration.json"));
    let block = &written["temperature"];
    assert!((block["reference_degC"].as_f64().unwrap() - 25.0).abs() < 1e-9);
    // In the unit of the outputs: 1.2 mg/K.
    let slope = block["bias"][2][0].as_f64().unwrap() / 9.80665e-3;
    assert!((slope - 1.2).abs() < 0.1, "{slope}");
    let names: Vec<&str> = written["estimate"]["components"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|c| c["name"].as_str())
        .collect();
    assert!(
        names.contains(&"bias.z") && names.contains(&"bias.z.T1"),
        "{names:?}"
    );
    let header = succeed(&["export", text(&out.join("calibration.json")), "--c"]);
    let header = String::from_utf8_lossy(&header.stdout).into_owned();
    assert!(
        header.contains(
            "unit_apply(const float output[3], float temperature, float acceleration[3])"
        )
    );

    // Applied with the temperature, z no longer follows it; without, it is refused.
    let compensated = folder.path().join("compensated.csv");
    let calibration = out.join("calibration.json");
    let mut words = vec![
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&compensated),
        "--columns",
        "acc_x,acc_y,acc_z",
    ];
    let said = refuse(&words);
    assert!(said.contains("no column of temperatures"), "{said}");
    words.extend(["--temperature", "temp", "--force"]);
    succeed(&words);
    let z: Vec<f64> = std::fs::read_to_string(&compensated)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
        .collect();
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    // Cold against warm: 84 mg before, the uncertainty of the coefficients after.
    let change = mean(&z[2800..3200]) - mean(&z[..400]);
    assert!(change.abs() < 1.5 * 9.80665e-3, "{change}");
}

/// What lies beyond the sweep is compensated as at its nearer end and counted, or refused.
#[test]
fn refuses_temperatures_beyond_the_sweep_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = folder.path().join("calibration.json");
    let file = r#"{"schema": {"name": "proofmass.calibration", "version": 2}, "kind": "triaxial",
        "software": {"name": "proofmass", "version": "0.1.0"}, "device": {}, "input_unit": "count", "output_unit": "m/s²",
        "columns": ["x", "y", "z"], "model": "full", "K": [[100, 0, 0], [0, 100, 0], [0, 0, 100]], "b": [0, 0, 0],
        "estimate": {"components": [], "covariance": [], "influences": []},
        "temperature": {"reference_degC": 20, "bias": [[1, 0, 0], [0, 0, 0], [0, 0, 0]],
            "scale": [[0, 0, 0], [0, 0, 0], [0, 0, 0]], "range_degC": [0, 40]}, "inputs": []}"#;
    std::fs::write(&calibration, file).unwrap();
    let recording = folder.path().join("raw.csv");
    std::fs::write(
        &recording,
        "x_count,y_count,z_count,t_degC\n110,0,981,30\n130,0,981,50\n",
    )
    .unwrap();
    let out = folder.path().join("out.csv");
    let words = vec![
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&out),
        "--temperature",
        "t",
    ];
    let output = succeed(&words);
    assert!(
        stderr(&output).contains("1 sample lies beyond 0.0 … 40.0 °C"),
        "{}",
        stderr(&output)
    );
    let written = std::fs::read_to_string(&out).unwrap();
    let x: Vec<&str> = written
        .lines()
        .skip(1)
        .map(|l| l.split(',').next().unwrap())
        .collect();
    // At 50 °C with the offset of 40 °C: (130 − 20) / 100.
    assert_eq!(x, ["1.0", "1.1"]);
    let mut strict = words;
    strict.extend(["--within-range", "--force"]);
    let said = refuse(&strict);
    assert!(
        said.contains("beyond the range") && said.contains(":3"),
        "{said}"
    );
}
