use super::measured::normal_tail;
use super::*;
use crate::{DegreesOfFreedom, Quantity};

fn measured(value: f64, u: f64, nu: f64) -> Measured {
    Measured::of(&quantity(value, u, nu))
}

fn quantity(value: f64, u: f64, nu: f64) -> Quantity {
    Quantity {
        name: "y".into(),
        unit: "1".into(),
        value,
        standard_uncertainty: u,
        dof: DegreesOfFreedom::new(nu).unwrap(),
    }
}

/// Quantiles of a normal distribution, as trials without chance.
fn trials(value: f64, u: f64) -> Measured {
    let n = 200_000;
    let draws = (0..n).map(|i| value + u * normal_quantile((f64::from(i) + 0.5) / f64::from(n)));
    Measured::of_trials(value, draws.collect()).unwrap()
}

#[test]
fn published_probabilities() {
    // `[JCGM106]` 7.4: a metal container whose burst strength is 509.7 kPa with u = 8.6 kPa, 490 kPa at least.
    let container = Limits::above(490.0)
        .unwrap()
        .probability(&measured(509.7, 8.6, f64::INFINITY));
    assert!((container - 0.99).abs() < 0.005, "{container}");
    // Motor oil SAE 40, 12.5 to 16.3 mm²/s, of 13.6 mm²/s with u = 1.8 mm²/s.
    let oil = Limits::between(12.5, 16.3)
        .unwrap()
        .probability(&measured(13.6, 1.8, f64::INFINITY));
    assert!((oil - 0.66).abs() < 0.005, "{oil}");
}

#[test]
fn law_probability_is_that_of_the_interval() {
    // Limits at y ± U hold the measurand with the probability of U.
    for nu in [2.0, 7.5, f64::INFINITY] {
        let q = quantity(3.0, 0.2, nu);
        let half = q.expanded(0.9);
        let limits = Limits::between(3.0 - half, 3.0 + half).unwrap();
        let m = Measured::of(&q);
        assert!((limits.probability(&m) - 0.9).abs() < 1e-10, "{nu}");
        assert!((Limits::above(3.0).unwrap().probability(&m) - 0.5).abs() < 1e-12);
        // Both sides of a limit make one.
        let (above, below) = (Limits::above(3.3).unwrap(), Limits::below(3.3).unwrap());
        assert!((above.probability(&m) + below.probability(&m) - 1.0).abs() < 1e-12);
    }
    assert!(Limits::between(1.0, 1.0).is_err());
}

/// A normal production and a normal measurement leave a normal item, whose mean and variance are in every textbook.
#[test]
fn law_bayes_with_normal_distributions() {
    let limits = Limits::between(-0.8, 1.1).unwrap();
    for (sd, u, y) in [(0.6, 0.2, 0.9), (0.3, 0.5, 1.4), (2.0, 0.05, -0.85)] {
        let production = Distribution::Normal { mean: 0.1, u: sd };
        let weight = sd * sd / (sd * sd + u * u);
        let (mean, left) = (0.1 + weight * (y - 0.1), u * weight.sqrt());
        let expected = limits.probability(&measured(mean, left, f64::INFINITY));
        let got = limits
            .probability_among(&production, &measured(y, u, f64::INFINITY))
            .unwrap();
        assert!((got - expected).abs() < 1e-5, "{got} {expected}");
        let of_trials = limits
            .probability_among(&production, &trials(y, u))
            .unwrap();
        assert!(
            (of_trials - expected).abs() < 2e-3,
            "{of_trials} {expected}"
        );
    }
    // An item that no production has.
    let elsewhere = Distribution::Rectangular {
        lower: 0.0,
        upper: 1.0,
    };
    let far = limits.probability_among(&elsewhere, &measured(80.0, 0.1, f64::INFINITY));
    assert!(matches!(far, Err(Error::OutOfRange { .. })), "{far:?}");
    let counted = Distribution::Poisson {
        lower: 0.0,
        scale: 1.0,
        mean: 3.0,
    };
    assert!(
        limits
            .probability_among(&counted, &measured(1.0, 0.1, 9.0))
            .is_err()
    );
}

/// Without guard band and with a flat production the risks at one limit are alike; all shares sum to one.
#[test]
fn law_global_risks() {
    let limits = Limits::between(-1.0, 1.0).unwrap();
    let (sd, u) = (0.6, 0.2);
    let production = Distribution::Normal { mean: 0.0, u: sd };
    let normal = measured(5.0, u, f64::INFINITY);
    let risk = limits.global_risk(&limits, &production, &normal).unwrap();
    // Observed values are normal with √(sd² + u²): accepted = conforming − producer + consumer.
    let inside = |s: f64| 1.0 - 2.0 * normal_tail(1.0 / s);
    let accepted = inside(sd) - risk.producer + risk.consumer;
    assert!((accepted - inside(sd.hypot(u))).abs() < 1e-8);
    let guarded = limits.narrowed(Limits::guard_band(u, 0.05));
    let tighter = limits.global_risk(&guarded, &production, &normal).unwrap();
    assert!(tighter.consumer < risk.consumer && tighter.producer > risk.producer);
    // One limit at the mean: P(accepted, not conforming) = atan(u/sd)/(2π).
    let half = Limits::above(0.0).unwrap();
    let exact = (u / sd).atan() / std::f64::consts::TAU;
    for (error, allowed) in [(normal, 1e-7), (trials(-3.0, u), 1e-4)] {
        let risk = half.global_risk(&half, &production, &error).unwrap();
        assert!((risk.consumer - exact).abs() < allowed, "{risk:?} {exact}");
        assert!((risk.producer - exact).abs() < allowed, "{risk:?} {exact}");
    }
}

/// An error that leans to one side: an estimate lies above its item as far as the draws lie below the estimate.
#[test]
fn law_skewed_errors_turn_around() {
    let limits = Limits::below(1.0).unwrap();
    // Draws at the estimate and 0.5 above it, equally often: the estimate is right or 0.5 too small.
    let error = Measured::of_trials(0.0, vec![0.0, 0.5]).unwrap();
    let production = Distribution::Rectangular {
        lower: 0.0,
        upper: 2.0,
    };
    let risk = limits.global_risk(&limits, &production, &error).unwrap();
    // Items from 1 to 1.5, a quarter of all, are accepted each second time; none that conforms is rejected.
    assert!(
        (risk.consumer - 0.125).abs() < 1e-3 && risk.producer < 1e-3,
        "{risk:?}"
    );
}

/// An item exactly at a limit is called neither way but by chance: the two sides of its interval decide one question each.
#[test]
fn coverage_an_item_at_its_limit_is_undecided() {
    let limits = Limits::below(1.0).unwrap();
    let mut counts = [0u32; 3];
    let n = 4000;
    for i in 0..n {
        // Estimates at the quantiles of their distribution about the limit.
        let estimate = 1.0 + 0.1 * normal_quantile((f64::from(i) + 0.5) / f64::from(n));
        let half = 0.1 * normal_quantile(0.975);
        let judged = limits.judge((estimate - half, estimate + half));
        counts[judged as usize] += 1;
    }
    // 2.5 % each way.
    assert_eq!(counts, [100, 100, 3800]);
    // Both ends of two limits count.
    let both = Limits::between(-1.0, 1.0).unwrap();
    assert_eq!(both.judge((-1.5, 1.5)), Judgement::Undecided);
    assert_eq!(both.judge((-3.0, -1.5)), Judgement::Fail);
    assert_eq!(both.judge((-1.0, 1.0)), Judgement::Pass);
}

/// The same verdict as that of the two rules it is made of.
#[test]
fn law_a_judgement_is_guarded_acceptance_and_guarded_rejection() {
    let limits = Limits::between(-0.5, 1.0).unwrap();
    for k in -40..40 {
        let (y, half) = (0.05 * f64::from(k), 0.13);
        let m = measured(y, half / 1.96, f64::INFINITY);
        let accepted = |factor| {
            let rule = DecisionRule::GuardBand { factor };
            limits.decide(&m, half, rule, None).unwrap().accepted
        };
        let expected = match (accepted(1.0), accepted(-1.0)) {
            (true, _) => Judgement::Pass,
            (_, false) => Judgement::Fail,
            _ => Judgement::Undecided,
        };
        assert_eq!(limits.judge((y - half, y + half)), expected, "{y}");
    }
}
