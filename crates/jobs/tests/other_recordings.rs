//! Calibrations without twelve standstills: one axis alone, a sensor that is turned all the time, a logger that is worn.

use proofmass_core::{Matrix3, SensorModel, Unwatched, norm};
use proofmass_documents::AnyCalibration;
use proofmass_io::{ColumnRef, Source};
use proofmass_jobs::apply::{ApplyData, ApplyJob, Destination};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::{Job, StoredResult, Trouble};
use std::fmt::Write;
use std::path::Path;

const GRAVITY: &str = "[gravity]\nvalue = 9.81\nstandard_uncertainty = 1e-4\n";
const G: f64 = 9.81;

fn calibrate(folder: &Path, text: &str) -> Result<StoredResult, Trouble> {
    let path = folder.join("campaign.toml");
    std::fs::write(&path, text).unwrap();
    Campaign::open(&path)?.evaluate(Some("2026-01-01".to_owned()), &Unwatched)
}

fn file(result: &StoredResult, name: &str) -> serde_json::Value {
    let files = result.files().unwrap();
    let (_, bytes) = files.iter().find(|(n, _)| n == name).unwrap();
    serde_json::from_slice(bytes).unwrap()
}

/// Value, u and U of a quantity.
fn quantity(result: &StoredResult, name: &str) -> [f64; 3] {
    let document = file(result, "result.json");
    let all = document["quantities"].as_array().unwrap().clone();
    let q = all.iter().find(|q| q["name"] == name).unwrap();
    ["value", "u", "U"].map(|key| q[key].as_f64().unwrap())
}

/// Uniform between ±1, reproducible.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        2.0 * (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}

/// One axis of 1.004 and 0.02 m/s², resting at angles for four seconds each, turned within two.
fn rests(angles: &[f64], noise: f64) -> Vec<Vec<f64>> {
    let mut draw = Draw(11);
    let mut value = |angle: f64, shake: f64| {
        0.02 + 1.004 * G * angle.to_radians().cos() + noise * draw.next() + shake * draw.next()
    };
    let mut pieces = Vec::new();
    for (i, angle) in angles.iter().enumerate() {
        pieces.push((0..400).map(|_| value(*angle, 0.0)).collect());
        if let Some(next) = angles.get(i + 1) {
            let between = |k: i32| angle + (next - angle) * f64::from(k) / 200.0;
            pieces.push((0..200).map(|k| value(between(k), 0.5)).collect());
        }
    }
    pieces
}

fn table(path: &Path, heading: &str, rows: impl Iterator<Item = String>) {
    let lines: Vec<String> = rows.collect();
    std::fs::write(path, format!("{heading}\n{}\n", lines.join("\n"))).unwrap();
}

fn recording(path: &Path, samples: impl Iterator<Item = f64>) {
    let rows = samples
        .enumerate()
        .map(|(i, v)| format!("{:.2},{v:.6}", 0.01 * i as f64));
    table(path, "t_s,a_m/s2", rows);
}

#[test]
fn known_axis_up_and_down_from_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let pieces = rests(&[0.0, 180.0], 0.01);
    recording(&folder.path().join("up.csv"), pieces[0].iter().copied());
    recording(&folder.path().join("down.csv"), pieces[2].iter().copied());
    let campaign = |levelling: f64| {
        format!(
            "kind = \"single-axis\"\n[recording]\nfiles = [\"up.csv\", \"down.csv\"]\ncolumn = \"a\"\n\
             [position]\nangles_deg = [0, 180]\nlevelling_deg = {levelling}\n{GRAVITY}"
        )
    };
    let level = calibrate(folder.path(), &campaign(0.0)).unwrap();
    let [bias, u, _] = quantity(&level, "bias");
    // Uniform noise of ±10 mm/s² has 5.8 mm/s²; the half sum of two means of 400 some 0.2 mm/s².
    let expected = 0.01 / 3f64.sqrt() / 400f64.sqrt() / 2f64.sqrt();
    assert!((u / expected - 1.0).abs() < 0.2, "{u} {expected}");
    assert!((bias - 0.02).abs() < 4.0 * u);
    let [scale, u, _] = quantity(&level, "sensitivity");
    assert!((scale - 1.004).abs() < 4.0 * u);
    // Half a degree about two axes in each position, by hand: δ² of the sensitivity, whose mean is taken off, δ²/√2 of g in the bias.
    let tilted = calibrate(folder.path(), &campaign(0.5)).unwrap();
    let square = 0.5f64.to_radians().powi(2);
    let [longer, with, _] = quantity(&tilted, "sensitivity");
    assert!((longer / scale - 1.0 - square).abs() < 1e-9);
    assert!(((with * with - u * u).sqrt() / (1.004 * square) - 1.0).abs() < 1e-3);
    let [_, with, _] = quantity(&tilted, "bias");
    let added = (with * with - quantity(&level, "bias")[1].powi(2)).sqrt();
    assert!((added / (0.5f64.sqrt() * 1.004 * G * square) - 1.0).abs() < 1e-3);
}

#[test]
fn known_axis_on_a_turntable_from_a_table_and_from_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let mut draw = Draw(5);
    let rows = (0..36).map(|i| {
        let angle = 10.0 * f64::from(i);
        let out = 1.0 + 10.0 * (angle + 0.3f64).to_radians().cos() + 1e-3 * draw.next();
        format!("{angle},{out:.6}")
    });
    table(&folder.path().join("table.csv"), "angle_deg,out_mV", rows);
    let result = calibrate(
        folder.path(),
        &format!(
            "kind = \"single-axis\"\n[recording]\nfile = \"table.csv\"\ncolumn = \"out\"\nangle = \"angle\"\n\
             [position]\nzero_deg = 0.1\nlean_deg = 0.5\nout_of_plane_deg = 1\n{GRAVITY}"
        ),
    )
    .unwrap();
    let [angle, u, _] = quantity(&result, "misalignment");
    assert!((angle - 0.3f64.to_radians()).abs() < 1e-4);
    assert!(
        (u / 0.1f64.to_radians() - 1.0).abs() < 0.01,
        "the zero of the scale rules: {u}"
    );
    // A lean of 0.5° with an axis 1° out of the plane: S g χ ψ = 10 mV · 0.01745 · 0.008727.
    let [bias, u, _] = quantity(&result, "bias");
    assert!((bias - 1e-3).abs() < 1e-6);
    assert!(
        (u / (10e-3 * 1f64.to_radians() * 0.5f64.to_radians()) - 1.0).abs() < 0.01,
        "{u}"
    );

    let angles = [0.0, 60.0, 120.0, 180.0, 240.0, 300.0, 360.0];
    let pieces = rests(&angles, 0.01);
    recording(
        &folder.path().join("turn.csv"),
        pieces.into_iter().flatten(),
    );
    let campaign = |angles: &[f64]| {
        format!(
            "kind = \"single-axis\"\n[recording]\nfile = \"turn.csv\"\ncolumn = \"a\"\n\
             [position]\nangles_deg = {angles:?}\n{GRAVITY}"
        )
    };
    let result = calibrate(folder.path(), &campaign(&angles)).unwrap();
    for (name, truth) in [
        ("bias", 0.02),
        ("sensitivity", 1.004),
        ("misalignment", 0.0),
    ] {
        let [value, _, expanded] = quantity(&result, name);
        assert!(
            (value - truth).abs() < 2.0 * expanded,
            "{name}: {value} ± {expanded}"
        );
    }
    let refused = calibrate(folder.path(), &campaign(&angles[..5]))
        .err()
        .unwrap();
    assert!(
        refused.to_string().contains("5 angles are given"),
        "{refused}"
    );
}

#[test]
fn refuses_one_axis_whose_angles_are_unknown_or_given_twice() {
    let folder = tempfile::tempdir().unwrap();
    table(
        &folder.path().join("t.csv"),
        "p,out_V",
        ["1,1", "0.5,0.4"].map(str::to_owned).into_iter(),
    );
    for (recording, position, what) in [
        ("", "", "the angles are not known"),
        (
            "angle = \"p\"",
            "angles_deg = [0, 180]",
            "the angles are given twice",
        ),
        (
            "angle = \"p\"\nposition = \"p\"",
            "",
            "the angles are given twice",
        ),
        ("position = \"p\"", "", "a position of 0.5"),
        ("angle = \"p\"", "lean_deg = -1", "must not be negative"),
    ] {
        let text = format!(
            "kind = \"single-axis\"\n[recording]\nfile = \"t.csv\"\ncolumn = \"out\"\n{recording}\n[position]\n{position}\n{GRAVITY}"
        );
        let trouble = calibrate(folder.path(), &text).err().unwrap();
        assert!(trouble.to_string().contains(what), "{what}: {trouble}");
    }
}

#[test]
fn known_tumble_calibrates_and_says_how_much_of_it_is_independent() {
    let folder = tempfile::tempdir().unwrap();
    let k = [
        [1.012, 0.011, -0.006],
        [0.0, 0.985, 0.008],
        [0.0, 0.0, 1.021],
    ];
    let sensor = SensorModel::new(Matrix3(k), [0.12, -0.25, 0.31]).unwrap();
    let mut draw = Draw(3);
    let mut sway = [0.0; 3];
    let rows = (0..7500).map(|i| {
        // Two incommensurate turns reach the whole sphere.
        let t = f64::from(i) / 50.0;
        let (a, b) = (0.31 * t, (0.19 * t).sin() * 1.4);
        let up = [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()];
        let output = sensor.invert(std::array::from_fn(|axis| {
            sway[axis] = 0.94 * sway[axis] + 0.02 * draw.next();
            G * up[axis] + sway[axis]
        }));
        let [x, y, z] = output.map(|v| v + 0.03 * draw.next());
        format!("{t:.2},{x:.5},{y:.5},{z:.5}")
    });
    table(
        &folder.path().join("tumble.csv"),
        "t_s,x_m/s2,y_m/s2,z_m/s2",
        rows,
    );
    let body = "kind = \"multi-position\"\n[recording]\nfile = \"tumble.csv\"\ncolumns = { x = \"x\", y = \"y\", z = \"z\" }\n";
    let result = calibrate(
        folder.path(),
        &format!("{body}rows = \"tumble\"\n{GRAVITY}"),
    )
    .unwrap();
    for (name, truth) in [
        ("bias.x", 0.12),
        ("bias.y", -0.25),
        ("bias.z", 0.31),
        ("scale.x", 1.012),
        ("scale.z", 1.021),
        ("misalignment.xy", 0.011 / 1.012),
    ] {
        let [value, _, expanded] = quantity(&result, name);
        assert!(
            (value - truth).abs() < 2.0 * expanded,
            "{name}: {value} ± {expanded}, {truth}"
        );
        assert!(expanded < 0.02, "{name}: {expanded}");
    }
    let calibration = file(&result, "calibration.json");
    assert_eq!(calibration["kind"], "triaxial");
    // Taken for a recording with standstills it is refused, and told what it may be.
    let refused = calibrate(folder.path(), &format!("{body}{GRAVITY}"))
        .err()
        .unwrap();
    assert!(
        format!("{refused:?}").contains("rows = \\\"tumble\\\""),
        "{refused:?}"
    );
}

/// Six hours of a logger with a temperature, five samples a second, at rest in a posture for five minutes each.
fn wrist(path: &Path) {
    let (s, o, c) = (
        [0.990, 1.012, 0.985],
        [-0.020, 0.035, 0.050],
        [0.8e-3, -0.4e-3, 1.2e-3],
    );
    let mut draw = Draw(17);
    let mut text = "t_s,x_g,y_g,z_g,temperature_degC\n".to_owned();
    let mut up = [0.0, 0.0, 1.0];
    for i in 0..6 * 3600 * 5 {
        let t = f64::from(i) / 5.0;
        if i % 1500 == 0 {
            let v: [f64; 3] = std::array::from_fn(|_| draw.next());
            let length = norm(v).max(0.1);
            up = v.map(|v| v / length);
        }
        let temperature = 28.0 + 4.0 * (t / 3400.0).sin();
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| {
            (up[k] / norm(up) - (temperature - 25.0) * c[k]) / s[k] - o[k] + 0.006 * draw.next()
        });
        let _ = writeln!(text, "{t:.1},{x:.5},{y:.5},{z:.5},{temperature:.3}");
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn known_logger_that_was_worn_is_compensated_with_its_own_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrist.csv");
    wrist(&path);
    let body = "kind = \"free-living\"\n[recording]\nfile = \"wrist.csv\"\ncolumns = { x = \"x\", y = \"y\", z = \"z\" }\ntemperature = \"temperature\"\n";
    let result = calibrate(folder.path(), &format!("{body}{GRAVITY}")).unwrap();
    let calibration = file(&result, "calibration.json");
    // ã = K a + b: K = g₀/(s g), b = −o g₀ at 25 °C, followed to the mean temperature.
    let [scale, _, expanded] = quantity(&result, "scale.x");
    assert!((scale - 0.990).abs() < 2.0 * expanded);
    let k = calibration["K"][0][0].as_f64().unwrap();
    assert!((k * scale * G / 9.80665 - 1.0).abs() < 1e-12);
    let (calibration, _) = AnyCalibration::from_source(
        Source::from_bytes("c.json", serde_json::to_vec(&calibration).unwrap()).unwrap(),
    )
    .unwrap();
    let mut job = ApplyJob::default();
    job.temperature = Some(ColumnRef::from_word("temperature"));
    let mut written = Vec::new();
    let data = ApplyData::new(
        &calibration,
        Source::open(&path).unwrap(),
        Destination::Bytes(&mut written),
    );
    job.evaluate(&data, &Unwatched).unwrap();
    drop(data);
    let text = String::from_utf8(written).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        sum += norm([v[1], v[2], v[3]]);
        count += 1.0;
    }
    // Noise of 3.5 mg across lengthens a magnitude by 0.012 mg; the mean of all postures is that of gravity.
    assert!((sum / count / G - 1.0).abs() < 2e-4, "{}", sum / count);

    // Without a place the scale factors in m/s² carry the gravity of anywhere.
    let anywhere = calibrate(folder.path(), body).unwrap();
    let calibration = file(&anywhere, "calibration.json");
    let u = calibration["gravity"]["standard_uncertainty"]
        .as_f64()
        .unwrap();
    assert!((u - 0.03).abs() < 1e-12, "{u}");
}

/// The same samples as raw floats give the same windows; a file that was cut, or of other channels, is refused.
#[test]
fn known_logger_as_raw_floats() {
    let folder = tempfile::tempdir().unwrap();
    wrist(&folder.path().join("wrist.csv"));
    let text = std::fs::read_to_string(folder.path().join("wrist.csv")).unwrap();
    let bytes: Vec<u8> = text
        .lines()
        .skip(1)
        .flat_map(|line| {
            let fields = line.split(',').skip(1);
            let values: Vec<f32> = fields.map(|f| f.parse().unwrap()).collect();
            values.into_iter().flat_map(f32::to_le_bytes)
        })
        .collect();
    std::fs::write(folder.path().join("wrist.f32"), &bytes).unwrap();
    let raw = "kind = \"free-living\"\n[recording]\nfile = \"wrist.f32\"\nformat = \"f32\"\ncolumns = { x = 1, y = 2, z = 3 }\ntemperature = 4\nunit = \"g\"\n";
    let from_floats = calibrate(folder.path(), &format!("{raw}sampling_rate_Hz = 5\n")).unwrap();
    let body = "kind = \"free-living\"\n[recording]\nfile = \"wrist.csv\"\ncolumns = { x = \"x\", y = \"y\", z = \"z\" }\ntemperature = \"temperature\"\n";
    let from_text = calibrate(folder.path(), body).unwrap();
    for name in ["scale.x", "offset.y", "temperature.z"] {
        let [a, u, _] = quantity(&from_floats, name);
        let [b, _, _] = quantity(&from_text, name);
        // Five decimals in the text are eight digits in a float; the uncertainty is far larger.
        assert!((a - b).abs() < 1e-2 * u, "{name}: {a} {b} ± {u}");
    }
    let refused = |text: &str| format!("{:?}", calibrate(folder.path(), text).err().unwrap());
    assert!(
        refused(raw).contains("sampling_rate_Hz"),
        "{}",
        refused(raw)
    );
    let unsaid = refused(&raw.replace("unit = \"g\"\n", "sampling_rate_Hz = 5\n"));
    assert!(unsaid.contains("unit = \\\"g\\\""), "{unsaid}");
    let more = refused(&format!("{raw}sampling_rate_Hz = 5\nchannel_count = 3\n"));
    assert!(more.contains("channel 4 of 3"), "{more}");
    std::fs::write(folder.path().join("wrist.f32"), &bytes[..1003]).unwrap();
    let cut = refused(&format!("{raw}sampling_rate_Hz = 5\n"));
    assert!(cut.contains("1003 bytes"), "{cut}");
}
