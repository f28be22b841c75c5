//! `proofmass calibrate` on hand-held recordings at several temperatures: one calibration K(T), b(T), applied and exported.

use crate::support::*;
use std::fmt::Write;
use std::path::Path;

const G: f64 = 9.80665;

fn direction(chance: &mut Chance) -> [f64; 3] {
    let v = [chance.normal(), chance.normal(), chance.normal()];
    let size = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / size)
}

/// Scale 1.01, 0.99, 1.004; biases 0.1, −0.2, 0.05 m/s² at 25 °C with 1, −0.5 and 0.4 mg/K; scales with 200, −100 and 50 ppm/K.
fn output(a: [f64; 3], t: f64) -> [f64; 3] {
    let d = t - 25.0;
    let scale = [1.01, 0.99, 1.004];
    let bias = [0.1, -0.2, 0.05];
    let slope = [1e-3 * G, -0.5e-3 * G, 0.4e-3 * G];
    let change = [2e-4, -1e-4, 0.5e-4];
    std::array::from_fn(|i| bias[i] + slope[i] * d + scale[i] * (1.0 + change[i] * d) * a[i])
}

/// Eighteen attitudes of three seconds at 100 Hz, moved by hand between them.
fn hand_held(path: &Path, temperature: f64, seed: u64) {
    let mut chance = Chance(seed);
    let mut rows = String::from("t_s,x_m/s2,y_m/s2,z_m/s2,temp_degC\n");
    let mut sample = 0;
    let mut before = direction(&mut chance);
    for _ in 0..18 {
        let next = direction(&mut chance);
        for i in 0..400 {
            let share = (f64::from(i) / 100.0).min(1.0);
            let moving = share < 1.0;
            let mixed: [f64; 3] =
                std::array::from_fn(|k| before[k] * (1.0 - share) + next[k] * share);
            let size = mixed.iter().map(|c| c * c).sum::<f64>().sqrt().max(0.1);
            let shake = if moving { 1.5 } else { 0.0 };
            let a = mixed.map(|c| G * c / size + shake * chance.normal());
            let t = temperature + 0.3 * (f64::from(sample) / 7200.0);
            let [x, y, z] = output(a, t).map(|v| v + 0.01 * chance.normal());
            let _ = writeln!(
                rows,
                "{:.2},{x:.5},{y:.5},{z:.5},{:.3}",
                f64::from(sample) / 100.0,
                t + 0.01 * chance.normal()
            );
            sample += 1;
        }
        before = next;
    }
    std::fs::write(path, rows).unwrap();
}

fn campaign(terms: &str) -> String {
    format!(
        "kind = \"multi-position\"\n\
         [recording]\nfiles = [\"cold.csv\", \"room.csv\", \"hot.csv\"]\n\
         columns = {{ x = \"x_m/s2\", y = \"y_m/s2\", z = \"z_m/s2\" }}\ntime = \"t_s\"\ntemperature = \"temp_degC\"\n\
         [gravity]\nvalue = 9.80665\nstandard_uncertainty = 1e-5\n{terms}"
    )
}

fn folder(terms: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, t, seed) in [
        ("cold.csv", -10.0, 3),
        ("room.csv", 25.0, 5),
        ("hot.csv", 60.0, 8),
    ] {
        hand_held(&folder.path().join(name), t, seed);
    }
    std::fs::write(folder.path().join("campaign.toml"), campaign(terms)).unwrap();
    folder
}

#[test]
fn known_calibration_over_temperature() {
    let folder = folder("[terms]\nbias = 1\nscale = 1\nreference_degC = 25\n");
    let said = succeed(&["calibrate", text(folder.path()), "--details"]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("Models side by side"), "{said}");
    assert!(said.contains("triangular, b(T), K(T)"), "{said}");
    assert!(!said.contains("decision needed"), "{said}");
    let out = folder.path().join("result");
    let result = json(&out.join("result.json"));
    for (name, truth) in [
        ("bias.x", 0.1),
        ("scale.y", 0.99),
        ("bias.x.T1", 1e-3 * G),
        ("bias.y.T1", -0.5e-3 * G),
        ("scale.x.T1", 2e-4),
        ("scale.z.T1", 0.5e-4),
    ] {
        let (value, u, _) = quantity(&result, name);
        assert!(
            (value - truth).abs() < 4.0 * u,
            "{name}: {value} {u} {truth}"
        );
        assert!(u < 0.02 * truth.abs().max(1e-3), "{name}: {u}");
    }
    let models = result["extra"]["models"].as_array().unwrap();
    let error = |m: &serde_json::Value| m["cross_validation"].as_f64().unwrap();
    let stated = models.iter().find(|m| m["stated"] == true).unwrap();
    let matrix = models.iter().find(|m| m["parameters"] == 9).unwrap();
    assert!(20.0 * error(stated) < error(matrix), "{models:?}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Models of the same standstills"));

    // Rendered again to the byte.
    let again = folder.path().join("again");
    succeed(&["render", text(&out.join("result.json")), "-o", text(&again)]);
    assert_eq!(
        page,
        std::fs::read_to_string(again.join("report.html")).unwrap()
    );

    // Applied between the temperatures of the calibration, with the temperature and never without.
    let calibration = out.join("calibration.json");
    let recording = folder.path().join("new.csv");
    let mut rows = String::from("x_m/s2,y_m/s2,z_m/s2,temp_degC\n");
    for (a, t) in [
        ([0.0, 0.0, G], 5.0),
        ([G, 0.0, 0.0], 45.0),
        ([0.0, -G, 0.0], 80.0),
    ] {
        let [x, y, z] = output(a, t);
        let _ = writeln!(rows, "{x:.6},{y:.6},{z:.6},{t}");
    }
    std::fs::write(&recording, rows).unwrap();
    let compensated = folder.path().join("out.csv");
    let mut words = vec![
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&compensated),
    ];
    assert!(refuse(&words).contains("no column of temperatures"));
    words.extend(["--temperature", "temp_degC"]);
    let said = succeed(&words);
    let said =
        String::from_utf8_lossy(&said.stdout).into_owned() + &String::from_utf8_lossy(&said.stderr);
    assert!(said.contains("beyond"), "80 °C is none of it: {said}");
    let read: Vec<Vec<f64>> = std::fs::read_to_string(&compensated)
        .unwrap()
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    assert!(
        (read[0][2] - G).abs() < 3e-3 && read[0][0].abs() < 3e-3,
        "{read:?}"
    );
    assert!(
        (read[1][0] - G).abs() < 3e-3 && read[1][1].abs() < 3e-3,
        "{read:?}"
    );
    words.extend(["--within-range", "--force"]);
    assert!(refuse(&words).contains("beyond the range"));

    let header = succeed(&["export", text(&calibration), "--c"]);
    assert!(String::from_utf8_lossy(&header.stdout).contains("float temperature"));
}

#[test]
fn refuses_terms_without_temperature_or_meaning() {
    let folder = folder("[terms]\nbias = 1\n");
    let toml = folder.path().join("campaign.toml");
    let write = |text: String| std::fs::write(&toml, text).unwrap();
    write(campaign("[terms]\nbias = 1\n").replace("temperature = \"temp_degC\"\n", ""));
    let said = refuse(&["calibrate", text(folder.path())]);
    assert!(
        said.contains("need a recording with a temperature") && said.contains("hint"),
        "{said}"
    );
    write(campaign("[terms]\nbias = 4\n"));
    assert!(refuse(&["calibrate", text(folder.path())]).contains("0 to 3"));
    write(campaign("[terms]\ncurvature = 1\n"));
    assert!(refuse(&["calibrate", text(folder.path())]).contains("2 or 3"));
    write(campaign("[terms]\nbais = 1\n"));
    assert!(refuse(&["calibrate", text(folder.path())]).contains("bais"));
    write(campaign("[terms]\nbias = 1\nreference_degC = 900\n"));
    assert!(refuse(&["calibrate", text(folder.path())]).contains("reference temperature"));
    // Without terms the temperature is told as what is missing.
    write(campaign(""));
    let said = succeed(&["calibrate", text(folder.path())]);
    assert!(String::from_utf8_lossy(&said.stdout).contains("decision needed"));
}

/// The curvature of a calibration is part of what is validated.
#[test]
fn known_validation_of_a_calibration_with_curvature() {
    let folder = tempfile::tempdir().unwrap();
    // 1e-3 of the square of the output: 0.1 m/s² at 1 g.
    let curved = |name: &str, seed: u64| {
        let path = folder.path().join(name);
        hand_held(&path, 25.0, seed);
        let straight = std::fs::read_to_string(&path).unwrap();
        let mut lines = straight.lines();
        let mut rows = format!("{}\n", lines.next().unwrap());
        for line in lines {
            let f: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
            let [x, y, z] = [1, 2, 3].map(|i| f[i] + 1e-3 * f[i] * f[i]);
            writeln!(rows, "{:.2},{x:.5},{y:.5},{z:.5},{:.3}", f[0], f[4]).unwrap();
        }
        std::fs::write(&path, rows).unwrap();
        path
    };
    curved("room.csv", 5);
    let one = campaign("[terms]\ncurvature = 2\n").replace(
        "files = [\"cold.csv\", \"room.csv\", \"hot.csv\"]",
        "file = \"room.csv\"",
    );
    std::fs::write(folder.path().join("campaign.toml"), one).unwrap();
    succeed(&["calibrate", text(folder.path())]);
    let other = curved("other.csv", 21);
    let calibration = folder.path().join("result/calibration.json");
    succeed(&[
        "validate",
        text(&calibration),
        text(&other),
        "--columns",
        "x_m/s2,y_m/s2,z_m/s2",
        "--time",
        "t_s",
        "--strict",
    ]);
}
