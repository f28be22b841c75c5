//! Laws that hold for the outcome of every job.
#![allow(dead_code)]

use proofmass_core::Watch;
use proofmass_documents::{Ambient, Device};
use proofmass_io::Input;
use proofmass_jobs::{Outcome, Record, StoredResult};
use std::ops::ControlFlow;
use std::sync::Mutex;

/// What a caller knows.
pub fn record() -> Record {
    Record {
        title: Some("Practice".to_owned()),
        device: Device {
            model: Some("ADXL355".to_owned()),
            ..Device::default()
        },
        ambient: Ambient {
            temperature_deg_c: Some(23.1),
            description: None,
        },
        date: Some("2026-01-01".to_owned()),
        inputs: vec![Input {
            path: "recording.csv".to_owned(),
            sha256: "00".repeat(32),
            ..Input::default()
        }],
        ..Record::default()
    }
}

/// Written, read and rendered again, every file is the same to the byte; what result.json states is the principal
/// result of the outcome.
pub fn law_outcome_comes_back<O: Outcome>(outcome: &O) {
    let result = StoredResult::new(record(), outcome).expect("a result");
    let files = result.files().expect("files");
    let json = &files[0].1;
    let read = StoredResult::from_json(json).expect("result.json is read again");
    // What stands beside result.json alone is read from there.
    let beside = |name: &str| {
        let mut files = files.iter();
        Ok(files.find(|f| f.0 == name).expect("the file").1.clone())
    };
    let read = read.with_files_beside(beside).expect("the files beside it");
    let again = read.files().expect("files of the result that was read");
    assert_eq!(files.len(), again.len());
    for ((name, a), (other, b)) in files.iter().zip(&again) {
        assert_eq!(name, other);
        assert!(a == b, "{name} differs after reading the result again");
    }
    assert_eq!(read.quantities(), outcome.quantities());
    assert_eq!(read.findings(), outcome.findings());
    assert!(StoredResult::from_json(&json[..json.len() / 2]).is_err());
}

/// The page of an outcome as a text.
pub fn page<O: Outcome>(outcome: &O) -> String {
    let result = StoredResult::new(record(), outcome).expect("a result");
    let mut files = result.files().expect("files").into_iter();
    let page = files.find(|f| f.0 == "report.html").expect("a page");
    String::from_utf8(page.1).expect("a text")
}

/// An onlooker that stops at once.
pub struct Stop;

impl Watch for Stop {
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

/// An onlooker that keeps what it was told.
#[derive(Default)]
pub struct Steps(Mutex<Vec<(&'static str, u64, u64)>>);

impl Watch for Steps {
    fn progress(&self, stage: &'static str, done: u64, of: u64) -> ControlFlow<()> {
        self.0.lock().expect("steps").push((stage, done, of));
        ControlFlow::Continue(())
    }
}

impl Steps {
    /// What is told has a name; a stage whose steps are counted goes up until all are behind, and only then begins anew. The
    /// last thing told is that all is done.
    pub fn law_they_go_up_to_the_end(&self, kind: &str) {
        let steps = self.0.lock().expect("steps");
        let mut shares = std::collections::BTreeMap::new();
        for &(stage, done, of) in steps.iter() {
            assert!(stage.len() > 2, "{kind}: a stage without a name");
            assert!(of == 0 || done <= of, "{kind}, {stage}: {done} of {of}");
            if of == 0 {
                continue;
            }
            let share = done as f64 / of as f64;
            let before: f64 = shares.insert(stage, share).unwrap_or(0.0);
            assert!(
                before <= share || before == 1.0,
                "{kind}, {stage} goes back from {before} to {share}"
            );
        }
        for (stage, share) in shares {
            assert_eq!(share, 1.0, "{kind}, {stage} does not end");
        }
        let last = steps.last().expect("something is told");
        assert!(last.1 == last.2 && last.2 > 0, "{kind} ends with {last:?}");
    }
}
