//! The noise job: the outcome is read again as it was written, streams agree with memory, an onlooker may stop it.

use proofmass_core::Watch;
use proofmass_io::Source;
use proofmass_jobs::noise::{
    NoiseBlock, NoiseBlocks, NoiseData, NoiseJob, NoiseOutcome, NoiseReading,
};
use proofmass_jobs::{Job, Outcome, Record, Result, StoredResult, TroubleKind, Unwatched};
use proofmass_noise::{ChannelName, NoiseChannel, NoiseModel, Sensor, Term, simulate};
use rand::SeedableRng;
use std::ops::ControlFlow;

const RATE: f64 = 50.0;

fn samples(n: usize) -> Vec<f64> {
    let model = NoiseModel {
        white: 2.5e-3,
        random_walk: 5.0e-4,
        ..Default::default()
    };
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(11);
    simulate(&model, n, RATE, &mut rng).unwrap()
}

fn channel(rate: &[f64]) -> NoiseChannel<'_> {
    NoiseChannel {
        name: "acc_x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate,
    }
}

#[test]
fn law_an_outcome_is_read_again_as_it_was_written() {
    let mut rate = samples(20_000);
    rate[7000] = f64::NAN;
    let dead = vec![1.0; rate.len()];
    let channels = vec![
        channel(&rate),
        NoiseChannel {
            name: "dead",
            ..channel(&dead)
        },
    ];
    let outcome = NoiseJob::default()
        .evaluate(&NoiseData::samples(channels, RATE), &Unwatched)
        .unwrap();
    let record = Record {
        title: Some("Noise of a bench".to_owned()),
        ..Record::default()
    };
    let filed = StoredResult::new(record, &outcome).unwrap();
    let files = filed.files().unwrap();
    let json = &files.iter().find(|f| f.0 == "result.json").unwrap().1;
    let again = StoredResult::from_json(json).unwrap();
    assert!(
        again.files().unwrap() == files,
        "a file rendered again differs"
    );
    let names: Vec<&str> = files.iter().map(|f| f.0.as_str()).collect();
    for name in [
        "report.html",
        "coefficients.csv",
        "deviation.csv",
        "spectrum.csv",
        "imu.yaml",
    ] {
        assert!(names.contains(&name), "{name} of {names:?}");
    }
    // A request is plain data too.
    let job = NoiseJob::default();
    let text = serde_json::to_string(&job).unwrap();
    assert_eq!(serde_json::from_str::<NoiseJob>(&text).unwrap(), job);
    assert_eq!(serde_json::from_str::<NoiseJob>("{}").unwrap(), job);
}

/// Blocks of seven hundred samples.
struct Pieces {
    rate: Vec<f64>,
    next: usize,
}

impl NoiseBlocks for Pieces {
    fn next_block(&mut self) -> Result<Option<NoiseBlock>> {
        let end = (self.next + 700).min(self.rate.len());
        let piece = self.rate[self.next..end].to_vec();
        self.next = end;
        Ok((!piece.is_empty()).then_some(NoiseBlock {
            behind_gap: false,
            columns: vec![piece],
        }))
    }

    fn rate(&self) -> Option<f64> {
        Some(RATE)
    }
}

#[test]
fn known_gravity_in_another_unit_is_told() {
    let noise = samples(5_000);
    let codes = |means: [f64; 3]| -> Vec<String> {
        let axes = means.map(|m| noise.iter().map(|v| v + m).collect::<Vec<f64>>());
        let channels = axes.iter().map(|axis| channel(axis)).collect();
        let data = NoiseData::samples(channels, RATE);
        let outcome = NoiseJob::default().evaluate(&data, &Unwatched).unwrap();
        let all = outcome.findings().iter().map(|f| f.code().to_owned());
        all.filter(|c| c == "unit-suspected").collect()
    };
    // Gravity along z in g and mg; in m/s², and without it, nothing is wrong.
    assert_eq!(codes([0.02, -0.01, 1.003]), ["unit-suspected"]);
    assert_eq!(codes([20.0, -10.0, 998.0]), ["unit-suspected"]);
    assert!(codes([0.2, -0.1, 9.81]).is_empty());
    assert!(codes([0.0, 0.0, 0.0]).is_empty());
}

#[test]
fn law_a_stream_is_the_record() {
    let rate = samples(20_000);
    let whole = NoiseJob::default()
        .evaluate(&NoiseData::samples(vec![channel(&rate)], RATE), &Unwatched)
        .unwrap();
    let mut pieces = Pieces { rate, next: 0 };
    let name = ChannelName {
        name: "acc_x".into(),
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²".into(),
    };
    let streamed = NoiseJob::default()
        .evaluate(&NoiseData::stream(vec![name], &mut pieces), &Unwatched)
        .unwrap();
    let model = |o: &NoiseOutcome| o.analysis().channels[0].whittle.clone().unwrap().model;
    // Twenty thousand samples are averages of one.
    assert_eq!(model(&whole), model(&streamed));
    assert_eq!(whole.quantities(), streamed.quantities());
}

#[test]
fn law_an_onlooker_stops_it() {
    struct Impatient;
    impl Watch for Impatient {
        fn progress(&self, _: &'static str, done: u64, _: u64) -> ControlFlow<()> {
            if done < 2 {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        }
    }
    let rate = samples(5000);
    let trouble = NoiseJob::default()
        .evaluate(&NoiseData::samples(vec![channel(&rate)], RATE), &Impatient)
        .unwrap_err();
    assert_eq!(trouble.kind(), TroubleKind::Cancelled);
}

/// A text with a time column in which samples are missing: read whole or streamed, the gap is found and the rate holds.
#[test]
fn law_readings_agree_on_gaps() {
    let rate = samples(30_000);
    let mut text = String::from("time_s,acc_x_m/s2\n");
    for (k, y) in rate.iter().enumerate() {
        let lost = if k >= 12_000 { 7 } else { 0 };
        text += &format!("{:.4},{y:.12}\n", (k + lost) as f64 / RATE);
    }
    let reading = NoiseReading::default();
    let whole = reading
        .read(Source::from_bytes("rest.csv", text.clone()).unwrap())
        .unwrap();
    let mut stream = reading
        .stream(Source::from_bytes("rest.csv", text).unwrap())
        .unwrap();
    let a = NoiseJob::default()
        .evaluate(&whole.data(), &Unwatched)
        .unwrap();
    let b = NoiseJob::default()
        .evaluate(&stream.data(), &Unwatched)
        .unwrap();
    // A stream does not state yet how it was read.
    let (a_stream, in_memory) = (stream.finish().unwrap(), whole.input());
    assert_eq!(a_stream.path, in_memory.path);
    assert_eq!(a_stream.sha256, in_memory.sha256);
    for outcome in [&a, &b] {
        let analysis = outcome.analysis();
        assert!(
            (analysis.sample_rate / RATE - 1.0).abs() < 1e-6,
            "{}",
            analysis.sample_rate
        );
        assert_eq!(analysis.channels[0].samples, 30_000);
        assert!(
            outcome
                .findings()
                .iter()
                .any(|f| f.code() == "gaps-in-record")
        );
        let fit = analysis.channels[0].whittle.as_ref().unwrap();
        assert!((fit.value(Term::White).unwrap() / 2.5e-3 - 1.0).abs() < 0.03);
    }
}
