//! Whether the stated uncertainty of the velocity is the true one.

use proofmass_core::Unwatched;
use proofmass_motion::{KalmanModel, Method, MotionRecord, ReadingSource, Whiteness};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const DT: f64 = 0.01;

/// A run of the model itself: an acceleration that holds over each sample, read with white noise, and positions
/// with white noise. `factor` multiplies the noise of the accelerometer.
fn run(
    rng: &mut Xoshiro256PlusPlus,
    n: usize,
    q: f64,
    r: f64,
    factor: f64,
) -> (MotionRecord, Vec<f64>) {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let (mut x, mut v) = (0.0, 0.0);
    let (mut reading, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..n {
        let a = 3.0 * (0.05 * k as f64).sin();
        reading.push(Some(x + r.sqrt() * normal()));
        acceleration.push(a + factor * q.sqrt() * normal());
        truth.push(v);
        x += DT * v + 0.5 * DT * DT * a;
        v += DT * a;
    }
    let mut record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
    record.initial_velocity = Some(0.0);
    (record, truth)
}

fn model(q: f64, r: f64) -> KalmanModel {
    KalmanModel {
        interpolation: proofmass_motion::Hold::Zero,
        ..KalmanModel::new(q, r)
    }
}

#[test]
fn coverage_of_the_velocity_interval_is_95_per_cent() {
    let (q, r) = (0.04, 1e-6);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(101);
    for smoother in [false, true] {
        let (mut inside, mut nees) = (0usize, 0.0);
        for _ in 0..1000 {
            let (record, truth) = run(&mut rng, 120, q, r, 1.0);
            let model = model(q, r);
            let method = if smoother {
                Method::Smoother { model }
            } else {
                Method::Kalman { model }
            };
            let trace = method.run(&record).unwrap();
            let u = trace.standard_uncertainty.unwrap();
            let k = 100; // one sample a run: runs are independent, samples are not
            let z = (trace.velocity[k] - truth[k]) / u[k];
            nees += z * z;
            inside += usize::from(z.abs() < 1.959964);
        }
        // Binomial(1000, 0.95): mean 950, σ = 6.89; three σ: 929…971.
        assert!((929..=971).contains(&inside), "{smoother} {inside}");
        // Σ z² ~ χ²(1000): mean 1000, σ = 44.7; three σ.
        println!(
            "smoother {smoother}: {inside} inside, NEES {:.4}",
            nees / 1000.0
        );
        assert!((nees - 1000.0).abs() < 134.0, "{smoother} {nees}");
    }
}

#[test]
fn coverage_whiteness_flags_the_mismatched_model_only() {
    let (q, r) = (0.04, 1e-6);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(102);
    let (mut matched, mut mismatched) = (0, 0);
    for _ in 0..100 {
        for (factor, count) in [(1.0, &mut matched), (10.0, &mut mismatched)] {
            let (record, _) = run(&mut rng, 1000, q, r, factor);
            let run = model(q, r).filter(&record).unwrap();
            let innovations: Vec<f64> =
                run.innovations.iter().flatten().skip(20).copied().collect();
            let test = Whiteness::test(&innovations).unwrap();
            *count += usize::from(test.p_white < 0.01);
        }
    }
    // Binomial(100, 0.01): 6 or more has probability 5e-4. A noise ten times too small is seen every time.
    println!("flagged: matched {matched}, mismatched {mismatched} of 100");
    assert!(matched <= 6, "{matched}");
    assert_eq!(mismatched, 100);
}

#[test]
fn law_tuning_recovers_the_parameters_it_was_made_of() {
    use proofmass_motion::{BiasChoice, Hold, Tuning};
    let (q, r) = (0.04, 1e-6);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(103);
    let tuning = Tuning {
        bias: BiasChoice::None,
        interpolation: Hold::Zero,
        ..Tuning::default()
    };
    let mut inside = 0;
    for _ in 0..60 {
        let (record, _) = run(&mut rng, 1500, q, r, 1.0);
        let tuned = tuning.run(&record, &Unwatched).unwrap();
        // R from 1500 readings, most of them innovation: 1/√750 = 3.7 %; four of it.
        assert!(
            (tuned.model.reading_noise / r - 1.0).abs() < 0.15,
            "{:?}",
            tuned.model
        );
        let (below, above) = tuned.log_q_interval.unwrap();
        // The interval is of the ratio q/R.
        let error = (q / r / (tuned.model.acceleration_noise / tuned.model.reading_noise)).ln();
        inside += usize::from(error > -below && error < above);
        assert!(tuned.whiteness.p_white > 1e-5);
    }
    // Binomial(60, 0.95): mean 57, σ = 1.7; below 51 has probability 3e-3.
    assert!(inside >= 51, "{inside}");
}

/// A run whose accelerometer has an offset that walks with density `s` from a start of deviation `initial`.
fn walking(
    rng: &mut Xoshiro256PlusPlus,
    n: usize,
    noise: (f64, f64),
    s: f64,
    initial: f64,
) -> (MotionRecord, Vec<f64>) {
    let (mut record, truth) = run(rng, n, noise.0, noise.1, 1.0);
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let mut offset = initial * normal();
    for a in &mut record.acceleration {
        *a += offset;
        offset += (s * DT).sqrt() * normal();
    }
    (record, truth)
}

#[test]
fn coverage_with_an_offset_that_walks_is_95_per_cent() {
    let (q, r, s, initial) = (0.04, 1e-6, 1e-2, 0.3);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(104);
    let model = KalmanModel {
        bias: Some(proofmass_motion::BiasModel::RandomWalk {
            density: s,
            initial,
        }),
        ..model(q, r)
    };
    let mut inside = 0;
    for _ in 0..500 {
        let (record, truth) = walking(&mut rng, 220, (q, r), s, initial);
        let run = model.filter(&record).unwrap();
        let k = 200;
        let z = (run.velocity[k] - truth[k]) / run.velocity_uncertainty[k];
        inside += usize::from(z.abs() < 1.959_964);
    }
    // Binomial(500, 0.95): mean 475, σ = 4.9; three of them.
    println!("{inside} of 500");
    assert!((460..=490).contains(&inside), "{inside}");
}

#[test]
fn law_tuning_finds_an_offset_that_walks_and_none_where_there_is_none() {
    use proofmass_motion::{BiasModel, Hold, Tuning};
    let (q, r, s) = (0.04, 1e-6, 1e-2);
    let tuning = Tuning {
        interpolation: Hold::Zero,
        ..Tuning::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(105);
    let mut logs = Vec::new();
    for _ in 0..12 {
        let (record, _) = walking(&mut rng, 1500, (q, r), s, 0.3);
        let tuned = tuning.run(&record, &Unwatched).unwrap();
        let Some(BiasModel::RandomWalk { density, .. }) = tuned.model.bias else {
            panic!("the offset was not found: {:?}", tuned.model);
        };
        logs.push((density / s).ln());
        let (record, _) = run(&mut rng, 1500, q, r, 1.0);
        let tuned = tuning.run(&record, &Unwatched).unwrap();
        assert_eq!(tuned.model.bias, None, "{:?}", tuned.model);
    }
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    // A walk of 15 s that is seen at some 0.3 s has 50 independent steps: ln of its density is known to √(2/50),
    // that of twelve runs to 0.06; what the filter does not resolve costs as much again, and four of both.
    println!("mean ln(density/true) = {mean:.3}");
    assert!(mean.abs() < 0.5, "{mean}");
}

#[test]
fn law_readings_that_rest_are_said() {
    use proofmass_motion::Tuning;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(106);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    // Increments of 1 mm, passed in 2 samples and in 100: runs of two and of a hundred.
    for (speed, resting) in [(0.05, false), (0.001, true)] {
        let reading = (0..3000)
            .map(|k| Some((speed * DT * f64::from(k) / 1e-3).floor() * 1e-3))
            .collect();
        let acceleration = (0..3000).map(|_| 0.02 * normal()).collect();
        let record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
        let tuned = Tuning::default().run(&record, &Unwatched).unwrap();
        assert_eq!(
            tuned
                .findings
                .iter()
                .any(|f| f.code() == "slow-quantised-readings"),
            resting,
            "{speed}: {:?}",
            tuned.findings
        );
    }
}
