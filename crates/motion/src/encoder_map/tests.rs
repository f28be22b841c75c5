//! Accuracy, coverage and false alarms of the search.

use super::*;
use crate::estimate;
use proofmass_core::Unwatched;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const RADIUS: f64 = 0.005;
const DT: f64 = 1e-3;

/// How a wheel of 5 mm shows its motion in 2000 counts per turn.
#[derive(Clone, Copy, Default)]
struct Wheel {
    /// Of the disc, rad, and where.
    eccentricity: f64,
    phase: f64,
    /// By how much the edges of a line stand too far, counts.
    quarters: [f64; 4],
    /// Extra way the wheel makes from 3 s to 3.3 s, m.
    slip: f64,
}

const COUNT: f64 = TAU * RADIUS / 2000.0;

impl Wheel {
    /// Rolled ±0.14 m, four and a half turns to either side, with the truth of its velocity.
    fn roll(&self, seed: u64) -> (MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        // Two sines whose periods have no common multiple in the record: the roundings differ every time.
        let parts = [(0.12, 0.31, 0.4 * normal()), (0.02, 0.97, 0.4 * normal())];
        let place = |t: f64, order: u32| -> f64 {
            let part = |&(a, f, p): &(f64, f64, f64)| {
                let w = TAU * f;
                match order {
                    0 => a * (w * t + p).sin(),
                    1 => a * w * (w * t + p).cos(),
                    _ => -a * w * w * (w * t + p).sin(),
                }
            };
            parts.iter().map(part).sum()
        };
        let time = |k: usize| DT * k as f64;
        let reading = (0..8000).map(|k| {
            let spun = ((time(k) - 3.0) / 0.3).clamp(0.0, 1.0);
            let x = place(time(k), 0) + self.slip * spun;
            let shown = x + RADIUS * self.eccentricity * (x / RADIUS + self.phase).sin();
            Some(self.count(shown / COUNT) * COUNT)
        });
        let acceleration = (0..8000).map(|k| place(time(k), 2) + 0.05 + 0.02 * normal());
        let mut record = MotionRecord::new(
            DT,
            ReadingSource::Position,
            reading.collect(),
            acceleration.collect(),
        )
        .unwrap();
        record.increment = Some(COUNT);
        (record, (0..8000).map(|k| place(time(k), 1)).collect())
    }

    /// The count n between the edges n − ½ and n + ½, each where it stands.
    fn count(&self, y: f64) -> f64 {
        let edge = |n: f64| n - 0.5 + self.quarters[n.rem_euclid(4.0) as usize];
        let n = y.round();
        if y < edge(n) {
            n - 1.0
        } else if y >= edge(n + 1.0) {
            n + 1.0
        } else {
            n
        }
    }
}

fn wheel(eccentricity: f64, phase: f64, seed: u64) -> (MotionRecord, Vec<f64>) {
    let wheel = Wheel {
        eccentricity,
        phase,
        ..Wheel::default()
    };
    wheel.roll(seed)
}

fn search() -> MapSearch {
    MapSearch {
        turn: TAU * RADIUS,
        orders: vec![1.0, 2.0],
        ..MapSearch::default()
    }
}

#[test]
fn coverage_of_an_eccentric_disc() {
    let phase = 0.7f64;
    let (mut inside, mut all) = (0, 0);
    for (eccentricity, seeds) in [(0.01, 0..15), (0.03, 15..30)] {
        for seed in seeds {
            let (record, _) = wheel(eccentricity, phase, seed);
            let found = search().run(&record, &Unwatched).unwrap();
            assert_eq!(found.map.lines[0].order, 1.0, "{found:?}");
            let line = found.map.lines[0];
            let size = RADIUS * eccentricity;
            for (value, truth, axis) in [
                (line.cosine, size * phase.sin(), 0),
                (line.sine, size * phase.cos(), 1),
            ] {
                let u = line.covariance[axis][axis].sqrt();
                all += 1;
                inside += u32::from((value - truth).abs() < 1.96 * u);
            }
        }
    }
    // Binomial at 0.95: 57 of 60 expected, below 51 in one of a thousand.
    assert!(inside >= 51, "{inside} of {all}");
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
fn known_false_alarms_of_ideal_encoders() {
    let found = (100..140)
        .filter(|&seed| {
            let (record, _) = wheel(0.0, 0.0, seed);
            let found = search().run(&record, &Unwatched).unwrap();
            !found.map.lines.is_empty()
        })
        .count();
    // One in a thousand is stated: two of forty come by chance in one of 1300.
    assert!(found <= 1, "{found} of 40");
}

#[test]
fn coverage_of_unequal_quarters() {
    let wheel = Wheel {
        quarters: [0.0, 0.1, 0.0, -0.1],
        ..Wheel::default()
    };
    let search = MapSearch {
        quarters: true,
        ..search()
    };
    let (mut inside, mut all) = (0, 0);
    for seed in 200..210 {
        let (record, _) = wheel.roll(seed);
        let found = search.run(&record, &Unwatched).unwrap();
        assert_eq!(found.map.lines.len(), 1, "{:?}", found.map);
        let line = found.map.lines[0];
        assert!((line.order - 500.0).abs() < 1e-9);
        // The cell of count 0 lies between edges that stand 0 and 0.1 too far, its middle 0.05: the reading is too small.
        for (value, axis) in [(line.cosine, 0), (line.sine, 1)] {
            let u = line.covariance[axis][axis].sqrt();
            all += 1;
            inside += u32::from((value + 0.05 * COUNT).abs() < 1.96 * u);
        }
    }
    // Binomial at 0.95 of 20: below 15 in one of four hundred.
    assert!(inside >= 15, "{inside} of {all}");
}

#[test]
fn known_false_alarms_of_equal_quarters() {
    let search = MapSearch {
        quarters: true,
        orders: Vec::new(),
        ..search()
    };
    let found = (300..320)
        .filter(|&seed| {
            let (record, _) = Wheel::default().roll(seed);
            let found = search.run(&record, &Unwatched).unwrap();
            !found.map.lines.is_empty()
        })
        .count();
    assert!(found <= 1, "{found} of 20");
}

#[test]
fn coverage_of_a_wheel_that_slips() {
    let (mut inside, mut all) = (0, 0);
    let phase = 0.7f64;
    for (eccentricity, slip) in [(0.01, 0.06), (0.03, -0.05)] {
        let wheel = Wheel {
            eccentricity,
            phase,
            slip,
            ..Wheel::default()
        };
        for seed in 0..6 {
            let (record, _) = wheel.roll(seed);
            let found = search().run(&record, &Unwatched).unwrap();
            // Where it begins and where it ends; between, wheel and axis keep their distance in speed.
            assert!(found.stretches.len() >= 2, "{:?}", found.stretches);
            let report = found.slip.as_ref().unwrap();
            assert!(
                report.slips(3000, 0) && report.slips(3300, 0),
                "{:?}",
                report.slip
            );
            assert!(!report.slips(2000, 0) && !report.slips(5000, 0));
            let line = found.map.lines[0];
            let size = RADIUS * eccentricity;
            for (value, truth, axis) in [
                (line.cosine, size * phase.sin(), 0),
                (line.sine, size * phase.cos(), 1),
            ] {
                let u = line.covariance[axis][axis].sqrt();
                all += 1;
                inside += u32::from((value - truth).abs() < 1.96 * u);
            }
        }
    }
    // Binomial at 0.95 of 24: below 19 in one of two hundred.
    assert!(inside >= 19, "{inside} of {all}");
}

#[test]
fn refuses_orders_and_turns_that_cannot_be() {
    let (record, _) = wheel(0.0, 0.0, 1);
    let refused = |search: MapSearch| search.run(&record, &Unwatched).is_err();
    assert!(refused(MapSearch {
        turn: 0.0,
        ..search()
    }));
    assert!(refused(MapSearch {
        orders: vec![],
        ..search()
    }));
    assert!(refused(MapSearch {
        orders: vec![1.0, f64::NAN],
        ..search()
    }));
    assert!(refused(MapSearch {
        orders: vec![1.0, 1.0],
        ..search()
    }));
    assert!(refused(MapSearch {
        orders: vec![1.0; 10],
        ..search()
    }));
    let mut lengths = record.clone();
    lengths.increment = None;
    let quarters = MapSearch {
        quarters: true,
        ..search()
    };
    assert!(quarters.run(&lengths, &Unwatched).is_err());
    let mut speed = record.clone();
    speed.source = ReadingSource::Speed;
    assert!(search().run(&speed, &Unwatched).is_err());
}
