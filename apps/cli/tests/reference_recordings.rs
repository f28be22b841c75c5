//! Recordings that others made, through the command line, against published and independent values.

use crate::support::*;
use std::path::Path;

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_xsens_against_an_independent_refit() {
    let data = reference_data();
    let folder = tempfile::tempdir().unwrap();
    let toml = format!(
        "kind = \"multi-position\"\n[recording]\nfile = {:?}\ncolumns = {{ x = 2, y = 3, z = 4 }}\ntime = 1\n\
         time_unit = \"s\"\nunit = \"count\"\n[gravity]\nvalue = 9.81744\nstandard_uncertainty = 1e-4\n",
        text(&data.join("xsens-mti/xsens_acc.txt"))
    );
    campaign(folder.path(), &toml);
    succeed(&["calibrate", text(folder.path())]);
    let result = json(&folder.path().join("result/result.json"));
    // 0.02 % and 2 counts were asked for; two evaluations of the same 38 rests agree ten times better.
    for (name, expected) in [
        ("scale.x", 414.42),
        ("scale.y", 412.03),
        ("scale.z", 414.62),
    ] {
        assert!(
            (quantity(&result, name).0 / expected - 1.0).abs() < 2e-5,
            "{name}"
        );
    }
    for (name, expected) in [
        ("bias.x", 33123.9),
        ("bias.y", 33275.2),
        ("bias.z", 32364.5),
    ] {
        assert!((quantity(&result, name).0 - expected).abs() < 0.2, "{name}");
    }
    let fit = &result["extra"]["fit"];
    assert!((fit["residual_rms_m_per_s2"].as_f64().unwrap() - 1.0e-3).abs() < 5e-5);
    assert_eq!(result["extra"]["standstills"].as_array().unwrap().len(), 38);
}

/// [Ferraris1995] form of the six rests of the session, to every printed digit.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_ferraris_session() {
    let data = reference_data();
    let file = data.join("ferraris-imu/annotated_session.csv");
    let folder = tempfile::tempdir().unwrap();
    let parts: Vec<String> = std::fs::read_to_string(&file)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| line.split(',').next().unwrap().to_owned())
        .collect();
    let mut segments = "start,end,direction\n".to_owned();
    for (part, direction) in [
        ("x_p", "+x"),
        ("x_a", "-x"),
        ("y_p", "+y"),
        ("y_a", "-y"),
        ("z_p", "+z"),
        ("z_a", "-z"),
    ] {
        let start = parts.iter().position(|p| p == part).unwrap();
        let end = parts.iter().rposition(|p| p == part).unwrap() + 1;
        segments += &format!("{start},{end},{direction}\n");
    }
    let toml = format!(
        "kind = \"multi-position\"\n[recording]\nfile = {:?}\ncolumns = {{ x = \"acc_x\", y = \"acc_y\", z = \"acc_z\" }}\n\
         sampling_rate_Hz = 100\nunit = \"count\"\n[gravity]\nvalue = 9.81\nstandard_uncertainty = 1e-3\n\
         [standstill]\nsegments = \"segments.csv\"\n[method]\nmodel = \"ferraris\"\n[attitude]\nstandard_uncertainty_deg = 1\n",
        text(&file)
    );
    campaign(folder.path(), &toml);
    std::fs::write(folder.path().join("segments.csv"), segments).unwrap();
    succeed(&["calibrate", text(folder.path())]);
    let fit = &json(&folder.path().join("result/result.json"))["extra"]["fit"];
    let close = |got: &serde_json::Value, expected: f64, digit: f64| {
        let got = got.as_f64().unwrap();
        // The printed digits are cut, not rounded: R_a[0][2] is −0.01114566.
        assert!((got - expected).abs() < digit, "{got} against {expected}");
    };
    let k = [208.54567, 208.00113, 214.78455];
    let b = [-6.01887, -48.28787, -28.96637];
    let r = [
        [0.9999125, 0.0071221, -0.0111456],
        [-0.0079474, 0.9996887, 0.0236489],
        [0.0213429, -0.0107819, 0.9997141],
    ];
    for i in 0..3 {
        close(&fit["ferraris"]["scale"][i], k[i], 1e-5);
        close(&fit["b"][i], b[i], 1e-5);
        for j in 0..3 {
            close(&fit["ferraris"]["directions"][i][j], r[i][j], 1e-7);
        }
    }
}

/// Recordings of any other shape are at least described.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn known_shapes_of_recordings_of_others() {
    let data = reference_data();
    for (name, rows, columns) in [
        ("xsens-mti/xsens_acc.txt", 51175, 4),
        ("mikov-mpu9150/imu0.log", 15969, 6),
        ("ferraris-imu/annotated_session.csv", 9414, 8),
        ("icm42652-temperature/sample.csv", 100_000, 5),
        ("hammer-frf/measurements_1.csv", 25600, 3),
    ] {
        let output = succeed(&["inspect", "--json", text(&data.join(Path::new(name)))]);
        let inspection: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(inspection["rows"], rows, "{name}");
        assert_eq!(
            inspection["columns"].as_array().unwrap().len(),
            columns,
            "{name}"
        );
    }
}
