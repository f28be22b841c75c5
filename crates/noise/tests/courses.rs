//! Courses that are not noise are taken out of it and named; the slowest cycles have a test of their own. The maps are
//! `examples/courses.rs`.

use proofmass_noise::{
    AnalysisOptions, CoefficientFit, CourseShape, FitOptions, FitRecord, GaussMarkov, NoiseChannel,
    NoiseModel, Reason, Sensor, Term, Verdict, analyse, conservative, simulate, whittle,
    whittle_record,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

const RATE: f64 = 10.0;
const SAMPLES: usize = 20_000;

fn source(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// White noise of N = 1 with a course over it.
fn white(seed: u64, rate: f64, course: impl Fn(f64) -> f64) -> Vec<f64> {
    let model = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    let mut samples = simulate(&model, SAMPLES, rate, &mut source(seed)).unwrap();
    for (i, y) in samples.iter_mut().enumerate() {
        *y += course(i as f64 / rate);
    }
    samples
}

fn codes(fit: &CoefficientFit) -> Vec<&str> {
    fit.findings.iter().map(|f| f.code()).collect()
}

/// Nothing grows towards low frequencies, and the true size lies within five standard uncertainties.
fn noise_is_white(fit: &CoefficientFit, size: f64) {
    for term in [Term::Flicker, Term::RandomWalk, Term::Ramp] {
        assert_eq!(fit.value(term), None, "{term:?}");
    }
    let [course] = &fit.courses[..] else {
        panic!("{:?}", fit.courses);
    };
    let (value, u) = (
        course.size.value().unwrap(),
        course.size.standard_uncertainty().unwrap(),
    );
    assert!((value - size).abs() < 5.0 * u, "{course:?}");
}

/// Two standard deviations of a sample over 120 s, which were called a random walk.
#[test]
fn law_a_warm_up_is_no_random_walk() {
    let size = 2.0 * RATE.sqrt();
    let samples = white(1, RATE, |t| size * (-t / 120.0).exp());
    let fit = whittle(&samples, RATE, &FitOptions::default()).unwrap();
    noise_is_white(&fit, size);
    assert!(codes(&fit).contains(&"output-settles"));
    assert!(matches!(
        fit.courses[0].shape,
        CourseShape::Exponential { time } if (80.0..180.0).contains(&time)
    ));
    // As before where it is not sought.
    let options = FitOptions {
        courses: false,
        ..FitOptions::default()
    };
    let fit = whittle(&samples, RATE, &options).unwrap();
    assert!(fit.get(Term::RandomWalk).unwrap().verdict.is_identified());
}

/// Half a standard deviation of a sample; the curve without it is that of white noise, and it is no disturbance
/// besides.
#[test]
fn law_a_lasting_step_is_no_random_walk() {
    let size = 0.5 * RATE.sqrt();
    let samples = white(2, RATE, |t| if t > 741.0 { size } else { 0.0 });
    let channel = NoiseChannel {
        name: "x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate: &samples,
    };
    let analysis = analyse(&[channel], None, RATE, &AnalysisOptions::default()).unwrap();
    let channel = &analysis.channels[0];
    let fit = channel.whittle.as_ref().unwrap();
    noise_is_white(fit, size);
    let (low, high) = fit.courses[0].interval.unwrap();
    assert!(low < 741.0 && 741.0 < high, "{low} {high}");
    assert_eq!(channel.taken_off(), "step");
    let without = channel.compensated.as_ref().unwrap();
    let last = without.points.last().unwrap();
    assert!(last.deviation < 3.0 / last.tau.sqrt(), "{last:?}");
    let said: Vec<&str> = channel.findings.iter().map(|f| f.code()).collect();
    assert!(said.contains(&"mean-steps"), "{said:?}");
    assert!(!said.contains(&"disturbance"), "{said:?}");
}

/// A record of 1.16 days.
#[test]
fn law_a_cycle_of_the_day_is_no_random_walk() {
    let rate = 0.2;
    let samples = white(3, rate, |t| 0.15 * (2.0 * PI * t / 86_400.0 + 1.0).sin());
    let fit = whittle(&samples, rate, &FitOptions::default()).unwrap();
    noise_is_white(&fit, 0.15);
    assert!(codes(&fit).contains(&"day-cycle"));
}

/// The output follows a temperature that rises and falls, from somewhere else at the start.
fn followed(seed: u64, lag: f64) -> CoefficientFit {
    let mut rng = source(seed + 500);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let course = |t: f64| 1.4 * (2.0 * PI * 3.3 * t / 2000.0 + 0.4).sin();
    let temperature: Vec<f64> = (0..SAMPLES)
        .map(|i| 20.0 + course(i as f64 / RATE) + 0.002 * noise())
        .collect();
    let mut inside = 0.3;
    let mut samples = white(seed, RATE, |_| 0.0);
    for (i, y) in samples.iter_mut().enumerate() {
        inside += (course(i as f64 / RATE) - inside) / (lag * RATE);
        *y += inside;
    }
    let (stretches, beside) = ([&samples[..]], [&temperature[..]]);
    let record = FitRecord {
        temperature: Some(&beside),
        ..FitRecord::new(&stretches)
    };
    whittle_record(&record, RATE, &FitOptions::default()).unwrap()
}

/// 60 s that nobody states: sensitivity and lag are held, and no drift is left.
#[test]
fn law_an_unstated_lag_is_found() {
    let fit = followed(4, 60.0);
    let found = fit.temperature.as_ref().unwrap();
    let (low, high) = found.verdict.interval().unwrap();
    assert!(low < 1.0 && 1.0 < high, "{found:?}");
    let (low, high) = found.lag_interval.unwrap();
    assert!(low < 60.0 && 60.0 < high.unwrap(), "{found:?}");
    assert!(codes(&fit).contains(&"temperature-lag-found"));
    assert_eq!(fit.value(Term::RandomWalk), None);
    assert_eq!(fit.value(Term::Flicker), None);
}

/// 600 s in a record of 2000 s: there is no sensitivity, and it is said why.
#[test]
fn refuses_a_sensitivity_behind_a_lag_too_long_for_the_record() {
    let fit = followed(5, 600.0);
    let found = fit.temperature.as_ref().unwrap();
    assert!(
        matches!(
            found.verdict,
            Verdict::NotIdentifiable {
                reason: Reason::LagOpen { at_least },
                ..
            } if at_least < 600.0
        ),
        "{found:?}"
    );
    assert!(codes(&fit).contains(&"temperature-lag-open"));
    assert_eq!(fit.value(Term::RandomWalk), None);
}

/// A process that is not sought levels off below the frequencies that B and K are fitted to: the slowest cycles say so, and files for
/// filters too.
#[test]
fn law_slowest_cycles_have_a_test_of_their_own() {
    let model = NoiseModel {
        white: 1.0,
        gauss_markov: vec![GaussMarkov {
            standard_deviation: 2.0,
            correlation_time: 40.0,
        }],
        ..Default::default()
    };
    let samples = simulate(&model, 40_000, RATE, &mut source(6)).unwrap();
    let fit = whittle(&samples, RATE, &FitOptions::default()).unwrap();
    let misfit = fit.slow_misfit.unwrap();
    assert!(misfit.ratio < 0.6 && misfit.chance < 0.01, "{misfit:?}");
    assert!(codes(&fit).contains(&"slow-noise-misfit"));
    let walk = fit.get(Term::RandomWalk).unwrap().verdict;
    assert!(walk.estimate().unwrap() < misfit.whole, "{walk:?}");
    let file = conservative(Term::RandomWalk, &[&fit]).unwrap();
    assert!(file.reason.contains("slow-noise-misfit"), "{}", file.reason);
}
