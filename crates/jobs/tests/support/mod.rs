//! Laws that hold for the outcome of every job.
#![allow(dead_code)]

use proofmass_core::Watch;
use proofmass_io::{Ambient, Device, Input};
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
            reading: None,
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
    /// Every stage has a name and goes up; one whose steps are counted ends when all are behind, and so does the whole.
    pub fn law_they_go_up_to_the_end(&self, kind: &str) {
        let steps = self.0.lock().expect("steps");
        let mut by_stage = std::collections::BTreeMap::<_, Vec<(u64, u64)>>::new();
        for (stage, done, of) in steps.iter() {
            by_stage.entry(*stage).or_default().push((*done, *of));
        }
        if std::env::var_os("PROOFMASS_REPORTS").is_some() {
            eprintln!("STEPS {kind} {by_stage:?} LAST {:?}", steps.last());
            return;
        }
        for (stage, told) in by_stage {
            assert!(stage.len() > 2, "{kind}: a stage without a name");
            for pair in told.windows(2) {
                let [(before, of), (after, of_after)] = [pair[0], pair[1]];
                assert!(
                    before <= after && of == of_after,
                    "{kind}, {stage}: {told:?}"
                );
            }
            let (done, of) = told[told.len() - 1];
            assert!(
                of == 0 || done == of,
                "{kind}, {stage} ends at {done} of {of}"
            );
        }
    }
}
