//! Slow counted axes: the tuned filter against an exact one, of forty thousand particles that know noise and offset.
//!
//!     cargo run --release -p proofmass-motion --example particle_reference -- [SEEDS]
//!
//! A count says between which edges the axis is and no more; particles outside die. Prints the table of docs/velocity.md.

#[path = "../tests/motions/mod.rs"]
mod motions;

use motions::{Motion, creeping, sine};
use proofmass_core::Unwatched;
use proofmass_motion::{MotionRecord, ReadingSource, estimate};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{PI, TAU};

const DT: f64 = 1e-3;
const INCREMENT: f64 = 1.57e-4;
const NOISE: f64 = 0.02;
const OFFSET: f64 = 0.03;
const PARTICLES: usize = 40_000;
/// Samples that are not judged.
const SKIP: usize = 2000;

/// A speed of so many samples per count that swings.
fn counting(samples: f64) -> Motion {
    creeping(INCREMENT / (samples * DT))
}

/// Moves of sin² out and back with rests as long between them.
fn stop_and_go(speed: f64, time: f64) -> Motion {
    let hop = move |t: f64| -> [f64; 3] {
        let s = t.clamp(0.0, time);
        let phase = TAU * s / time;
        let a = if s == t {
            PI * speed / time * phase.sin()
        } else {
            0.0
        };
        [
            0.5 * speed * (s - time / TAU * phase.sin()),
            0.5 * speed * (1.0 - phase.cos()),
            a,
        ]
    };
    Box::new(move |t| {
        let s = t.rem_euclid(4.0 * time);
        let (out, back) = (hop(s), hop(s - 2.0 * time));
        std::array::from_fn(|i| out[i] - back[i])
    })
}

struct Axis {
    counts: Vec<f64>,
    acceleration: Vec<f64>,
    truth: Vec<f64>,
}

fn simulate(motion: &Motion, seed: u64) -> Axis {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let phase: f64 = rng.random();
    let (mut counts, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..12_000 {
        let [x, v, a] = motion(DT * f64::from(k));
        let e: f64 = StandardNormal.sample(&mut rng);
        counts.push((x / INCREMENT + phase).floor());
        acceleration.push(a + OFFSET + NOISE * e);
        truth.push(v);
    }
    Axis {
        counts,
        acceleration,
        truth,
    }
}

/// Mean velocity of the particles after each sample, and the samples at which none was left.
fn particles(axis: &Axis, seed: u64) -> (Vec<f64>, usize) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5151);
    let mut cloud: Vec<[f64; 2]> = (0..PARTICLES)
        .map(|_| {
            let e: f64 = StandardNormal.sample(&mut rng);
            let x = (axis.counts[0] + rng.random::<f64>()) * INCREMENT;
            [x, axis.truth[0] + 0.002 * e]
        })
        .collect();
    let mut mean = vec![axis.truth[0]];
    let mut lost = 0;
    for k in 1..axis.counts.len() {
        let a = [k - 1, k].map(|i| axis.acceleration[i] - OFFSET);
        for [x, v] in &mut cloud {
            let e: f64 = StandardNormal.sample(&mut rng);
            let noise = NOISE * e;
            *x += DT * *v + DT * DT * (a[0] / 3.0 + a[1] / 6.0 + 0.5 * noise);
            *v += DT * (0.5 * (a[0] + a[1]) + noise);
        }
        let cell = axis.counts[k];
        let mut alive: Vec<[f64; 2]> = cloud
            .iter()
            .filter(|p| (p[0] / INCREMENT).floor() == cell)
            .copied()
            .collect();
        if alive.is_empty() {
            lost += 1;
            for p in &mut cloud {
                p[0] = p[0].clamp(cell * INCREMENT, (cell + 1.0) * INCREMENT);
            }
            alive.clone_from(&cloud);
        }
        mean.push(alive.iter().map(|p| p[1]).sum::<f64>() / alive.len() as f64);
        // The dead are replaced by copies of the living, in turn; the noise parts them again.
        let n = alive.len();
        for i in n..PARTICLES {
            alive.push(alive[i % n]);
        }
        cloud = alive;
    }
    (mean, lost)
}

fn square(v: &[f64], truth: &[f64]) -> f64 {
    let n = (truth.len() - SKIP) as f64;
    (SKIP..truth.len())
        .map(|k| (v[k] - truth[k]).powi(2) / n)
        .sum()
}

fn main() {
    let seeds: u64 = std::env::args()
        .nth(1)
        .and_then(|n| n.parse().ok())
        .unwrap_or(4);
    let cases: [(&str, Motion); 9] = [
        ("5 samples per count", counting(5.0)),
        ("20", counting(20.0)),
        ("50", counting(50.0)),
        ("100", counting(100.0)),
        ("200", counting(200.0)),
        ("sine of 1 Hz, 10 mm/s", sine(10e-3 / TAU, 1.0)),
        ("dither of 0.3 counts, 7 Hz", sine(0.3 * INCREMENT, 7.0)),
        ("dither of 0.7 counts, 7 Hz", sine(0.7 * INCREMENT, 7.0)),
        ("stop and go, 20 mm/s", stop_and_go(0.02, 0.5)),
    ];
    println!("| axis | exact, mm/s | tuned, mm/s | ratio | samples without particles |");
    println!("|---|---|---|---|---|");
    for (name, motion) in cases {
        let (mut exact, mut tuned, mut lost) = (0.0, 0.0, 0);
        for seed in 0..seeds {
            let axis = simulate(&motion, 500 + seed);
            let (mean, none) = particles(&axis, seed);
            exact += square(&mean, &axis.truth) / seeds as f64;
            lost += none;
            let reading = axis.counts.iter().map(|c| Some((c + 0.5) * INCREMENT));
            let mut record = MotionRecord::new(
                DT,
                ReadingSource::Position,
                reading.collect(),
                axis.acceleration.clone(),
            )
            .expect("a record");
            record.increment = Some(INCREMENT);
            let result = estimate(&record, None, None, &Unwatched).expect("an estimate");
            tuned += square(&result.trace.velocity, &axis.truth) / seeds as f64;
        }
        println!(
            "| {name} | {:.3} | {:.3} | {:.3} | {lost} |",
            1e3 * exact.sqrt(),
            1e3 * tuned.sqrt(),
            (tuned / exact).sqrt()
        );
    }
}
