//! How often the resonances of a response to noise are found, without a model, and how often their 95 % intervals hold; how many are found
//! where there is none.
//!
//! `cargo run --release -p proofmass-dynamic --example resonance_coverage [runs]` makes the table of `docs/dynamic-tests.md`.

use num_complex::Complex64;
use proofmass_core::Unwatched;
use proofmass_dynamic::model::{Mode, TransducerModel};
use proofmass_dynamic::modes::{Resonance, resonances};
use proofmass_signal::transfer::{CrossSpectra, Estimator};
use proofmass_signal::{Welch, fourier};
use proofmass_uncertainty::student_quantile;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const SAMPLES: usize = 200_000;
const RATE: f64 = 10_000.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(20), |a| a.parse())?;
    let one = |damping: f64| {
        vec![Mode {
            frequency: 900.0,
            damping,
            share: 1.0,
        }]
    };
    let two = |apart: f64, dampings: [f64; 2]| {
        let mut modes = one(dampings[0]);
        modes[0].share = 0.6;
        modes.push(Mode {
            frequency: 900.0 * apart,
            damping: dampings[1],
            share: 0.4,
        });
        modes
    };
    let mut devices: Vec<(String, Vec<Mode>)> = [0.002, 0.005, 0.02, 0.05, 0.1, 0.2, 0.3]
        .into_iter()
        .map(|zeta| (format!("{zeta}"), one(zeta)))
        .collect();
    devices.push(("0.01, 0.01".into(), two(1.3, [0.01, 0.01])));
    devices.push(("0.05, 0.03".into(), two(1.8, [0.05, 0.03])));
    println!(
        "| ζ | segment | noise | found | f held | ζ held | U of ζ in % | others |\n|---|---|---|---|---|---|---|---|"
    );
    for (name, modes) in &devices {
        for segment in [1024, 2048, 8192, 32_768] {
            for noise in [0.05, 0.5] {
                let mut count = [0usize; 4];
                let mut wide = 0.0;
                for seed in 0..runs {
                    let found = listed(modes, segment, noise, seed)?;
                    count[3] += found.len();
                    for mode in modes {
                        let near = |r: &&Resonance| {
                            (r.frequency / mode.frequency - 1.0).abs() < mode.damping.max(0.02)
                        };
                        let Some(r) = found.iter().find(near) else {
                            continue;
                        };
                        count[3] -= 1;
                        count[0] += 1;
                        let t = student_quantile(0.975, r.freedom);
                        let held = |d: f64, u: f64| usize::from(d.abs() <= t * u);
                        count[1] += held(r.frequency - mode.frequency, r.frequency_uncertainty);
                        count[2] += held(r.damping - mode.damping, r.damping_uncertainty);
                        wide += t * r.damping_uncertainty / mode.damping;
                    }
                }
                let share = |n: usize, of: usize| 100.0 * n as f64 / of.max(1) as f64;
                println!(
                    "| {name} | {segment} | {noise} | {:.1} | {:.1} | {:.1} | {:.2} | {} |",
                    share(count[0], runs as usize * modes.len()),
                    share(count[1], count[0]),
                    share(count[2], count[0]),
                    100.0 * wide / count[0].max(1) as f64,
                    count[3]
                );
            }
        }
    }
    println!(
        "\n| flat response: segment | noise | records | records with a resonance |\n|---|---|---|---|"
    );
    for segment in [1024, 2048, 8192, 32_768] {
        for noise in [0.05, 1.0] {
            let mut found = 0;
            for seed in 0..10 * runs {
                found += usize::from(!listed(&[], segment, noise, 10_000 + seed)?.is_empty());
            }
            println!("| {segment} | {noise} | {} | {found} |", 10 * runs);
        }
    }
    Ok(())
}

/// What is listed of white noise through the device, periodic over a record twice as long, and white noise of the output.
fn listed(
    modes: &[Mode],
    segment: usize,
    noise: f64,
    seed: u64,
) -> Result<Vec<Resonance>, Box<dyn std::error::Error>> {
    let device = TransducerModel {
        modes: modes.to_vec(),
        ..TransducerModel::flat(1.0)
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let x: Vec<f64> = (0..2 * SAMPLES).map(|_| normal()).collect();
    let line = RATE / x.len() as f64;
    let spectrum: Vec<Complex64> = fourier::forward(&x)
        .iter()
        .enumerate()
        .map(|(k, v)| v * device.response(k as f64 * line))
        .collect();
    let y = fourier::inverse(spectrum, x.len()).ok_or("no inverse")?;
    let y: Vec<f64> = y[..SAMPLES].iter().map(|v| v + noise * normal()).collect();
    let welch = Welch::new(segment);
    let spectra = CrossSpectra::welch(&x[..SAMPLES], &[&y], RATE, &welch, &Unwatched)?;
    let response = spectra.response(0, Estimator::H1)?;
    let low = (2.0 * RATE / segment as f64).max(10.0);
    let smearing = spectra.smearing(Estimator::H1);
    Ok(resonances(&response, Some(&smearing), low, 4900.0))
}
