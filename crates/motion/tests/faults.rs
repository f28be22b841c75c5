//! Faults of a record: glitches, rests that move, counters that roll over; healthy records raise no alarm.

use proofmass_motion::{
    MotionRecord, ReadingSource, continued, drop_glitches, moves_while_still, rollover, turns_anew,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn record(values: Vec<f64>, increment: Option<f64>) -> MotionRecord {
    let readings = values.into_iter().map(Some).collect();
    let mut record =
        MotionRecord::without_accelerometer(1e-3, ReadingSource::Position, readings).unwrap();
    record.increment = increment;
    record
}

#[test]
fn known_glitches_are_left_out() {
    let wave = |k: usize| (50.0 * (0.01 * k as f64).sin()).round() * 1e-3;
    let mut values: Vec<f64> = (0..5000).map(wave).collect();
    values[1234] += 0.064;
    values[3000] -= 8.0;
    let mut found = record(values, Some(1e-3));
    let finding = drop_glitches(&mut found).unwrap();
    assert!(
        finding.evidence_text().starts_with("2 of 5000"),
        "{finding}"
    );
    let missing: Vec<usize> = (0..5000).filter(|&k| found.reading[k].is_none()).collect();
    assert_eq!(missing, [1234, 3000]);
}

#[test]
fn coverage_healthy_readings_stay() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let step = |k: usize| if k < 5000 { 0.0 } else { 0.5 };
    let stops = |k: usize| {
        let phase = (k % 1000) as f64 / 500.0;
        if phase < 1.0 {
            (std::f64::consts::PI * phase).sin().powi(2)
        } else {
            0.0
        }
    };
    for _ in 0..10 {
        let cases: [(Vec<f64>, Option<f64>); 5] = [
            ((0..10_000).map(|_| noise()).collect(), None),
            (
                (0..10_000)
                    .map(|k| (2.0 * (0.3 * k as f64).sin()).round())
                    .collect(),
                Some(1.0),
            ),
            (
                (0..10_000).map(|k| step(k) + 1e-3 * noise()).collect(),
                None,
            ),
            (
                (0..10_000)
                    .map(|k| (300.0 * stops(k)).floor() * 1e-3)
                    .collect(),
                Some(1e-3),
            ),
            (
                (0..10_000)
                    .map(|k| (30.0 * stops(k * 20)).floor())
                    .collect(),
                Some(1.0),
            ),
        ];
        for (values, increment) in cases {
            let mut healthy = record(values, increment);
            assert!(drop_glitches(&mut healthy).is_none());
        }
    }
}

#[test]
fn coverage_stillness_raises_few_false_alarms_and_motion_one() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let alarms = (0..2000)
        .filter(|_| {
            let a: Vec<f64> = (0..200).map(|_| 9.81 + 0.02 * noise()).collect();
            moves_while_still(&a).is_some()
        })
        .count();
    // 2·10⁻⁴ of 2000 and a binomial bound of 10⁻³.
    assert!(alarms <= 4, "{alarms}");
    let wave: Vec<f64> = (0..200)
        .map(|k| (0.02 * f64::from(k)).sin() + 0.02 * noise())
        .collect();
    assert!(moves_while_still(&wave).is_some());
    assert!(moves_while_still(&[1.0; 500]).is_none());
    assert!(moves_while_still(&[]).is_none());
}

#[test]
fn law_words_of_any_width_are_suspected_and_continued() {
    for bits in [8u32, 10, 12, 14, 16, 20, 24, 32] {
        let range = 1i64 << bits;
        for low in [0, -range / 2] {
            let path: Vec<i64> = (0..2000).map(|k| low + range - 40 + k / 3).collect();
            let words: Vec<i64> = path
                .iter()
                .map(|c| (c - low).rem_euclid(range) + low)
                .collect();
            let found = rollover(&words).unwrap();
            assert!(
                found.advice_text().contains(&format!("{bits} bits")),
                "{found}"
            );
            let words: Vec<f64> = words.iter().map(|w| *w as f64).collect();
            let all = continued(&words, range as f64);
            for (a, c) in all.iter().zip(&path) {
                assert_eq!(a - all[0], (c - path[0]) as f64);
            }
        }
    }
}

#[test]
fn law_angles_of_a_turn_are_suspected_and_jumps_of_another_kind_are_not() {
    let angle: Vec<f64> = (0..900)
        .map(|k| (0.7 * f64::from(k)).rem_euclid(360.0))
        .collect();
    assert!(turns_anew(&angle, 360.0).is_some());
    let one_turn: Vec<f64> = (0..500).map(|k| 0.7 * f64::from(k)).collect();
    assert!(turns_anew(&one_turn, 360.0).is_none());
    // A glitch, a step of the axis, a reversing path.
    let mut glitch: Vec<i64> = (0..300).collect();
    glitch[150] = 4000;
    assert!(rollover(&glitch).is_none());
    let step: Vec<i64> = (0..200)
        .map(|k| if k < 100 { k / 10 } else { 200 + k / 10 })
        .collect();
    assert!(rollover(&step).is_none());
    let sine: Vec<i64> = (0..5000)
        .map(|k| (2000.0 * (0.003 * f64::from(k)).sin()) as i64)
        .collect();
    assert!(rollover(&sine).is_none());
    assert!(rollover(&[]).is_none() && rollover(&[1]).is_none());
}
