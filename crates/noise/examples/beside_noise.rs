//! Coverage of what is fitted beside the noise terms, as in `docs/noise.md`: temperature and slow sinusoids.
//!
//! `cargo run --release -p proofmass-noise --example beside_noise -- 200 [FIRST_SEED [CELL]]`. Records of 20 000 samples at 10 Hz with
//! N = 1, K at 30 crossing times, B at 100. Temperatures: a slow sinusoid (3.3 cycles), a straight line, a random walk,
//! each of 1 K rms with the noise of a thermometer (2 mK). For each cell: how often the truth lies in the 95 % intervals (or below the
//! limits), how often terms that are not there are called identified, how many sinusoids were found.

use proofmass_noise::{FitOptions, FitRecord, NoiseModel, Term, Verdict, simulate, whittle_record};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::PI;

const RATE: f64 = 10.0;
const SAMPLES: usize = 20_000;

#[derive(Clone, Copy, PartialEq)]
enum Course {
    None,
    Sinusoid,
    Line,
    Walk,
}

#[derive(Clone, Copy)]
struct Cell {
    name: &'static str,
    /// Crossing times of K and B in the record.
    walk: f64,
    flicker: f64,
    /// In √(12N²/T³).
    ramp: f64,
    course: Course,
    /// K_T, U/K.
    sensitivity: f64,
    /// Amplitude, and cycles in the record.
    sinusoid: Option<(f64, f64)>,
    seek: bool,
}

const PLAIN: Cell = Cell {
    name: "",
    walk: 0.0,
    flicker: 0.0,
    ramp: 0.0,
    course: Course::None,
    sensitivity: 0.0,
    sinusoid: None,
    seek: false,
};

fn cells() -> Vec<Cell> {
    let mixtures = [
        ("N", 0.0, 0.0),
        ("N+K30", 30.0, 0.0),
        ("N+B100", 0.0, 100.0),
        ("N+B100+K60", 60.0, 100.0),
    ];
    let mut cells = Vec::new();
    for (course, word) in [
        (Course::Sinusoid, "T sinusoid"),
        (Course::Line, "T line"),
        (Course::Walk, "T walk"),
    ] {
        for (name, walk, flicker) in mixtures {
            for sensitivity in [0.0, 1.0] {
                let text = format!("{name}, {word}, K_T = {sensitivity}");
                cells.push(Cell {
                    name: text.leak(),
                    walk,
                    flicker,
                    course,
                    sensitivity,
                    ..PLAIN
                });
            }
        }
    }
    for (name, walk, flicker) in [
        ("N", 0.0, 0.0),
        ("N+K10", 10.0, 0.0),
        ("N+K30", 30.0, 0.0),
        ("N+K100", 100.0, 0.0),
        ("N+K300", 300.0, 0.0),
        ("N+B30", 0.0, 30.0),
        ("N+B100", 0.0, 100.0),
        ("N+B300", 0.0, 300.0),
        ("N+B100+K60", 60.0, 100.0),
        ("N+B100+K300", 300.0, 100.0),
    ] {
        let text = format!("{name}, none");
        cells.push(Cell {
            name: text.leak(),
            walk,
            flicker,
            seek: true,
            ..PLAIN
        });
    }
    // Of a hundredth of the white noise of a sample and above; many standard uncertainties.
    for (name, walk, flicker, amplitude, cycles) in [
        ("N, 3.33 cycles", 0.0, 0.0, 0.3, 3.33),
        ("N, 20 cycles", 0.0, 0.0, 0.3, 20.0),
        ("N+K30, 3.33 cycles", 30.0, 0.0, 1.0, 3.33),
        ("N+K30, 20 cycles", 30.0, 0.0, 0.4, 20.0),
        ("N+B100, 3.33 cycles", 0.0, 100.0, 0.5, 3.33),
        ("N+B100+K60, 3.33 cycles", 60.0, 100.0, 2.0, 3.33),
        ("N+B100+K60, 20 cycles", 60.0, 100.0, 0.5, 20.0),
        // Eleven standard uncertainties, √(2 N²/T).
        ("N, 20.3 cycles", 0.0, 0.0, 0.348, 20.3),
        ("N, 33.3 cycles", 0.0, 0.0, 0.348, 33.3),
        ("N, 36.3 cycles", 0.0, 0.0, 0.348, 36.3),
        ("N, 50.3 cycles", 0.0, 0.0, 0.348, 50.3),
        ("N, 100.3 cycles", 0.0, 0.0, 0.348, 100.3),
        ("N, 330.3 cycles", 0.0, 0.0, 0.348, 330.3),
    ] {
        cells.push(Cell {
            name,
            walk,
            flicker,
            sinusoid: Some((amplitude, cycles)),
            seek: true,
            ..PLAIN
        });
    }
    cells
}

/// Held: N, B, K, R, K_T, amplitude, frequency; identified: B, K, R, K_T; sinusoids; records whose first sinusoid is the true one.
type Counts = [u64; 14];

fn temperature(course: Course, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    let phase = 2.0 * normal();
    let mut walk = 0.0;
    let n = SAMPLES as f64;
    (0..SAMPLES)
        .map(|i| {
            let part = i as f64 / n;
            walk += normal() * (6.0 / n).sqrt();
            let slow = match course {
                Course::None => 0.0,
                Course::Sinusoid => 2.0_f64.sqrt() * (2.0 * PI * 3.3 * part + phase).sin(),
                Course::Line => 12.0_f64.sqrt() * part,
                Course::Walk => walk,
            };
            20.0 + slow + 0.002 * normal()
        })
        .collect()
}

fn examine(cell: &Cell, seed: u64) -> Counts {
    let t = SAMPLES as f64 / RATE;
    let model = NoiseModel {
        white: 1.0,
        random_walk: 3.0_f64.sqrt() * cell.walk / t,
        flicker: (cell.flicker / (0.4413 * t)).sqrt(),
        ramp: cell.ramp * (12.0 / t.powi(3)).sqrt(),
        ..Default::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut rate = simulate(&model, SAMPLES, RATE, &mut rng).expect("a legal model");
    let phase: f64 = StandardNormal.sample(&mut rng);
    if let Some((amplitude, cycles)) = cell.sinusoid {
        for (i, y) in rate.iter_mut().enumerate() {
            *y += amplitude * (2.0 * PI * cycles * i as f64 / SAMPLES as f64 + 3.0 * phase).sin();
        }
    }
    let course = temperature(cell.course, &mut rng);
    for (y, c) in rate.iter_mut().zip(&course) {
        *y += cell.sensitivity * (c - 20.0);
    }
    let mut options = FitOptions::default();
    if cell.seek {
        options.terms.push(Term::Sinusoid);
    }
    let stretches = [&rate[..]];
    let courses = [&course[..]];
    let record = FitRecord {
        temperature: (cell.course != Course::None).then_some(&courses[..]),
        ..FitRecord::new(&stretches)
    };
    let fit = whittle_record(&record, RATE, &options).expect("a long record");
    let held = |verdict: Verdict, truth: f64| -> u64 {
        u64::from(match verdict {
            Verdict::Identified { interval, .. } | Verdict::Present { interval, .. } => {
                interval.0 <= truth && truth <= interval.1
            }
            _ => verdict.upper().is_none_or(|u| truth.abs() <= u),
        })
    };
    let mut row = [0; 14];
    let truths = [
        (Term::White, model.white),
        (Term::Flicker, model.flicker),
        (Term::RandomWalk, model.random_walk),
        (Term::Ramp, model.ramp),
    ];
    for (k, (term, truth)) in truths.into_iter().enumerate() {
        let verdict = fit.get(term).expect("sought").verdict;
        row[k] = held(verdict, truth);
        if k > 0 {
            row[6 + k] = u64::from(verdict.is_identified());
        }
    }
    if let Some(sensitivity) = &fit.temperature {
        row[4] = held(sensitivity.verdict, cell.sensitivity);
        row[10] = u64::from(sensitivity.verdict.is_identified());
    }
    let sinusoids: Vec<_> = fit
        .coefficients
        .iter()
        .filter(|c| c.term == Term::Sinusoid)
        .collect();
    row[11] = sinusoids.len() as u64;
    if let (Some((amplitude, cycles)), Some(first)) = (cell.sinusoid, sinusoids.first()) {
        let found = first.parameter.expect("a frequency");
        let frequency = cycles / t;
        if (found.value - frequency).abs() < 0.7 / t {
            row[12] = 1;
            row[5] = held(first.verdict, amplitude);
            row[6] = u64::from(
                found
                    .interval
                    .is_none_or(|(a, b): (f64, f64)| a <= frequency && frequency <= b),
            );
        }
    }
    row[13] = u64::from(fit.discrepancy > 0.0);
    row
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<u64>().ok());
    let records = argument(1).unwrap_or(200);
    let first = argument(2).unwrap_or(0);
    let only = std::env::args().nth(3);
    println!(
        "{records} records a cell, in %: truth held N B K R | K_T, amplitude, frequency | identified B K R | K_T | found, sinusoids per record, misfit"
    );
    for (index, cell) in cells().iter().enumerate() {
        if only.as_deref().is_some_and(|o| !cell.name.contains(o)) {
            continue;
        }
        let counts = (0..records)
            .into_par_iter()
            .map(|k| examine(cell, (index as u64 + 100) << 32 | (first + k)))
            .reduce(
                || [0; 14],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            );
        let of = |n: u64, all: u64| 100.0 * n as f64 / all.max(1) as f64;
        let share = |k: usize| of(counts[k], records);
        print!("{:36}", cell.name);
        for k in 0..4 {
            print!(" {:5.1}", share(k));
        }
        print!(
            " | {:5.1} {:5.1} {:5.1} |",
            share(4),
            of(counts[5], counts[12]),
            of(counts[6], counts[12])
        );
        for k in 7..10 {
            print!(" {:5.1}", share(k));
        }
        println!(
            " | {:5.1} | {:5.1} {:5.2} {:4.1}",
            share(10),
            share(12),
            share(11) / 100.0,
            share(13)
        );
    }
}
