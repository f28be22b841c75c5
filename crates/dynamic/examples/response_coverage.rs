//! How often the 95 % intervals of a frequency response, and of the sensitivity, natural frequency and damping fitted to it, hold
//! the truth, with noise on the output, on the input and on both, from wide resonances to those narrower than a line.
//!
//! `cargo run --release -p proofmass-dynamic --example response_coverage [runs]` makes the table of `docs/dynamic-tests.md`.

use num_complex::Complex64;
use proofmass_core::Unwatched;
use proofmass_dynamic::model::{FitProblem, Mode, ModelStructure, ResponsePoints, TransducerModel};
use proofmass_signal::transfer::{CrossSpectra, Estimator};
use proofmass_signal::{Welch, fourier};
use proofmass_uncertainty::student_quantile;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const SAMPLES: usize = 1 << 16;
const SEGMENT: usize = 2048;
const RATE: f64 = 10_000.0;

struct Case {
    name: &'static str,
    estimator: Estimator,
    /// Noise of a sample of input and output; the input itself has one.
    noise: [f64; 2],
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(1000), |a| a.parse())?;
    let cases = [
        Case {
            name: "output, h1",
            estimator: Estimator::H1,
            noise: [0.0, 0.3],
        },
        Case {
            name: "input, h2",
            estimator: Estimator::H2,
            noise: [0.2, 0.0],
        },
        Case {
            name: "both, hv",
            estimator: Estimator::Hv { noise_ratio: 4.0 },
            noise: [0.1, 0.2],
        },
    ];
    println!(
        "| noise, estimator | samples to a period | ζ | lines to the width | lines | S₀ | f_n | ζ | doubted |\n|---|---|---|---|---|---|---|---|---|"
    );
    for case in &cases {
        for (period, damping) in [(10.0, 0.05), (10.0, 0.01), (10.0, 0.004), (50.0, 0.02)] {
            let device = TransducerModel {
                modes: vec![Mode {
                    frequency: RATE / period,
                    damping,
                    share: 1.0,
                }],
                ..TransducerModel::flat(2.0)
            };
            let mode = device.modes[0];
            let truth = [2.0, mode.frequency, mode.damping];
            let (mut points_inside, mut points) = (0, 0);
            let (mut inside, mut doubted, mut failed) = ([0; 3], 0, 0);
            for seed in 0..runs {
                let (x, y) = record(&device, case.noise, seed);
                let spectra =
                    CrossSpectra::welch(&x, &[&y], RATE, &Welch::new(SEGMENT), &Unwatched)?;
                let band = [0.2 * mode.frequency, 2.0 * mode.frequency];
                let response = spectra
                    .response(0, case.estimator)?
                    .within(band[0], band[1]);
                for k in (0..response.lines()).step_by(3) {
                    let t = student_quantile(0.975, response.dof[k]);
                    let d = response.value[k] - device.response(response.frequency[k]);
                    for (d, v) in [
                        (d.re, response.covariance[k][0]),
                        (d.im, response.covariance[k][2]),
                    ] {
                        points += 1;
                        points_inside += usize::from(d.abs() <= t * v.sqrt());
                    }
                }
                let seen = ResponsePoints::of(&response, "1")
                    .seen_through(&response, spectra.smearing(case.estimator));
                match FitProblem::new(ModelStructure::default()).fit(&seen) {
                    Ok(fit) => {
                        for ((count, q), t) in
                            inside.iter_mut().zip(fit.estimate.quantities()).zip(truth)
                        {
                            *count += usize::from((q.value - t).abs() <= q.expanded(0.95));
                        }
                        doubted += usize::from(
                            fit.findings
                                .iter()
                                .any(|f| f.code() == "model-does-not-describe"),
                        );
                    }
                    Err(_) => failed += 1,
                }
            }
            let share = |count: usize, of: usize| 100.0 * count as f64 / of.max(1) as f64;
            let n = runs as usize;
            println!(
                "| {} | {period} | {damping} | {:.1} | {:.1} % | {:.1} % | {:.1} % | {:.1} % | {:.1} %{} |",
                case.name,
                2.0 * damping * mode.frequency / (RATE / SEGMENT as f64),
                share(points_inside, points),
                share(inside[0], n),
                share(inside[1], n),
                share(inside[2], n),
                share(doubted, n),
                if failed > 0 {
                    format!(", {failed} not fitted")
                } else {
                    String::new()
                }
            );
        }
    }
    Ok(())
}

/// White noise through the device, periodic over a record twice as long, and noise on both.
fn record(device: &TransducerModel, noise: [f64; 2], seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let x: Vec<f64> = (0..2 * SAMPLES).map(|_| normal()).collect();
    let line = RATE / x.len() as f64;
    let spectrum: Vec<Complex64> = fourier::forward(&x)
        .iter()
        .enumerate()
        .map(|(k, v)| v * device.response(k as f64 * line))
        .collect();
    let y = fourier::inverse(spectrum, x.len()).unwrap_or_default();
    let mut noisy = |signal: &[f64], amplitude: f64| -> Vec<f64> {
        signal[..SAMPLES]
            .iter()
            .map(|v| v + amplitude * normal())
            .collect()
    };
    (noisy(&x, noise[0]), noisy(&y, noise[1]))
}
