//! Running a peer and timing ourselves.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// What the lines of a peer said: name to seconds and a figure to compare.
pub(crate) struct Peers(HashMap<String, (f64, f64)>);

impl Peers {
    /// Runs a Python script of this folder with arguments.
    pub(crate) fn run(
        script: &str,
        arguments: &[&Path],
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let python = std::env::var("PROOFMASS_BENCH_PYTHON").unwrap_or_else(|_| "python3".into());
        let path = format!("{}/src/{script}", env!("CARGO_MANIFEST_DIR"));
        let output = Command::new(&python).arg(path).args(arguments).output()?;
        if !output.status.success() {
            return Err(format!("{python}: {}", String::from_utf8_lossy(&output.stderr)).into());
        }
        let text = String::from_utf8(output.stdout)?;
        let line = |line: &str| {
            let mut words = line.split_whitespace();
            Some((
                words.next()?.to_owned(),
                (words.next()?.parse().ok()?, words.next()?.parse().ok()?),
            ))
        };
        Ok(Self(text.lines().filter_map(line).collect()))
    }

    /// Seconds and figure of one measurement.
    pub(crate) fn get(&self, name: &str) -> Result<(f64, f64), String> {
        let found = self.0.get(name).copied();
        found.ok_or(format!("the peer did not report {name}"))
    }
}

/// Seconds of the best of several runs.
pub(crate) fn best(repeats: usize, mut f: impl FnMut()) -> f64 {
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}
