//! Wrong calls as people type them: each message says what is wrong in words of the call, and what to type instead.

use crate::support::*;
use std::fmt::Write;

/// A sensor at rest, 100 Hz, in m/s², with the headings of a phone.
fn at_rest(rows: usize, stamp: impl Fn(usize) -> String) -> String {
    let mut noise = Chance(3);
    let mut text = "time,ax_m/s2,ay_m/s2,az_m/s2\n".to_owned();
    for i in 0..rows {
        let [x, y, z] = [0, 1, 2].map(|_| 1e-2 * noise.normal());
        writeln!(text, "{},{x:.5},{y:.5},{:.5}", stamp(i), 9.81 + z).unwrap();
    }
    text
}

fn seconds(i: usize) -> String {
    format!("{:.2}", i as f64 / 100.0)
}

/// Exit code 1 or 2, and what was said.
fn refused(arguments: &[&str]) -> String {
    let output = proofmass(arguments);
    let said = stderr(&output);
    assert!(
        matches!(output.status.code(), Some(1 | 2)),
        "{arguments:?}: {said}"
    );
    law_a_message_fits_the_call(arguments, &said);
    said
}

#[test]
fn refuses_wrong_calls_with_what_to_type() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: String| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        text_of(path)
    };
    let rest = file("rest.csv", at_rest(3000, seconds));
    let comma = file("words.csv", at_rest(300, |i| format!("{i} samples")));
    let midnight = file(
        "midnight.csv",
        at_rest(400, |i| {
            let t = (86_398 * 100 + i) % 8_640_000;
            let (s, part) = (t / 100, t % 100);
            format!("{:02}:{:02}:{:02}.{part:02}", s / 3600, s / 60 % 60, s % 60)
        }),
    );
    let rest = rest.as_str();
    let place = &["--latitude", "45.07", "--height", "239"];
    let calibrate = |more: &[&str]| refused(&[&["calibrate", rest], &place[..], more].concat());
    for (said, words) in [
        (
            refused(&["calibrate", rest, "--latitude", "45,07"]),
            &["45,07", "--latitude", "45.07"][..],
        ),
        (
            refused(&["calibrate", rest, "--latitude", "north"]),
            &["\"north\" is no number", "--latitude"],
        ),
        (calibrate(&[]), &["standstill", "at least twelve"]),
        (
            calibrate(&["--model", "full"]),
            &["`full`", "at least twelve"],
        ),
        (calibrate(&["--model", "ful"]), &["full", "bias-scale"]),
        (calibrate(&["--between", "5", "2"]), &["--between"]),
        (
            refused(&["calibrate", rest, "--latitude", "91"]),
            &["rest.csv: --latitude"],
        ),
        (
            refused(&["noise", rest, "--statistic", "oaedv"]),
            &["oadev", "hdev"],
        ),
        (
            refused(&["noise", rest, "--between", "0", "0.05"]),
            &["--between"],
        ),
        (
            refused(&["noise", rest, "--between", "1,5", "2,5"]),
            &["1.5"],
        ),
        (
            refused(&["noise", &comma]),
            &[
                "the times in column \"time\" are not read",
                "hh:mm:ss",
                "--rate",
            ],
        ),
        (refused(&["noise", &midnight]), &["midnight"]),
        (refused(&["modes", rest]), &["rest.csv", "TOML", "[wedge]"]),
        (refused(&["uncertainty", rest]), &["rest.csv", "TOML"]),
        (
            refused(&["noise", rest, "-o", "/proc/x"]),
            &["/proc", "takes no new files"],
        ),
    ] {
        for word in words {
            assert!(said.contains(word), "{word:?} is missing from: {said}");
        }
        assert!(!said.contains("as a campaign"), "{said}");
        assert!(!said.contains("invalid float literal"), "{said}");
    }
}

#[test]
fn law_a_refusal_of_what_was_read_begins_with_how_it_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    std::fs::write(&path, at_rest(3000, seconds)).unwrap();
    let rest = text(&path);
    let place = &["--latitude", "45.07", "--height", "239"];
    for (call, known) in [
        (
            [&["calibrate", rest], &place[..]].concat(),
            &["ax", "m/s²", "100 Hz", "g = "][..],
        ),
        (
            vec!["test", "shock", rest, "--column", "ax"],
            &["ax", "m/s²", "100 Hz"],
        ),
        (
            vec!["test", "step", rest, "--column", "ax"],
            &["ax", "m/s²", "100 Hz"],
        ),
        (
            vec![
                "test",
                "impact",
                rest,
                "--input",
                "ax",
                "--output-column",
                "ay",
            ],
            &["ax", "ay", "m/s²", "100 Hz"],
        ),
    ] {
        let said = refused(&call);
        let first = said.lines().next().unwrap();
        assert!(first.starts_with("Read  "), "{call:?}: {said}");
        assert!(said.contains("error["), "{call:?}: {said}");
        for word in [&["rest.csv"], known].concat() {
            assert!(first.contains(word), "{call:?}: no {word} in: {first}");
        }
    }
}

#[test]
fn known_times_of_day_are_a_clock() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("day.csv");
    let stamp = |i: usize| {
        let t = 359_900 + i;
        format!(
            "{:02}:{:02}:{:02}.{:02}",
            t / 360_000,
            t / 6000 % 60,
            t / 100 % 60,
            t % 100
        )
    };
    std::fs::write(&path, at_rest(3000, stamp)).unwrap();
    let output = succeed(&["noise", text(&path), "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let time = &result["inputs"][0]["reading"]["time"];
    assert!(
        (time["rate_hz"].as_f64().unwrap() - 100.0).abs() < 1e-6,
        "{time}"
    );
    assert_eq!(time["by"], "field");
}

fn text_of(path: std::path::PathBuf) -> String {
    path.to_str().unwrap().to_owned()
}
