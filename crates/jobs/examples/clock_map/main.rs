//! Sampling rates as they are stated, over what clocks and transports do to time stamps: is value ± 1.96 u right in 95 of 100 recordings?
//!
//! Every recording is a file on the disk, read through the door of `proofmass inspect` and, where its rows are in order, through that of the
//! other commands (`Recording::read`), which must say the same. Arguments: recordings per cell (200), a word that the cells must hold.
//! The table stands in docs/recordings.md.

use proofmass_io::{ColumnRef, Recording, RecordingOptions, inspect};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus as Random;
use std::fmt::Write;
use std::path::Path;

mod stamps;

use stamps::{CELLS, Cell};

/// What a cell gave.
#[derive(Default)]
struct Tally {
    recordings: usize,
    refused: usize,
    /// Relative error and relative standard uncertainty.
    stated: Vec<(f64, f64)>,
    /// Recordings with a finding about the clock.
    told: usize,
    /// Recordings whose other door said something else.
    apart: usize,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(200);
    let only = arguments.next().unwrap_or_default();
    let folder = std::env::temp_dir().join(format!("clock-map-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the recordings");
    println!("| Stamps | covered, % | U/f, median | U / least that covers 95 % | said, % |");
    println!("|---|---|---|---|---|");
    let (mut all, mut within) = (0, 0);
    for cell in CELLS.iter().filter(|c| c.name.contains(&only)) {
        let tally = walk(cell, count, &folder.join("recording.csv"));
        let inside = tally.stated.iter().filter(|(e, u)| e.abs() <= 1.96 * u);
        let covered = inside.count();
        (all, within) = (all + tally.stated.len(), within + covered);
        println!("{}", tally.row(cell.name, covered));
    }
    println!(
        "| all | {:.2} | | | |",
        100.0 * within as f64 / all.max(1) as f64
    );
    let _ = std::fs::remove_dir_all(&folder);
}

impl Tally {
    fn row(&self, name: &str, covered: usize) -> String {
        let n = self.stated.len();
        if n == 0 {
            return format!("| {name} | refused | | | |");
        }
        let percentile = |values: &mut Vec<f64>, p: f64| {
            values.sort_by(f64::total_cmp);
            values[((values.len() - 1) as f64 * p).round() as usize]
        };
        let mut widths: Vec<f64> = self.stated.iter().map(|s| 1.96 * s.1).collect();
        let mut ratios: Vec<f64> = self
            .stated
            .iter()
            .map(|(e, u)| e.abs() / (1.96 * u))
            .collect();
        let mut row = format!(
            "| {name} | {:.1} | {:.1e} | {:.2} | {:.0} |",
            100.0 * covered as f64 / n as f64,
            percentile(&mut widths, 0.5),
            1.0 / percentile(&mut ratios, 0.95),
            100.0 * self.told as f64 / self.recordings as f64,
        );
        if self.refused > 0 {
            let _ = write!(row, " {} refused", self.refused);
        }
        if self.apart > 0 {
            let _ = write!(row, " {} APART", self.apart);
        }
        row
    }
}

fn walk(cell: &Cell, count: usize, path: &Path) -> Tally {
    let mut tally = Tally {
        recordings: count,
        ..Tally::default()
    };
    for seed in 0..count as u64 {
        let mut random = Random::seed_from_u64(seed ^ cell.seed());
        let (text, rate) = cell.recording(&mut random);
        std::fs::write(path, text).expect("room for a recording");
        let seen = inspect(path).expect("a recording");
        let Some(time) = seen.time else {
            tally.refused += 1;
            continue;
        };
        let clock = time.clock;
        tally
            .stated
            .push((clock.rate_hz / rate - 1.0, clock.rate_u_hz / rate));
        tally.told += usize::from(!seen.findings.is_empty() || clock.gaps > 0);
        let options = RecordingOptions {
            columns: vec![ColumnRef::from_word("a")],
            late_stamps: true,
            ..RecordingOptions::default()
        };
        if let Ok(read) = Recording::read(path, &options) {
            let same = read.time.rate_hz() == clock.rate_hz;
            tally.apart += usize::from(!same);
        }
    }
    tally
}
