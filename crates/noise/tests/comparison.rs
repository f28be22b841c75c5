//! Units held against each other and against limits: rates of false alarms and of wrong passes.

use proofmass_noise::{
    Conformity, FitOptions, NoiseLimit, NoiseModel, Sensor, SimulatedSensor, Term, Verdict,
    against_limit, equal_coefficients, whittle,
};

const RATE: f64 = 10.0;

fn fit(model: &NoiseModel, samples: usize, seed: u64) -> proofmass_noise::CoefficientFit {
    let sensor = SimulatedSensor::new(model.clone());
    let y = sensor.record(1, samples, RATE, seed).unwrap().remove(0);
    // Courses have tests of their own.
    let options = FitOptions {
        courses: false,
        ..FitOptions::default()
    };
    whittle(&y, RATE, &options).unwrap()
}

fn model(white: f64, flicker: f64, random_walk: f64) -> NoiseModel {
    NoiseModel {
        white,
        flicker,
        random_walk,
        ..Default::default()
    }
}

/// Sets of three equal units with white noise, flicker and a walk: a chance below 5 % in at most 5 % of them for every coefficient, within
/// the binomial bound of the number of sets at 1 in 1000. Prints the shares for `cargo test -- --nocapture`.
#[test]
fn coverage_equal_units_are_called_equal() {
    let sets: u64 = std::env::var("SETS").map_or(40, |s| s.parse().unwrap());
    let truth = model(1.0, 0.08, 0.02);
    let terms = [
        Term::Quantisation,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ];
    let mut below = [[0_u32; 3]; 5];
    for set in 0..sets {
        let fits: Vec<_> = (0..3)
            .map(|k| fit(&truth, 4000, 9000 + 3 * set + k))
            .collect();
        let all: Vec<_> = fits.iter().collect();
        for (term, below) in terms.iter().zip(&mut below) {
            let chance = equal_coefficients(*term, &all).map_or(1.0, |e| e.chance);
            for (limit, count) in [0.05, 0.01, 0.002].iter().zip(below) {
                *count += u32::from(chance < *limit);
            }
        }
    }
    for (term, below) in terms.iter().zip(&below) {
        println!("{}: {below:?} of {sets}", term.symbol());
        let n = sets as f64;
        for (limit, count) in [0.05, 0.01, 0.002].iter().zip(below) {
            let bound = n * limit + 3.1 * (n * limit * (1.0 - limit)).sqrt() + 1.0;
            assert!(
                f64::from(*count) <= bound,
                "{}: {count} of {sets} below {limit}",
                term.symbol()
            );
        }
    }
}

/// Units whose white noise differs by 10 % and whose walks differ threefold are told apart, what they share is not.
#[test]
fn known_different_units_are_told_apart() {
    let a = fit(&model(1.0, 0.0, 0.05), 20_000, 1);
    let b = fit(&model(1.1, 0.0, 0.15), 20_000, 2);
    let c = fit(&model(1.0, 0.0, 0.05), 20_000, 3);
    let equal = |term| equal_coefficients(term, &[&a, &b, &c]).unwrap();
    assert!(equal(Term::White).chance < 1e-6);
    assert!(equal(Term::RandomWalk).chance < 1e-3);
    assert!(equal(Term::Ramp).chance > 0.01);
    let pair = equal_coefficients(Term::White, &[&a, &c]).unwrap();
    assert!(pair.chance > 0.01 && pair.freedom == 1);
    assert!(pair.interval.0 < 1.0 && 1.0 < pair.interval.1);
    // The interval of what two units share is narrower than that of either.
    let own = a.get(Term::White).unwrap().verdict.interval().unwrap();
    assert!(pair.interval.1 - pair.interval.0 < 0.85 * (own.1 - own.0));
    assert!(equal_coefficients(Term::White, &[&a]).is_none());
}

/// A unit exactly at its limit passes in at most 2.5 % and fails in at most 2.5 % of records, within the binomial bound at 1 in 1000.
#[test]
fn coverage_a_unit_at_its_limit_is_undecided() {
    let records = 200;
    let mut counts = [0; 3];
    for seed in 0..records {
        let fit = fit(&model(1.0, 0.0, 0.0), 2000, 500 + seed);
        let verdict = fit.get(Term::White).unwrap().verdict;
        let check = against_limit(&verdict, 1.0, 1.0).unwrap();
        counts[check.conformity as usize] += 1;
    }
    println!("pass, fail, undecided: {counts:?}");
    // 5 expected, and 3.1 √4.9.
    assert!(counts[0] <= 12 && counts[1] <= 12, "{counts:?}");
}

#[test]
fn known_limits_in_the_units_of_data_sheets() {
    let of = |term, unit: &str, meaning: Option<&str>, sensor| {
        let mut limit = NoiseLimit::new(term, 1.0, unit);
        limit.meaning = meaning.map(str::to_owned);
        limit.conversion(sensor, 100.0).unwrap()
    };
    use Sensor::{Accelerometer, Gyroscope};
    let g = 9.806_65;
    let near = |found: Option<proofmass_noise::InUnit>, expected: f64| {
        let value = found.unwrap().value;
        assert!(
            (value / expected - 1.0).abs() < 1e-12,
            "{value}, {expected}"
        );
    };
    // Data sheets give one-sided densities and the floor of the curve.
    near(
        of(Term::White, "µg/√Hz", None, Accelerometer),
        2_f64.sqrt() * 1e6 / g,
    );
    near(
        of(Term::White, "ug/sqrt(Hz)", Some("two-sided"), Accelerometer),
        1e6 / g,
    );
    near(of(Term::White, "m/s/√h", None, Accelerometer), 60.0);
    near(
        of(Term::White, "deg/sqrt(h)", None, Gyroscope),
        60.0_f64.to_degrees(),
    );
    let floor = (2.0 * std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    near(
        of(Term::Flicker, "ug", None, Accelerometer),
        floor * 1e6 / g,
    );
    near(
        of(Term::Flicker, "°/h", Some("coefficient"), Gyroscope),
        3600_f64.to_degrees(),
    );
    near(of(Term::RandomWalk, "(m/s²)·√Hz", None, Accelerometer), 1.0);
    // In SI too; the two-sided density is the coefficient.
    near(of(Term::Flicker, "m/s²", None, Accelerometer), floor);
    near(of(Term::Flicker, "rad/s", None, Gyroscope), floor);
    near(
        of(Term::Flicker, "m/s2", Some("coefficient"), Accelerometer),
        1.0,
    );
    let root_two = 2_f64.sqrt();
    near(of(Term::White, "(m/s²)/√Hz", None, Accelerometer), root_two);
    near(of(Term::White, "(rad/s)/√Hz", None, Gyroscope), root_two);
    for meaning in ["two-sided", "coefficient"] {
        near(
            of(Term::White, "(m/s²)/√Hz", Some(meaning), Accelerometer),
            1.0,
        );
        near(
            of(Term::White, "µg/√Hz", Some(meaning), Accelerometer),
            1e6 / g,
        );
    }
    assert!(of(Term::White, "µg/√Hz", Some("sided"), Accelerometer).is_none());
    assert!(of(Term::White, "°/√h", None, Accelerometer).is_none());
    assert!(of(Term::Flicker, "µg", Some("one-sided"), Accelerometer).is_none());
    assert!(
        NoiseLimit::new(Term::White, 0.0, "µg/√Hz")
            .conversion(Accelerometer, 1.0)
            .is_err()
    );
}

#[test]
fn known_guard_bands() {
    let identified = Verdict::Identified {
        value: 2.0,
        standard_uncertainty: 0.1,
        interval: (1.8, 2.2),
        gain: 100.0,
    };
    let of = |most| against_limit(&identified, 10.0, most).unwrap().conformity;
    assert_eq!(of(22.0), Conformity::Pass);
    assert_eq!(of(21.9), Conformity::Undecided);
    assert_eq!(of(18.0), Conformity::Undecided);
    assert_eq!(of(17.9), Conformity::Fail);
    // A ramp downwards counts by its magnitude.
    let down = Verdict::Identified {
        value: -2.0,
        standard_uncertainty: 0.1,
        interval: (-2.2, -1.8),
        gain: 100.0,
    };
    let check = against_limit(&down, 1.0, 1.5).unwrap();
    assert_eq!(
        (check.conformity, check.interval),
        (Conformity::Fail, (1.8, 2.2))
    );
}
