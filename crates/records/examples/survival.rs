//! Kills a writer at random instants, lets two write at once, and flips single bits in the database and in kept files: nothing committed is
//! lost, no lock remains, every flipped bit is found or harmless.
//!
//! `cargo run --release -p proofmass-records --example survival [KILLS] [BITS] [OPERATIONS] [URL]`; with the URL of an empty database of
//! PostgreSQL the kills and the two writers are on that.

use proofmass_records::*;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const TODAY: &str = "2026-06-01";

fn candidate(name: &str) -> Candidate {
    let large = name.bytes().cycle().take(100_000).collect();
    Candidate {
        device: proofmass_documents::Device {
            serial: Some(name.into()),
            ..Default::default()
        },
        kind: "test".into(),
        date: TODAY.into(),
        sha256: name.into(),
        quantities: vec![FiledQuantity {
            name: "S".into(),
            unit: "1".into(),
            value: 1.0,
            u: Some(0.1),
            ..Default::default()
        }],
        files: vec![("large.bin".into(), large)],
        ..Default::default()
    }
}

/// Adds results, for ever where no number is given, and says each that is on the disk.
fn write(place: &str, from: u64, count: Option<u64>) -> Result<(), proofmass_jobs::Trouble> {
    let mut records = Records::open_or_make(place)?;
    for k in from..count.map_or(u64::MAX, |n| from + n) {
        records.file_candidate(&candidate(&format!("D{k}")), &Filing::default(), TODAY)?;
        println!("{k}");
        let _ = std::io::stdout().flush();
    }
    Ok(())
}

fn main() -> Result<(), proofmass_jobs::Trouble> {
    let arguments: Vec<String> = std::env::args().collect();
    if arguments.get(1).map(String::as_str) == Some("write") {
        let count = arguments.get(4).and_then(|n| n.parse().ok());
        return write(
            &arguments[2],
            arguments[3].parse().unwrap_or_default(),
            count,
        );
    }
    let number = |i: usize, usual: u64| {
        arguments
            .get(i)
            .and_then(|t| t.parse().ok())
            .unwrap_or(usual)
    };
    let (kills, bits) = (number(1, 200), number(2, 200));
    let folder =
        std::env::temp_dir().join(format!("proofmass-records-survival-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("lab.records");
    let place = arguments.get(4).map_or(file.to_str(), |url| Some(url));
    let place = place.expect("a path");
    let mut said = 0_u64;
    let (mut chance, mut last) = (1_u64, 0);
    for kill in 0..kills {
        let mut child = Command::new(&arguments[0])
            .args(["write", place, &said.to_string()])
            .stdout(Stdio::piped())
            .spawn()
            .expect("a process");
        let lines = BufReader::new(child.stdout.take().expect("its output"));
        advance(&mut chance);
        let wait = Duration::from_micros(2_000 + (chance >> 33) % 60_000);
        let began = Instant::now();
        std::thread::spawn({
            let id = child.id();
            move || {
                std::thread::sleep(wait.saturating_sub(began.elapsed()));
                let _ = Command::new("kill").args(["-9", &id.to_string()]).status();
            }
        });
        let committed: Vec<u64> = lines
            .lines()
            .map_while(Result::ok)
            .filter_map(|l| l.parse().ok())
            .collect();
        let _ = child.wait();
        said = committed.last().map_or(said, |k| k + 1);
        let Ok(mut records) = Records::open_to_add(place) else {
            // Killed before the first table was made.
            assert_eq!(said, 0, "kill {kill}");
            continue;
        };
        let count = records.devices(false)?.len() as u64;
        assert!(
            count >= said,
            "kill {kill}: {said} were committed, {count} are there"
        );
        said = count;
        if kill % 20 == 0 || kill + 1 == kills {
            let check = records.check()?;
            assert!(check.is_whole(), "kill {kill}: {:?}", check.damage);
            last = check.entries;
        }
    }
    println!("{kills} kills: {said} results, {last} entries, none lost, chain whole, no lock left");
    two_writers(&arguments[0], place, number(3, 10_000))?;
    // A smaller file for the flipped bits, so that each lies in something.
    let copy = folder.join("bits.records");
    let mut records = Records::open_or_make(copy.to_str().expect("a path"))?;
    for k in 0..60 {
        let small = Candidate {
            files: vec![(
                "small.txt".into(),
                format!("file {k}").repeat(20).into_bytes(),
            )],
            ..candidate(&format!("D{k}"))
        };
        records.file_candidate(&small, &Filing::default(), TODAY)?;
    }
    let single = folder.join("single.records");
    records.backup(&single)?;
    let json = records.export_json()?;
    let good = std::fs::read(&single).expect("a file");
    let (mut found, mut harmless) = (0, 0);
    for _ in 0..bits {
        advance(&mut chance);
        let at = (chance >> 20) as usize % good.len();
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (chance % 8);
        std::fs::write(&single, &bytes).expect("a file");
        match Records::open(single.to_str().expect("a path"))
            .and_then(|mut r| Ok((r.check()?, r.export_json())))
        {
            Ok((check, read)) if check.is_whole() => {
                assert_eq!(read?, json, "byte {at} was changed and nobody says it");
                harmless += 1;
            }
            _ => found += 1,
        }
    }
    println!(
        "{bits} flipped bits of {} bytes: {found} found, {harmless} harmless (unused places), 0 unseen",
        good.len()
    );
    in_kept_files(&folder, bits.min(200), &mut chance)?;
    let _ = std::fs::remove_dir_all(&folder);
    Ok(())
}

/// The next of a row of numbers that are the same every time.
fn advance(chance: &mut u64) {
    *chance = chance
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
}

/// Two processes add so many entries in all, half of them each.
fn two_writers(program: &str, place: &str, operations: u64) -> Result<(), proofmass_jobs::Trouble> {
    let before = Records::open_or_make(place)?.devices(false)?.len() as u64;
    // A result of a new device is two entries.
    let each = operations / 4;
    let began = Instant::now();
    let writers: Vec<_> = [1_000_000, 2_000_000]
        .map(|from: u64| {
            let arguments = [
                "write".into(),
                place.to_owned(),
                from.to_string(),
                each.to_string(),
            ];
            let mut command = Command::new(program);
            command.args(arguments).stdout(Stdio::null());
            command.spawn().expect("a process")
        })
        .into();
    for mut writer in writers {
        assert!(writer.wait().expect("a process").success());
    }
    let seconds = began.elapsed().as_secs_f64();
    let mut records = Records::open(place)?;
    let there = records.devices(false)?.len() as u64 - before;
    assert_eq!(there, 2 * each);
    let check = records.check()?;
    assert!(check.is_whole(), "{:?}", check.damage);
    println!(
        "two writers: {} entries in {seconds:.0} s, all there, chain of {} whole",
        4 * each,
        check.entries
    );
    Ok(())
}

/// Single bits of the files that stand beside the database.
fn in_kept_files(
    folder: &std::path::Path,
    bits: u64,
    chance: &mut u64,
) -> Result<(), proofmass_jobs::Trouble> {
    let place = folder.join("beside.records");
    let place = place.to_str().expect("a path");
    let mut records = Records::open_or_make(place)?;
    for k in 0..5 {
        records.file_candidate(&candidate(&format!("F{k}")), &Filing::default(), TODAY)?;
    }
    let mut kept = Vec::new();
    let mut folders = vec![folder.join("beside.records.files")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder").flatten() {
            match entry.path().is_dir() {
                true => folders.push(entry.path()),
                false => kept.push(entry.path()),
            }
        }
    }
    assert!(!kept.is_empty() && records.check()?.is_whole());
    for _ in 0..bits {
        advance(chance);
        let file = &kept[(*chance >> 40) as usize % kept.len()];
        let good = std::fs::read(file).expect("a file");
        let mut bytes = good.clone();
        let at = (*chance >> 13) as usize % good.len();
        bytes[at] ^= 1 << (*chance % 8);
        std::fs::write(file, &bytes).expect("a file");
        assert!(
            !records.check()?.is_whole(),
            "byte {at} of {}",
            file.display()
        );
        std::fs::write(file, &good).expect("a file");
    }
    println!(
        "{bits} flipped bits of {} kept files: all found",
        kept.len()
    );
    Ok(())
}
