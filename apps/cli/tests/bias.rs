//! `proofmass bias` on simulated recordings: with a noise result, stated noise, tables of rests, and what it refuses.

use crate::support::*;
use std::fmt::Write;
use std::path::Path;

/// Noise that needs no library: a sum of twelve uniform numbers.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1u64 << 53) as f64;
        }
        sum
    }
}

const WHITE: f64 = 1e-3;
const WALK: f64 = 1e-4;
const RATE: f64 = 20.0;

/// `minutes` at 20 Hz with z up; between rests of five seconds every thirty it moves, unless it only rests. The true bias
/// at the end.
fn write_recording(path: &Path, minutes: u32, moves: bool, seed: u64) -> [f64; 3] {
    let mut noise = Noise(seed);
    let mut bias = [0.02, -0.01, 0.03];
    let mut text = String::from("time_s,a_x_m/s2,a_y_m/s2,a_z_m/s2\n");
    for i in 0..minutes * 60 * RATE as u32 {
        let t = f64::from(i) / RATE;
        let rests = !moves || t % 30.0 < 5.0;
        let _ = write!(text, "{t:.3}");
        for (axis, bias) in bias.iter_mut().enumerate() {
            *bias += WALK / RATE.sqrt() * noise.next();
            let motion = if rests {
                0.0
            } else {
                2.0 * (1.7 * t + axis as f64).sin()
            };
            let known = if axis == 2 { 9.80665 } else { 0.0 };
            let read = known + *bias + motion + WHITE * RATE.sqrt() * noise.next();
            let _ = write!(text, ",{read:.6}");
        }
        text.push('\n');
    }
    std::fs::write(path, text).unwrap();
    bias
}

const COLUMNS: [&str; 2] = ["--columns", "a_x,a_y,a_z"];
const STATED: [&str; 6] = [
    "--white",
    "1e-3",
    "--walk",
    "1e-4",
    "--gravity-uncertainty",
    "0",
];

/// From the recording of the noise to the bias of another recording, and the same files again.
#[test]
fn known_bias_with_the_noise_of_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_recording(&path("rest.csv"), 25, false, 3);
    let truth = write_recording(&path("moving.csv"), 5, true, 4);
    let (rest, noise) = (path("rest.csv"), path("noise"));
    succeed(&["noise", text(&rest), "-o", text(&noise)]);
    let result = noise.join("result.json");
    let (moving, out) = (path("moving.csv"), path("bias"));
    let mut words = vec![
        "bias",
        text(&moving),
        "--noise",
        text(&result),
        "--up",
        "+z",
    ];
    words.extend(COLUMNS);
    words.extend([
        "--gravity",
        "9.80665",
        "--gravity-uncertainty",
        "0",
        "-o",
        text(&out),
    ]);
    succeed(&words);
    let written = json(&out.join("result.json"));
    let gravity = &written["inputs"][0]["reading"]["gravity"];
    assert_eq!(gravity["by"], "as stated", "{}", written["inputs"]);
    for (name, truth) in ["bias.x", "bias.y", "bias.z"].into_iter().zip(truth) {
        let (value, u, _) = quantity(&written, name);
        // The bias walks by 1e-4 √25 s between the last rest and the end.
        assert!(
            (value - truth).abs() < 4.0 * u && u < 1.5e-3 && u > 5e-4,
            "{name} {value} {truth} {u}"
        );
    }
    let codes: Vec<&str> = written["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["code"].as_str().unwrap())
        .collect();
    assert!(
        !codes
            .iter()
            .any(|c| c.starts_with("innovations") || c.starts_with("rest-")),
        "{codes:?}"
    );
    assert_eq!(written["inputs"].as_array().unwrap().len(), 2);
    assert!(
        holds_only(
            &out,
            &[
                "bias.csv",
                "innovations.csv",
                "manifest.json",
                "quantities.csv",
                "report.html",
                "result.json",
            ]
        ),
        "{:?}",
        names(&out)
    );
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let again = path("again");
    succeed(&["render", text(&out.join("result.json")), "-o", text(&again)]);
    assert_eq!(
        page,
        std::fs::read_to_string(again.join("report.html")).unwrap()
    );
    // φ of a walk is one; Q and R at 20 Hz are K²/20 and 20 N², as the analysis found K and N.
    let filter = &written["extra"]["bias_filter"];
    assert_eq!(filter["coefficients"][0][0].as_f64(), Some(1.0));
    let r = filter["coefficients"][0][2].as_f64().unwrap();
    assert!((r / (RATE * WHITE * WHITE) - 1.0).abs() < 0.1, "{r}");
}

#[test]
fn known_attitudes_from_a_table_and_turned_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // Turned from z up to x up after a minute and a half.
    let mut noise = Noise(9);
    let mut text_of = String::from("time_s,a_x_m/s2,a_y_m/s2,a_z_m/s2\n");
    for i in 0..3600 {
        let t = f64::from(i) / RATE;
        let known = if t < 90.0 {
            [0.0, 0.0, 9.80665]
        } else {
            [9.80665, 0.0, 0.0]
        };
        let motion = if t % 30.0 < 10.0 {
            0.0
        } else {
            3.0 * (2.1 * t).sin()
        };
        let _ = write!(text_of, "{t:.3}");
        for (known, bias) in known.into_iter().zip([0.02, -0.01, 0.03]) {
            let _ = write!(
                text_of,
                ",{:.6}",
                known + bias + motion + WHITE * RATE.sqrt() * noise.next()
            );
        }
        text_of.push('\n');
    }
    let recording = path("turned.csv");
    std::fs::write(&recording, text_of).unwrap();
    let mut table = String::from("start_s,end_s,direction\n");
    for k in 0..6 {
        let _ = writeln!(
            table,
            "{},{},{}",
            30 * k,
            30 * k + 10,
            if k < 3 { "+z" } else { "+x" }
        );
    }
    std::fs::write(path("rests.csv"), table).unwrap();
    let rests = path("rests.csv");
    let mut words = vec![
        "bias",
        text(&recording),
        "--segments",
        text(&rests),
        "--json",
    ];
    words.extend(COLUMNS);
    words.extend(STATED);
    let said = succeed(&words);
    let written: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    for (name, truth) in [("bias.x", 0.02), ("bias.y", -0.01), ("bias.z", 0.03)] {
        let (value, u, _) = quantity(&written, name);
        assert!((value - truth).abs() < 4.0 * u, "{name} {value} {u}");
    }
    // The same with one attitude for all: the turned rests are no bias, and --strict stops.
    let mut words = vec!["bias", text(&recording), "--up", "0,0,1", "--strict"];
    words.extend(COLUMNS);
    words.extend(STATED);
    let output = proofmass(&words);
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("was the sensor turned"), "{said}");
}

#[test]
fn refuses_what_it_cannot_know() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("moving.csv");
    write_recording(&recording, 2, true, 5);
    let with = |more: &[&str]| -> String {
        let mut words = vec!["bias", text(&recording)];
        words.extend(COLUMNS);
        words.extend(more);
        refuse(&words)
    };
    assert!(with(&STATED).contains("attitude of rest 1 is not known"));
    // Wrong use is told by the reader of the arguments.
    for (wrong, word) in [
        (&["--white", "1e-3", "--up", "+z"][..], "--walk"),
        (
            &["--white", "1e-3", "--walk", "1e-4", "--up", "sideways"],
            "+x",
        ),
        (
            &["--white", "1e-3", "--markov", "1,0", "--up", "+z"],
            "positive",
        ),
        (&["--up", "+z"], "--noise"),
    ] {
        let mut words = vec!["bias", text(&recording)];
        words.extend(COLUMNS);
        words.extend(wrong);
        let output = proofmass(&words);
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        let said = stderr(&output);
        assert!(said.contains(word), "{wrong:?}: {said}");
    }
    let other = folder.path().join("other.json");
    std::fs::write(&other, "{}").unwrap();
    let refused = with(&["--noise", text(&other), "--up", "+z"]);
    assert!(refused.contains("other.json"), "{refused}");
    // Zero motion on readings that hold gravity: the rests are not what is stated.
    let mut words = vec![
        "bias",
        text(&recording),
        "--up",
        "none",
        "--initial",
        "0.1",
        "--strict",
    ];
    words.extend(COLUMNS);
    words.extend(STATED);
    assert_eq!(proofmass(&words).status.code(), Some(3));
    // Volts are no acceleration.
    let volts = folder.path().join("volts.csv");
    std::fs::write(&volts, "x_V,y_V,z_V\n1,2,3\n1,2,3\n").unwrap();
    let mut words = vec![
        "bias",
        text(&volts),
        "--columns",
        "x,y,z",
        "--rate",
        "10",
        "--up",
        "+z",
    ];
    words.extend(STATED);
    assert!(refuse(&words).contains("no acceleration"));
}
