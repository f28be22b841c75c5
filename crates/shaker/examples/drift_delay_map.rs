//! Are drifts of a gain and delays of channels told that nobody declared, and how often without any?
//!
//! Prints the tables of docs/shaker.md: `cargo run -p proofmass-shaker --example drift_delay_map`. An argument sets the number of
//! campaigns per line (300).

use num_complex::Complex64;
use proofmass_rig::bench::BenchDevice;
use proofmass_shaker::{Fit, joint};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

#[path = "shaker_coverage.rs"]
#[allow(dead_code, reason = "the simulator of the coverage table")]
pub mod shaker_coverage;
use shaker_coverage::{CASES, Case, Gluings, Simulated};

/// Order of the runs of a frequency in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Wedge after wedge.
    Wedges,
    /// Mixed.
    Mixed,
}

/// The bench.
pub fn bench(gluings: Gluings) -> Case {
    Case {
        gluings,
        repeats: Some((10, 2e-4)),
        ..CASES[0]
    }
}

/// A campaign of which a gain (of one output, or of all) changes by `size` over the runs of each frequency.
pub fn drifting(
    gluings: Gluings,
    order: Order,
    output: Option<usize>,
    size: f64,
    seed: u64,
) -> Fit {
    let case = bench(gluings);
    let Simulated {
        mut rows, spurious, ..
    } = case.campaign(&[10.0, 160.0, 1000.0], seed);
    let n = rows.len() / 3;
    if order == Order::Mixed {
        // The same mixed order at all frequencies, as when each mounting is driven at all of them.
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x0DD5);
        let mut place: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            place.swap(i, (rng.random::<f64>() * (i + 1) as f64) as usize);
        }
        rows = (0..3 * n)
            .map(|i| rows[i - i % n + place[i % n]].clone())
            .collect();
    }
    for (i, row) in rows.iter_mut().enumerate() {
        let gain = 1.0 + size * ((i % n) as f64 / (n - 1) as f64 - 0.5);
        for j in (0..3).filter(|j| output.is_none_or(|k| k == *j)) {
            row.outputs[j] *= gain;
        }
    }
    joint(&rows, &spurious, &case.budget()).expect("sound runs")
}

/// Devices of which the axes differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// Piezoelectric: resonances of 2.5 to 10 kHz, Q of 15 to 50.
    Resonant,
    /// Micromachined: resonances of 1.2 to 5 kHz with ζ of 0.3 to 1, the axes within ±10 % of each other.
    Damped,
}

/// A campaign whose channels are read one after another: reference, x, y, z, each `step` later than the one before.
pub fn scanned(device: Device, frequencies: &[f64], step: f64, seed: u64) -> Fit {
    let case = bench(Gluings::Published);
    let Simulated {
        mut rows, spurious, ..
    } = case.campaign(frequencies, seed);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xDE1A);
    let mut even = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let usual = BenchDevice::default();
    let axes: [(f64, f64); 3] = match device {
        Device::Resonant => [(); 3].map(|()| (even(2.5e3, 1e4), even(15.0, 50.0))),
        Device::Damped => {
            let (f, damping) = (even(1.2e3, 5e3), even(0.3, 1.0));
            [(); 3].map(|()| (f * even(0.9, 1.1), 0.5 / (damping * even(0.9, 1.1))))
        }
    };
    for row in &mut rows {
        let response = |f0: f64, q: f64| {
            let x = row.frequency / f0;
            Complex64::new(1.0 - x * x, x / q).inv()
        };
        for (j, (f0, q)) in axes.into_iter().enumerate() {
            let late = -std::f64::consts::TAU * row.frequency * step * (j + 1) as f64;
            let other = response(f0, q) / response(usual.resonance[j], usual.quality);
            row.outputs[j] *= other * Complex64::from_polar(1.0, late);
        }
    }
    joint(&rows, &spurious, &case.budget()).expect("sound runs")
}

/// Whether a finding is among those of a fit.
pub fn told(fit: &Fit, code: &str) -> bool {
    fit.findings.iter().any(|f| f.code() == code)
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let campaigns: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(300);
    let many = |one: &(dyn Fn(u64) -> Fit + Sync)| -> Vec<Fit> {
        (0..campaigns)
            .into_par_iter()
            .map(|s| one(200_000 + s))
            .collect()
    };
    let share = |fits: &[Fit], code: &str| {
        let n = fits.iter().filter(|f| told(f, code)).count();
        format!("{:.1}", 100.0 * n as f64 / fits.len() as f64)
    };
    println!("| drift of | mountings, order | U / % | none | 1 U | 2 U | 2.5 U |");
    println!("|{}", "---|".repeat(7));
    for (gluings, order) in [
        (Gluings::Published, Order::Wedges),
        (Gluings::Published, Order::Mixed),
        (Gluings::Twelve, Order::Wedges),
        (Gluings::Twelve, Order::Mixed),
    ] {
        let healthy = many(&|seed| drifting(gluings, order, None, 0.0, seed));
        for output in [None, Some(0)] {
            let u = |f: &Fit| {
                let own = |d: &&proofmass_shaker::GainDrift| d.each_frequency && d.output == output;
                f.drifts
                    .iter()
                    .find(own)
                    .map_or(0.0, |d| d.standard_uncertainty)
            };
            let expanded = 1.96 * healthy.iter().map(u).sum::<f64>() / healthy.len() as f64;
            let sizes = [1.0, 2.0, 2.5].map(|times| {
                let fits = many(&|seed| drifting(gluings, order, output, times * expanded, seed));
                share(&fits, "gain-drift")
            });
            println!(
                "| {} | {gluings:?}, {order:?} | {:.3} | {} | {} |",
                output.map_or("the reference", |_| "output x"),
                100.0 * expanded,
                share(&healthy, "gain-drift"),
                sizes.join(" | ")
            );
        }
    }
    println!(
        "\n| device | frequencies | step / µs | told / % | z after x / µs, U, explained by the device |"
    );
    println!("|{}", "---|".repeat(5));
    let six = [10.0, 40.0, 80.0, 160.0, 400.0, 1000.0];
    for device in [Device::Resonant, Device::Damped] {
        for frequencies in [&[10.0, 160.0, 1000.0][..], &six] {
            for step in [0.0, 2.0, 5.0, 20.0, 50.0] {
                let fits = many(&|seed| scanned(device, frequencies, 1e-6 * step, seed));
                let mut sums = [0.0; 3];
                for fit in &fits {
                    let pair = fit.delays.iter().find(|d| d.outputs == [2, 0]);
                    if let Some(d) = pair {
                        let numbers = [d.value, 1.96 * d.standard_uncertainty, d.allowed];
                        (0..3).for_each(|k| sums[k] += 1e6 * numbers[k] / fits.len() as f64);
                    }
                }
                println!(
                    "| {device:?} | {} | {step} | {} | {:.2}, {:.2}, {:.2} |",
                    frequencies.len(),
                    share(&fits, "channel-delays"),
                    sums[0],
                    sums[1],
                    sums[2]
                );
            }
        }
    }
}
