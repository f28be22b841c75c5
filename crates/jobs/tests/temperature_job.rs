//! The temperature job from memory: evaluated, filed, read again, cancelled.

use proofmass_io::Unit;
use proofmass_jobs::temperature::{EnvironmentalColumn, TemperatureData, TemperatureJob};
use proofmass_jobs::{Job, Record, StoredResult, TroubleKind, Unwatched, Watch};
use std::ops::ControlFlow;

struct Sweep {
    outputs: [Vec<f64>; 3],
    temperature: Vec<f64>,
}

/// 0 … 40 °C in 3000 samples, x by 0.5 mg/K, small deterministic noise.
fn sweep() -> Sweep {
    let t: Vec<f64> = (0..3000).map(|i| f64::from(i) / 75.0).collect();
    let noise =
        |i: usize, k: usize| ((i * (7919 + 104 * k) % 10_007) as f64 / 10_007.0 - 0.5) * 4e-3;
    let column = |k: usize, level: f64, slope: f64| -> Vec<f64> {
        t.iter()
            .enumerate()
            .map(|(i, t)| level + slope * t + noise(i, k))
            .collect()
    };
    Sweep {
        outputs: [
            column(0, 0.01, 5e-4),
            column(1, 0.0, 0.0),
            column(2, 1.0, 0.0),
        ],
        temperature: t,
    }
}

fn data(sweep: &Sweep) -> TemperatureData<'_> {
    let [x, y, z] = &sweep.outputs;
    TemperatureData {
        outputs: vec![x, y, z],
        unit: Unit::StandardGravity,
        temperature: &sweep.temperature,
        environment: &[],
        rate: 10.0,
        calibration: None,
        findings: &[],
        name: "memory",
    }
}

#[test]
fn law_filed_read_and_rendered_again_alike() {
    let sweep = sweep();
    let outcome = TemperatureJob::default()
        .evaluate(&data(&sweep), &Unwatched)
        .unwrap();
    let slope = outcome.fit().estimate.get("slope.x").unwrap();
    assert!((slope.value / 9.80665e-3 - 0.5).abs() < 5e-3);
    let filed = StoredResult::new(Record::default(), &outcome).unwrap();
    let back = StoredResult::from_json(&filed.to_json().unwrap()).unwrap();
    assert_eq!(back.files().unwrap(), filed.files().unwrap());
}

#[test]
fn law_a_watcher_stops_it() {
    struct Stop;
    impl Watch for Stop {
        fn progress(&self, _: &'static str, _: u64, _: u64) -> ControlFlow<()> {
            ControlFlow::Break(())
        }
    }
    let sweep = sweep();
    let trouble = TemperatureJob::default()
        .evaluate(&data(&sweep), &Stop)
        .unwrap_err();
    assert_eq!(trouble.kind(), TroubleKind::Cancelled);
}

#[test]
fn refuses_units_that_are_no_acceleration_without_a_calibration() {
    let sweep = sweep();
    let mut data = data(&sweep);
    data.unit = Unit::Count;
    let trouble = TemperatureJob::default()
        .evaluate(&data, &Unwatched)
        .unwrap_err();
    assert!(trouble.to_string().contains("count") && trouble.hint().is_some());
}

/// A humidity that falls as the temperature rises, one that does not change, one that is named like a power of the temperature.
#[test]
fn refuses_surroundings_that_cannot_be_told() {
    let sweep = sweep();
    let with = |columns: &[EnvironmentalColumn]| {
        let mut data = data(&sweep);
        data.environment = columns;
        TemperatureJob::default().evaluate(&data, &Unwatched)
    };
    let n = sweep.temperature.len();
    let falls: Vec<f64> = sweep.temperature.iter().map(|t| 80.0 - t).collect();
    let own: Vec<f64> = (0..n)
        .map(|k| 50.0 + 10.0 * (0.013 * k as f64).sin())
        .collect();
    let humidity = |values: &[f64]| EnvironmentalColumn::new("humidity", "%", values.to_vec());
    let trouble = with(&[humidity(&falls)]).unwrap_err();
    assert!(
        trouble
            .to_string()
            .contains("does not tell humidity from the temperature"),
        "{trouble}"
    );
    assert!(trouble.hint().unwrap().contains("two humidities"));
    let trouble = with(&[humidity(&vec![50.0; n])]).unwrap_err();
    assert!(trouble.to_string().contains("does not change"), "{trouble}");
    let trouble = with(&[EnvironmentalColumn::new("T1", "V", own.clone())]).unwrap_err();
    assert!(trouble.to_string().contains("no name"), "{trouble}");
    let trouble = with(&[humidity(&own), humidity(&own)]).unwrap_err();
    assert!(trouble.to_string().contains("twice"), "{trouble}");
    let told = with(&[humidity(&own)]).unwrap();
    assert!(told.fit().estimate.get("output.x.humidity").is_some());
}
