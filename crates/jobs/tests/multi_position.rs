//! The multi-position job from memory alone.

use crate::support;
use proofmass_core::Gravity;
use proofmass_documents::{CalibrationFile, ThermalBlock};
use proofmass_io::{Input, Unit};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::multi_position::{MultiPositionData, MultiPositionJob};
use proofmass_jobs::validation::{ValidationData, ValidationJob};
use proofmass_jobs::{Job, Memory, Outcome, Record, StoredResult, TroubleKind, Unwatched};
use proofmass_rig::HandHeld;
use proofmass_uncertainty::{Estimate, Finding};
use std::sync::Arc;

fn job() -> MultiPositionJob {
    MultiPositionJob::new(Gravity::given(9.80665, 1e-5).unwrap())
}

#[test]
fn law_outcome_comes_back_to_the_byte() {
    let recording = HandHeld::default().simulate(1);
    let [x, y, z] = &recording.outputs;
    let data = MultiPositionData::new([x, y, z], recording.rate, Unit::Count);
    let outcome = job().evaluate(&data, &Unwatched).unwrap();
    assert_eq!(outcome.quantities().len(), 10);
    support::law_outcome_comes_back(&outcome);
}

#[test]
fn law_a_request_is_plain_data() {
    let text = serde_json::to_string(&job()).unwrap();
    assert_eq!(
        serde_json::from_str::<MultiPositionJob>(&text).unwrap(),
        job()
    );
}

#[test]
fn law_an_onlooker_can_stop_it() {
    let recording = HandHeld::default().simulate(1);
    let [x, y, z] = &recording.outputs;
    let data = MultiPositionData::new([x, y, z], recording.rate, Unit::Count);
    let trouble = job().evaluate(&data, &support::Stop).unwrap_err();
    assert_eq!(trouble.kind(), TroubleKind::Cancelled);
}

/// A campaign whose files never touch a disk.
#[test]
fn law_a_campaign_runs_from_memory() {
    let recording = HandHeld::default().simulate(7);
    let mut text = String::from("time_s,x,y,z\n");
    for i in 0..recording.outputs[0].len() {
        let [x, y, z] = [0, 1, 2].map(|axis| recording.outputs[axis][i]);
        text += &format!("{:.3},{x},{y},{z}\n", i as f64 / recording.rate);
    }
    let campaign = "kind = \"multi-position\"\n[recording]\nfile = \"recording.csv\"\n\
        columns = { x = \"x\", y = \"y\", z = \"z\" }\nunit = \"count\"\n\
        [gravity]\nvalue = 9.80665\nstandard_uncertainty = 1e-5\n";
    let store = Memory::new()
        .file("campaign.toml", campaign)
        .file("recording.csv", text);
    let Campaign::MultiPosition(campaign) =
        Campaign::read(Arc::new(store), "campaign.toml").unwrap()
    else {
        panic!("another kind");
    };
    let recordings = campaign.load(&Unwatched).unwrap();
    let job = campaign.job(&recordings).unwrap();
    let outcome = job.evaluate(&recordings.data(), &Unwatched).unwrap();
    let names: Vec<&str> = recordings
        .inputs()
        .iter()
        .map(|i| i.path.as_str())
        .collect();
    assert_eq!(names, ["campaign.toml", "recording.csv"]);
    let scale = &outcome.quantities()[3];
    assert_eq!(scale.name, "scale.x");
    assert!((scale.value - 415.2).abs() < 4.0 * scale.u.unwrap());
}

/// The highest rest is cut off in the middle of its noise, or wholly; rests themselves are no limit of the range.
#[test]
fn known_cut_off_rests_are_found_and_whole_ones_are_not() {
    for seed in 0..8 {
        let recording = HandHeld::default().simulate(seed);
        let [x, y, z] = &recording.outputs;
        let clipped = |x: &[f64]| -> Vec<String> {
            let data = MultiPositionData::new([x, y, z], recording.rate, Unit::Count);
            let outcome = job().evaluate(&data, &Unwatched).unwrap();
            let found = outcome.findings().iter().filter(|f| f.code() == "clipped");
            found.map(|f| f.to_string()).collect()
        };
        assert_eq!(clipped(x), Vec::<String>::new(), "{seed}");
        let means = recording.rests.iter().map(|rest| {
            let rest = &x[rest.start..rest.end];
            rest.iter().sum::<f64>() / rest.len() as f64
        });
        let highest = means.fold(f64::NEG_INFINITY, f64::max);
        for below in [0.0, 0.002] {
            let at = (highest * (1.0 - below)).round();
            let cut: Vec<f64> = x.iter().map(|v| v.min(at)).collect();
            let found = clipped(&cut);
            assert!(
                found.len() == 1 && found[0].contains("output x is cut off at the upper end"),
                "{seed} {below} {found:?}"
            );
        }
    }
}

/// A calibration says little of the recording that it was made of, nothing without its uncertainty, and at one temperature what it
/// knows of many.
#[test]
fn known_validations_that_prove_little() {
    let recording = HandHeld::default().simulate(1);
    let [x, y, z] = &recording.outputs;
    let data = MultiPositionData::new([x, y, z], recording.rate, Unit::Count);
    let outcome = job().evaluate(&data, &Unwatched).unwrap();
    let record = Record {
        inputs: vec![Input {
            path: "r.csv".into(),
            sha256: "ab".repeat(32),
            ..Input::default()
        }],
        ..Record::default()
    };
    let files = StoredResult::new(record, &outcome)
        .unwrap()
        .files()
        .unwrap();
    let file = files
        .iter()
        .find(|(name, _)| name == "calibration.json")
        .unwrap();
    let good = CalibrationFile::from_json(&file.1).unwrap();
    let fresh = HandHeld::default().simulate(2);
    let told = |calibration: &CalibrationFile, sha256: &str| {
        let [x, y, z] = &fresh.outputs;
        let data = ValidationData {
            calibration,
            outputs: [x, y, z],
            rate: fresh.rate,
            breaks: &[],
            segments: None,
            findings: &[],
            sha256: Some(sha256),
            name: "fresh",
        };
        let outcome = ValidationJob::default()
            .evaluate(&data, &Unwatched)
            .unwrap();
        outcome.findings().to_vec()
    };
    let other = "cd".repeat(32);
    let code = |f: &[Finding], code: &str| f.iter().any(|f| f.code() == code);
    assert!(told(&good, &other).is_empty());
    assert!(code(&told(&good, &"ab".repeat(32)), "same-recording"));
    let mut bare = good.clone();
    bare.estimate = Estimate::new(vec![], vec![]).unwrap();
    assert!(code(
        &told(&bare, &other),
        "calibration-without-uncertainty"
    ));
    let mut thermal = good.clone();
    thermal.temperature = Some(ThermalBlock {
        reference: 23.5,
        bias: vec![[0.0; 3]; 3],
        scale: vec![[0.0; 3]; 3],
        range: [-20.0, 60.0],
        hysteresis: None,
    });
    let found = told(&thermal, &other);
    let found = found
        .iter()
        .find(|f| f.code() == "temperature-not-followed")
        .unwrap();
    assert_eq!(found.evidence_text(), "23.5 °C");
}
