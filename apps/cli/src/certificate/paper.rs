//! The certificate on paper, by a program of its own: typesetting builds for minutes, and needs a newer compiler than the rest.

use crate::Failure;
use proofmass::jobs::certificate::CertificateOutcome;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const PROGRAM: &str = "proofmass-certificate";

/// Writes the PDF.
pub(super) fn write(outcome: &CertificateOutcome, place: &Path) -> Result<(), Failure> {
    let missing = |why: String| {
        Failure::new(format!("the program {PROGRAM}, which typesets certificates, cannot be started: {why}"))
            .hint("put proofmass-certificate beside proofmass or on the PATH (it is built from the same source); or leave --pdf out: every other file is written")
    };
    let sheet = outcome.whole_sheet()?;
    let mut child = Command::new(crate::beside(PROGRAM))
        .arg("-")
        .arg("-o")
        .arg(place)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| missing(e.to_string()))?;
    if let Some(mut input) = child.stdin.take() {
        // A program that ends early says why itself.
        let _ = input.write_all(&sheet);
    }
    let ended = child
        .wait_with_output()
        .map_err(|e| missing(e.to_string()))?;
    if ended.status.success() && place.is_file() {
        return Ok(());
    }
    Err(refused(&String::from_utf8_lossy(&ended.stderr)))
}

/// What the program says: what is wrong, where in the sheet, what to do.
fn refused(said: &str) -> Failure {
    let mut lines: Vec<&str> = said
        .lines()
        .map(str::trim)
        .filter(|l| !l.is_empty())
        .collect();
    let hint = lines.iter().position(|l| l.starts_with("hint: "));
    let hint = hint.map(|i| lines.remove(i).trim_start_matches("hint: ").to_owned());
    let mut lines = lines.into_iter();
    let what = lines.next().unwrap_or("it says nothing");
    let what = what.trim_start_matches("error: ");
    let failure = Failure::new(format!("{PROGRAM} has not typeset the certificate: {what}"));
    let rest = "without --pdf every other file is written, sheet.json too, which is what was to be typeset";
    let hint = hint.map_or_else(|| rest.to_owned(), |hint| format!("{hint}; {rest}"));
    lines.fold(failure, |f, line| f.detail(line)).hint(hint)
}
