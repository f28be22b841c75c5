//! Damaged files of every form: nothing panics, and what is accepted keeps its promises.
//!
//! The targets of the fuzzer on the stable compiler: every seed of `fuzz/corpus` with mutations from a fixed seed.
//! `PROOFMASS_MUTATIONS` sets how many there are of each seed; `fuzz/README.md` says how the fuzzer itself runs.

#[path = "../../../fuzz/targets.rs"]
mod targets;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::PathBuf;

/// Words that break careless readers.
const HOSTILE: [&[u8]; 24] = [
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"1e400",
    b"-0",
    b"0",
    b"1e999999999",
    b"99999999999999999999",
    b"-9223372036854775808",
    b"18446744073709551615",
    b"0x10",
    b"\xef\xbb\xbf",
    b"\0",
    b"\r",
    b"\"",
    b"\\u0000",
    b"\x1b[31m",
    b"\xe2\x80\xae",
    b"[[",
    b"{}",
    b"\xff\xfe",
];

fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(name);
    let mut all: Vec<(PathBuf, Vec<u8>)> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.clone(), std::fs::read(path).unwrap()))
        .collect();
    all.sort();
    assert!(!all.is_empty(), "{}", folder.display());
    all
}

fn mutated(seed: &[u8], other: &[u8], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..=4) {
        let n = bytes.len();
        let at = rng.random_range(0..=n);
        let end = (at + rng.random_range(0..=32usize)).min(n);
        match rng.random_range(0..8) {
            0 if at < n => bytes[at] ^= 1 << rng.random_range(0..8),
            1 if at < n => bytes[at] = rng.random(),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => {
                let piece = bytes[at..end].to_vec();
                let times = rng.random_range(1..=20);
                let to = rng.random_range(0..=n);
                drop(bytes.splice(to..to, piece.repeat(times)));
            }
            5 => {
                let word = HOSTILE[rng.random_range(0..HOSTILE.len())];
                drop(bytes.splice(at..at, word.iter().copied()));
            }
            6 => {
                // A number becomes a hostile word.
                let digit = |b: &u8| b.is_ascii_digit() || *b == b'.';
                if let Some(start) = bytes[at..].iter().position(digit).map(|i| at + i) {
                    let length = bytes[start..].iter().take_while(|b| digit(b)).count();
                    let word = HOSTILE[rng.random_range(0..12)];
                    drop(bytes.splice(start..start + length, word.iter().copied()));
                }
            }
            _ => {
                let from = rng.random_range(0..=other.len());
                let to = (from + rng.random_range(0..=200usize)).min(other.len());
                drop(bytes.splice(at..end, other[from..to].iter().copied()));
            }
        }
    }
    bytes
}

fn run(name: &str, target: fn(&[u8])) {
    let count = std::env::var("PROOFMASS_MUTATIONS")
        .ok()
        .and_then(|n| n.parse().ok());
    let count: u64 = count.unwrap_or(200);
    let seeds = corpus(name);
    for (index, (path, seed)) in seeds.iter().enumerate() {
        target(seed);
        for number in 0..count {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(number ^ (index as u64) << 32);
            let other = &seeds[rng.random_range(0..seeds.len())].1;
            let bytes = mutated(seed, other, &mut rng);
            let caught = std::panic::catch_unwind(|| target(&bytes));
            if caught.is_err() {
                let kept = std::env::temp_dir().join(format!("proofmass-{name}-{number}"));
                std::fs::write(&kept, &bytes).unwrap();
                panic!(
                    "{}, mutation {number}: see {}",
                    path.display(),
                    kept.display()
                );
            }
        }
    }
}

#[test]
fn law_damaged_recordings() {
    run("recording", targets::recording);
}

#[test]
fn law_damaged_waveforms() {
    run("waveform", targets::waveform);
}

#[test]
fn law_damaged_streams() {
    run("streams", targets::streams);
}

#[test]
fn law_damaged_documents() {
    run("documents", targets::documents);
}

#[test]
fn law_damaged_results() {
    run("results", targets::results);
}

#[test]
fn law_damaged_models() {
    run("model", targets::model);
}

#[test]
fn law_damaged_campaigns() {
    run("campaign", targets::campaign);
}
