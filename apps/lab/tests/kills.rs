//! The program killed while it records: no finished run is lost, and the campaign goes on.

use proofmass::jobs::Unwatched;
use proofmass_lab::evaluation::evaluate;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn start(folder: &Path, speed: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_proofmass-lab"))
        .args([
            "--simulate",
            "--unattended",
            "--start",
            "--no-browser",
            "--port",
            "0",
        ])
        .args(["--duration", "0.4", "--speed", speed, "-o"])
        .arg(folder)
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts")
}

/// Names and files of the runs in the table, each with its recording whole.
fn whole_runs(folder: &Path) -> Vec<String> {
    let Ok(mut reader) = csv::Reader::from_path(folder.join("runs.csv")) else {
        return Vec::new();
    };
    let header = reader.headers().expect("a heading").clone();
    let at = |name: &str| header.iter().position(|h| h == name).expect("a column");
    let (run, file, frequency) = (at("run"), at("file"), at("frequency_Hz"));
    let rows = reader.records().map(|r| r.expect("a row"));
    rows.map(|row| {
        let size = std::fs::metadata(folder.join(&row[file]))
            .expect("a recording")
            .len();
        let frequency: f64 = row[frequency].parse().expect("a number");
        let samples = ((0.4 * frequency).ceil() * 51_200.0 / frequency).round() as u64;
        assert_eq!(size, 16 * samples, "{}", &row[run]);
        row[run].to_owned()
    })
    .collect()
}

#[test]
fn law_kills_lose_no_finished_run() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("m");
    let mut before = Vec::new();
    for kill in 0..8 {
        let mut child = start(&folder, "3");
        std::thread::sleep(Duration::from_millis(250 + 130 * (kill * 5 % 8)));
        child.kill().unwrap();
        child.wait().unwrap();
        let now = whole_runs(&folder);
        assert!(
            before.iter().all(|run| now.contains(run)),
            "{before:?} {now:?}"
        );
        before = now;
    }
    let mut child = start(&folder, "0");
    let begun = Instant::now();
    while whole_runs(&folder).len() < 18 && begun.elapsed() < Duration::from_secs(100) {
        std::thread::sleep(Duration::from_millis(50));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(whole_runs(&folder).len(), 18);
    assert!(evaluate(&folder, "2026-01-01", &Unwatched).is_ok());
    let log = std::fs::read_to_string(folder.join("lab-log.csv")).unwrap();
    println!(
        "{} runs before the last start, {} cut short",
        before.len(),
        log.matches(",killed,").count()
    );
}
