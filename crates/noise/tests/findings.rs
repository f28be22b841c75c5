//! Findings of this room: what is wrong with a record is told, and its sound twin is left in peace.

use proofmass_noise::{AnalysisOptions, NoiseChannel, NoiseModel, Sensor, analyse, simulate};
use proofmass_uncertainty::{Finding, Severity};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

const RATE: f64 = 100.0;

fn insist(code: &str, found: &[Finding]) {
    assert!(found.iter().any(|f| f.code() == code), "{code}: {found:#?}");
}

fn spare(code: &str, found: &[Finding]) {
    assert!(
        !found.iter().any(|f| f.code() == code),
        "{code}: {found:#?}"
    );
}

/// Gaussian samples of standard deviation one.
fn white(samples: usize, seed: u64) -> Vec<f64> {
    let model = NoiseModel {
        white: RATE.sqrt().recip(),
        ..Default::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(&model, samples, RATE, &mut rng).unwrap()
}

fn found(rate: &[f64]) -> Vec<Finding> {
    let channel = NoiseChannel {
        name: "x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate,
    };
    let analysis = analyse(&[channel], None, RATE, &AnalysisOptions::default()).unwrap();
    let own = analysis.channels.into_iter().flat_map(|c| c.findings);
    analysis.findings.into_iter().chain(own).collect()
}

#[test]
fn known_sound_record_raises_nothing() {
    let found = found(&white(40_000, 1));
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn known_step_of_the_converter_beyond_the_noise() {
    let stepped = |step: f64| -> Vec<f64> {
        let y = white(40_000, 2);
        y.iter().map(|v| (v / step).round() * step).collect()
    };
    insist("coarse-resolution", &found(&stepped(2.5)));
    spare("coarse-resolution", &found(&stepped(0.1)));
}

#[test]
fn known_disturbances_large_and_small() {
    let mut shaken = white(40_000, 3);
    shaken[23_456..23_956].iter_mut().for_each(|v| *v *= 4.0);
    let told = found(&shaken);
    insist("disturbance", &told);
    let gravest = told.iter().map(Finding::severity).max();
    assert_eq!(gravest, Some(Severity::Decision));
    // What stays is taken out of the noise, and is no disturbance besides.
    let mut step = white(40_000, 3);
    step[23_456..].iter_mut().for_each(|v| *v += 3.0);
    insist("mean-steps", &found(&step));
    spare("disturbance", &found(&step));
    let mut spike = white(40_000, 4);
    spike[12_345] += 12.0;
    insist("isolated-spikes", &found(&spike));
    spare("disturbances-together", &found(&spike));
    // One of them is a thousandth of the variance, all together a fifth.
    let mut spikes = white(40_000, 5);
    spikes.iter_mut().step_by(200).for_each(|v| *v += 6.5);
    insist("disturbances-together", &found(&spikes));
}

/// Too few samples for a spectrum of anything.
#[test]
fn known_record_that_is_too_short_for_coefficients() {
    insist("no-coefficients", &found(&white(24, 6)));
}

/// A parabola leaves the curve but not the pieces of the spectrum, from which straight lines are removed.
#[test]
fn known_curve_that_does_not_follow_from_the_density() {
    let n = 200_000;
    let bent: Vec<f64> = white(n, 7)
        .iter()
        .enumerate()
        .map(|(k, v)| v + 40.0 * (k as f64 / n as f64 - 0.5).powi(2))
        .collect();
    insist("density-and-allan-differ", &found(&bent));
}

/// A resonance at 42 Hz of 50 Hz: too weak for a filter to be suspected, and no noise term has such a bump.
#[test]
fn known_resonance_in_the_upper_band_is_left_out() {
    let (radius, angle) = (0.97_f64, 0.42 * std::f64::consts::TAU);
    let ringing = |size: f64| -> Vec<f64> {
        let drive = white(40_000, 8);
        let mut y = [0.0; 2];
        let rung = drive.iter().map(|x| {
            let next = 2.0 * radius * angle.cos() * y[0] - radius * radius * y[1] + x;
            y = [next, y[0]];
            next
        });
        let rest = white(40_000, 9);
        rung.zip(rest).map(|(r, w)| w + size * r).collect()
    };
    let told = found(&ringing(0.03));
    let left = told.iter().find(|f| f.code() == "resonance-left-out");
    let evidence = left.unwrap().evidence_text();
    let used: f64 = evidence.split(' ').nth(3).unwrap().parse().unwrap();
    assert!((35.0..42.0).contains(&used), "{evidence}");
    spare("resonance-left-out", &found(&ringing(0.0)));
}
