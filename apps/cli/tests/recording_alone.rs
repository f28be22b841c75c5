//! A recording without a campaign: `calibrate RECORDING`, what its rows are, and the campaign that `init` writes.

use crate::support::*;
use std::fmt::Write;
use std::path::Path;

const PLACE: [&str; 2] = ["--latitude", "45.07"];
/// Gravity there at 300 m, m/s².
const GRAVITY: f64 = 9.8053;

/// ã = K a + b of the sensor that made the tables below.
fn output(a: [f64; 3]) -> [f64; 3] {
    let k = [[1.01, 0.004, -0.003], [0.0, 0.99, 0.006], [0.0, 0.0, 1.02]];
    let b = [0.12, -0.25, 0.31];
    std::array::from_fn(|i| (0..3).map(|j| k[i][j] * a[j]).sum::<f64>() + b[i])
}

/// Directions spread over the sphere, the six faces first.
fn directions(count: usize) -> Vec<[f64; 3]> {
    (0..count)
        .map(|i| {
            if i < 6 {
                let mut face = [0.0; 3];
                face[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
                return face;
            }
            let z = 1.0 - (2.0 * (i - 6) as f64 + 1.0) / (count - 6) as f64;
            let (r, angle) = ((1.0 - z * z).sqrt(), 2.4 * i as f64 + 0.3);
            [r * angle.cos(), r * angle.sin(), z]
        })
        .collect()
}

/// Means of some 1 mm/s² in a file.
fn readings(path: &Path, count: usize) {
    let mut table = "acc_x_m/s2,acc_y_m/s2,acc_z_m/s2\n".to_owned();
    for (i, up) in directions(count).iter().enumerate() {
        let [x, y, z] = output(up.map(|u| GRAVITY * u));
        let error = |k: usize| 1e-3 * ((i * 7 + k * 13) as f64 * 1.7).sin();
        writeln!(
            table,
            "{:.4},{:.4},{:.4}",
            x + error(1),
            y + error(2),
            z + error(3)
        )
        .unwrap();
    }
    std::fs::write(path, table).unwrap();
}

fn holds(result: &serde_json::Value) {
    for (name, truth) in [
        ("bias.x", 0.12),
        ("bias.y", -0.25),
        ("bias.z", 0.31),
        ("scale.x", 1.01),
        ("scale.y", 0.99),
        ("scale.z", 1.02),
    ] {
        let (value, u, _) = quantity(result, name);
        assert!((value - truth).abs() < 4.0 * u, "{name}: {value} ± {u}");
    }
}

#[test]
fn known_readings_without_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("means.csv");
    readings(&file, 24);
    let mut arguments = vec!["calibrate", text(&file), "--rows", "readings"];
    arguments.extend(PLACE);
    succeed(&arguments);
    holds(&json(&folder.path().join("result/result.json")));
}

/// A campaign from `init` gives what the recording alone gives, and is never replaced.
#[test]
fn law_init_writes_the_campaign_of_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("means.csv");
    readings(&file, 24);
    let mut arguments = vec!["init", text(&file), "--rows", "readings"];
    arguments.extend(PLACE);
    let said = stderr(&succeed(&arguments));
    assert!(said.contains("proofmass calibrate"), "{said}");
    let place = folder.path().join("campaign.toml");
    let written = std::fs::read_to_string(&place).unwrap();
    assert!(written.contains("rows = \"readings\""), "{written}");
    succeed(&["calibrate", text(folder.path())]);
    holds(&json(&folder.path().join("result/result.json")));
    let said = refuse(&arguments);
    assert!(said.contains("never replaced"), "{said}");
    assert_eq!(std::fs::read_to_string(&place).unwrap(), written);
}

/// Six faces alone: the refusal asks for their directions, and with these six are enough.
#[test]
fn known_six_faces_as_readings_ask_for_directions() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("six.csv");
    readings(&file, 6);
    let mut arguments = vec!["calibrate", text(&file), "--rows", "readings"];
    arguments.extend(PLACE);
    let said = refuse(&arguments);
    assert!(said.contains("6 given"), "{said}");
    assert!(said.contains("directions = ["), "{said}");
    assert!(holds_only(folder.path(), &["six.csv"]));
    arguments[0] = "init";
    succeed(&arguments);
    let place = folder.path().join("campaign.toml");
    let written = std::fs::read_to_string(&place).unwrap();
    let directed = written.replace(
        "[standstill]\n",
        "[standstill]\ndirections = [\"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\"]\n",
    );
    assert_ne!(written, directed);
    std::fs::write(&place, directed).unwrap();
    succeed(&["calibrate", text(folder.path())]);
    holds(&json(&folder.path().join("result/result.json")));
}

/// Turned slowly all the time; as standstills the same rows are refused with a word of what they may be.
#[test]
fn known_tumble_without_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tumble.csv");
    let mut table = "time_s,ax_m/s2,ay_m/s2,az_m/s2\n".to_owned();
    for i in 0..9000 {
        let t = i as f64 / 50.0;
        // From pole to pole while it goes round: all of the sphere in three minutes.
        let (polar, around) = (0.31 * t, 0.17 * t);
        let up = [
            polar.sin() * around.cos(),
            polar.sin() * around.sin(),
            polar.cos(),
        ];
        let [x, y, z] = output(up.map(|u| GRAVITY * u));
        let error = |k: usize| 0.01 * ((i * 37 + k * 101) as f64 * 0.73).sin();
        writeln!(
            table,
            "{t:.3},{:.4},{:.4},{:.4}",
            x + error(1),
            y + error(2),
            z + error(3)
        )
        .unwrap();
    }
    std::fs::write(&file, table).unwrap();
    let mut arguments = vec!["calibrate", text(&file)];
    arguments.extend(PLACE);
    let said = refuse(&arguments);
    assert!(said.contains("--rows tumble"), "{said}");
    arguments.extend(["--rows", "tumble"]);
    succeed(&arguments);
    holds(&json(&folder.path().join("result/result.json")));
}

/// What only a recording needs is refused beside a campaign, and a recording needs a place.
#[test]
fn refuses_options_of_a_recording_beside_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("means.csv");
    readings(&file, 24);
    let said = refuse(&["calibrate", text(&file), "--rows", "readings"]);
    assert!(said.contains("--latitude"), "{said}");
    let mut arguments = vec!["init", text(&file), "--rows", "readings"];
    arguments.extend(PLACE);
    succeed(&arguments);
    let said = refuse(&["calibrate", text(folder.path()), "--rows", "readings"]);
    assert!(said.contains("campaign.toml"), "{said}");
}
