//! THEOH, the Allan deviation over time, three sensors by themselves, states of a filter.

use proofmass_noise::{
    Bias, DeviationOptions, FitOptions, NoiseModel, NoiseRecord, SimulatedSensor, Statistic, Taus,
    Term, deviation, dynamic_deviation, separated_deviations, state_space, whittle,
};

fn record(model: &NoiseModel, samples: usize, rate: f64, seed: u64) -> Vec<f64> {
    SimulatedSensor::new(model.clone())
        .record(1, samples, rate, seed)
        .unwrap()
        .remove(0)
}

fn white() -> NoiseModel {
    NoiseModel {
        white: 1.0,
        ..Default::default()
    }
}

/// Up to a fifth of the record it is OADEV, beyond it THEO1 scaled to the record's Allan variance, to three quarters of the record.
#[test]
fn law_theoh_is_made_of_its_parts() {
    let y = record(&white(), 700, 1.0, 1);
    let curve = |statistic, taus, bias| {
        let options = DeviationOptions {
            taus,
            bias,
            ..Default::default()
        };
        deviation(NoiseRecord::Rate(&y), 1.0, statistic, &options).unwrap()
    };
    let whole = curve(Statistic::TheoHybrid, Taus::Octave, Bias::default());
    assert!(whole.points.last().unwrap().tau > 350.0);
    let tau: Vec<f64> = whole.points.iter().map(|p| p.tau).collect();
    assert!(tau.windows(2).all(|w| w[1] > w[0]), "{tau:?}");
    let (near, far): (Vec<_>, Vec<_>) = whole.points.iter().partition(|p| p.tau <= 140.0);
    assert!(far.len() >= 2);
    let factors = |points: &[&proofmass_noise::DeviationPoint]| {
        Taus::Factors(points.iter().map(|p| p.factor).collect())
    };
    let allan = curve(Statistic::OverlappingAllan, factors(&near), Bias::default());
    let theo = curve(Statistic::Theo1, factors(&far), Bias::FromRecord);
    for (a, b) in near
        .iter()
        .zip(&allan.points)
        .chain(far.iter().zip(&theo.points))
    {
        assert_eq!((a.deviation, a.interval), (b.deviation, b.interval));
        assert!(a.interval.is_some());
    }
}

/// At half the record the mean of its square is the Allan variance, for white noise, flicker noise and a walk: within four standard
/// deviations of the mean of 60 records and 6 %, what scaling by the record leaves.
#[test]
fn law_theoh_has_no_bias() {
    let models = [
        white(),
        NoiseModel {
            flicker: 1.0,
            ..Default::default()
        },
        NoiseModel {
            random_walk: 1.0,
            ..Default::default()
        },
    ];
    for model in models {
        let options = DeviationOptions {
            taus: Taus::Factors(vec![150]),
            ..Default::default()
        };
        let ratios: Vec<f64> = (0..60)
            .map(|seed| {
                let y = record(&model, 300, 1.0, 100 + seed);
                let curve =
                    deviation(NoiseRecord::Rate(&y), 1.0, Statistic::TheoHybrid, &options).unwrap();
                let p = &curve.points[0];
                assert_eq!(p.tau, 150.0);
                p.deviation.powi(2) / model.sampled_allan_variance(150, 1.0)
            })
            .collect();
        let mean = ratios.iter().sum::<f64>() / 60.0;
        let scatter = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 59.0).sqrt();
        println!("{mean:.3} ± {:.3}", scatter / 60_f64.sqrt());
        assert!(
            (mean - 1.0).abs() < 0.06 + 4.0 * scatter / 60_f64.sqrt(),
            "{mean} {scatter}"
        );
    }
}

/// A window's curve is that of its samples.
#[test]
fn law_windows_are_records() {
    let y = record(&white(), 1000, 10.0, 2);
    let options = DeviationOptions::default();
    let windows = dynamic_deviation(&y, 10.0, 4, &options).unwrap();
    assert_eq!(windows.len(), 4);
    let alone = deviation(
        NoiseRecord::Rate(&y[500..750]),
        10.0,
        Statistic::OverlappingAllan,
        &options,
    )
    .unwrap();
    assert_eq!((windows[2].from, windows[2].to), (50.0, 75.0));
    assert_eq!(windows[2].curve, alone);
    assert!(dynamic_deviation(&y, 10.0, 200, &options).is_err());
    assert!(dynamic_deviation(&y, 10.0, 100_000, &options).is_err());
}

/// Three sensors of 1, 2 and 3 that shake together: each by itself, within four of the stated uncertainties up to a twentieth of the record
/// (beyond, the uncertainty is one of few degrees of freedom itself); clocks against a third as well.
#[test]
fn law_three_sensors_are_separated() {
    let alone: Vec<Vec<f64>> = [1.0, 2.0, 3.0]
        .iter()
        .zip(5..)
        .map(|(n, seed)| {
            let model = NoiseModel {
                white: *n,
                ..Default::default()
            };
            record(&model, 20_000, 1.0, seed)
        })
        .collect();
    let common = NoiseModel {
        random_walk: 2.0,
        ..Default::default()
    };
    let shake = record(&common, 20_000, 1.0, 9);
    let seen: Vec<Vec<f64>> = alone
        .iter()
        .map(|y| y.iter().zip(&shake).map(|(a, b)| a + b).collect())
        .collect();
    let options = DeviationOptions::default();
    let points = separated_deviations([&seen[0], &seen[1], &seen[2]], 1.0, &options).unwrap();
    assert!(points.len() >= 13);
    for p in points.iter().filter(|p| p.tau <= 1000.0) {
        for (k, n) in [1.0_f64, 2.0, 3.0].iter().enumerate() {
            let (v, u) = (p.variances[k], p.uncertainties[k]);
            let truth = n * n / p.tau;
            assert!(
                (v - truth).abs() < 4.0 * u,
                "τ = {}: {v} ± {u}, {truth}",
                p.tau
            );
        }
    }
    let difference =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(x, y)| x - y).collect() };
    let clocks = [
        difference(&alone[0], &alone[2]),
        difference(&alone[1], &alone[2]),
    ];
    let zeros = vec![0.0; 20_000];
    let again = separated_deviations([&clocks[0], &clocks[1], &zeros], 1.0, &options).unwrap();
    for (p, q) in points.iter().zip(&again) {
        for k in 0..3 {
            assert!((p.variances[k] / q.variances[k] - 1.0).abs() < 1e-6);
        }
    }
}

/// The states have the density of flicker noise within the stated error, over records from 10³ to 10⁶ samples.
#[test]
fn law_states_have_the_density_of_flicker_noise() {
    let model = NoiseModel {
        white: 1.0,
        flicker: 0.7,
        ..Default::default()
    };
    let y = record(&model, 20_000, 10.0, 3);
    let fit = whittle(&y, 10.0, &FitOptions::default()).unwrap();
    for duration in [100.0, 2000.0, 1e5] {
        let states = state_space(&fit, 10.0, duration).unwrap();
        let error = states.flicker_error.unwrap();
        assert!(error < 0.025, "{duration}: {error}");
        let (low, high) = states.flicker_band.unwrap();
        assert_eq!((low, high), (1.0 / duration, 2.5));
        let b2 = fit.model.flicker.powi(2);
        for f in [low, 3.0 * low, 0.1, 1.0, high] {
            // The density of an autoregression of order one, directly.
            let density: f64 = states
                .components
                .iter()
                .filter(|c| c.term == Term::Flicker)
                .map(|c| {
                    let w = 2.0 * std::f64::consts::PI * f / 10.0;
                    let gap = 1.0 - 2.0 * c.transition * w.cos() + c.transition.powi(2);
                    2.0 * c.process / (10.0 * gap)
                })
                .sum();
            let expected = 2.0 * b2 / (20.0 * (std::f64::consts::PI * f / 10.0).sin());
            assert!(
                (density / expected - 1.0).abs() < 1.01 * error + 1e-9,
                "{f} Hz"
            );
        }
    }
    // Without a walk in the record its limit moves the bias.
    let states = state_space(&fit, 10.0, 2000.0).unwrap();
    let walk = states
        .components
        .iter()
        .find(|c| c.term == Term::RandomWalk);
    assert!(walk.is_some_and(|c| c.process > 0.0));
}
