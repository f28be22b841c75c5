//! The table of docs/what-takes-what.md: every cell is typed.

use crate::support::axis::column;
use crate::support::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Output;

const PAGE: &str = include_str!("data/what-takes-what.md");

/// Rows of the first table of the page, its heading first.
fn cells() -> Vec<Vec<String>> {
    let rows = PAGE.lines().skip_while(|l| !l.starts_with("| result"));
    let rows = rows.take_while(|l| l.starts_with('|'));
    let row = |l: &str| {
        let fields = l.trim_matches('|').split('|');
        fields.map(|f| f.trim().to_owned()).collect()
    };
    rows.filter(|l| !l.starts_with("|---")).map(row).collect()
}

const G: f64 = 9.80665;

/// Volts of a sensor of one axis.
fn volts(a: f64) -> f64 {
    0.004 + 0.0131 * a
}

/// Recordings of one axis in volts, or of three axes in counts or volts as their calibration takes them.
struct Recordings {
    raw: PathBuf,
    columns: &'static str,
    rests: PathBuf,
    sweep: PathBuf,
    sweep_columns: &'static str,
    drive: PathBuf,
    axis: &'static [&'static str],
}

/// Rests up and down, a sweep of the temperature and a driven axis, of one axis in volts.
fn one_axis(folder: &Path) -> Recordings {
    let at = |name: &str| folder.join(name);
    let mut noise = Chance(3);
    table(
        &at("one-rests.csv"),
        "t_s,acc_V,T_degC",
        (0..4800).map(|i| {
            let (turn, within) = (i / 600, i % 600);
            let up = if turn % 2 == 0 { 1.0 } else { -1.0 };
            let swing = std::f64::consts::PI * f64::from((within - 500).max(0)) / 100.0;
            let a = up * G * swing.cos() + 0.02 * noise.normal();
            vec![0.01 * f64::from(i), volts(a), 20.0]
        }),
    );
    table(
        &at("one-sweep.csv"),
        "acc_V,T_degC",
        (0..3000).map(|i| {
            let s = f64::from(i) / 1500.0;
            let t = 60.0 * if s < 1.0 { s } else { 2.0 - s };
            let t = t + 0.02 * noise.normal();
            vec![volts(G + 0.01 * (t - 25.0) + 2e-3 * noise.normal()), t]
        }),
    );
    Recordings {
        raw: at("one-rests.csv"),
        columns: "acc_V",
        rests: at("one-rests.csv"),
        sweep: at("one-sweep.csv"),
        sweep_columns: "acc_V",
        drive: drive(folder, "one-drive.csv", &["acc_V"]),
        axis: &[],
    }
}

/// A driven axis whose accelerometer is the last column, once for every name.
fn drive(folder: &Path, name: &str, columns: &[&str]) -> PathBuf {
    let place = folder.join("axis");
    if !place.exists() {
        succeed(&["simulate", "axis", "--duration", "3", "-o", text(&place)]);
    }
    let recording = place.join("recording.csv");
    let a = column(&recording, "acceleration_m/s2");
    let mut written = String::new();
    for (i, line) in std::fs::read_to_string(&recording)
        .unwrap()
        .lines()
        .enumerate()
    {
        let _ = write!(written, "{line}");
        for name in columns {
            let _ = match i {
                0 => write!(written, ",{name}"),
                _ => write!(written, ",{}", volts(a[i - 1])),
            };
        }
        written.push('\n');
    }
    let path = folder.join(name);
    std::fs::write(&path, written).unwrap();
    path
}

#[test]
fn law_every_cell_of_the_table_is_true() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let one = one_axis(folder.path());

    // The results, one for each row.
    let mut results: BTreeMap<&str, (PathBuf, &Recordings)> = BTreeMap::new();
    succeed(&["calibrate", example, "-o", text(&at("three"))]);
    let columns = json(&at("three").join("calibration.json"))["columns"].clone();
    let columns: Vec<String> = columns
        .as_array()
        .unwrap()
        .iter()
        .map(|c| match c {
            serde_json::Value::String(name) => name.clone(),
            number => number.to_string(),
        })
        .collect();
    let columns: &'static str = columns.join(",").leak();
    let raw = Path::new(example).join("recording.csv");
    // A sweep and a drive of three axes, in counts as the example has them: outputs near its own at rest.
    let calibration = json(&at("three").join("calibration.json"));
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let k: Vec<f64> = (0..3).map(|i| number(&calibration["K"][i][i])).collect();
    let b: Vec<f64> = (0..3).map(|i| number(&calibration["b"][i])).collect();
    let mut noise = Chance(7);
    table(
        &at("three-sweep.csv"),
        "x_count,y_count,z_count,T_degC",
        (0..3000).map(|i| {
            let s = f64::from(i) / 1500.0;
            let t = 60.0 * if s < 1.0 { s } else { 2.0 - s } + 0.02 * noise.normal();
            let a = [0.001 * t, 0.0, G + 0.01 * (t - 25.0)];
            let mut row: Vec<f64> = (0..3)
                .map(|j| b[j] + k[j] * (a[j] + 2e-3 * noise.normal()))
                .collect();
            row.push(t);
            row
        }),
    );
    let a = column(
        &drive(folder.path(), "one-drive.csv", &["acc_V"]),
        "acceleration_m/s2",
    );
    let mut written = String::new();
    for (i, line) in std::fs::read_to_string(at("axis").join("recording.csv"))
        .unwrap()
        .lines()
        .enumerate()
    {
        let counts = |j: usize| b[j] + k[j] * if j == 0 { a[i - 1] } else { 0.0 };
        let _ = match i {
            0 => writeln!(written, "{line},x_count,y_count,z_count"),
            _ => writeln!(written, "{line},{},{},{}", counts(0), counts(1), counts(2)),
        };
    }
    std::fs::write(at("three-drive.csv"), written).unwrap();
    let three = Recordings {
        rests: raw.clone(),
        raw,
        columns,
        sweep: at("three-sweep.csv"),
        sweep_columns: "x_count,y_count,z_count",
        drive: at("three-drive.csv"),
        axis: &["--axis", "x"],
    };
    let three_volts = Recordings {
        raw: at("three-volts.csv"),
        columns: "x_V,y_V,z_V",
        rests: at("three-volts.csv"),
        sweep: at("three-volts.csv"),
        sweep_columns: "x_V,y_V,z_V",
        drive: drive(
            folder.path(),
            "three-volts-drive.csv",
            &["x_V", "y_V", "z_V"],
        ),
        axis: &["--axis", "x"],
    };
    table(
        &three_volts.raw,
        "t_s,x_V,y_V,z_V,T_degC",
        (0..400).map(|i| {
            vec![
                0.01 * f64::from(i),
                0.01,
                0.02,
                0.1,
                20.0 + 0.01 * f64::from(i),
            ]
        }),
    );
    results.insert(
        "three axes: `calibrate` (multi-position)",
        (at("three"), &three),
    );
    let temperature = |recordings: &Recordings, calibration: &Path, out: &Path| {
        let words = [
            "test",
            "temperature",
            text(&recordings.sweep),
            "--temperature",
            "T",
            "--rate",
            "10",
        ];
        let more = [
            "--columns",
            recordings.sweep_columns,
            "--reference",
            "25",
            "-o",
            text(out),
        ];
        let calibration = calibration.join("calibration.json");
        succeed(&[&words[..], &more, &["--calibration", text(&calibration)]].concat());
    };
    temperature(&three, &at("three"), &at("three-T"));
    results.insert(
        "three axes over temperature: `test temperature`",
        (at("three-T"), &three),
    );
    succeed(&["simulate", "shaker", "-o", text(&at("shaker"))]);
    succeed(&["calibrate", text(&at("shaker"))]);
    results.insert(
        "three axes over frequency: `calibrate` (shaker)",
        (at("shaker/result"), &three_volts),
    );

    table(
        &at("levels.csv"),
        "a_m/s2,out_V",
        (0..40).map(|i| {
            let a = -60.0 + 3.0 * f64::from(i);
            vec![a, volts(a) + 2e-5 * noise.normal()]
        }),
    );
    let reading = |test: &str, table: &str, more: &[&str]| {
        let (table, out) = (at(table), at(test));
        let words = [
            "test",
            test,
            text(&table),
            "--output-column",
            "out_V",
            "-o",
            text(&out),
        ];
        succeed(&[&words[..], more].concat());
        out
    };
    let linear = reading("linearity", "levels.csv", &["--acceleration", "a_m/s2"]);
    table(
        &at("ends.csv"),
        "position,out_V",
        (0..12).map(|i| {
            let p = if i % 2 == 0 { 1.0 } else { -1.0 };
            vec![p, volts(p * G) + 2e-5 * noise.normal()]
        }),
    );
    let ends = reading("sensitivity", "ends.csv", &["--position", "position"]);
    results.insert(
        "one axis: `test linearity`, `test centrifuge`",
        (linear.clone(), &one),
    );
    results.insert(
        "one axis: `test tilt`, `test sensitivity`, `calibrate` (single-axis)",
        (ends, &one),
    );
    temperature(&one, &linear, &at("one-T"));
    results.insert(
        "one axis over temperature: `test temperature`",
        (at("one-T"), &one),
    );
    let single = at("single");
    std::fs::create_dir(&single).unwrap();
    campaign(
        &single,
        "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[reference]\nfile = \"reference.csv\"\nk = 2\n\
         [reading]\nu_relative = 0.001\nu_phase_deg = 0.1\n",
    );
    let certificate = "frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n0.5,10,0,0.4,0.3\n500,10,0,0.4,0.3\n";
    std::fs::write(single.join("reference.csv"), certificate).unwrap();
    let runs = "run,frequency_Hz,reference_V,reference_phase_deg,output_V,output_phase_deg\n\
                a,80,0.1,0,0.131,0\nb,100,0.1,0,0.13105,0\nc,160,0.1,0,0.131,0\n";
    std::fs::write(single.join("runs.csv"), runs).unwrap();
    succeed(&["calibrate", text(&single)]);
    results.insert(
        "one axis over frequency: `calibrate` (shaker-single, shaker-primary)",
        (single.join("result"), &one),
    );
    let rest = at("rest.csv");
    table(
        &rest,
        "t_s,x_g,y_g,z_g",
        (0..6000).map(|i| {
            let mut n = || 1e-3 * noise.normal();
            vec![0.01 * f64::from(i), n(), n(), 1.0 + n()]
        }),
    );
    let columns = ["--columns", "x_g,y_g,z_g"];
    succeed(
        &[
            &["test", "zero-g", text(&rest), "-o", text(&at("zero-g"))],
            &columns[..],
        ]
        .concat(),
    );
    succeed(&[
        "noise",
        text(&rest),
        "--columns",
        "x_g,y_g,z_g",
        "-o",
        text(&at("noise")),
    ]);
    let tracked = at("bias");
    let bias = ["bias", text(&rest), "-o", text(&tracked), "--up", "+z"];
    succeed(&[&bias[..], &columns, &["--white", "1e-3", "--walk", "1e-6"]].concat());
    for (heading, name) in [
        ("`test zero-g`", "zero-g"),
        ("`noise`", "noise"),
        ("`bias`", "bias"),
    ] {
        results.insert(heading, (at(name), &one));
    }

    // The same sensor as the calibration of three axes, at rest for as long as its bias was tracked.
    table(
        &at("bias-rest.csv"),
        "t_s,x_count,y_count,z_count",
        (0..6000).map(|i| {
            let counts = |j: usize, a: f64| b[j] + k[j] * a;
            vec![
                0.01 * f64::from(i),
                counts(0, 0.0),
                counts(1, 0.0),
                counts(2, G),
            ]
        }),
    );
    let raw_of_bias = at("bias-rest.csv");
    let three_calibrated = at("three").join("result.json");

    // Every cell.
    let cells = cells();
    assert_eq!(cells.len(), 1 + results.len(), "{cells:?}");
    let scratch = at("scratch");
    let run = |command: &str, result: &Path, with: &Recordings, band: bool, warm: bool| -> Output {
        let _ = std::fs::remove_dir_all(&scratch);
        std::fs::create_dir(&scratch).unwrap();
        let calibration = text(result);
        let out = scratch.join("out.csv");
        // The same calibration as another file.
        let mut other = result.with_file_name("calibration.json");
        if !other.exists() {
            other = result.to_path_buf();
        }
        let banded = |option: &'static str| -> Vec<&str> {
            if band {
                vec![option, "80,160"]
            } else {
                Vec::new()
            }
        };
        let words: Vec<&str> = match command {
            "`apply`" => {
                // A calibration over temperature asks for the temperature, which the sweeps have.
                let (recording, columns) = match warm {
                    true => (&with.sweep, with.sweep_columns),
                    false => (&with.raw, with.columns),
                };
                let mut words = vec!["apply", calibration, text(recording), "-o", text(&out)];
                words.extend(["--columns", columns]);
                if warm {
                    words.extend(["--temperature", "T"]);
                }
                words.extend(banded("--band"));
                // What is no calibration follows one.
                if band && calibration == text(&tracked.join("result.json")) {
                    words = vec!["apply", text(&three_calibrated), text(&raw_of_bias)];
                    words.extend(["-o", text(&out), "--columns", "x_count,y_count,z_count"]);
                    words.extend(["--bias", calibration]);
                }
                words
            }
            "`export`" => [&["export", calibration, "--c"], &banded("--band")[..]].concat(),
            "`velocity --calibration`" => {
                let mut words = vec![
                    "velocity",
                    "estimate",
                    text(&with.drive),
                    "--position",
                    "encoder",
                ];
                words.extend([
                    "--counts-per-turn",
                    "2000",
                    "--radius",
                    "0.3",
                    "--calibration",
                    calibration,
                ]);
                words.extend([
                    "--acceleration",
                    if with.axis.is_empty() {
                        "acc_V"
                    } else {
                        with.sweep_columns
                    },
                ]);
                words.extend(with.axis);
                words.extend(banded("--calibration-band"));
                words
            }
            "`validate`" => {
                let gravity = ["--gravity", "9.80665", "--gravity-uncertainty", "1e-4"];
                let words = [
                    "validate",
                    calibration,
                    text(&with.rests),
                    "--columns",
                    with.columns,
                ];
                [&words[..], &gravity].concat()
            }
            "`test temperature --calibration`" => {
                let words = [
                    "test",
                    "temperature",
                    text(&with.sweep),
                    "--temperature",
                    "T",
                    "--rate",
                    "10",
                ];
                let more = [
                    "--columns",
                    with.sweep_columns,
                    "--calibration",
                    calibration,
                ];
                [&words[..], &more, &["--reference", "25"]].concat()
            }
            "`test orthogonality`" => vec!["test", "orthogonality", calibration],
            "`compare`" => vec!["compare", calibration, text(&other)],
            "`velocity drift --calibration`" => {
                let mut words = vec!["velocity", "drift"];
                match band {
                    true => words.extend(["--noise-result", calibration, "--axis", "x"]),
                    false => words.extend(["--calibration", calibration]),
                }
                if !band {
                    words.extend(with.axis);
                }
                words
            }
            other => panic!("no such column: {other}"),
        };
        proofmass(&words)
    };
    let mut wrong = Vec::new();
    for row in &cells[1..] {
        let Some((result, with)) = results.get(row[0].as_str()) else {
            panic!("no result for the row {:?}", row[0]);
        };
        let result = result.join("result.json");
        for (command, cell) in cells[0][1..].iter().zip(&row[1..]) {
            let warm = row[0].contains("over temperature");
            let plain = run(command, &result, with, false, warm);
            let said = stderr(&plain);
            let good = match cell.as_str() {
                "yes" => plain.status.success(),
                "`--band`" | "`--calibration-band`" | "`--bias`" | "`--noise-result`" => {
                    plain.status.code() == Some(1)
                        && said.contains(cell.trim_matches('`'))
                        && run(command, &result, with, true, warm).status.success()
                }
                "" => false,
                reason => {
                    plain.status.code() == Some(1)
                        && said.contains(
                            reason
                                .strip_prefix('"')
                                .and_then(|r| r.strip_suffix('"'))
                                .unwrap(),
                        )
                }
            };
            if !good {
                wrong.push(format!("{} × {command}: {cell:?}, but {said}", row[0]));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
