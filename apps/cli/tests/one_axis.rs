//! A calibration of one axis through the commands that take it: what one command measures, the next one uses.
//!
//! Every sensor is written out by its own equation here, o = b + β (T − 25 °C) + k (a + k₂ a² + k₃ a³), so that what comes back is
//! compared with a truth that the program does not know.

use crate::support::axis::{axis, column, rms};
use crate::support::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A servo accelerometer with an output in volts.
#[derive(Clone, Copy)]
struct Sensor {
    /// V/(m/s²).
    k: f64,
    /// V.
    b: f64,
    /// 1/(m/s²), 1/(m/s²)².
    k2: f64,
    k3: f64,
    /// V/K.
    beta: f64,
}

const SERVO: Sensor = Sensor {
    k: 0.0131,
    b: 0.0042,
    k2: 2e-4,
    k3: 1e-6,
    beta: 2e-4,
};

/// Without the temperature.
const CURVED: Sensor = Sensor { beta: 0.0, ..SERVO };

const STRAIGHT: Sensor = Sensor {
    k2: 0.0,
    k3: 0.0,
    beta: 0.0,
    ..SERVO
};

impl Sensor {
    fn output(&self, a: f64, temperature: f64) -> f64 {
        let shape = a * (1.0 + a * (self.k2 + a * self.k3));
        self.b + self.beta * (temperature - 25.0) + self.k * shape
    }
}

/// Accelerations along a recording of the sensor, from −50 to 50 m/s².
fn truth() -> Vec<f64> {
    (0..=100).map(|i| f64::from(i) - 50.0).collect()
}

fn recording(folder: &Path, sensor: Sensor, temperature: f64) -> PathBuf {
    let path = folder.join("recording.csv");
    let rows = truth().into_iter().enumerate();
    table(
        &path,
        "t_s,acc_V,temp_degC",
        rows.map(|(i, a)| vec![1e-3 * i as f64, sensor.output(a, temperature), temperature]),
    );
    path
}

/// `test linearity` on 40 levels between ±60 m/s² with 20 µV of noise.
fn linearity(folder: &Path, sensor: Sensor, seed: u64, more: &[&str]) -> PathBuf {
    let (levels, out) = (folder.join("levels.csv"), folder.join("linearity"));
    let mut noise = Chance(seed);
    table(
        &levels,
        "a_m/s2,out_V,T_degC",
        (0..40).map(|i| {
            let (a, t) = (-60.0 + 3.0 * f64::from(i), 20.0 + f64::from(i * 7 % 11));
            vec![a, sensor.output(a, t) + 2e-5 * noise.normal(), t]
        }),
    );
    let mut words = vec!["test", "linearity", text(&levels), "--acceleration", "a"];
    words.extend(["--output-column", "out", "-o", text(&out)]);
    words.extend(more);
    succeed(&words);
    out
}

/// What `apply` makes of the recording, and the largest uncertainty that it states with the acceleration at which it holds.
fn apply(calibration: &Path, recording: &Path, more: &[&str]) -> (Vec<f64>, f64, f64) {
    let out = recording.with_file_name("compensated.csv");
    let mut words = vec![
        "apply",
        text(calibration),
        text(recording),
        "-o",
        text(&out),
    ];
    words.extend(["--columns", "acc_V"]);
    words.extend(more);
    let said = stderr(&succeed(&words));
    let stated = said
        .split("uncertainty by the calibration: at most ")
        .nth(1);
    let words: Vec<&str> = stated
        .unwrap_or_else(|| panic!("{said}"))
        .split(' ')
        .collect();
    let at = words.iter().position(|w| *w == "at").unwrap() + 1;
    let number = |i: usize| words[i].parse::<f64>().unwrap();
    (column(&out, "acc_m/s2"), number(0), number(at))
}

#[test]
fn coverage_of_a_test_through_apply() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path(), CURVED, 25.0);
    let (mut covered, trials) = (0, 60);
    for seed in 0..trials {
        let out = linearity(folder.path(), CURVED, 100 + seed, &[]);
        let (a, expanded, at) = apply(&out.join("result.json"), &raw, &[]);
        let nearest = |v: &f64| (v - at).abs();
        let i = (0..a.len()).min_by(|i, j| nearest(&a[*i]).total_cmp(&nearest(&a[*j])));
        let i = i.unwrap();
        covered += u64::from((a[i] - truth()[i]).abs() <= expanded);
        // 20 µV over 13 mV/(m/s²) in 40 readings is some mm/s²; the square and the cube at 50 m/s² are 0.5 and 0.125 m/s².
        assert!((1e-4..1e-2).contains(&expanded), "{expanded}");
        for (a, truth) in a.iter().zip(truth()) {
            assert!((a - truth).abs() < 1e-2, "{a} {truth}");
        }
    }
    // Of 60 at 95 %, fewer than 51 come in one of a thousand.
    assert!(covered >= 51, "{covered} of {trials}");
}

#[test]
fn known_temperature_of_a_table_is_taken_out() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path(), SERVO, 28.5);
    let out = linearity(folder.path(), SERVO, 3, &["--temperature", "T"]);
    let calibration = out.join("calibration.json");
    let (a, expanded, _) = apply(&calibration, &raw, &["--temperature", "temp"]);
    for (a, truth) in a.iter().zip(truth()) {
        assert!((a - truth).abs() < 3.0 * expanded, "{a} {truth} {expanded}");
    }
    // 0.2 mV/K over 3.5 K is 53 mm/s², which would be there without the temperature; so it is asked for.
    let words = [
        "apply",
        text(&calibration),
        text(&raw),
        "--columns",
        "acc_V",
    ];
    let compensated = folder.path().join("none.csv");
    let words = [&words[..], &["-o", text(&compensated)]].concat();
    assert!(refuse(&words).contains("--temperature COLUMN"));
}

#[test]
fn known_sensor_comes_back_from_every_test_of_one_axis() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let raw = recording(folder.path(), STRAIGHT, 25.0);
    let g = 9.80665;
    let mut noise = Chance(11);
    let mut reading = |a: f64| 1e3 * STRAIGHT.output(a, 25.0) + 5e-3 * noise.normal();
    table(
        &at("tilt.csv"),
        "angle_deg,out_mV",
        (0..24).map(|i| {
            let t = 15.0 * f64::from(i);
            vec![t, reading(g * (t + 0.5).to_radians().cos())]
        }),
    );
    table(
        &at("ends.csv"),
        "position,out_mV",
        (0..12).map(|i| {
            let p = if i % 2 == 0 { 1.0 } else { -1.0 };
            vec![p, reading(p * g)]
        }),
    );
    table(
        &at("arm.csv"),
        "speed_rad/s,out_mV",
        (0..20).map(|i| {
            let w = 0.5 * f64::from(i);
            vec![w, reading(0.5 * w * w)]
        }),
    );
    let gravity = ["--gravity", "9.80665", "--gravity-uncertainty", "1e-5"];
    let cases: [(&str, &str, &[&str]); 3] = [
        ("tilt", "tilt.csv", &["--angle", "angle"]),
        ("sensitivity", "ends.csv", &["--position", "position"]),
        (
            "centrifuge",
            "arm.csv",
            &["--speed", "speed", "--radius", "0.5"],
        ),
    ];
    for (test, file, input) in cases {
        let (readings, out) = (at(file), at(test));
        let mut words = vec!["test", test, text(&readings), "--output-column", "out"];
        words.extend(["-o", text(&out)]);
        words.extend(input);
        if test != "centrifuge" {
            words.extend(gravity);
        }
        succeed(&words);
        let stored = json(&out.join("calibration.json"));
        assert_eq!(stored["kind"], "single-axis");
        assert_eq!(stored["input_unit"], "V");
        let (a, expanded, _) = apply(&out.join("result.json"), &raw, &[]);
        for (a, truth) in a.iter().zip(truth()) {
            assert!(
                (a - truth).abs() < 2.0 * expanded,
                "{test}: {a} {truth} {expanded}"
            );
        }
    }
    // The twelve positions of a campaign, in degrees.
    let rows: Vec<String> = (0..12)
        .map(|i| {
            let t = 30.0 * f64::from(i);
            format!("{t},{}", reading(g * t.to_radians().cos()))
        })
        .collect();
    let place = at("campaign");
    std::fs::create_dir(&place).unwrap();
    std::fs::write(
        place.join("table.csv"),
        format!("angle_deg,out_mV\n{}\n", rows.join("\n")),
    )
    .unwrap();
    campaign(
        &place,
        "kind = \"single-axis\"\n[recording]\nfile = \"table.csv\"\nangle = \"angle\"\ncolumn = \"out\"\n\
         [gravity]\nvalue = 9.80665\nstandard_uncertainty = 1e-5\n",
    );
    succeed(&["calibrate", text(&place)]);
    let (a, expanded, _) = apply(&place.join("result/calibration.json"), &raw, &[]);
    for (a, truth) in a.iter().zip(truth()) {
        assert!((a - truth).abs() < 2.0 * expanded, "{a} {truth} {expanded}");
    }
}

#[test]
fn law_every_form_of_export_computes_what_apply_computes() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path(), CURVED, 25.0);
    let out = linearity(folder.path(), CURVED, 5, &[]);
    let calibration = out.join("result.json");
    for (form, word) in [
        ("--rust", "AxisCompensation::constant("),
        (
            "--c",
            "_apply(const float output[1], float acceleration[1])",
        ),
        ("--python", "def apply(output):"),
        ("--json", "\"K_inverse\""),
    ] {
        let said = succeed(&["export", text(&calibration), form]);
        let written = String::from_utf8(said.stdout).unwrap();
        assert!(written.contains(word), "{form}: {written}");
    }
    // The check vectors are those of the sensor, as far as the calibration knows it.
    let said = succeed(&["export", text(&calibration), "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    let numbers = |name: &str| -> Vec<f64> {
        let rows = json["check"][name].as_array().unwrap().iter();
        rows.map(|row| row[0].as_f64().unwrap()).collect()
    };
    for (o, a) in numbers("outputs").into_iter().zip(numbers("accelerations")) {
        assert!((CURVED.output(a, 25.0) - o).abs() < 1e-4, "{a} {o}");
    }
    let module = folder.path().join("sensor.py");
    succeed(&[
        "export",
        text(&calibration),
        "--python",
        "-o",
        text(&module),
    ]);
    let (compensated, ..) = apply(&calibration, &raw, &[]);
    let program = format!(
        "import sensor\nfor a in {:?}:\n    print(repr(sensor.apply(a)))\nassert sensor.self_check() is None",
        column(&raw, "acc_V")
    );
    let python = std::process::Command::new("python3")
        .args(["-c", &program])
        .current_dir(folder.path())
        .output();
    match python {
        Ok(said) if said.status.success() => {
            let numbers = String::from_utf8(said.stdout).unwrap();
            for (line, a) in numbers.lines().zip(&compensated) {
                assert!(
                    (line.parse::<f64>().unwrap() - a).abs() < 1e-12,
                    "{line} {a}"
                );
            }
        }
        other => println!("skipped: no python3 ({other:?})"),
    }
    let integers = ["export", text(&calibration), "--c", "--number", "fixed"];
    assert!(!refuse(&[&integers[..], &["--outputs", "0,65535"]].concat()).is_empty());
}

/// The simulated axis with its accelerometer in volts.
fn axis_in_volts(folder: &Path, sensor: Sensor) -> PathBuf {
    let place = axis(folder, &["--duration", "4", "--seed", "3"]);
    let recording = place.join("recording.csv");
    let a = column(&recording, "acceleration_m/s2");
    let lines = std::fs::read_to_string(&recording).unwrap();
    let mut written = String::new();
    for (i, line) in lines.lines().enumerate() {
        let volts = match i {
            0 => "acc_V".to_owned(),
            _ => sensor.output(a[i - 1], 25.0).to_string(),
        };
        let _ = writeln!(written, "{line},{volts}");
    }
    let path = place.join("volts.csv");
    std::fs::write(&path, written).unwrap();
    path
}

const ENCODER: [&str; 6] = [
    "--position",
    "encoder",
    "--counts-per-turn",
    "2000",
    "--radius",
    "0.3",
];

#[test]
fn known_velocity_from_volts_is_that_from_the_acceleration() {
    let folder = tempfile::tempdir().unwrap();
    let recording = axis_in_volts(folder.path(), CURVED);
    let calibration = linearity(folder.path(), CURVED, 9, &[]).join("result.json");
    let truth = column(&recording.with_file_name("truth.csv"), "velocity_m/s");
    let run = |name: &str, more: &[&str]| -> (Vec<f64>, Vec<f64>) {
        let out = folder.path().join(name);
        let mut words = vec!["velocity", "estimate", text(&recording), "-o", text(&out)];
        words.extend(ENCODER);
        words.extend(more);
        succeed(&words);
        let table = out.join("velocity.csv");
        (
            column(&table, "velocity_m/s"),
            column(&table, "standard_uncertainty_m/s"),
        )
    };
    let (plain, _) = run("plain", &["--acceleration", "acceleration"]);
    let volts = [
        "--acceleration",
        "acc_V",
        "--calibration",
        text(&calibration),
    ];
    let (v, u) = run("volts", &volts);
    let (own, reference) = (rms(&v, &truth, 500), rms(&plain, &truth, 500));
    assert!(own < 1.1 * reference, "{own} {reference}");
    let inside = (500..v.len())
        .filter(|i| (v[*i] - truth[*i]).abs() <= 2.0 * u[*i])
        .count();
    let share = inside as f64 / (v.len() - 500) as f64;
    assert!(share > 0.85, "{share}");
    // The prior of the gain enters once: from the calibration, or from the option.
    let twice = [&volts[..], &["--gain-uncertainty", "1"]].concat();
    let mut words = vec!["velocity", "estimate", text(&recording)];
    words.extend(ENCODER);
    assert!(refuse(&[&words[..], &twice[..]].concat()).contains("both state"));
    for question in ["compare", "map"] {
        let out = folder.path().join(question);
        let mut words = vec!["velocity", question, text(&recording), "-o", text(&out)];
        words.extend(ENCODER);
        words.extend(volts);
        let more: &[&str] = if question == "compare" {
            &["--method", "observer:5,25"]
        } else {
            &[]
        };
        words.extend(more);
        succeed(&words);
    }
}

#[test]
fn known_temperature_coefficients_of_one_column() {
    let folder = tempfile::tempdir().unwrap();
    let calibration =
        linearity(folder.path(), STRAIGHT, 13, &["--order", "1"]).join("calibration.json");
    let sweep = folder.path().join("sweep.csv");
    let mut noise = Chance(5);
    let g = 9.80665;
    let warm = |a: f64, t: f64| {
        Sensor {
            beta: 1.5e-4,
            ..STRAIGHT
        }
        .output(a, t)
    };
    table(
        &sweep,
        "acc_V,temp_degC",
        (0..6000).map(|i| {
            let s = f64::from(i) / 3000.0;
            let t = -10.0 + 70.0 * if s < 1.0 { s } else { 2.0 - s };
            vec![
                warm(g, t) + 2e-5 * noise.normal(),
                t + 0.02 * noise.normal(),
            ]
        }),
    );
    let out = folder.path().join("temperature");
    let words = [
        "test",
        "temperature",
        text(&sweep),
        "--temperature",
        "temp",
        "--rate",
        "10",
    ];
    let more = [
        "--columns",
        "acc_V",
        "--calibration",
        text(&calibration),
        "--reference",
        "25",
    ];
    succeed(&[&words[..], &more, &["-o", text(&out)]].concat());
    let result = json(&out.join("result.json"));
    let (slope, u, _) = quantity(&result, "slope");
    assert!((slope - 1.5e-4 / STRAIGHT.k).abs() < 4.0 * u, "{slope} {u}");
    // The completed calibration takes the temperature out again.
    let raw = folder.path().join("recording.csv");
    table(
        &raw,
        "t_s,acc_V,temp_degC",
        truth().into_iter().enumerate().map(|(i, a)| {
            let t = 0.5 * i as f64;
            vec![1e-3 * i as f64, warm(a, t), t]
        }),
    );
    let (a, expanded, _) = apply(&out.join("result.json"), &raw, &["--temperature", "temp"]);
    for (a, truth) in a.iter().zip(truth()) {
        assert!(
            (a - truth).abs() < 2.0 * expanded.max(2e-3),
            "{a} {truth} {expanded}"
        );
    }
    // Without a calibration volts have no gain.
    assert!(refuse(&[&words[..], &["--columns", "acc_V"]].concat()).contains("no acceleration"));
    let three = [
        &words[..],
        &[
            "--columns",
            "acc_V,acc_V,acc_V",
            "--calibration",
            text(&calibration),
        ],
    ]
    .concat();
    assert!(refuse(&three).contains("of one axis, and 3 columns are named"));
}

#[test]
fn known_constant_of_a_band_is_a_calibration_of_one_axis() {
    let folder = tempfile::tempdir().unwrap();
    // A comparison on a shaker at three frequencies against a reference of 10 mV/(m/s²), 0.4 % (k = 2).
    let place = folder.path().join("shaker");
    std::fs::create_dir(&place).unwrap();
    campaign(
        &place,
        "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[reference]\nfile = \"reference.csv\"\nk = 2\n\
         [reading]\nu_relative = 0.001\nu_phase_deg = 0.1\n",
    );
    std::fs::write(
        place.join("reference.csv"),
        "frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n0.5,10,0,0.4,0.3\n50,10,0,0.4,0.3\n",
    )
    .unwrap();
    std::fs::write(
        place.join("runs.csv"),
        "run,frequency_Hz,reference_V,reference_phase_deg,output_V,output_phase_deg\n\
         a,1,0.1,0,0.131,0\nb,5,0.1,0,0.13105,0\nc,20,0.1,0,0.131,0\n",
    )
    .unwrap();
    succeed(&["calibrate", text(&place)]);
    let table_of = place.join("result/result.json");
    let raw = recording(folder.path(), Sensor { b: 0.0, ..STRAIGHT }, 25.0);
    let compensated = folder.path().join("band.csv");
    let words = ["apply", text(&table_of), text(&raw), "--columns", "acc_V"];
    let words = [&words[..], &["-o", text(&compensated)]].concat();
    assert!(refuse(&words).contains("--band"));
    succeed(&[&words[..], &["--band", "1,20"]].concat());
    for (a, truth) in column(&compensated, "acc_m/s2").iter().zip(truth()) {
        assert!(
            (a - truth).abs() <= 0.006 * truth.abs() + 1e-9,
            "{a} {truth}"
        );
    }
    let said = succeed(&["export", text(&table_of), "--band", "1,20", "--c"]);
    let said = String::from_utf8(said.stdout).unwrap();
    assert!(
        said.contains("k_inverse[1][1]") && said.contains("Error of the acceleration at most"),
        "{said}"
    );
    // In the motion: the constant of the band is the gain, its stated error the prior.
    let volts = axis_in_volts(folder.path(), Sensor { b: 0.0, ..STRAIGHT });
    let truth = column(&volts.with_file_name("truth.csv"), "velocity_m/s");
    let out = folder.path().join("velocity");
    let mut words = vec![
        "velocity",
        "estimate",
        text(&volts),
        "--acceleration",
        "acc_V",
    ];
    words.extend(ENCODER);
    words.extend(["--calibration", text(&table_of)]);
    assert!(refuse(&words).contains("one over frequency"));
    words.extend(["--calibration-band", "1,20", "-o", text(&out)]);
    succeed(&words);
    let v = column(&out.join("velocity.csv"), "velocity_m/s");
    assert!(rms(&v, &truth, 500) < 5e-3, "{}", rms(&v, &truth, 500));
}

#[test]
fn known_rests_up_and_down_validate_a_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let good = linearity(folder.path(), CURVED, 17, &[]);
    let raw = folder.path().join("rests.csv");
    let mut noise = Chance(23);
    // Up and down by turns, five seconds each, turned over in a second; the noise is that of 2 mg.
    let g = 9.80665;
    let rests = (0..4800).map(|i| {
        let (turn, within) = (i / 600, i % 600);
        let up = if turn % 2 == 0 { 1.0 } else { -1.0 };
        let swing = std::f64::consts::PI * f64::from((within - 500).max(0)) / 100.0;
        let a = up * g * swing.cos() + 0.02 * noise.normal();
        vec![0.01 * f64::from(i), CURVED.output(a, 25.0)]
    });
    table(&raw, "t_s,acc_V", rests);
    let run = |calibration: &Path| {
        let out = folder.path().join("validation");
        let words = [
            "validate",
            text(calibration),
            text(&raw),
            "--columns",
            "acc_V",
            "-o",
        ];
        let gravity = [
            "--gravity",
            "9.80665",
            "--gravity-uncertainty",
            "1e-5",
            "--force",
        ];
        succeed(&[&words[..], &[text(&out)], &gravity].concat());
        json(&out.join("result.json"))
    };
    let result = run(&good.join("result.json"));
    assert_eq!(codes(&result), Vec::<String>::new(), "{result}");
    let attitudes = result["extra"]["validation"]["attitudes"]
        .as_array()
        .unwrap();
    assert_eq!(attitudes.len(), 8);
    for (i, rest) in attitudes.iter().enumerate() {
        let a = rest["acceleration"][0].as_f64().unwrap();
        let truth = if i % 2 == 0 { g } else { -g };
        let u = rest["standard_uncertainty"].as_f64().unwrap();
        assert!((a - truth).abs() < 4.0 * u, "{a} {truth} {u}");
    }
    // A gain that is one per cent off is seen.
    let wrong = Sensor {
        k: 1.01 * CURVED.k,
        ..CURVED
    };
    let wrong = linearity(folder.path(), wrong, 17, &[]);
    let said = codes(&run(&wrong.join("result.json")));
    assert!(said.iter().any(|c| c == "beyond-one-per-mille"), "{said:?}");
}

#[test]
fn refuses_to_make_a_calibration_of_what_cannot_be_undone() {
    let folder = tempfile::tempdir().unwrap();
    // A square of 12 % at the end of the range is no correction; an output of noise has no gain.
    let bent = Sensor {
        k2: 2e-3,
        ..STRAIGHT
    };
    let dead = Sensor {
        k: 1e-9,
        ..STRAIGHT
    };
    for (sensor, why) in [
        (bent, "share of curvature"),
        (dead, "zero within its uncertainty"),
    ] {
        let out = linearity(folder.path(), sensor, 3, &["--force"]);
        let result = json(&out.join("result.json"));
        let found = codes(&result);
        assert!(
            found.iter().any(|c| c == "calibration-not-made"),
            "{found:?}"
        );
        assert!(result["findings"].to_string().contains(why), "{result}");
        assert!(!out.join("calibration.json").exists());
    }
}

#[test]
fn refuses_calibrations_that_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let three = folder.path().join("three");
    succeed(&["calibrate", example, "-o", text(&three)]);
    let three = three.join("calibration.json");
    let raw = recording(folder.path(), STRAIGHT, 25.0);
    let one = linearity(folder.path(), STRAIGHT, 1, &["--order", "1"]).join("result.json");
    let out = folder.path().join("out.csv");
    let apply = |calibration: &Path, columns: &str| {
        let words = ["apply", text(calibration), text(&raw), "-o", text(&out)];
        refuse(&[&words[..], &["--columns", columns]].concat())
    };
    // Three axes on a single column, one axis on three.
    assert!(apply(&three, "acc_V").contains("of 3 axes, and one column is named"));
    assert!(apply(&one, "t_s,acc_V,temp_degC").contains("of one axis, and 3 columns are named"));
    // Another unit of the raw output.
    let counts = folder.path().join("counts.csv");
    std::fs::write(&counts, "acc_count\n1\n2\n").unwrap();
    let said = refuse(&[
        "apply",
        text(&one),
        text(&counts),
        "-o",
        text(&out),
        "--columns",
        "acc_count",
    ]);
    assert!(said.contains("count, the calibration takes V"), "{said}");
    // Volts without a gain.
    let volts = axis_in_volts(folder.path(), STRAIGHT);
    let mut words = vec![
        "velocity",
        "estimate",
        text(&volts),
        "--acceleration",
        "acc_V",
    ];
    words.extend(ENCODER);
    assert!(refuse(&words).contains("no acceleration"));
    let with = |more: &[&str]| refuse(&[&words[..], more].concat());
    assert!(with(&["--calibration", text(&three), "--axis", "x"]).contains("of 3 axes"));
    assert!(with(&["--calibration", text(&one), "--axis", "x"]).contains("is of one"));
    // Two calibrations for one axis.
    let twice = ["--calibration", text(&one), "--calibration", text(&one)];
    let twice = proofmass(&[&words[..], &twice].concat());
    assert_eq!(twice.status.code(), Some(2));
    assert!(stderr(&twice).contains("cannot be used multiple times"));
    // Jobs that need three axes say so.
    assert!(refuse(&["test", "orthogonality", text(&one)]).contains("one axis"));
    // A result that holds no calibration.
    let none = folder.path().join("noise");
    let stored = folder.path().join("t.csv");
    table(
        &stored,
        "x_g,y_g,z_g",
        (0..500).map(|i| vec![1e-3 * f64::from(i % 7), 0.0, 1.0]),
    );
    succeed(&[
        "test",
        "zero-g",
        text(&stored),
        "--columns",
        "x_g,y_g,z_g",
        "--rate",
        "100",
        "-o",
        text(&none),
    ]);
    let none = none.join("result.json");
    assert!(apply(&none, "acc_V").contains("a result without a calibration"));
}
