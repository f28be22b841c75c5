//! `proofmass convert` through its own door: files, provenance, refusals that leave nothing.

use crate::support::*;
use proofmass::io::{Input, Provenance};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn recording(folder: &Path) -> PathBuf {
    let mut rows = "time_s,a_g,b_count\n".to_owned();
    for i in 0..500 {
        rows += &format!(
            "{:.2},{},{}\n",
            f64::from(i) / 100.0,
            0.1 * f64::from(i),
            i % 7
        );
    }
    let path = folder.join("raw.csv");
    fs::write(&path, rows).unwrap();
    path
}

#[test]
fn known_what_is_told_and_what_stands_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path());
    let file = folder.path().join("out.npy");
    let said = stderr(&succeed(&[
        "convert",
        text(&raw),
        "-o",
        text(&file),
        "--without-units",
    ]));
    let lines: Vec<&str> = said.lines().collect();
    assert!(
        lines[0].ends_with(
            "raw.csv: columns 2 a in g by the heading, 3 b in count by the heading; \
             100 Hz by column 1 time in s by the heading"
        ) && lines[0].starts_with("read: "),
        "{said}"
    );
    assert!(
        lines[1].starts_with("written: ")
            && lines[1].ends_with("out.npy (500 rows of 3 columns, npy, double precision)"),
        "{said}"
    );
    assert_eq!(
        lines[2..],
        ["lost: names and units: column 1 is time in s, 2 is a in g, 3 is b in count"]
    );
    let digest = Input::of(&file).unwrap().sha256;
    let provenance = Provenance::of(&file).unwrap().unwrap();
    assert_eq!(provenance.sha256, digest);
    assert_eq!(
        names(folder.path()),
        ["out.npy", "out.npy.provenance.json", "raw.csv"]
    );
    succeed(&["verify", text(&file)]);
    // What this program wrote may be replaced, what was changed since may not.
    succeed(&["convert", text(&raw), "-o", text(&file), "--without-units"]);
    fs::write(&file, "mine").unwrap();
    let told = refuse(&["convert", text(&raw), "-o", text(&file), "--without-units"]);
    assert!(told.contains("--force"), "{told}");
    assert_eq!(fs::read(&file).unwrap(), b"mine");
    succeed(&[
        "convert",
        text(&raw),
        "-o",
        text(&file),
        "--without-units",
        "--force",
    ]);
    assert_eq!(Input::of(&file).unwrap().sha256, digest);
    // The recording was changed since.
    fs::write(&raw, "time_s,a_g\n0,1\n1,2\n").unwrap();
    assert_ne!(proofmass(&["verify", text(&file)]).status.code(), Some(0));
}

#[test]
fn law_a_signature_and_several_inputs_stand_in_the_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path());
    let later = folder.path().join("later.csv");
    fs::write(&later, "time_s,a_g,b_count\n5.00,1,2\n5.01,2,3\n").unwrap();
    succeed(&["keygen", text(&folder.path().join("lab"))]);
    let key = folder.path().join("lab.key");
    let file = folder.path().join("out.uff");
    succeed(&[
        "convert",
        text(&raw),
        text(&later),
        "-o",
        text(&file),
        "--sign",
        text(&key),
    ]);
    let provenance = Provenance::of(&file).unwrap().unwrap();
    assert!(provenance.signature.is_some());
    let statement = provenance.statement();
    for input in [&raw, &later] {
        assert!(statement.contains(&Input::of(input).unwrap().sha256));
    }
    let said = stderr(&succeed(&[
        "convert",
        text(&file),
        "-o",
        "-",
        "--to",
        "csv",
    ]));
    assert!(said.contains("502 rows of 3 columns, CSV"), "{said}");
}

#[test]
fn refuses_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let raw = recording(folder.path());
    let gapped = folder.path().join("gapped.csv");
    let rows = fs::read_to_string(&raw).unwrap();
    let kept: Vec<&str> = rows.lines().filter(|l| !l.starts_with("2.")).collect();
    fs::write(&gapped, kept.join("\n")).unwrap();
    let before = names(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (raw, gapped) = (text(&raw), text(&gapped));
    for (arguments, said) in [
        (vec![raw, "-o", &at("x.wav")], "--without-units"),
        (
            vec![raw, "-o", &at("x.dat")],
            "--to csv, npy, wav, uff or parquet",
        ),
        (vec![gapped, "-o", &at("x.uff")], "--gaps hold"),
        (
            vec![gapped, "-o", &at("x.csv"), "--gaps", "close"],
            "no gap has to be closed",
        ),
        (
            vec![raw, raw, "-o", &at("x.csv")],
            "name the recordings in the order of their times",
        ),
        (
            vec!["-", "-o", &at("x.csv")],
            "standard input can be read only once",
        ),
        (vec![raw, "-o", raw], "is the input itself"),
        (vec![raw, "-o", raw, "--force"], "is the input itself"),
        (
            vec![
                raw,
                "-o",
                &at("x.wav"),
                "--without-units",
                "--wav-form",
                "int16",
            ],
            "cannot be held in the form of the WAV file",
        ),
        (
            vec![raw, "-o", &at("no/folder/x.csv")],
            "no such file or folder",
        ),
        (vec![&at("absent.csv"), "-o", &at("x.csv")], "no such file"),
    ] {
        let told = refuse(&[&["convert"], &arguments[..]].concat());
        assert!(told.contains(said), "{arguments:?}: {told}");
        assert_eq!(names(folder.path()), before, "{arguments:?}");
    }
}

#[test]
#[cfg(unix)]
fn law_a_conversion_that_is_ended_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let raw = folder.path().join("raw.csv");
    let row = |i: u32| format!("{:.3},{}.25,{}\n", f64::from(i) / 1000.0, i % 911, i % 13);
    let rows: String = (0..600_000).map(row).collect();
    fs::write(&raw, format!("time_s,a_g,b_g\n{rows}")).unwrap();
    let file = folder.path().join("out.csv");
    for late in [5, 40, 120, 300] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_proofmass"))
            .args(["convert", text(&raw), "-o", text(&file)])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(late));
        child.kill().unwrap();
        child.wait().unwrap();
        if file.exists() {
            let provenance = Provenance::of(&file).unwrap().unwrap();
            assert!(provenance.wrote(&Input::of(&file).unwrap().sha256));
        }
    }
    succeed(&["convert", text(&raw), "-o", text(&file)]);
    assert_eq!(
        names(folder.path()),
        ["out.csv", "out.csv.provenance.json", "raw.csv"]
    );
}

/// A name with a star stands for several columns; a picture of them is a page.
#[test]
fn known_patterns_of_columns_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let raw = folder.path().join("raw.csv");
    let mut rows = "time_s,gyro_x_rad/s,acc_x_g,acc_y_g,Acc_z_g\n".to_owned();
    for i in 0..5000 {
        let peak = if i == 3210 { 7.5 } else { 0.0 };
        rows += &format!(
            "{},0.1,{},0.5,{peak}\n",
            f64::from(i) / 100.0,
            (f64::from(i) * 0.01).sin()
        );
    }
    fs::write(&raw, rows).unwrap();
    let out = folder.path().join("out.csv");
    succeed(&["convert", text(&raw), "-o", text(&out), "--columns", "acc*"]);
    let first = fs::read_to_string(&out).unwrap();
    assert_eq!(first.lines().next(), Some("time_s,acc_x_g,acc_y_g,Acc_z_g"));
    let none = refuse(&["inspect", text(&raw), "--columns", "mag*"]);
    assert!(
        none.contains("column \"mag*\"") && none.contains("acc_x_g"),
        "{none}"
    );
    let page = folder.path().join("raw.html");
    let plot = |columns| {
        [
            "inspect",
            text(&raw),
            "--plot",
            text(&page),
            "--columns",
            columns,
        ]
    };
    refuse(&plot("*acc_?,acc_*"));
    assert!(!page.exists());
    let plot = plot("acc_*");
    succeed(&plot);
    let html = fs::read_to_string(&page).unwrap();
    assert!(
        html.contains("<svg") && html.contains("7.5"),
        "{}",
        html.len()
    );
    let there = refuse(&plot);
    assert!(there.contains("--force"), "{there}");
    succeed(&[&plot[..], &["--force"]].concat());
}
