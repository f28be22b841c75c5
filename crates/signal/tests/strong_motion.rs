//! An earthquake record with published velocity, intensity and response spectrum.

use proofmass_signal::{Baseline, Extremes, Peaks, Response, ShockSpectrum, StrongMotion};
use std::path::PathBuf;

fn column(name: &str, skip: usize, index: usize) -> Vec<f64> {
    let folder = std::env::var_os("PROOFMASS_REFERENCE_DATA").expect("PROOFMASS_REFERENCE_DATA");
    let path = PathBuf::from(folder).join("strong-motion").join(name);
    let text = std::fs::read_to_string(path).expect("the recording");
    text.lines()
        .skip(skip)
        .map(|l| {
            l.split(',')
                .nth(index)
                .expect("a field")
                .trim()
                .parse()
                .expect("a number")
        })
        .collect()
}

/// Gravity with which the source turned its record into g: 1.25 m/s² printed beside 0.12742 g.
const GRAVITY: f64 = 9.81;

fn record() -> Vec<f64> {
    column("test_motion_dt0p01.txt", 2, 0)
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_intensity_and_velocity() {
    let record = record();
    let figures = StrongMotion::of(&record, 100.0, GRAVITY).unwrap();
    assert!(
        (figures.arias_intensity - 0.63398).abs() < 5e-6,
        "{figures:?}"
    );
    assert!(
        (figures.cumulative_absolute_velocity - 8.53872).abs() < 5e-6,
        "{figures:?}"
    );
    let velocity = column("test_motion_avd.csv", 1, 2);
    let motion = Baseline::None.integrate(&record, 100.0).unwrap();
    for (ours, theirs) in motion.velocity.iter().zip(&velocity) {
        // The printed record is rounded to 1e-6 g at its peak: 4684 roundings of 1e-7 m/s.
        assert!((ours - theirs).abs() < 5e-5);
    }
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_response_spectrum() {
    let period = column("test_motion_true_spectra_acc.csv", 1, 0);
    let theirs = column("test_motion_true_spectra_acc.csv", 1, 1);
    let spectrum = ShockSpectrum {
        damping: 0.05,
        response: Response::PseudoAcceleration,
        peaks: Peaks::BetweenSamples,
        ..ShockSpectrum::new(period.iter().map(|t| 1.0 / t).collect(), 10.0)
    };
    let ours = spectrum.evaluate(&record(), 100.0).unwrap();
    let mut departures: Vec<f64> = ours
        .curve(Extremes::recorded_maximax)
        .iter()
        .zip(&theirs)
        .map(|(a, b)| (a / GRAVITY / b - 1.0).abs())
        .collect();
    departures.sort_by(f64::total_cmp);
    // Two references of this record, from two programs, differ by as much.
    assert!(departures[departures.len() / 2] < 2e-3, "{departures:?}");
    assert!(departures[departures.len() - 1] < 0.05, "{departures:?}");
}
