//! Bad input: one clear message that names place and remedy, exit code 1, nothing half written.

use crate::support::*;

const CAMPAIGN: &str = "kind = \"multi-position\"\n[recording]\nfile = \"r.csv\"\n\
    columns = { x = \"acc_x\", y = \"acc_y\", z = \"acc_z\" }\ntime = \"time\"\n\
    [gravity]\nvalue = 9.80665\nstandard_uncertainty = 1e-5\n";

/// Calibrates a recording that must be refused, and gives back what was said.
fn refuse_recording(lines: &[String]) -> String {
    refuse_campaign(CAMPAIGN, lines)
}

fn refuse_campaign(toml: &str, lines: &[String]) -> String {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), toml);
    let mut text_of = lines.join("\n");
    if !lines.is_empty() {
        text_of.push('\n');
    }
    std::fs::write(folder.path().join("r.csv"), text_of).unwrap();
    let said = refuse(&["calibrate", text(folder.path())]);
    assert!(
        holds_only(folder.path(), &["campaign.toml", "r.csv"]),
        "something was left behind"
    );
    assert!(said.contains("hint:"), "no remedy: {said}");
    said
}

fn assert_says(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "{word:?} is missing from: {said}");
    }
}

#[test]
fn refuses_an_empty_file() {
    assert_says(&refuse_recording(&[]), &["r.csv", "empty"]);
}

#[test]
fn refuses_one_row() {
    let lines = example_lines();
    assert_says(&refuse_recording(&lines[..2]), &["r.csv"]);
    assert_says(&refuse_recording(&lines[..1]), &["r.csv"]);
}

#[test]
fn refuses_all_zeros() {
    let mut lines = vec![example_lines()[0].clone()];
    lines.extend((0..2000).map(|i| format!("{},0,0,0", f64::from(i) / 100.0)));
    assert_says(
        &refuse_recording(&lines),
        &["r.csv", "output x never changes"],
    );
}

#[test]
fn refuses_nan_inf_and_text_with_line_and_column() {
    for word in ["NaN", "inf", "-Infinity", "n/a", ""] {
        let mut lines = example_lines();
        let fields: Vec<&str> = lines[500].split(',').collect();
        lines[500] = format!("{},{},{word},{}", fields[0], fields[1], fields[3]);
        assert_says(&refuse_recording(&lines), &["r.csv:501", "acc_y"]);
    }
}

#[test]
fn refuses_a_wrong_column_count_in_row_70_000() {
    let mut lines = vec![example_lines()[0].clone()];
    lines.extend((0..80_000).map(|i| format!("{},{},2,3", f64::from(i) / 100.0, i % 7)));
    lines[70_000] = "700,1,2".to_owned();
    assert_says(&refuse_recording(&lines), &["r.csv:70001"]);
}

#[test]
fn refuses_time_that_runs_backwards_or_repeats() {
    let mut lines = example_lines();
    lines.swap(800, 801);
    assert_says(&refuse_recording(&lines), &["r.csv:802", "time"]);
    let mut lines = example_lines();
    lines[900] = lines[899].clone();
    assert_says(&refuse_recording(&lines), &["r.csv:901", "time"]);
}

#[test]
fn refuses_counts_declared_as_acceleration() {
    let mut lines = example_lines();
    lines[0] = "time_s,acc_x,acc_y,acc_z".to_owned();
    let toml = CAMPAIGN.replace("time = \"time\"", "time = \"time\"\nunit = \"m/s²\"");
    assert_says(
        &refuse_campaign(&toml, &lines),
        &["raw counts", "unit = \"count\""],
    );
}

#[test]
fn refuses_multiples_of_g_declared_as_metres_per_second_squared() {
    let mut lines = vec!["time_s,acc_x,acc_y,acc_z".to_owned()];
    for line in &example_lines()[1..] {
        let f: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        let g = |i: usize, b: f64| (f[i] - b) / 414.0 / 9.80665;
        lines.push(format!(
            "{},{},{},{}",
            f[0],
            g(1, 33120.0),
            g(2, 33271.0),
            g(3, 32366.0)
        ));
    }
    let toml = CAMPAIGN.replace("time = \"time\"", "time = \"time\"\nunit = \"m/s²\"");
    assert_says(&refuse_campaign(&toml, &lines), &["unit = \"g\""]);
}

/// The rows of the example outside the motions to and from some standstills, and their campaign.
fn without_standstills(keep: impl Fn([f64; 3]) -> bool) -> Vec<String> {
    let lines = example_lines();
    let truth = json(std::path::Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/hand-held/truth.json"
    )));
    let mut kept = vec![lines[0].clone()];
    for rest in truth["standstills"].as_array().unwrap() {
        let attitude = std::array::from_fn(|i| rest["attitude"][i].as_f64().unwrap());
        if keep(attitude) {
            let at = |key: &str| rest[key].as_u64().unwrap() as usize;
            let end = (at("end") + 150).min(lines.len() - 1);
            for line in &lines[at("start") + 1..end + 1] {
                let rest_of = line.split_once(',').unwrap().1;
                kept.push(format!("{},{rest_of}", (kept.len() - 1) as f64 / 100.0));
            }
        }
    }
    kept
}

#[test]
fn refuses_six_positions_of_which_two_are_missing() {
    // Only the first six rests are the principal directions; z up and z down are left out.
    let lines = without_standstills(|a| {
        let largest = a.iter().map(|v| v.abs()).fold(0.0, f64::max);
        largest > 0.95 && a[2].abs() < 0.9
    });
    let said = refuse_recording(&lines);
    assert_says(&said, &["r.csv", "+z and -z missing", "standstills"]);
}

#[test]
fn refuses_attitudes_in_a_plane() {
    // The rests near the x–y plane: z cannot be found.
    let lines = without_standstills(|a| a[2].abs() < 0.15);
    let said = refuse_recording(&lines);
    assert_says(&said, &["r.csv", "+z and -z missing"]);
}

#[test]
fn refuses_a_misspelt_key_and_names_the_right_one() {
    let said = refuse_campaign(&CAMPAIGN.replace("columns =", "colums ="), &example_lines());
    assert_says(&said, &["campaign.toml:4", "columns"]);
}

#[test]
fn refuses_an_unknown_kind() {
    let said = refuse_campaign(
        &CAMPAIGN.replace("multi-position", "multiposition"),
        &example_lines(),
    );
    assert_says(&said, &["campaign.toml:1", "multi-position"]);
}

#[test]
fn refuses_a_missing_campaign_and_a_missing_recording() {
    let folder = tempfile::tempdir().unwrap();
    assert_says(
        &refuse(&["calibrate", text(&folder.path().join("nowhere"))]),
        &["nowhere"],
    );
    campaign(folder.path(), CAMPAIGN);
    assert_says(&refuse(&["calibrate", text(folder.path())]), &["r.csv"]);
}

#[test]
fn refuses_to_apply_to_other_units_or_columns_and_leaves_the_output_alone() {
    let folder = tempfile::tempdir().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let result = folder.path().join("result");
    succeed(&["calibrate", example, "-o", text(&result)]);
    let calibration = result.join("calibration.json");
    let out = folder.path().join("out.csv");
    std::fs::write(&out, "precious").unwrap();
    for (header, row, words) in [
        (
            "time_s,acc_x_g,acc_y_g,acc_z_g",
            "0,0.1,0.2,0.9",
            ["acc_x", "g", "count"],
        ),
        ("time_s,a,b,c", "0,1,2,3", ["acc_x", "", ""]),
        (
            "time_s,acc_x,acc_y,acc_z",
            "0,1,2,3",
            ["unit", "count", "--unit"],
        ),
        (
            "time_s,acc_x_count,acc_y_count,acc_z_count",
            "0,1,NaN,3",
            [":2", "acc_y", ""],
        ),
    ] {
        let recording = folder.path().join("in.csv");
        std::fs::write(
            &recording,
            format!("{header}\n{row}\n{}\n", row.replace("NaN", "2")),
        )
        .unwrap();
        let said = refuse(&[
            "apply",
            text(&calibration),
            text(&recording),
            "-o",
            text(&out),
            "--force",
        ]);
        assert_says(&said, &words);
        assert_eq!(std::fs::read_to_string(&out).unwrap(), "precious");
    }
    let recording = folder.path().join("in.csv");
    let said = refuse(&[
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&recording),
    ]);
    assert_says(&said, &["in.csv"]);
}

#[test]
fn refuses_to_replace_a_folder_that_is_not_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("mine");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("thesis.txt"), "years of work").unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    refuse(&["calibrate", example, "-o", text(&out)]);
    assert_eq!(
        std::fs::read_to_string(out.join("thesis.txt")).unwrap(),
        "years of work"
    );
}

#[test]
fn wrong_use_is_exit_code_two() {
    assert_eq!(proofmass(&["calibrate"]).status.code(), Some(2));
    assert_eq!(proofmass(&["calibrat", "x"]).status.code(), Some(2));
}
