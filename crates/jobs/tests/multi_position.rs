//! The multi-position job from memory alone.

mod support;

use proofmass_core::Gravity;
use proofmass_io::Unit;
use proofmass_jobs::multi_position::{MultiPositionData, MultiPositionJob};
use proofmass_jobs::{Job, Outcome, TroubleKind, Unwatched};
use proofmass_rig::HandHeld;

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
    support::law_outcome_comes_back(outcome);
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
