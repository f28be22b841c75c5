//! The example that ships with the project, from its recording to a compensated one.

use crate::support::*;
use std::path::Path;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");

/// The first figure of the report of the first command stands in `docs/report.svg`, beside the picture of the whole page.
#[test]
fn the_picture_of_the_book_shows_the_figure_of_today() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    succeed(&["calibrate", EXAMPLE, "-o", text(&out)]);
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    let (_, from) = report.split_once("<svg ").unwrap();
    let (figure, _) = from.split_once("</svg>").unwrap();
    let figure = format!("<svg {figure}</svg>\n");
    let kept = Path::new(EXAMPLE).with_file_name("report.svg");
    if std::env::var_os("PROOFMASS_WRITE_PAGES").is_some() {
        std::fs::write(&kept, &figure).unwrap();
    }
    if std::fs::read_to_string(&kept).unwrap() != figure {
        let now = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.svg");
        std::fs::write(&now, &figure).unwrap();
        panic!(
            "the figure of the first report was {} and is {}: run the test with PROOFMASS_WRITE_PAGES=1, and make docs/report.png again (`just picture`)",
            kept.display(),
            now.display()
        );
    }
}

#[test]
fn known_truth_lies_within_the_stated_uncertainty() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    succeed(&["calibrate", EXAMPLE, "-o", text(&out)]);
    let result = json(&out.join("result.json"));
    let truth = json(&Path::new(EXAMPLE).join("truth.json"));
    let k = |i: usize, j: usize| truth["K_count_per_m_per_s2"][i][j].as_f64().unwrap();
    let axes = ["x", "y", "z"];
    for i in 0..3 {
        let (value, u, _) = quantity(&result, &format!("bias.{}", axes[i]));
        let bias = truth["b_count"][i].as_f64().unwrap();
        // Nine quantities with some 15 degrees of freedom: beyond 3.5 u once in 300 seeds.
        assert!((value - bias).abs() < 3.5 * u, "bias.{}: {value}", axes[i]);
        let (value, u, _) = quantity(&result, &format!("scale.{}", axes[i]));
        assert!(
            (value - k(i, i)).abs() < 3.5 * u,
            "scale.{}: {value}",
            axes[i]
        );
        for j in i + 1..3 {
            let name = format!("misalignment.{}{}", axes[i], axes[j]);
            let (value, u, _) = quantity(&result, &name);
            assert!(
                (value - k(i, j) / k(i, i)).abs() < 3.5 * u,
                "{name}: {value}"
            );
        }
    }
    for name in [
        "report.html",
        "calibration.json",
        "parameters.csv",
        "standstills.csv",
        "covariance.csv",
    ] {
        assert!(out.join(name).is_file(), "{name}");
    }
    let size = std::fs::metadata(out.join("result.json")).unwrap().len();
    assert!(size < 150_000, "result.json has {size} bytes");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for outside in [
        "http://", "https://", "src=", "fetch(", "import(", "<link", "@import",
    ] {
        let foreign = page.replace("http://www.w3.org/", "");
        assert!(
            !foreign.contains(outside),
            "the page reaches outside: {outside}"
        );
    }
}

#[test]
fn regress_the_recording_is_what_its_seed_makes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("campaign");
    succeed(&[
        "simulate",
        "multi-position",
        "--seed",
        "1",
        "-o",
        text(&out),
    ]);
    for name in ["recording.csv", "campaign.toml", "truth.json"] {
        let made = std::fs::read(out.join(name)).unwrap();
        let shipped = std::fs::read(Path::new(EXAMPLE).join(name)).unwrap();
        assert!(made == shipped, "{name} differs from the shipped one");
    }
}

#[test]
fn law_results_are_the_same_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    succeed(&["calibrate", EXAMPLE, "-o", text(&a)]);
    succeed(&["calibrate", EXAMPLE, "-o", text(&b)]);
    for name in ["result.json", "calibration.json", "report.html"] {
        assert!(
            std::fs::read(a.join(name)).unwrap() == std::fs::read(b.join(name)).unwrap(),
            "{name}"
        );
    }
}

#[test]
fn law_apply_is_the_model_row_by_row() {
    let folder = tempfile::tempdir().unwrap();
    let result = folder.path().join("result");
    succeed(&["calibrate", EXAMPLE, "-o", text(&result)]);
    let calibration = result.join("calibration.json");
    let recording = Path::new(EXAMPLE).join("recording.csv");
    let out = folder.path().join("compensated.csv");
    succeed(&[
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&out),
    ]);

    let file = json(&calibration);
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let k = std::array::from_fn(|i| std::array::from_fn(|j| number(&file["K"][i][j])));
    let b = std::array::from_fn(|i| number(&file["b"][i]));
    let sensor = proofmass::core::SensorModel::new(proofmass::core::Matrix3(k), b).unwrap();
    let raw = std::fs::read_to_string(&recording).unwrap();
    let compensated = std::fs::read_to_string(&out).unwrap();
    assert!(compensated.starts_with("time_s,acc_x_m/s2,acc_y_m/s2,acc_z_m/s2\n"));
    assert_eq!(raw.lines().count(), compensated.lines().count());
    for (raw, got) in raw.lines().zip(compensated.lines()).skip(1).step_by(97) {
        let raw: Vec<f64> = raw.split(',').map(|f| f.parse().unwrap()).collect();
        let got: Vec<f64> = got.split(',').map(|f| f.parse().unwrap()).collect();
        assert_eq!(got[0], raw[0]);
        // The same function and shortest round-trip digits: the same bits.
        assert_eq!(got[1..], sensor.apply([raw[1], raw[2], raw[3]]));
    }
}

#[test]
fn law_validation_on_another_recording_of_the_same_sensor_is_consistent() {
    let folder = tempfile::tempdir().unwrap();
    let (result, other) = (folder.path().join("result"), folder.path().join("other"));
    succeed(&["calibrate", EXAMPLE, "-o", text(&result)]);
    succeed(&[
        "simulate",
        "multi-position",
        "--seed",
        "2",
        "-o",
        text(&other),
    ]);
    let out = folder.path().join("validation");
    succeed(&[
        "validate",
        text(&result.join("calibration.json")),
        text(&other.join("recording.csv")),
        "-o",
        text(&out),
    ]);
    let validation = &json(&out.join("result.json"))["extra"]["validation"];
    assert_eq!(validation["attitudes"].as_array().unwrap().len(), 24);
    assert!(
        validation["attitudes"]
            .as_array()
            .unwrap()
            .iter()
            .all(|a| a["within_rule"] == true)
    );
    // One recording: a p-value below 1e-3 arises once in a thousand seeds when the covariance is right.
    assert!(validation["p_value"].as_f64().unwrap() > 1e-3);
    // 1 mm/s² of wander is 0.1 mg.
    assert!(validation["rms_after_mg"].as_f64().unwrap() < 0.2);
}

#[test]
fn known_plan_of_a_recording_held_by_hand_lists_what_to_add() {
    let said = succeed(&["plan", EXAMPLE]);
    let said = String::from_utf8(said.stdout).unwrap();
    // The answer is that of the plan, above what there is so far.
    let verdict = said.find("4 further standstills lower the expanded uncertainties to ");
    let residual = said.find("Birge ratio");
    assert!(
        verdict.is_some() && verdict < residual.or(Some(said.len())),
        "{said}"
    );
    assert!(
        said.contains("Further standstills that tell most"),
        "{said}"
    );
    let shares: Vec<f64> = ["+1", "+2", "+3", "+4"]
        .iter()
        .map(|number| {
            let starts = |l: &&str| l.trim_start().starts_with(number);
            let line = said
                .lines()
                .find(starts)
                .unwrap_or_else(|| panic!("{said}"));
            line.split_whitespace().last().unwrap().parse().unwrap()
        })
        .collect();
    // Each narrows further, none by more than one of a few among many.
    assert!(shares.windows(2).all(|w| w[1] <= w[0]), "{shares:?}");
    assert!((70.0..100.0).contains(&shares[0]), "{shares:?}");
    let said = refuse(&["plan", EXAMPLE, "--best", "4"]);
    assert!(said.contains("--best"), "{said}");
}
