//! N and B behind filters that are not the ones the fit knows, as in `docs/noise.md`.
//!
//! `cargo run --release -p proofmass-noise --example front_ends -- 100 [T/τ_f]`. Records of 200 000 samples at 10 Hz with N = 1 and flicker noise
//! by its crossing time: bias and scatter of N, and how often N and B lie in their 95 % intervals.

use proofmass_noise::{FitOptions, NoiseModel, Term, Verdict, simulate, whittle};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

const RATE: f64 = 10.0;
const SAMPLES: usize = 200_000;
/// Samples before the record, in which the filters settle.
const BEFORE: usize = 2000;

#[derive(Clone, Copy)]
enum Shape {
    /// Sections of second order, each with its quality and its corner over that of the whole.
    Sections(&'static [(f64, f64)]),
    FirstOrder,
    /// Mean of so many samples.
    Mean(usize),
}

/// Shape, corner as a part of the rate, white noise added behind.
const CASES: [(&str, Shape, f64, f64); 8] = [
    ("Butterworth 4, 1/10", FOURTH, 0.1, 0.0),
    ("Butterworth 4, 1/30", FOURTH, 1.0 / 30.0, 0.0),
    ("Bessel 2, 1/10", BESSEL, 0.1, 0.0),
    ("Bessel 2, 1/30", BESSEL, 1.0 / 30.0, 0.0),
    ("mean of 4", Shape::Mean(4), 0.0, 0.0),
    ("mean of 16", Shape::Mean(16), 0.0, 0.0),
    (
        "order 1, 1/30, 1 % behind",
        Shape::FirstOrder,
        1.0 / 30.0,
        0.1,
    ),
    ("order 2, 1/30, 1 % behind", SECOND, 1.0 / 30.0, 0.1),
];
const FOURTH: Shape = Shape::Sections(&[(0.541_196, 1.0), (1.306_563, 1.0)]);
const BESSEL: Shape = Shape::Sections(&[(0.577_350, 1.2736)]);
const SECOND: Shape = Shape::Sections(&[(FRAC_1_SQRT_2, 1.0)]);

fn section(samples: &mut [f64], w: f64, quality: f64) {
    let n = 1.0 / (1.0 + w / quality + w * w);
    let (b, a1, a2) = (
        w * w * n,
        2.0 * (w * w - 1.0) * n,
        (1.0 - w / quality + w * w) * n,
    );
    let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
    for v in samples {
        let out = b * (*v + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
        (x, y) = ([*v, x[0]], [out, y[0]]);
        *v = out;
    }
}

fn record(model: &NoiseModel, shape: Shape, corner: f64, behind: f64, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut y = simulate(model, BEFORE + SAMPLES, RATE, &mut rng).expect("a legal model");
    let w = (PI * corner).tan();
    match shape {
        Shape::Sections(sections) => {
            for (quality, factor) in sections {
                section(&mut y, factor * w, *quality);
            }
        }
        Shape::FirstOrder => {
            let (mut input, mut output) = (0.0, 0.0);
            for v in &mut y {
                output = (w * (*v + input) + (1.0 - w) * output) / (1.0 + w);
                input = *v;
                *v = output;
            }
        }
        Shape::Mean(m) => {
            y = y
                .windows(m)
                .map(|w| w.iter().sum::<f64>() / m as f64)
                .collect();
        }
    }
    let mut y = y.split_off(y.len() - SAMPLES);
    if behind > 0.0 {
        let floor = NoiseModel {
            white: behind,
            ..NoiseModel::default()
        };
        let floor = simulate(&floor, SAMPLES, RATE, &mut rng).expect("a legal model");
        y.iter_mut().zip(floor).for_each(|(y, f)| *y += f);
    }
    y
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<f64>().ok());
    let records = argument(1).unwrap_or(100.0);
    let crossings = argument(2).unwrap_or(0.0);
    let model = NoiseModel {
        white: 1.0,
        flicker: (crossings / (0.4413 * SAMPLES as f64 / RATE)).sqrt(),
        ..NoiseModel::default()
    };
    println!(
        "{records} records, T/tau_f = {crossings}: bias of N, % (of one record) | N held, % | B"
    );
    for (name, shape, corner, behind) in CASES {
        let sums = (0..records as u64)
            .into_par_iter()
            .map(|seed| {
                let y = record(&model, shape, corner, behind, seed);
                let fit = whittle(&y, RATE, &FitOptions::default()).expect("a long record");
                let held = |term, truth: f64| {
                    let verdict: Verdict = fit.get(term).expect("sought").verdict;
                    let inside = match verdict.interval() {
                        Some((low, high)) => low <= truth && truth <= high,
                        None => verdict.upper().is_none_or(|u| truth <= u),
                    };
                    f64::from(u8::from(inside))
                };
                let error = fit.model.white - 1.0;
                let (n, b) = (held(Term::White, 1.0), held(Term::Flicker, model.flicker));
                [error, error * error, n, b]
            })
            .reduce(|| [0.0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        let [mean, square, n, b] = sums.map(|s| 100.0 * s / records);
        println!(
            "{name:26} {mean:+.2} ({:.2}) | {n:.0} | {b:.0}",
            (100.0 * square - mean * mean).max(0.0).sqrt()
        );
    }
}
