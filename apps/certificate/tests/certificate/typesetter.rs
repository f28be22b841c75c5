//! Runs the program on a sheet.

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{LazyLock, OnceLock};

use serde_json::Value;

/// Sheets written by hand, then those that `proofmass certificate` writes of every kind of calibration.
pub const SHEETS: [&str; 11] = [
    "one-page-en",
    "forty-frequencies-en",
    "long-names-en",
    "certificate-it",
    "certificate-fa",
    "shaker-single-en",
    "shaker-primary-it",
    "shaker-triaxial-fa",
    "transverse-sensitivity-fa",
    "multi-position-en",
    "temperature-it",
];

pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/sheets/{name}.json"))
}

pub fn sheet(name: &str) -> Value {
    serde_json::from_slice(&fs::read(path(name)).unwrap()).unwrap()
}

pub fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_proofmass-certificate"))
}

/// With the sheet on standard input.
pub fn run(sheet: &[u8], arguments: &[&str]) -> Output {
    let mut child = program()
        .arg("-")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that stops early does not read all of it.
    let _ = child.stdin.take().unwrap().write_all(sheet);
    child.wait_with_output().unwrap()
}

/// The PDF of a sheet of `tests/sheets`, which is made once for all tests.
pub fn typeset(name: &str, folder: &Path) -> PathBuf {
    static MADE: LazyLock<HashMap<&str, OnceLock<Vec<u8>>>> =
        LazyLock::new(|| SHEETS.map(|name| (name, OnceLock::new())).into());
    let pdf = folder.join(format!("{name}.pdf"));
    let bytes = MADE[name].get_or_init(|| {
        let output = program()
            .arg(path(name))
            .arg("-o")
            .arg(&pdf)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        fs::read(&pdf).unwrap()
    });
    fs::write(&pdf, bytes).unwrap();
    pdf
}
