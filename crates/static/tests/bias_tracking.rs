//! The tracked bias against simulated truth: intervals, normalised errors, innovations, findings.

use proofmass_core::velocity::BiasModel;
use proofmass_core::{BiasFilter, Error};
use proofmass_static::{BiasNoise, BiasObservations, BiasTrack, BiasTracking, RestMean};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

const WHITE: f64 = 1e-3;
const G: f64 = 9.80665;

fn markov() -> BiasNoise {
    BiasNoise {
        white: WHITE,
        model: BiasModel::GaussMarkov {
            deviation: 2e-3,
            time: 120.0,
        },
        offset: 0.5,
    }
}

fn walk() -> BiasNoise {
    BiasNoise {
        white: WHITE,
        model: BiasModel::RandomWalk {
            density: 4e-8,
            initial: 0.5,
        },
        offset: 0.0,
    }
}

struct Simulated {
    observations: BiasObservations,
    /// Truth at the end of the recording and in the middle between two rests, axis by axis.
    end: [f64; 3],
    middle: [f64; 3],
    middle_time: f64,
}

/// Forty rests of three seconds every twenty, in means of a second; `wrong` multiplies the white noise of the samples.
fn simulate(noise: &BiasNoise, seed: u64, wrong: f64) -> Simulated {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = move || -> f64 { rng.sample(StandardNormal) };
    let known = [0.0, 0.0, G];
    let mut means = Vec::new();
    let mut bias: [f64; 3] = std::array::from_fn(|_| normal() * noise.model.initial());
    let constant: [f64; 3] = std::array::from_fn(|_| normal() * noise.offset);
    let mut time = 0.0;
    let mut middle = [0.0; 3];
    let middle_time = 412.5;
    let mut go = |bias: &mut [f64; 3], to: f64, normal: &mut dyn FnMut() -> f64| {
        let dt = to - time;
        for b in bias.iter_mut() {
            *b = match noise.model {
                BiasModel::GaussMarkov { deviation, time } => {
                    let keep = (-dt / time).exp();
                    keep * *b + deviation * (1.0 - keep * keep).sqrt() * normal()
                }
                BiasModel::RandomWalk { density, .. } => *b + (density * dt).sqrt() * normal(),
            };
        }
        time = to;
    };
    for rest in 0..40 {
        for part in 0..3 {
            let at = 20.0 * f64::from(rest) + 0.5 + f64::from(part);
            if rest == 21 && part == 0 {
                go(&mut bias, middle_time, &mut normal);
                middle = std::array::from_fn(|k| bias[k] + constant[k]);
            }
            go(&mut bias, at, &mut normal);
            means.push(RestMean {
                time: at,
                duration: 1.0,
                mean: std::array::from_fn(|k| {
                    known[k] + bias[k] + constant[k] + wrong * WHITE * normal()
                }),
                known,
                rest: rest as usize,
            });
        }
    }
    go(&mut bias, 800.0, &mut normal);
    Simulated {
        observations: BiasObservations {
            span: [0.0, 800.0],
            means,
        },
        end: std::array::from_fn(|k| bias[k] + constant[k]),
        middle,
        middle_time,
    }
}

fn track(noise: &BiasNoise, simulated: &Simulated) -> BiasTrack {
    BiasTracking::new([*noise; 3])
        .track(&simulated.observations)
        .expect("a track")
}

fn codes(track: &BiasTrack) -> Vec<&str> {
    track.findings.iter().map(|f| f.code()).collect()
}

/// 600 recordings of three axes: 1800 intervals and errors of each kind. Binomial: 1710 ± 4 · 9.2; the mean of 1800 squares
/// of unit variance is one within 4 √(2/1800) = 0.133; findings: three in a thousand, and eight more than that has odds below 10⁻⁴.
#[test]
fn coverage_of_filter_and_smoother_and_false_alarms() {
    for noise in [markov(), walk()] {
        let (mut inside, mut square, mut alarms) = ([0; 2], [0.0; 2], 0);
        for seed in 0..600 {
            let simulated = simulate(&noise, seed, 1.0);
            let track = track(&noise, &simulated);
            alarms += usize::from(!track.findings.is_empty());
            let between = track
                .time
                .iter()
                .position(|t| (t - simulated.middle_time).abs() < 1e-6)
                .expect("a point between the rests");
            for (k, axis) in track.axes.iter().enumerate() {
                for (i, (estimate, truth)) in [
                    (axis.end(), simulated.end[k]),
                    (axis.smoothed[between], simulated.middle[k]),
                ]
                .into_iter()
                .enumerate()
                {
                    let z = (estimate.bias - truth) / estimate.u;
                    square[i] += z * z / 1800.0;
                    inside[i] += usize::from(z.abs() < 1.959_964);
                }
                // What the whole recording says is never worse than what came before.
                assert!(axis.smoothed[between].u <= axis.filtered[between].u * (1.0 + 1e-9));
            }
        }
        for i in 0..2 {
            assert!((1673..=1747).contains(&inside[i]), "{inside:?} {noise:?}");
            assert!((square[i] - 1.0).abs() < 0.133, "{square:?} {noise:?}");
        }
        assert!(alarms <= 10, "{alarms} of 600 {noise:?}");
    }
}

#[test]
fn known_wrong_noise_is_found() {
    for noise in [markov(), walk()] {
        for seed in 0..20 {
            let louder = track(&noise, &simulate(&noise, seed, 2.0));
            assert!(codes(&louder).contains(&"innovations-too-large"), "{seed}");
            let quieter = track(&noise, &simulate(&noise, seed, 0.3));
            assert!(
                codes(&quieter).contains(&"innovations-too-small"),
                "{seed} {:?}",
                codes(&quieter)
            );
        }
    }
    // A bias that is thought to be still, and walks.
    let still = BiasNoise {
        model: BiasModel::RandomWalk {
            density: 0.0,
            initial: 0.5,
        },
        ..walk()
    };
    for seed in 0..20 {
        let simulated = simulate(&walk(), seed, 1.0);
        let found = track(&still, &simulated);
        assert!(codes(&found).contains(&"innovations-correlated"), "{seed}");
    }
}

#[test]
fn known_steps_and_turns_are_named() {
    let noise = walk();
    let mut stepped = simulate(&noise, 3, 1.0);
    for m in stepped
        .observations
        .means
        .iter_mut()
        .filter(|m| m.rest >= 25)
    {
        m.mean[0] += 0.05;
    }
    let found = track(&noise, &stepped);
    assert_eq!(codes(&found), ["rest-out-of-line"]);
    assert_eq!(found.axes[0].consistency.deviating[0].rest, 25);
    assert!(found.axes[1].consistency.deviating.is_empty());
    let mut turned = simulate(&noise, 4, 1.0);
    for m in turned
        .observations
        .means
        .iter_mut()
        .filter(|m| m.rest >= 30)
    {
        m.mean.rotate_left(1);
    }
    assert!(codes(&track(&noise, &turned)).contains(&"rest-in-another-attitude"));
}

/// An error that all known accelerations share is an error of the bias, and its uncertainty says so.
#[test]
fn coverage_of_a_common_error_of_the_known_acceleration() {
    let noise = markov();
    let mut inside = 0;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(99);
    for seed in 0..300 {
        let mut simulated = simulate(&noise, 10_000 + seed, 1.0);
        let error: [f64; 3] = std::array::from_fn(|_| 5e-3 * rng.sample::<f64, _>(StandardNormal));
        for m in &mut simulated.observations.means {
            m.mean = std::array::from_fn(|k| m.mean[k] + error[k]);
        }
        let mut tracking = BiasTracking::new([noise; 3]);
        tracking.known_uncertainty = [5e-3; 3];
        let track = tracking.track(&simulated.observations).expect("a track");
        for (k, axis) in track.axes.iter().enumerate() {
            let end = axis.end();
            inside += usize::from((end.bias - simulated.end[k]).abs() < 1.959_964 * end.u);
            assert!((axis.known_part / 5e-3 - 1.0).abs() < 0.01);
        }
    }
    // 855 ± 4 · 6.5.
    assert!((829..=881).contains(&inside), "{inside}");
}

/// Sample by sample, as the chip does it, and in means of half a second: the same bias to a hundredth of its uncertainty.
#[test]
fn law_means_and_samples_agree() {
    let model = BiasModel::RandomWalk {
        density: 1e-8,
        initial: 0.1,
    };
    let rate = 100.0;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let (filter, mut state) =
        BiasFilter::<f64>::new(model, WHITE * WHITE * rate, 1.0 / rate).expect("a filter");
    let mut means = Vec::new();
    let mut bias = 0.03;
    for part in 0..400 {
        let mut sum = 0.0;
        for _ in 0..50 {
            bias += (1e-8 / rate).sqrt() * rng.sample::<f64, _>(StandardNormal);
            let read = bias + WHITE * rate.sqrt() * rng.sample::<f64, _>(StandardNormal);
            filter.predict(&mut state);
            filter.update(&mut state, read, 0.0);
            sum += read / 50.0;
        }
        means.push(RestMean {
            time: 0.5 * f64::from(part) + 0.25,
            duration: 0.5,
            mean: [sum; 3],
            known: [0.0; 3],
            rest: 0,
        });
    }
    let noise = BiasNoise {
        white: WHITE,
        model,
        offset: 0.0,
    };
    let observations = BiasObservations {
        span: [0.0, 200.0],
        means,
    };
    let end = BiasTracking::new([noise; 3])
        .track(&observations)
        .expect("a track")
        .axes[0]
        .end();
    let u = state.variance().sqrt();
    assert!((end.u / u - 1.0).abs() < 0.02, "{} {u}", end.u);
    // Half a mean of the walk is smoothed in the one and followed in the other: under a tenth of u.
    assert!((end.bias - state.bias()).abs() < 0.1 * u);
}

#[test]
fn refuses_what_has_no_meaning() {
    let good = simulate(&walk(), 1, 1.0).observations;
    let run = |noise: BiasNoise, observations: &BiasObservations| {
        BiasTracking::new([noise; 3]).track(observations)
    };
    assert!(run(walk(), &good).is_ok());
    let empty = BiasObservations::default();
    assert!(matches!(run(walk(), &empty), Err(Error::TooFew { .. })));
    let mut twice = good.clone();
    twice.means[5].time = twice.means[4].time;
    assert!(matches!(
        run(walk(), &twice),
        Err(Error::NotIncreasing { index: 5, .. })
    ));
    let mut nan = good.clone();
    nan.means[7].mean[1] = f64::NAN;
    assert!(matches!(
        run(walk(), &nan),
        Err(Error::NotFinite { index: 7, .. })
    ));
    let mut short = good.clone();
    short.means[0].duration = 0.0;
    assert!(run(walk(), &short).is_err());
    let mut outside = good.clone();
    outside.span = [0.0, 700.0];
    assert!(run(walk(), &outside).is_err());
    for noise in [
        BiasNoise {
            white: 0.0,
            ..walk()
        },
        BiasNoise {
            white: f64::NAN,
            ..walk()
        },
        BiasNoise {
            offset: -1.0,
            ..markov()
        },
        BiasNoise {
            model: BiasModel::GaussMarkov {
                deviation: 1e-3,
                time: 0.0,
            },
            ..markov()
        },
    ] {
        assert!(run(noise, &good).is_err(), "{noise:?}");
    }
}
