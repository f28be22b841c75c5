//! Running the binary and reading what it wrote.
#![allow(dead_code)] // every test file uses its own part

pub mod axis;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn proofmass(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(arguments)
        .env("SOURCE_DATE_EPOCH", "1790000000")
        .output()
        .expect("the binary runs")
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs and insists on success.
pub fn succeed(arguments: &[&str]) -> Output {
    let output = proofmass(arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        stderr(&output)
    );
    output
}

/// Runs and insists on exit code 1 and one `error[CODE]:`; gives back what was said.
pub fn refuse(arguments: &[&str]) -> String {
    let output = proofmass(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
    assert_eq!(said.matches("error[").count(), 1, "{said}");
    assert!(!said.contains("panicked"), "{said}");
    law_a_message_fits_the_call(arguments, &said);
    said
}

/// What a refusal advises can be typed: every option it names is one of the command, and keys of a campaign stand only where a
/// campaign was named or is spoken of.
pub fn law_a_message_fits_the_call(arguments: &[&str], said: &str) {
    let commands = match arguments {
        [
            group @ ("test" | "velocity" | "simulate" | "certificate"),
            test,
            ..,
        ] => vec![*group, *test],
        ["noise", "compare", ..] => vec!["noise", "compare"],
        ["device", question, ..] => vec!["device", *question],
        ["records", "add", what, ..] => vec!["records", "add", *what],
        ["records", what, ..] => vec!["records", *what],
        [command, ..] => vec![*command],
        [] => return,
    };
    let help = proofmass(&[&commands[..], &["--help"]].concat());
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    // What another command is told to do stands in back quotes with its name.
    let quoted = said.split('`').enumerate();
    let own: String = quoted
        .filter(|(k, part)| k % 2 == 0 || !part.starts_with("proofmass "))
        .map(|(_, part)| part)
        .collect();
    let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    for (at, _) in own.match_indices("--") {
        let word = own[at + 2..]
            .split(|c| !letter(c))
            .next()
            .unwrap_or_default();
        let option = format!("--{word}");
        let typed = arguments.contains(&option.as_str());
        assert!(
            word.is_empty() || typed || help.contains(&option),
            "{commands:?} has no {option}: {said}"
        );
    }
    // Where a campaign was named, its keys are what to change.
    let of_campaigns = ["calibrate", "plan", "modes"].contains(&commands[0]);
    let campaign = |p: &Path| p.is_dir() || p.extension().is_some_and(|e| e == "toml");
    let limits = ["--limits", "--sheet"]
        .iter()
        .any(|o| arguments.contains(o));
    if limits || of_campaigns && arguments.iter().any(|a| campaign(Path::new(a))) {
        return;
    }
    let of_a_campaign = [
        "[recording]",
        "[standstill]",
        "[method]",
        "[gravity]",
        " = \"",
    ];
    let key = of_a_campaign.iter().find(|key| said.contains(**key));
    assert!(
        key.is_none() || said.contains("campaign"),
        "{commands:?} speaks of {key:?} of a campaign that nobody named: {said}"
    );
}

pub fn json(path: &Path) -> serde_json::Value {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&bytes).expect("JSON")
}

/// (value, u, U) of one quantity of a result.json; U is not a number where the interval is not value ± U.
pub fn quantity(result: &serde_json::Value, name: &str) -> (f64, f64, f64) {
    let list = result["quantities"].as_array().expect("quantities");
    let q = list
        .iter()
        .find(|q| q["name"] == name)
        .unwrap_or_else(|| panic!("no {name}"));
    let get = |key: &str| q[key].as_f64().expect("number");
    let expanded = q.get("interval").map_or_else(|| get("U"), |_| f64::NAN);
    (get("value"), get("u"), expanded)
}

/// The folder of recordings that others made; only tests that are ignored without it ask for it.
pub fn reference_data() -> PathBuf {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md")
        .into()
}

/// A campaign folder with one campaign.toml.
pub fn campaign(folder: &Path, toml: &str) {
    std::fs::create_dir_all(folder).expect("folder");
    std::fs::write(folder.join("campaign.toml"), toml).expect("campaign.toml");
}

/// The recording of the shipped example, as lines.
pub fn example_lines() -> Vec<String> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/hand-held/recording.csv"
    );
    let text = std::fs::read_to_string(path).expect("the example ships with the project");
    text.lines().map(str::to_owned).collect()
}

/// Names in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> = std::fs::read_dir(folder)
        .expect("folder")
        .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
        .collect();
    all.sort();
    all
}

/// Whether a folder holds nothing but what was put there.
pub fn holds_only(folder: &Path, expected: &[&str]) -> bool {
    names(folder) == expected
}

/// Codes of the findings of a result, in their order.
pub fn codes(result: &serde_json::Value) -> Vec<String> {
    let findings = result["findings"].as_array().expect("findings").iter();
    let code = |f: &serde_json::Value| f["code"].as_str().expect("a code").to_owned();
    findings.map(code).collect()
}

/// Numbers by chance, the same on every machine.
pub struct Chance(pub u64);

impl Chance {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normal but for its tails.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Published means of an MPU9250 over its ten repeats: frequency in Hz, m/s² per m/s².
pub const MPU9250_MEANS: [(f64, f64); 7] = [
    (10.0, 1.01917),
    (20.0, 1.01680),
    (40.0, 1.00884),
    (80.0, 0.97718),
    (100.0, 0.95351),
    (160.0, 0.85382),
    (250.0, 0.64397),
];

/// Writes a table, its heading first.
pub fn table(path: &Path, heading: &str, rows: impl Iterator<Item = Vec<f64>>) {
    let mut text = format!("{heading}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    std::fs::write(path, text).expect("a table is written");
}

/// Rows of a table, every field with its heading.
pub fn rows(path: &Path) -> Vec<Vec<(String, String)>> {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines().map(fields);
    let header = lines.next().expect("a header");
    lines
        .map(|fields| header.iter().cloned().zip(fields).collect())
        .collect()
}

/// Fields of a line, which may stand in quotes.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match (c, fields.last_mut()) {
            ('"', _) => quoted = !quoted,
            (',', _) if !quoted => fields.push(String::new()),
            (c, Some(field)) => field.push(c),
            (_, None) => {}
        }
    }
    fields
}

pub fn field<'a>(row: &'a [(String, String)], heading: &str) -> &'a str {
    row.iter()
        .find(|(h, _)| h == heading)
        .map_or_else(|| panic!("no {heading}"), |(_, f)| f.as_str())
}

pub fn number(row: &[(String, String)], heading: &str) -> f64 {
    field(row, heading).parse().expect("a number")
}

/// Copies a folder with what is in it, but for folders of one name.
pub fn copy(from: &Path, to: &Path, but: Option<&str>) {
    std::fs::create_dir_all(to).unwrap();
    for name in names(from) {
        let (from, to) = (from.join(&name), to.join(&name));
        match from.is_dir() {
            true if but == Some(name.as_str()) => {}
            true => copy(&from, &to, but),
            false => drop(std::fs::copy(from, to).unwrap()),
        }
    }
}

/// The noise result of a simulated sensor, white noise over 200 s, in `out`; its recording in `raw`.
pub fn white_noise(sensor: &str, raw: &Path, out: &Path, white: &str, seed: &str) {
    succeed(&[
        "simulate",
        "noise",
        "-o",
        text(raw),
        "--duration",
        "200",
        "--rate",
        "50",
        "--random-walk",
        "0",
        "--white",
        white,
        "--seed",
        seed,
        "--sensor",
        sensor,
    ]);
    succeed(&["noise", text(&raw.join("recording.csv")), "-o", text(out)]);
}
