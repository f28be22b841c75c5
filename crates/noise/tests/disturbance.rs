//! Disturbances: how often chance is taken for one, and how surely one is found.

use proofmass_noise::{DisturbanceKind, NoiseModel, disturbances, simulate};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

fn record(model: &NoiseModel, samples: usize, rate: f64, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(model, samples, rate, &mut rng).unwrap()
}

/// The stated rate of false alarms: 1 % asked for, 300 records of white noise, flicker and random walk; a binomial of mean
/// 3 exceeds 10 with probability 3e-4.
#[test]
fn law_disturbance_false_alarms() {
    let model = NoiseModel {
        white: 1e-3,
        flicker: 2e-4,
        random_walk: 1e-5,
        ..Default::default()
    };
    let alarms: usize = (0..300_u64)
        .into_par_iter()
        .map(|seed| {
            let y = record(&model, 30_000, 100.0, 700 + seed);
            usize::from(!disturbances(&y, 100.0, 0.01).unwrap().is_empty())
        })
        .sum();
    println!("{alarms} of 300");
    assert!(alarms <= 10, "{alarms} of 300");
}

/// Knocks, steps, spikes and frozen stretches of a few standard deviations are found where they are.
#[test]
fn law_disturbances_are_found() {
    let model = NoiseModel {
        white: 1e-3,
        random_walk: 1e-6,
        ..Default::default()
    };
    let clean = record(&model, 200_000, 100.0, 77);
    let sigma = 1e-2;
    type Damage = (DisturbanceKind, fn(&mut [f64], f64));
    let damages: [Damage; 4] = [
        (DisturbanceKind::Step, |y, s| {
            y[123_456..].iter_mut().for_each(|v| *v += 0.5 * s)
        }),
        (DisturbanceKind::Burst, |y, s| {
            for (k, v) in y[123_400..123_600].iter_mut().enumerate() {
                *v += 2.0 * s * (k as f64).sin();
            }
        }),
        (DisturbanceKind::Spike, |y, s| y[123_456] += 12.0 * s),
        (DisturbanceKind::Lull, |y, _| {
            let frozen = y[123_400];
            y[123_400..123_600].iter_mut().for_each(|v| *v = frozen);
        }),
    ];
    for (kind, damage) in damages {
        let mut y = clean.clone();
        damage(&mut y, sigma);
        let found = disturbances(&y, 100.0, 1e-4).unwrap();
        assert!(
            found
                .iter()
                .any(|d| d.samples.0 <= 123_600 && 123_400 <= d.samples.1),
            "{kind:?}: {found:?}"
        );
    }
    assert!(disturbances(&clean, 100.0, 1e-4).unwrap().is_empty());
}
