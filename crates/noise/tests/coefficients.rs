//! Coefficients of simulated records: coverage of the intervals, false alarms, refusals.

use proofmass_noise::{
    CoefficientFit, DeviationOptions, FitOptions, NoiseModel, NoiseRecord, Statistic, Term,
    Verdict, deviation, simulate, whittle,
};
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

/// Both coefficients inside their 95 % intervals in 95 % of 200 records; B and Q not identified in ≥ 90 %.
///
/// Bound: √(0.95·0.05/200) = 0.0154; three of them below 0.95 is 0.904, above 0.996.
#[test]
fn coverage_white_and_random_walk() {
    let model = NoiseModel {
        white: N,
        random_walk: K,
        ..Default::default()
    };
    let fits: Vec<CoefficientFit> = (0..200)
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
    assert!((0.904..=0.996).contains(&white), "N: {white}");
    assert!((0.904..=0.996).contains(&walk), "K: {walk}");
    for term in [Term::Flicker, Term::Quantisation, Term::Ramp] {
        assert!(share(&|f| identified(f, term)) <= 0.1, "{term:?}");
    }
}

/// White noise alone shows nothing else. The stated rate is 0.002 for each of four terms: two are expected among 250 records
/// if it were used up, and more than seven have a chance of 1e-3.
#[test]
fn law_white_noise_is_white() {
    let model = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    let mut alarms = 0;
    let fits: Vec<CoefficientFit> = (0..250)
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
    assert!(alarms <= 7, "{alarms} false alarms");
    let covered = fits.iter().filter(|f| inside(f, Term::White, 1.0)).count();
    println!("coverage {covered}/250, alarms {alarms}");
    // Three of √(0.95·0.05·250) = 3.4 below 237.
    assert!(covered >= 227, "{covered}");
}

/// A part of the map of `docs/noise.md`: the truth lies in the interval, or below the limit, whether the term is there, weak
/// or absent, and nothing absent is identified.
///
/// Bound for 40 records, thirty comparisons: four of √(0.95·0.05/40) = 0.034 below 0.95 is 32 of 40; at the stated rate of
/// 0.002 three false identifications of 40 have a chance of 1e-4.
#[test]
fn coverage_of_mixtures() {
    let t = 2000.0_f64;
    let walk = |crossings: f64| 3.0_f64.sqrt() * crossings / t;
    let flicker = |crossings: f64| (crossings / (0.4413 * t)).sqrt();
    let ramp = |u: f64| u * (12.0 / t.powi(3)).sqrt();
    for (name, k, b, r, q) in [
        ("N+K 15", walk(15.0), 0.0, 0.0, 0.0),
        ("N+K 30", walk(30.0), 0.0, 0.0, 0.0),
        ("N+B 100", 0.0, flicker(100.0), 0.0, 0.0),
        ("N+B 100+K 20", walk(20.0), flicker(100.0), 0.0, 0.0),
        ("N+K 30+R", walk(30.0), 0.0, ramp(100.0), 0.0),
        ("N+Q+B 100+K 60", walk(60.0), flicker(100.0), 0.0, 0.1),
    ] {
        let model = NoiseModel {
            white: 1.0,
            random_walk: k,
            flicker: b,
            ramp: r,
            quantisation: q,
            ..Default::default()
        };
        let fits: Vec<CoefficientFit> = (0..40_u64)
            .into_par_iter()
            .map(|seed| {
                let rate = record(&model, 20_000, 10.0, 40_000 + seed);
                whittle(&rate, 10.0, &FitOptions::default()).unwrap()
            })
            .collect();
        for (term, truth) in [
            (Term::Quantisation, q),
            (Term::White, 1.0),
            (Term::Flicker, b),
            (Term::RandomWalk, k),
            (Term::Ramp, r),
        ] {
            let held = fits
                .iter()
                .filter(|f| {
                    let verdict = f.get(term).unwrap().verdict;
                    match verdict.interval() {
                        Some((low, high)) => low <= truth && truth <= high,
                        None => verdict.upper().is_none_or(|u| truth <= u),
                    }
                })
                .count();
            let seen = fits.iter().filter(|f| identified(f, term)).count();
            println!("{name} {term:?}: held {held}, identified {seen} of 40");
            assert!(held >= 32, "{name} {term:?}: {held} of 40");
            assert!(truth > 0.0 || seen <= 2, "{name} {term:?}: {seen} false");
        }
    }
}

/// The curve's 95 % intervals at every octave, for each noise alone and mixed: 150 records, four standard deviations of a
/// binomial share (0.018) below 0.95 are granted and 0.01 for the χ² form, above nothing is asked.
#[test]
fn coverage_of_curve_intervals() {
    let n = 8192;
    for (name, model) in [
        ("white", [1.0, 0.0, 0.0]),
        ("flicker", [0.0, 1.0, 0.0]),
        ("walk", [0.0, 0.0, 1.0]),
        ("mixed", [1.0, 0.2, 0.004]),
    ]
    .map(|(name, [white, flicker, random_walk])| {
        (
            name,
            NoiseModel {
                white,
                flicker,
                random_walk,
                ..Default::default()
            },
        )
    }) {
        let curves: Vec<_> = (0..150_u64)
            .into_par_iter()
            .map(|seed| {
                let rate = record(&model, n, 1.0, 70_000 + seed);
                deviation(
                    NoiseRecord::Rate(&rate),
                    1.0,
                    Statistic::OverlappingAllan,
                    &DeviationOptions::default(),
                )
                .unwrap()
            })
            .collect();
        for i in 0..curves[0].points.len() {
            let m = curves[0].points[i].factor;
            let truth = model.sampled_allan_variance(m, 1.0).sqrt();
            let held = curves
                .iter()
                .filter(|c| {
                    let (low, high) = c.points[i].interval.unwrap();
                    low <= truth && truth <= high
                })
                .count();
            println!("{name} m = {m}: {held} of 150");
            assert!(held as f64 / 150.0 > 0.87, "{name} m = {m}: {held} of 150");
        }
    }
}

/// White noise behind low-pass filters: N is not biased by more than 1 %, and the band is said.
///
/// Twelve records of 2·10⁵ samples; three standard errors of the mean beyond 1 %.
#[test]
fn law_filters_do_not_bias_white_noise() {
    let rate = 100.0;
    for (order, corner) in [
        (1, rate / 3.0),
        (1, rate / 10.0),
        (2, rate / 3.0),
        (2, rate / 10.0),
    ] {
        let values: Vec<f64> = (0..12_u64)
            .into_par_iter()
            .map(|seed| {
                let model = NoiseModel {
                    white: 2.5e-3,
                    ..Default::default()
                };
                let y = low_pass(
                    &record(&model, 200_000, rate, 90_000 + seed),
                    order,
                    corner / rate,
                );
                let fit = whittle(&y, rate, &FitOptions::default()).unwrap();
                assert!(fit.band.cut, "order {order} at {corner} Hz");
                fit.value(Term::White).unwrap() / 2.5e-3 - 1.0
            })
            .collect();
        let mean = values.iter().sum::<f64>() / 12.0;
        let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 11.0).sqrt();
        println!(
            "order {order} at {corner} Hz: {:+.2} % ± {:.2} %",
            100.0 * mean,
            100.0 * spread
        );
        assert!(mean.abs() < 0.01 + 3.0 * spread / 12.0_f64.sqrt());
    }
}

/// Butterworth low-pass by the bilinear transform, corner as a share of the sample rate.
fn low_pass(x: &[f64], order: u32, corner: f64) -> Vec<f64> {
    let w = (std::f64::consts::PI * corner).tan();
    let (b, a) = if order == 1 {
        let g = 1.0 + w;
        ([w / g, w / g, 0.0], [(w - 1.0) / g, 0.0])
    } else {
        let g = 1.0 + std::f64::consts::SQRT_2 * w + w * w;
        let b = w * w / g;
        (
            [b, 2.0 * b, b],
            [
                2.0 * (w * w - 1.0) / g,
                (1.0 - std::f64::consts::SQRT_2 * w + w * w) / g,
            ],
        )
    };
    let (mut x1, mut x2, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0);
    x.iter()
        .map(|&x0| {
            let y = b[0] * x0 + b[1] * x1 + b[2] * x2 - a[0] * y1 - a[1] * y2;
            (x2, x1, y2, y1) = (x1, x0, y1, y);
            y
        })
        .collect()
}

/// Averages that overlap by one sample are part of the fit whether quantisation is sought or not, and beside a process that is sought.
///
/// N lies within four of its standard uncertainties (0.25 % of N each) of the truth, and no process is found.
#[test]
fn law_overlapping_averages_are_told_without_quantisation() {
    let white = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    // Half of the density is lost at half the rate: 4 c (1 − c) = ½.
    let c = 0.5 - 0.125_f64.sqrt();
    for seed in 0..3 {
        let plain = record(&white, 100_000, 100.0, seed + 900);
        let rate: Vec<f64> = plain
            .windows(2)
            .map(|w| c * w[0] + (1.0 - c) * w[1])
            .collect();
        for further in [
            vec![Term::Flicker, Term::RandomWalk],
            vec![Term::RandomWalk, Term::GaussMarkov],
        ] {
            let mut terms = vec![Term::White];
            terms.extend(further);
            let options = FitOptions {
                terms,
                ..FitOptions::default()
            };
            let fit = whittle(&rate, 100.0, &options).unwrap();
            assert!(
                fit.band.front_end.is_some(),
                "{seed}: {:?} {:?}",
                fit.coefficients,
                fit.band
            );
            assert!(
                (fit.model.white - 1.0).abs() < 0.01,
                "{seed}: {}",
                fit.model.white
            );
            assert!(fit.model.gauss_markov.is_empty(), "{seed}");
        }
    }
}

/// Quantisation above white noise is not taken for a filter, which would take Q out of the fit: N and Q hold.
///
/// 60 records a cell; 0.95 less three of √(0.95·0.05/60) is 0.866. A filter that is not there was seen in one record in ten before.
#[test]
fn coverage_beside_quantisation() {
    for quantisation in [2e-4, 1e-3] {
        let model = NoiseModel {
            white: N,
            quantisation,
            ..Default::default()
        };
        let fits: Vec<CoefficientFit> = (0..60)
            .into_par_iter()
            .map(|seed| {
                let rate = record(&model, 20_000, 100.0, seed + 7000);
                whittle(&rate, 100.0, &FitOptions::default()).unwrap()
            })
            .collect();
        let share = |f: &dyn Fn(&CoefficientFit) -> bool| {
            fits.iter().filter(|fit| f(fit)).count() as f64 / fits.len() as f64
        };
        assert!(share(&|f| inside(f, Term::White, N)) >= 0.866);
        assert!(share(&|f| inside(f, Term::Quantisation, quantisation)) >= 0.866);
        assert!(share(&|f| f.band.cut) <= 0.04);
    }
}

/// What the caller says holds: terms left out, forced, given.
#[test]
fn law_terms_follow_the_caller() {
    let model = NoiseModel {
        white: 1.0,
        random_walk: 0.01,
        ..Default::default()
    };
    let rate = record(&model, 20_000, 10.0, 3);
    let options = FitOptions {
        terms: vec![Term::White, Term::Flicker, Term::RandomWalk],
        forced: vec![Term::Flicker],
        fixed: vec![(Term::RandomWalk, 0.01)],
        ..FitOptions::default()
    };
    let fit = whittle(&rate, 10.0, &options).unwrap();
    assert!(fit.get(Term::Ramp).is_none() && fit.get(Term::Quantisation).is_none());
    // Zero lies in its interval: asked for is not identified.
    assert!(matches!(
        fit.get(Term::Flicker).unwrap().verdict,
        Verdict::Reported { interval: (low, high), .. } if low == 0.0 && high > 0.0
    ));
    assert_eq!(
        fit.get(Term::RandomWalk).unwrap().verdict,
        Verdict::Fixed { value: 0.01 }
    );
    assert_eq!(fit.model.random_walk, 0.01);
    for highest in [0.0, -1.0, 6.0, f64::NAN] {
        let options = FitOptions {
            highest_frequency: Some(highest),
            ..FitOptions::default()
        };
        assert!(whittle(&rate, 10.0, &options).is_err());
    }
}
