//! What a model asks beside its outputs: conformity, sweeps, target uncertainties.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn evaluate(text: &str, options: Evaluate) -> Result<ModelResult, Refusal> {
    let model: UncertaintyModel = toml::from_str(text).unwrap_or_else(|e| panic!("{e}"));
    model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
}

fn options() -> Evaluate {
    Evaluate {
        trials: Trials::Fixed(200_000),
        ..Evaluate::default()
    }
}

const SUM: &str = r#"
[[input]]
name = "a"
unit = "V"
value = 10
u = 3
[[input]]
name = "b"
unit = "V"
value = 20
u = 4
[[output]]
name = "y"
unit = "V"
expression = "a + b"
"#;

/// The square of a number about zero: the law of propagation says u = 0, and is not what is stated.
const SQUARE: &str = r#"
[[input]]
name = "x"
unit = "1"
value = 0
u = 1
[[output]]
name = "y"
unit = "1"
expression = "x^2"
"#;

#[test]
fn published_conformity_of_a_diode() {
    // `[JCGM106]` 7.4, example 1: −5.47 V with u = 0.05 V, −5.40 V at most.
    let text = r#"
    [[input]]
    name = "V"
    unit = "V"
    value = -5.47
    u = 0.05
    [[output]]
    name = "V"
    unit = "V"
    [[conformity]]
    output = "V"
    upper = -5.40
    [[conformity]]
    output = "V"
    upper = -5.40
    guard_band = 1
    [[conformity]]
    output = "V"
    upper = -5.40
    least_probability = 0.9
    "#;
    let result = evaluate(text, options()).unwrap();
    let [simple, guarded, likely] = &result.conformity[..] else {
        panic!("{:?}", result.conformity)
    };
    assert!((simple.decision.probability - 0.92).abs() < 0.005);
    assert!(simple.decision.accepted && simple.decision.guard_band == Some(0.0));
    assert!((simple.decision.risk - 0.080_757).abs() < 1e-6);
    // U = 1.96 · 0.05: accepted to −5.498 V.
    assert!(!guarded.decision.accepted && (guarded.decision.risk - 0.919_243).abs() < 1e-6);
    assert!((guarded.decision.guard_band.unwrap() - 0.098).abs() < 1e-4);
    assert!((guarded.decision.acceptance.upper.unwrap() + 5.498).abs() < 1e-4);
    assert!(likely.decision.accepted && likely.decision.guard_band.is_none());
}

#[test]
fn law_conformity_is_of_the_stated_distribution() {
    let text = format!("{SQUARE}[[conformity]]\noutput = \"y\"\nupper = 1\n");
    let result = evaluate(&text, options()).unwrap();
    assert_eq!(result.outputs[0].stated.method, StatementMethod::MonteCarlo);
    // P(x² ≤ 1) = P(|x| ≤ 1).
    let decision = &result.conformity[0].decision;
    assert!(
        (decision.probability - 0.682_689).abs() < 0.004,
        "{decision:?}"
    );

    // With a production: trials of a χ² of one degree of freedom about their mean are the errors. A production much narrower
    // than u leaves the items it has.
    let prior = "prior = { kind = \"rectangular\", lower = 0.5, upper = 0.52 }\n";
    let result = evaluate(&format!("{text}{prior}"), options()).unwrap();
    let decision = &result.conformity[0].decision;
    assert!((decision.probability - 1.0).abs() < 1e-9, "{decision:?}");
    assert!(decision.global.unwrap().consumer < 1e-9);
    // Accepted where the draw is not below item + mean − 1 ≈ 0.51.
    let rejected = decision.global.unwrap().producer;
    let expected = 0.524_8; // P(|x| < √0.51)
    assert!((rejected - expected).abs() < 0.01, "{rejected}");
}

#[test]
fn law_sweep_follows_the_model() {
    let text = r#"
    [[input]]
    name = "x"
    unit = "1"
    observations = [0.9, 1.0, 1.1, 1.0]
    [[input]]
    name = "v"
    unit = "1"
    values = [1, 2]
    u = 0.1
    [[output]]
    name = "y"
    unit = "1"
    expression = "x^2 + 0 * v[1]"
    [[output]]
    name = "w"
    unit = "1"
    expression = "sqrt(v[2]) * 2"
    [[sweep]]
    input = "x"
    from = 1
    to = 3
    steps = 5
    [[sweep]]
    input = "v[2]"
    from = -1
    to = 4
    steps = 2
    "#;
    let result = evaluate(text, options()).unwrap();
    let u_x = (0.02f64 / 3.0 / 4.0).sqrt();
    let points = &result.sweeps[0].points;
    let estimates: Vec<f64> = points.iter().map(|p| p.estimate).collect();
    assert_eq!(estimates, [1.0, 1.5, 2.0, 2.5, 3.0]);
    for point in points {
        let y = &point.outputs[0];
        if y.method == StatementMethod::LawOfPropagation {
            assert!((y.value - point.estimate.powi(2)).abs() < 1e-12);
            assert!((y.standard_uncertainty.unwrap() - 2.0 * point.estimate * u_x).abs() < 1e-12);
        }
    }
    // At the estimate itself the sweep states what the result states.
    assert_eq!(
        points[0].outputs,
        result
            .outputs
            .iter()
            .map(|o| o.stated.clone())
            .collect::<Vec<_>>()
    );
    // The root of a negative number is said, and takes nothing from the other point.
    let points = &result.sweeps[1].points;
    assert!(points[0].outputs.is_empty());
    assert!(
        points[0].refused.as_ref().unwrap().contains("output w"),
        "{points:?}"
    );
    assert!((points[1].outputs[1].value - 4.0).abs() < 1e-2);
}

#[test]
fn independent_target_uncertainty() {
    let text = |expanded: f64| format!("{SUM}[[target]]\noutput = \"y\"\nU = {expanded}\n");
    let options = Evaluate {
        coverage_factor: Some(2.0),
        ..options()
    };
    // U = 2 √(3² + 4²) = 10; 8.2 = 2 √(0.9² + 4²) = 2 √(3² + 2.7946²).
    let result = evaluate(&text(8.2), options).unwrap();
    let target = &result.targets[0];
    assert!((target.expanded - 10.0).abs() < 1e-12);
    for (input, u) in target.inputs.iter().zip([0.9, 7.81f64.sqrt()]) {
        assert!((input.needed.unwrap() / u - 1.0).abs() < 1e-5, "{input:?}");
        assert!((input.expanded - 8.2).abs() < 1e-4, "{input:?}");
    }
    // 7.9 is less than 2 · 4, which b leaves were a known; 2 · 3 is less than 7.9.
    let result = evaluate(&text(7.9), options).unwrap();
    let [a, b] = &result.targets[0].inputs[..] else {
        panic!("two inputs")
    };
    assert!(
        a.needed.is_none() && (a.expanded - 8.0).abs() < 1e-6,
        "{a:?}"
    );
    assert!((b.needed.unwrap() - 6.6025f64.sqrt()).abs() < 1e-4, "{b:?}");
    // A larger U than now says how much more an input may have.
    let result = evaluate(&text(12.0), options).unwrap();
    assert!((result.targets[0].inputs[0].needed.unwrap() - 20f64.sqrt()).abs() < 1e-4);

    // Where Monte Carlo states the output its interval is what reaches the target: it shrinks with u².
    let now = evaluate(SQUARE, super_fixed()).unwrap().outputs[0]
        .stated
        .clone();
    let reach = (now.interval.upper - now.value).max(now.value - now.interval.lower);
    let text = format!("{SQUARE}[[target]]\noutput = \"y\"\nU = {}\n", 0.25 * reach);
    let result = evaluate(&text, super_fixed()).unwrap();
    let input = &result.targets[0].inputs[0];
    assert!((input.needed.unwrap() - 0.5).abs() < 1e-4, "{input:?}");
}

fn super_fixed() -> Evaluate {
    Evaluate {
        trials: Trials::Fixed(20_000),
        ..Evaluate::default()
    }
}

/// Readings: their factor grows with few degrees of freedom, and goes into what is needed.
#[test]
fn law_target_of_readings_is_reached() {
    let text = r#"
    [[input]]
    name = "r"
    unit = "V"
    observations = [1.0, 1.3, 0.8, 1.1]
    [[input]]
    name = "c"
    unit = "V"
    value = 0
    half_width = 0.4
    [[output]]
    name = "y"
    unit = "V"
    expression = "r + c"
    [[target]]
    output = "y"
    U = 0.475
    "#;
    let model: UncertaintyModel = toml::from_str(text).unwrap();
    let run = |m: &UncertaintyModel| {
        let result = m.evaluate(&options(), &mut |_| ControlFlow::Continue(()));
        result.unwrap()
    };
    let result = run(&model);
    let target = &result.targets[0];
    let r = &target.inputs[0];
    assert_eq!(r.input, "r");
    // Put in what is needed: readings about their mean 1.05.
    let factor = r.needed.unwrap() / r.standard_uncertainty;
    let mut there = model.clone();
    there.target.clear();
    let readings = there.input[0].observations.as_mut().unwrap();
    readings
        .iter_mut()
        .for_each(|x| *x = 1.05 + factor * (*x - 1.05));
    let linear = run(&there).outputs[0].linear.clone().unwrap();
    assert!(
        (linear.expanded_uncertainty - 0.475).abs() < 1e-5,
        "{linear:?}"
    );
}

#[test]
fn bad_requests_are_refused_in_words() {
    let said = |more: &str| match evaluate(&format!("{SUM}{more}"), options()) {
        Ok(_) => panic!("accepted: {more}"),
        Err(refusal) => refusal.to_string(),
    };
    for (more, words) in [
        (
            "[[conformity]]\noutput = \"z\"\nupper = 1\n",
            "no output is called z; there are: y",
        ),
        (
            "[[conformity]]\noutput = \"y\"\n",
            "a `lower` or an `upper` limit is needed",
        ),
        (
            "[[conformity]]\noutput = \"y\"\nlower = 3\nupper = 1\n",
            "upper limit",
        ),
        (
            "[[conformity]]\noutput = \"y\"\nupper = 1\nguard_band = 1\nleast_probability = 0.9\n",
            "more than once",
        ),
        (
            "[[conformity]]\noutput = \"y\"\nupper = 1\nprior = { kind = \"normal\", mean = 0, u = -1 }\n",
            "`prior`",
        ),
        (
            "[[conformity]]\noutput = \"y\"\nupper = 1\nprior = { kind = \"poisson\", mean = 3 }\n",
            "continuous",
        ),
        (
            "[[sweep]]\ninput = \"q\"\nfrom = 0\nto = 1\nsteps = 3\n",
            "no input is called q",
        ),
        (
            "[[sweep]]\ninput = \"a[1]\"\nfrom = 0\nto = 1\nsteps = 3\n",
            "a is no vector",
        ),
        (
            "[[sweep]]\ninput = \"a\"\nfrom = 0\nto = 1\nsteps = 1\n",
            "`steps`",
        ),
        (
            "[[sweep]]\ninput = \"a\"\nfrom = 1\nto = 1\nsteps = 3\n",
            "two different",
        ),
        ("[[target]]\noutput = \"y\"\nU = 0\n", "above 0"),
        (
            "[[target]]\noutput = \"x\"\nU = 1\n",
            "no output is called x",
        ),
    ] {
        let text = said(more);
        assert!(text.contains(words), "{more}: {text}");
    }
}

/// Numbers of a file are one statement among others.
#[test]
fn bad_columns_are_refused_in_words() {
    let entry = |more: &str| -> InputEntry {
        toml::from_str(&format!("name = \"x\"\nunit = \"1\"\n{more}")).unwrap()
    };
    let mut readings = entry("file = \"a.csv\"\ncolumn = \"x\"\n");
    assert!(
        readings
            .input()
            .unwrap_err()
            .to_string()
            .contains("numbers of its `file`")
    );
    readings.fill(vec![1.0, 2.0, 3.0], None).unwrap();
    assert_eq!(readings.input().unwrap().estimate(), 2.0);
    assert!(
        readings
            .fill(vec![1.0], None)
            .unwrap_err()
            .to_string()
            .contains("more than once")
    );

    let mut vector =
        entry("file = \"a.csv\"\ncolumn = \"x\"\nholds = \"values\"\nu_column = \"u\"\n");
    vector.fill(vec![1.0, 2.0], Some(vec![0.1, 0.2])).unwrap();
    assert_eq!(vector.u_of_each, Some(vec![0.1, 0.2]));

    let mut chain = entry("file = \"a.csv\"\ncolumn = \"x\"\nholds = \"samples\"\n");
    chain.fill(vec![1.0, 5.0], None).unwrap();
    assert_eq!(chain.input().unwrap().estimate(), 3.0);

    let mut u_of_readings = entry("file = \"a.csv\"\ncolumn = \"x\"\nu_column = \"u\"\n");
    let refused = u_of_readings.fill(vec![1.0, 2.0], Some(vec![0.1, 0.2]));
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("holds = \"values\"")
    );
    let alone = entry("value = 1\ncolumn = \"x\"\n").input();
    assert!(alone.unwrap_err().to_string().contains("belong to a table"));
}
