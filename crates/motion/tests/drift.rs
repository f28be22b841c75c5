//! Drift of velocity and place in closed form: powers of the time, limits, simulated records.

use proofmass_motion::DriftSources;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// The textbook's powers of the time: b t, N t^½, K t^{3/2}; of the place b t², N t^{3/2}, K t^{5/2}.
#[test]
fn known_powers_of_the_time() {
    let sources = DriftSources {
        offset_uncertainty: 0.01,
        noise: 0.002,
        sample_time: 1.0,
        walk: 3e-4,
        flicker: 1e-3,
        ..DriftSources::default()
    };
    let t = 100.0f64;
    let (v, p) = (sources.after(t), sources.place_after(t));
    let floor = (4.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    for (value, known) in [
        (v.offset_uncertainty, 0.01 * t),
        (v.noise, 0.002 * t.sqrt()),
        (v.walk, 3e-4 * (t.powi(3) / 3.0).sqrt()),
        (v.flicker, 1e-3 * floor * t),
        (p.offset_uncertainty, 0.5 * 0.01 * t * t),
        (p.noise, 0.002 * (t.powi(3) / 3.0).sqrt()),
        (p.walk, 3e-4 * (t.powi(5) / 20.0).sqrt()),
    ] {
        assert!((value / known - 1.0).abs() < 1e-12, "{value} {known}");
    }
    // The floor of the Allan deviation: the mean over t less that over as long before has twice its variance.
    let rested = DriftSources { rest: t, ..sources };
    assert!((rested.after(t).flicker / v.flicker - 1.0).abs() < 1e-12);
    assert_eq!(rested.after(t).offset_uncertainty, 0.0);
    // N √(t + t²/T) and K √(t³/3 + t² T/3) with T = t.
    assert!((rested.after(t).noise / (0.002 * (2.0 * t).sqrt()) - 1.0).abs() < 1e-12);
    assert!((rested.after(t).walk / (3e-4 * (2.0 * t.powi(3) / 3.0).sqrt()) - 1.0).abs() < 1e-12);
}

/// A Gauss–Markov process is white noise long after, a constant long before its correlation time, and with a rest what a walk is.
#[test]
fn law_a_gauss_markov_process_lies_between_noise_and_offset() {
    let with = |time: f64, rest: f64| DriftSources {
        markov: [[0.01, time], [0.0; 2], [0.0; 2], [0.0; 2]],
        rest,
        ..DriftSources::default()
    };
    let white = (2.0f64 * 1e-3).sqrt() * 0.01;
    // Of order τ/t and t/τ.
    assert!((with(1e-3, 0.0).after(100.0).markov / (white * 10.0) - 1.0).abs() < 1e-4);
    assert!((with(1e7, 0.0).after(100.0).markov / 1.0 - 1.0).abs() < 1e-4);
    assert!((with(1e7, 0.0).place_after(100.0).markov / 50.0 - 1.0).abs() < 1e-4);
    assert!(
        (with(2000.0, 0.0).place_after(100.0).markov / with(2000.1, 0.0).place_after(100.0).markov
            - 1.0)
            .abs()
            < 1e-5
    );
    let walk = DriftSources {
        walk: 0.01 * (2.0f64 / 1e6).sqrt(),
        rest: 20.0,
        ..DriftSources::default()
    };
    for of in [DriftSources::after, DriftSources::place_after] {
        let ratio = of(&with(1e6, 20.0), 100.0).markov / of(&walk, 100.0).walk;
        assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    }
}

/// Every process simulated, with a rest before the start and without, against the closed forms: velocity and place.
#[test]
fn law_simulated_drifts_scatter_as_the_closed_forms_say() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    // 20 s of rest, 40 s of motion at 10 Hz.
    let (step, before, after) = (0.1f64, 200usize, 400usize);
    let runs = 2000;
    let sources = DriftSources {
        noise: 0.02,
        sample_time: step,
        walk: 5e-4,
        markov: [[2e-3, 15.0], [0.0; 2], [0.0; 2], [0.0; 2]],
        ..DriftSources::default()
    };
    let rested = DriftSources {
        rest: 20.0,
        ..sources
    };
    let decay = (-step / 15.0f64).exp();
    let mut ends = [[0.0; 2]; 2];
    for _ in 0..runs {
        let (mut walk, mut markov) = (0.0, 2e-3 * normal());
        let mut samples = Vec::with_capacity(before + after);
        for _ in 0..before + after {
            samples.push(walk + markov + 0.02 * normal());
            walk += 5e-4 * step.sqrt() * normal();
            markov = decay * markov + 2e-3 * (1.0 - decay * decay).sqrt() * normal();
        }
        let mean = samples[..before].iter().sum::<f64>() / before as f64;
        let (mut v, mut p) = ([0.0; 2], [0.0; 2]);
        for a in &samples[before..] {
            for (k, off) in [mean, 0.0].into_iter().enumerate() {
                p[k] += v[k] * step + 0.5 * (a - off) * step * step;
                v[k] += (a - off) * step;
            }
        }
        ends[0][0] += v[0] * v[0] / f64::from(runs);
        ends[0][1] += p[0] * p[0] / f64::from(runs);
        ends[1][0] += v[1] * v[1] / f64::from(runs);
        ends[1][1] += p[1] * p[1] / f64::from(runs);
    }
    // A standard deviation from 2000 scatters by 1.6 %: four of them, and half a step in forty seconds.
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.07, "{a} {b}");
    close(ends[0][0].sqrt(), rested.after(40.0).combined);
    close(ends[0][1].sqrt(), rested.place_after(40.0).combined);
    // The walk had gone on for 20 s before: as an offset of K √20 more.
    let older = DriftSources {
        offset_uncertainty: 5e-4 * 20f64.sqrt(),
        ..sources
    };
    close(ends[1][0].sqrt(), older.after(40.0).combined);
    close(ends[1][1].sqrt(), older.place_after(40.0).combined);
}

/// Flicker noise by its sum of relaxations against the closed form: B²/π of variance in each Neper of correlation times is
/// S = B²/(2π|f|) between their corners.
#[test]
fn law_flicker_is_a_sum_of_relaxations() {
    let (per_decade, decades) = (20, 14);
    let width = 10f64.ln() / f64::from(per_decade);
    let deviation = (width / std::f64::consts::PI).sqrt();
    for (t, rest) in [(10.0, 10.0), (100.0, 5.0), (3.0, 200.0)] {
        for of in [DriftSources::after, DriftSources::place_after] {
            let sum: f64 = (0..per_decade * decades)
                .map(|k| 10f64.powf(-7.0 + (f64::from(k) + 0.5) / f64::from(per_decade)))
                .map(|tau| {
                    let one = DriftSources {
                        markov: [[deviation, tau], [0.0; 2], [0.0; 2], [0.0; 2]],
                        rest,
                        ..DriftSources::default()
                    };
                    of(&one, t).markov.powi(2)
                })
                .sum();
            let closed = DriftSources {
                flicker: 1.0,
                rest,
                ..DriftSources::default()
            };
            // Correlation times beyond the grid carry less than a thousandth; the grid itself errs by less.
            let closed = of(&closed, t).flicker.powi(2);
            assert!(
                (sum / closed - 1.0).abs() < 4e-3,
                "{t} {rest}: {sum} {closed}"
            );
        }
    }
}
