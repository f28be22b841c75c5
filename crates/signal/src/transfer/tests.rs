use super::*;
use crate::{Welch, Window};
use proofmass_core::Unwatched;
use proofmass_uncertainty::student_quantile;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const RATE: f64 = 1000.0;

fn white(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
}

/// y_n = x_n + 1.2 y_{n−1} − 0.6 y_{n−2}: a resonance near 110 Hz, 81 Hz wide.
fn filter(x: &[f64]) -> Vec<f64> {
    let (mut a, mut b) = (0.0, 0.0);
    x.iter()
        .map(|x| {
            let y = x + 1.2 * a - 0.6 * b;
            (b, a) = (a, y);
            y
        })
        .collect()
}

fn truth(f: f64) -> Complex64 {
    let z = Complex64::from_polar(1.0, -TAU * f / RATE);
    1.0 / (1.0 - 1.2 * z + 0.6 * z * z)
}

/// Share of 95 % intervals of real and imaginary parts that hold the truth, over lines and runs.
fn coverage(estimate: impl Fn(u64) -> ResponseEstimate, runs: u64) -> (f64, usize) {
    let (mut inside, mut count) = (0, 0);
    for seed in 0..runs {
        let e = estimate(seed);
        // Every third line: neighbours share a Hann window.
        for k in (3..e.frequency.len() - 3).step_by(3) {
            let t = student_quantile(0.975, e.dof[k]);
            let d = e.value[k] - truth(e.frequency[k]);
            for (d, v) in [(d.re, e.covariance[k][0]), (d.im, e.covariance[k][2])] {
                count += 1;
                inside += usize::from(d.abs() <= t * v.sqrt());
            }
        }
    }
    (inside as f64 / count as f64, count)
}

/// Three standard deviations of a binomial share to either side of 95 %; above it 1.5 % more, since the second difference
/// that stands for the leakage holds noise of its own.
fn assert_covers((share, count): (f64, usize)) {
    let s = (0.95 * 0.05 / count as f64).sqrt();
    assert!(
        share > 0.95 - 3.0 * s && share < 0.965 + 3.0 * s,
        "{share} of {count}"
    );
}

fn welch(x: &[f64], y: &[f64], estimator: Estimator) -> ResponseEstimate {
    CrossSpectra::welch(x, &[y], RATE, &Welch::new(256), &Unwatched)
        .unwrap()
        .response(0, estimator)
        .unwrap()
}

fn noisy(x: &[f64], amplitude: f64, seed: u64) -> Vec<f64> {
    x.iter()
        .zip(white(x.len(), seed))
        .map(|(x, n)| x + amplitude * n)
        .collect()
}

#[test]
fn coverage_frf_noise_on_output() {
    assert_covers(coverage(
        |seed| {
            let x = white(8192, seed);
            welch(&x, &noisy(&filter(&x), 0.7, seed + 9000), Estimator::H1)
        },
        40,
    ));
}

#[test]
fn coverage_frf_noise_on_input() {
    assert_covers(coverage(
        |seed| {
            let x = white(8192, seed);
            welch(&noisy(&x, 0.3, seed + 9000), &filter(&x), Estimator::H2)
        },
        40,
    ));
}

#[test]
fn coverage_frf_noise_on_both() {
    assert_covers(coverage(
        |seed| {
            let x = white(8192, seed);
            let y = noisy(&filter(&x), 0.6, seed + 7000);
            welch(
                &noisy(&x, 0.3, seed + 9000),
                &y,
                Estimator::Hv { noise_ratio: 4.0 },
            )
        },
        40,
    ));
}

#[test]
fn coverage_frf_local_polynomial_of_a_sweep() {
    assert_covers(coverage(
        |seed| {
            // 5 Hz to 400 Hz in 16 s.
            let n = 16_384;
            let x: Vec<f64> = (0..n)
                .map(|k| f64::from(k) / RATE)
                .map(|t| (TAU * (5.0 * t + 0.5 * 395.0 / 16.384 * t * t)).sin())
                .collect();
            let y = noisy(&filter(&x), 0.3, seed);
            let method = LocalPolynomial {
                band: [10.0, 380.0],
                ..LocalPolynomial::default()
            };
            method.estimate(&x, &y, RATE, &Unwatched).unwrap()
        },
        12,
    ));
}

#[test]
fn law_bias_of_h1_and_h2_by_the_noise_they_do_not_allow_for() {
    let x = white(200_000, 1);
    let y = filter(&x);
    let low = welch(&noisy(&x, 0.5, 2), &y, Estimator::H1);
    let high = welch(&x, &noisy(&y, 1.0, 3), Estimator::H2);
    let k = 25;
    let h = truth(low.frequency[k]).norm();
    // Gxx grows by a quarter; Gyy by 1/|H|².
    assert!((low.value[k].norm() / h - 0.8).abs() < 0.02);
    assert!((high.value[k].norm() / h - (1.0 + 1.0 / (h * h))).abs() < 0.04);
    assert!(low.coherence[k] < 0.82 && low.coherence[k] > 0.77);
}

#[test]
fn law_leakage_is_as_large_as_said() {
    // A resonance of a few lines' width, without noise: the error of H₁ is the leakage bias.
    let x = white(400_000, 5);
    let (mut a, mut b) = (0.0, 0.0);
    let y: Vec<f64> = x
        .iter()
        .map(|x| {
            let y = x + 1.57 * a - 0.94 * b;
            (b, a) = (a, y);
            y
        })
        .collect();
    // Five lines to the width of the resonance.
    let spectra = CrossSpectra::welch(&x, &[&y], RATE, &Welch::new(512), &Unwatched).unwrap();
    let e = spectra.response(0, Estimator::H1).unwrap();
    let h = |f: f64| {
        let z = Complex64::from_polar(1.0, -TAU * f / RATE);
        1.0 / (1.0 - 1.57 * z + 0.94 * z * z)
    };
    let top = (0..e.value.len())
        .max_by(|a, b| e.value[*a].norm().total_cmp(&e.value[*b].norm()))
        .unwrap();
    let error = e.value[top] - h(e.frequency[top]);
    let said = e.leakage[top];
    // The second difference of what is already smoothed misses the next order.
    assert!((error - said).norm() < 0.5 * said.norm(), "{error} {said}");
    assert!(said.norm() > 0.01 * e.value[top].norm());
}

#[test]
fn known_hits_of_a_noise_free_oscillator() {
    let mut hits = Vec::new();
    for width in [3usize, 4, 5] {
        let x: Vec<f64> = (0..1024)
            .map(|k| if k < width { 1.0 + k as f64 } else { 0.0 })
            .collect();
        let y = filter(&x);
        hits.push((x, y));
    }
    let views: Vec<[&[f64]; 1]> = hits.iter().map(|(_, y)| [y.as_slice()]).collect();
    let hits: Vec<Hit> = hits
        .iter()
        .zip(&views)
        .map(|((x, _), y)| Hit {
            input: x,
            outputs: y,
        })
        .collect();
    let spectra = CrossSpectra::hits(&hits, RATE, 1024, Some(8), None).unwrap();
    let e = spectra.response(0, Estimator::H1).unwrap();
    for (f, v) in e.frequency.iter().zip(&e.value) {
        assert!((v - truth(*f)).norm() < 1e-9, "{f}");
    }
    assert!(e.coherence.iter().all(|c| *c > 1.0 - 1e-9));
}

#[test]
fn refuses_too_little() {
    let x = white(300, 1);
    let one = CrossSpectra::welch(&x, &[&x], RATE, &Welch::new(256), &Unwatched).unwrap();
    assert!(one.response(0, Estimator::H1).is_err());
    assert!(one.response(1, Estimator::H1).is_err());
    assert!(CrossSpectra::welch(&x, &[&x[..200]], RATE, &Welch::new(64), &Unwatched).is_err());
    let rectangular = Welch {
        window: Window::Rectangular,
        ..Welch::new(64)
    };
    let many = CrossSpectra::welch(&x, &[&x], RATE, &rectangular, &Unwatched).unwrap();
    assert!(
        many.response(0, Estimator::Hv { noise_ratio: 0.0 })
            .is_err()
    );
    assert!(CrossSpectra::hits(&[], RATE, 64, None, None).is_err());
    let method = LocalPolynomial::default();
    assert!(
        method
            .estimate(&x[..20], &x[..20], RATE, &Unwatched)
            .is_err()
    );
    assert!(
        method
            .estimate(&[0.0; 400], &[0.0; 400], RATE, &Unwatched)
            .is_err()
    );
}

#[test]
fn law_leakage_of_every_estimator_is_its_own() {
    // A resonance twelve lines wide as a window shows it without noise: the leakage is the bias to a tenth (the next order, by
    // (line/width)², leaves 7 %). What the slope within a line adds to the output's power is as large as the bias of H₁.
    let x = white(4096, 5);
    let width = 12.0;
    let shown = |f: f64| 1.0 / Complex64::new(f - 60.0, 0.5 * width);
    let mut spectra = CrossSpectra::welch(&x, &[&x], 256.0, &Welch::new(256), &Unwatched).unwrap();
    // Lines at whole frequencies.
    assert_eq!(spectra.frequency[60], 60.0);
    for line in 0..spectra.frequency.len() {
        let f = spectra.frequency[line];
        let (mut cross, mut auto) = (Complex64::new(0.0, 0.0), 0.0);
        for (m, q) in spectra.kernel.iter().enumerate() {
            let away = 0.25 * m as f64;
            for at in [f - away, f + away].iter().take(if m == 0 { 1 } else { 2 }) {
                cross += *q * shown(*at);
                auto += *q * shown(*at).norm_sqr();
            }
        }
        spectra.input[line] = 1.0;
        spectra.outputs[0].auto[line] = auto;
        spectra.outputs[0].cross[line] = cross;
    }
    spectra.independent = 1e9;
    for estimator in [
        Estimator::H1,
        Estimator::H2,
        Estimator::Hv { noise_ratio: 0.01 },
    ] {
        let e = spectra.response(0, estimator).unwrap().within(48.0, 72.0);
        let bias: Vec<Complex64> = (0..e.lines())
            .map(|k| e.value[k] - shown(e.frequency[k]))
            .collect();
        let greatest = bias.iter().map(|b| b.norm()).fold(0.0, f64::max);
        assert!(greatest > 5e-3 * shown(60.0).norm() && greatest < 0.01 * shown(60.0).norm());
        for (b, said) in bias.iter().zip(&e.leakage) {
            assert!(
                (b - said).norm() < 0.1 * greatest,
                "{estimator:?} {b} {said}"
            );
        }
    }
}
