//! Required densities: the published profiles, and what a measured density says of one.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_dynamic::required_density::{DensityVerdict, RequiredDensity, RequiredPoint};
use proofmass_signal::Welch;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Overall values as the profiles are published with: 6.06, 14.1, 10.0 and 7.7 g.
#[test]
fn published_overall_values_of_the_profiles() {
    for (word, overall, digit) in [
        ("navmat-p-9492", 6.06, 0.01),
        ("gevs-qualification", 14.1, 0.05),
        ("gevs-acceptance", 10.0, 0.05),
        ("mil-std-810-minimum-integrity", 7.7, 0.05),
    ] {
        let profile = RequiredDensity::named(word).unwrap();
        assert!(profile.check().is_ok());
        let rms = profile.rms(0.0, 1e4) / STANDARD_GRAVITY;
        assert!((rms - overall).abs() < digit, "{word}: {rms}");
    }
    assert!(RequiredDensity::named("navmat").is_none());
}

#[test]
fn known_slopes_between_points() {
    let navmat = RequiredDensity::named("navmat-p-9492").unwrap();
    let at = |f: f64| navmat.at(f).map(|p| p.0 / STANDARD_GRAVITY.powi(2));
    // +3 dB to the octave, to the digits of 0.01 and 0.04.
    assert!((at(40.0).unwrap() - 0.02).abs() < 1e-12);
    assert!((at(200.0).unwrap() - 0.04).abs() < 1e-12);
    assert!((at(2000.0).unwrap() - 0.007).abs() < 1e-12);
    assert!(at(19.9).is_none() && at(2000.1).is_none());
}

fn flat(density: f64) -> RequiredDensity {
    let point = |frequency| RequiredPoint {
        frequency,
        density,
        tolerance: RequiredDensity::TOLERANCE,
    };
    RequiredDensity {
        name: "flat".into(),
        points: vec![point(20.0), point(400.0)],
    }
}

/// White noise of 1 kHz and a density of one: record by record against a profile at a number of dB beside it.
fn verdicts(beside: f64, seconds: usize, runs: u64) -> [usize; 3] {
    let mut counts = [0; 3];
    for seed in 0..runs {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let sigma = 500f64.sqrt();
        let record: Vec<f64> = (0..1000 * seconds)
            .map(|_| -> f64 { sigma * Distribution::<f64>::sample(&StandardNormal, &mut rng) })
            .collect();
        let density = Welch::new(200).density(&record, 1000.0).unwrap();
        let required = flat(10f64.powf(-beside / 10.0));
        let comparison = required.judge(&density, 0.0).unwrap();
        counts[match comparison.verdict {
            DensityVerdict::Inside { .. } => 0,
            DensityVerdict::Beyond { .. } => 1,
            DensityVerdict::NotShown { .. } => 2,
            other => panic!("{other:?}"),
        }] += 1;
        let [rms, u, _] = comparison.rms;
        // 380 Hz of a density of one; five standard uncertainties, of 360 records none beyond.
        assert!((rms - 380f64.sqrt()).abs() < 5.0 * u, "{rms} {u}");
    }
    counts
}

/// At the limit itself a record is called beyond, or inside, in at most one of twenty: of 200 in at most 19 (binomial, one in a
/// thousand); well inside it is shown, well beyond it is told, and a short record shows nothing.
#[test]
fn coverage_of_verdicts_on_white_noise() {
    let at_limit = verdicts(3.0, 60, 200);
    assert!(at_limit[1] <= 19 && at_limit[0] <= 19, "{at_limit:?}");
    let inside = verdicts(0.0, 120, 50);
    assert_eq!(inside, [50, 0, 0]);
    let beyond = verdicts(6.0, 60, 50);
    assert_eq!(beyond, [0, 50, 0]);
    let short = verdicts(0.0, 3, 50);
    assert!(short[0] == 0 && short[1] <= 8, "{short:?}");
}

#[test]
fn refuses_what_is_no_profile() {
    let mut bad = flat(1.0);
    bad.points[1].frequency = 20.0;
    assert!(bad.check().is_err());
    let mut bad = flat(1.0);
    bad.points[0].density = 0.0;
    assert!(bad.check().is_err());
    let mut bad = flat(1.0);
    bad.points[0].tolerance = [3.0, -3.0];
    assert!(bad.check().is_err());
    bad.points.truncate(1);
    assert!(bad.check().is_err());
}
