//! Densities against SciPy 1.16, against Parseval, and their confidence bands against simulation.

use proofmass_signal::{
    Detrend, Multitaper, Tapers, Welch, Window, equivalent_noise_bandwidth, fourier, slepian,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A reproducible signal that any program can make: ((7k² + 3k) mod 101)/101 − 0.5.
fn congruential(n: u64) -> Vec<f64> {
    (0..n)
        .map(|k| ((7 * k * k + 3 * k) % 101) as f64 / 101.0 - 0.5)
        .collect()
}

fn white(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
}

fn assert_close(ours: f64, theirs: f64, relative: f64, what: &str) {
    assert!(
        (ours / theirs - 1.0).abs() < relative,
        "{what}: {ours:e}, expected {theirs:e}"
    );
}

/// `scipy.signal.welch(x, fs=50, nperseg=128, noverlap=64, detrend='constant')`, bins 1, 7, 33, 64.
#[test]
fn crosscheck_scipy_welch() {
    let signal = congruential(1024);
    let bins = [1, 7, 33, 64];
    for (window, expected) in [
        (
            Window::Hann,
            [
                0.005266497127099335,
                0.00016087598966943326,
                0.00017721186678688156,
                0.0007571161145645837,
            ],
        ),
        (
            Window::FlatTop,
            [
                0.0038156915027008002,
                0.0040412532866486725,
                0.0007207311565155358,
                0.0010999871274838702,
            ],
        ),
        (
            Window::BlackmanHarris,
            [
                0.004610206334767912,
                0.0010462811288694852,
                0.000293904523960438,
                0.0008507724490952946,
            ],
        ),
        (
            Window::Rectangular,
            [
                0.005779026206291005,
                0.0002898806311117933,
                0.00026986874052216403,
                0.0004599171241381563,
            ],
        ),
    ] {
        let welch = Welch {
            window,
            ..Welch::new(128)
        };
        let density = welch.density(&signal, 50.0).unwrap();
        for (bin, expected) in bins.iter().zip(expected) {
            assert_close(
                density.density[*bin],
                expected,
                1e-12,
                &format!("{window:?} bin {bin}"),
            );
        }
    }
}

/// Odd segments, another overlap, a straight line removed from each.
#[test]
fn crosscheck_scipy_welch_odd_and_linear() {
    let welch = Welch {
        segment: 125,
        overlap: 60,
        window: Window::Hann,
        detrend: Detrend::Linear,
    };
    let density = welch.density(&congruential(1024), 50.0).unwrap();
    assert_eq!(density.density.len(), 63);
    let expected = [
        0.004496435149637206,
        0.00030265056697998576,
        0.0006494137291838484,
        0.0017648677329602641,
    ];
    for (bin, expected) in [1, 7, 33, 62].iter().zip(expected) {
        assert_close(
            density.density[*bin],
            expected,
            1e-11,
            &format!("bin {bin}"),
        );
    }
}

/// `scipy.signal.windows.dpss(64, 2.5, 4)` and `(501, 4, 7)`.
#[test]
fn crosscheck_scipy_slepian() {
    let (tapers, concentrations) = slepian(64, 2.5, 4).unwrap();
    let expected = [
        [
            0.0012289709940492657,
            0.018696499589131506,
            0.21899450645426716,
            0.060529388020430334,
        ],
        [
            0.007905854887166863,
            0.06574053634884051,
            0.012787882119658662,
            -0.1446421199118971,
        ],
        [
            0.0333104613759799,
            0.14094185803961598,
            -0.14361261630561342,
            0.18803347343301913,
        ],
        [
            0.10052097618754133,
            0.19507768639676776,
            -0.013458392561080007,
            -0.11144951550567797,
        ],
    ];
    for (taper, expected) in tapers.iter().zip(expected) {
        for (i, value) in [0, 7, 31, 50].iter().zip(expected) {
            assert!((taper[*i] - value).abs() < 1e-9, "{} {value}", taper[*i]);
        }
    }
    for (ours, theirs) in concentrations
        .iter()
        .zip([0.99999728, 0.99984655, 0.99626686, 0.95242596])
    {
        assert!((ours - theirs).abs() < 1e-8);
    }
    let (tapers, concentrations) = slepian(501, 4.0, 7).unwrap();
    let last = [
        0.04526591584096279,
        -0.041316747106675905,
        -0.041034994104671395,
        0.03254386029840205,
    ];
    for (i, value) in [0, 100, 250, 333].iter().zip(last) {
        assert!((tapers[6][*i] - value).abs() < 1e-9);
    }
    assert!((concentrations[6] - 0.936665498660636).abs() < 1e-10);
}

#[test]
fn law_slepian_tapers_are_orthonormal() {
    for (n, nw, count) in [(64, 2.5, 4), (501, 4.0, 7), (20_000, 4.0, 7)] {
        let (tapers, _) = slepian(n, nw, count).unwrap();
        for (j, a) in tapers.iter().enumerate() {
            for (k, b) in tapers.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                let expected = f64::from(u8::from(j == k));
                assert!(
                    (product - expected).abs() < 1e-9,
                    "n {n}, {j} {k}: {product:e}"
                );
            }
        }
    }
}

/// Σ S Δf is the mean square, exactly, for one rectangular segment of any parity.
#[test]
fn law_parseval() {
    for n in [64, 125, 1000, 4097] {
        let signal = white(n, n as u64);
        let welch = Welch {
            segment: n,
            overlap: 0,
            window: Window::Rectangular,
            detrend: Detrend::None,
        };
        let density = welch.density(&signal, 17.0).unwrap();
        let mean_square = signal.iter().map(|v| v * v).sum::<f64>() / n as f64;
        assert_close(
            density.mean_square(0.0, 9.0),
            mean_square,
            1e-12,
            &format!("n = {n}"),
        );
    }
}

/// With a window the mean square is that weighted by w².
#[test]
fn law_parseval_windowed() {
    let signal = white(512, 3);
    for window in [
        Window::Hann,
        Window::Hamming,
        Window::BlackmanHarris,
        Window::FlatTop,
    ] {
        let welch = Welch {
            segment: 512,
            overlap: 0,
            window,
            detrend: Detrend::None,
        };
        let w = window.weights(512);
        let weighted: f64 = signal.iter().zip(&w).map(|(v, w)| (v * w).powi(2)).sum();
        let expected = weighted / w.iter().map(|w| w * w).sum::<f64>();
        let density = welch.density(&signal, 3.0).unwrap();
        assert_close(density.mean_square(0.0, 1.5), expected, 1e-12, "windowed");
    }
}

/// `[Heinzel2002]` appendix C: bandwidths in bins.
#[test]
fn published_equivalent_noise_bandwidths() {
    for (window, published) in [
        (Window::Rectangular, 1.0),
        (Window::Hann, 1.5),
        (Window::Hamming, 1.3628),
        (Window::BlackmanHarris, 2.0044),
        (Window::FlatTop, 3.7702),
    ] {
        let bins = equivalent_noise_bandwidth(&window.weights(4096));
        assert!((bins - published).abs() < 1e-4, "{window:?}: {bins}");
    }
}

/// The 90 % band holds the true density of white noise: S = 2σ²/rate.
///
/// Bound: 400 records × 16 well separated bins = 6400 trials; √(0.9·0.1/6400) = 0.00375, three of them 0.0113. The
/// bins of overlapping Hann segments are not quite χ², for which another 0.005 is granted.
#[test]
fn coverage_of_confidence_bands() {
    let welch = Welch::new(128);
    let multitaper = Multitaper {
        segment: 512,
        tapers: Tapers::Slepian {
            time_bandwidth: 4.0,
            count: 7,
        },
        detrend: Detrend::Constant,
    };
    let sine = Multitaper {
        tapers: Tapers::Sine { count: 5 },
        ..multitaper
    };
    for estimator in 0..3 {
        let (mut inside, mut trials) = (0, 0);
        for seed in 0..400 {
            let signal = white(1024, 1000 + seed);
            let density = match estimator {
                0 => welch.density(&signal, 10.0),
                1 => multitaper.density(&signal, 10.0),
                _ => sine.density(&signal, 10.0),
            }
            .unwrap();
            let band = density.confidence(0.9).unwrap();
            let step = (density.density.len() - 1) / 18;
            for k in 1..=16 {
                let (low, high) = band[k * step + step / 2];
                inside += usize::from(low < 0.2 && 0.2 < high);
                trials += 1;
            }
        }
        let share = inside as f64 / trials as f64;
        assert!(
            (share - 0.9).abs() < 0.0163,
            "estimator {estimator}: {share}"
        );
    }
}

#[test]
fn law_forward_inverse() {
    for n in [1, 2, 7, 64, 1001] {
        let signal = white(n, 40 + n as u64);
        let back = fourier::inverse(fourier::forward(&signal), n).unwrap();
        for (a, b) in signal.iter().zip(&back) {
            assert!((a - b).abs() < 1e-13);
        }
    }
}

#[test]
fn law_quadratic_trend_is_removed_exactly() {
    let mut signal: Vec<f64> = (0..501)
        .map(|k| {
            let t = (f64::from(k) - 250.0) / 100.0;
            1.5 - 0.25 * t + 0.75 * t * t
        })
        .collect();
    let trend = Detrend::Quadratic.remove(&mut signal, 100.0).unwrap();
    assert!((trend.slope + 0.25).abs() < 1e-12 && (trend.curvature - 0.75).abs() < 1e-12);
    assert!(signal.iter().all(|v| v.abs() < 1e-12));
}

#[test]
fn refuses_bad_signals() {
    let welch = Welch::new(16);
    assert!(welch.density(&[0.0; 8], 1.0).is_err());
    let mut signal = vec![0.0; 64];
    signal[20] = f64::NAN;
    assert_eq!(
        welch.density(&signal, 1.0),
        Err(proofmass_core::Error::NotFinite {
            name: "signal",
            index: 20
        })
    );
    signal[20] = 0.0;
    assert!(welch.density(&signal, 0.0).is_err());
    assert!(
        Welch {
            overlap: 16,
            ..welch
        }
        .density(&signal, 1.0)
        .is_err()
    );
    assert!(slepian(64, 2.5, 0).is_err());
    assert!(slepian(64, 40.0, 4).is_err());
}

#[test]
fn law_weights_are_the_sum_of_cosines() {
    // Definitions of Heinzel, Rüdiger and Schilling, appendix C.
    let coefficients: [(Window, &[f64]); 3] = [
        (Window::Rectangular, &[1.0]),
        (Window::Hann, &[0.5, 0.5]),
        (
            Window::BlackmanHarris,
            &[0.35875, 0.48829, 0.14128, 0.01168],
        ),
    ];
    for (window, coefficients) in coefficients {
        for n in [0, 1, 2, 3, 64, 65, 127, 128, 129, 130, 1000, 4097] {
            let weights = window.weights(n);
            assert_eq!(weights.len(), n);
            for (k, w) in weights.iter().enumerate() {
                let angle = std::f64::consts::TAU * k as f64 / n as f64;
                let terms = coefficients.iter().enumerate();
                let expected: f64 = terms
                    .map(|(j, a)| (-1f64).powi(j as i32) * a * (j as f64 * angle).cos())
                    .sum();
                // Rounding of the angles j 2πk/n, which the derivative of up to j = 3 carries on.
                assert!(
                    (w - expected).abs() < 4e-15,
                    "{window:?} {n} {k}: {w} {expected}"
                );
            }
        }
    }
}
