//! Three roads to a result, none of which may take the result of another away; one meaning of the degrees of freedom.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn evaluate_with(text: &str, trials: Trials) -> Result<ModelResult, Refusal> {
    let options = Evaluate {
        trials,
        ..Evaluate::default()
    };
    let model: UncertaintyModel = toml::from_str(text).unwrap();
    model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
}

fn evaluate(text: &str) -> ModelResult {
    evaluate_with(text, Trials::Fixed(200_000)).unwrap()
}

fn input(name: &str, rest: &str) -> String {
    format!("[[input]]\nname = \"{name}\"\nunit = \"1\"\n{rest}\n")
}

fn output(expression: &str) -> String {
    format!("[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"{expression}\"\n")
}

fn has(result: &ModelResult, code: &str) -> bool {
    result.findings.iter().any(|f| f.code() == code)
}

/// Models whose series to second order has no variance above zero: every road that has a result states it.
#[test]
fn regress_the_second_order_vetoes_nothing() {
    for (known, expression, u) in [
        (
            "value = 0\nhalf_width = 3.14159",
            "sin(x)",
            Some(0.5f64.sqrt()),
        ),
        ("value = 0\nu = 0.8", "tanh(x)", None),
        ("value = 0\nu = 1", "atan(x)", None),
        ("value = 0.5\nu = 1", "exp(-x^2)", None),
        ("value = 0.3\nu = 1", "1/(1+x^2)", None),
        ("value = 0\nu = 1", "x^(1+1)", Some(2f64.sqrt())),
    ] {
        let result = evaluate(&(input("x", known) + &output(expression)));
        let y = &result.outputs[0];
        assert!(y.linear.is_some(), "{expression}");
        let trials = y.monte_carlo.as_ref().unwrap();
        if let Some(u) = u {
            // Of 200 000 trials of bounded or χ² distributions u is known to better than 1 %.
            let got = trials.standard_uncertainty.unwrap();
            assert!((got / u - 1.0).abs() < 0.01, "{expression}: {got}");
        }
    }
}

/// `[S2] 9.3`, u(x1) = u(x2) = 0.010: modulus and angle, all six rows. Mean and u of the angle and u of the modulus from
/// the published table as test suites of others state them; rounded to its digits.
#[test]
fn published_s2_93_polar_coordinates() {
    for (x1, r, modulus, angle) in [
        (0.001, 0.0, Some((0.013, 0.007)), Some((0.0, 1.744))),
        (0.010, 0.0, Some((0.015, 0.008)), Some((0.0, 1.117))),
        (0.100, 0.0, Some((0.1005, 0.010)), Some((0.0, 0.1005))),
        (0.001, 0.9, Some((0.012, 0.008)), Some((-0.556, 1.599))),
        (0.010, 0.9, Some((0.015, 0.008)), Some((-0.343, 0.903))),
        (0.100, 0.9, Some((0.1005, 0.0099)), None),
    ] {
        let text = input("x1", &format!("value = {x1}\nu = 0.010"))
            + &input("x2", "value = 0\nu = 0.010")
            + &format!("[[correlation]]\nbetween = [\"x1\", \"x2\"]\ncoefficient = {r}\n")
            + "[[output]]\nname = \"r\"\nunit = \"1\"\nexpression = \"sqrt(x1^2 + x2^2)\"\n"
            + "[[output]]\nname = \"theta\"\nunit = \"rad\"\nexpression = \"atan2(x2, x1)\"\n";
        let result = evaluate(&text);
        let of = |name: &str| {
            let m = result.get(name).unwrap().monte_carlo.as_ref().unwrap();
            (m.mean, m.standard_uncertainty.unwrap())
        };
        for (name, expected, step) in [("r", modulus, 0.0006), ("theta", angle, 0.006)] {
            if let Some((mean, u)) = expected {
                let (got_mean, got_u) = of(name);
                assert!(
                    (got_mean - mean).abs() < step,
                    "{x1} {r} {name}: {got_mean} {mean}"
                );
                assert!((got_u - u).abs() < step, "{x1} {r} {name}: {got_u} {u}");
            }
        }
    }
}

/// A phase of an inverting amplifier: the cut of atan2 at ± π does not divide the distribution.
#[test]
fn regress_a_phase_at_half_a_turn() {
    let text = input("re", "value = -1\nu = 0.05")
        + &input("im", "value = 0\nu = 0.1")
        + &output("atan2(im, re)");
    let result = evaluate(&text);
    let y = &result.outputs[0];
    let trials = y.monte_carlo.as_ref().unwrap();
    assert!(
        (trials.mean - std::f64::consts::PI).abs() < 0.002,
        "{}",
        trials.mean
    );
    assert!((trials.standard_uncertainty.unwrap() - 0.1).abs() < 0.002);
    assert!((y.stated.value - std::f64::consts::PI).abs() < 1e-12);
    // Differences of phases as well.
    let text = input("a", "value = -1\nu = 0.1")
        + &input("b", "value = 0\nu = 0.1")
        + &output("degrees(2 * atan2(b, a) - atan2(b + 0.1, a))");
    let trials = evaluate(&text).outputs[0].monte_carlo.clone().unwrap();
    assert!(trials.symmetric.width() < 60.0, "{:?}", trials.symmetric);
}

/// Two inputs of unequal degrees of freedom that are correlated: what the estimate states is what the table states.
#[test]
fn regress_one_number_of_degrees_of_freedom() {
    let text = input("a", "value = 1\nu = 0.01\ndof = 3")
        + &input("b", "value = 1\nu = 1")
        + "[[correlation]]\nbetween = [\"a\", \"b\"]\ncoefficient = 0.3\n"
        + &output("a + b");
    let result = evaluate(&text);
    let y = result.outputs[0].linear.as_ref().unwrap();
    let again = result.estimate.as_ref().unwrap().get("y").unwrap();
    assert!((again.dof.get() / y.quantity.dof.get() - 1.0).abs() < 1e-9);
    assert!(y.quantity.dof.get() > 1e5);
    assert!((again.expanded(0.95) - y.expanded_uncertainty).abs() < 1e-12);
    // It survives a further function, and a file.
    let estimate = result.estimate.unwrap();
    let doubled = estimate
        .propagate(vec![Component::new("z", "1", 4.0)], &[2.0])
        .unwrap();
    let read: Estimate = serde_json::from_str(&serde_json::to_string(&doubled).unwrap()).unwrap();
    assert_eq!(read.get("z").unwrap().dof, doubled.get("z").unwrap().dof);
    assert!((doubled.get("z").unwrap().dof.get() / y.quantity.dof.get() - 1.0).abs() < 1e-9);
    let shares: f64 = read.budget("z").unwrap().iter().map(|l| l.share).sum();
    assert!((shares - 1.0).abs() < 1e-12);
}

/// `[S2] 9.4`: `[GUM] H.2` with a sixth reading, by both rules. Linear u of the published table with n − 1, Monte Carlo u
/// with n − N; by one rule linear and Monte Carlo intervals agree.
#[test]
fn published_s2_94_impedance_by_both_rules() {
    let model = |rule: &str| {
        let read = |name: &str, unit: &str, values: &str| {
            format!(
                "[[input]]\nname = \"{name}\"\nunit = \"{unit}\"\nobservations = [{values}]\ntogether = \"readings\"\n"
            )
        };
        format!("joint_readings = \"{rule}\"\n")
            + &read("V", "V", "5.007, 4.994, 5.005, 4.990, 4.999, 4.999")
            + &read(
                "I",
                "A",
                "19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3, 19.661e-3",
            )
            + &read(
                "phi",
                "rad",
                "1.0456, 1.0438, 1.0468, 1.0428, 1.0433, 1.0445",
            )
            + "[[output]]\nname = \"R\"\nunit = \"Ω\"\nexpression = \"V / I * cos(phi)\"\n"
            + "[[output]]\nname = \"X\"\nunit = \"Ω\"\nexpression = \"V / I * sin(phi)\"\n"
            + "[[output]]\nname = \"Z\"\nunit = \"Ω\"\nexpression = \"V / I\"\n"
    };
    let gum = evaluate(&model("gum"));
    let s2 = evaluate_with(&model("jcgm-102"), Trials::Fixed(2_000_000)).unwrap();
    for (name, linear, sampled) in [
        ("R", 0.058, 0.130),
        ("X", 0.241, 0.540),
        ("Z", 0.193, 0.431),
    ] {
        let g = gum.get(name).unwrap();
        let q = &g.linear.as_ref().unwrap().quantity;
        assert!((q.standard_uncertainty - linear).abs() < 5e-4, "{name}");
        assert!((q.dof.get() - 5.0).abs() < 1e-9);
        let s = s2.get(name).unwrap();
        assert!((s.linear.as_ref().unwrap().quantity.dof.get() - 3.0).abs() < 1e-9);
        // The variance of t with ν = 3 has no variance of its own: u of 2·10⁶ trials is good to some per cent.
        let u = s
            .monte_carlo
            .as_ref()
            .unwrap()
            .standard_uncertainty
            .unwrap();
        assert!((u / sampled - 1.0).abs() < 0.04, "{name}: {u} {sampled}");
        for o in [g, s] {
            assert_eq!(
                o.validation.as_ref().unwrap().verdict,
                Verdict::Validated,
                "{name}"
            );
        }
    }
    let r = s2.get("R").unwrap().monte_carlo.as_ref().unwrap().symmetric;
    assert!(
        (r.lower - 127.491).abs() < 0.003 && (r.upper - 127.968).abs() < 0.003,
        "{r:?}"
    );
}

/// Means, uncertainties and correlations of readings made together behave as the readings do.
#[test]
fn law_summary_of_an_ensemble_equals_its_readings() {
    let summary = |together: &str| {
        let one = |name: &str, mean: f64, u: f64| {
            input(
                name,
                &format!("value = {mean}\nu = {u}\ndof = 4\n{together}"),
            )
        };
        one("V", 4.9990, 0.00320936)
            + &one("I", 19.6610e-3, 9.47101e-6)
            + &one("phi", 1.04446, 7.520638e-4)
            + "[[correlation]]\nbetween = [\"V\", \"I\"]\ncoefficient = -0.355311\n"
            + "[[correlation]]\nbetween = [\"V\", \"phi\"]\ncoefficient = 0.857624\n"
            + "[[correlation]]\nbetween = [\"I\", \"phi\"]\ncoefficient = -0.645111\n"
            + &output("V / I * cos(phi)")
    };
    let result = evaluate(&summary("together = \"bench\""));
    let y = &result.outputs[0];
    let q = &y.linear.as_ref().unwrap().quantity;
    assert!((q.standard_uncertainty - 0.0711).abs() < 1e-4 && (q.dof.get() - 4.0).abs() < 1e-9);
    assert_eq!(y.validation.as_ref().unwrap().verdict, Verdict::Validated);
    assert!(!has(&result, "separately-estimated"));
    // Without the word they were estimated separately, which is said, and holds on both roads.
    let apart = evaluate(&summary(""));
    assert!(has(&apart, "separately-estimated"));
    assert!(apart.outputs[0].linear.as_ref().unwrap().quantity.dof.get() < 2.0);
}

/// dof beside any statement reaches the trials: ends of the 95 % interval over u.
#[test]
fn law_degrees_of_freedom_reach_every_distribution() {
    let ends = |known: &str| {
        let y = evaluate(&(input("x", known) + &output("x"))).outputs[0].clone();
        let u = y.linear.as_ref().unwrap().quantity.standard_uncertainty;
        (
            0.5 * y.monte_carlo.as_ref().unwrap().symmetric.width() / u,
            y,
        )
    };
    let t = |nu: f64| DegreesOfFreedom::new(nu).unwrap().coverage_factor(0.95);
    for (known, k) in [
        ("observations = [1.0, 1.1, 0.9, 1.05]\ndof = 50", t(50.0)),
        (
            "distribution = { kind = \"student-t\", location = 0.0, scale = 1.0, dof = 3.0 }\ndof = \"infinite\"",
            t(f64::INFINITY),
        ),
        ("value = 1\nu = 0.1\ndof = 5", t(5.0)),
        ("value = 1\nU = 0.2\nk = 2\ndof = 5", t(5.0)),
    ] {
        let (got, y) = ends(known);
        assert!((got / k - 1.0).abs() < 0.02, "{known}: {got} {k}");
        assert_eq!(y.validation.unwrap().verdict, Verdict::Validated, "{known}");
    }
    // Doubtful limits: the curvilinear trapezoid with d = a √(3/(2ν)), its 97.5 % quantile by its own integral.
    let d = (1.5f64 / 8.0).sqrt();
    let limits = Distribution::CurvilinearTrapezoid {
        lower: -1.0,
        upper: 1.0,
        inexactness: d,
    };
    let (got, _) = ends("value = 0\nhalf_width = 1\ndof = 8");
    let expected = limits.quantile(0.975) * 3f64.sqrt();
    assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
}

#[test]
fn refuses_a_lonely_word_in_together() {
    let text = input(
        "a",
        "observations = [1.0, 2.0, 3.0]\ntogether = \"reading\"",
    ) + &input(
        "b",
        "observations = [1.0, 2.0, 3.0]\ntogether = \"readings\"",
    ) + &output("a + b");
    let refusal = evaluate_with(&text, Trials::Fixed(10_000)).unwrap_err();
    assert!(refusal.to_string().contains("misspelt"), "{refusal}");
}

/// What used to run for minutes or for ever.
#[test]
fn regress_nothing_hangs() {
    let text = input("x", "value = 1\nu = 0.1\ndof = 1e-9") + &output("x");
    assert!(evaluate_with(&text, Trials::Fixed(10_000)).is_err());
    // Correlated samples are sorted once.
    let samples = Distribution::Samples {
        values: (0..100_000).map(|i| f64::from(i) * 1e-5).collect(),
    };
    let joint = Inputs::new()
        .add(Input::new("a", "1", samples.clone()))
        .add(Input::new("b", "1", samples))
        .correlate("a", "b", 0.5)
        .single()
        .unwrap();
    struct Sum;
    impl Model for Sum {
        fn outputs(&self) -> Vec<(String, String)> {
            vec![("y".into(), "1".into())]
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            y[0] = x.iter().fold(T::from(0.0), |s, &x| s + x);
        }
    }
    let sampled = MonteCarlo::new(1)
        .trials(Trials::Fixed(50_000))
        .run(&Sum, &joint)
        .unwrap();
    assert!((sampled.outputs[0].mean - 1.0).abs() < 0.01);
    // A thousand inputs by the law of propagation.
    let began = std::time::Instant::now();
    let inputs = (0..1000).fold(Inputs::new(), |inputs, i| {
        inputs.add(Input::new(
            format!("x{i}"),
            "1",
            Distribution::Normal { mean: 1.0, u: 0.1 },
        ))
    });
    let linear = propagate(&Sum, &inputs.single().unwrap()).unwrap();
    assert!((linear.get("y").unwrap().standard_uncertainty - 0.1 * 1000f64.sqrt()).abs() < 1e-9);
    assert!(began.elapsed().as_secs_f64() < 1.0, "{:?}", began.elapsed());
}

/// A standard deviation that does not exist is not printed; one that exists is, however few the degrees of freedom.
#[test]
fn regress_heavy_tails_have_no_standard_deviation() {
    for (known, expression) in [
        ("value = 3\nu = 1", "1/x"),
        ("observations = [1.0, 1.1]", "x"),
        ("value = 1\nu = 1\ndof = 2", "x"),
    ] {
        let result = evaluate(&(input("x", known) + &output(expression)));
        let y = &result.outputs[0];
        assert!(
            y.monte_carlo
                .as_ref()
                .unwrap()
                .standard_uncertainty
                .is_none(),
            "{expression} {known}"
        );
        assert!(has(&result, "no-standard-deviation"));
        if y.stated.method == StatementMethod::MonteCarlo {
            assert!(y.stated.standard_uncertainty.is_none());
            assert!((y.stated.value - y.monte_carlo.as_ref().unwrap().median).abs() < 1e-12);
        }
    }
    for seed in 0..40 {
        // Student t with ν = 3, and a lognormal with σ = 1: heavy, but with a standard deviation.
        let inputs = Inputs::new()
            .add(Input::new(
                "t",
                "1",
                Distribution::StudentT {
                    location: 0.0,
                    scale: 1.0,
                    dof: 3.0,
                },
            ))
            .add(Input::new(
                "z",
                "1",
                Distribution::Normal { mean: 0.0, u: 1.0 },
            ));
        struct Both;
        impl Model for Both {
            fn outputs(&self) -> Vec<(String, String)> {
                vec![("t".into(), "1".into()), ("e".into(), "1".into())]
            }
            fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
                (y[0], y[1]) = (x[0], x[1].exp());
            }
        }
        let sampled = MonteCarlo::new(seed)
            .trials(Trials::Fixed(20_000))
            .run(&Both, &inputs.single().unwrap())
            .unwrap();
        assert!(
            sampled
                .outputs
                .iter()
                .all(|o| o.standard_uncertainty.is_some()),
            "seed {seed}"
        );
    }
}

/// x² at zero: no linear uncertainty; the trials set their own tolerance and stop, and the result is theirs.
#[test]
fn regress_no_uncertainty_to_first_order() {
    let text = input("x", "value = 0\nu = 1") + &output("x^2");
    let result = evaluate_with(
        &text,
        Trials::Adaptive {
            digits: 2,
            max: 5_000_000,
        },
    )
    .unwrap();
    let y = &result.outputs[0];
    assert!(!has(&result, "too-few-trials"));
    assert!(result.trials < 3_000_000, "{}", result.trials);
    assert_eq!(y.stated.method, StatementMethod::MonteCarlo);
    assert!((y.stated.value - 1.0).abs() < 0.02);
    assert!((y.stated.standard_uncertainty.unwrap() - 2f64.sqrt()).abs() < 0.03);
}

/// One draw outside a function's domain takes nothing away.
#[test]
fn regress_invalid_trials_veto_nothing() {
    let result = evaluate(&(input("x", "value = 3\nu = 1") + &output("ln(x)")));
    let y = &result.outputs[0];
    assert_eq!(y.stated.method, StatementMethod::LawOfPropagation);
    assert!((y.stated.standard_uncertainty.unwrap() - 1.0 / 3.0).abs() < 1e-12);
    let share = y.monte_carlo.as_ref().unwrap().invalid as f64 / result.trials as f64;
    assert!(
        (share - 0.00135).abs() < 4.0 * (0.00135f64 / 200_000.0).sqrt(),
        "{share}"
    );
    assert!(has(&result, "invalid-trials"));
    // An output without a derivative leaves the other its linear result.
    let text = input("x", "value = 0\nu = 1")
        + "[[output]]\nname = \"a\"\nunit = \"1\"\nexpression = \"sqrt(abs(x))\"\n"
        + "[[output]]\nname = \"b\"\nunit = \"1\"\nexpression = \"2 * x\"\n";
    let result = evaluate(&text);
    assert!(result.get("a").unwrap().linear.is_none());
    assert_eq!(
        result.get("a").unwrap().stated.method,
        StatementMethod::MonteCarlo
    );
    let b = &result.get("b").unwrap().stated;
    assert_eq!(
        (b.method, b.standard_uncertainty),
        (StatementMethod::LawOfPropagation, Some(2.0))
    );
}

/// A whole power of a negative constant that stands as an input.
#[test]
fn regress_a_power_of_a_negative_number() {
    let text = input("x", "value = -2\nu = 0.1") + &input("n", "value = 3") + &output("x^n");
    let y = &evaluate(&text).outputs[0];
    let q = &y.linear.as_ref().unwrap().quantity;
    assert_eq!(q.value, -8.0);
    assert!((q.standard_uncertainty - 1.2).abs() < 1e-12);
}

/// Random valid models at three sizes of relative uncertainty: none is refused.
#[test]
fn coverage_no_random_model_is_refused() {
    let mut state = 12345u64;
    let mut next = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize
    };
    fn formula(next: &mut impl FnMut() -> usize, depth: usize) -> String {
        if depth == 0 {
            return ["a", "b", "c", "1.5", "(a + 2*b)"][next() % 5].to_owned();
        }
        let x = formula(next, depth - 1);
        match next() % 12 {
            0 => format!("sin({x})"),
            1 => format!("tanh({x})"),
            2 => format!("exp(-({x})^2)"),
            3 => format!("atan({x})"),
            4 => format!("1/(1+({x})^2)"),
            5 => format!("sqrt(1+({x})^2)"),
            6 => format!("cos({x})"),
            7 => format!("hypot({x}, {})", formula(next, 0)),
            8 => format!("max({x}, {})", formula(next, 0)),
            9 => format!("({x}) * ({})", formula(next, depth - 1)),
            10 => format!("({x}) - ({})", formula(next, depth - 1)),
            _ => format!("ln(2+({x})^2)"),
        }
    }
    for share in [0.1, 0.3, 0.6] {
        for _ in 0..60 {
            let mut text = String::new();
            for name in ["a", "b", "c"] {
                let value = 0.2 + (next() % 1000) as f64 * 2e-3;
                text += &input(name, &format!("value = {value}\nu = {}", share * value));
            }
            let formula = formula(&mut next, 1 + share as usize + 2);
            text += &output(&formula);
            let result = evaluate_with(&text, Trials::Fixed(10_000));
            let y = result.unwrap_or_else(|e| panic!("{formula}: {e}")).outputs[0].clone();
            assert!(y.linear.is_some() && y.monte_carlo.is_some(), "{formula}");
        }
    }
}

/// Degrees in a sine, sums of unlike things and of unlike sizes are said; a healthy model hears nothing.
#[test]
fn law_units_are_looked_at() {
    let with = |unit: &str, name: &str| {
        format!("[[input]]\nname = \"{name}\"\nunit = \"{unit}\"\nvalue = 3\nu = 0.1\n")
    };
    let say = |inputs: &[(&str, &str)], unit: &str, expression: &str| {
        let text: String = inputs.iter().map(|(name, unit)| with(unit, name)).collect();
        let model: UncertaintyModel = toml::from_str(
            &(text
                + &format!(
                    "[[output]]\nname = \"y\"\nunit = \"{unit}\"\nexpression = \"{expression}\"\n"
                )),
        )
        .unwrap();
        let findings = model.doubtful_units();
        findings
            .iter()
            .map(|f| f.code().to_owned())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let (l, phi) = (("L", "mm"), ("phi", "°"));
    assert_eq!(
        say(&[l, phi], "mm", "L * sin(phi)"),
        "degrees-in-trigonometry"
    );
    assert_eq!(
        say(&[l, phi], "mm", "L * sin(2 * phi)"),
        "degrees-in-trigonometry"
    );
    assert_eq!(say(&[l, phi], "mm", "L * sin(radians(phi))"), "");
    assert_eq!(say(&[l, phi], "mm", "L * sin(phi * pi / 180)"), "");
    assert_eq!(say(&[l, phi], "mm", "L + phi"), "units-do-not-fit");
    assert_eq!(say(&[l, ("d", "m")], "mm", "L + d"), "units-do-not-fit");
    assert_eq!(say(&[l, ("d", "m")], "mm", "L + 1000 * d"), "");
    assert_eq!(say(&[l, ("d", "µm")], "mm", "L + d / 1000"), "");
    assert_eq!(say(&[l, ("t", "s")], "kg", "L / t"), "units-do-not-fit");
    assert_eq!(say(&[l, ("t", "s")], "mm/s", "L / t"), "");
    assert_eq!(say(&[l, ("t", "s")], "m/s", "L / t"), "units-do-not-fit");
    assert_eq!(say(&[("V", "V"), ("I", "mA")], "kΩ", "V / I"), "");
    assert_eq!(
        say(&[("m", "kg"), ("d", "m")], "kg/m³", "m / (pi / 6 * d^3)"),
        ""
    );
    assert_eq!(say(&[l], "1", "exp(L)"), "units-do-not-fit");
    assert_eq!(say(&[("x", "m")], "mm", "x"), "units-do-not-fit");
    assert_eq!(say(&[("x", "wheels")], "mm", "x"), "unknown-unit");
    assert_eq!(
        say(&[("t", "°C")], "°C", "t - 20 + 0.00152 * (t - 20)^2"),
        ""
    );
}

/// `[GUM] H.1.7`: terms of second order bring u from 32 nm to 34 nm. To one digit of u both are the same, as Monte Carlo says, and nothing
/// contradicts it; by terms of second order alone, two digits are refused.
#[test]
fn published_terms_of_second_order_are_judged_by_the_digits_that_count() {
    let text = include_str!("gum/gum-h1.toml");
    let result = evaluate_with(text, Evaluate::default().trials).unwrap();
    let l = &result.outputs[0];
    assert!(l.validation.as_ref().unwrap().holds());
    assert!(!has(&result, "linear-result-not-validated"));
    let linear = l.linear.as_ref().unwrap();
    let second = linear.second_order.unwrap();
    let agrees = |digits| second.agrees(&linear.quantity, 0.95, digits);
    assert_eq!((agrees(1), agrees(2)), (true, false));
    // k (33.8 − 31.66) with t(16.75) = 2.11.
    let departure = second.departure(&linear.quantity, 0.95);
    assert!((departure - 2.11 * 2.1).abs() < 0.3, "{departure}");
}

/// Several outputs and figures that are not stable are one finding, with every name.
#[test]
fn regress_too_few_trials_are_said_once() {
    let text = input("x", "value = 1\nu = 0.0351")
        + "[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"x^2\"\n\
           [[output]]\nname = \"z\"\nunit = \"1\"\nexpression = \"2 * x^2\"\n";
    let model: UncertaintyModel = toml::from_str(&text).unwrap();
    let options = Evaluate {
        check_digits: 3,
        trials: Trials::Adaptive {
            digits: 4,
            max: 80_000,
        },
        ..Evaluate::default()
    };
    let result = model
        .evaluate(&options, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let few = result
        .findings
        .iter()
        .filter(|f| f.code() == "too-few-trials");
    assert_eq!(few.count(), 1, "{:?}", result.findings);
}

/// An output whose square no number holds takes nothing from another.
#[test]
fn regress_a_covariance_beyond_numbers_refuses_nothing() {
    let text = input("x", "value = 0\nu = 1")
        + "[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"x\"\n\
           [[output]]\nname = \"z\"\nunit = \"1\"\nexpression = \"exp(100 * x)\"\n";
    let result = evaluate(&text);
    let y = result.get("y").unwrap().monte_carlo.as_ref().unwrap();
    let u = y.standard_uncertainty.unwrap();
    // 200 000 trials: 0.16 % is one standard deviation of u.
    assert!((u - 1.0).abs() < 0.01, "{u}");
    assert!(has(&result, "no-standard-deviation"));
}
