//! The steps behind a calibration, in memory: simulated signals with known truth, and the functions of the chip on the same samples.

use proofmass_core::{
    Butterworth, Compensation, Decimator, DecimatorState, Gravity, Matrix3, SensorModel, TaitBryan,
};
use proofmass_documents::{AnyCalibration, CalibrationFile};
use proofmass_io::{Source, Unit};
use proofmass_jobs::apply::{
    ApplyData, ApplyJob, ApplyOutcome, Destination, LowPass, LowPassForm, Rotation,
};
use proofmass_jobs::bias::{AxisNoise, BiasData, BiasJob, TrackedBias};
use proofmass_jobs::{Job, Outcome, Record, StoredResult, Trouble, Unwatched};
use proofmass_uncertainty::Estimate;
use std::f64::consts::TAU;
use std::fmt::Write;

const K: [[f64; 3]; 3] = [[415.0, 1.25, 4.0], [0.5, 412.5, 8.75], [-0.5, 0.25, 414.0]];
const B: [f64; 3] = [33_120.0, 33_271.0, 32_366.0];
const RATE: f64 = 1000.0;

fn calibration() -> AnyCalibration {
    let none = Estimate::new(Vec::new(), Vec::new()).expect("an estimate of nothing");
    let mut file = CalibrationFile::new("full", Unit::Count, K, B, none);
    file.device.serial = Some("0042".into());
    file.into()
}

/// A recording of counts of these accelerations, with a label that has to go through.
fn recording(n: usize, a: impl Fn(f64) -> [f64; 3]) -> String {
    let model = SensorModel::<f64>::new(Matrix3(K), B).expect("a model");
    let mut text = String::from("t_s,x_count,y_count,z_count,row\n");
    for i in 0..n {
        let t = i as f64 / RATE;
        let [x, y, z] = model.invert(a(t));
        let _ = writeln!(text, "{t},{x:?},{y:?},{z:?},{i}");
    }
    text
}

fn job() -> ApplyJob {
    let mut job = ApplyJob::default();
    job.reading.columns = Some(vec!["x".into(), "y".into(), "z".into()]);
    job
}

fn ask(
    job: &ApplyJob,
    text: &str,
    bias: Option<&TrackedBias>,
) -> Result<(ApplyOutcome, String), Trouble> {
    let calibration = calibration();
    let mut written = Vec::new();
    let source = Source::from_bytes("raw.csv", text)?;
    let mut data = ApplyData::new(&calibration, source, Destination::Bytes(&mut written));
    if let Some(bias) = bias {
        data = data.with_bias(bias);
    }
    let outcome = job.evaluate(&data, &Unwatched)?;
    drop(data);
    Ok((outcome, String::from_utf8(written).expect("text")))
}

/// t, x, y, z, row of every row.
fn rows(text: &str) -> Vec<[f64; 5]> {
    let row = |line: &str| {
        let mut cells = line.split(',').map(|c| c.parse().expect("a number"));
        std::array::from_fn(|_| cells.next().expect("five cells"))
    };
    text.lines().skip(1).map(row).collect()
}

fn wave(t: f64) -> [f64; 3] {
    [
        2.0 * (TAU * 7.0 * t).sin(),
        0.5 + (TAU * 31.0 * t).cos(),
        9.8 + 0.3 * (TAU * 180.0 * t).sin(),
    ]
}

/// What is asked for nowhere changes no byte, and is not told.
#[test]
fn law_no_steps_are_the_calibration_alone() {
    let text = recording(50, wave);
    let (plain, written) = ask(&job(), &text, None).expect("a recording");
    assert!(plain.chain().is_none() && plain.findings().is_empty());
    let model = SensorModel::<f64>::new(Matrix3(K), B).expect("a model");
    for (row, line) in rows(&written).iter().zip(text.lines().skip(1)) {
        let mut cells = line.split(',').map(|c| c.parse::<f64>().expect("a number"));
        let _ = cells.next();
        let counts = std::array::from_fn(|_| cells.next().expect("a count"));
        assert_eq!(row[1..4], model.apply(counts));
    }
    assert_eq!(
        serde_json::to_value(job()).expect("a request").get("chain"),
        None
    );
}

/// Every step is the function of the chip: the same bits, over blocks and rows.
#[test]
fn crosscheck_steps_are_those_of_the_chip_to_the_last_bit() {
    let n = 90_000;
    let text = recording(n, wave);
    let angles = [0.1, -0.2, 2.5];
    let mut job = job();
    job.chain.rotation = Some(Rotation {
        angles,
        uncertainty: [0.0; 3],
        covariance: None,
    });
    job.chain.low_pass = Some(LowPass::new(4.0));
    job.chain.decimation = Some(7);
    let (outcome, written) = ask(&job, &text, None).expect("a recording");
    let sensor = SensorModel::<f64>::new(Matrix3(K), B).expect("a model");
    let compensation = Compensation::new(sensor, None, None, 0.0).expect("a compensation");
    let [roll, pitch, yaw] = angles;
    let turn: Matrix3<f64> = TaitBryan::new(roll, pitch, yaw).expect("angles").matrix();
    let low_pass = Butterworth::<f64>::new(4.0, RATE).expect("a low-pass");
    let decimator = Decimator::<f64, 3>::new(low_pass, 7).expect("a decimator");
    let wait = low_pass.settling(1e-3) as u32;
    let late = low_pass.group_delay().round() as usize;
    let mut state = None;
    let mut expected = Vec::new();
    for (i, line) in text.lines().skip(1).enumerate() {
        let mut cells = line.split(',').map(|c| c.parse::<f64>().expect("a number"));
        let _ = cells.next();
        let counts = std::array::from_fn(|_| cells.next().expect("a count"));
        let a = turn.times(compensation.apply(counts, 0.0));
        let state = state.get_or_insert(DecimatorState::at(a, wait));
        if let Some(a) = decimator.step(state, a) {
            expected.push((i - late, a));
        }
    }
    let written = rows(&written);
    assert_eq!(written.len(), expected.len());
    for (row, (i, a)) in written.iter().zip(&expected) {
        assert_eq!((row[4], row[0]), (*i as f64, *i as f64 / RATE));
        assert_eq!(row[1..4], *a, "row {i}");
    }
    let chain = outcome.chain().expect("steps");
    assert_eq!(chain.rate, Some(RATE / 7.0));
    // Half of a sample is the most that whole samples leave.
    assert!(chain.delay_left.abs() <= 0.5 / RATE + 1e-12);
    assert!((chain.delay * RATE - low_pass.group_delay()).abs() < 1e-9);
    assert!(outcome.findings().is_empty(), "{:?}", outcome.findings());
}

/// A matrix that holds the rotation gives what the rotation behind the matrix gives.
#[test]
fn law_rotation_commutes_into_the_matrix() {
    let AnyCalibration::Constant(file) = calibration() else {
        panic!("a calibration of three axes");
    };
    let rotation = Rotation {
        angles: [0.4, 1.2, -2.0],
        uncertainty: [0.0; 3],
        covariance: None,
    };
    let turn = rotation.matrix().expect("a matrix");
    let turned = file.turned(&turn).expect("a calibration");
    let folded = turned.compensation().expect("a compensation");
    let folded = *folded.three_axes().expect("three axes");
    let own = SensorModel::<f64>::new(Matrix3(K), B).expect("a model");
    for i in 0..100 {
        let a = wave(0.013 * f64::from(i));
        let outputs = own.invert(a);
        let (one, two) = (folded.apply(outputs, 0.0), turn.times(own.apply(outputs)));
        // Sixteen roundings relative to the largest number in the sums, as in the self-check of an export, for either.
        let size = outputs.iter().chain(&B).map(|v| v * v).sum::<f64>().sqrt();
        let bound = 32.0 * f64::EPSILON * size * own.k_inverse().norm();
        for axis in 0..3 {
            assert!((one[axis] - two[axis]).abs() < bound);
        }
    }
}

/// A vector that is known in the machine comes out as it is there, whatever the sensor sits like.
#[test]
fn known_vector_in_the_frame_of_the_machine() {
    let angles = [10f64, -35.0, 120.0].map(f64::to_radians);
    let turn: Matrix3<f64> = TaitBryan::new(angles[0], angles[1], angles[2])
        .expect("angles")
        .matrix();
    let truth = [1.5, -0.25, 9.80665];
    let text = recording(20, |_| turn.transpose().times(truth));
    let mut job = job();
    job.chain.rotation = Some(Rotation {
        angles,
        uncertainty: [0.5f64, 0.5, 1.0].map(f64::to_radians),
        covariance: None,
    });
    let (outcome, written) = ask(&job, &text, None).expect("a recording");
    for row in rows(&written) {
        for axis in 0..3 {
            // Counts are written to their last digit: a few roundings of 40 000 counts over 400.
            assert!((row[axis + 1] - truth[axis]).abs() < 1e-12);
        }
    }
    // The yaw alone moves by 1°; roll beside it, by −sin(pitch) of it, adds to that: between the one and both together.
    let quantities = outcome.quantities();
    let stated = quantities.iter().find(|q| q.name == "rotation_error");
    let u = stated.expect("an uncertainty").expanded / 1.96;
    let degree = 1f64.to_radians();
    assert!(u > degree && u < 1.25f64.sqrt() * degree, "{u}");
}

/// Amplitude and phase of a tone behind the Butterworth low-pass, whose delay is taken out by whole samples.
#[test]
fn known_tone_behind_the_low_pass_of_the_chip() {
    let (frequency, corner) = (5.0, 20.0);
    let text = recording(6000, |t| [(TAU * frequency * t).sin(), 0.0, 9.8]);
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(corner));
    let (outcome, written) = ask(&job, &text, None).expect("a recording");
    let left = outcome.chain().expect("steps").delay_left;
    let (mut sine, mut cosine, mut count) = (0.0, 0.0, 0.0);
    let whole = rows(&written);
    // Whole periods: 200 samples each.
    for row in &whole[..whole.len() / 200 * 200] {
        sine += row[1] * (TAU * frequency * row[0]).sin();
        cosine += row[1] * (TAU * frequency * row[0]).cos();
        count += 0.5;
        assert!((row[3] - 9.8).abs() < 1e-10);
    }
    let (amplitude, phase) = (sine.hypot(cosine) / count, cosine.atan2(sine));
    let gain = 1.0 / (1.0 + (frequency / corner).powi(4)).sqrt();
    // The bilinear transform bends 5 Hz against 20 Hz by (π 20/1000)²/3 of the ratio; the transient left is below 1e-3 at first.
    assert!((amplitude - gain).abs() < 2e-4, "{amplitude} {gain}");
    // Phase of an analogue Butterworth less that of its delay at zero frequency: atan(√2 x/(1 − x²)) = √2 x (1 + x²/3 …).
    let x = frequency / corner;
    let bent = (std::f64::consts::SQRT_2 * x / (1.0 - x * x)).atan() - std::f64::consts::SQRT_2 * x;
    let expected = -(bent + TAU * frequency * left);
    assert!((phase - expected).abs() < 2e-3, "{phase} {expected}");
}

/// A low-pass of linear phase leaves a tone where it was, with its amplitude within the stated ripple; a tone that would fold to it is gone.
#[test]
fn known_decimated_recording_without_alias() {
    let (kept, folding) = (13.0, 87.0);
    let record = |a: f64, b: f64| {
        recording(9000, move |t| {
            let (a, b) = (a * (TAU * kept * t).sin(), b * (TAU * folding * t).sin());
            [a + b, 0.0, 9.8]
        })
    };
    let mut job = job();
    let mut low_pass = LowPass::new(25.0);
    low_pass.form = LowPassForm::LinearPhase;
    job.chain.low_pass = Some(low_pass);
    job.chain.decimation = Some(10);
    let (outcome, written) = ask(&job, &record(1.0, 0.0), None).expect("a recording");
    let chain = outcome.chain().expect("steps");
    let (ripple, folded) = (
        chain.ripple.expect("a ripple"),
        chain.folded.expect("a gain"),
    );
    assert!(ripple <= 1e-3 && folded <= 1e-3 && chain.delay_left == 0.0);
    assert!(outcome.findings().is_empty());
    let written = rows(&written);
    // 9000 samples less the length of the response, every tenth.
    let length = 2.0 * chain.delay * RATE;
    assert_eq!(written.len(), ((9000.0 - length) / 10.0).ceil() as usize);
    for row in &written {
        let truth = (TAU * kept * row[0]).sin();
        assert!((row[1] - truth).abs() <= ripple + 1e-9, "{row:?}");
        assert!((row[3] - 9.8).abs() < 1e-10 && row[4] == (row[0] * RATE).round());
    }
    for pair in written.windows(2) {
        assert_eq!(pair[1][4] - pair[0][4], 10.0);
    }
    // 87 Hz lies 13 Hz below the new rate of 100 Hz.
    let (_, written) = ask(&job, &record(0.0, 1.0), None).expect("a recording");
    for row in rows(&written) {
        assert!(row[1].abs() <= folded + 1e-9, "{row:?}");
    }
}

/// What a Butterworth low-pass does not keep out is told; where it does, nothing is.
#[test]
fn known_alias_not_suppressed_is_told() {
    let text = recording(9000, wave);
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(20.0));
    job.chain.decimation = Some(10);
    let (outcome, _) = ask(&job, &text, None).expect("a recording");
    let found = &outcome.findings()[0];
    assert_eq!(found.code(), "alias-not-suppressed");
    // 80 Hz folds to 20 Hz: (80/20)² is 24 dB, and a little more by the bent frequencies.
    assert!(found.to_string().contains("24.") || found.what().contains("24."));
    job.chain.attenuation = 20.0;
    let (outcome, _) = ask(&job, &text, None).expect("a recording");
    assert!(outcome.findings().is_empty());
    job.chain.low_pass = Some(LowPass::new(45.0));
    let (outcome, _) = ask(&job, &text, None).expect("a recording");
    assert_eq!(outcome.findings()[0].code(), "alias-not-suppressed");
}

/// A gap begins the low-pass anew, and no value is computed across it.
#[test]
fn law_a_gap_begins_the_low_pass_anew() {
    let whole = recording(3000, |_| [1.0, 2.0, 9.8]);
    let mut lines: Vec<&str> = whole.lines().collect();
    lines.drain(1201..1401);
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(20.0));
    job.chain.decimation = Some(3);
    job.chain.attenuation = 20.0;
    let (outcome, written) = ask(&job, &lines.join("\n"), None).expect("a recording");
    assert!(
        outcome
            .findings()
            .iter()
            .any(|f| f.code() == "gaps-in-record"),
        "{:?}",
        outcome.findings()
    );
    let low_pass = Butterworth::<f64>::new(20.0, RATE).expect("a low-pass");
    let late = low_pass.group_delay().round();
    let before = low_pass.settling(1e-3) - late;
    let written = rows(&written);
    for row in &written {
        let stretch = if row[4] < 1200.0 {
            [0.0, 1200.0]
        } else {
            [1400.0, 3000.0]
        };
        assert!(
            row[4] >= stretch[0] + before && row[4] < stretch[1] - late,
            "{row:?}"
        );
        assert!((row[1] - 1.0).abs() < 1e-9);
    }
    assert!(written.iter().any(|r| r[4] == 1400.0 + before));
}

/// A bias that moves from x = 20 to 60 mm/s², tracked over half a minute of rest with z up.
fn tracked(start: f64, serial: Option<&str>) -> Vec<u8> {
    let n = 3000;
    let time: Vec<f64> = (0..n).map(|i| start + f64::from(i) / 100.0).collect();
    let noise = |i: i32, k: f64| 1e-3 * (k * f64::from(i)).sin();
    let column = |of: &dyn Fn(i32) -> f64| (0..n).map(of).collect::<Vec<f64>>();
    let x = column(&|i| 0.02 + 0.04 * f64::from(i) / 3000.0 + noise(i, 7.1));
    let y = column(&|i| noise(i, 3.3));
    let z = column(&|i| 9.80665 - 0.01 + noise(i, 5.7));
    let data = BiasData {
        outputs: [&x, &y, &z],
        time: &time,
        rate: 100.0,
        breaks: &[],
        segments: None,
        findings: &[],
        name: "at rest",
    };
    let noise = AxisNoise::walk(2e-4, 5e-3);
    let mut job = BiasJob::new([noise.clone(), noise.clone(), noise]);
    job.gravity = Some(Gravity::given(9.80665, 1e-5).expect("gravity"));
    job.up = Some([0.0, 0.0, 1.0]);
    let outcome = job.evaluate(&data, &Unwatched).expect("a track");
    let mut record = Record::default();
    record.device.serial = serial.map(str::to_owned);
    let result = StoredResult::new(record, &outcome).expect("a result");
    result.to_json().expect("JSON")
}

fn track(bytes: Vec<u8>) -> Result<TrackedBias, Trouble> {
    TrackedBias::read(Source::from_bytes("bias/result.json", bytes)?).map(|(track, _)| track)
}

/// The bias that was tracked is gone afterwards, before the axes are turned.
#[test]
fn known_bias_is_subtracted_along_the_axes_of_the_sensor() {
    let track = track(tracked(0.0, Some("0042"))).expect("a track");
    let moving = |t: f64| [0.02 + 0.04 * t / 30.0, 0.0, -0.01];
    let truth = |t: f64| [(TAU * 3.0 * t).sin(), 1.0, 9.8];
    let text = recording(29_000, |t| {
        let (a, b) = (truth(t), moving(t));
        std::array::from_fn(|i| a[i] + b[i])
    });
    let (outcome, written) = ask(&job(), &text, Some(&track)).expect("a recording");
    let chain = outcome.chain().expect("steps");
    let u = chain.bias_uncertainty.expect("an uncertainty");
    assert!(u > 0.0 && u < 0.01, "{u}");
    for row in rows(&written) {
        let expected = truth(row[0]);
        for axis in 0..3 {
            // A straight line is what the smoother is surest of; four standard uncertainties.
            assert!(
                (row[axis + 1] - expected[axis]).abs() < 4.0 * u,
                "{row:?} {u}"
            );
        }
    }
    // Turned by a quarter about z, x of the sensor is y of the machine: so is its bias.
    let mut turned = job();
    turned.chain.rotation = Some(Rotation {
        angles: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
        uncertainty: [0.0; 3],
        covariance: None,
    });
    let (_, after) = ask(&turned, &text, Some(&track)).expect("a recording");
    for (row, before) in rows(&after).iter().zip(rows(&written)) {
        assert!((row[2] - before[1]).abs() < 1e-12 && (row[1] + before[2]).abs() < 1e-12);
    }
    let said = chain.steps.join(" / ");
    assert!(said.contains("bias/result.json"), "{said}");
}

/// Times that lie far from zero count from the first stamp in both.
#[test]
fn law_times_of_a_track_count_as_those_of_the_recording() {
    let track = track(tracked(0.0, None)).expect("a track");
    let near = recording(2000, wave);
    let far: String = near
        .lines()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("{line}\n"),
            _ => {
                let (_, rest) = line.split_once(',').expect("a time");
                format!("{:.3},{rest}\n", 1.7e9 + (i - 1) as f64 / RATE)
            }
        })
        .collect();
    let (_, a) = ask(&job(), &near, Some(&track)).expect("a recording");
    let (_, b) = ask(&job(), &far, Some(&track)).expect("a recording");
    for (a, b) in rows(&a).iter().zip(rows(&b)) {
        // Stamps of 1.7e9 s hold a quarter of a microsecond.
        assert!((a[1] - b[1]).abs() < 1e-8 && a[4] == b[4]);
    }
    // A stretch of the recording is corrected as it is within the whole.
    for stamped in [true, false] {
        let mut part = job();
        if !stamped {
            part.reading.rate = Some(RATE);
            part.reading.time = None;
        }
        let text = match stamped {
            true => far.clone(),
            false => near.replace("t_s,", "other,"),
        };
        part.reading.between = Some(vec![0.5, 1.0]);
        let (_, c) = ask(&part, &text, Some(&track)).expect("a recording");
        let (c, a) = (rows(&c), rows(&a));
        assert!(c.len().abs_diff(500) < 2);
        for row in c {
            let whole = a[row[4] as usize];
            assert!((row[1] - whole[1]).abs() < 1e-6, "{row:?} {whole:?}");
        }
    }
}

/// What, where and what to do.
fn told(trouble: &Trouble) -> String {
    let hint = trouble.hint().unwrap_or_default();
    format!("{trouble} {} {hint}", trouble.place().join(" "))
}

#[test]
fn refuses_a_bias_that_does_not_belong_to_the_recording() {
    let text = recording(2000, wave);
    let refused = |bytes: Vec<u8>| {
        let found = track(bytes).and_then(|t| ask(&job(), &text, Some(&t)).map(|_| ()));
        told(&found.expect_err("a refusal"))
    };
    // Tracked from 1 s on: the recording begins before, at line 2.
    let late = refused(tracked(1.0, None));
    assert!(
        late.contains("from 1 s") && late.contains("raw.csv:2"),
        "{late}"
    );
    let other = refused(tracked(0.0, Some("0043")));
    assert!(other.contains("0043") && other.contains("0042"), "{other}");
    let none = refused(b"{}".to_vec());
    assert!(none.contains("no result of `proofmass bias`"), "{none}");
    let two = refused(calibration().to_json().expect("JSON"));
    assert!(two.contains("is a calibration"), "{two}");
    let mut damaged: serde_json::Value = serde_json::from_slice(&tracked(0.0, None)).expect("JSON");
    damaged["extra"]["bias_filter"]["rate"] = serde_json::json!("fast");
    let damaged = refused(serde_json::to_vec(&damaged).expect("JSON"));
    assert!(damaged.contains("damaged"), "{damaged}");
}

#[test]
fn refuses_steps_that_cannot_be_taken() {
    let text = recording(2000, wave);
    let refused = |change: &dyn Fn(&mut ApplyJob), words: &[&str]| {
        let mut job = job();
        change(&mut job);
        let said = match ask(&job, &text, None) {
            Err(trouble) => told(&trouble),
            Ok(_) => panic!("{words:?} was not refused"),
        };
        for word in words {
            assert!(said.contains(word), "{word}: {said}");
        }
    };
    let rotation = |angles, uncertainty| {
        Some(Rotation {
            angles,
            uncertainty,
            covariance: None,
        })
    };
    refused(
        &|j| j.chain.rotation = rotation([0.0, f64::NAN, 0.0], [0.0; 3]),
        &["angles of a rotation", "roll, pitch and yaw"],
    );
    refused(
        &|j| j.chain.rotation = rotation([90.0, 0.0, 0.0], [0.0; 3]),
        &["angle of the rotation is 5156.6", "more than a turn"],
    );
    refused(
        &|j| j.chain.rotation = rotation([0.0; 3], [0.0, -1.0, 0.0]),
        &["standard uncertainty of an angle of the rotation cannot be -57.29"],
    );
    refused(
        &|j| j.chain.rotation = rotation([0.0; 3], [0.0, 0.0, 1.6]),
        &["cannot be 91.6", "from 0° to 30°"],
    );
    for factor in [0, 1] {
        refused(
            &|j| {
                j.chain.low_pass = Some(LowPass::new(10.0));
                j.chain.decimation = Some(factor);
            },
            &["decimation", "whole number from 2 on"],
        );
    }
    refused(
        &|j| j.chain.decimation = Some(4),
        &["needs a low-pass", "--low-pass HZ"],
    );
    for corner in [f64::NAN, 0.0, -1.0] {
        refused(
            &|j| j.chain.low_pass = Some(LowPass::new(corner)),
            &["corner of a low-pass cannot be"],
        );
    }
    for form in [LowPassForm::Butterworth, LowPassForm::LinearPhase] {
        let low_pass = |corner| {
            let mut low_pass = LowPass::new(corner);
            low_pass.form = form;
            Some(low_pass)
        };
        refused(
            &|j| j.chain.low_pass = low_pass(600.0),
            &["not below half of the sampling rate, 500", "raw.csv"],
        );
    }
    for form in [LowPassForm::Butterworth, LowPassForm::LinearPhase] {
        refused(
            &|j| {
                let mut low_pass = LowPass::new(60.0);
                low_pass.form = form;
                j.chain.low_pass = Some(low_pass);
                j.chain.decimation = Some(10);
            },
            &["leaves 100.000000 Hz", "lower the corner"],
        );
    }
    refused(
        &|j| {
            j.chain.low_pass = Some(LowPass::new(10.0));
            j.chain.attenuation = 5.0;
        },
        &["attenuation of 5 dB"],
    );
    // Longer to settle than the recording is.
    refused(
        &|j| j.chain.low_pass = Some(LowPass::new(0.2)),
        &["nothing is left of the recording"],
    );
    // A rate that nobody states.
    let untimed = text.replace("t_s,", "other,");
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(10.0));
    let said = ask(&job, &untimed, None).expect_err("a refusal");
    assert!(said.to_string().contains("sampling rate"), "{said}");
    // One axis has no frame.
    let none = Estimate::new(Vec::new(), Vec::new()).expect("an estimate");
    let one: AnyCalibration = CalibrationFile::new("one", Unit::Volt, [[2.0]], [0.0], none).into();
    let mut job = ApplyJob::default();
    job.reading.columns = Some(vec!["u".into()]);
    job.chain.rotation = rotation([0.1, 0.0, 0.0], [0.0; 3]);
    let mut written = Vec::new();
    let source = Source::from_bytes("one.csv", "u_V\n0.1\n").expect("a source");
    let data = ApplyData::new(&one, source, Destination::Bytes(&mut written));
    let said = job.evaluate(&data, &Unwatched).expect_err("a refusal");
    drop(data);
    assert!(said.to_string().contains("three axes"), "{said}");
    assert!(written.is_empty());
}

/// The steps stand in the result, on its page and in the JSON of it.
#[test]
fn law_steps_are_told_in_the_result() {
    let text = recording(6000, wave);
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(4.0));
    job.chain.decimation = Some(5);
    let (outcome, _) = ask(&job, &text, None).expect("a recording");
    let result = StoredResult::new(Record::default(), &outcome).expect("a result");
    let chain = result.section("chain").expect("a section");
    let steps = chain["steps"].as_array().expect("steps");
    assert_eq!(steps.len(), 3, "{steps:?}");
    assert!(chain["delay_s"].as_f64().expect("a delay") > 0.05);
    let page = result.html().expect("a page");
    assert!(page.contains("one of 5 samples kept") && page.contains("delay of all steps"));
    let asked = serde_json::to_string(&job).expect("JSON");
    let back: ApplyJob = serde_json::from_str(&asked).expect("a request");
    assert_eq!(back, job);
}

/// A filter works at one rate: where the rate drifts away, that is told, and an even clock raises nothing.
#[test]
fn law_a_rate_that_changes_is_told_where_a_low_pass_runs() {
    let even = recording(3000, wave);
    // The same rows at a rate that falls from some 500 Hz to 280 Hz.
    let bent: Vec<String> = even
        .lines()
        .enumerate()
        .map(|(i, line)| match line.split_once(',') {
            Some((t, rest)) if i > 0 => {
                let t: f64 = t.parse().expect("a time");
                format!("{},{rest}", 0.1 * (10.0 * t).powf(1.3))
            }
            _ => line.to_owned(),
        })
        .collect();
    let mut job = job();
    job.chain.low_pass = Some(LowPass::new(10.0));
    let told = |text: &str| {
        let (outcome, _) = ask(&job, text, None).expect("a recording");
        let mut codes = outcome.findings().iter().map(|f| f.code());
        codes.any(|code| code == "rate-changes")
    };
    assert!(told(&bent.join("\n")));
    assert!(!told(&even));
}
