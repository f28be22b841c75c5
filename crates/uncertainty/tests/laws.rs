//! Laws: what must hold for every model, and the coverage that the intervals promise.
use crate::common::*;
use proofmass_uncertainty::*;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::ops::ControlFlow;

/// |Σ shares − 1| is rounding of a sum of n terms: 1e-12 is generous.
#[test]
fn law_budget_sums_to_the_variance() {
    let joint = impedance()
        .add(normal("unused", 1.0, 0.1))
        .single()
        .unwrap();
    let linear = propagate(&Impedance, &joint).unwrap();
    for name in ["R", "X", "Z"] {
        let sum: f64 = linear
            .budget(name)
            .unwrap()
            .iter()
            .map(|line| line.share)
            .sum();
        assert!((sum - 1.0).abs() < 1e-12, "{name}");
    }
    let linear = propagate(&EndGauge, &end_gauge().single().unwrap()).unwrap();
    let q = linear.get("length").unwrap();
    let lines = linear.budget("length").unwrap();
    let squares: f64 = lines.iter().map(|l| l.contribution.powi(2)).sum();
    assert!((squares.sqrt() / q.standard_uncertainty - 1.0).abs() < 1e-12);
    assert!(
        lines
            .windows(2)
            .all(|w| w[0].contribution >= w[1].contribution)
    );
    // The estimate's own budget says the same.
    let own: f64 = linear
        .estimate()
        .budget("length")
        .unwrap()
        .iter()
        .map(|l| l.share)
        .sum();
    assert!((own - 1.0).abs() < 1e-12);
}

/// Linear model, correlated normal inputs: M = 2e5 leaves u/√(2M) = 0.16 % of u (bound: four of it) and
/// (1 − r²)/√M = 0.2 % of correlation (four: 0.9 %).
#[test]
fn law_linear_models_agree_with_monte_carlo() {
    model!(Linear2, ["a" "1", "b" "1"], |x, y, T| {
        y[0] = x[0] + T::from(2.0) * x[1] - x[2];
        y[1] = x[1] + x[2];
    });
    let joint = Inputs::new()
        .add(normal("p", 1.0, 0.3))
        .add(normal("q", -1.0, 0.2))
        .add(normal("r", 5.0, 0.4))
        .correlate("p", "q", 0.7)
        .correlate("q", "r", -0.3)
        .single()
        .unwrap();
    let linear = propagate(&Linear2, &joint).unwrap();
    let sampled = MonteCarlo::new(7)
        .trials(Trials::Fixed(200_000))
        .run(&Linear2, &joint)
        .unwrap();
    for (k, name) in ["a", "b"].into_iter().enumerate() {
        let q = linear.get(name).unwrap();
        let o = &sampled.outputs[k];
        assert!((o.standard_uncertainty.unwrap() / q.standard_uncertainty - 1.0).abs() < 0.0064);
        assert!((o.mean - q.value).abs() < 4.0 * q.standard_uncertainty / 200_000f64.sqrt());
    }
    let r = |c: &Covariance| c.correlation(0, 1).unwrap();
    assert!((r(&sampled.covariance) - r(linear.estimate().covariance())).abs() < 0.009);
    assert!(
        sampled
            .validate(&linear, 1)
            .iter()
            .all(|v| v.verdict == Verdict::Validated)
    );
    // Two normal outputs: the ellipsoid of 95 % has k = √(−2 ln 0.05) = 2.448, and is the smallest region. Its
    // mesh of 63 cells a side counts whole cells along the rim, some per cent too many or too few.
    let region = sampled.region.unwrap();
    assert!((region.ellipsoid_factor - 2.448).abs() < 0.02);
    let ratio = region.smallest_content.unwrap() / region.ellipsoid_content;
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
}

#[test]
fn law_units_scale_the_answer() {
    let scaled = |s: f64| {
        model!(Ratio, ["y" "1"], |x, y, T| {
            y[0] = x[0] / x[1] * x[1].ln();
        });
        let joint = Inputs::new()
            .add(normal("a", 3.0 * s, 0.1 * s))
            .add(normal("b", 2.0, 0.2))
            .single()
            .unwrap();
        propagate_second_order(&Ratio, &joint).unwrap()
    };
    let (one, thousand) = (scaled(1.0), scaled(1e3));
    let u = |l: &Linear| l.get("y").unwrap().standard_uncertainty;
    assert!((u(&thousand) / u(&one) / 1e3 - 1.0).abs() < 1e-13);
    let second = |l: &Linear| l.second_order()[0].unwrap().standard_uncertainty;
    assert!((second(&thousand) / second(&one) / 1e3 - 1.0).abs() < 1e-12);
}

/// A mean of n readings: what all share stays, what each has alone falls by √n. By propagation and by trials.
#[test]
fn law_grouping_keys_average_only_what_is_independent() {
    struct Mean(usize);
    impl Model for Mean {
        fn outputs(&self) -> Vec<(String, String)> {
            vec![("mean".into(), "1".into())]
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            // Draws of the common input come first: one of them or n.
            let n = x.len() - usize::from(x.len() != self.0);
            let start = x.len() - n;
            let sum = x[start..].iter().fold(T::from(0.0), |s, &x| s + x);
            let common = x[..start].iter().fold(T::from(0.0), |s, &x| s + x);
            y[0] = sum / T::from(n as f64) + common;
        }
    }
    for n in [4, 16, 64] {
        let runs: Vec<Labels> = (0..n).map(|i| Labels::new().with("run", i)).collect();
        let d = || Distribution::Normal { mean: 0.0, u: 1.0 };
        let own = Inputs::new()
            .add(Input::new("own", "1", d()).varies_with(["run"]))
            .joint(&runs)
            .unwrap();
        let both = Inputs::new()
            .add(Input::new("common", "1", d()))
            .add(Input::new("own", "1", d()).varies_with(["run"]))
            .joint(&runs)
            .unwrap();
        let u = |joint: &JointInputs| {
            propagate(&Mean(n), joint)
                .unwrap()
                .get("mean")
                .unwrap()
                .standard_uncertainty
        };
        let independent = 1.0 / (n as f64).sqrt();
        assert!(
            (u(&own) - independent).abs() < 1e-14,
            "independent falls by √n"
        );
        assert!(
            (u(&both) - (1.0 + independent * independent).sqrt()).abs() < 1e-14,
            "common stays"
        );
        assert_eq!(both.draws().len(), n + 1);

        // The same through the covariance of the observations, common alone: the mean keeps u = 1.
        let common = Inputs::new()
            .add(Input::new("common", "1", d()))
            .joint(&runs)
            .unwrap();
        let c = common.observation_covariance(&vec![1.0; n]).unwrap();
        let mean = c.propagate(&vec![1.0 / n as f64; n]).unwrap();
        assert!((mean.standard_uncertainty(0) - 1.0).abs() < 1e-14);

        let sampled = MonteCarlo::new(2)
            .trials(Trials::Fixed(40_000))
            .run(&Mean(n), &both)
            .unwrap();
        let ratio = sampled.outputs[0].standard_uncertainty.unwrap() / u(&both);
        assert!((ratio - 1.0).abs() < 0.0142, "four times 1/√(2 · 40 000)");
    }
}

/// One estimate of σ serves all readings: their mean keeps its ν, in both calculations.
#[test]
fn law_readings_share_one_estimate_of_sigma() {
    struct Mean;
    impl Model for Mean {
        fn outputs(&self) -> Vec<(String, String)> {
            vec![("mean".into(), "1".into())]
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            y[0] = x.iter().fold(T::from(0.0), |s, &x| s + x) / T::from(x.len() as f64);
        }
    }
    let runs: Vec<Labels> = (0..9).map(|i| Labels::new().with("run", i)).collect();
    let d = Distribution::StudentT {
        location: 0.0,
        scale: 3.0,
        dof: 5.0,
    };
    let joint = Inputs::new()
        .add(Input::new("x", "1", d).varies_with(["run"]))
        .joint(&runs)
        .unwrap();
    let q = propagate(&Mean, &joint).unwrap().get("mean").unwrap();
    assert!((q.standard_uncertainty - 1.0).abs() < 1e-14 && (q.dof.get() - 5.0).abs() < 1e-12);
    let sampled = MonteCarlo::new(2)
        .trials(Trials::Fixed(400_000))
        .run(&Mean, &joint)
        .unwrap();
    let upper = sampled.outputs[0].symmetric.upper;
    // √(p(1−p)/M)/f(2.57) = 2.5e-4/0.030 = 0.008; three times that.
    assert!(
        (upper - q.dof.coverage_factor(0.95)).abs() < 0.025,
        "{upper}"
    );
}

/// V = I Z cos …, written the other way round: an implicit model gives the explicit one's covariance.
#[test]
fn law_implicit_equals_explicit() {
    struct Circuit;
    impl Implicit for Circuit {
        fn outputs(&self) -> Vec<(String, String)> {
            Impedance.outputs()
        }
        fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]) {
            h[0] = y[2] * x[1] - x[0];
            h[1] = y[0] * y[0] + y[1] * y[1] - y[2] * y[2];
            h[2] = y[0] * x[2].sin() - y[1] * x[2].cos();
        }
    }
    let joint = impedance().single().unwrap();
    let implicit = propagate_implicit(&Circuit, &[100.0, 200.0, 250.0], &joint).unwrap();
    let explicit = propagate(&Impedance, &joint).unwrap();
    for i in 0..3 {
        let (a, b) = (
            &implicit.estimate().components()[i],
            &explicit.estimate().components()[i],
        );
        assert!((a.value / b.value - 1.0).abs() < 1e-12);
        for j in 0..3 {
            let (a, b) = (
                implicit.estimate().covariance()[(i, j)],
                explicit.estimate().covariance()[(i, j)],
            );
            assert!((a - b).abs() < 1e-9 * b.abs(), "{i} {j}");
        }
    }
}

/// Binomial bound: four standard deviations of a share 0.95 in 20 000 repetitions are 4 √(0.95 · 0.05 / 20 000)
/// = 0.0062.
/// A reading that never changes has no correlation to give, and must not take that of its companion.
#[test]
fn regress_a_constant_reading_beside_another_keeps_its_own_draws() {
    let p = [101_310.0, 101_325.0, 101_340.0, 101_320.0, 101_330.0];
    let t = [293.1; 5];
    for columns in [
        [("p", "Pa", &p[..]), ("T", "K", &t[..])],
        [("T", "K", &t[..]), ("p", "Pa", &p[..])],
    ] {
        let inputs = Inputs::new().observed(&columns).unwrap().single().unwrap();
        model!(First, ["y" "1"], |x, y, T| { y[0] = x[0] + T::from(0.0) * x[1]; });
        let n = 100_000;
        let sampled = MonteCarlo::new(2)
            .trials(Trials::Fixed(n))
            .run(&First, &inputs)
            .unwrap();
        let (mean, u) = match columns[0].0 {
            "p" => (101_325.0, 5.0),
            _ => (293.1, 0.0),
        };
        // t with ν = 4 has the standard deviation √2 u; four standard deviations of the mean of n.
        let bound = 4.0 * 2f64.sqrt() * u / (n as f64).sqrt() + 1e-9;
        assert!(
            (sampled.outputs[0].mean - mean).abs() <= bound,
            "{}",
            sampled.outputs[0].mean
        );
    }
}

/// A certificate with U, k and ν is drawn from Student's t: the trials then give the interval that k promises.
#[test]
fn law_degrees_of_freedom_of_a_normal_input_reach_the_trials() {
    let inputs = Inputs::new()
        .add(normal("x", 1.0, 0.1).dof(dof(4.0)))
        .single()
        .unwrap();
    model!(Itself, ["y" "1"], |x, y, T| { y[0] = x[0] + T::from(0.0); });
    let linear = propagate(&Itself, &inputs).unwrap();
    let sampled = MonteCarlo::new(2)
        .trials(Trials::Fixed(400_000))
        .run(&Itself, &inputs)
        .unwrap();
    let expanded = linear.get("y").unwrap().expanded(0.95);
    assert!((expanded - 0.27764).abs() < 1e-5); // t_0.975(4) = 2.7764
    let interval = sampled.outputs[0].symmetric;
    let bound = 4.0 * sampled.outputs[0].symmetric_scatter;
    assert!(bound < 0.01);
    assert!(
        (interval.upper - 1.0 - expanded).abs() < bound,
        "{interval:?}"
    );
    assert!(
        (1.0 - interval.lower - expanded).abs() < bound,
        "{interval:?}"
    );
}

/// y³ + y = x, solved by iteration and by Cardano's formula.
struct Iterated;
impl Implicit for Iterated {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![("y".into(), "1".into())]
    }
    fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]) {
        h[0] = y[0].powi(3) + y[0] - x[0];
    }
}
struct Cardano;
impl Model for Cardano {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![("y".into(), "1".into())]
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let half = x[0] / T::from(2.0);
        let root = (half * half + T::from(1.0 / 27.0)).sqrt();
        let third = T::from(1.0 / 3.0);
        y[0] = (root + half).powf(third) - (root - half).powf(third);
    }
}

#[test]
fn law_an_implicit_model_runs_like_its_explicit_solution() {
    let inputs = Inputs::new().add(normal("x", 2.0, 0.5)).single().unwrap();
    let solved = Solved::new(Iterated, vec![1.0]);
    // First and second derivatives: rounding alone, a few ulp of values near one through a dozen operations.
    let (a, b) = (
        propagate_second_order(&solved, &inputs).unwrap(),
        propagate_second_order(&Cardano, &inputs).unwrap(),
    );
    let (qa, qb) = (a.get("y").unwrap(), b.get("y").unwrap());
    assert!((qa.value - qb.value).abs() < 1e-14);
    assert!((qa.standard_uncertainty - qb.standard_uncertainty).abs() < 1e-14);
    assert!(
        (a.second_order()[0].unwrap().shift - b.second_order()[0].unwrap().shift).abs() < 1e-13
    );
    assert!(
        a.second_order()[0].unwrap().shift.abs() > 1e-3,
        "the test needs a curved model"
    );
    // The same seed draws the same inputs, so the trials agree one by one.
    let run = MonteCarlo::new(3).trials(Trials::Fixed(20_000));
    let (a, b) = (
        run.run(&solved, &inputs).unwrap(),
        run.run(&Cardano, &inputs).unwrap(),
    );
    let (a, b) = (&a.outputs[0], &b.outputs[0]);
    assert!((a.mean - b.mean).abs() < 1e-13);
    assert!((a.symmetric.lower - b.symmetric.lower).abs() < 1e-13);
    assert!((a.symmetric.upper - b.symmetric.upper).abs() < 1e-13);
    // A start that is not a number gives no solution, and no result.
    let lost = Solved::new(Iterated, vec![f64::NAN]);
    assert!(run.run(&lost, &inputs).is_err());
}

/// A circle through four points of which both coordinates err: the fit is implicit in every input.
struct Circle;
impl LeastSquares for Circle {
    fn outputs(&self) -> Vec<(String, String)> {
        ["x0", "y0", "r"].map(|n| (n.into(), "m".into())).to_vec()
    }
    fn residuals(&self) -> usize {
        4
    }
    fn residual<T: Number>(&self, y: &[T], x: &[T], r: &mut [T]) {
        for i in 0..4 {
            let (dx, dy) = (x[2 * i] - y[0], x[2 * i + 1] - y[1]);
            r[i] = (dx * dx + dy * dy).sqrt() - y[2];
        }
    }
}

#[test]
fn law_a_fit_agrees_with_its_own_trials() {
    let mut inputs = Inputs::new();
    for (i, (x, y)) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
        .into_iter()
        .enumerate()
    {
        inputs =
            inputs
                .add(normal(&format!("x{i}"), x, 0.01))
                .add(normal(&format!("y{i}"), y, 0.01));
    }
    let inputs = inputs.single().unwrap();
    let start = [0.1, -0.1, 0.9];
    let linear = propagate_least_squares(&Circle, &start, &inputs).unwrap();
    // By symmetry: r is the mean of four radii, a centre coordinate half the difference of two opposite points.
    assert!((linear.get("r").unwrap().standard_uncertainty - 0.005).abs() < 1e-12);
    assert!((linear.get("x0").unwrap().standard_uncertainty - 0.01 / 2f64.sqrt()).abs() < 1e-12);
    let n = 20_000;
    let solved = Solved::new(NormalEquations(Circle), start.to_vec());
    let sampled = MonteCarlo::new(5)
        .trials(Trials::Fixed(n))
        .run(&solved, &inputs)
        .unwrap();
    for name in ["x0", "y0", "r"] {
        let (q, s) = (linear.get(name).unwrap(), sampled.get(name).unwrap());
        // s of n trials has the relative standard deviation 1/√(2n); four of them, and 0.01² for the curvature.
        let bound = 4.0 / (2.0 * n as f64).sqrt() + 1e-4;
        assert!(
            (s.standard_uncertainty.unwrap() / q.standard_uncertainty - 1.0).abs() < bound,
            "{name}"
        );
    }
}

#[test]
fn coverage_of_the_t_interval() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    for n in [3, 5] {
        let mut inside = 0;
        for _ in 0..20_000 {
            let x: Vec<f64> = (0..n)
                .map(|_| 7.0 + rng.sample::<f64, _>(StandardNormal))
                .collect();
            let d = Distribution::from_observations(&x).unwrap();
            let k = d.dof().coverage_factor(0.95);
            inside += usize::from((d.estimate() - 7.0).abs() <= k * d.standard_uncertainty());
        }
        let share = inside as f64 / 20_000.0;
        assert!((share - 0.95).abs() < 0.0062, "n {n}: {share}");
    }
}

/// Two means of n = 4 with unequal variances, ν_eff by Welch–Satterthwaite: the known error of the approximation at
/// ν = 3 is within 1.5 %, on top of the binomial 0.6 %.
#[test]
fn coverage_of_the_effective_degrees_of_freedom() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    let mut inside = 0;
    for _ in 0..20_000 {
        let mut mean = |sigma: f64| {
            let x: Vec<f64> = (0..4)
                .map(|_| sigma * rng.sample::<f64, _>(StandardNormal))
                .collect();
            Distribution::from_observations(&x).unwrap()
        };
        let (a, b) = (mean(1.0), mean(2.0));
        let u = a.standard_uncertainty().hypot(b.standard_uncertainty());
        let nu = welch_satterthwaite(&[
            (a.standard_uncertainty(), a.dof()),
            (b.standard_uncertainty(), b.dof()),
        ]);
        inside += usize::from((a.estimate() - b.estimate()).abs() <= nu.coverage_factor(0.95) * u);
    }
    let share = inside as f64 / 20_000.0;
    assert!((share - 0.95).abs() < 0.021, "{share}");
}

#[test]
fn law_threads_do_not_change_a_bit() {
    let joint = end_gauge().single().unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let run = MonteCarlo {
            seed: 42,
            probability: 0.99,
            trials: Trials::Adaptive {
                digits: 1,
                max: 500_000,
            },
        };
        pool.install(|| run.run(&EndGauge, &joint)).unwrap()
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one, two);
    assert_eq!(
        one.outputs[0].symmetric.upper.to_bits(),
        two.outputs[0].symmetric.upper.to_bits()
    );
    let other = MonteCarlo::new(43)
        .trials(Trials::Fixed(10_000))
        .run(&EndGauge, &joint)
        .unwrap();
    assert_ne!(one.outputs[0].mean, other.outputs[0].mean);
}

/// Draws beyond what the cache holds stand in groups of trials; every one is where the model looks for it.
#[test]
fn law_thousands_of_draws_come_to_the_trials_they_belong_to() {
    struct Sum;
    impl Trial for Sum {
        fn names(&self) -> Vec<(String, String)> {
            ["sum", "first", "last"]
                .map(|n| (n.to_owned(), "1".to_owned()))
                .into()
        }
        fn trial(&self, x: &[f64], y: &mut [f64]) {
            y[0] = x[..x.len() - 1].iter().sum();
            (y[1], y[2]) = (x[0], x[x.len() - 1]);
        }
    }
    let count = 3000;
    let runs: Vec<Labels> = (0..count).map(|i| Labels::new().with("run", i)).collect();
    let unit = Distribution::Normal { mean: 0.0, u: 1.0 };
    let bias = Distribution::Rectangular {
        lower: 4.0,
        upper: 6.0,
    };
    let joint = Inputs::new()
        .add(Input::new("reading", "1", unit).varies_with(["run"]))
        .add(Input::new("bias", "1", bias))
        .joint(&runs)
        .unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let run = MonteCarlo::new(7).trials(Trials::Fixed(10_000));
        pool.install(|| run.run(&Sum, &joint)).unwrap()
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one, three);
    // 10 000 trials: u has 0.7 % of standard uncertainty, a mean 1 % of u.
    let expected = [
        (0.0, (count as f64).sqrt()),
        (0.0, 1.0),
        (5.0, 3f64.sqrt().recip()),
    ];
    for (output, (mean, u)) in one.outputs.iter().zip(expected) {
        assert!(
            (output.mean - mean).abs() < 0.04 * u,
            "{}: {}",
            output.name,
            output.mean
        );
        let found = output.standard_uncertainty.unwrap();
        assert!((found / u - 1.0).abs() < 0.03, "{}: {found}", output.name);
    }
    let correlation = one.covariance.correlation(0, 1).unwrap();
    assert!(
        (correlation - (count as f64).sqrt().recip()).abs() < 0.04,
        "{correlation}"
    );
    assert!(one.covariance.correlation(0, 2).unwrap().abs() < 0.04);
}

#[test]
fn law_adaptive_stops_when_stable() {
    let joint = end_gauge().single().unwrap();
    let mut calls = 0;
    let result = MonteCarlo::new(1)
        .trials(Trials::Adaptive {
            digits: 1,
            max: 10_000_000,
        })
        .run_with(&EndGauge, &joint, &mut |_| {
            calls += 1;
            ControlFlow::Continue(())
        })
        .unwrap();
    assert!(calls >= 1 && result.trials < 1_000_000 && result.findings.is_empty());
    let short = MonteCarlo::new(1).trials(Trials::Adaptive {
        digits: 4,
        max: 20_000,
    });
    let findings = short.run(&EndGauge, &joint).unwrap().findings;
    assert_eq!(findings[0].code(), "too-few-trials");
}

#[test]
fn refuses_a_cancelled_run() {
    let joint = end_gauge().single().unwrap();
    let result = MonteCarlo::new(1).run_with(&EndGauge, &joint, &mut |_| ControlFlow::Break(()));
    assert_eq!(result, Err(Refusal::Cancelled));
}

#[test]
fn refuses_contradicting_correlations_by_name() {
    let joint = Inputs::new()
        .add(normal("a", 0.0, 1.0))
        .add(normal("b", 0.0, 1.0))
        .add(normal("c", 0.0, 1.0))
        .add(normal("bystander", 0.0, 1.0))
        .correlate("a", "b", 0.9)
        .correlate("b", "c", 0.9)
        .correlate("a", "c", -0.9)
        .single();
    match joint {
        Err(Refusal::Correlation { first, second, .. }) => {
            assert_ne!(first, "bystander");
            assert_ne!(second, "bystander");
        }
        other => panic!("{other:?}"),
    }
    let frequencies: Vec<Labels> = [10, 20, 40]
        .map(|f| Labels::new().with("frequency", f))
        .into();
    let d = Distribution::Normal { mean: 1.0, u: 0.01 };
    let reference = Inputs::new().add(Input::new("reference", "1", d).varies_with(["frequency"]));
    let adjacent = reference
        .clone()
        .correlate("reference[frequency=10]", "reference[frequency=20]", 0.5)
        .joint(&frequencies)
        .unwrap();
    assert!((adjacent.covariance()[(0, 1)] - 0.5e-4).abs() < 1e-18);
    assert_eq!(adjacent.covariance()[(0, 2)], 0.0);
    let error =
        reference
            .clone()
            .correlate("reference[frequency=10]", "reference[frequency=20]", 1.5);
    assert!(
        error
            .joint(&frequencies)
            .unwrap_err()
            .to_string()
            .contains("reference[frequency=20]")
    );
    let error = reference
        .clone()
        .correlate("reference", "referense", 0.5)
        .joint(&frequencies);
    assert_eq!(
        error.unwrap_err().to_string(),
        "no input is called referense"
    );
    assert!(
        reference
            .joint(&[Labels::new()])
            .unwrap_err()
            .to_string()
            .contains("frequency")
    );
}

#[test]
fn refuses_a_model_that_is_not_finite() {
    model!(Root, ["y" "1"], |x, y, T| {
        y[0] = x[0].sqrt();
    });
    let at = |mean| Inputs::new().add(normal("x", mean, 1.0)).single().unwrap();
    assert!(propagate(&Root, &at(-1.0)).is_err());
    assert!(propagate(&Root, &at(0.0)).is_err(), "no derivative at zero");
    let run = MonteCarlo::new(1).trials(Trials::Fixed(20_000));
    assert!(run.run(&Root, &at(-9.0)).is_err(), "negative in all trials");
    // At 1 ± 1 a share Φ(−1) = 0.159 of the trials is negative: left out, counted and said.
    let sampled = run.run(&Root, &at(1.0)).unwrap();
    let share = sampled.outputs[0].invalid as f64 / sampled.trials as f64;
    assert!((share - 0.1587).abs() < 0.012, "{share}");
    assert!(
        sampled
            .findings
            .iter()
            .any(|f| f.code() == "invalid-trials")
    );
}

/// Every distribution is drawn as its quantiles say: ends of the 95 % interval within four binomial deviations, mean and
/// standard deviation within five of theirs (the fourth moments of these stay below twenty times the variance squared).
#[test]
fn law_draws_of_every_distribution_follow_its_quantiles() {
    model!(Identity, ["x" "1"], |x, y, T| {
        y[0] = x[0] * T::from(1.0);
    });
    let n = 200_000usize;
    for d in [
        Distribution::Exponential {
            lower: 1.0,
            mean: 3.0,
        },
        Distribution::Gamma {
            lower: 0.5,
            shape: 3.0,
            scale: 0.3,
        },
        Distribution::Lognormal {
            lower: 0.0,
            median: 2.0,
            sigma: 0.4,
        },
        Distribution::Beta {
            lower: 1.0,
            upper: 4.0,
            alpha: 2.0,
            beta: 3.5,
        },
        Distribution::TruncatedNormal {
            mean: 1.0,
            sd: 2.0,
            lower: 0.0,
            upper: f64::MAX,
        },
        Distribution::Poisson {
            lower: 0.0,
            scale: 0.5,
            mean: 4.2,
        },
        Distribution::Discrete {
            values: vec![3.0, 1.0, 7.0],
            weights: vec![1.0, 2.0, 1.0],
        },
    ] {
        let inputs = Inputs::new()
            .add(Input::new("x", "1", d.clone()))
            .single()
            .unwrap();
        let sampled = MonteCarlo::new(11)
            .trials(Trials::Fixed(n))
            .run(&Identity, &inputs)
            .unwrap();
        let x = &sampled.outputs[0];
        let (mean, u) = (d.estimate(), d.standard_uncertainty());
        let trials = sampled.trials as f64;
        assert!(
            (x.mean - mean).abs() < 5.0 * u / trials.sqrt(),
            "{d:?}: {} {mean}",
            x.mean
        );
        let got = x.standard_uncertainty.unwrap();
        assert!(
            (got / u - 1.0).abs() < 5.0 * (5.0 / trials).sqrt(),
            "{d:?}: {got} {u}"
        );
        let step = 4.0 * (0.025 * 0.975 / trials).sqrt();
        for (end, p) in [(x.symmetric.lower, 0.025), (x.symmetric.upper, 0.975)] {
            assert!(
                end >= d.quantile(p - step) && end <= d.quantile(p + step),
                "{d:?} {p}: {end}"
            );
        }
    }
}

/// −3.5·10⁻¹⁹ is what rounding left of zero: by it the whole input moves the result by less than a double tells. A small sensitivity that
/// contributes is none of that.
#[test]
fn known_rounding_noise_of_a_sensitivity_is_zero_in_budgets() {
    let cause = |key: &str, value: f64, u: f64, sensitivity: f64| Influence {
        key: key.into(),
        description: key.into(),
        evaluation: Evaluation::B,
        distribution: "normal".into(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Scalar {
            value,
            unit: "V".into(),
            standard_uncertainty: u,
            sensitivity: vec![sensitivity],
        },
    };
    let causes = vec![
        cause("noise", 5.0, 0.01, -3.5e-19),
        cause("signal", 5.0, 0.01, 1.0),
        // A large input with a small coefficient.
        cause("large", 1e12, 1e9, 1e-12),
    ];
    let estimate = Estimate::new(vec![Component::new("y", "V", 6.0)], causes).unwrap();
    let budget = estimate.budget("y").unwrap();
    let line = |key: &str| budget.iter().find(|l| l.key == key).unwrap();
    let sensitivity = |key: &str| line(key).input.as_ref().unwrap().sensitivity;
    assert_eq!(sensitivity("noise"), 0.0);
    assert_eq!(line("noise").contribution, 0.0);
    assert_eq!(sensitivity("signal"), 1.0);
    assert_eq!(sensitivity("large"), 1e-12);
    assert_eq!(line("large").contribution, 1e-3);
}

/// u, degrees of freedom and correlation of contributions whose squares or fourth powers are no numbers any more.
#[test]
fn law_large_and_small_contributions_have_the_same_u() {
    use proofmass_uncertainty::{DegreesOfFreedom, Uncertain};
    for scale in [1e-300, 1e-100, 1.0, 1e100, 1e300] {
        let number = |name: &str, u: f64, nu: f64| {
            let number = Uncertain::new(name, 0.0, u * scale).unwrap();
            number.dof(DegreesOfFreedom::new(nu).unwrap())
        };
        let (a, b) = (number("a", 3.0, 5.0), number("b", 4.0, 9.0));
        let sum = &a + &b;
        assert!((sum.standard_uncertainty() / (5.0 * scale) - 1.0).abs() < 1e-12);
        let nu = 625.0 / (81.0 / 5.0 + 256.0 / 9.0);
        assert!((sum.effective_dof().get() / nu - 1.0).abs() < 1e-12);
        assert!((sum.correlation(&a).unwrap() - 0.6).abs() < 1e-12);
    }
}
