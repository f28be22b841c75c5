//! Sine approximation of four channels of 2²⁰ samples beside numpy, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy. The peer
//! solves for three parameters only, with its basis made beforehand; ours makes its own sines and gives the residuals,
//! and the covariance from the noise beside the drive as well.

mod peer;
mod processor;

use peer::{Peers, best};
use processor::processor_time;
use proofmass_signal::sine::{Frequency, SineApproximation};
use std::f64::consts::TAU;

const SAMPLES: usize = 1 << 20;
const OMEGA: f64 = 0.0123;

/// Noise that looks normal enough: the sum of a few shuffled bits.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (0..4)
            .map(|k| f64::from((state >> (16 * k)) as u16) / 65_536.0 - 0.5)
            .sum::<f64>()
            * 3f64.sqrt()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peers = Peers::run("sine_peer.py", &[])?;
    let channels: Vec<Vec<f64>> = (1..=4)
        .map(|seed| {
            let mut noise = noise(seed * 0x9e37_79b9);
            (0..SAMPLES)
                .map(|i| (OMEGA * i as f64 + 0.2).cos() + 1e-3 * noise())
                .collect()
        })
        .collect();
    let views: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    println!("sine approximation, 4 channels of 2²⁰ samples");
    let (theirs, modulus) = peers.get("least_squares")?;
    let (normal, _) = peers.get("normal_equations")?;
    println!(
        "  numpy, least squares      {:8.2} ms              |X| = {modulus:.7}",
        1e3 * theirs
    );
    println!("  numpy, normal equations   {:8.2} ms", 1e3 * normal);
    let all = std::thread::available_parallelism()?.get();
    for (name, frequency) in [
        ("known frequency", Frequency::Known),
        ("common frequency", Frequency::Common),
    ] {
        let sine = SineApproximation::new(OMEGA / TAU).frequency(frequency);
        for threads in [1, all] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?;
            let mut modulus = f64::NAN;
            let ours = best(20, || {
                modulus = pool
                    .install(|| sine.fit(1.0, &views))
                    .map_or(f64::NAN, |fit| fit.channels[0].modulus());
            });
            println!(
                "  {name:16}, {threads} thr.  {:8.2} ms   {:6.1} ×   |X| = {modulus:.7}",
                1e3 * ours,
                theirs / ours
            );
        }
    }
    let sine = SineApproximation::new(OMEGA / TAU);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let fit = || {
        std::hint::black_box(pool.install(|| sine.fit(1.0, &views)).is_ok());
    };
    if let Some(ours) = processor_time(100, fit) {
        let (theirs, _) = peers.get("least_squares_processor")?;
        println!(
            "  processor time, known frequency: numpy {:.2} ms, ours {:.2} ms   {:.1} ×",
            1e3 * theirs,
            1e3 * ours,
            theirs / ours
        );
    }
    Ok(())
}
