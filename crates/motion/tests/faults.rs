//! Faults of a record: glitches, rests that move, counters that roll over; healthy records raise no alarm.

use proofmass_motion::{
    MotionRecord, ReadingSource, continued, drop_glitches, drop_wild_accelerations,
    moves_while_still, repetition, rollover, turns_anew,
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

/// An axis with a sine of 2 Hz and 0.02 m/s² of noise, whose velocity jumps by a blow of one sample where `blow` is true.
fn driven(seed: u64, counts: bool, blow: bool) -> MotionRecord {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let (w, dt, n) = (12.566, 1e-3, 5000);
    let after = |k: usize| f64::from(u8::from(blow && k > 3000));
    let x = |k: usize| {
        let t = dt * k as f64;
        0.02 * (w * t).sin() + 0.2 * after(k) * (t - 3.0)
    };
    let step = 1.57e-4;
    let read = |k: usize| match counts {
        true => (x(k) / step).floor() * step,
        false => 0.02 * w * (w * dt * k as f64).cos() + 0.2 * after(k),
    };
    let readings = (0..n).map(|k| Some(read(k))).collect();
    let acceleration = (0..n)
        .map(|k| {
            let hit = if blow && k == 3000 { 0.2 / dt } else { 0.0 };
            -0.02 * w * w * (w * dt * k as f64).sin() + 0.05 + 0.02 * noise() + hit
        })
        .collect();
    let source = match counts {
        true => ReadingSource::Position,
        false => ReadingSource::Speed,
    };
    let mut record = MotionRecord::new(dt, source, readings, acceleration).unwrap();
    record.increment = counts.then_some(step);
    record
}

#[test]
fn known_wild_accelerations_are_left_out_and_a_blow_is_not() {
    for counts in [true, false] {
        let sound = driven(1, counts, false);
        let mut wild = sound.clone();
        wild.acceleration[1234] = 500.0;
        wild.acceleration[4000] -= 60.0;
        let finding = drop_wild_accelerations(&mut wild).unwrap();
        assert_eq!(finding.code(), "glitches");
        assert!(
            finding.evidence_text().starts_with("2 of 5000"),
            "{finding}"
        );
        // The line between two neighbours of 0.02 m/s² of noise, and the sample itself: √1.5 of it, five standard deviations.
        for k in [1234, 4000] {
            let off = wild.acceleration[k] - sound.acceleration[k];
            assert!(off.abs() < 0.13, "{off}");
        }
        let mut blow = driven(1, counts, true);
        assert_eq!(drop_wild_accelerations(&mut blow), None);
        assert_eq!(blow, driven(1, counts, true));
    }
}

#[test]
fn law_healthy_accelerations_are_not_wild() {
    for seed in 0..50 {
        for counts in [true, false] {
            let mut healthy = driven(seed, counts, false);
            assert_eq!(drop_wild_accelerations(&mut healthy), None);
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
            let found = rollover(&words, None).unwrap();
            assert!(
                found.advice_text().contains(&format!("--bits {bits}")),
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
    assert!(rollover(&glitch, None).is_none());
    let step: Vec<i64> = (0..200)
        .map(|k| if k < 100 { k / 10 } else { 200 + k / 10 })
        .collect();
    assert!(rollover(&step, None).is_none());
    let sine: Vec<i64> = (0..5000)
        .map(|k| (2000.0 * (0.003 * f64::from(k)).sin()) as i64)
        .collect();
    assert!(rollover(&sine, None).is_none());
    assert!(rollover(&[], None).is_none() && rollover(&[1], None).is_none());
}

/// A speed in m/s with decimals, read in every row: amplitudes, frequencies and digits at which its commonest run is two rows and more.
#[test]
fn law_rounding_is_no_slower_sensor() {
    let digits = |v: f64, step: f64| (v / step).round() * step;
    let mut told = 0;
    for amplitude in [0.05, 0.25, 1.0, 3.0] {
        for frequency in [0.1, 0.2, 0.7, 1.3, 2.0] {
            for step in [1e-4, 1e-3, 0.01 / 3.6, 0.1 / 3.6] {
                for ramp in [false, true] {
                    let v = |k: usize| {
                        let t = 1e-3 * k as f64;
                        let phase = 2.0 * std::f64::consts::PI * frequency * t;
                        // A triangle has one slope, and so runs of one length.
                        let shape = match ramp {
                            true => phase.sin().asin(),
                            false => phase.sin(),
                        };
                        digits(amplitude * shape, step)
                    };
                    let readings = (0..12_000).map(|k| Some(v(k))).collect();
                    let nothing = vec![0.0; 12_000];
                    let axis =
                        MotionRecord::new(1e-3, ReadingSource::Speed, readings, nothing).unwrap();
                    let found = repetition(&axis);
                    let what = (amplitude, frequency, step, ramp);
                    assert_eq!(found, None, "{what:?}");
                    told += 1;
                }
            }
        }
    }
    assert_eq!(told, 160);
}

/// Slower sensors whose values have digits, also of a clock that comes a row early or late.
#[test]
fn law_slower_sensors_with_digits_are_known() {
    for rows in [2, 3, 5, 10] {
        for step in [1e-6, 1e-3, 0.01 / 3.6] {
            for unsteady in [false, true] {
                let (mut at, mut next) = (0, 0);
                let v = |k: usize| {
                    if k >= next {
                        // A row early or late now and then; of two rows late only.
                        let late = usize::from(unsteady && k * 7919 % 11 < 3);
                        let early = usize::from(unsteady && rows > 2 && k * 7919 % 13 < 3);
                        (at, next) = (k, k + rows + late - early);
                    }
                    let t = 1e-3 * at as f64;
                    let v = 0.8 * (4.4 * t).sin() + 0.5 * (11.0 * t).cos();
                    Some((v / step).round() * step)
                };
                let readings: Vec<Option<f64>> = (0..12_000).map(v).collect();
                let nothing = vec![0.0; 12_000];
                let axis = MotionRecord::new(1e-3, ReadingSource::Speed, readings, nothing);
                let found = repetition(&axis.unwrap());
                let near = found.is_some_and(|n| n.abs_diff(rows) <= 1);
                // A digit and less to a step, a row early or late: nothing tells it from rounding.
                let open = unsteady && rows < 5 && step > 1e-3;
                assert!(near || open, "{rows} {step} {unsteady}: {found:?}");
            }
        }
    }
}
