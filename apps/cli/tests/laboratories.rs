//! Tables of laboratories, held against each other on the command line.

use crate::support::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A table in the unit of the device, the sensitivities times a factor.
fn table(folder: &Path, name: &str, unit: &str, factor: f64) -> PathBuf {
    let path = folder.join(name);
    let mut lines =
        format!("frequency_Hz,sensitivity_{unit},phase_deg,u_sensitivity_{unit},U_phase_deg,k\n");
    for k in 0..12 {
        let f = 10.0 * 1.4f64.powi(k);
        let s = factor * (1.0 + 1e-4 * f64::from(k % 3));
        writeln!(lines, "{f:.3},{s},{},{},0.4,2", -0.01 * f, 0.002 * factor).unwrap();
    }
    std::fs::write(&path, lines).unwrap();
    path
}

#[test]
fn known_table_of_a_device_that_gives_acceleration() {
    let folder = tempfile::tempdir().unwrap();
    let list = [
        table(folder.path(), "one.csv", "m/s2/(m/s2)", 1.0),
        table(folder.path(), "two.csv", "g/g", 1.001),
        table(folder.path(), "three.csv", "mg/g", 999.0),
    ];
    let out = folder.path().join("out");
    let paths: Vec<&str> = list.iter().map(|p| text(p)).collect();
    let arguments = [&["compare"], &paths[..], &["-o", text(&out)]].concat();
    succeed(&arguments);
    let result = json(&out.join("result.json"));
    assert_eq!(
        result["findings"].as_array().map(Vec::len),
        Some(0),
        "{result}"
    );
    let first = &rows(&out.join("reference.csv"))[0];
    let heading = first.iter().find(|(h, _)| h.starts_with("mean_modulus"));
    let mean = number(first, &heading.expect("a mean").0);
    assert!((mean - 1.0).abs() < 1e-5, "{mean}");
    // 0.2 % of each: 0.2 %/√3.
    let u = number(first, "u_mean_modulus_percent");
    assert!((u / 0.2 * 3f64.sqrt() - 1.0).abs() < 2e-3, "{u}");
    assert!(out.join("reference.csv").exists() && out.join("equivalence.csv").exists());
    let before = std::fs::read(out.join("report.html")).unwrap();
    succeed(&["render", text(&out)]);
    assert_eq!(before, std::fs::read(out.join("report.html")).unwrap());

    let off = table(folder.path(), "off.csv", "m/s2/(m/s2)", 1.03);
    let arguments = [&["compare", text(&off)], &paths[..], &["--json"]].concat();
    let result: serde_json::Value =
        serde_json::from_slice(&succeed(&arguments).stdout).expect("a result");
    let finding = &result["findings"][0];
    assert_eq!(finding["code"], "calibrations-differ", "{finding}");
    assert!(finding.to_string().contains("off.csv: at"), "{finding}");
    let arguments = [&["compare", text(&off)], &paths[..], &["--strict"]].concat();
    assert_eq!(proofmass(&arguments).status.code(), Some(3));
}

#[test]
fn refuses_tables_that_cannot_be_compared() {
    let folder = tempfile::tempdir().unwrap();
    let one = table(folder.path(), "one.csv", "m/s2/(m/s2)", 1.0);
    let three = table(folder.path(), "three.csv", "m/s2/(m/s2)", 1.001);
    let volts = table(folder.path(), "volts.csv", "mV/g", 100.0);
    let said = refuse(&["compare", text(&one), text(&volts)]);
    assert!(said.contains("volts.csv in V/(m/s²)"), "{said}");
    let write = |name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    };
    for (name, content, expected) in [
        ("empty.csv", "", "empty"),
        (
            "bare.csv",
            "frequency_Hz,sensitivity\n1,1\n",
            "does not say the unit",
        ),
        (
            "none.csv",
            "frequency_Hz,sensitivity_g/g\n1,1\n",
            "u_relative_",
        ),
        (
            "twice.csv",
            "frequency_Hz,sensitivity_g/g,u_relative_%,u_sensitivity_g/g\n1,1,1,1\n",
            "stands twice",
        ),
        (
            "other.csv",
            "frequency_Hz,sensitivity_g/g,u_sensitivity_V/g\n1,1,1\n",
            "no such column",
        ),
        (
            "both.csv",
            "frequency_Hz,sensitivity_g/g,sensitivity_V/g,u_relative_%\n1,1,1,1\n",
            "two columns",
        ),
        (
            "factor.csv",
            "frequency_Hz,sensitivity_g/g,U_relative_%\n1,1,1\n",
            "coverage factor",
        ),
        (
            "huge.csv",
            "frequency_Hz,sensitivity_g/g,u_sensitivity_g/g\n1,1,2\n",
            "more than half",
        ),
        (
            "nan.csv",
            "frequency_Hz,sensitivity_g/g,u_relative_%\n1,nan,2\n",
            "not a finite number",
        ),
        (
            "exact.csv",
            "frequency_Hz,sensitivity_g/g,phase_deg,u_relative_%,u_phase_deg\n10,1,0,0,0.1\n",
            "states no uncertainty of modulus or phase at 10 Hz",
        ),
        (
            "without.csv",
            "frequency_Hz,sensitivity_g/g,u_relative_%\n10,1,1\n100,1,1\n",
            "states no phase",
        ),
    ] {
        let bad = write(name, content);
        let said = refuse(&["compare", text(&one), text(&bad), text(&three)]);
        assert!(said.contains(expected), "{name}: {said}");
    }
    // Of two, moduli alone are compared; phases of the other are left aside.
    let moduli = |name: &str, shift: f64| {
        let rows = (1..=12).map(|k| format!("{},{},1\n", 10 * k, 1.0 + shift));
        let rows: String = rows.collect();
        write(
            name,
            &format!("frequency_Hz,sensitivity_g/g,u_relative_%\n{rows}"),
        )
    };
    let [a, b, c] =
        [("moduli.csv", 0.0), ("near.csv", 0.01), ("far.csv", 0.04)].map(|(n, s)| moduli(n, s));
    for (other, differ) in [(&b, false), (&c, true)] {
        let out = folder.path().join("moduli");
        let all = [
            "compare",
            text(&a),
            text(other),
            "-o",
            text(&out),
            "--force",
        ];
        let said = String::from_utf8_lossy(&succeed(&all).stdout).into_owned();
        assert_eq!(said.contains("calibrations-differ"), differ, "{said}");
        assert!(
            said.contains("moduli alone are compared")
                && !said.contains("difference of the phases"),
            "{said}"
        );
        assert!(said.contains("phase-not-stated"), "{said}");
        let table = std::fs::read_to_string(out.join("comparison.csv")).unwrap();
        assert!(
            !table.contains("phase") && table.lines().count() == 13,
            "{table}"
        );
    }
    let copy = folder.path().join("copy.csv");
    std::fs::copy(&one, &copy).unwrap();
    let said = refuse(&["compare", text(&one), text(&three), text(&copy)]);
    assert!(said.contains("the same file"), "{said}");
    let alone = proofmass(&["compare", text(&one)]);
    assert_eq!(alone.status.code(), Some(2));
    assert!(stderr(&alone).contains("2 values required"));
}

/// Rows of one frequency are repeats; a device of acceleration at 17 frequencies, ten times each.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_table_of_an_mpu9250_and_a_second_laboratory() {
    let theirs = reference_data().join("mpu9250-round-robin/MPU9250_PTB.csv");
    let content = std::fs::read_to_string(theirs).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut lists = [String::new(), String::new()];
    for (list, factor) in lists.iter_mut().zip([1.0, 0.997]) {
        *list = "frequency_Hz,sensitivity_m/s2/(m/s2),u_sensitivity_m/s2/(m/s2),phase_rad,u_phase_rad\n"
            .to_owned();
        for line in content.lines().skip(1) {
            let f: Vec<&str> = line.split(',').collect();
            let value: f64 = f[2].parse().unwrap();
            writeln!(
                list,
                "{},{},{},{},{}",
                f[1],
                factor * value,
                f[3],
                f[5],
                f[6]
            )
            .unwrap();
        }
    }
    let paths = ["ptb.csv", "other.csv"].map(|name| folder.path().join(name));
    for (path, list) in paths.iter().zip(&lists) {
        std::fs::write(path, list).unwrap();
    }
    let out = folder.path().join("out");
    succeed(&[
        "compare",
        text(&paths[0]),
        text(&paths[1]),
        "-o",
        text(&out),
    ]);
    let result = json(&out.join("result.json"));
    let codes = codes(&result);
    assert!(
        codes.iter().any(|c| c == "calibrations-differ"),
        "{codes:?}"
    );
    assert!(codes.iter().any(|c| c == "repeats-averaged"), "{codes:?}");
    let table = rows(&out.join("comparison.csv"));
    for (frequency, expected) in MPU9250_MEANS {
        let found = table
            .iter()
            .find(|r| number(r, "frequency_Hz") == frequency);
        let row = found.expect("the frequency");
        let value = number(row, "modulus_first_(m/s²)/(m/s²)");
        assert!((value - expected).abs() < 6e-6, "{frequency}: {value}");
    }
}
