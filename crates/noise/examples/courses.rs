//! Coverage beside courses that are not noise, as in `docs/noise.md`: settling after the start, steps, the cycle of the day, and a
//! temperature that the output follows with a lag that nobody states.
//!
//! `cargo run --release -p proofmass-noise --example courses -- 200 [FIRST_SEED [CELL]]`. Records of 20 000 samples at 10 Hz (of a cycle of
//! the day at 0.2 Hz) with N = 1. For each cell: how often the truth lies in the 95 % intervals or below the limits, how often terms that
//! are not there are called identified, which courses were found, and how often their sizes and times are held.

use proofmass_noise::{
    CoefficientFit, CourseShape, FitOptions, FitRecord, NoiseModel, Term, Verdict, simulate,
    whittle_record,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::PI;

const SAMPLES: usize = 20_000;

/// What is added to the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Added {
    Nothing,
    /// Size in standard deviations of a sample, time constant in s.
    Exponential(f64, f64),
    /// Size, and where in the record.
    Step(f64, f64),
    Both,
    /// Amplitude.
    Day(f64),
    /// K_T, lag in s, whether the temperature is a walk.
    Lag(f64, f64, bool),
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    mixture: (&'static str, f64, f64),
    added: Added,
}

const MIXTURES: [(&str, f64, f64); 4] = [
    ("N", 0.0, 0.0),
    ("N+K30", 30.0, 0.0),
    ("N+B100", 0.0, 100.0),
    ("N+B100+K60", 60.0, 100.0),
];

fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut all = MIXTURES.to_vec();
    all.extend([
        ("N+K10", 10.0, 0.0),
        ("N+K100", 100.0, 0.0),
        ("N+K300", 300.0, 0.0),
        ("N+B300", 0.0, 300.0),
    ]);
    for mixture in all {
        cells.push(Cell {
            mixture,
            added: Added::Nothing,
        });
    }
    for added in [
        Added::Exponential(0.2, 120.0),
        Added::Exponential(2.0, 120.0),
        Added::Exponential(1.0, 20.0),
        Added::Exponential(1.0, 500.0),
        Added::Step(0.1, 0.37),
        Added::Step(0.5, 0.37),
        Added::Step(0.5, 0.9),
        Added::Both,
        Added::Day(0.0),
        Added::Day(0.3),
        Added::Lag(1.0, 0.0, false),
        Added::Lag(1.0, 10.0, false),
        Added::Lag(1.0, 60.0, false),
        Added::Lag(1.0, 400.0, false),
        Added::Lag(1.0, 1000.0, false),
        Added::Lag(1.0, 10.0, true),
        Added::Lag(1.0, 60.0, true),
        Added::Lag(1.0, 400.0, true),
        Added::Lag(1.0, 1000.0, true),
        Added::Lag(0.0, 0.0, false),
        Added::Lag(0.0, 0.0, true),
    ] {
        for mixture in MIXTURES {
            cells.push(Cell { mixture, added });
        }
    }
    cells
}

fn temperature(is_walk: bool, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    let phase = 2.0 * normal();
    let n = SAMPLES as f64;
    let mut walk = 0.0;
    (0..SAMPLES)
        .map(|i| {
            walk += normal() * (6.0 / n).sqrt();
            let slow = 2.0_f64.sqrt() * (2.0 * PI * 3.3 * i as f64 / n + phase).sin();
            20.0 + if is_walk { walk } else { slow }
        })
        .collect()
}

/// Names of what is counted.
const COUNTED: [&str; 17] = [
    "N held",
    "B",
    "K",
    "R",
    "K_T",
    "lag",
    "size",
    "time",
    "| id. B",
    "K",
    "R",
    "| exp",
    "step",
    "day",
    "lag found",
    "K_T open",
    "slow misfit",
];

fn held(verdict: Verdict, truth: f64) -> bool {
    match verdict.interval() {
        Some((low, high)) => low <= truth && truth <= high,
        None => verdict.upper().is_none_or(|u| truth.abs() <= u),
    }
}

fn examine(cell: &Cell, seed: u64) -> [f64; 17] {
    let rate: f64 = match cell.added {
        Added::Day(_) => 0.2,
        _ => 10.0,
    };
    let t = SAMPLES as f64 / rate;
    let (_, walk, flicker) = cell.mixture;
    let model = NoiseModel {
        white: 1.0,
        random_walk: 3.0_f64.sqrt() * walk / t,
        flicker: (flicker / (0.4413 * t)).sqrt(),
        ..Default::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut y = simulate(&model, SAMPLES, rate, &mut rng).expect("a legal model");
    let sigma = rate.sqrt();
    let mut beside: Option<Vec<f64>> = None;
    let mut add = |value: &dyn Fn(f64) -> f64| {
        for (i, y) in y.iter_mut().enumerate() {
            *y += value(i as f64 / rate);
        }
    };
    let mut truth = (0.0, 0.0);
    match cell.added {
        Added::Nothing => {}
        Added::Exponential(size, time) => {
            truth = (size * sigma, time);
            add(&|s| size * sigma * (-s / time).exp());
        }
        Added::Step(size, share) => {
            truth = (size * sigma, share * t);
            add(&|s| if s >= share * t { size * sigma } else { 0.0 });
        }
        Added::Both => {
            truth = (2.0 * sigma, 120.0);
            add(&|s| 2.0 * sigma * (-s / 120.0).exp());
            add(&|s| if s >= 0.6 * t { 0.7 * sigma } else { 0.0 });
        }
        Added::Day(amplitude) => {
            truth = (amplitude * sigma, 0.0);
            add(&|s| amplitude * sigma * (2.0 * PI * s / 86_400.0 + 1.0).sin());
        }
        Added::Lag(sensitivity, lag, is_walk) => {
            let mut course = temperature(is_walk, &mut rng);
            // The sensor was not yet at the temperature when the record began.
            let start: f64 = StandardNormal.sample(&mut rng);
            let mut inside = course[0] + if lag > 0.0 { 0.5 * start } else { 0.0 };
            for (y, c) in y.iter_mut().zip(&course) {
                inside = if lag > 0.0 {
                    c + (inside - c) * (-1.0 / (lag * rate)).exp()
                } else {
                    *c
                };
                *y += sensitivity * (inside - 20.0);
            }
            for c in &mut course {
                let normal: f64 = StandardNormal.sample(&mut rng);
                *c += 0.002 * normal;
            }
            beside = Some(course);
        }
    }
    let stretches = [&y[..]];
    let courses = beside.as_ref().map(|c| [&c[..]]);
    let record = FitRecord {
        temperature: courses.as_ref().map(|c| &c[..]),
        ..FitRecord::new(&stretches)
    };
    let fit = whittle_record(&record, rate, &FitOptions::default()).expect("a long record");
    let mut row = [f64::NAN; 17];
    let of = |b: bool| f64::from(u8::from(b));
    let truths = [
        (Term::White, model.white),
        (Term::Flicker, model.flicker),
        (Term::RandomWalk, model.random_walk),
        (Term::Ramp, 0.0),
    ];
    for (k, (term, truth)) in truths.into_iter().enumerate() {
        let verdict = fit.get(term).expect("sought").verdict;
        row[k] = of(held(verdict, truth));
        if std::env::var("SHOW").is_ok() && row[k] == 0.0 && term != Term::White {
            println!(
                "{seed:x} {term:?} truth {truth:.4} {verdict:?} T {:?} {:?}",
                fit.temperature.as_ref().map(|t| (t.lag, t.lag_interval)),
                fit.courses.iter().map(|c| c.shape).collect::<Vec<_>>()
            );
        }
        if k > 0 {
            row[7 + k] = of(verdict.is_identified());
        }
    }
    if let (Added::Lag(sensitivity, lag, _), Some(found)) = (cell.added, &fit.temperature) {
        row[4] = of(held(found.verdict, sensitivity));
        let (low, high) = found.lag_interval.expect("sought");
        if sensitivity > 0.0 {
            row[5] = of(low <= lag && high.is_none_or(|h| lag <= h));
        }
    }
    let is = |f: &CoefficientFit, k: usize| {
        f.courses.iter().any(|c| {
            k == match c.shape {
                CourseShape::Exponential { .. } => 0,
                CourseShape::Step { .. } => 1,
                _ => 2,
            }
        })
    };
    for k in 0..3 {
        row[11 + k] = of(is(&fit, k));
    }
    let kind = match cell.added {
        Added::Exponential(..) | Added::Both => 0,
        Added::Step(..) => 1,
        Added::Day(..) => 2,
        _ => 3,
    };
    let course = fit.courses.iter().find(|c| match c.shape {
        CourseShape::Exponential { .. } => kind == 0,
        CourseShape::Step { .. } => kind == 1,
        _ => kind == 2,
    });
    if let Some(course) = course {
        row[6] = of(held(course.size, truth.0));
        if let Some((low, high)) = course.interval {
            row[7] = of(low <= truth.1 && truth.1 <= high);
        }
    }
    let has = |code: &str| of(fit.findings.iter().any(|f| f.code() == code));
    row[14] = has("temperature-lag-found");
    row[15] = has("temperature-lag-open");
    row[16] = has("slow-noise-misfit");
    row
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<u64>().ok());
    let records = argument(1).unwrap_or(200);
    let first = argument(2).unwrap_or(0);
    let only = std::env::args().nth(3);
    println!("{records} records a cell, in %, of those to which it applies");
    println!("{:44}{}", "", COUNTED.join(" "));
    for (index, cell) in cells().iter().enumerate() {
        let name = format!("{}, {:?}", cell.mixture.0, cell.added);
        if only.as_deref().is_some_and(|o| !name.contains(o)) {
            continue;
        }
        let rows: Vec<[f64; 17]> = (0..records)
            .into_par_iter()
            .map(|k| examine(cell, (index as u64 + 300) << 32 | (first + k)))
            .collect();
        print!("{name:44}");
        for (k, counted) in COUNTED.iter().enumerate() {
            let values: Vec<f64> = rows.iter().map(|r| r[k]).filter(|v| !v.is_nan()).collect();
            let bar = if counted.starts_with('|') { " |" } else { "" };
            match values.len() {
                0 => print!("{bar}     -"),
                n => print!(
                    "{bar} {:5.1}",
                    100.0 * values.iter().sum::<f64>() / n as f64
                ),
            }
        }
        println!();
    }
}
