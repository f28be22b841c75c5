//! Curves through points, against certified values and independent solutions.
use proofmass_uncertainty::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::ops::ControlFlow;

fn read(text: &str) -> UncertaintyModel {
    toml::from_str(text).unwrap_or_else(|e| panic!("{e}"))
}

fn evaluate(model: &UncertaintyModel, trials: usize) -> Result<ModelResult, Refusal> {
    let options = Evaluate {
        trials: Trials::Fixed(trials),
        ..Evaluate::default()
    };
    model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
}

fn by_the_law(model: &UncertaintyModel) -> Linear {
    let (joint, equations) = model.prepared().unwrap();
    propagate(&equations, &joint).unwrap()
}

fn linear(result: &ModelResult, name: &str) -> Quantity {
    let output = result.get(name).expect("the output");
    output
        .linear
        .as_ref()
        .expect("a linear result")
        .quantity
        .clone()
}

/// Set, and value and standard deviation of each parameter as they are certified.
type Certified = (&'static str, &'static [(f64, f64)]);

const SETS: &[Certified] = &[
    (
        "strd-misra1a",
        &[
            (238.94212918, 2.7070075241),
            (0.00055015643181, 7.2668688436e-6),
        ],
    ),
    (
        "strd-danwood",
        &[
            (0.76886226176, 0.01828197386),
            (3.8604055871, 0.051726610913),
        ],
    ),
    (
        "strd-rat43",
        &[
            (699.6415127, 16.302297817),
            (5.2771253025, 2.0828735829),
            (0.75962938329, 0.19566123451),
            (1.2792483859, 0.68761936385),
        ],
    ),
    (
        "strd-eckerle4",
        &[
            (1.5543827178, 0.015408051163),
            (4.0888321754, 0.046803020753),
            (451.54121844, 0.046800518816),
        ],
    ),
    (
        "strd-mgh09",
        &[
            (0.19280693458, 0.011435312227),
            (0.19128232873, 0.19633220911),
            (0.12305650693, 0.080842031232),
            (0.13606233068, 0.090025542308),
        ],
    ),
    (
        "strd-mgh10",
        &[
            (0.005609636471, 0.00015687892471),
            (6181.3463463, 23.309021107),
            (345.22363462, 0.78486103508),
        ],
    ),
    (
        "strd-boxbod",
        &[(213.80940889, 12.354515176), (0.54723748542, 0.10455993237)],
    ),
    (
        "strd-thurber",
        &[
            (1288.13968, 4.6647963344),
            (1491.0792535, 39.571156086),
            (583.23836877, 28.698696102),
            (75.416644291, 5.567537027),
            (0.96629502864, 0.031333340687),
            (0.39797285797, 0.014984928198),
            (0.049727297349, 0.0065842344623),
        ],
    ),
];

/// Nonlinear regression of the NIST Statistical Reference Datasets, from the farther of their two starts (BoxBOD and MGH10 from the nearer).
#[test]
fn published_nist_strd() {
    for (name, certified) in SETS {
        let path = format!("{}/tests/gum/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let model = read(&std::fs::read_to_string(&path).unwrap());
        let (joint, equations) = model.prepared().unwrap_or_else(|e| panic!("{name}: {e}"));
        let result = propagate(&equations, &joint).unwrap();
        let (mut worst, mut worst_u): (f64, f64) = (0.0, 0.0);
        for (k, (value, sd)) in certified.iter().enumerate() {
            let got = result.get(&format!("b{}", k + 1)).unwrap();
            worst = worst.max((got.value / value - 1.0).abs());
            worst_u = worst_u.max((got.standard_uncertainty / sd - 1.0).abs());
            let points = model.input[0].values.as_ref().unwrap().len();
            assert!(
                (got.dof.get() - (points - certified.len()) as f64).abs() < 1e-6,
                "{name}"
            );
        }
        println!(
            "| {name} | {} | {worst:.1e} | {worst_u:.1e} |",
            certified.len()
        );
        assert!(worst < 2e-9, "{name}: {worst:e}");
        assert!(worst_u < 1e-6, "{name}: {worst_u:e}");
    }
}

const DECAY: &str = r#"
[[input]]
name = "t"
unit = "s"
values = [0.0, 0.5, 1.0, 1.6, 2.1, 2.9, 3.4, 4.2]
u_of_each = [0.05, 0.05, 0.08, 0.08, 0.1, 0.1, 0.12, 0.12]
[[input]]
name = "V"
unit = "V"
values = [5.1, 3.9, 3.25, 2.3, 2.05, 1.35, 1.2, 0.8]
u_of_each = [0.1, 0.1, 0.08, 0.08, 0.06, 0.06, 0.05, 0.05]
[[fit]]
name = "decay"
x = "t"
y = "V"
curve = "a * exp(-b * t) + c"
parameters = ["a", "b", "c"]
start = [5, 0.5, 0.1]
weights = "both"
[[output]]
name = "a"
unit = "V"
[[output]]
name = "b"
unit = "1/s"
[[output]]
name = "c"
unit = "V"
"#;

/// The normal equations in the parameters and all eight true abscissae, solved with 40 digits, and their solutions for points
/// that were moved one by one.
#[test]
fn independent_errors_in_both_variables() {
    let result = by_the_law(&read(DECAY));
    for (name, value, u) in [
        ("a", 4.852_358_685_944_1, 0.174_271_521_4),
        ("b", 0.480_488_437_615_43, 0.049_944_021_81),
        ("c", 0.182_001_732_873_18, 0.189_444_799_9),
    ] {
        let got = result.get(name).unwrap();
        assert!((got.value - value).abs() < 1e-9, "{name}: {got:?}");
        assert!(
            (got.standard_uncertainty - u).abs() < 1e-8,
            "{name}: {got:?}"
        );
    }
}

/// A straight line is a polynomial and a curve: both ways give the same, for every weighing.
#[test]
fn law_a_line_is_a_curve() {
    let line = include_str!("gum/pearson-york.toml");
    let line = read(line);
    assert_eq!(line.fit[0].weights, FitWeights::Both);
    for weights in [FitWeights::Equal, FitWeights::Y, FitWeights::Both] {
        for scatter in [FitScatter::None, FitScatter::Residuals] {
            if scatter == FitScatter::Residuals && weights != FitWeights::Equal {
                continue;
            }
            let mut polynomial = line.clone();
            if scatter == FitScatter::Residuals {
                // Draws about the points and about the curve differ in what uncertain abscissae do.
                let x = line.fit[0].x.clone();
                let x = polynomial.input.iter_mut().find(|i| i.name == x).unwrap();
                (x.u, x.u_of_each) = (None, None);
            }
            polynomial.fit[0].weights = weights;
            polynomial.fit[0].scatter = scatter;
            let mut curve = polynomial.clone();
            let [a, b] = &line.fit[0].parameters[..] else {
                panic!("two parameters")
            };
            curve.fit[0].curve = Some(format!("{a} + {b} * {}", line.fit[0].x));
            curve.fit[0].start = Some(vec![1.0, 1.0]);
            let (polynomial, curve) = (by_the_law(&polynomial), by_the_law(&curve));
            for name in [a, b] {
                let (p, c) = (polynomial.get(name).unwrap(), curve.get(name).unwrap());
                let near = |x: f64, y: f64| (x - y).abs() < 1e-9 * x.abs();
                assert!(near(p.value, c.value), "{weights:?} {p:?} {c:?}");
                assert!(
                    near(p.standard_uncertainty, c.standard_uncertainty),
                    "{weights:?} {p:?} {c:?}"
                );
            }
        }
    }
}

/// Known uncertainties of the points propagate with the derivative of the solution, second derivatives of the curve included:
/// 40 digits of the set Misra1a with u = 0.1 for each ordinate.
#[test]
fn independent_weighted_curve() {
    let mut model = read(include_str!("gum/strd-misra1a.toml"));
    model.input[0].u = Some(0.1);
    model.fit[0].weights = FitWeights::Y;
    model.fit[0].scatter = FitScatter::None;
    let result = evaluate(&model, 10_000).unwrap();
    let sampled = result.get("b1").unwrap().monte_carlo.as_ref().unwrap();
    let u_of_trials = sampled.standard_uncertainty.unwrap();
    let (b1, b2) = (linear(&result, "b1"), linear(&result, "b2"));
    let scale = 0.1 / 0.101_878_763_3;
    assert!(
        (u_of_trials / b1.standard_uncertainty - 1.0).abs() < 0.04,
        "{u_of_trials}"
    );
    assert!((b1.value - 238.942_129_179).abs() < 1e-7);
    assert!(
        (b1.standard_uncertainty - 2.714_727_444 * scale).abs() < 1e-7,
        "{b1:?}"
    );
    assert!(
        (b2.standard_uncertainty - 7.287_643_448e-6 * scale).abs() < 1e-13,
        "{b2:?}"
    );
    assert!(
        result
            .findings
            .iter()
            .all(|f| f.code() != "residuals-exceed-uncertainty")
    );
}

/// A vector with a member per point and a quantity of all points may stand in a curve.
#[test]
fn law_other_quantities_in_a_curve() {
    let text = r#"
    [[input]]
    name = "x1"
    unit = "1"
    values = [1, 2, 3, 4, 5]
    [[input]]
    name = "x2"
    unit = "1"
    values = [2, 1, 4, 3, 7]
    [[input]]
    name = "gain"
    unit = "1"
    value = 2
    u = 0.02
    [[intermediate]]
    name = "y"
    expression = "6 * x1 + 10 * x2 + 1"
    [[fit]]
    x = "x1"
    y = "y"
    curve = "gain * (p * x1 + q * x2) + 1"
    parameters = ["p", "q"]
    start = [1, 1]
    [[output]]
    name = "p"
    unit = "1"
    [[output]]
    name = "q"
    unit = "1"
    "#;
    let result = evaluate(&read(text), 10_000).unwrap();
    // p = 3 · 2/gain, q = 5 · 2/gain.
    for (name, value) in [("p", 3.0), ("q", 5.0)] {
        let got = linear(&result, name);
        assert!((got.value - value).abs() < 1e-12, "{got:?}");
        assert!(
            (got.standard_uncertainty - 0.01 * value).abs() < 1e-12,
            "{got:?}"
        );
    }
}

#[test]
fn bad_curves_are_refused_in_words() {
    let said = |change: &dyn Fn(&mut FitEntry)| {
        let mut model = read(DECAY);
        change(&mut model.fit[0]);
        match evaluate(&model, 10_000) {
            Ok(_) => panic!("accepted"),
            Err(refusal) => refusal.to_string(),
        }
    };
    let needs = |text: String, part: &str| assert!(text.contains(part), "{text}");
    needs(said(&|f| f.start = None), "a `curve` needs its `start`");
    needs(
        said(&|f| f.start = Some(vec![1.0])),
        "one finite number per parameter, 3",
    );
    needs(
        said(&|f| f.curve = Some("a * exp(-b * t) + z".into())),
        "no variable is called z",
    );
    needs(
        said(&|f| f.curve = Some("a * b + c".into())),
        "speaks of its abscissa, `t`",
    );
    needs(
        said(&|f| f.curve = Some("a * ln(-1 - t) + b + c".into())),
        "no finite value or slope at `start`",
    );
    // a and b only as their product.
    needs(
        said(&|f| {
            f.curve = Some("a * b * t + c".into());
            f.weights = FitWeights::Equal;
        }),
        "do not determine every parameter",
    );
    needs(
        said(&|f| {
            f.curve = None;
            f.weights = FitWeights::Equal;
        }),
        "`start` belongs to",
    );
    needs(said(&|f| f.parameters[0] = "t".into()), "t");
}

/// Points by the thousand with errors in both variables: each trial searches from the line at the estimates, by York's iteration, and
/// the law of propagation has the derivatives of the same line.
#[test]
fn law_a_thousand_points_with_errors_in_both_variables() {
    let n = 1000;
    let list = |f: &dyn Fn(f64) -> f64| {
        let values: Vec<String> = (0..n).map(|k| format!("{:.6}", f(f64::from(k)))).collect();
        format!("[{}]", values.join(", "))
    };
    let text = format!(
        "[[input]]\nname = \"x\"\nunit = \"1\"\nvalues = {}\nu = 0.3\n\
         [[input]]\nname = \"y\"\nunit = \"1\"\nvalues = {}\nu = 0.4\n\
         [[fit]]\nname = \"line\"\nx = \"x\"\ny = \"y\"\nparameters = [\"a\", \"b\"]\nweights = \"both\"\n\
         [[output]]\nname = \"a\"\nunit = \"1\"\n[[output]]\nname = \"b\"\nunit = \"1\"\n",
        list(&|k| 0.02 * k + 0.3 * (7.0 * k).sin()),
        list(&|k| 1.0 + 0.01 * k + 0.4 * (5.0 * k).cos()),
    );
    let model: UncertaintyModel = toml::from_str(&text).unwrap();
    let begun = std::time::Instant::now();
    let watch = &mut |_: Progress| std::ops::ControlFlow::Continue(());
    let result = model.evaluate(&Evaluate::default(), watch).unwrap();
    println!("{:?}", begun.elapsed());
    for name in ["a", "b"] {
        let output = result.get(name).unwrap();
        let linear = &output.linear.as_ref().unwrap().quantity;
        let trials = output.monte_carlo.as_ref().unwrap();
        let (u, drawn) = (
            linear.standard_uncertainty,
            trials.standard_uncertainty.unwrap(),
        );
        assert!((drawn / u - 1.0).abs() < 0.04, "{name}: {drawn} {u}");
        // Equal u at every point: a slope of 0.5 leaves √(0.4² + 0.25 · 0.3²) = 0.427 across, over √Σ(x − x̄)² of 5.77 √1000.
        if name == "b" {
            assert!(
                (u / (0.427_2 / (5.773_5 * 1000f64.sqrt())) - 1.0).abs() < 0.01,
                "{u}"
            );
        }
    }
}

/// A straight line and the same line as a curve end at the same solution for other points too: York's iteration beside the descent
/// along the distances, whose last step is 10⁻⁸ of what the points leave open.
#[test]
fn law_trials_of_a_line_are_those_of_a_curve() {
    let line = read(include_str!("gum/pearson-york.toml"));
    let mut curve = line.clone();
    curve.fit[0].curve = Some("a + b * x".to_owned());
    curve.fit[0].start = Some(vec![1.0, 1.0]);
    let law = by_the_law(&line);
    let [u_a, u_b] = ["a", "b"].map(|name| law.get(name).unwrap().standard_uncertainty);
    let (joint, line) = line.prepared().unwrap();
    let (_, curve) = curve.prepared().unwrap();
    let (estimates, covariance) = (joint.estimates(), joint.covariance());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(13);
    for trial in 0..2000 {
        let points: Vec<f64> = (estimates.iter().enumerate())
            .map(|(i, x)| x + covariance.standard_uncertainty(i) * rng.random_range(-3.0..3.0))
            .collect();
        let [mut l, mut c] = [[0.0; 2]; 2];
        line.evaluate(&points, &mut l);
        curve.evaluate(&points, &mut c);
        assert!((l[0] - c[0]).abs() < 1e-6 * u_a, "{trial}: {l:?} {c:?}");
        assert!((l[1] - c[1]).abs() < 1e-6 * u_b, "{trial}: {l:?} {c:?}");
    }
}
