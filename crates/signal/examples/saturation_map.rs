//! Which records are said to be cut off, and which not, over waveforms, converters, levels and noise behind the limit.
//!
//! `cargo run --release -p proofmass-signal --example saturation_map [records]` makes the tables of `docs/dynamic-tests.md`.

use proofmass_signal::saturation::rails;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

type Rng256 = Xoshiro256PlusPlus;
type Waveform = fn(&mut Rng256) -> Vec<f64>;

const SAMPLES: usize = 20_000;
const WAVEFORMS: [(&str, Waveform); 12] = [
    ("white noise", white),
    ("narrow-band random, Q = 20", narrow),
    ("sine", sine),
    ("logarithmic sweep", sweep),
    ("five sines", sines),
    ("twenty impacts", impacts),
    ("half-sine", half_sine),
    ("twelve attitudes", attitudes),
    ("six attitudes", six_attitudes),
    ("six attitudes, five times", thirty_attitudes),
    ("one turn", one_turn),
    ("step", step),
];
const BITS: [Option<u32>; 4] = [None, Some(16), Some(12), Some(8)];

fn normal(rng: &mut Rng256) -> f64 {
    StandardNormal.sample(rng)
}

fn white(rng: &mut Rng256) -> Vec<f64> {
    (0..SAMPLES).map(|_| normal(rng)).collect()
}

/// A resonance of twenty samples a period, driven by white noise.
fn ringing(rng: &mut Rng256, drive: impl Fn(usize, &mut Rng256) -> f64) -> Vec<f64> {
    let (period, quality) = (rng.random_range(15.0..25.0), 20.0);
    let w = TAU / period;
    let decay = (-0.5 * w / quality).exp();
    let (a, b) = (2.0 * decay * w.cos(), -decay * decay);
    let mut y = vec![0.0; SAMPLES];
    for i in 2..SAMPLES {
        y[i] = a * y[i - 1] + b * y[i - 2] + drive(i, rng);
    }
    y
}

fn narrow(rng: &mut Rng256) -> Vec<f64> {
    ringing(rng, |_, rng| normal(rng))
}

fn impacts(rng: &mut Rng256) -> Vec<f64> {
    ringing(rng, |i, rng| match i % (SAMPLES / 20) {
        100 => rng.random_range(0.5..1.5),
        _ => 0.0,
    })
}

fn tone(rng: &mut Rng256, amplitude: f64) -> impl Fn(f64) -> f64 + use<> {
    let (f, phase) = (rng.random_range(0.001..0.1), rng.random_range(0.0..TAU));
    move |t| amplitude * (TAU * f * t + phase).sin()
}

fn sine(rng: &mut Rng256) -> Vec<f64> {
    let y = tone(rng, 1.0);
    (0..SAMPLES).map(|i| y(i as f64)).collect()
}

fn sines(rng: &mut Rng256) -> Vec<f64> {
    let tones: Vec<_> = (0..5).map(|_| tone(rng, 1.0)).collect();
    let at = |i: usize| tones.iter().map(|y| y(i as f64)).sum();
    (0..SAMPLES).map(at).collect()
}

fn sweep(rng: &mut Rng256) -> Vec<f64> {
    let (from, octaves) = (rng.random_range(0.001..0.01), 4.0);
    let n = SAMPLES as f64;
    let at = |i: usize| {
        let rate = octaves * 2f64.ln() / n;
        (TAU * from / rate * (rate * i as f64).exp()).sin()
    };
    (0..SAMPLES).map(at).collect()
}

fn half_sine(rng: &mut Rng256) -> Vec<f64> {
    let (length, at) = (
        rng.random_range(20.0..200.0),
        rng.random_range(500.0..1500.0),
    );
    let pulse = |i: usize| {
        let t = (i as f64 - at) / length;
        match (0.0..1.0).contains(&t) {
            true => (0.5 * TAU * t).sin(),
            false => 0.0,
        }
    };
    (0..2500).map(pulse).collect()
}

/// Rests at these levels, with a turn of half a second between them.
fn rests(levels: &[f64], rng: &mut Rng256) -> Vec<f64> {
    let mut last = levels[0];
    let mut all = Vec::new();
    for &level in levels {
        let hold = rng.random_range(300..900);
        all.extend((0..50).map(|i| last + (level - last) * f64::from(i) / 50.0));
        all.extend(std::iter::repeat_n(level, hold));
        last = level;
    }
    all
}

/// Twelve rests, some of them alike.
fn attitudes(rng: &mut Rng256) -> Vec<f64> {
    rests(
        &[
            1.0, 1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.7, 0.7, -0.7, -0.7,
        ],
        rng,
    )
}

/// One axis on six sides in turn, whichever comes first.
fn six_attitudes(rng: &mut Rng256) -> Vec<f64> {
    let mut levels = [1.0, 0.0, -1.0, 0.0, 0.0, 0.0];
    levels.shuffle(rng);
    rests(&levels, rng)
}

fn thirty_attitudes(rng: &mut Rng256) -> Vec<f64> {
    (0..5).flat_map(|_| six_attitudes(rng)).collect()
}

/// From one side to another, once.
fn one_turn(rng: &mut Rng256) -> Vec<f64> {
    let mut levels = [0.0, 1.0];
    levels.shuffle(rng);
    rests(&levels, rng)
}

/// A step with the transients of a sensor of second order, the rest before it shorter or longer than what follows.
fn step(rng: &mut Rng256) -> Vec<f64> {
    let (period, damping) = (rng.random_range(5.0..50.0), rng.random_range(0.05..1.0f64));
    let (at, sign) = (
        rng.random_range(300..5000),
        if rng.random_bool(0.5) { 1.0 } else { -1.0 },
    );
    let (w, root) = (TAU / period, (1.0 - damping * damping).sqrt());
    let after = |i: i32| {
        let t = f64::from((i - at).max(0)) * w;
        1.0 - (-damping * t).exp() * ((root * t).cos() + damping / root * (root * t).sin())
    };
    (0..6000).map(|i| sign * after(i)).collect()
}

/// What an amplifier with a limit on each side, noise behind it, and a converter make of a record; noise in parts of the peak.
fn record(
    mut y: Vec<f64>,
    rng: &mut Rng256,
    limits: [f64; 2],
    noise: f64,
    bits: Option<u32>,
) -> Vec<f64> {
    let peak = y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let step = bits.map(|b| 2.5 * peak / f64::from(1u32 << b));
    for v in &mut y {
        *v = v.clamp(-limits[0] * peak, limits[1] * peak) + noise * peak * normal(rng);
        if let Some(step) = step {
            *v = (*v / step).round() * step;
        }
    }
    y
}

/// Share of the records with a rail, in per cent.
fn found(count: u64, seed: u64, make: impl Fn(&mut Rng256) -> (Vec<f64>, usize)) -> f64 {
    let hit = |k: &u64| {
        let mut rng = Rng256::seed_from_u64(seed + k);
        let (values, wanted) = make(&mut rng);
        rails(&values).len() >= wanted
    };
    100.0 * (0..count).filter(hit).count() as f64 / count as f64
}

fn main() {
    let count: u64 = std::env::args()
        .nth(1)
        .map_or(200, |a| a.parse().expect("a number"));
    let bits = |b: Option<u32>| b.map_or("fine".to_owned(), |b| format!("{b} bit"));
    println!(
        "| healthy; noise of 0, 1e-4 and 1e-2 of the peak | {} |",
        BITS.map(bits).join(" | ")
    );
    println!("|---|---|---|---|---|");
    for (name, waveform) in WAVEFORMS {
        let cells = BITS.map(|bits| {
            let share = |noise: f64| {
                found(count, 1, |rng| {
                    (record(waveform(rng), rng, [2.0, 2.0], noise, bits), 1)
                })
            };
            let shares = [0.0, 1e-4, 1e-2].map(share);
            format!("{:.2}", shares.iter().sum::<f64>() / 3.0)
        });
        println!("| {name} | {} |", cells.join(" | "));
    }
    println!(
        "\n| cut off at, noise behind the limit | {} |",
        BITS.map(bits).join(" | ")
    );
    println!("|---|---|---|---|---|");
    for (name, waveform) in &WAVEFORMS[..7] {
        // Noise by its standard deviation, the rest by the largest value.
        let random = *name == "white noise" || name.starts_with("narrow");
        let levels = if random {
            [3.0, 2.5, 2.0]
        } else {
            [0.98, 0.95, 0.8]
        };
        for level in levels {
            for noise in [0.0, 1e-3] {
                let cells = BITS.map(|bits| {
                    let share = |both: bool| {
                        found(count, 1, |rng| {
                            let y = waveform(rng);
                            let most = y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                            let top = y.iter().copied().fold(0.0f64, f64::max) / most;
                            let square = y.iter().map(|v| v * v).sum::<f64>() / y.len() as f64;
                            let at = level * if random { square.sqrt() / most } else { top };
                            let limits = [if both { at } else { 2.0 }, at];
                            (record(y, rng, limits, noise, bits), 1 + usize::from(both))
                        })
                    };
                    // A shock has one top.
                    match *name {
                        "half-sine" => format!("{:.0}", share(false)),
                        _ => format!("{:.0}, {:.0}", share(false), share(true)),
                    }
                });
                let unit = if random { " σ" } else { " of the peak" };
                let behind = match noise > 0.0 {
                    true => noise.to_string(),
                    false => "none".to_owned(),
                };
                println!(
                    "| {name}, {level}{unit}, {behind} | {} |",
                    cells.join(" | ")
                );
            }
        }
    }
}
