//! What a person meets first: help in groups, words of the field, arguments in a file.

use crate::support::{json, proofmass, refuse, stderr, succeed, text};
use std::path::Path;

fn stdout(arguments: &[&str]) -> String {
    String::from_utf8(succeed(arguments).stdout).expect("text in UTF-8")
}

/// Wrong use: exit code 2, and what was said.
fn wrong(arguments: &[&str]) -> String {
    let output = proofmass(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    said
}

#[test]
fn the_first_page_shows_groups_and_both_helps_of_a_command_their_options() {
    for arguments in [&["--help"][..], &["-h"], &["help"]] {
        let page = stdout(arguments);
        let mut from = 0;
        for heading in [
            "Calibrate:",
            "Test:",
            "Noise:",
            "Velocity:",
            "Uncertainty:",
            "Files and results:",
        ] {
            let at = page[from..].find(heading);
            from += at.unwrap_or_else(|| panic!("{heading} in {page}"));
        }
        assert!(page.contains("  velocity     Velocity from"), "{page}");
    }
    let short = stdout(&["velocity", "estimate", "-h"]);
    assert!(short.contains("\nAccelerometer:\n"), "{short}");
    assert!(short.contains("\n      --counts-per-turn <N>"), "{short}");
    assert!(!short.contains("\n      --excitation"), "{short}");
    assert!(stdout(&["velocity", "estimate", "--help"]).contains("\n      --excitation <COLUMN>"));
}

#[test]
fn a_word_of_the_field_leads_to_its_command_and_a_misspelt_command_to_the_nearest() {
    let said = wrong(&["allan", "rest.csv"]);
    assert!(said.contains("`allan` is not a command"), "{said}");
    assert!(said.contains("use `proofmass noise RECORDING`"), "{said}");
    let said = wrong(&["test", "psd"]);
    assert!(said.contains("use `proofmass noise RECORDING`"), "{said}");
    let said = wrong(&["tilt", "table.csv"]);
    assert!(said.contains("`proofmass test tilt"), "{said}");
    // A term of two words, as it is written.
    let said = wrong(&["static", "interval", "rest.csv"]);
    assert!(
        said.contains("`static interval` is not a command"),
        "{said}"
    );
    assert!(
        said.contains("use `proofmass calibrate RECORDING`"),
        "{said}"
    );
    let said = wrong(&["calibrat", "x"]);
    assert!(said.contains("'calibrate'"), "{said}");
}

#[test]
fn explain_knows_the_words_of_the_glossary() {
    for word in ["VRW", "velocity-random-walk", "velocity random walk"] {
        let one = stdout(&["explain", word]);
        assert!(one.starts_with("velocity random walk (also: VRW"), "{one}");
        assert!(
            one.contains("command: proofmass noise RECORDING\n"),
            "{one}"
        );
    }
    assert_eq!(
        stdout(&["explain", "velocity", "random", "walk"]),
        stdout(&["explain", "VRW"])
    );
    let all: serde_json::Value =
        serde_json::from_str(&stdout(&["explain", "bias-instability", "--json"])).expect("JSON");
    assert_eq!(all[0]["words"][0], "bias instability");
    // K is a random walk, k a coverage factor: all that a word may mean is shown.
    let k = stdout(&["explain", "K"]);
    assert!(
        k.contains("acceleration random walk") && k.contains("expanded uncertainty"),
        "{k}"
    );
    refuse(&["explain", "no-such-word"]);
}

const PRESET: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/encoder/quadrature.args"
);

#[test]
fn arguments_in_a_file_are_those_that_are_typed() {
    let folder = tempfile::tempdir().expect("folder");
    let bench = folder.path().join("bench");
    succeed(&["simulate", "axis", "-o", text(&bench)]);
    let recording = bench.join("recording.csv");
    let result = |name: &str, options: &[&str]| {
        let out = folder.path().join(name);
        let call = [
            "velocity",
            "estimate",
            text(&recording),
            "--method",
            "observer:5,25",
        ];
        succeed(&[&call[..], options, &["-o", text(&out)]].concat());
        json(&out.join("result.json"))["quantities"].clone()
    };
    let preset = format!("@{PRESET}");
    let typed = [
        "--position",
        "encoder",
        "--counts-per-turn",
        "2000",
        "--radius",
        "0.3",
        "--acceleration",
        "acceleration",
    ];
    assert_eq!(result("file", &[&preset]), result("typed", &typed));
}

#[test]
fn an_error_in_a_file_of_arguments_names_its_line() {
    let folder = tempfile::tempdir().expect("folder");
    let said = |lines: &str| {
        let file = folder.path().join("options.args");
        std::fs::write(&file, lines).expect("file");
        wrong(&[
            "velocity",
            "estimate",
            "run.csv",
            &format!("@{}", text(&file)),
        ])
    };
    let place = |said: &str, line: usize| {
        assert!(said.contains(&format!("options.args:{line}: ")), "{said}");
    };
    place(&said("# wheel\n--position count\n--radius wide\n"), 3);
    place(&said("--position count\n--raduis 0.3\n"), 2);
    place(&said("--bits 16\n\n--bits 12\n"), 3);
    place(&said("--position count\n--speed wheel\n"), 1);
    let gone = wrong(&["velocity", "estimate", "run.csv", "@no-such.args"]);
    assert!(
        gone.contains("@no-such.args stands for the arguments in that file"),
        "{gone}"
    );
    assert!(!Path::new("no-such.args").exists());
}

/// What a shell is given knows every command, and there is a manual page of each.
#[test]
fn law_completions_and_manual_have_every_command() {
    let commands = proofmass_cli::commands();
    let named: Vec<&str> = commands.get_subcommands().map(|c| c.get_name()).collect();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = stdout(&["completions", shell]);
        let missing: Vec<_> = named.iter().filter(|n| !text.contains(**n)).collect();
        assert!(missing.is_empty(), "{shell}: {missing:?}");
        assert!(text.contains("imu-yaml"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("man1");
    succeed(&["manual", "-o", text(&place)]);
    for name in named.iter().filter(|n| **n != "help") {
        let page = std::fs::read_to_string(place.join(format!("proofmass-{name}.1"))).expect(name);
        assert!(page.contains(".SH OPTIONS"), "{name}");
    }
    assert!(place.join("proofmass-noise-compare.1").is_file());
    assert!(refuse(&["manual", "-o", text(&place)]).contains("cannot be made"));
}
