use super::*;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn record(n: usize, omega: f64, noise: &mut impl FnMut() -> f64, terms: &[(f64, f64)]) -> Vec<f64> {
    (0..n)
        .map(|i| {
            let t = i as f64;
            terms
                .iter()
                .enumerate()
                .map(|(h, (a, p))| a * ((h + 1) as f64 * omega * t + p).cos())
                .sum::<f64>()
                + noise()
        })
        .collect()
}

fn gaussian(seed: u64, sigma: f64) -> impl FnMut() -> f64 {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let normal = Normal::new(0.0, sigma).unwrap();
    move || normal.sample(&mut rng)
}

#[test]
fn law_noise_free_records_return_the_truth() {
    // Lengths that are whole blocks, ragged, and shorter than one block; not a whole number of periods.
    for n in [300usize, 4096, 5001, 70_003] {
        let omega = 0.061_234;
        let x: Vec<f64> = record(
            n,
            omega,
            &mut || 0.0,
            &[(2.0, 0.7), (0.01, -1.0), (0.002, 2.0)],
        )
        .iter()
        .enumerate()
        .map(|(i, v)| v + 0.3 + 1e-5 * i as f64)
        .collect();
        let fit = SineApproximation::new(omega / TAU)
            .harmonics(3)
            .drift(true)
            .fit(1.0, &[&x])
            .unwrap();
        let c = &fit.channels[0];
        assert!(
            (c.amplitude - Complex64::from_polar(2.0, 0.7)).norm() < 1e-11,
            "{n}: {c:?}"
        );
        assert!((c.harmonics[0] - Complex64::from_polar(0.01, -1.0)).norm() < 1e-11);
        assert!((c.harmonics[1] - Complex64::from_polar(0.002, 2.0)).norm() < 1e-11);
        assert!((c.drift - 1e-5).abs() < 1e-13 * 1e3);
        assert!((c.offset - 0.3 - 1e-5 * 0.5 * (n - 1) as f64).abs() < 1e-11);
        assert!(c.residual_rms < 1e-11);
        let thd = (0.01f64.powi(2) + 0.002f64.powi(2)).sqrt() / 2.0;
        assert!((c.thd().unwrap() - thd).abs() < 1e-11);
    }
}

#[test]
fn law_the_common_frequency_is_found_from_all_channels() {
    // Started 0.8 of a resolution cell (1/T) off; noise-free, so what is left is rounding.
    let (n, omega) = (20_000, 0.05);
    let channels: Vec<Vec<f64>> = [(1.0, 0.1), (0.5, 2.0), (0.01, -2.0)]
        .iter()
        .map(|&t| record(n, omega, &mut || 0.0, &[t]))
        .collect();
    let views: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    let start = omega / TAU + 0.3 / n as f64;
    let fit = SineApproximation::new(start)
        .frequency(Frequency::Common)
        .fit(1.0, &views)
        .unwrap();
    assert!((fit.frequency * TAU / omega - 1.0).abs() < 1e-12);
    assert!((fit.channels[1].amplitude - Complex64::from_polar(0.5, 2.0)).norm() < 1e-8);
}

#[test]
fn law_the_number_of_threads_changes_nothing() {
    let x = record(300_000, 0.0123, &mut gaussian(1, 0.1), &[(1.0, 0.2)]);
    let fit = || {
        SineApproximation::new(0.0123 / TAU)
            .fit(1.0, &[&x, &x])
            .unwrap()
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(fit(), pool.install(fit));
}

/// Share of 2×2 regions at 95 % that hold the true phasor.
fn covered(residuals: Residuals, colour: f64, trials: u64) -> usize {
    let (n, omega) = (2048, 0.2);
    let truth = Complex64::from_polar(1.0, 0.4);
    (0..trials)
        .filter(|&seed| {
            let (mut white, mut state) = (gaussian(1000 + seed, 0.05), 0.0);
            let mut noise = || {
                state = colour * state + white();
                state
            };
            let x = record(n, omega, &mut noise, &[(1.0, 0.4)]);
            let fit = SineApproximation::new(omega / TAU)
                .residuals(residuals)
                .fit(1.0, &[&x])
                .unwrap();
            let c = &fit.channels[0];
            let e = c.amplitude - truth;
            let [rr, ri, ii] = c.covariance;
            let q = (e.re * e.re * ii - 2.0 * e.re * e.im * ri + e.im * e.im * rr)
                / (rr * ii - ri * ri);
            // Hotelling: T² with ν = 2M Wishart degrees of freedom, 2(ν)/(ν−1) F(2, ν−1); for 20: F = 3.522.
            let bound = if c.dof > 1000.0 {
                5.991
            } else {
                2.0 * 20.0 / 19.0 * 3.522
            };
            q < bound
        })
        .count()
}

#[test]
fn coverage_of_the_amplitude_in_white_and_coloured_noise() {
    // 1000 trials of probability 0.95: standard deviation 6.9; ±3.3 σ is 927 … 973 (two-sided 0.1 %).
    let white = covered(Residuals::White, 0.0, 1000);
    assert!((927..=973).contains(&white), "white: {white}");
    let coloured = covered(Residuals::Coloured, 0.95, 1000);
    assert!((927..=973).contains(&coloured), "coloured: {coloured}");
    // The white assumption fails on the same records: the noise at 0.2 rad is 3 times its mean density.
    let wrong = covered(Residuals::White, 0.95, 200);
    assert!(
        wrong < 170,
        "white assumption in coloured noise: {wrong} of 200"
    );
}

#[test]
fn coverage_of_the_common_frequency() {
    let (n, omega) = (4096, 0.11);
    let inside = (0..400)
        .filter(|&seed| {
            let x = record(n, omega, &mut gaussian(9000 + seed, 0.1), &[(1.0, 0.4)]);
            let y = record(n, omega, &mut gaussian(19_000 + seed, 0.5), &[(1.0, 1.4)]);
            let fit = SineApproximation::new(omega / TAU)
                .frequency(Frequency::Common)
                .residuals(Residuals::White)
                .fit(1.0, &[&x, &y])
                .unwrap();
            (fit.frequency - omega / TAU).abs() < 1.96 * fit.frequency_uncertainty.unwrap()
        })
        .count();
    // 400 trials: 380 ± 4.4; 0.1 % two-sided bounds.
    assert!((365..=394).contains(&inside), "{inside}");
}

#[test]
fn refuses_what_cannot_be_fitted() {
    let x = vec![0.0; 1000];
    let sine = SineApproximation::new(0.1);
    assert!(matches!(
        sine.fit(1.0, &[&x, &x[1..]]),
        Err(Error::Length { .. })
    ));
    assert!(matches!(
        sine.fit(1.0, &[&x[..100]]),
        Err(Error::TooFew { .. })
    ));
    assert!(matches!(
        SineApproximation::new(0.3).harmonics(2).fit(1.0, &[&x]),
        Err(Error::OutOfRange { .. })
    ));
    let mut bad = x.clone();
    bad[500] = f64::NAN;
    assert_eq!(
        sine.fit(1.0, &[&x, &bad]),
        Err(Error::NotFinite {
            name: "channel",
            index: 1
        })
    );
}

/// A sine with its second harmonic and an offset at jittered instants; rms jitter in samples.
fn jittered(n: usize, omega: f64, jitter: f64, seed: u64, noise: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut late, mut white) = (gaussian(seed, jitter), gaussian(seed + 50_000, noise));
    let late: Vec<f64> = (0..n).map(|_| late().clamp(-0.45, 0.45)).collect();
    let x = late.iter().enumerate().map(|(i, l)| {
        let t = i as f64 + l;
        (omega * t + 0.4).cos() + 0.02 * (2.0 * omega * t - 1.0).cos() + 0.5 + white()
    });
    let x = x.collect();
    (late, x)
}

#[test]
fn law_a_sine_is_found_at_its_own_instants() {
    for (n, omega, jitter) in [(4000, 0.3, 0.2), (777, 1.1, 0.1), (300, 0.05, 0.4)] {
        let (late, x) = jittered(n, omega, jitter, 3, 0.0);
        let fit = SineApproximation::new(omega / TAU * 1.000_01)
            .frequency(Frequency::Common)
            .harmonics(2)
            .fit_at(1.0, &late, &[&x])
            .unwrap();
        let off = (fit.channels[0].amplitude - Complex64::from_polar(1.0, 0.4)).norm();
        assert!(off < 1e-9, "{n}: {off:e}");
        assert!((fit.frequency * TAU / omega - 1.0).abs() < 1e-10);
        // On an even grid the jitter is noise of the size ωδ.
        let even = SineApproximation::new(omega / TAU)
            .harmonics(2)
            .fit(1.0, &[&x]);
        assert!(even.unwrap().channels[0].residual_rms > 0.3 * omega * jitter);
    }
}

#[test]
fn coverage_at_jittered_instants() {
    let (n, omega) = (1024, 0.4);
    let truth = Complex64::from_polar(1.0, 0.4);
    let inside = (0..400)
        .filter(|&seed| {
            let (late, x) = jittered(n, omega, 0.15, 100 + seed, 0.02);
            let fit = SineApproximation::new(omega / TAU)
                .harmonics(2)
                .residuals(Residuals::White)
                .fit_at(1.0, &late, &[&x])
                .unwrap();
            let c = &fit.channels[0];
            let e = c.amplitude - truth;
            let [rr, ri, ii] = c.covariance;
            let q = (e.re * e.re * ii - 2.0 * e.re * e.im * ri + e.im * e.im * rr)
                / (rr * ii - ri * ri);
            q < 5.991
        })
        .count();
    // 400 trials at 95 %: 380 ± 4.4; 0.1 % two-sided.
    assert!((365..=394).contains(&inside), "{inside}");
}

/// Mains hum within a resolution of a harmonic turns that harmonic through the record; the drive is found all the same.
#[test]
fn law_hum_beside_a_harmonic_stops_nothing() {
    let rate = 400.0;
    for (case, (drive, seconds, hum, size)) in [
        (10.0003, 60.0, 50.01, 0.005),
        (9.9996, 60.0, 50.01, 0.02),
        (10.0, 60.0, 49.98, 0.02),
        (12.5002, 30.0, 49.98, 0.02),
        (19.998, 40.0, 60.01, 0.01),
    ]
    .into_iter()
    .enumerate()
    {
        let n = (seconds * rate) as usize;
        let mut noise = gaussian(900 + case as u64, 2e-5);
        let channels: Vec<Vec<f64>> = [1.0, 0.8, 0.1, -0.05]
            .iter()
            .map(|gain| {
                (0..n)
                    .map(|i| {
                        let t = i as f64 / rate;
                        0.1 * gain
                            * ((TAU * drive * t).cos() + 1e-3 * (2.0 * TAU * drive * t).cos())
                            + size * (TAU * hum * t + 0.4).cos()
                            + noise()
                    })
                    .collect()
            })
            .collect();
        let channels: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
        for tones in [false, true] {
            let fit = SineApproximation::new(drive.round())
                .start(drive * (1.0 + 1e-6))
                .harmonics(5)
                .residuals(Residuals::Coloured)
                .frequency(Frequency::Common)
                .tones(tones)
                .fit(rate, &channels);
            let fit = fit.unwrap();
            let u = fit.frequency_uncertainty.unwrap();
            assert!(
                (fit.frequency - drive).abs() < 4.0 * u,
                "{case} {tones}: {} ± {u}",
                fit.frequency
            );
            let c = &fit.channels[1];
            assert!((c.amplitude - 0.08).norm() < 1e-5, "{case} {tones}: {c:?}");
        }
    }
}

/// Mean, over short records, of σ² as the covariance of a fit has it: that of a known frequency takes three degrees of freedom,
/// that of a found one four, shared by the channels that show it.
#[test]
fn law_a_found_frequency_takes_a_degree_of_freedom() {
    let (n, omega, sigma) = (16, 1.0, 0.05);
    for (frequency, amplitudes, expected) in [
        (Frequency::Known, vec![1.0], 13.0),
        (Frequency::Common, vec![1.0], 12.0),
        (Frequency::Common, vec![1.0, 1.0], 12.5),
        (Frequency::Common, vec![1.0, 1e-6], 12.0),
    ] {
        let (mut dof, mut power) = (0.0, 0.0);
        let trials = 4000;
        for seed in 0..trials {
            let mut noise = gaussian(9000 + seed, sigma);
            let channels: Vec<Vec<f64>> = amplitudes
                .iter()
                .map(|&a| record(n, omega, &mut noise, &[(a, 0.4)]))
                .collect();
            let views: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
            let fit = SineApproximation::new(omega / TAU)
                .frequency(frequency)
                .residuals(Residuals::White)
                .fit(1.0, &views)
                .unwrap();
            let c = &fit.channels[0];
            dof += c.dof / trials as f64;
            power += n as f64 * c.residual_rms * c.residual_rms / c.dof / trials as f64;
        }
        assert!((dof - expected).abs() < 0.05, "{dof}, {expected}");
        // χ² with 12 degrees of freedom, 4000 times: standard deviation 0.65 %, four of them.
        assert!((power / (sigma * sigma) - 1.0).abs() < 0.026, "{power:e}");
    }
}
