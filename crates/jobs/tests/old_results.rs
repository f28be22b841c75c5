//! Results of earlier forms: what is still read of them, and what is refused by name.

use proofmass_documents::ResultDocument;
use proofmass_jobs::static_test::dated;
use proofmass_jobs::{StoredResult, noise_comparison::NoiseDocument};

const VERSION_1: &[u8] = include_bytes!("data/result-version-1.json");

#[test]
fn known_quantities_of_version_1_are_read() {
    let document = ResultDocument::from_json(VERSION_1).unwrap();
    assert_eq!(document.kind, "level-linearity");
    assert_eq!(document.quantities.len(), 2);
    let estimate = document.stated().unwrap().expect("an estimate");
    assert_eq!(estimate.components().len(), 2);
    // A record of calibrations over the years takes results of either form.
    assert!(dated(VERSION_1, "result.json").is_ok());
}

#[test]
fn refuses_to_render_version_1_and_says_what_to_do() {
    let refused = StoredResult::from_json(VERSION_1).unwrap_err();
    assert!(refused.to_string().contains("form 1"), "{refused}");
    assert!(refused.hint().unwrap().contains("evaluate it again"));
    let source = proofmass_io::Source::from_bytes("result.json", VERSION_1).unwrap();
    let refused = NoiseDocument::read(source).unwrap_err();
    assert!(refused.to_string().contains("level-linearity"), "{refused}");
}
