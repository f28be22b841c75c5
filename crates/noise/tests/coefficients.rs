//! Coefficients of simulated records: coverage of the intervals, false alarms, refusals.

use proofmass_noise::{CoefficientFit, FitOptions, NoiseModel, Term, Verdict, simulate, whittle};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// The record of the published acceptance case, N and K at 400 Hz for 11 000 s, averaged to 10 Hz.
///
/// Averages of white noise and of a random walk have the same N and K, and everything the case can tell about K, B
/// and Q against N (corner at K/(2πN) = 4.4 mHz) lies below 5 Hz; `examples/acceptance.rs` runs all 4.4 million samples.
const N: f64 = 0.00250199;
const K: f64 = 6.97244e-5;
const RATE: f64 = 10.0;
const SAMPLES: usize = 110_000;

fn record(model: &NoiseModel, samples: usize, rate: f64, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(model, samples, rate, &mut rng).unwrap()
}

fn inside(fit: &CoefficientFit, term: Term, truth: f64) -> bool {
    fit.get(term)
        .and_then(|c| c.verdict.interval())
        .is_some_and(|(low, high)| low <= truth && truth <= high)
}

fn identified(fit: &CoefficientFit, term: Term) -> bool {
    matches!(fit.get(term).unwrap().verdict, Verdict::Identified { .. })
}

/// Both coefficients inside their 95 % intervals in 95 % of 500 records; B and Q not identifiable in ≥ 90 %.
///
/// Bound: √(0.95·0.05/500) = 0.0097; three of them below 0.95 is 0.921, above 0.979.
#[test]
fn coverage_white_and_random_walk() {
    let model = NoiseModel {
        white: N,
        random_walk: K,
        ..Default::default()
    };
    let fits: Vec<CoefficientFit> = (0..500)
        .into_par_iter()
        .map(|seed| {
            whittle(
                &record(&model, SAMPLES, RATE, seed),
                RATE,
                &FitOptions::default(),
            )
            .unwrap()
        })
        .collect();
    let share = |f: &dyn Fn(&CoefficientFit) -> bool| {
        fits.iter().filter(|fit| f(fit)).count() as f64 / fits.len() as f64
    };
    let white = share(&|f| inside(f, Term::White, N));
    let walk = share(&|f| inside(f, Term::RandomWalk, K));
    println!("coverage N {white} K {walk}");
    println!(
        "identified Q {} B {} R {}",
        share(&|f| identified(f, Term::Quantisation)),
        share(&|f| identified(f, Term::Flicker)),
        share(&|f| identified(f, Term::Ramp))
    );
    assert!((0.921..=0.979).contains(&white), "N: {white}");
    assert!((0.921..=0.979).contains(&walk), "K: {walk}");
    for term in [Term::Flicker, Term::Quantisation, Term::Ramp] {
        assert!(share(&|f| identified(f, term)) <= 0.1, "{term:?}");
    }
}

/// White noise alone shows nothing else. The stated false-alarm rate is 1e-4 for all terms of a record together:
/// among 500 records one false alarm has probability 0.05 and two 0.0012.
#[test]
fn law_white_noise_is_white() {
    let model = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    let mut alarms = 0;
    let fits: Vec<CoefficientFit> = (0..500)
        .into_par_iter()
        .map(|seed| {
            whittle(
                &record(&model, 20_000, 100.0, 9000 + seed),
                100.0,
                &FitOptions::default(),
            )
            .unwrap()
        })
        .collect();
    for fit in &fits {
        assert!(identified(fit, Term::White));
        for term in [
            Term::Quantisation,
            Term::Flicker,
            Term::RandomWalk,
            Term::Ramp,
        ] {
            alarms += usize::from(identified(fit, term));
        }
    }
    assert!(alarms <= 1, "{alarms} false alarms");
    let covered = fits.iter().filter(|f| inside(f, Term::White, 1.0)).count();
    println!("coverage {covered}/500, alarms {alarms}");
    assert!((461..=489).contains(&covered), "{covered}");
}

/// The regression on the curve: a quarter of the record, its own intervals.
///
/// Bound for 160 records: √(0.95·0.05/160) = 0.0172, three of them below 0.95 is 0.898; the covariance integrals are good
/// to 2 %, for which another 0.01 is granted. K needs the longest τ of this short record: where chance bends the curve
/// another way it is refused or replaced (not more than one record in ten).
#[test]
fn coverage_allan_regression() {
    let model = NoiseModel {
        white: N,
        random_walk: K,
        ..Default::default()
    };
    let fits: Vec<CoefficientFit> = (0..160)
        .into_par_iter()
        .map(|seed| {
            let rate = record(&model, SAMPLES / 4, RATE, 5000 + seed);
            proofmass_noise::allan_regression(&rate, RATE, &FitOptions::default()).unwrap()
        })
        .collect();
    let count = |f: &dyn Fn(&CoefficientFit) -> bool| fits.iter().filter(|x| f(x)).count();
    let white = count(&|f| inside(f, Term::White, N));
    let found = count(&|f| identified(f, Term::RandomWalk));
    let walk = count(&|f| inside(f, Term::RandomWalk, K));
    println!("regression: N {white} of 160; K inside {walk} of {found}");
    assert!(white as f64 / 160.0 >= 0.888, "{white}");
    assert!(found >= 144, "{found}");
    assert!(walk as f64 / found as f64 >= 0.888, "{walk} of {found}");
}

/// White noise alone in the regression: 1e-4 is asked for; the covariance of the longest τ is approximate, so 2 of 160
/// are allowed.
#[test]
fn law_white_curve_is_white() {
    let model = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    let alarms: usize = (0..160_u64)
        .into_par_iter()
        .map(|seed| {
            let rate = record(&model, 10_000, 100.0, 20_000 + seed);
            let fit =
                proofmass_noise::allan_regression(&rate, 100.0, &FitOptions::default()).unwrap();
            let others = [
                Term::Quantisation,
                Term::Flicker,
                Term::RandomWalk,
                Term::Ramp,
            ];
            usize::from(others.iter().any(|t| identified(&fit, *t)))
        })
        .sum();
    println!("regression: {alarms} false alarms of 160");
    assert!(alarms <= 2, "{alarms}");
}
