//! How often a device with its typical noise is decided by a recording of the planned length, and of others: `-- RUNS FIRST_SEED`.

use proofmass_io::Input;
use proofmass_jobs::data_sheet::sheet;
use proofmass_jobs::device_check::{DeviceCheckData, DeviceCheckJob, DeviceResult, SheetVerdict};
use proofmass_jobs::device_plan::DevicePlanJob;
use proofmass_jobs::noise::{NoiseData, NoiseJob};
use proofmass_jobs::{Job, Record, StoredResult, Unwatched};
use proofmass_noise::{NoiseChannel, NoiseModel, Sensor, simulate};
use rand::SeedableRng;

const G: f64 = 9.80665;

/// N, B, K in µg/√Hz one-sided, µg (floor), µg/√s; which is limited, its limit over the typical value; rate.
const ROWS: [(f64, f64, f64, &str, f64, f64); 9] = [
    (145.0, 0.0, 0.0, "N", 1.5, 50.0),
    (145.0, 0.0, 0.0, "N", 1.2, 50.0),
    (145.0, 0.0, 0.0, "N", 1.1, 50.0),
    (145.0, 0.0, 0.0, "N", 1.05, 50.0),
    (145.0, 0.0, 0.0, "N", 1.03, 100.0),
    (145.0, 20.0, 0.0, "N", 1.05, 50.0),
    (145.0, 0.0, 5.0, "N", 1.1, 10.0),
    (145.0, 40.0, 0.0, "B", 1.5, 10.0),
    (145.0, 0.0, 20.0, "K", 1.5, 10.0),
];

fn main() {
    let mut words = std::env::args().skip(1);
    let mut number = |default: u64| words.next().and_then(|w| w.parse().ok()).unwrap_or(default);
    let (runs, first) = (number(60), number(1));
    println!("| N, B, K | limit | planned / s | decided, % | 1.25 × | 1.5 × | 2 × |");
    println!("|---|---|---|---|---|---|---|");
    for (n, b, k, term, over, rate) in ROWS {
        let limit = |t: &str, typical: f64, unit: &str| {
            let most = if t == term {
                over * typical
            } else {
                1e3 * typical
            };
            format!(
                "[[limit]]\nterm = \"{t}\"\nmost = {most}\ntypical = {typical}\nunit = \"{unit}\"\n"
            )
        };
        let mut text = limit("N", n, "µg/√Hz");
        if b > 0.0 {
            text += &limit("B", b, "µg");
        }
        if k > 0.0 {
            text += &limit("K", k, "µg/√s");
        }
        let mut job = DevicePlanJob::default();
        job.sheet = sheet(&text).expect("a sheet");
        job.given.rate = Some(rate);
        let outcome = job.evaluate(&(), &Unwatched).expect("a plan");
        let place = job
            .sheet
            .limit
            .iter()
            .position(|l| l.term.as_deref() == Some(term));
        let place = place.expect("the limit");
        let Some(planned) = outcome.limits()[place].duration else {
            println!("| {n}, {b}, {k} | {term} {over} | out of reach |");
            continue;
        };
        let model = NoiseModel {
            white: n * 1e-6 * G / std::f64::consts::SQRT_2,
            flicker: b * 1e-6 * G / (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt(),
            random_walk: k * 1e-6 * G,
            ..NoiseModel::default()
        };
        print!("| {n}, {b}, {k} | {term} {over} | {planned} |");
        for factor in [1.0, 1.25, 1.5, 2.0] {
            let decided = (first..first + runs).filter(|seed| {
                let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(*seed);
                let samples = (rate * planned * factor) as usize;
                let data = simulate(&model, samples, rate, &mut rng).expect("noise");
                let channel = NoiseChannel {
                    name: "acc",
                    sensor: Some(Sensor::Accelerometer),
                    unit: "m/s²",
                    rate: &data,
                };
                let data = NoiseData::samples(vec![channel], rate);
                let outcome = NoiseJob::default()
                    .evaluate(&data, &Unwatched)
                    .expect("an analysis");
                let bytes =
                    StoredResult::new(Record::default(), &outcome).and_then(|r| r.to_json());
                let result = DeviceResult::from_json(
                    "unit",
                    "unit/result.json",
                    &bytes.expect("JSON"),
                    Input::default(),
                );
                let results = [result.expect("a result")];
                let mut check = DeviceCheckJob::default();
                check.sheet = job.sheet.clone();
                let data = DeviceCheckData { results: &results };
                let outcome = check.evaluate(&data, &Unwatched).expect("a verdict");
                let mut rows = outcome.devices()[0].limits.iter();
                rows.any(|row| row.limit == place && row.verdict == SheetVerdict::Pass)
            });
            print!(" {:.0} |", 100.0 * decided.count() as f64 / runs as f64);
        }
        println!();
    }
}
