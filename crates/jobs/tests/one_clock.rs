//! One recording, one sampling rate, whoever reads it.

use proofmass_documents::CalibrationFile;
use proofmass_io::{RecordingOptions, Source, Unit, inspect_source};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::noise::{NoiseReading, NoiseSamples};
use proofmass_jobs::validation::ValidationRecording;
use proofmass_jobs::velocity::AxisSensors;
use proofmass_jobs::{Memory, RecordingReading, Unwatched};
use proofmass_uncertainty::Estimate;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::fmt::Write;

const ROWS: usize = 20_000;

/// A recording of three accelerations and a position at the stamps, s.
fn recording(stamps: &[f64], decimals: usize) -> String {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut text = "t_s,x_m/s2,y_m/s2,z_m/s2,position (m)\n".to_owned();
    for t in stamps {
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let [x, y, z, p] = [noise(), noise(), 9.8 + noise(), 0.01 * noise()];
        writeln!(text, "{t:.decimals$},{x:.4},{y:.4},{z:.4},{p:.6}").unwrap();
    }
    text
}

fn source(text: &str) -> Source {
    Source::from_bytes("r.csv", text.to_owned()).unwrap()
}

fn inspected(text: &str) -> f64 {
    inspect_source(source(text), &RecordingOptions::default(), 10)
        .unwrap()
        .time
        .unwrap()
        .rate_hz
}

fn noise(text: &str) -> f64 {
    let recording = NoiseReading::default().read(source(text)).unwrap();
    match recording.data().samples {
        NoiseSamples::Slices { rate, .. } => rate.unwrap(),
        _ => unreachable!("a recording in memory"),
    }
}

fn noise_as_a_stream(text: &str) -> f64 {
    let mut stream = NoiseReading::default().stream(source(text)).unwrap();
    match stream.data().samples {
        NoiseSamples::Stream { blocks, .. } => {
            let blocks = blocks.into_inner().unwrap();
            while blocks.next_block().unwrap().is_some() {}
            blocks.rate().unwrap()
        }
        _ => unreachable!("a stream"),
    }
}

fn calibrated(text: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.csv"), text).unwrap();
    let path = folder.path().join("campaign.toml");
    let campaign = "kind = \"multi-position\"\n[recording]\nfile = \"r.csv\"\ncolumns = { x = \"x\", y = \"y\", z = \"z\" }\n\
                    [gravity]\nvalue = 9.80665\nstandard_uncertainty = 1e-5\n";
    std::fs::write(&path, campaign).unwrap();
    match Campaign::open(&path).unwrap() {
        Campaign::MultiPosition(campaign) => campaign.load(&Unwatched).unwrap().data().rate,
        _ => unreachable!("another kind"),
    }
}

fn calibration() -> Source {
    let k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let estimate = Estimate::new(vec![], vec![]).unwrap();
    let file = CalibrationFile::new("full", Unit::MetrePerSecondSquared, k, [0.0; 3], estimate);
    Source::from_bytes("c.json", file.to_json().unwrap()).unwrap()
}

fn reading() -> RecordingReading {
    let mut reading = RecordingReading::default();
    reading.columns = Some(vec!["x".into(), "y".into(), "z".into()]);
    reading
}

fn validated(text: &str) -> f64 {
    let read = ValidationRecording::read(calibration(), source(text), &reading(), None);
    read.unwrap().data().rate
}

fn validated_as_a_stream(text: &str) -> f64 {
    let read = ValidationRecording::stream(calibration(), source(text), &reading(), &Unwatched);
    read.unwrap().data().rate
}

fn velocity(text: &str) -> f64 {
    let files = Memory::new().file("r.csv", text.to_owned());
    let mut sensors = AxisSensors::default();
    sensors.recording = "r.csv".into();
    sensors.reading.position = Some(vec!["position".into()]);
    sensors.acceleration = vec!["x".into()];
    let loaded = sensors.load(&files, None, &Unwatched).unwrap();
    1.0 / loaded.data().record.sample_time
}

type Reader = (&'static str, fn(&str) -> f64);

/// Readers of every recording, and those that refuse stamps that cross.
const ALL: [Reader; 3] = [
    ("inspect", inspected),
    ("noise", noise),
    ("noise --stream", noise_as_a_stream),
];
const IN_ORDER: [Reader; 4] = [
    ("calibrate", calibrated),
    ("test", validated),
    ("test, streamed", validated_as_a_stream),
    ("velocity", velocity),
];

#[test]
fn law_every_reader_states_the_same_rate() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let even = |rate: f64| move |k: usize| k as f64 / rate;
    let all = |stamp: &dyn Fn(usize) -> f64| (0..ROWS).map(stamp).collect::<Vec<f64>>();
    let jitter: Vec<f64> = (0..ROWS).map(|_| normal()).collect();
    // One row in eleven, never two together: `velocity` takes the longest stretch without a step of three intervals.
    let there = |k: &usize| match k % 997 {
        5 => false,
        3..10 => true,
        _ => (k * 7919) % 100 >= 9,
    };
    let thinned = |rate: f64| {
        let rows = (0..ROWS).filter(there).map(even(rate));
        rows.collect::<Vec<f64>>()
    };
    let mut busy = 0.0_f64;
    let mut chance = Xoshiro256PlusPlus::seed_from_u64(4);
    let host: Vec<f64> = (0..ROWS)
        .map(|k| {
            let late: f64 = Exp1.sample(&mut chance);
            // More than three intervals between two samples of an accelerometer are a gap to `velocity`.
            busy = (k as f64 + 0.2 * late.min(7.0)).max(busy + 1e-3);
            0.01 * busy + 1e-6 * chance.random::<f64>()
        })
        .collect();
    // Rate, decimals, bound of its relative error, stamps.
    let files: [(&str, f64, usize, f64, Vec<f64>); 10] = [
        ("even, fine", 100.02, 6, 1e-9, all(&even(100.02))),
        ("800 Hz in milliseconds", 800.0, 3, 1e-6, all(&even(800.0))),
        (
            "1600 Hz in milliseconds",
            1600.0,
            3,
            1e-6,
            all(&even(1600.0)),
        ),
        ("104 Hz in milliseconds", 104.0, 3, 1e-6, all(&even(104.0))),
        ("rows lost, fine", 100.02, 6, 1e-8, thinned(100.02)),
        ("rows lost, in milliseconds", 100.0, 3, 1e-8, thinned(100.0)),
        // √12 σ/n^1.5 = 1.2e-7 is one standard uncertainty.
        (
            "jitter of 10 %",
            100.0,
            6,
            6e-7,
            all(&|k| 0.01 * (k as f64 + 0.1 * jitter[k])),
        ),
        (
            "jitter of 10 %, rows lost",
            100.0,
            6,
            6e-7,
            (0..ROWS)
                .filter(there)
                .map(|k| 0.01 * (k as f64 + 0.1 * jitter[k]))
                .collect(),
        ),
        (
            "packets of eight",
            100.0,
            6,
            1e-6,
            all(&|k| 0.01 * (k / 8 * 8 + 8) as f64),
        ),
        ("a late host", 100.0, 6, 2e-6, host),
    ];
    for (name, rate, decimals, bound, stamps) in files {
        let text = recording(&stamps, decimals);
        let stated = inspected(&text);
        assert!((stated / rate - 1.0).abs() < bound, "{name}: {stated} Hz");
        for (reader, read) in ALL.iter().chain(&IN_ORDER) {
            let read = read(&text);
            assert!(
                (read / stated - 1.0).abs() < 1e-8,
                "{name}, {reader}: {read} Hz, {stated} Hz by inspect"
            );
        }
    }
    // Stamps that cross are refused where the order of rows counts.
    let crossing = all(&|k| 0.01 * (k as f64 + 0.3 * jitter[k]));
    let text = recording(&crossing, 6);
    for (reader, read) in ALL {
        let read = read(&text);
        // One standard uncertainty is √12 · 0.3/n^1.5 = 3.7e-7.
        assert!(
            (read / 100.0 - 1.0).abs() < 1.8e-6,
            "crossing, {reader}: {read} Hz"
        );
    }
}
