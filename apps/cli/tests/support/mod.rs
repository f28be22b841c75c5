//! Running the binary and reading what it wrote.
#![allow(dead_code)] // every test file uses its own part

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

/// Runs and insists on exit code 1 and one `error:`; gives back what was said.
pub fn refuse(arguments: &[&str]) -> String {
    let output = proofmass(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
    assert_eq!(said.matches("error:").count(), 1, "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

pub fn json(path: &Path) -> serde_json::Value {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&bytes).expect("JSON")
}

/// (value, u, U) of one quantity of a result.json.
pub fn quantity(result: &serde_json::Value, name: &str) -> (f64, f64, f64) {
    let list = result["quantities"].as_array().expect("quantities");
    let q = list
        .iter()
        .find(|q| q["name"] == name)
        .unwrap_or_else(|| panic!("no {name}"));
    let get = |key: &str| q[key].as_f64().expect("number");
    (get("value"), get("u"), get("U"))
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
        "/../../examples/hand-held/recording.csv"
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
