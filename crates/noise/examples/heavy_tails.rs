//! N of samples with heavy tails and of samples with outliers, as in `docs/noise.md`.
//!
//! `cargo run --release -p proofmass-noise --example heavy_tails -- 300 [FIRST_SEED]`. Records of 20 000 samples at 10 Hz with N = 1 and K at 30
//! crossing times. For each law of the white noise: how often the 95 % interval of N holds its standard deviation, outliers included, and its bias;
//! the same of the fit without outliers, against the noise that is not outliers.

use proofmass_noise::{FitOptions, FitRecord, NoiseModel, Term, robust_fit, simulate, whittle};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StudentT, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const RATE: f64 = 10.0;
const SAMPLES: usize = 20_000;

#[derive(Clone, Copy)]
enum Law {
    Gauss,
    Laplace,
    /// Student's t with so many degrees of freedom.
    Student(f64),
    /// Share, and standard deviation in those of a sample.
    Outliers(f64, f64),
}

fn white(law: Law, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let unit = Uniform::new(0.0, 1.0).expect("a range");
    let student = match law {
        Law::Student(dof) => dof,
        _ => 4.0,
    };
    let spread = (student / (student - 2.0)).sqrt();
    let student = StudentT::new(student).expect("degrees of freedom");
    (0..SAMPLES)
        .map(|_| {
            let normal: f64 = StandardNormal.sample(rng);
            match law {
                Law::Gauss => normal,
                Law::Laplace => {
                    let u: f64 = unit.sample(rng);
                    normal.signum() * -(1.0 - u).ln() / 2.0_f64.sqrt()
                }
                Law::Student(_) => student.sample(rng) / spread,
                Law::Outliers(share, size) => {
                    let u: f64 = unit.sample(rng);
                    let further: f64 = StandardNormal.sample(rng);
                    normal + if u < share { size * further } else { 0.0 }
                }
            }
        })
        .collect()
}

/// Held, N less one: ordinary; robust; both without failures; samples replaced.
fn examine(law: Law, seed: u64) -> [f64; 5] {
    let t = SAMPLES as f64 / RATE;
    let walk = NoiseModel {
        random_walk: 3.0_f64.sqrt() * 30.0 / t,
        ..Default::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut rate = simulate(&walk, SAMPLES, RATE, &mut rng).expect("a legal model");
    for (y, w) in rate.iter_mut().zip(white(law, &mut rng)) {
        *y += RATE.sqrt() * w;
    }
    let options = FitOptions::default();
    let fit = whittle(&rate, RATE, &options).expect("a long record");
    let robust = robust_fit(&FitRecord::new(&[&rate]), &fit, RATE, &options).expect("few outliers");
    let of = |fit: &proofmass_noise::CoefficientFit, truth: f64| {
        let verdict = fit.get(Term::White).expect("sought").verdict;
        let held = verdict
            .interval()
            .is_some_and(|(low, high)| low <= truth && truth <= high);
        (f64::from(u8::from(held)), fit.model.white / truth - 1.0)
    };
    let all = match law {
        Law::Outliers(share, size) => (1.0 + share * size * size).sqrt(),
        _ => 1.0,
    };
    let (a, b) = (of(&fit, all), of(&robust.fit, 1.0));
    [a.0, a.1, b.0, b.1, robust.replaced as f64]
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<u64>().ok());
    let records = argument(1).unwrap_or(300);
    let first = argument(2).unwrap_or(0);
    println!("{records} records: N held, bias, % | robust: held, bias, % | samples replaced");
    for (index, (name, law)) in [
        ("Gaussian", Law::Gauss),
        ("Laplace", Law::Laplace),
        ("Student t, 4", Law::Student(4.0)),
        ("Student t, 5", Law::Student(5.0)),
        ("0.1 % of 10 sigma", Law::Outliers(0.001, 10.0)),
        ("0.01 % of 20 sigma", Law::Outliers(0.0001, 20.0)),
        ("1 % of 10 sigma", Law::Outliers(0.01, 10.0)),
    ]
    .into_iter()
    .enumerate()
    {
        let sums = (0..records)
            .into_par_iter()
            .map(|k| examine(law, (index as u64) << 32 | (first + k)))
            .reduce(
                || [0.0; 5],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            );
        let mean = sums.map(|s| s / records as f64);
        println!(
            "{name:20} {:5.1} {:+.2} | {:5.1} {:+.2} | {:.1}",
            100.0 * mean[0],
            100.0 * mean[1],
            100.0 * mean[2],
            100.0 * mean[3],
            mean[4]
        );
    }
}
