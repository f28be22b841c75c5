//! The search for rests and the interval behind it: a small seed of the map in `examples/rest_search.rs`.

#[allow(dead_code)]
#[path = "../examples/rest_search.rs"]
mod program;

use program::{PLACES, Place};
use proofmass_static::Standstill;

const RECORDINGS: usize = 40;

fn at(rate: f64, rest: f64, noise: f64) -> Place {
    let found = PLACES.iter().find(|p| {
        (p.rate, p.rest, p.noise) == (rate, rest, noise)
            && p.wander > 0.0
            && p.bits == 16
            && p.tremor + p.touched == 0.0
    });
    *found.expect("a place of the map")
}

/// Rests of ten seconds at 50 Hz were 24 to 32 standstills of twelve attitudes, and 95 % intervals held 77 %.
#[test]
fn coverage_long_rests_are_one_reading_each() {
    let cell = at(50.0, 10.0, 4.0).cell(RECORDINGS);
    assert_eq!((cell.refused, cell.found), (0, 1.0), "{cell:?}");
    // Nine parameters of one recording share its scatter: 40 recordings tell no less than 40 independent intervals, of which at
    // 95 % nine and more miss once in 7000 times.
    assert!(cell.mean > 31.0 / 40.0 && cell.width < 1.3, "{cell:?}");
}

/// With rests of 1.5 s, a window of a second leaves hardly any.
#[test]
fn coverage_rests_hardly_longer_than_the_window() {
    let cell = at(100.0, 1.5, 4.0).cell(RECORDINGS);
    assert_eq!(cell.refused, 0, "{cell:?}");
    assert!(cell.mean > 31.0 / 40.0 && cell.width < 1.3, "{cell:?}");
}

/// Noise of a twentieth of a step: windows without any change stand beside windows at the edge of two codes.
#[test]
fn coverage_a_converter_coarser_than_the_noise() {
    let cell = at(50.0, 10.0, 0.05).cell(RECORDINGS);
    assert_eq!(cell.refused, 0, "{cell:?}");
    assert!(cell.mean > 31.0 / 40.0 && cell.width < 1.3, "{cell:?}");
}

/// The shortest hold that is asked for at a rate is found in nearly every recording; rests vary by ±20 % about their mean.
#[test]
fn law_the_shortest_hold_is_found() {
    for (rate, expected) in [
        (5.0, 3.52),
        (10.0, 3.2),
        (25.0, 1.6),
        (50.0, 1.6),
        (100.0, 1.6),
    ] {
        let shortest = Standstill::default().shortest_hold(rate);
        assert!((shortest - expected).abs() < 1e-9, "{rate}: {shortest}");
        let place = Place {
            rate,
            rest: shortest / 0.8,
            ..PLACES[1]
        };
        let cell = place.cell(RECORDINGS);
        assert_eq!(cell.refused, 0, "{rate}: {cell:?}");
        assert!(cell.found > 0.85, "{rate}: {cell:?}");
    }
}

/// A touched rest is one reading, and a tremor widens what it is worth.
#[test]
fn coverage_rests_that_are_touched() {
    for place in PLACES.iter().filter(|p| p.touched > 0.0) {
        let cell = place.cell(RECORDINGS);
        assert_eq!(cell.refused, 0, "{cell:?}");
        assert!(cell.mean > 31.0 / 40.0, "{cell:?}");
    }
}
