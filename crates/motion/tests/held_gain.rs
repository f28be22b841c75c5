//! A gain whose uncertainty a calibration or a data sheet states: it holds where the readings tell little, and yields where they
//! tell more.

use proofmass_core::Unwatched;
use proofmass_motion::{EstimateResult, MotionRecord, ReadingSource, estimate};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// A sine of 1 Hz read with this noise for 20 s at 100 Hz, beside an accelerometer of this gain; and the true velocity.
fn record(amplitude: f64, noise: f64, gain: f64, seed: u64) -> (MotionRecord, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let dt = 0.01;
    let (mut reading, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..2000 {
        let (s, c) = (TAU * dt * f64::from(k)).sin_cos();
        reading.push(Some(amplitude * s + noise * normal()));
        acceleration.push(-gain * amplitude * TAU * TAU * s + 0.1 + 2e-3 * normal());
        truth.push(amplitude * TAU * c);
    }
    let record = MotionRecord::new(dt, ReadingSource::Position, reading, acceleration).unwrap();
    (record, truth)
}

fn gain_of(result: &EstimateResult) -> (f64, f64) {
    let gain = result.tuned.as_ref().unwrap().gain.expect("a gain");
    (gain.value, gain.uncertainty)
}

/// Readings that tell the gain to some 3 %, gains of sensors that scatter by 3 %: together 2.2 %.
#[test]
fn coverage_of_a_gain_that_is_held() {
    let (mut held, mut inside, mut all) = (0, 0usize, 0usize);
    for seed in 0..40 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(500 + seed);
        let scatter: f64 = StandardNormal.sample(&mut rng);
        let gain = 1.0 + 0.03 * scatter;
        let (mut record, truth) = record(2e-3, 2e-3, gain, seed);
        record.gain_uncertainty = Some(0.03);
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        let (found, u) = gain_of(&result);
        assert!((0.01..0.03).contains(&u), "{u}");
        held += usize::from((found - gain).abs() < 1.959_964 * u);
        let smooth = &result.smoother;
        let uncertainty = smooth.standard_uncertainty.as_ref().unwrap();
        all += truth.len();
        inside += (0..truth.len())
            .filter(|&k| (smooth.velocity[k] - truth[k]).abs() < 1.959_964 * uncertainty[k])
            .count();
    }
    let share = inside as f64 / all as f64;
    println!("gain {held} of 40, smoother {share:.3}");
    // Binomial: fewer than 33 of 40 once in a thousand. Errors of the gain last for a record: forty independent ones.
    assert!(held >= 33, "{held}");
    assert!(share > 0.85, "{share}");
}

/// Readings that tell the gain to a thousandth outweigh a statement of 3 %, and one that is five times too small is not hidden.
#[test]
fn law_readings_that_tell_more_outweigh_what_is_stated() {
    let (mut record, _) = record(0.1, 1e-4, 1.15, 3);
    record.gain_uncertainty = Some(0.03);
    let result = estimate(&record, None, None, &Unwatched).unwrap();
    let (found, u) = gain_of(&result);
    assert!((found - 1.15).abs() < 4.0 * u + 1e-3, "{found} {u}");
    assert!(u < 3e-3, "{u}");
    assert!(result.findings.iter().any(|f| f.code() == "gain-mismatch"));
    record.gain_uncertainty = Some(-1.0);
    assert!(record.check().is_err());
}
