//! Disturbances: how often chance is taken for one, and how surely one is found.

use proofmass_noise::{DisturbanceKind, NoiseModel, disturbances, simulate};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::path::PathBuf;

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

/// A disturbance, made in a record of scatter `s` about its own noise, between the samples given.
type Damage = (&'static str, fn(&mut [f64], f64));

const FROM: usize = 123_400;
const TO: usize = 125_400;

/// What happens to sensors that should be left alone. Sizes are in standard deviations of one sample; the time
/// taken is 20 s of 2000 s.
const DAMAGES: [Damage; 5] = [
    // The table was touched: the attitude changed for good.
    ("step of 1.5 σ", |y, s| {
        y[FROM..].iter_mut().for_each(|v| *v += 1.5 * s)
    }),
    // Lost bits: ten single samples.
    ("spikes of 10 σ", |y, s| {
        (0..10).for_each(|k| y[FROM + 200 * k] += 10.0 * s)
    }),
    // A machine was switched on near by.
    ("oscillation of 1.2 σ", |y, s| {
        for (k, v) in y[FROM..TO].iter_mut().enumerate() {
            *v += 1.2 * s * (1.3 * k as f64).sin();
        }
    }),
    // Half the noise again for 20 s.
    ("noise of 1.5 σ", |y, _| {
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        y[FROM..TO]
            .iter_mut()
            .for_each(|v| *v = mean + 1.5 * (*v - mean))
    }),
    // A draught: away and back within 20 s.
    ("swell of 1.5 σ", |y, s| {
        for (k, v) in y[FROM..TO].iter_mut().enumerate() {
            *v += 1.5 * s * (std::f64::consts::PI * k as f64 / (TO - FROM) as f64).sin();
        }
    }),
];

/// Power at the strict false-alarm rate of 1e-4: each of these is found, in its place, in every one of 20 records; were it
/// found in 80 % of records only, 20 of 20 would have a probability of 0.012.
#[test]
fn law_disturbances_are_found_every_time() {
    let model = NoiseModel {
        white: 1e-3,
        random_walk: 1e-6,
        ..Default::default()
    };
    for (name, damage) in DAMAGES {
        let found: usize = (0..20_u64)
            .into_par_iter()
            .map(|seed| {
                let mut y = record(&model, 200_000, 100.0, 3000 + seed);
                damage(&mut y, 1e-2);
                let found = disturbances(&y, 100.0, 1e-4).unwrap();
                let there =
                    |d: &proofmass_noise::Disturbance| d.samples.0 < TO && FROM < d.samples.1;
                usize::from(found.iter().any(there))
            })
            .sum();
        println!("{name}: {found} of 20");
        assert_eq!(found, 20, "{name}");
    }
}

/// One channel of a real inertial unit at rest for 2.8 h, in counts: found undisturbed, and every damage found in it.
///
/// The noise of this unit is neither white nor Gaussian in its tails; nothing here was set by looking at it.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_disturbances_in_a_real_record() {
    let root = PathBuf::from(
        std::env::var_os("PROOFMASS_REFERENCE_DATA")
            .expect("PROOFMASS_REFERENCE_DATA names the folder of the recordings of others"),
    );
    let file = std::fs::File::open(root.join("adis16405/imu1_counts_int16.npy.gz")).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(file), &mut bytes).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let counts: Vec<f64> = bytes[header..]
        .as_chunks::<2>()
        .0
        .iter()
        .map(|b| f64::from(i16::from_le_bytes(*b)))
        .collect();
    let decisive = |y: &[f64], place: Option<(usize, usize)>| {
        disturbances(y, 100.0, 1e-4).unwrap().iter().any(|d| {
            d.displacement >= 3.0 && place.is_none_or(|(a, b)| d.samples.0 < b && a < d.samples.1)
        })
    };
    for (index, clean) in counts.chunks(1_000_000).enumerate() {
        assert!(!decisive(clean, None), "channel {index} undisturbed");
        let part = &clean[..200_000];
        let mean = part.iter().sum::<f64>() / 2e5;
        let sigma = (part.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 2e5).sqrt();
        for (name, damage) in DAMAGES {
            let mut y = part.to_vec();
            damage(&mut y, sigma);
            let found = disturbances(&y, 100.0, 1e-4).unwrap();
            let there = found.iter().any(|d| d.samples.0 < TO && FROM < d.samples.1);
            println!("channel {index}, {name}: {there}");
            assert!(there, "channel {index}, {name}");
        }
    }
}
