//! Lines of an encoder that are found and subtracted: one record of each wheel of the map in `docs/velocity.md`.

use proofmass_core::Unwatched;
use proofmass_motion::{MotionRecord, ReadingSource, estimate};

#[path = "../examples/encoder_map_coverage.rs"]
#[allow(dead_code, reason = "the map over many records")]
mod encoder_map_coverage;

use encoder_map_coverage::{WHEELS, Wheel, errors, search, search_for, wheel};

/// Ten errors beyond 4.5 standard uncertainties come once in 15 000.
#[test]
fn known_lines_of_one_record_of_each_wheel() {
    for (name, wheel) in &WHEELS {
        let found = errors(wheel, 200).unwrap_or_else(|| panic!("{name}: no line"));
        assert!(found.iter().all(|z| z.abs() < 4.5), "{name}: {found:?}");
    }
}

/// Where the slip begins and where it ends; between, wheel and axis keep their distance in speed.
#[test]
fn known_slip_beside_an_eccentric_disc() {
    let (record, _) = WHEELS[2].1.roll(0);
    let found = search().run(&record, &Unwatched).unwrap();
    assert!(found.stretches.len() >= 2, "{:?}", found.stretches);
    let report = found.slip.as_ref().unwrap();
    assert!(
        report.slips(3000, 0) && report.slips(3300, 0),
        "{:?}",
        report.slip
    );
    assert!(!report.slips(2000, 0) && !report.slips(5000, 0));
}

/// A false line is stated once in a thousand, one of this chance once in 100 000.
#[test]
fn known_ideal_encoders_show_no_line() {
    for quarters in [false, true] {
        let (record, _) = Wheel::default().roll(100);
        let found = search_for(quarters).run(&record, &Unwatched).unwrap();
        let lines = &found.map.lines;
        assert!(lines.iter().all(|l| l.chance > 1e-5), "{lines:?}");
    }
}

#[test]
fn law_the_subtracted_map_makes_the_encoder_ideal() {
    let rms = |record: &MotionRecord, truth: &[f64]| {
        let trace = estimate(record, None, None, &Unwatched).unwrap().smoother;
        let inner = 500..7500;
        let square: f64 = inner
            .clone()
            .map(|k| (trace.velocity[k] - truth[k]).powi(2))
            .sum();
        (square / inner.len() as f64).sqrt()
    };
    let (ideal, truth) = wheel(0.0, 0.0, 3);
    let (record, _) = wheel(0.03, 0.7, 3);
    let found = search().run(&record, &Unwatched).unwrap();
    let mended = found.map.corrected(&record).unwrap();
    let (before, after, best) = (
        rms(&record, &truth),
        rms(&mended, &truth),
        rms(&ideal, &truth),
    );
    assert!(after < 1.5 * best, "{before} {after} {best}");
    assert!(before > 5.0 * after, "{before} {after}");
}

#[test]
fn refuses_orders_and_turns_that_cannot_be() {
    let (record, _) = wheel(0.0, 0.0, 1);
    let refused = |record: &MotionRecord, turn: f64, orders: &[f64], quarters: bool| {
        let mut search = search_for(quarters);
        (search.turn, search.orders) = (turn, orders.to_vec());
        search.run(record, &Unwatched).is_err()
    };
    let turn = search().turn;
    assert!(refused(&record, 0.0, &[1.0, 2.0], false));
    for orders in [&[][..], &[1.0, f64::NAN], &[1.0, 1.0], &[1.0; 10]] {
        assert!(refused(&record, turn, orders, false), "{orders:?}");
    }
    let mut lengths = record.clone();
    lengths.increment = None;
    assert!(refused(&lengths, turn, &[1.0, 2.0], true));
    let mut speed = record.clone();
    speed.source = ReadingSource::Speed;
    assert!(refused(&speed, turn, &[1.0, 2.0], false));
}
