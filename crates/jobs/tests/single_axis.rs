//! Rests of one axis at known angles: a small seed of the map in `examples/single_axis_map.rs`.

#[allow(dead_code)]
#[path = "../examples/single_axis_map.rs"]
mod single_axis_map;

use proofmass_core::Error;
use proofmass_rig::TurnedAxis;
use proofmass_static::Standstill;
use proofmass_static::static_test::KnownAngles;
use single_axis_map::{PLACES, Place};

const RECORDINGS: usize = 30;

fn at(angles: usize, wanted: impl Fn(&Place) -> bool) -> Place {
    let found = PLACES.iter().find(|p| p.angles == angles && wanted(p));
    *found.expect("a place of the map")
}

/// The strictest threshold that happened to fit turned φ by more than a degree in 7 % of such recordings.
#[test]
fn coverage_rests_that_are_neither_touched_nor_lost() {
    for angles in [12, 24] {
        let cell = at(angles, |p| p.rate == 100.0).cell(RECORDINGS);
        assert_eq!((cell.refused, cell.decided), (0, 0), "{cell:?}");
        assert_eq!((cell.beyond, cell.turned), (0, 0), "{cell:?}");
        // 95 % of 30 intervals; fewer than 23 hold once in ten thousand times.
        assert!(cell.held.iter().all(|h| *h >= 23), "{cell:?}");
    }
}

/// Touched rests are cut in two: of 24 angles 32 % were refused, and 40 % of the others had φ wrong by more than a degree.
#[test]
fn coverage_rests_that_are_touched() {
    let cell = at(24, |p| p.tremor > 0.0).cell(RECORDINGS);
    assert_eq!(
        (cell.beyond, cell.turned, cell.refused),
        (0, 0, 0),
        "{cell:?}"
    );
    assert!(cell.stated >= RECORDINGS - 3, "{cell:?}");
}

/// An angle that was listed and not turned to: refused or a decision, where 92 % had φ wrong by more than a degree.
#[test]
fn law_a_missing_rest_is_no_result() {
    let cell = at(12, |p| p.missing == 1).cell(RECORDINGS);
    assert_eq!(cell.stated, 0, "{cell:?}");
}

fn find(
    rig: &TurnedAxis,
    change: impl Fn(&mut Vec<f64>),
    angles: &[f64],
) -> Result<Vec<String>, String> {
    let mut output = rig.simulate(1).output;
    change(&mut output);
    let found = KnownAngles::find(&output, rig.rate, &[], &Standstill::default(), angles);
    match found.map_err(|e: Error| e.to_string())? {
        Ok(found) => Ok(found.findings.iter().map(|f| f.code().to_owned()).collect()),
        Err([low, high]) => Err(format!("{low} to {high}")),
    }
}

#[test]
fn refuses_recordings_without_the_rests() {
    let rig = TurnedAxis::default();
    let angles = &rig.angles;
    assert_eq!(find(&rig, |_| (), angles), Ok(vec![]));
    assert!(find(&rig, |o| o.clear(), angles).is_err());
    assert!(find(&rig, |o| o.truncate(400), angles).is_err());
    assert!(
        find(&rig, |o| o.fill(1.0), angles)
            .is_err_and(|e| e.contains("never changes") || e.contains("constant"))
    );
    // One rest by no motion at all, and rests too short.
    let mut still = rig.clone();
    still.angles = vec![0.0];
    still.rest = 60.0;
    assert!(find(&still, |_| (), angles).is_err());
    let mut short = rig.clone();
    short.rest = 0.1;
    // Shorter than any window: nothing, or a decision.
    let found = find(&short, |_| (), angles);
    assert!(
        found.clone().is_err() || found == Ok(vec!["angles-in-doubt".to_owned()]),
        "{found:?}"
    );
}

/// A list that begins one rest too late fits a cosine that is turned by a step: no residual shows it.
#[test]
fn known_list_that_is_shifted_is_a_decision() {
    let rig = TurnedAxis::default();
    let shifted: Vec<f64> = rig.angles.iter().map(|a| a + 30f64.to_radians()).collect();
    assert_eq!(
        find(&rig, |_| (), &shifted),
        Ok(vec!["angles-in-doubt".to_owned()])
    );
}
