//! What is stated, by which method, and what another model that reads it gets.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn options() -> Evaluate {
    Evaluate {
        trials: Trials::Fixed(200_000),
        ..Evaluate::default()
    }
}

fn evaluate_with(model: &UncertaintyModel, options: &Evaluate) -> ModelResult {
    let watch = &mut |_: Progress| ControlFlow::Continue(());
    model.evaluate(options, watch).unwrap()
}

fn read(text: &str) -> UncertaintyModel {
    toml::from_str(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn evaluate(text: &str) -> ModelResult {
    evaluate_with(&read(text), &options())
}

fn input(name: &str, rest: &str) -> String {
    format!("[[input]]\nname = \"{name}\"\nunit = \"1\"\n{rest}\n")
}

fn output(name: &str, expression: &str) -> String {
    format!("[[output]]\nname = \"{name}\"\nunit = \"1\"\nexpression = \"{expression}\"\n")
}

/// A second model on results as a file would hand them over.
fn second(firsts: &[(&ModelResult, &str)], rest: &str) -> ModelResult {
    let mut text = String::new();
    for (k, (_, quantities)) in firsts.iter().enumerate() {
        text +=
            &format!("[[earlier]]\nfile = \"{k}/result.json\"\nquantities = {{ {quantities} }}\n");
    }
    let mut model = read(&(text + rest));
    for (entry, (result, _)) in model.earlier.iter_mut().zip(firsts) {
        entry.estimate = result.stated.clone();
        entry.trials = result.table.clone();
    }
    evaluate_with(&model, &options())
}

fn close(got: f64, expected: f64, allowed: f64) {
    assert!(
        (got - expected).abs() <= allowed,
        "{got} is not {expected} ± {allowed}"
    );
}

fn reference(name: &str) -> String {
    let path = format!("{}/tests/gum/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Three readings and more: Student's t of each input in the trials is no reason to leave y ± U of the GUM.
#[test]
fn published_few_degrees_of_freedom_are_no_nonlinearity() {
    for (file, output, u, expanded) in [
        ("gum-h4-1", "A_x", 0.0083, None),
        // EA-4/02 S12.9: k = 2.28 at ν_eff cut down to 10; here at 10.4.
        ("ea-s12-water-meter", "e_X", 0.00091, Some(0.0020)),
    ] {
        let result = evaluate(&reference(file));
        let stated = &result.get(output).unwrap().stated;
        assert_eq!(stated.method, StatementMethod::LawOfPropagation, "{file}");
        close(stated.standard_uncertainty.unwrap(), u, 0.006 * u);
        if let Some(expanded) = expanded {
            close(stated.expanded_uncertainty.unwrap(), expanded, 5e-5);
        }
        let findings = result.findings.iter();
        let mut codes = findings.map(Finding::code);
        assert!(
            codes.any(|code| code == "few-degrees-of-freedom-differ"),
            "{file}: {:?}",
            result.findings
        );
        let decision = |f: &&Finding| f.code() == "linear-result-not-validated";
        assert_eq!(result.findings.iter().find(decision), None, "{file}");
    }
    let twice = Evaluate {
        coverage_factor: Some(2.0),
        ..options()
    };
    let result = evaluate_with(&read(&reference("ea-s12-water-meter")), &twice);
    let stated = &result.get("e_X").unwrap().stated;
    assert_eq!(stated.coverage_factor, Some(2.0));
    close(stated.expanded_uncertainty.unwrap(), 2.0 * 0.000907, 2e-6);
}

/// Each method states what it says; the law of propagation stands beside it in any case.
#[test]
fn known_square_by_every_method() {
    let text = input("x", "value = 1\nu = 0.5") + &output("y", "x^2");
    // Mean 1 + u², variance 4u² + 2u⁴.
    let variance: f64 = 4.0 * 0.25 + 2.0 * 0.0625;
    for (method, stated, value, u) in [
        (None, StatementMethod::MonteCarlo, 1.25, variance.sqrt()),
        (
            Some(Method::Linear),
            StatementMethod::LawOfPropagation,
            1.0,
            1.0,
        ),
        (
            Some(Method::SecondOrder),
            StatementMethod::SecondOrder,
            1.25,
            variance.sqrt(),
        ),
        (
            Some(Method::MonteCarlo),
            StatementMethod::MonteCarlo,
            1.25,
            variance.sqrt(),
        ),
    ] {
        let result = evaluate_with(
            &read(&text),
            &Evaluate {
                method,
                ..options()
            },
        );
        let y = &result.outputs[0];
        assert_eq!(y.stated.method, stated);
        close(y.stated.value, value, 0.01);
        close(y.stated.standard_uncertainty.unwrap(), u, 0.01);
        assert_eq!(
            y.linear.as_ref().unwrap().quantity.standard_uncertainty,
            1.0
        );
        // What is passed on is what is stated, to the last digit.
        let passed = result.stated.as_ref().unwrap().get("y").unwrap();
        close(passed.value, y.stated.value, 1e-12);
        close(
            passed.standard_uncertainty,
            y.stated.standard_uncertainty.unwrap(),
            1e-9,
        );
        // k and U only where the interval is y ± k u.
        let by_trials = stated == StatementMethod::MonteCarlo;
        assert_eq!(y.stated.coverage_factor.is_none(), by_trials);
        assert_eq!(y.stated.expanded_uncertainty.is_none(), by_trials);
    }
    // The model file says it, and the caller may say otherwise.
    let model = read(&format!("method = \"linear\"\n{text}"));
    let y = evaluate_with(&model, &options()).outputs[0].stated.clone();
    assert_eq!(y.method, StatementMethod::LawOfPropagation);
    let auto = Evaluate {
        method: Some(Method::Auto),
        ..options()
    };
    let y = evaluate_with(&model, &auto).outputs[0].stated.clone();
    assert_eq!(y.method, StatementMethod::MonteCarlo);
    // A factor about the mean of the trials: |x² − 1.25| ≤ 2 · 1.06066 is |x| ≤ 1.83605, for the lower end is below zero.
    let twice = Evaluate {
        coverage_factor: Some(2.0),
        ..options()
    };
    let y = evaluate_with(&read(&text), &twice).outputs[0]
        .stated
        .clone();
    close(y.expanded_uncertainty.unwrap(), 2.0 * variance.sqrt(), 0.02);
    let edge = (1.25 + 2.0 * variance.sqrt()).sqrt();
    let phi = |z: f64| 1.0 - 0.5 * (1.0 - two_sided(z)).max(0.0);
    let expected = phi((edge - 1.0) / 0.5) - (1.0 - phi((edge + 1.0) / 0.5));
    // Of 20 000 rows a share of 5 % is known to 0.0015.
    close(y.probability, expected, 0.006);
}

/// P(|Z| ≤ z) of the standard normal, by Simpson's rule.
fn two_sided(z: f64) -> f64 {
    let n = 2000;
    let h = z / n as f64;
    let f = |x: f64| (-0.5 * x * x).exp() / (0.5 * std::f64::consts::PI).sqrt();
    let inner: f64 = (1..n)
        .map(|k| f(k as f64 * h) * if k % 2 == 1 { 4.0 } else { 2.0 })
        .sum();
    h / 3.0 * (f(0.0) + inner + f(z))
}

/// x² at 0 ± 1 is 1 with u = √2, and so it is to a model that reads it.
#[test]
fn known_a_refuted_result_is_passed_on_as_stated() {
    let first = evaluate(&(input("x", "value = 0\nu = 1") + &output("y", "x^2")));
    let result = second(&[(&first, "q = \"y\"")], &output("z", "3 * q"));
    let z = &result.outputs[0];
    let linear = &z.linear.as_ref().unwrap().quantity;
    close(linear.value, 3.0, 0.03);
    close(linear.standard_uncertainty, 3.0 * 2f64.sqrt(), 0.05);
    // χ² with one degree of freedom: 0.00098 and 5.0239 at 2.5 and 97.5 %.
    assert_eq!(z.stated.method, StatementMethod::MonteCarlo);
    close(z.stated.interval.lower, 0.003, 0.002);
    close(z.stated.interval.upper, 15.07, 0.4);
    close(z.stated.value, 3.0 * first.outputs[0].stated.value, 0.05);
}

/// 1/x of N(3, 1) has no mean: the median is stated, and whoever reads it draws the trials where they lie.
#[test]
fn regress_a_result_without_a_mean_is_not_moved() {
    let first = evaluate(&(input("x", "value = 3\nu = 1") + &output("y", "1/x")));
    let stated = &first.outputs[0].stated;
    assert!(stated.standard_uncertainty.is_none());
    let later = second(&[(&first, "q = \"y\"")], &output("z", "q"));
    let z = later.outputs[0].monte_carlo.as_ref().unwrap();
    // 20 000 rows: a quantile at 2.5 % is known to 1 % of the width.
    let width = stated.interval.upper - stated.interval.lower;
    close(z.median, stated.value, 0.02 * width);
    close(z.symmetric.lower, stated.interval.lower, 0.03 * width);
    close(z.symmetric.upper, stated.interval.upper, 0.03 * width);
}

/// Two results that curvature moves, with a cause in common: it cancels in their difference, and what that costs is said.
#[test]
fn known_what_curved_results_share_is_drawn_by_the_law_of_propagation() {
    let first = evaluate(&(input("x", "value = 1\nu = 0.05") + &output("y", "x^2")));
    let table = first.table.as_ref().expect("trials are passed on");
    assert!(table.columns[0].loose);
    let later = second(
        &[(&first, "a = \"y\""), (&first, "b = \"y\"")],
        &output("z", "a - b + 0 * a"),
    );
    assert!(
        later
            .findings
            .iter()
            .any(|f| f.code() == "earlier-result-linearised")
    );
    let u = later.outputs[0]
        .monte_carlo
        .as_ref()
        .unwrap()
        .standard_uncertainty;
    // One of the two follows from the cause in the row of the other: only curvature is left, u(x)² √2.
    assert!(u.unwrap() < 0.01, "{u:?}");
}

/// What a refuted result shares with another correlates them, in the trials and by the law of propagation.
#[test]
fn known_a_cause_shared_with_a_refuted_result() {
    let share = input("s", "value = 0\nu = 1");
    let curved =
        evaluate(&(share.clone() + &input("e", "value = 0\nu = 1") + &output("y", "s + e^2")));
    assert_eq!(curved.outputs[0].stated.method, StatementMethod::MonteCarlo);
    let straight =
        evaluate(&(share.clone() + &input("f", "value = 0\nu = 0.5") + &output("v", "2 * s + f")));
    assert_eq!(
        straight.outputs[0].stated.method,
        StatementMethod::LawOfPropagation
    );
    // 2 y − v = 2 e² − f: s cancels.
    let expected = (8.0 + 0.25f64).sqrt();
    for order in [false, true] {
        let mut firsts = vec![(&curved, "y = \"y\""), (&straight, "v = \"v\"")];
        if order {
            firsts.reverse();
        }
        let d = second(&firsts, &output("d", "2 * y - v"));
        let d = &d.outputs[0];
        close(
            d.monte_carlo
                .as_ref()
                .unwrap()
                .standard_uncertainty
                .unwrap(),
            expected,
            0.03 * expected,
        );
        let linear = d.linear.as_ref().unwrap().quantity.standard_uncertainty;
        close(linear, expected, 0.02 * expected);
        assert!(d.stated.interval.lower > -2.0, "{:?}", d.stated.interval);
    }
    // The estimate says so too: cov(y, s) = 1, and the rest is e².
    let stated = curved.stated.as_ref().unwrap();
    let of_s = stated.influences().iter().find(|i| i.key == "s").unwrap();
    let Effect::Scalar { sensitivity, .. } = &of_s.effect else {
        panic!("{of_s:?}")
    };
    close(sensitivity[0], 1.0, 0.05);
    // Rows of two tables cannot be drawn together, and that is said.
    let other = evaluate(&(share + &output("w", "s^2")));
    let d = second(
        &[(&curved, "y = \"y\""), (&other, "w = \"w\"")],
        &output("d", "y - w"),
    );
    assert!(
        d.findings
            .iter()
            .any(|f| f.code() == "shared-causes-of-trials")
    );
}

/// A cause whose u was copied with fewer digits is two causes: a note names both, and the same u is one cause without it.
#[test]
fn known_causes_that_are_nearly_alike_are_told() {
    let first = |u: &str, own: &str| {
        evaluate(
            &(input("standard", &format!("value = 5\nu = {u}"))
                + &input("own", &format!("value = 0\nu = {own}"))
                + &output("y", "standard + own")),
        )
    };
    let (a, b) = (first("0.03", "0.001"), first("0.0300001", "0.002"));
    let difference = |b: &ModelResult| {
        let result = second(
            &[(&a, "y = \"y\""), (b, "w = \"y\"")],
            &output("d", "y - w"),
        );
        let mut told = result.findings.iter();
        let told = told.find(|f| f.code() == "causes-nearly-alike");
        let told = told.map_or("", |f| f.evidence_text()).to_owned();
        let u = result.outputs[0].linear.as_ref().unwrap();
        (u.quantity.standard_uncertainty, told)
    };
    let (u, told) = difference(&b);
    close(u, 0.03 * 2f64.sqrt(), 2e-3);
    for words in ["standard: u = 0.03 in 0/", "0.0300001 in 1/"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let (u, told) = difference(&first("0.03", "0.002"));
    assert!(u < 0.003 && told.is_empty(), "{u} {told}");
    // 5 % apart are two causes without a word.
    assert!(difference(&first("0.0315", "0.002")).1.is_empty());
}

/// In a result of both kinds, what is stated linearly keeps the shape that its few degrees of freedom have.
#[test]
fn known_a_linear_quantity_beside_a_refuted_one() {
    let first = evaluate(
        &(input("x", "value = 0\nu = 1\ndof = 6")
            + &input("e", "value = 0\nu = 1")
            + &output("y", "x")
            + &output("q", "e^2")),
    );
    let method = |name: &str| first.get(name).unwrap().stated.method;
    assert_eq!(method("y"), StatementMethod::LawOfPropagation);
    assert_eq!(method("q"), StatementMethod::MonteCarlo);
    let both = second(
        &[(&first, "y = \"y\", q = \"q\"")],
        &output("z", "y + 0.01 * q"),
    );
    let trials = both.outputs[0].monte_carlo.as_ref().unwrap();
    // Variance ν/(ν − 2) = 1.5 of t; t(6) at 97.5 % is 2.447.
    close(trials.standard_uncertainty.unwrap(), 1.5f64.sqrt(), 0.03);
    close(trials.symmetric.upper, 2.447 + 0.01, 0.06);
}

/// y³ − 3y = x has its branch y > 1 for x > −2 alone: trials beyond the fold are lost, the others stay on it.
#[test]
fn known_branches_end_at_a_fold() {
    let text = input("x", "value = -1.5775\nu = 0.5")
        + "[[solve]]\nunknown = [\"y\"]\nstart = [1.5]\nequations = [\"y^3 - 3*y = x\"]\n"
        + &output("branch", "y - 2*cos(acos(x/2)/3)")
        + &output("z", "y");
    let result = evaluate(&text);
    // Φ(−0.845) = 0.1991, of 200 000 trials known to 0.0009.
    let z = result.get("z").unwrap().monte_carlo.as_ref().unwrap();
    close(z.invalid as f64 / result.trials as f64, 0.1991, 0.004);
    let off = result.get("branch").unwrap().monte_carlo.as_ref().unwrap();
    assert!(off.symmetric.width() < 1e-9, "{:?}", off.symmetric);
    assert!(z.symmetric.lower > 1.0);
    let lost = result
        .findings
        .iter()
        .find(|f| f.code() == "invalid-trials")
        .unwrap();
    assert_eq!(lost.severity(), Severity::Decision);
}

/// Two circles that cross: neither point is left for the other, and what depends weakly on an unknown at zero is followed.
#[test]
fn known_crossing_of_circles_keeps_its_side() {
    let text = input("r", "value = 5\nu = 0.3")
        + &input("s", "value = 5\nu = 0.3")
        + "[[solve]]\nunknown = [\"px\", \"py\"]\nstart = [0.5, 1.0]\nequations = [\"hypot(px + 3, py) = r\", \"hypot(px - 3, py) = s\"]\n"
        + &output("x", "px - (r^2 - s^2)/12")
        + &output("y", "py");
    let result = evaluate(&text);
    let of = |name: &str| result.get(name).unwrap().monte_carlo.as_ref().unwrap();
    assert!(of("x").symmetric.width() < 1e-9, "{:?}", of("x").symmetric);
    assert_eq!((of("x").invalid, of("y").invalid), (0, 0));
    assert!(of("y").symmetric.lower > 2.0);
}

/// Parameters that are drawn as a whole have the covariance of the law of propagation, whatever the points share.
#[test]
fn law_many_points_are_drawn_as_parameters() {
    let n = 60;
    let list = |f: &dyn Fn(f64) -> f64| {
        let values: Vec<String> = (0..n).map(|k| format!("{}", f(k as f64))).collect();
        format!("[{}]", values.join(", "))
    };
    let points = input("t", &format!("values = {}", list(&|k| k)))
        + &input(
            "b",
            &format!(
                "values = {}\nu = 0.2",
                list(&|k| 1.0 + 0.3 * k + 0.1 * (7.0 * k).sin())
            ),
        );
    for scatter in ["", "scatter = \"residuals\"\n", "weights = \"y\"\n"] {
        let fit = format!("[[fit]]\nx = \"t\"\ny = \"b\"\nparameters = [\"p\", \"q\"]\n{scatter}");
        let text = points.clone()
            + &input("at", "value = 90\nu = 0.5")
            + &fit
            + &output("far", "p + q * at")
            + &output("q1", "q");
        let result = evaluate(&text);
        for name in ["far", "q1"] {
            let output = result.get(name).unwrap();
            let linear = &output.linear.as_ref().unwrap().quantity;
            let trials = output.monte_carlo.as_ref().unwrap();
            // √(ν/(ν − 2)) of t with 58 degrees of freedom is 1.018.
            let u = linear.standard_uncertainty;
            close(trials.standard_uncertainty.unwrap() / u, 1.005, 0.02);
            close(trials.mean, linear.value, 0.02 * u);
            assert_eq!(
                output.validation.as_ref().unwrap().verdict,
                Verdict::Validated,
                "{scatter}"
            );
        }
        let covariance = result.monte_carlo_covariance.as_ref().unwrap();
        let linear = result
            .estimate
            .as_ref()
            .unwrap()
            .covariance()
            .correlation(0, 1)
            .unwrap();
        close(covariance.correlation(0, 1).unwrap(), linear, 0.01);
    }
}
