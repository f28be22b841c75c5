//! Motions that an accelerometer does not see whole: blows between its samples, and hard stops that are none; axes that turn within a
//! sample.

use crate::motions::hard_stops;
use proofmass_core::Unwatched;
use proofmass_motion::{
    CountingModel, EstimateResult, Method, MotionRecord, ReadingSource, estimate,
};
use proofmass_rig::AxisMotion;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// Standard deviation of an acceleration sample, m/s².
const NOISE: f64 = 0.02;

/// A record of 500 lines × 4 on an arc of 0.3 m, and the true velocity.
fn simulate(
    motion: impl Fn(f64) -> [f64; 3],
    rate: f64,
    duration: f64,
    seed: u64,
) -> (MotionRecord, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let phase: f64 = rng.random();
    let (dt, increment) = (1.0 / rate, TAU * 0.3 / 2000.0);
    let points: Vec<[f64; 3]> = (0..(duration * rate) as usize)
        .map(|k| motion(dt * k as f64))
        .collect();
    let count = |x: f64| ((x / increment + phase).floor() + 0.5) * increment;
    let reading = points.iter().map(|p| Some(count(p[0]))).collect();
    let acceleration = points
        .iter()
        .map(|p| {
            let e: f64 = StandardNormal.sample(&mut rng);
            p[2] + 0.01 + NOISE * e
        })
        .collect();
    let mut record = MotionRecord::new(dt, ReadingSource::Position, reading, acceleration).unwrap();
    record.increment = Some(increment);
    (record, points.iter().map(|p| p[1]).collect())
}

fn of(motion: AxisMotion) -> impl Fn(f64) -> [f64; 3] {
    move |t| {
        let p = motion.at(t);
        [p.position, p.velocity, p.acceleration]
    }
}

/// Share of the judged samples inside the 95 % interval, and mean square error.
fn judged(v: &[f64], u: &[f64], truth: &[f64], sample: impl Fn(usize) -> bool) -> [f64; 2] {
    let places: Vec<usize> = (0..truth.len()).filter(|k| sample(*k)).collect();
    let n = places.len() as f64;
    let off = |k: &&usize| (v[**k] - truth[**k]).abs();
    let inside = places
        .iter()
        .filter(|k| off(k) < 1.959_964 * u[**k])
        .count();
    let square: f64 = places.iter().map(|k| off(&k).powi(2)).sum();
    [inside as f64 / n, square / n]
}

fn both(result: &EstimateResult, truth: &[f64], sample: impl Fn(usize) -> bool) -> [[f64; 2]; 2] {
    [&result.trace, &result.smoother].map(|trace| {
        let u = trace.standard_uncertainty.as_deref().unwrap();
        judged(&trace.velocity, u, truth, &sample)
    })
}

fn found(result: &EstimateResult, code: &str) -> bool {
    result.findings.iter().any(|f| f.code() == code)
}

/// A blow of 4 ms between samples of 1 ms: what they do not show of it is left open, so that nothing is wrong after it.
///
/// A filter that goes on as if it had seen all errs by some 3 mm/s for seconds, and its intervals hold nothing.
#[test]
fn coverage_after_an_impact() {
    let mut pooled = [[0.0; 2]; 2];
    let runs = 6;
    for seed in 0..runs {
        let (record, truth) = simulate(of(AxisMotion::impact()), 1000.0, 4.0, 300 + seed);
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        assert!(found(&result, "collision"), "{seed}");
        let after = |k: usize| k >= 1100;
        for (sum, one) in pooled.iter_mut().zip(both(&result, &truth, after)) {
            assert!(one[0] > 0.85, "{seed}: {one:?}");
            sum[0] += one[0] / runs as f64;
            sum[1] += one[1] / runs as f64;
        }
    }
    println!("{pooled:?}");
    for ([share, square], most) in pooled.iter().zip([0.4e-3, 0.2e-3]) {
        assert!((0.92..0.99).contains(share), "{pooled:?}");
        assert!(square.sqrt() < most, "{pooled:?}");
    }
}

#[test]
fn known_false_alarms_of_hard_stops() {
    for seed in 0..30 {
        let (record, _) = simulate(hard_stops(0.3, seed, 8.0), 1000.0, 8.0, 400 + seed);
        let report = proofmass_motion::SlipSearch::default()
            .run(&record)
            .unwrap();
        assert!(
            report.collisions.is_empty(),
            "{seed}: {:?}",
            report.collisions
        );
    }
}

/// Five samples to a period, of which an axis that swings by ±60 mm turns within some: as good as a filter that was told the noise.
#[test]
fn coverage_of_an_oscillation_at_five_samples_a_period() {
    let (mut pooled, mut told) = ([[0.0; 2]; 2], [0.0; 2]);
    let runs = 6;
    let settled = |k: usize| k >= 20;
    for seed in 0..runs {
        let (record, truth) = simulate(of(AxisMotion::damped_oscillation()), 20.0, 20.0, seed);
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        for (sum, one) in pooled.iter_mut().zip(both(&result, &truth, settled)) {
            sum[0] += one[0] / runs as f64;
            sum[1] += one[1] / runs as f64;
        }
        let model = CountingModel {
            acceleration_noise: NOISE * NOISE,
            edge: 1e-6,
            offset: 0.13,
            walk: 0.0,
        };
        let methods = [
            Method::Counting { model },
            Method::CountingSmoother { model },
        ];
        for (sum, method) in told.iter_mut().zip(methods) {
            let run = method.run(&record).unwrap();
            let u = run.standard_uncertainty.as_deref().unwrap();
            *sum += judged(&run.velocity, u, &truth, settled)[1] / runs as f64;
        }
    }
    println!("{pooled:?} {told:?}");
    for ([share, square], told) in pooled.iter().zip(told) {
        assert!((0.93..0.99).contains(share), "{pooled:?}");
        assert!((square / told).sqrt() < 1.1, "{pooled:?} {told:?}");
    }
}
