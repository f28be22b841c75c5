//! What is too large is refused with the bound, what is hostile is shown as it is, and one bad number takes nothing with it.

use crate::bench::{phasors, rows};
use crate::support::*;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

fn published(folder: &Path) {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/published-triaxial");
    for entry in fs::read_dir(example).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
}

fn edit(path: &Path, old: &str, new: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(old), "{old}");
    fs::write(path, text.replacen(old, new, 1)).unwrap();
}

fn refused_quickly(arguments: &[&str], words: &[&str]) {
    let began = Instant::now();
    let said = refuse(arguments);
    // Generous: the suite runs on a busy machine, and without the bound it would not end at all.
    assert!(
        began.elapsed().as_secs() < 30,
        "{arguments:?}: {:?}",
        began.elapsed()
    );
    for word in words {
        assert!(said.contains(word), "{word:?} is missing from: {said}");
    }
}

#[test]
fn regress_numbers_of_trials_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    phasors(folder.path(), &rows(&[80.0, 160.0]));
    let toml = folder.path().join("campaign.toml");
    edit(&toml, "trials = 0", "trials = 1000000000000");
    refused_quickly(
        &["calibrate", text(folder.path())],
        &["campaign.toml:", "trials", "100000000 at most"],
    );
    // Fewer, but with all outputs of the joint fit more than is kept.
    edit(&toml, "trials = 1000000000000", "trials = 99000000");
    refused_quickly(&["calibrate", text(folder.path())], &["trials", "at most"]);
}

#[test]
fn regress_a_million_candidates_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    published(folder.path());
    let mut plan = "configuration,inclination_deg,rotation_deg\n".to_owned();
    for k in 0..1_000_000 {
        let _ = writeln!(
            plan,
            "{k},{},{}",
            0.09 * f64::from(k / 1000),
            0.36 * f64::from(k % 1000)
        );
    }
    fs::write(folder.path().join("plan.csv"), plan).unwrap();
    refused_quickly(
        &["plan", text(folder.path())],
        &["1000000 candidates", "1000 at most"],
    );
}

#[test]
fn regress_formulas_and_endless_files_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.toml");
    let of = |formula: &str| {
        format!(
            "[[input]]\nname = \"a\"\nunit = \"1\"\nvalue = 1\nU = 0.1\nk = 2\n[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"{formula}\"\n"
        )
    };
    fs::write(&model, of(&vec!["a"; 200_000].join("+"))).unwrap();
    refused_quickly(
        &["uncertainty", text(&model)],
        &["20000 at most", "intermediate"],
    );
    fs::write(&model, of("log(a)")).unwrap();
    refused_quickly(&["uncertainty", text(&model)], &["ambiguous", "log10"]);
    if cfg!(target_os = "linux") {
        refused_quickly(&["uncertainty", "/dev/zero"], &["/dev/zero", "64 MiB"]);
        for command in ["calibrate", "inspect", "noise", "modes", "render", "init"] {
            refused_quickly(&[command, "/dev/zero"], &["/dev/zero"]);
        }
    }
}

#[test]
fn regress_a_number_that_cannot_be_drawn_takes_nothing_with_it() {
    let folder = tempfile::tempdir().unwrap();
    phasors(folder.path(), &rows(&[80.0, 160.0]));
    let toml = folder.path().join("campaign.toml");
    let mut campaign = fs::read_to_string(&toml).unwrap();
    campaign += "[datasheet]\nsensitivity = 1e-300\ntolerance = 1e-300\nunit = \"mV/(m/s²)\"\n";
    fs::write(&toml, campaign).unwrap();
    succeed(&["calibrate", text(folder.path())]);
    let result = folder.path().join("result");
    assert!(result.join("result.json").is_file() && result.join("report.html").is_file());

    let other = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    fs::copy(example.join("recording.csv"), other.path().join("r.csv")).unwrap();
    let campaign = fs::read_to_string(example.join("campaign.toml")).unwrap();
    let campaign = campaign.replace("\"recording.csv\"", "\"r.csv\"");
    let time = campaign
        .lines()
        .find(|l| l.trim_start().starts_with("time"))
        .unwrap();
    let campaign = campaign.replace(time, "sampling_rate_Hz = 1e-300");
    fs::write(other.path().join("campaign.toml"), campaign).unwrap();
    let output = proofmass(&["calibrate", text(other.path())]);
    let said = stderr(&output);
    // Drawn or refused for the rate itself, but no number of three hundred digits and no lost report.
    assert!(
        !said.contains("cannot be drawn") && said.len() < 2000,
        "{said}"
    );
}

#[test]
fn regress_messages_do_not_steer_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let toml = folder.path().join("campaign.toml");
    let hostile = "\\u001b]0;pwned\\u0007\\u001b[31mX\\u202e";
    let bytes = "\u{1b}]0;pwned\u{7}\u{202e}";
    let calibration = folder.path().join("calibration.json");
    let named = folder.path().join(format!("a{bytes}.csv"));
    fs::write(&named, "x\n").unwrap();
    for campaign in [
        format!("kind = \"{hostile}\"\n"),
        format!("kind = \"multi-position\"\n\"{hostile}\" = 1\n"),
        format!("kind = \"multi-position\"\n[recording]\nfile = \"{hostile}\"\n"),
        format!(
            "kind = \"multi-position\"\n[recording]\nfile = \"r.csv\"\ncolumns = {{ x = \"{hostile}\", y = 2, z = 3 }}\n"
        ),
    ] {
        fs::write(&toml, campaign).unwrap();
        let said = refuse(&["calibrate", text(folder.path())]);
        assert!(!said.contains(['\u{1b}', '\u{7}', '\u{202e}']), "{said:?}");
    }
    for document in [
        format!("{{\"schema\":{{\"name\":\"{hostile}\",\"version\":1}}}}"),
        format!(
            "{{\"schema\":{{\"name\":\"proofmass.calibration\",\"version\":1}},\"kind\":\"{hostile}\"}}"
        ),
    ] {
        fs::write(&calibration, document).unwrap();
        let said = refuse(&["validate", text(&calibration), "r.csv"]);
        assert!(!said.contains(['\u{1b}', '\u{7}', '\u{202e}']), "{said:?}");
    }
    for command in ["inspect", "noise", "uncertainty", "render", "verify"] {
        let output = proofmass(&[command, text(&named)]);
        let said = stderr(&output) + &String::from_utf8_lossy(&output.stdout);
        assert!(
            !said.contains(['\u{1b}', '\u{7}', '\u{202e}']),
            "{command}: {said:?}"
        );
    }
}

#[test]
fn regress_labels_are_no_formulas_in_tables() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    fs::copy(
        example.join("recording.csv"),
        folder.path().join("recording.csv"),
    )
    .unwrap();
    let truth = json(&example.join("truth.json"));
    let labels = [
        "=HYPERLINK(\"\"http://evil\"\",\"\"x\"\")",
        "@SUM(1)",
        "+1+cmd",
        "-2+3",
        "plain",
    ];
    let mut segments = "start,end,label\n".to_owned();
    for (k, rest) in truth["standstills"].as_array().unwrap().iter().enumerate() {
        let label = labels[k % labels.len()];
        let _ = writeln!(segments, "{},{},\"{label}\"", rest["start"], rest["end"]);
    }
    fs::write(folder.path().join("segments.csv"), segments).unwrap();
    let campaign = fs::read_to_string(example.join("campaign.toml")).unwrap();
    fs::write(
        folder.path().join("campaign.toml"),
        format!("{campaign}\n[standstill]\nsegments = \"segments.csv\"\n"),
    )
    .unwrap();
    succeed(&["calibrate", text(folder.path())]);
    let table = fs::read_to_string(folder.path().join("result/standstills.csv")).unwrap();
    assert!(table.contains("plain"), "the labels are there");
    for field in table.split([',', '\n']) {
        let field = field.trim_matches('"');
        let number = field.parse::<f64>().is_ok();
        assert!(
            number || !field.starts_with(['=', '@', '+', '-']),
            "{field}"
        );
    }
}

#[test]
fn law_campaigns_of_strangers_can_be_contained() {
    let folder = tempfile::tempdir().unwrap();
    let (camp, secret) = (folder.path().join("camp"), folder.path().join("secret.csv"));
    fs::create_dir(&camp).unwrap();
    fs::write(&secret, "t,x,y,z\n0,SECRET,2,3\n").unwrap();
    let absolute = text(&secret).to_owned();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&secret, camp.join("link.csv")).unwrap();
    let mut names = vec!["../secret.csv", absolute.as_str(), "../camp/../secret.csv"];
    if cfg!(unix) {
        names.push("link.csv");
    }
    for name in names {
        let toml = format!(
            "kind = \"multi-position\"\n[recording]\nfile = \"{name}\"\nunit = \"m/s²\"\ntime_unit = \"s\"\ncolumns = {{ x = 2, y = 3, z = 4 }}\ntime = 1\n\
             [gravity]\nvalue = 9.8\nstandard_uncertainty = 1e-4\n"
        );
        fs::write(camp.join("campaign.toml"), toml).unwrap();
        // As a rule a campaign may name any file, and the message is about what stands in it.
        assert!(
            refuse(&["calibrate", text(&camp)]).contains("SECRET"),
            "{name}"
        );
        let said = refuse(&["calibrate", text(&camp), "--contained"]);
        assert!(said.contains("outside of the folder"), "{name}: {said}");
        assert!(!said.contains("SECRET"), "{name}: {said}");
    }
    // Files inside are read, also from another folder than the one that one stands in.
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let out = folder.path().join("out");
    succeed(&["calibrate", example, "--contained", "-o", text(&out)]);
}

#[test]
fn law_headers_of_any_size_are_read_or_refused_with_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wide.csv");
    let wide = |columns: usize, name: usize| {
        let header: Vec<String> = (0..columns)
            .map(|i| format!("{}{i}", "c".repeat(name)))
            .collect();
        let row = vec!["1.5"; columns].join(",");
        format!("{}\n{row}\n{row}\n{row}\n", header.join(","))
    };
    for (columns, name) in [(9000, 8), (3, 50_000)] {
        fs::write(&file, wide(columns, name)).unwrap();
        let began = Instant::now();
        succeed(&["inspect", text(&file)]);
        assert!(
            began.elapsed().as_secs() < 20,
            "{columns}, {name}: {:?}",
            began.elapsed()
        );
    }
    fs::write(&file, wide(3, 2_000_000)).unwrap();
    refused_quickly(&["inspect", text(&file)], &["wide.csv", "4 MiB"]);
}
