//! Dynamic tests: shock, frequency response, step, levels, motion, deconvolution.

use crate::agreement::check;
use crate::ask;
use proofmass_dynamic::model::{
    FitProblem, Mode, ModelFit, ModelStructure, ResponsePoints, TransducerModel,
};
use proofmass_dynamic::required_density::{RequiredDensity, RequiredPoint};
use proofmass_dynamic::step::step_response;
use proofmass_jobs::deconvolution::{DeconvolutionData, DeconvolutionJob};
use proofmass_jobs::linearity::{LinearityData, LinearityJob};
use proofmass_jobs::motion::{MotionData, MotionJob};
use proofmass_jobs::response::{Excitation, ModelData, ModelJob, ResponseData, ResponseJob};
use proofmass_jobs::shock::{ShockData, ShockJob};
use proofmass_jobs::step::{StepData, StepJob};
use proofmass_jobs::{AnyData, Channel};
use proofmass_noise::{NoiseModel, simulate};
use proofmass_signal::PulseShape;
use rand::SeedableRng;

fn noise(amplitude: f64, samples: usize, seed: u64) -> Vec<f64> {
    let model = NoiseModel {
        white: amplitude,
        ..NoiseModel::default()
    };
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(&model, samples, 1.0, &mut rng).expect("noise")
}

fn channel<'a>(name: &'a str, unit: &'a str, data: &'a [f64]) -> Channel<'a> {
    Channel { name, unit, data }
}

/// 500 m/s² for 11 ms at 20 kHz.
fn pulse() -> Vec<f64> {
    let clean = PulseShape::HalfSine.record(500.0, 0.011, 0.1, 6000, 20e3);
    let noise = noise(0.02, clean.len(), 3);
    clean.iter().zip(noise).map(|(a, e)| a + e).collect()
}

/// Alone, and against a reference.
pub fn shock(kind: &str) {
    let reference = pulse();
    let noise = noise(2e-5, reference.len(), 4);
    let output: Vec<f64> = reference
        .iter()
        .zip(noise)
        .map(|(a, e)| 0.01 * a + e)
        .collect();
    let mut job = ShockJob::default();
    job.per_octave = 3;
    for data in [
        ShockData {
            reference: None,
            output: channel("a", "m/s²", &reference),
            rate: 20e3,
            findings: &[],
            name: "memory",
        },
        ShockData {
            reference: Some(channel("a", "m/s²", &reference)),
            output: channel("u", "V", &output),
            rate: 20e3,
            findings: &[],
            name: "memory",
        },
    ] {
        let result = check(kind, &|watch| {
            ask(job.clone(), &AnyData::Shock(data.clone()), watch)
        });
        assert!(!result.quantities().is_empty());
    }
}

/// In a record of a million samples the pulse is drawn as it was sampled: its flat top has all its points and no apex, and the
/// figure of the whole record keeps the extremes.
#[test]
fn law_a_pulse_keeps_its_shape() {
    let (rate, first, top) = (100e3, 500_000, 200);
    let mut record = noise(0.5, 1_000_000, 5);
    for (k, a) in record[first..first + top].iter_mut().enumerate() {
        // Up, flat and down again; each flank takes fifty samples.
        let flank = (k.min(top - 1 - k) as f64 / 50.0).min(1.0);
        *a += 1000.0 * flank;
    }
    let data = ShockData {
        reference: None,
        output: channel("a", "m/s²", &record),
        rate,
        findings: &[],
        name: "memory",
    };
    let mut job = ShockJob::default();
    job.per_octave = 1;
    let result = ask(job, &AnyData::Shock(data), &proofmass_jobs::Unwatched).expect("a result");
    let report = serde_json::to_value(result.report()).expect("JSON");
    let panels = &report["answer"]["figure"]["plot"]["xy"]["panels"];
    let drawn = panels[0]["series"][0]["y"].as_array().expect("a curve");
    let drawn: Vec<f64> = drawn.iter().filter_map(serde_json::Value::as_f64).collect();
    let high = drawn.iter().filter(|y| **y > 990.0).count();
    assert_eq!(high, top - 100, "points of the flat top");
    let largest = record.iter().copied().fold(f64::MIN, f64::max);
    let seen = drawn.iter().copied().fold(f64::MIN, f64::max);
    assert!((seen - largest).abs() < 0.5, "{seen} {largest}");
}

pub fn response(kind: &str) {
    let input = noise(1.0, 8000, 1);
    let own = noise(1e-3, 8000, 2);
    let output: Vec<f64> = input.iter().zip(own).map(|(x, e)| 0.02 * x + e).collect();
    let mut job = ResponseJob::new(Excitation::Random);
    job.model = Some(ModelStructure::modes(0));
    let result = check(kind, &|watch| {
        let data = ResponseData {
            recordings: vec![[channel("a", "m/s²", &input), channel("u", "V", &output)]],
            rate: 1000.0,
            findings: &[],
            name: "memory",
        };
        ask(job.clone(), &AnyData::Response(data), watch)
    });
    assert_eq!(result.quantities()[0].name, "sensitivity");
    // The same with a resonance at 120 Hz.
    let (mut resonant, mut a, mut b) = (Vec::new(), 0.0, 0.0);
    let (turn, decay) = (std::f64::consts::TAU * 0.12, 0.98_f64);
    for (x, y) in input.iter().zip(&output) {
        let next = 2.0 * decay * turn.cos() * a - decay * decay * b + 0.01 * x;
        (b, a) = (a, next);
        resonant.push(y + next);
    }
    check(kind, &|watch| {
        let data = ResponseData {
            recordings: vec![[channel("a", "m/s²", &input), channel("u", "V", &resonant)]],
            rate: 1000.0,
            findings: &[],
            name: "memory",
        };
        ask(
            ResponseJob::new(Excitation::Random),
            &AnyData::Response(data),
            watch,
        )
    });
}

/// A mass at 900 Hz with a damping of 0.3, and 0.02 V/(m/s²).
fn points() -> ResponsePoints {
    let model = TransducerModel {
        modes: vec![Mode {
            frequency: 900.0,
            damping: 0.3,
            share: 1.0,
        }],
        ..TransducerModel::flat(0.02)
    };
    let frequency: Vec<f64> = (1..=40).map(|k| 40.0 * f64::from(k)).collect();
    let n = frequency.len();
    let value: Vec<_> = frequency.iter().map(|f| model.response(*f)).collect();
    let error = noise(1.0, n, 9);
    let modulus: Vec<f64> = value
        .iter()
        .zip(error)
        .map(|(s, e)| s.norm() * (1.0 + 1e-3 * e))
        .collect();
    let phase: Vec<f64> = value.iter().map(|s| s.arg()).collect();
    let u: Vec<f64> = modulus.iter().map(|m| 1e-3 * m).collect();
    ResponsePoints::polar(frequency, &modulus, &u, &phase, &vec![1e-3; n], "V/(m/s²)")
        .expect("points")
}

fn fit(points: &ResponsePoints) -> ModelFit {
    let problem = FitProblem::new(ModelStructure::modes(1));
    problem.fit(points).expect("a model")
}

pub fn transducer_model(kind: &str) {
    let points = points();
    let result = check(kind, &|watch| {
        let data = ModelData {
            points: &points,
            findings: &[],
            name: "memory",
        };
        let job = ModelJob::new(ModelStructure::modes(1));
        ask(job, &AnyData::TransducerModel(data), watch)
    });
    assert_eq!(result.quantities()[0].name, "sensitivity");
}

pub fn step(kind: &str) {
    let rate = 5000.0;
    let own = noise(1e-3, 1500, 5);
    let record: Vec<f64> = own
        .iter()
        .enumerate()
        .map(|(k, e)| {
            let t = (k as f64 - 300.0) / rate;
            let height = if t > 0.0 {
                step_response(t, 100.0, 0.2)
            } else {
                0.0
            };
            0.3 + 2.0 * height + e
        })
        .collect();
    let result = check(kind, &|watch| {
        let data = StepData {
            channel: channel("u", "V", &record),
            rate,
            findings: &[],
            name: "memory",
        };
        ask(StepJob::default(), &AnyData::Step(data), watch)
    });
    assert!(!result.quantities().is_empty());
}

pub fn levels(kind: &str) {
    let level: Vec<f64> = (1..=12).map(|k| 10.0 * f64::from(k)).collect();
    let own = noise(1e-4, level.len(), 6);
    let output: Vec<f64> = level.iter().zip(own).map(|(a, e)| 0.02 * a + e).collect();
    let u = vec![1e-4; level.len()];
    let result = check(kind, &|watch| {
        let data = LinearityData {
            level: channel("a", "m/s²", &level),
            output: channel("u", "V", &output),
            uncertainty: channel("s", "V", &u),
            findings: &[],
            name: "memory",
        };
        ask(LinearityJob::default(), &AnyData::Levels(data), watch)
    });
    assert!(!result.quantities().is_empty());
}

pub fn motion(kind: &str) {
    let record: Vec<f64> = (0..4000).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let mut job = MotionJob::default();
    job.relative_uncertainty = 0.01;
    job.periods = vec![0.02, 0.1, 1.0];
    // A sine is beyond any flat spectrum at its own line.
    job.required = Some(RequiredDensity {
        name: "flat".into(),
        points: [20.0, 400.0]
            .map(|frequency| RequiredPoint {
                frequency,
                density: 1e-4,
                tolerance: RequiredDensity::TOLERANCE,
            })
            .to_vec(),
    });
    let result = check(kind, &|watch| {
        let data = MotionData {
            channel: channel("a", "m/s²", &record),
            rate: 1000.0,
            findings: &[],
            name: "memory",
        };
        ask(job.clone(), &AnyData::Motion(data), watch)
    });
    assert!(!result.quantities().is_empty());
}

pub fn deconvolution(kind: &str) {
    let fit = fit(&points());
    let record: Vec<f64> = pulse().iter().map(|a| 0.02 * a).collect();
    let result = check(kind, &|watch| {
        let data = DeconvolutionData {
            fit: &fit,
            unit: "V/(m/s²)",
            channel: channel("u", "V", &record),
            rate: 20e3,
            findings: &[],
            name: "memory",
        };
        ask(
            DeconvolutionJob::default(),
            &AnyData::Deconvolution(data),
            watch,
        )
    });
    assert_eq!(result.quantities()[0].name, "peak");
}
