//! An accelerometer that shows less of slow accelerations: the corner is stated or found, the intervals hold, and the velocity is as good
//! as beside one that measures down to zero. A healthy one has no corner. The map over corners and motions is the program `velocity_map`
//! of `proofmass-jobs`.

use crate::motions::{HighPass, Motion, STEP, hand, of_seeds, s_curve, stop_and_go};
use proofmass_core::Unwatched;
use proofmass_motion::{LowCorner, MotionRecord, ReadingSource, Tuning, estimate, tune};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const DT: f64 = 1e-3;
const N: usize = 8000;

/// Readings of 2000 counts a turn, and an accelerometer behind a high-pass of first order with an offset behind that; the true velocity.
fn simulate(motion: &Motion, corner: Option<f64>, seed: u64) -> (MotionRecord, Vec<f64>) {
    let fine = (DT / STEP).round() as usize;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let increment = TAU * 0.05 / 2000.0;
    let phase: f64 = rng.random();
    let mut stage = HighPass::new(corner.unwrap_or(0.0), motion(0.0)[2]);
    let (mut reading, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..N {
        let [x, v, a] = motion(DT * k as f64);
        let mut passed = a;
        for i in 1..=fine * usize::from(k > 0) {
            passed = stage.pass(motion(DT * (k - 1) as f64 + STEP * i as f64)[2]);
        }
        let noise: f64 = StandardNormal.sample(&mut rng);
        reading.push(Some(((x / increment + phase).floor() + 0.5) * increment));
        acceleration.push(passed + 0.05 + 0.02 * noise);
        truth.push(v);
    }
    let mut record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
    record.increment = Some(increment);
    (record, truth)
}

/// Share of the samples inside of 95 % and RMS, of the filter and of the smoother, and the corner that was used.
type Row = ([(f64, f64); 2], Option<LowCorner>);

fn rows(name: &str, corner: Option<f64>, stated: bool, seeds: u64) -> Vec<Row> {
    of_seeds(seeds, |seed| {
        let motion = match name {
            "hand" => hand(2.0, 7000 + seed),
            "S-curve" => s_curve(1.0, 5.0, 100.0),
            _ => stop_and_go(0.5, 0.4),
        };
        let (mut record, truth) = simulate(&motion, corner, seed);
        if stated {
            record.low_corner = corner.map(|f| LowCorner::new(f, 0.0, 1).unwrap());
        }
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        let found = result
            .findings
            .iter()
            .any(|f| f.code() == "low-corner-found");
        assert_eq!(found, corner.is_some() && !stated, "{name} {corner:?}");
        let traces = [&result.trace, &result.smoother].map(|trace| {
            let u = trace.standard_uncertainty.as_ref().unwrap();
            let off = |k: usize| trace.velocity[k] - truth[k];
            let all = 200..N;
            let inside = all.clone().filter(|&k| off(k).abs() <= 1.96 * u[k]).count();
            let square: f64 = all.clone().map(|k| off(k).powi(2)).sum();
            let n = all.len() as f64;
            (inside as f64 / n, (square / n).sqrt())
        });
        (traces, result.low_corner)
    })
}

#[test]
fn law_a_corner_is_found_or_stated_and_the_intervals_hold() {
    for (name, corner, stated) in [
        ("hand", 0.1, false),
        ("stop and go", 0.5, false),
        ("S-curve", 2.0, false),
        ("stop and go", 0.1, true),
    ] {
        let healthy = rows(name, None, false, 2);
        let rows = rows(name, Some(corner), stated, 2);
        for i in 0..2 {
            let mean = |rows: &[Row], of: &dyn Fn(&Row) -> f64| {
                rows.iter().map(of).sum::<f64>() / rows.len() as f64
            };
            let inside = mean(&rows, &|r| r.0[i].0);
            assert!(inside > 0.9, "{name}, {corner} Hz: {inside}");
            let rms = mean(&rows, &|r| r.0[i].1) / mean(&healthy, &|r| r.0[i].1);
            // Its noise was integrated with the rest: the higher the corner, the less is left of the slow ones.
            let most = if corner < 1.0 { 2.0 } else { 3.5 };
            assert!(rms < most, "{name}, {corner} Hz: {rms}");
        }
        for (_, found) in rows {
            let found = found.unwrap();
            let off = found.frequency - corner;
            assert!(off.abs() <= 4.0 * found.uncertainty + 1e-12, "{found:?}");
        }
    }
}

#[test]
fn law_tuning_gives_back_what_the_corner_took() {
    let (record, _) = simulate(&stop_and_go(0.5, 0.4), Some(0.3), 7);
    let tuned = tune(&record, &Tuning::default(), &Unwatched).unwrap();
    let corner = tuned.low_corner.unwrap();
    assert!((corner.frequency - 0.3).abs() < 4.0 * corner.uncertainty);
    assert!(
        tuned
            .findings
            .iter()
            .any(|f| f.code() == "low-corner-found")
    );
    let healthy = simulate(&stop_and_go(0.5, 0.4), None, 7).0;
    assert!(
        tune(&healthy, &Tuning::default(), &Unwatched)
            .unwrap()
            .low_corner
            .is_none()
    );
}
