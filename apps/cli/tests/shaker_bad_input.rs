//! What goes wrong in a shaker laboratory, through the binary: named by run, file and line, and nothing left behind.

use crate::bench::{self, Row, rows};
use crate::support;
use crate::support::{holds_only, json, refuse, succeed, text};
use std::path::Path;

/// Findings of a campaign that ends, as (severity, code, all that is said).
fn findings(folder: &Path) -> Vec<(String, String, String)> {
    let out = folder.join("result");
    succeed(&["calibrate", text(folder), "--output", text(&out), "--force"]);
    let result = json(&out.join("result.json"));
    let list = result["findings"].as_array().expect("findings");
    let word = |f: &serde_json::Value, key: &str| f[key].as_str().unwrap_or_default().to_owned();
    list.iter()
        .map(|f| {
            let said = format!(
                "{}; {}; {}",
                word(f, "what"),
                word(f, "evidence"),
                word(f, "advice")
            );
            (word(f, "severity"), word(f, "code"), said)
        })
        .collect()
}

/// Insists on a finding of this code that says all these words.
fn insist(findings: &[(String, String, String)], code: &str, words: &[&str]) {
    let found = findings
        .iter()
        .any(|(_, c, said)| c == code && words.iter().all(|w| said.contains(w)));
    assert!(found, "no {code} with {words:?} in {findings:#?}");
}

fn phasors(change: impl FnOnce(&mut Vec<Row>)) -> Vec<(String, String, String)> {
    let folder = tempfile::tempdir().expect("folder");
    let mut rows = rows(&[80.0, 160.0]);
    change(&mut rows);
    bench::phasors(folder.path(), &rows);
    findings(folder.path())
}

fn recordings(change: impl FnOnce(&mut Vec<Row>)) -> Vec<(String, String, String)> {
    let folder = tempfile::tempdir().expect("folder");
    let mut rows = rows(&[80.0, 160.0]);
    change(&mut rows);
    bench::recordings(folder.path(), &rows);
    findings(folder.path())
}

fn none_needs_a_decision(findings: &[(String, String, String)]) {
    assert!(findings.iter().all(|f| f.0 == "note"), "{findings:#?}");
}

#[test]
fn a_sound_campaign_says_nothing() {
    none_needs_a_decision(&phasors(|_| {}));
    none_needs_a_decision(&recordings(|_| {}));
}

#[test]
fn names_a_missing_run() {
    let said = phasors(|rows| {
        rows.remove(20);
    });
    insist(
        &said,
        "missing-configuration",
        &["inclination 55°, rotation 0°, 80 Hz"],
    );
}

#[test]
fn names_a_configuration_that_is_there_twice() {
    let said = phasors(|rows| {
        let mut again = rows[20].clone();
        again.run = "again".into();
        rows.push(again);
    });
    insist(&said, "copied-run", &["r021", "again"]);
}

#[test]
fn names_the_run_with_swapped_cables() {
    let said = phasors(|rows| rows[13].channels.swap(1, 2));
    insist(&said, "swapped-channels", &["r014", "x and y"]);
    let said = phasors(|rows| rows.iter_mut().for_each(|r| r.channels.swap(1, 2)));
    insist(
        &said,
        "swapped-channels",
        &["channel x follows the y axis in every run"],
    );
}

#[test]
fn names_the_run_with_an_inverted_channel() {
    let said = recordings(|rows| rows[20].channels[3] = -rows[20].channels[3]);
    insist(&said, "inverted-channel", &["r021", "channel z"]);
}

#[test]
fn names_the_clipped_run() {
    let said = recordings(|rows| {
        for z in &mut rows[30].channels {
            *z *= 12.0;
        }
    });
    insist(&said, "clipped", &["r031"]);
}

#[test]
fn names_the_run_whose_frequency_is_wrong_in_the_table() {
    // A frequency of its own, which one run cannot determine.
    let said = recordings(|rows| rows[17].frequency = 100.0);
    insist(
        &said,
        "frequency-mismatch",
        &["r018", "100 Hz in the table", "80.0"],
    );
    insist(&said, "frequency-undetermined", &["r018", "100 Hz"]);
    insist(&said, "missing-configuration", &["80 Hz"]);
    // The frequency of other runs.
    let said = recordings(|rows| rows[17].frequency = 160.0);
    insist(
        &said,
        "frequency-mismatch",
        &["r018", "160 Hz in the table", "80.0"],
    );
}

#[test]
fn names_the_runs_that_the_certificate_does_not_reach() {
    let folder = tempfile::tempdir().expect("folder");
    bench::phasors(folder.path(), &rows(&[80.0, 160.0]));
    bench::certificate(folder.path(), 100.0);
    let said = findings(folder.path());
    insist(
        &said,
        "reference-out-of-range",
        &["160 Hz", "44 runs from r045"],
    );
    // No frequency left: no result, and the reason.
    bench::certificate(folder.path(), 50.0);
    std::fs::remove_dir_all(folder.path().join("result")).expect("result");
    let said = refuse(&["calibrate", text(folder.path())]);
    assert!(
        said.contains("does not reach 80 Hz, 160 Hz") && said.contains("r001"),
        "{said}"
    );
    assert!(!folder.path().join("result").exists());
}

#[test]
fn recognises_radians_declared_as_degrees() {
    let folder = tempfile::tempdir().expect("folder");
    let rows: Vec<Row> = rows(&[80.0, 160.0])
        .into_iter()
        .enumerate()
        .map(|(i, r)| Row {
            // Another start of every run, as without a trigger.
            channels: r.channels.map(|z| {
                let turned = z * num(1.0, 0.7 * i as f64);
                num(turned.norm(), turned.arg().to_radians())
            }),
            ..r
        })
        .collect();
    bench::phasors(folder.path(), &rows);
    let out = folder.path().join("result");
    let output = support::proofmass(&["calibrate", text(folder.path()), "--output", text(&out)]);
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        support::stderr(&output)
    );
    assert!(
        said.contains("look like radians that were declared as degrees"),
        "{said}"
    );
    let result = std::fs::read_to_string(out.join("result.json")).expect("a result");
    assert!(result.contains("runs r001 to r088"), "{said}");
    // Degrees declared as radians are refused at the first row that cannot be.
    let table = bench::phasor_table(&bench::rows(&[80.0, 160.0])).replace("phase_deg", "phase_rad");
    std::fs::write(folder.path().join("runs.csv"), table).expect("runs");
    let said = refuse(&[
        "calibrate",
        text(folder.path()),
        "--output",
        text(&folder.path().join("again")),
    ]);
    assert!(
        said.contains("runs.csv:") && said.contains("run \"r0") && said.contains("_deg"),
        "{said}"
    );
}

fn num(modulus: f64, phase: f64) -> proofmass::shaker::Complex64 {
    proofmass::shaker::Complex64::from_polar(modulus, phase)
}

/// What is said about a campaign of recordings after something was done to its folder; nothing may be left behind.
fn damaged(damage: impl FnOnce(&Path)) -> String {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    bench::recordings(here, &rows(&[80.0])[..12]);
    damage(here);
    let mut before: Vec<String> = std::fs::read_dir(here)
        .expect("folder")
        .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
        .collect();
    before.sort();
    let said = refuse(&["calibrate", text(here)]);
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    assert!(holds_only(here, &before), "something was left behind");
    said
}

fn edit(path: &Path, change: impl FnOnce(&str) -> String) {
    let text = std::fs::read_to_string(path).expect("text");
    std::fs::write(path, change(&text)).expect("text");
}

#[test]
fn names_the_recording_that_ended_early_and_the_correction_with_gaps() {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    bench::recordings(here, &rows(&[80.0]));
    // Half of 5000 instants of four channels, cut between two instants.
    let path = here.join("r007.f32");
    let mut all = std::fs::read(&path).expect("recording");
    all.truncate(2500 * 16);
    std::fs::write(&path, all).expect("recording");
    edit(&here.join("campaign.toml"), |t| {
        format!("{t}[[correction]]\nlabel = \"first\"\nfile = \"spurious.csv\"\n")
    });
    std::fs::write(
        here.join("spurious.csv"),
        "inclination_deg,frequency_Hz,x_ratio_%,x_phase_deg,u_x_ratio_%\n0,80,0.1,20,0.01\n15,80,0.1,20,0.01\n",
    )
    .expect("correction");
    let said = findings(here);
    insist(&said, "short-recording", &["r007", "0.1250 s"]);
    insist(
        &said,
        "correction-incomplete",
        &["first", "4 inclinations", "35"],
    );
}

#[test]
fn refuses_damaged_recordings_by_run_file_and_line() {
    let cut = |bytes: usize| {
        move |folder: &Path| {
            let path = folder.join("r004.f32");
            let mut all = std::fs::read(&path).expect("recording");
            all.truncate(bytes);
            std::fs::write(path, all).expect("recording");
        }
    };
    let nan = |folder: &Path| {
        let path = folder.join("r004.f32");
        let mut all = std::fs::read(&path).expect("recording");
        all[8000..8004].copy_from_slice(&f32::NAN.to_le_bytes());
        std::fs::write(path, all).expect("recording");
    };
    for (said, words) in [
        (damaged(cut(0)), ["r004.f32", "empty"]),
        (damaged(cut(1001)), ["r004.f32", "1001 bytes"]),
        (damaged(cut(160)), ["r004.f32", "no sine of 80 Hz"]),
        (damaged(nan), ["r004.f32", "sample 500 is NaN"]),
        (
            damaged(|f| std::fs::remove_file(f.join("r004.f32")).expect("recording")),
            ["runs.csv:5", "there is no recording"],
        ),
    ] {
        assert!(words.iter().all(|w| said.contains(w)), "{words:?}: {said}");
        assert!(
            said.contains("r004") && said.contains("runs.csv:5"),
            "{said}"
        );
        assert!(said.contains("hint"), "{said}");
    }
}

#[test]
fn refuses_damaged_tables_by_file_and_line() {
    let runs =
        |change: fn(&str) -> String| move |folder: &Path| edit(&folder.join("runs.csv"), change);
    let toml = |change: fn(&str) -> String| {
        move |folder: &Path| edit(&folder.join("campaign.toml"), change)
    };
    let reference = |change: fn(&str) -> String| {
        move |folder: &Path| edit(&folder.join("reference.csv"), change)
    };
    let budget =
        |change: fn(&str) -> String| move |folder: &Path| edit(&folder.join("budget.toml"), change);
    for (said, words) in [
        (damaged(runs(|_| String::new())), ["runs.csv", "is empty"]),
        (
            damaged(|folder| {
                edit(&folder.join("campaign.toml"), |t| {
                    format!("{t}[[correction]]\nlabel = \"first\"\nfile = \"spurious.csv\"\n")
                });
                // Radians where degrees belong.
                let table = "inclination_deg,frequency_Hz,x_ratio_%,x_phase_deg,u_x_ratio_%\n0.61,80,0.1,20,0.01\n";
                std::fs::write(folder.join("spurious.csv"), table).expect("correction");
            }),
            ["no line of a wedge", "degrees"],
        ),
        (
            damaged(runs(|t| t.lines().take(1).collect())),
            ["runs.csv", "no rows"],
        ),
        (
            damaged(runs(|t| t[..t.len() - 20].to_owned())),
            ["runs.csv:13", "fields"],
        ),
        (
            damaged(runs(|t| t.replacen("frequency_Hz", "frequenzy_Hz", 1))),
            ["runs.csv:1", "did you mean `frequency_Hz`"],
        ),
        (
            damaged(runs(|t| t.replacen("rotation_deg", "rotation", 1))),
            ["runs.csv:1", "rotation_deg or rotation_rad"],
        ),
        (
            damaged(runs(|t| t.replacen("r003,80,", "r003,NaN,", 1))),
            ["runs.csv:4", "frequency_Hz"],
        ),
        (
            damaged(runs(|t| t.replacen("r003,80,", "r003,-80,", 1))),
            ["runs.csv:4", "not above zero"],
        ),
        (
            damaged(runs(|t| t.replacen("r003,", "r002,", 1))),
            ["runs.csv:4", "line 3 already"],
        ),
        (
            damaged(runs(|t| t.replacen("r003.f32", "r002.f32", 1))),
            ["runs.csv:4", "recording of line 3"],
        ),
        (
            damaged(runs(|t| t.replacen("r003,80,0,", "r003,80,500,", 1))),
            ["runs.csv:4", "inclination of 500"],
        ),
        (
            damaged(toml(|t| t.replacen("full_scale_V", "fullscale_V", 1))),
            ["campaign.toml:", "did you mean `full_scale_V`"],
        ),
        (
            damaged(toml(|t| t.replacen("z = 4", "z = 9", 1))),
            ["r001.f32", "whole number of samples"],
        ),
        (
            damaged(toml(|t| t.replacen(", z = 4", "", 1))),
            ["recording.channels", "\"z\" is missing"],
        ),
        (
            damaged(toml(|t| t.replacen("k = 2\n", "", 1))),
            ["reference.csv:1", "coverage factor"],
        ),
        (
            damaged(reference(|t| t.replacen("5,9.9", "5,inf", 1))),
            ["reference.csv:2", "not a finite number"],
        ),
        (
            damaged(reference(|_| "\0\0".to_owned())),
            ["reference.csv", "not a text"],
        ),
        (
            damaged(budget(|t| t.replacen("acts = \"rotation\"\n", "", 1))),
            ["budget.toml:9", "does not say what it acts on"],
        ),
        (
            damaged(budget(|t| {
                t.replacen("\"inclination\", \"rotation\"", "\"inclinaton\"", 1)
            })),
            ["budget.toml:9", "did you mean \"inclination\""],
        ),
        (
            damaged(budget(|t| t.replacen("unit = \"%\"", "unit = \"V\"", 1))),
            ["budget.toml:15", "unknown unit"],
        ),
        (
            damaged(budget(|t| t.replacen("kind = \"rect", "kin = \"rect", 1))),
            ["budget.toml:6", "kin"],
        ),
    ] {
        assert!(words.iter().all(|w| said.contains(w)), "{words:?}: {said}");
        assert!(said.contains("hint"), "{said}");
    }
}
