//! Where every method starts: the velocity of the first readings, or the one that is stated.

use proofmass_motion::{MotionRecord, ReadingSource};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// An axis in motion at its first sample, with an offset of its accelerometer.
fn axis(
    source: ReadingSource,
    seed: u64,
    increment: Option<f64>,
    alone: bool,
) -> (MotionRecord, f64) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let (dt, n) = (1e-3, 4000);
    let (v0, phase) = (0.8 * normal(), 3.0 * normal());
    let (amplitude, w, offset) = (0.1, 6.0, 0.05 * normal());
    let mean = v0 - amplitude * phase.sin();
    let place = normal();
    let (mut reading, mut a) = (Vec::new(), Vec::new());
    for k in 0..n {
        let t = dt * k as f64;
        let v = mean + amplitude * (w * t + phase).sin();
        let x = place + mean * t - amplitude / w * ((w * t + phase).cos() - phase.cos());
        a.push(amplitude * w * (w * t + phase).cos() + offset + 0.02 * normal());
        reading.push(Some(match (source, increment) {
            (ReadingSource::Speed, _) => v + 0.01 * normal(),
            (ReadingSource::Position, Some(d)) => (x / d).round() * d,
            (ReadingSource::Position, None) => x + 1e-4 * normal(),
        }));
    }
    let mut record = match alone {
        false => MotionRecord::new(dt, source, reading, a),
        true => MotionRecord::without_accelerometer(dt, source, reading),
    }
    .unwrap();
    record.increment = increment;
    (record, v0)
}

#[test]
fn coverage_start_of_moving_axes() {
    for (source, increment, alone, largest) in [
        (ReadingSource::Speed, None, false, 2e-3),
        (ReadingSource::Position, None, false, 2e-3),
        (ReadingSource::Position, Some(1e-3), false, 8e-3),
        (ReadingSource::Position, Some(1e-4), false, 2e-3),
        (ReadingSource::Position, Some(1e-3), true, 3e-2),
    ] {
        let runs = 200;
        let (mut inside, mut square) = (0, 0.0);
        for seed in 0..runs {
            let (record, v0) = axis(source, seed, increment, alone);
            let (v, u) = record.start_velocity();
            inside += u32::from((v - v0).abs() < 1.96 * u);
            square += (v - v0).powi(2) / runs as f64;
        }
        println!(
            "{source:?} {increment:?} alone {alone}: {inside} of {runs}, {:.3e}",
            square.sqrt()
        );
        // 181 of 200 is the 1 % point of the binomial at 95 %.
        assert!(inside >= 181, "{source:?} {increment:?} {alone}: {inside}");
        assert!(
            square.sqrt() < largest,
            "{source:?} {increment:?} {alone}: {}",
            square.sqrt()
        );
    }
}

#[test]
fn law_a_stated_start_is_the_start() {
    let (mut record, _) = axis(ReadingSource::Position, 1, None, false);
    record.start_at(0.3, 0.01).unwrap();
    assert_eq!(record.start_velocity(), (0.3, 0.01));
    assert!(record.start_at(f64::NAN, 0.0).is_err());
    assert!(record.start_at(0.0, -1.0).is_err());
    assert!(record.start_at(0.0, f64::INFINITY).is_err());
}
