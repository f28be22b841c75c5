//! The uncertainty job from memory alone.

use crate::support;
use proofmass_jobs::uncertainty::UncertaintyJob;
use proofmass_jobs::{Job, StoredResult, TroubleKind, Unwatched};
use proofmass_uncertainty::{Evaluate, StatementMethod, Trials};

fn job(text: &str) -> UncertaintyJob {
    UncertaintyJob {
        model: proofmass_documents::read_model(text).unwrap(),
        options: Evaluate {
            trials: Trials::Fixed(100_000),
            ..Evaluate::default()
        },
    }
}

const IMPEDANCE: &str = include_str!("models/impedance.toml");

/// A sum of squares near zero: the law of propagation would state an interval below zero.
const SQUARES: &str = r#"
[[input]]
name = "x1"
unit = "1"
value = 0.010
u = 0.005
[[input]]
name = "x2"
unit = "1"
value = 0
u = 0.005
[[output]]
name = "y"
unit = "1"
expression = "x1^2 + x2^2"
"#;

#[test]
fn law_outcome_comes_back_to_the_byte() {
    for text in [IMPEDANCE, SQUARES] {
        support::law_outcome_comes_back(&job(text).evaluate(&(), &Unwatched).unwrap());
    }
}

#[test]
fn law_a_request_is_plain_data() {
    let text = serde_json::to_string(&job(IMPEDANCE)).unwrap();
    assert_eq!(
        serde_json::from_str::<UncertaintyJob>(&text).unwrap(),
        job(IMPEDANCE)
    );
}

#[test]
fn law_an_onlooker_can_stop_it() {
    let trouble = job(SQUARES).evaluate(&(), &support::Stop).unwrap_err();
    assert_eq!(trouble.kind(), TroubleKind::Cancelled);
}

/// What result.json, summary and report state is one result, also where Monte Carlo contradicts the linear one.
#[test]
fn regress_one_result_in_every_document() {
    let outcome = job(SQUARES).evaluate(&(), &Unwatched).unwrap();
    let stated = outcome.result.outputs[0].stated.clone();
    assert_eq!(stated.method, StatementMethod::MonteCarlo);
    assert!(stated.interval.lower > 0.0, "{stated:?}");
    let filed = StoredResult::new(support::record(), &outcome).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&filed.to_json().unwrap()).unwrap();
    let quantity = &document["quantities"][0];
    assert_eq!(quantity["method"], "monte-carlo");
    assert_eq!(quantity["value"].as_f64().unwrap(), stated.value);
    assert_eq!(
        quantity["interval"][0].as_f64().unwrap(),
        stated.interval.lower
    );
    assert_eq!(
        quantity["interval"][1].as_f64().unwrap(),
        stated.interval.upper
    );
    // 0.00001 to 0.00043 on the page and in the terminal.
    let page = filed.html().unwrap();
    assert!(
        page.contains("0.00001 to 0.00043"),
        "the page states another interval"
    );
}
