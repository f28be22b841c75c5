//! Coverage of coefficients and curves where the mixtures of `examples/coverage.rs` do not reach: the record of the published
//! acceptance case, white noise alone, quantisation, intervals of the curve at every octave, filters.
//!
//! `cargo run --release -p proofmass-noise --example coefficient_coverage [RECORDS]`, 1000 a cell if no number is given. The suite
//! takes a few records of each (`tests/coefficients.rs`).

use proofmass_noise::{
    CoefficientFit, DeviationOptions, FitOptions, NoiseModel, NoiseRecord, Statistic, Term,
    Verdict, deviation, simulate, whittle,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::ops::Range;

/// N of the published acceptance case, at 400 Hz for 11 000 s, averaged to 10 Hz.
///
/// Averages of white noise and of a random walk have the same N and K, and everything the case can tell about K, B
/// and Q against N (corner at K/(2πN) = 4.4 mHz) lies below 5 Hz.
pub const N: f64 = 0.00250199;
/// K of the case.
pub const K: f64 = 6.97244e-5;

/// A model with its sampling.
#[derive(Clone, Debug)]
pub struct Cell {
    /// What is simulated.
    pub model: NoiseModel,
    /// Samples of a record.
    pub samples: usize,
    /// Samples per second.
    pub rate: f64,
}

/// N and K of the acceptance case.
pub fn acceptance() -> Cell {
    Cell {
        model: NoiseModel {
            white: N,
            random_walk: K,
            ..Default::default()
        },
        samples: 110_000,
        rate: 10.0,
    }
}

/// N with Q, 20 000 samples at 100 Hz.
pub fn quantised(white: f64, quantisation: f64) -> Cell {
    Cell {
        model: NoiseModel {
            white,
            quantisation,
            ..Default::default()
        },
        samples: 20_000,
        rate: 100.0,
    }
}

/// White noise, flicker and random walk whose curves are looked at.
pub const CURVES: [(&str, [f64; 3]); 4] = [
    ("white", [1.0, 0.0, 0.0]),
    ("flicker", [0.0, 1.0, 0.0]),
    ("walk", [0.0, 0.0, 1.0]),
    ("mixed", [1.0, 0.2, 0.004]),
];

/// A simulated record.
pub fn record(model: &NoiseModel, samples: usize, rate: f64, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(model, samples, rate, &mut rng).expect("a legal model")
}

/// Fits of the records of these seeds.
pub fn fits(cell: &Cell, seeds: Range<u64>) -> Vec<CoefficientFit> {
    seeds
        .into_par_iter()
        .map(|seed| {
            let rate = record(&cell.model, cell.samples, cell.rate, seed);
            whittle(&rate, cell.rate, &FitOptions::default()).expect("a long record")
        })
        .collect()
}

/// Whether the truth lies in the 95 % interval, or below the limit where the term is not identified.
pub fn held(fit: &CoefficientFit, term: Term, truth: f64) -> bool {
    let Some(found) = fit.get(term) else {
        return false;
    };
    match found.verdict.interval() {
        Some((low, high)) => low <= truth && truth <= high,
        None => found.verdict.upper().is_none_or(|u| truth <= u),
    }
}

/// Whether a term is called identified.
pub fn identified(fit: &CoefficientFit, term: Term) -> bool {
    fit.get(term)
        .is_some_and(|c| matches!(c.verdict, Verdict::Identified { .. }))
}

/// Averaging factors of the curve, each with the number of records whose interval holds the true deviation.
pub fn curve(parts: [f64; 3], seeds: Range<u64>) -> Vec<(usize, usize)> {
    let model = NoiseModel {
        white: parts[0],
        flicker: parts[1],
        random_walk: parts[2],
        ..Default::default()
    };
    let curves: Vec<_> = seeds
        .into_par_iter()
        .map(|seed| {
            let rate = record(&model, 8192, 1.0, 70_000 + seed);
            deviation(
                NoiseRecord::Rate(&rate),
                1.0,
                Statistic::OverlappingAllan,
                &DeviationOptions::default(),
            )
            .expect("a long record")
        })
        .collect();
    let points = 0..curves[0].points.len();
    points
        .map(|i| {
            let factor = curves[0].points[i].factor;
            let truth = model.sampled_allan_variance(factor, 1.0).sqrt();
            let held = curves.iter().filter(|c| {
                c.points[i]
                    .interval
                    .is_some_and(|(low, high)| low <= truth && truth <= high)
            });
            (factor, held.count())
        })
        .collect()
}

/// Error of N of white noise behind a low-pass, its standard uncertainty, both relative, and whether the band was cut.
pub fn filtered(order: u32, corner: f64, seed: u64) -> Option<(f64, f64, bool)> {
    let (white, rate) = (2.5e-3, 100.0);
    let plain = record(&quantised(white, 0.0).model, 200_000, rate, 90_000 + seed);
    let fit = whittle(
        &low_pass(&plain, order, corner),
        rate,
        &FitOptions::default(),
    )
    .ok()?;
    let Verdict::Identified {
        value,
        standard_uncertainty,
        ..
    } = fit.get(Term::White)?.verdict
    else {
        return None;
    };
    Some((
        value / white - 1.0,
        standard_uncertainty / white,
        fit.band.cut,
    ))
}

/// Orders and corners, as parts of the rate, of the filters.
pub const FILTERS: [(u32, f64); 4] = [(1, 1.0 / 3.0), (1, 0.1), (2, 1.0 / 3.0), (2, 0.1)];

/// Butterworth low-pass by the bilinear transform, corner as a share of the sample rate.
pub fn low_pass(x: &[f64], order: u32, corner: f64) -> Vec<f64> {
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

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let records: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(1000);
    let percent = |n: usize| 100.0 * n as f64 / records as f64;
    println!("{records} records each; truth held | identified, %; band cut, %");
    for (name, cell, seed) in [
        ("acceptance case", acceptance(), 0),
        ("white noise alone", quantised(1.0, 0.0), 9000),
        ("Q = 2e-4", quantised(N, 2e-4), 7000),
        ("Q = 1e-3", quantised(N, 1e-3), 7000),
    ] {
        let fits = fits(&cell, seed..seed + records);
        print!("{name}");
        for (term, truth) in [
            (Term::Quantisation, cell.model.quantisation),
            (Term::White, cell.model.white),
            (Term::Flicker, 0.0),
            (Term::RandomWalk, cell.model.random_walk),
            (Term::Ramp, 0.0),
        ] {
            let of = |f: &dyn Fn(&CoefficientFit) -> bool| {
                percent(fits.iter().filter(|fit| f(fit)).count())
            };
            print!(
                " | {term:?} {:.1} | {:.1}",
                of(&|f| held(f, term, truth)),
                of(&|f| identified(f, term))
            );
        }
        println!(
            " | cut {:.1}",
            percent(fits.iter().filter(|f| f.band.cut).count())
        );
    }
    for (name, parts) in CURVES {
        let shares: Vec<String> = curve(parts, 0..records)
            .into_iter()
            .map(|(m, held)| format!("{m}: {:.1}", percent(held)))
            .collect();
        println!(
            "curve of {name}, held in % by factor: {}",
            shares.join(", ")
        );
    }
    for (order, corner) in FILTERS {
        let errors: Vec<f64> = (0..records)
            .into_par_iter()
            .filter_map(|seed| filtered(order, corner, seed).map(|f| f.0))
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        println!(
            "N behind order {order} at {corner:.2} of the rate: {:+.2} % in {} records",
            100.0 * mean,
            errors.len()
        );
    }
}
