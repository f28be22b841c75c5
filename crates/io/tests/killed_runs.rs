//! Runs that are killed: the results are those before or those after, and the next run leaves no litter.

#![cfg(unix)]

use proofmass_io::{AtomicFile, Manifest, OutputFolder};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PLACE: &str = "PROOFMASS_TEST_KILLED_PLACE";

/// Writes results again and again until it is killed: eight files, all with the number of the run.
#[test]
fn child() {
    let Some(place) = std::env::var_os(PLACE) else {
        return;
    };
    let place = Path::new(&place);
    for run in 0_u64.. {
        once(&place.join("result"), run);
        let mut file = AtomicFile::create(place.join("one.csv"), &[]).unwrap();
        for _ in 0..100 {
            file.write_all(format!("{run}\n").repeat(100).as_bytes())
                .unwrap();
        }
        file.commit().unwrap();
    }
}

fn once(place: &Path, run: u64) {
    let folder = OutputFolder::create(place, false).unwrap();
    folder
        .write(
            "result.json",
            format!(r#"{{"schema":{{"name":"proofmass.result","version":2}},"kind":"noise","title":"{run}"}}"#),
        )
        .unwrap();
    for i in 0..7 {
        folder
            .write(&format!("table-{i}.csv"), format!("{run}\n").repeat(1000))
            .unwrap();
    }
    folder.commit().unwrap();
}

/// Numbers of the runs whose files stand there.
fn runs(folder: &Path) -> Vec<u64> {
    let mut all: Vec<u64> = (0..7)
        .map(|i| {
            let text = fs::read_to_string(folder.join(format!("table-{i}.csv"))).unwrap();
            let first: u64 = text.lines().next().unwrap().parse().unwrap();
            assert_eq!(
                text,
                format!("{first}\n").repeat(1000),
                "a file is half written"
            );
            first
        })
        .collect();
    all.dedup();
    all
}

fn kills(with_foreign: bool, count: u32) {
    let above = tempfile::tempdir().unwrap();
    let result = above.path().join("result");
    once(&result, 0);
    if with_foreign {
        fs::write(result.join("notes.txt"), "mine").unwrap();
    }
    let program = std::env::current_exe().unwrap();
    let mut state = 42_u64;
    let mut unfinished = 0;
    for _ in 0..count {
        let mut child = Command::new(&program)
            .args(["--exact", "child"])
            .env(PLACE, above.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let wait = Duration::from_micros(2_000 + (state >> 33) % 30_000);
        let start = Instant::now();
        while start.elapsed() < wait {
            std::thread::sleep(Duration::from_micros(200));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        // Whole files; one run, or with files to keep two of which the next run finishes the second.
        let found = runs(&result);
        assert!(found.len() == 1 || with_foreign, "{found:?}");
        let litter = fs::read_dir(above.path()).unwrap().count() > 2;
        unfinished += u32::from(litter || found.len() > 1);
        drop(OutputFolder::create(&result, false).unwrap());
        assert_eq!(runs(&result).len(), 1, "the next run completes it");
        let manifest = Manifest::read(&result).unwrap().unwrap();
        assert!(manifest.files.iter().all(|f| f.is_unchanged(&result)));
        if let Ok(text) = fs::read_to_string(above.path().join("one.csv")) {
            let first = text.lines().next().unwrap();
            assert_eq!(text, format!("{first}\n").repeat(10_000));
        }
        drop(AtomicFile::create(above.path().join("one.csv"), &[]).unwrap());
        let left: Vec<_> = fs::read_dir(above.path())
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .filter(|n| n != "result" && n != "one.csv")
            .collect();
        assert!(left.is_empty(), "{left:?}");
        let files = fs::read_dir(&result).unwrap().count();
        assert_eq!(files, 9 + usize::from(with_foreign));
    }
    if with_foreign {
        assert_eq!(
            fs::read_to_string(result.join("notes.txt")).unwrap(),
            "mine"
        );
    }
    println!("{unfinished} of {count} kills came in the middle of something");
    assert!(unfinished > 0, "no kill met anything");
}

#[test]
fn law_kills_lose_nothing_where_the_folder_is_exchanged() {
    kills(false, 60);
}

#[test]
fn law_kills_lose_nothing_where_files_are_replaced_one_by_one() {
    kills(true, 60);
}

/// Two processes at one place: each folder is whole, whoever comes last.
#[test]
fn law_two_writers_at_once_leave_a_whole_folder() {
    let above = tempfile::tempdir().unwrap();
    let result = above.path().join("result");
    once(&result, 0);
    fs::write(result.join("notes.txt"), "mine").unwrap();
    std::thread::scope(|s| {
        for writer in 0..3_u64 {
            let result = &result;
            s.spawn(move || (0..10).for_each(|i| once(result, 100 * writer + i)));
        }
    });
    assert_eq!(runs(&result).len(), 1);
    assert_eq!(fs::read_dir(&result).unwrap().count(), 10);
    assert_eq!(fs::read_dir(above.path()).unwrap().count(), 1);
}
