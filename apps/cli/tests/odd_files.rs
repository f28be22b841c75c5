//! What a recording does not say is asked for with the option to type, and what was read is told; an example of a kind runs. The
//! table of odd files and readers is `crates/jobs/tests/odd_recordings`.

use crate::support::*;
use std::fmt::Write;

#[test]
fn known_unit_and_clock_are_asked_for_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    let mut rows = "timestamp,ax,ay,az\n".to_owned();
    let mut noise = Chance(5);
    for i in 0..3000 {
        let [x, y, z] = [0, 1, 2].map(|_| 1e-3 * noise.normal());
        writeln!(rows, "{},{x:.6},{y:.6},{:.6}", 10 * i, 1.0 + z).unwrap();
    }
    std::fs::write(&path, rows).unwrap();
    for (command, option) in [
        (&["noise"][..], "--unit g"),
        (&["test", "shock", "--column", "az"], "--unit g"),
        (
            &["test", "random", "--input", "ax", "--output-column", "az"],
            "--output-unit g",
        ),
    ] {
        let asked = refuse(&[command, &[text(&path), "--time-unit", "ms"]].concat());
        assert!(asked.contains(option), "{command:?}: {asked}");
    }
    assert!(refuse(&["noise", text(&path), "--unit", "g"]).contains("--time-unit ms"));
    // Said, file and stream are read alike, and tell it alike.
    let said = [
        "noise",
        text(&path),
        "--unit",
        "g",
        "--time-unit",
        "ms",
        "--json",
    ];
    let [held, stream] = [&[][..], &["--stream"]].map(|more: &[&str]| {
        let output = succeed(&[&said[..], more].concat());
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        result["inputs"][0]["reading"].clone()
    });
    assert_eq!(held["columns"][2]["unit"], "g");
    assert_eq!(held["columns"][2]["unit_by"], "person");
    assert_eq!(held["time"]["unit"], "ms");
    assert_eq!(
        (&held["columns"], &held["time"]["by"]),
        (&stream["columns"], &stream["time"]["by"])
    );
    for reading in [&held, &stream] {
        assert!((reading["time"]["rate_hz"].as_f64().unwrap() - 100.0).abs() < 1e-9);
    }
}

#[test]
fn known_units_are_not_asked_for_beside_one_that_is_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lg.csv");
    let mut rows = "light,ax_g,ay_g,az_g\n".to_owned();
    let mut noise = Chance(6);
    for _ in 0..3000 {
        let [light, x, y, z] = [0, 1, 2, 3].map(|_| 1e-3 * noise.normal());
        writeln!(rows, "{:.6},{x:.6},{y:.6},{:.6}", 0.4 + light, 1.0 + z).unwrap();
    }
    std::fs::write(&path, rows).unwrap();
    let asked = refuse(&["noise", text(&path)]);
    assert!(asked.contains("the unit of light is not said"), "{asked}");
    // What its neighbours are in says nothing of it.
    assert!(asked.contains("add --unit UNIT --rate HZ"), "{asked}");
}

/// Nine to one, or nine and 78394: a table is asked about with options that its command has.
#[test]
fn known_comma_of_a_table_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("amb.csv");
    // Whatever stands behind the comma rises and never begins with a zero.
    let rows: String = (0..12).map(|k| format!("9,{}\n", 78394 + 37 * k)).collect();
    std::fs::write(&path, rows).unwrap();
    let columns = ["--output-column", "2", "--output-unit", "V"];
    for (test, input) in [
        ("linearity", "--acceleration"),
        ("tilt", "--angle"),
        ("sensitivity", "--position"),
        ("centrifuge", "--speed"),
    ] {
        let radius = ["--radius", "0.1"];
        let radius = if test == "centrifuge" {
            &radius[..]
        } else {
            &[]
        };
        let head = ["test", test, text(&path), input, "1"];
        let asked = refuse(&[&head, &columns[..], radius].concat());
        assert!(asked.contains("--separator comma"), "{test}: {asked}");
        assert!(!asked.contains('`'), "{test}: {asked}");
        // As two columns it is read, and as one there is no second.
        let comma = refuse(&[&head, &columns[..], radius, &["--separator", "comma"]].concat());
        assert!(!comma.contains("decimal mark"), "{test}: {comma}");
        let one = refuse(&[&head, &columns[..], radius, &["--decimal", "comma"]].concat());
        assert!(one.contains("there is no column 2"), "{test}: {one}");
    }
    let levels = [
        "test",
        "levels",
        text(&path),
        "--level",
        "1",
        "--output-column",
        "2",
    ];
    let asked = refuse(&[&levels[..], &["--output-u", "2"]].concat());
    assert!(asked.contains("--separator comma"), "{asked}");
}

#[test]
fn known_example_of_a_kind_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("example");
    let said = stderr(&succeed(&[
        "init",
        "--kind",
        "shaker-single",
        "-o",
        text(&place),
    ]));
    assert!(said.contains("proofmass calibrate"), "{said}");
    succeed(&["calibrate", text(&place)]);
    let result = json(&place.join("result/result.json"));
    // 10 mV/(m/s²) behind a reference that reads 10.2 mV/(m/s²).
    let (value, _, expanded) = quantity(&result, "S.modulus[frequency=160]");
    assert!((value - 0.01).abs() < expanded, "{value} ± {expanded}");
    // The command that is printed runs, whatever the kind.
    for kind in proofmass::jobs::campaign::KINDS {
        let place = folder.path().join(kind);
        succeed(&["init", "--kind", kind, "-o", text(&place)]);
        succeed(&["calibrate", text(&place)]);
    }
    let wrong = proofmass(&["init", "--kind", "shaker", "-o", text(&place)]);
    assert_eq!(wrong.status.code(), Some(2));
}

/// Marks of thousands and marks of decimals look alike: counts of which both may be meant are asked for, others are read.
#[test]
fn marks_of_thousands_are_not_taken_for_decimals() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, heading: &str, row: &dyn Fn(usize) -> String| {
        let rows: String = (0..400).map(|k| row(k) + "\n").collect();
        let path = folder.path().join(name);
        std::fs::write(&path, format!("{heading}\n{rows}")).unwrap();
        text(&path).to_owned()
    };
    let counts = "time_ms;ax_count;ay_count;az_count";
    let thousands = file("thousands.csv", counts, &|k| {
        format!("{};37,{:03};33,{:03};995", 10 * k, k % 7 + 100, k % 5)
    });
    let german = file("german.csv", counts, &|k| {
        format!(
            "{};37.{:03};33.{:03};32.{:03}",
            10 * k,
            k % 7 + 100,
            k % 5,
            k % 3
        )
    });
    for file in [&thousands, &german] {
        for command in [
            &["calibrate", file, "--latitude", "45", "--height", "100"][..],
            &["noise", file],
            &["convert", file, "-o", "converted.npy"],
        ] {
            let said = refuse(command);
            assert!(
                said.contains("may be 37100") && said.contains("marks of thousands"),
                "{said}"
            );
        }
        let inspected = succeed(&["inspect", file, "--json"]);
        let inspected = String::from_utf8(inspected.stdout).unwrap();
        assert!(inspected.contains("thousands-suspected"), "{inspected}");
    }
    // Decimals below one, or more or fewer than three of them, are decimals.
    for (name, value) in [("one", "0,012"), ("four", "37,1234"), ("long", "33120,181")] {
        let decimals = file(name, counts, &|k| {
            format!("{};{value};33,{:03};1,5", 10 * k, k % 5)
        });
        let inspected = succeed(&[
            "inspect",
            &decimals,
            "--columns",
            "ax_count,az_count",
            "--json",
        ]);
        let inspected = String::from_utf8(inspected.stdout).unwrap();
        assert!(
            !inspected.contains("thousands-suspected"),
            "{name}: {inspected}"
        );
    }
}
