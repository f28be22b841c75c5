use super::*;
use crate::model::{Mode, TransducerModel};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const RATE: f64 = 20_000.0;

fn device() -> TransducerModel {
    TransducerModel {
        modes: vec![Mode {
            frequency: 1500.0,
            damping: 0.05,
            share: 1.0,
        }],
        ..TransducerModel::flat(0.02)
    }
}

/// Steps of so many periods and so much amplitude each, with a pause between them; the device follows at once.
fn stepped(steps: &[(f64, f64, f64)], pause: usize, noise: [f64; 2], seed: u64) -> [Vec<f64>; 2] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut channels = [vec![0.0; pause], vec![0.0; pause]];
    let mut phase = 0.3;
    for &(frequency, periods, amplitude) in steps {
        let s = device().response(frequency);
        let n = (periods * RATE / frequency) as usize;
        for _ in 0..n {
            let z = Complex64::from_polar(amplitude, phase);
            channels[0].push(z.re);
            channels[1].push((z * s).re);
            phase += TAU * frequency / RATE;
        }
        for c in &mut channels {
            c.extend(std::iter::repeat_n(0.0, pause));
        }
    }
    for (channel, noise) in channels.iter_mut().zip(noise) {
        for v in channel.iter_mut() {
            let e: f64 = StandardNormal.sample(&mut rng);
            *v += noise * e;
        }
    }
    channels
}

fn octaves() -> Vec<(f64, f64, f64)> {
    [
        40.0, 80.0, 160.0, 315.0, 630.0, 1000.0, 1250.0, 1600.0, 2000.0,
    ]
    .into_iter()
    .map(|f| (f, 30.0 + f / 8.0, 10.0))
    .collect()
}

#[test]
fn known_steps_are_found_with_and_without_pauses() {
    // Levels from 0.5 to 10 m/s², frequencies from an octave to 3 % apart.
    let close: Vec<(f64, f64, f64)> = (0..12)
        .map(|k| {
            let f = 100.0 * 1.03f64.powi(k);
            (f, 60.0, if k % 3 == 0 { 0.5 } else { 10.0 })
        })
        .collect();
    for (steps, noise) in [
        (octaves(), 0.0),
        (octaves(), 0.05),
        (close.clone(), 0.0),
        (close, 0.02),
    ] {
        for pause in [0, 3000] {
            let [x, y] = stepped(&steps, pause, [noise, 0.02 * noise], 7);
            let found = SineSteps::default().evaluate(&x, &y, RATE).unwrap();
            let frequencies: Vec<f64> = found.steps.iter().map(|s| s.frequency).collect();
            assert_eq!(
                found.steps.len(),
                steps.len(),
                "{pause} {noise} {frequencies:?}"
            );
            assert!(found.findings.is_empty(), "{pause} {:?}", found.findings);
            for (step, (f, _, amplitude)) in found.steps.iter().zip(&steps) {
                assert!((step.frequency / f - 1.0).abs() < 1e-3, "{step:?} {f}");
                assert!((step.amplitude / amplitude - 1.0).abs() < 0.05, "{step:?}");
                let truth = device().response(step.frequency);
                let u = (step.covariance[0] + step.covariance[2]).sqrt();
                // Without noise a fit is exact but for the harmonics that a step's edges leave to it.
                assert!(
                    (step.response - truth).norm() < 5.0 * u + 1e-6 * truth.norm(),
                    "{step:?}"
                );
            }
        }
    }
}

#[test]
fn coverage_of_stepped_sines() {
    // Noise on both channels, at 40 runs of nine steps: 720 parts. 95 % ± 3 σ of the binomial, σ = √(0.05·0.95/720) = 0.8 %;
    // parts of one step are two independent readings.
    let (mut inside, mut all) = (0usize, 0usize);
    for seed in 0..40 {
        let [x, y] = stepped(&octaves(), 800, [0.03, 0.001], 100 + seed);
        let found = SineSteps::default().evaluate(&x, &y, RATE).unwrap();
        assert_eq!(found.steps.len(), 9);
        for step in found.steps {
            let d = step.response - device().response(step.frequency);
            let t = proofmass_uncertainty::student_quantile(0.975, step.dof);
            for (d, v) in [(d.re, step.covariance[0]), (d.im, step.covariance[2])] {
                all += 1;
                inside += usize::from(d.abs() <= t * v.sqrt());
            }
        }
    }
    let share = inside as f64 / all as f64;
    assert!((share - 0.95).abs() < 0.025, "{share} of {all}");
}

#[test]
fn refuses_what_has_no_steps() {
    let channel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..60_000).map(|k| f(f64::from(k) / RATE)).collect()
    };
    let search = SineSteps::default();
    let refused = |x: &[f64]| match search.evaluate(x, x, RATE) {
        Err(NoResponse::Steps(why)) => why,
        other => panic!("{other:?}"),
    };
    // From 20 Hz to 2 kHz within three seconds, and within the same a linear sweep.
    let sweep = channel(&|t| {
        let rate = 100f64.ln() / 3.0;
        (TAU * 20.0 / rate * ((rate * t).exp() - 1.0)).sin()
    });
    assert!(matches!(refused(&sweep), NoSteps::Sweep { .. }));
    let linear = channel(&|t| (TAU * (20.0 * t + 330.0 * t * t)).sin());
    assert!(matches!(refused(&linear), NoSteps::Sweep { .. }));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let noise: Vec<f64> = (0..60_000)
        .map(|_| StandardNormal.sample(&mut rng))
        .collect();
    assert!(matches!(refused(&noise), NoSteps::NoSine { .. }));
    assert!(matches!(refused(&vec![0.0; 1000]), NoSteps::NoSine { .. }));
    assert!(search.evaluate(&noise, &noise[1..], RATE).is_err());
    assert!(search.evaluate(&noise[..10], &noise[..10], RATE).is_err());
    let mut broken = sweep.clone();
    broken[5] = f64::NAN;
    assert!(search.evaluate(&broken, &sweep, RATE).is_err());
}

#[test]
fn known_faults_of_single_steps_are_named() {
    let mut steps = octaves();
    steps[3].1 = 8.0;
    let [x, mut y] = stepped(&steps, 500, [1e-4, 1e-6], 3);
    // The amplifier's range ends within the resonance.
    for v in &mut y {
        *v = v.clamp(-0.5, 0.5);
    }
    let found = SineSteps::default().evaluate(&x, &y, RATE).unwrap();
    let codes: Vec<&str> = found.findings.iter().map(Finding::code).collect();
    assert_eq!(
        codes,
        ["steps-too-short", "clipped"],
        "{:?}",
        found.findings
    );
    assert!(found.findings[0].evidence_text().starts_with("31"));
    assert!(
        found
            .steps
            .iter()
            .all(|s| s.amplitude * s.response.norm() < 0.5)
    );
    // A device that has not settled: its own ringing is still there.
    let [x, mut y] = stepped(&[(200.0, 60.0, 10.0)], 0, [1e-4, 1e-6], 3);
    for (k, v) in y.iter_mut().enumerate() {
        let t = k as f64 / RATE;
        *v += 0.2 * (-t / 0.15).exp() * (TAU * 207.0 * t).sin();
    }
    let found = SineSteps::default().evaluate(&x, &y, RATE).unwrap();
    assert_eq!(found.findings.len(), 1, "{:?}", found.findings);
    assert_eq!(found.findings[0].code(), "step-not-settled");
}

#[test]
fn law_repeated_frequencies_become_their_mean() {
    let step = |frequency: f64, re: f64| SineStep {
        frequency,
        samples: [0, 1],
        amplitude: 1.0,
        response: Complex64::new(re, 0.0),
        covariance: [0.04, 0.0, 0.04],
        dof: 5.0,
    };
    let merged = merged(vec![step(200.0, 1.0), step(100.0, 2.0), step(200.01, 3.0)]);
    assert_eq!(merged.len(), 2);
    assert_eq!(merged[1].response.re, 2.0);
    assert!((merged[1].covariance[0] - 0.02).abs() < 1e-15 && merged[1].dof == 10.0);
}
