//! Simulated axes and what `proofmass velocity` makes of them.
#![allow(dead_code)] // every test file uses its own part

use super::{json, succeed, text};
use std::path::{Path, PathBuf};

/// Columns of a CSV file; an empty field is `None`.
pub fn columns(path: &Path) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names: Vec<String> = lines
        .next()
        .expect("headings")
        .split(',')
        .map(str::to_owned)
        .collect();
    let mut data = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, field) in data.iter_mut().zip(line.split(',')) {
            column.push(field.parse().ok());
        }
    }
    (names, data)
}

pub fn column(path: &Path, name: &str) -> Vec<f64> {
    let (names, data) = columns(path);
    let at = names.iter().position(|n| n == name);
    let at = at.unwrap_or_else(|| panic!("no {name} in {names:?}"));
    data[at].iter().map(|v| v.expect("a number")).collect()
}

/// Simulates an axis into `folder/axis` and gives that folder back.
pub fn axis(folder: &Path, arguments: &[&str]) -> PathBuf {
    let place = folder.join("axis");
    let mut all = vec!["simulate", "axis", "-o", text(&place)];
    all.extend(arguments);
    succeed(&all);
    place
}

/// Arguments that tell the simulated sensors.
pub const SENSORS: [&str; 8] = [
    "--position",
    "encoder",
    "--counts-per-turn",
    "2000",
    "--radius",
    "0.3",
    "--acceleration",
    "acceleration",
];

pub fn run(question: &str, recording: &Path, arguments: &[&str]) -> Vec<String> {
    let mut all = vec!["velocity", question, text(recording)];
    all.extend(arguments);
    all.into_iter().map(str::to_owned).collect()
}

pub fn estimate(recording: &Path, out: &Path, arguments: &[&str]) -> serde_json::Value {
    let mut all = run("estimate", recording, arguments);
    all.extend(["-o".to_owned(), text(out).to_owned()]);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let said = succeed(&all);
    let shown = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(!shown.contains("NaN") && !shown.contains("inf"), "{shown}");
    json(&out.join("result.json"))
}

pub fn rms(a: &[f64], b: &[f64], skip: usize) -> f64 {
    let sum: f64 = a
        .iter()
        .zip(b)
        .skip(skip)
        .map(|(a, b)| (a - b) * (a - b))
        .sum();
    (sum / (a.len() - skip) as f64).sqrt()
}
