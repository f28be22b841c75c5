//! Inputs of the dynamic tests that are cut off, and sweeps as they are first asked for.

use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::model::{
    FitProblem, Mode, ModelFit, ModelStructure, ResponsePoints, TransducerModel,
};
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_dynamic::step::step_response;
use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
use proofmass_jobs::deconvolution::{DeconvolutionData, DeconvolutionJob};
use proofmass_jobs::motion::{MotionData, MotionJob};
use proofmass_jobs::response::{Excitation, ResponseData, ResponseJob};
use proofmass_jobs::shock::{ShockData, ShockJob};
use proofmass_jobs::step::{StepData, StepJob};
use proofmass_jobs::{AnyData, AnyJob, Channel, Job, Outcome, Record, StoredResult, Unwatched};
use proofmass_signal::{Peaks, PulseShape, fourier};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const RATE: f64 = 20e3;

fn device() -> TransducerModel {
    let mode = Mode {
        frequency: 1500.0,
        damping: 0.1,
        share: 1.0,
    };
    TransducerModel {
        modes: vec![mode],
        ..TransducerModel::flat(0.02)
    }
}

fn driven(x: &[f64]) -> Vec<f64> {
    let spectrum = fourier::forward(x);
    let lines = spectrum.iter().enumerate();
    let lines = lines.map(|(k, v)| v * device().response(k as f64 * RATE / x.len() as f64));
    fourier::inverse(lines.collect(), x.len()).expect("an output")
}

fn noise(size: f64, n: usize, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let normal = || -> f64 { StandardNormal.sample(&mut rng) };
    std::iter::repeat_with(normal)
        .take(n)
        .map(|e| size * e)
        .collect()
}

fn with_noise(x: Vec<f64>, size: f64, seed: u64) -> Vec<f64> {
    let e = noise(size, x.len(), seed);
    x.into_iter().zip(e).map(|(x, e)| x + e).collect()
}

/// From one frequency to another within the record, logarithmic.
fn sweep(from: f64, to: f64, n: usize) -> Vec<f64> {
    let rate = (to / from).ln() / (n as f64 / RATE);
    let at = |k: usize| (TAU * from / rate * ((rate * k as f64 / RATE).exp() - 1.0)).sin();
    (0..n).map(at).collect()
}

fn cut(x: &[f64], at: [f64; 2]) -> Vec<f64> {
    let low = x.iter().copied().fold(0.0, f64::min);
    let high = x.iter().copied().fold(0.0, f64::max);
    x.iter()
        .map(|v| v.clamp(at[0] * low, at[1] * high))
        .collect()
}

fn channel<'a>(name: &'a str, unit: &'a str, data: &'a [f64]) -> Channel<'a> {
    Channel { name, unit, data }
}

/// A shock of a device alone.
fn shock<'a>(unit: &'a str, record: &'a [f64]) -> ShockData<'a> {
    ShockData {
        reference: None,
        output: channel("output", unit, record),
        rate: RATE,
        findings: &[],
        name: "memory",
    }
}

fn ask(job: impl Into<AnyJob>, data: &AnyData<'_>) -> StoredResult {
    let answer = job.into().evaluate(data, Record::default(), &Unwatched);
    answer.unwrap_or_else(|e| panic!("{e}"))
}

fn codes(result: &StoredResult) -> Vec<String> {
    let findings = result.findings().iter();
    findings.map(|f| f.code().to_owned()).collect()
}

fn response(job: &ResponseJob, x: &[f64], y: &[f64]) -> StoredResult {
    let data = ResponseData {
        recordings: vec![[channel("a", "m/s²", x), channel("u", "V", y)]],
        rate: RATE,
        findings: &[],
        name: "memory",
    };
    ask(job.clone(), &AnyData::Response(data))
}

fn fit() -> ModelFit {
    let f: Vec<f64> = (1..=40).map(|k| 60.0 * f64::from(k)).collect();
    let response: Vec<_> = f.iter().map(|f| device().response(*f)).collect();
    let modulus: Vec<f64> = response.iter().map(|s| s.norm()).collect();
    let phase: Vec<f64> = response.iter().map(|s| s.arg()).collect();
    let u: Vec<f64> = modulus.iter().map(|m| 1e-3 * m).collect();
    let points = ResponsePoints::polar(f, &modulus, &u, &phase, &[1e-3; 40], "V/(m/s²)");
    let fit = FitProblem::new(ModelStructure::modes(1)).fit(&points.expect("points"));
    fit.expect("a fit")
}

#[test]
fn known_cut_inputs_of_responses_are_named() {
    let random = with_noise(driven(&noise(10.0, 60_000, 1)), 1e-5, 2);
    let random = (noise(10.0, 60_000, 1), random);
    let swept = sweep(30.0, 3000.0, 100_000);
    let swept = (swept.clone(), with_noise(driven(&swept), 1e-5, 3));
    let blows: Vec<f64> = (0..60_000)
        .map(|k| {
            let t = (k % 6000) as f64 - 500.0;
            if t.abs() < 20.0 {
                50.0 * (0.5 + 0.5 * (t / 20.0 * 0.5 * TAU).cos())
            } else {
                0.0
            }
        })
        .collect();
    let answered = with_noise(driven(&blows), 1e-4, 5);
    let blows = (with_noise(blows, 1e-3, 4), answered);
    let mut stepped = Vec::new();
    for f in [80.0, 310.0, 770.0, 1210.0] {
        stepped.extend((0..20_000).map(|k| (TAU * f * f64::from(k) / RATE).sin()));
    }
    let stepped = (stepped.clone(), with_noise(driven(&stepped), 1e-5, 6));
    for (excitation, (x, y), level) in [
        (Excitation::Random, random, 0.45),
        (Excitation::Sweep, swept, 0.8),
        (Excitation::Impact, blows, 0.6),
        (Excitation::Steps, stepped, 0.8),
    ] {
        let job = ResponseJob::new(excitation);
        let whole = codes(&response(&job, &x, &y));
        assert!(
            !whole.iter().any(|c| c == "clipped"),
            "{excitation:?} {whole:?}"
        );
        for sides in [[level, level], [2.0, level], [level, 2.0]] {
            let found = codes(&response(&job, &x, &cut(&y, sides)));
            assert!(
                found.iter().any(|c| c == "clipped"),
                "{excitation:?} {sides:?} {found:?}"
            );
        }
    }
}

#[test]
fn refuses_a_channel_without_signal() {
    let (x, still) = (noise(1.0, 4000, 1), vec![0.0; 4000]);
    for (excitation, input, output) in [
        (Excitation::Random, &still, &x),
        (Excitation::Sweep, &x, &still),
        (Excitation::Impact, &still, &still),
    ] {
        let data = ResponseData {
            recordings: vec![[channel("a", "m/s²", input), channel("u", "V", output)]],
            rate: RATE,
            findings: &[],
            name: "memory",
        };
        let answer = ResponseJob::new(excitation).evaluate(&data, &Unwatched);
        let said = answer.expect_err("a refusal").to_string();
        assert!(said.contains("is constant"), "{said}");
    }
}

#[test]
fn known_cut_shocks_and_steps_are_named() {
    let pulse = PulseShape::HalfSine.record(500.0, 0.011, 0.1, 6000, RATE);
    let pulse = with_noise(driven(&pulse), 1e-3, 7);
    let step: Vec<f64> = (0..3000)
        .map(|k| step_response(f64::from(k) / RATE - 0.02, 300.0, 0.1))
        .collect();
    let step = with_noise(step, 1e-3, 8);
    let fit = fit();
    let named = |pulse: &[f64], step: &[f64]| {
        let shock = shock("V", pulse);
        let deconvolution = DeconvolutionData {
            fit: &fit,
            unit: "V/(m/s²)",
            channel: channel("u", "V", pulse),
            rate: RATE,
            findings: &[],
            name: "memory",
        };
        let step = StepData {
            channel: channel("u", "V", step),
            rate: RATE,
            findings: &[],
            name: "memory",
        };
        let mut job = ShockJob::default();
        job.per_octave = 1;
        [
            codes(&ask(job, &AnyData::Shock(shock))),
            codes(&ask(
                DeconvolutionJob::default(),
                &AnyData::Deconvolution(deconvolution),
            )),
            codes(&ask(StepJob::default(), &AnyData::Step(step))),
        ]
        .map(|found| found.iter().any(|c| c == "clipped"))
    };
    assert_eq!(named(&pulse, &step), [false; 3]);
    // A pulse by a twentieth, where it is flat for a fifth of its length; the ringing of a step where it swings highest.
    assert_eq!(
        named(&cut(&pulse, [2.0, 0.95]), &cut(&step, [2.0, 0.8])),
        [true; 3]
    );
}

#[test]
fn regress_a_model_that_fails_does_not_take_the_response_with_it() {
    let x = sweep(20.0, 3000.0, 40_000);
    let y = with_noise(driven(&x), 1e-3, 1);
    let mut job = ResponseJob::new(Excitation::Sweep);
    // Four modes where the device is flat.
    job.band = Some([100.0, 120.0]);
    job.model = Some(ModelStructure::modes(4));
    let result = response(&job, &x, &y);
    assert!(
        codes(&result).contains(&"model-not-fitted".to_owned()),
        "{:?}",
        codes(&result)
    );
}

#[test]
fn known_calibrations_that_hardly_meet_are_told() {
    let certificate = |f: &[f64]| {
        let line = |frequency: &f64| ReferencePoint {
            frequency: *frequency,
            sensitivity: 0.01,
            phase: 0.0,
            modulus_uncertainty: 0.005,
            phase_uncertainty: 0.005,
        };
        let table = ReferenceTable::new(f.iter().map(line).collect()).expect("a table");
        FrequencyResponse::try_from(&table).expect("a response")
    };
    let (wide, narrow) = (
        certificate(&[10.0, 20.0, 40.0, 80.0, 160.0]),
        certificate(&[80.0, 160.0]),
    );
    let said = |responses: &[&FrequencyResponse]| {
        let names = ["A", "B"];
        let data = ComparisonData {
            responses,
            names: &names,
            findings: &[],
        };
        let outcome = ComparisonJob::default()
            .evaluate(&data, &Unwatched)
            .expect("a comparison");
        let findings = outcome.findings().iter();
        findings
            .map(|f| (f.code().to_owned(), f.evidence_text().to_owned()))
            .collect::<Vec<_>>()
    };
    let found = said(&[&wide, &narrow]);
    let lost = found.iter().find(|f| f.0 == "frequencies-not-compared");
    assert_eq!(
        lost.map(|f| f.1.as_str()),
        Some("2 frequencies were compared; beyond them 3 of 5 of A")
    );
    assert!(
        said(&[&wide, &wide])
            .iter()
            .all(|f| f.0 != "frequencies-not-compared")
    );
}

#[test]
fn coverage_of_sweeps_as_typed_first() {
    let (mut fitted, mut held, mut asked) = (0, 0, 0);
    for seed in 0..10 {
        for (from, to, n) in [(20.0, 3000.0, 100_000), (3000.0, 50.0, 40_000)] {
            let x = sweep(from, to, n);
            let y = with_noise(driven(&x), 2e-4, 20 + seed);
            let mut job = ResponseJob::new(Excitation::Sweep);
            job.model = Some(ModelStructure::modes(1));
            let result = response(&job, &with_noise(x, 1e-2, 90 + seed), &y);
            asked += 1;
            fitted += u32::from(!codes(&result).iter().any(|c| c == "model-not-fitted"));
            let mode = result
                .quantities()
                .iter()
                .find(|q| q.name == "mode.1.frequency");
            held += u32::from(mode.is_some_and(|q| (q.value - 1500.0).abs() <= q.expanded));
        }
    }
    // 95 % of 20: fewer than 16 once in 400.
    assert!(fitted == asked && held >= 16, "{fitted} {held} of {asked}");
}

/// What is found in a strong motion of 100 s at 200 Hz beside this offset, at the vibration up to this frequency.
fn motion(offset: f64, highest: f64) -> Vec<(String, String)> {
    let (rate, n) = (200.0, 20_000);
    let record: Vec<f64> = (0..n)
        .map(|k| {
            let t = f64::from(k) / rate;
            offset + 2.0 * (-((t - 40.0) / 8.0).powi(2)).exp() * (TAU * 3.0 * t).sin()
        })
        .collect();
    let mut job = MotionJob::default();
    job.periods = vec![0.1, 1.0];
    job.vibration_band[1] = highest;
    let data = MotionData {
        channel: channel("a", "m/s²", &record),
        rate,
        findings: &[],
        name: "memory",
    };
    let outcome = job.evaluate(&data, &Unwatched).expect("a motion");
    let findings = outcome.findings().iter();
    findings
        .map(|f| (f.code().to_owned(), f.evidence_text().to_owned()))
        .collect()
}

#[test]
fn known_motions_that_drift_or_are_sampled_too_slowly() {
    assert!(motion(0.0, 80.0).is_empty());
    let drifting = motion(0.02, 80.0);
    let drift = drifting.iter().find(|f| f.0 == "velocity-drifts");
    // 0.02 m/s² for 100 s.
    assert!(
        drift.is_some_and(|f| f.1.starts_with("1.9999 m/s at the end")),
        "{drifting:?}"
    );
    let narrow = motion(0.0, 1000.0);
    let band = narrow.iter().find(|f| f.0 == "vibration-band-not-resolved");
    assert_eq!(
        band.map(|f| f.1.as_str()),
        Some("up to 90.0 Hz instead of 1000.0 Hz")
    );
}

/// A resonance whose half-width is 6 Hz in lines of 20 Hz, and in lines of half a hertz.
#[test]
fn known_resonance_between_the_lines_is_told() {
    let x = noise(10.0, 400_000, 11);
    let mode = Mode {
        frequency: 1500.0,
        damping: 0.002,
        share: 1.0,
    };
    let sharp = TransducerModel {
        modes: vec![mode],
        ..TransducerModel::flat(0.02)
    };
    let spectrum = fourier::forward(&x);
    let lines = spectrum.iter().enumerate();
    let lines = lines.map(|(k, v)| v * sharp.response(k as f64 * RATE / x.len() as f64));
    let y = fourier::inverse(lines.collect(), x.len()).expect("an output");
    let said = |segment: usize| {
        let mut job = ResponseJob::new(Excitation::Random);
        job.segment = Some(segment);
        let result = response(&job, &x, &with_noise(y.clone(), 1e-5, 12));
        let found = result.findings().iter().find(|f| f.code() == "leakage");
        found.map(|f| f.evidence_text().to_owned())
    };
    let coarse = said(1000).expect("a finding");
    let place = coarse
        .split(" at ")
        .nth(1)
        .and_then(|s| s.split(' ').next());
    let place: f64 = place.expect("a frequency").parse().expect("a number");
    assert!((place - 1500.0).abs() <= 20.0, "{coarse}");
    assert_eq!(said(40_000), None);
}

/// Half a millisecond sampled at 20 kHz: oscillators above a tenth of the rate fall between the samples.
#[test]
fn known_oscillators_too_fast_for_the_samples_are_told() {
    let pulse = PulseShape::HalfSine.record(500.0, 5e-4, 0.1, 4000, RATE);
    let pulse = with_noise(pulse, 1e-2, 13);
    let said = |highest: f64, peaks: Peaks| {
        let data = shock("m/s²", &pulse);
        let mut job = ShockJob::default();
        job.per_octave = 1;
        job.frequencies = Some([100.0, highest]);
        job.peaks = peaks;
        let result = ask(job, &AnyData::Shock(data));
        let mut findings = result.findings().iter();
        let found = findings.find(|f| f.code() == "few-samples-per-oscillation");
        found.map(|f| f.evidence_text().to_owned())
    };
    // 1 − cos(π f/f_s) is (π/5)²/2 there.
    let low = "4000 Hz at 20000 samples/s: peaks low by up to 20 %";
    assert_eq!(said(4000.0, Peaks::AtSamples).as_deref(), Some(low));
    assert_eq!(said(2000.0, Peaks::AtSamples), None);
    assert_eq!(said(4000.0, Peaks::BetweenSamples), None);
}

/// A tail that decays with 5 to 400 ms is no shift, whether it is over within the record of 0.6 s or not.
#[test]
fn coverage_a_decaying_tail_is_no_zero_shift() {
    let mut held = 0;
    for seed in 0..40u32 {
        let pulse = PulseShape::HalfSine.record(5.0, 0.011, 0.1, 12_000, RATE);
        let healthy = with_noise(pulse, 1e-3, 100 + u64::from(seed));
        let tau = 0.005 * 80f64.powf(f64::from(seed) / 39.0);
        let end = (0.111 * RATE) as usize;
        let tail = |k: usize| match k > end {
            true => 0.08 * (-((k - end) as f64) / (tau * RATE)).exp(),
            false => 0.0,
        };
        let record: Vec<f64> = healthy
            .iter()
            .enumerate()
            .map(|(k, v)| v + tail(k))
            .collect();
        let data = shock("V", &record);
        let mut job = ShockJob::default();
        job.per_octave = 1;
        let outcome = job.evaluate(&data, &Unwatched).expect("a shock");
        let shift = outcome
            .quantities()
            .into_iter()
            .find(|q| q.name == "zero_shift");
        let shift = shift.expect("a shift");
        held += usize::from(shift.value.abs() <= shift.expanded);
        assert!(
            outcome.findings().iter().all(|f| f.code() != "zero-shift"),
            "{tau}: {shift:?}"
        );
    }
    assert!(held >= 35, "{held} of 40");
}

/// 5 V for 11 ms beside noise of 1 mV; 20 ms later 80 mV stay.
#[test]
fn known_zero_shift_and_return_of_a_device() {
    let pulse = PulseShape::HalfSine.record(5.0, 0.011, 0.1, 12_000, RATE);
    let healthy = with_noise(pulse, 1e-3, 11);
    let end = ((0.111 + 0.02) * RATE) as usize;
    let shifted: Vec<f64> = healthy
        .iter()
        .enumerate()
        .map(|(k, v)| if k > end { v + 0.08 } else { *v })
        .collect();
    let of = |record: &[f64], band: Option<f64>| {
        let data = shock("V", record);
        let mut job = ShockJob::default();
        job.per_octave = 1;
        job.return_band = band;
        job.evaluate(&data, &Unwatched).expect("a shock")
    };
    let at_once = of(&healthy, None);
    let back = at_once.return_to_baseline().expect("a return");
    assert!(back.time.is_some_and(|t| t < 0.002), "{back:?}");
    let stays = of(&shifted, None);
    assert!(
        stays
            .findings()
            .iter()
            .any(|f| f.code() == "not-back-at-baseline")
    );
    let shift = stays
        .quantities()
        .into_iter()
        .find(|q| q.name == "zero_shift")
        .expect("a shift");
    assert!(
        (shift.value - 0.08).abs() < shift.expanded.max(2e-4),
        "{shift:?}"
    );
    let wide = of(&shifted, Some(0.2));
    assert!(
        wide.return_to_baseline()
            .is_some_and(|b| b.stated && b.time.is_some())
    );
    let data = shock("V", &healthy);
    let mut job = ShockJob::default();
    job.return_band = Some(0.0);
    assert!(job.evaluate(&data, &Unwatched).is_err());
}

/// Noise is no step, though an oscillator fits any record; one of fifteen times the noise is.
#[test]
fn refuses_a_step_in_noise() {
    let asked = |record: &[f64]| {
        let data = StepData {
            channel: channel("ax", "m/s²", record),
            rate: 1000.0,
            findings: &[],
            name: "memory",
        };
        StepJob::default().evaluate(&data, &Unwatched)
    };
    let refused: Vec<String> = (0..20)
        .map(|seed| {
            let refused = asked(&noise(0.01, 3000, seed)).expect_err("there is none");
            refused.to_string()
        })
        .collect();
    let named = refused
        .iter()
        .filter(|r| r.starts_with("there is no step in \"ax\": the height is "));
    assert!(named.count() > 0, "{refused:?}");
    let step =
        (0..3000).map(|k| 0.003 * step_response((f64::from(k) - 1000.0) / 1000.0, 5.0, 0.05));
    let outcome = asked(&with_noise(step.collect(), 2e-4, 3)).expect("a step");
    let height = outcome.estimate().unwrap().get("height").unwrap();
    assert!(
        (height.value - 0.003).abs() < 5.0 * height.standard_uncertainty,
        "{height:?}"
    );
}
