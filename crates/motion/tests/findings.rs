//! Findings of this room: what is wrong with a record is told, and its sound twin is left in peace.

use proofmass_core::Unwatched;
use proofmass_motion::{
    AbsoluteCode, MotionRecord, ReadingSource, Tuning, absolute, compare, leave_out_threshold,
    quadrature, tune,
};
use proofmass_uncertainty::Finding;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const DT: f64 = 1e-2;

fn insist(code: &str, found: &[Finding]) {
    assert!(found.iter().any(|f| f.code() == code), "{code}: {found:#?}");
}

fn spare(code: &str, found: &[Finding]) {
    assert!(
        !found.iter().any(|f| f.code() == code),
        "{code}: {found:#?}"
    );
}

/// An axis of two sines: speeds with this noise, accelerations with theirs, and the truth.
fn axis(n: usize, noise: [f64; 2], frequency: f64) -> (MotionRecord, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let parts = [(0.5, frequency), (0.2, 3.1 * frequency)];
    let of = |k: usize, order: i32| -> f64 {
        let part = |&(v, f): &(f64, f64)| match order {
            0 => v * (TAU * f * DT * k as f64).sin(),
            _ => v * TAU * f * (TAU * f * DT * k as f64).cos(),
        };
        parts.iter().map(part).sum()
    };
    let reading = (0..n)
        .map(|k| Some(of(k, 0) + noise[0] * normal()))
        .collect();
    let acceleration = (0..n).map(|k| of(k, 1) + noise[1] * normal()).collect();
    let record = MotionRecord::new(DT, ReadingSource::Speed, reading, acceleration).unwrap();
    (record, (0..n).map(|k| of(k, 0)).collect())
}

#[test]
fn known_counts_that_are_lost() {
    // Quarters of an encoder with its index pulses at these counts.
    let turns = |index: [i64; 4]| {
        let quarter =
            |k: i64| [(false, false), (true, false), (true, true), (false, true)][(k % 4) as usize];
        let (a, b): (Vec<bool>, Vec<bool>) = (0..400).map(quarter).unzip();
        let z: Vec<bool> = (0..400).map(|k| index.contains(&k)).collect();
        let decoding = proofmass_core::encoder::Decoding::Quadruple;
        quadrature(decoding, &a, &b, Some(&z)).unwrap().findings
    };
    insist("unequal-turns", &turns([50, 150, 250, 340]));
    assert!(turns([50, 150, 250, 350]).is_empty());
    let words = |step: u32| {
        let words: Vec<u32> = (0..40).map(|k| (step * k) % 1024).collect();
        absolute(AbsoluteCode::Binary, 10, &words).unwrap().findings
    };
    insist("large-step", &words(300));
    assert!(words(100).is_empty());
}

#[test]
fn known_speed_that_reads_zero_below_a_threshold() {
    let told = |threshold: f64| {
        let mut time: Vec<f64> = (0..2000).map(|k| DT * f64::from(k)).collect();
        let mut speed: Vec<f64> = time
            .iter()
            .map(|t| {
                let v = (100.0 * (TAU * 0.1 * t).sin()).round() / 100.0;
                if v.abs() < threshold { 0.0 } else { v }
            })
            .collect();
        leave_out_threshold(&mut time, &mut speed)
    };
    insist("speed-threshold", told(0.1).as_slice());
    spare("speed-threshold", told(0.0).as_slice());
}

#[test]
fn known_one_sensor_that_is_ignored() {
    let tuned = |noise: [f64; 2]| {
        let (record, _) = axis(3000, noise, 0.4);
        Tuning::default().run(&record, &Unwatched).unwrap().findings
    };
    insist("likelihood-at-bound", &tuned([0.0, 50.0]));
    spare("likelihood-at-bound", &tuned([0.02, 0.05]));
}

#[test]
fn known_reference_that_is_late() {
    let (record, truth) = axis(3000, [0.02, 0.05], 0.4);
    let compared = |late: usize| {
        let reference: Vec<f64> = (0..truth.len())
            .map(|k| truth[k.saturating_sub(late)])
            .collect();
        compare(&record, Some(&reference), &[], &[1], 1.0, &Unwatched)
            .unwrap()
            .findings
    };
    insist("reference-delay", &compared(8));
    spare("reference-delay", &compared(0));
}

/// Between the tenth and the twelfth second the wheel runs 0.6 m/s faster than the accelerometer tells.
#[test]
fn known_tuning_beside_a_slip() {
    let (mut record, _) = axis(3000, [0.01, 0.05], 0.4);
    let whole = tune(&record, &Tuning::default(), &Unwatched).unwrap();
    spare("tuned-on-a-part", &whole.tuned.findings);
    for reading in record.reading[1000..1200].iter_mut().flatten() {
        *reading += 0.6;
    }
    let found = proofmass_motion::estimate(&record, None, None, &Unwatched).unwrap();
    insist("tuned-on-a-part", &found.findings);
}

/// Rolled by some tenths of a metre on a wheel of a metre around, and of two hundredths.
#[test]
fn known_map_of_a_part_of_a_turn() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let w = TAU * 0.2;
    let at = |k: usize| DT * k as f64;
    let reading = (0..600).map(|k| Some(0.05 * (w * at(k)).sin() + 1e-5 * normal()));
    let reading: Vec<Option<f64>> = reading.collect();
    let acceleration = (0..600).map(|k| -0.05 * w * w * (w * at(k)).sin() + 0.01 * normal());
    let acceleration: Vec<f64> = acceleration.collect();
    let record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
    let found = |turn: f64| {
        let mut search = proofmass_motion::MapSearch::default();
        search.turn = turn;
        search.orders = vec![1.0];
        search.run(&record, &Unwatched).unwrap().findings
    };
    insist("encoder-map-part-of-a-turn", &found(1.0));
    spare("encoder-map-part-of-a-turn", &found(0.02));
}

/// A filter whose stated noise is ten times too small follows the readings, and its smoother contradicts it.
#[test]
fn known_filter_that_its_smoother_contradicts() {
    let (record, _) = axis(3000, [0.02, 0.05], 0.4);
    let estimated = |noise: f64| {
        let model =
            proofmass_motion::KalmanModel::new((0.05 * noise).powi(2), (0.02 * noise).powi(2));
        let method = proofmass_motion::Method::Kalman { model };
        let result = proofmass_motion::estimate(&record, Some(method), None, &Unwatched).unwrap();
        result.findings
    };
    insist("filter-and-smoother-disagree", &estimated(0.1));
    spare("filter-and-smoother-disagree", &estimated(1.0));
}

/// Half a minute at one sample in two seconds is too little to tune on, at 100 Hz it is enough.
#[test]
fn known_rate_at_which_nothing_is_tuned() {
    let (record, truth) = axis(3000, [0.02, 0.05], 0.4);
    let compared = |decimations: &[usize]| {
        let result = compare(&record, Some(&truth), &[], decimations, 1.0, &Unwatched);
        result.unwrap().findings
    };
    let told = compared(&[1, 200]);
    let found = told.iter().find(|f| f.code() == "not-tuned").unwrap();
    let evidence = found.evidence_text();
    assert!(
        evidence.starts_with("0.5 Hz: too few readings: 15 given"),
        "{evidence}"
    );
    spare("not-tuned", &compared(&[1]));
}

/// Counts of a motion of twenty samples per period round alike in every period; of one beside it they do not.
#[test]
fn known_rounding_that_repeats_with_the_motion() {
    let tuned = |period: f64| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let w = TAU / (period * DT);
        let at = |k: usize| w * DT * k as f64;
        let increment = 1e-4;
        let reading = (0..4000).map(|k| Some((4e-4 * at(k).sin() / increment).round() * increment));
        let reading: Vec<Option<f64>> = reading.collect();
        let acceleration = (0..4000).map(|k| -4e-4 * w * w * at(k).sin() + 0.005 * normal());
        let acceleration: Vec<f64> = acceleration.collect();
        let mut record =
            MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
        record.increment = Some(increment);
        Tuning::default().run(&record, &Unwatched).unwrap().findings
    };
    insist("rounding-repeats", &tuned(20.0));
    spare("rounding-repeats", &tuned(20.37));
}
