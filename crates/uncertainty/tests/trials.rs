//! Trials by columns, and standard deviations at the ends of the number range.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn evaluate(text: &str) -> Result<ModelResult, Refusal> {
    let options = Evaluate {
        trials: Trials::Fixed(20_000),
        ..Evaluate::default()
    };
    let model: UncertaintyModel = toml::from_str(text).unwrap();
    model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
}

/// Every operation of the language, and both kinds of blocks.
const EVERYTHING: &str = r#"
input = [
    { name = "a", unit = "1", value = 1.3, u = 0.4 },
    { name = "b", unit = "1", value = -0.7, u = 0.5 },
    { name = "c", unit = "1", value = 2.1, half_width = 0.3 },
    { name = "t", unit = "1", values = [0.0, 1.0, 2.0, 4.0], u = 0.01 },
    { name = "f", unit = "1", values = [0.1, 1.2, 1.9, 4.3], u = 0.1 },
]
intermediate = [
    { name = "p", expression = "-a + b * c - a / c + c^a + a^3 + b^-2" },
    { name = "q", expression = "sin(a) + cos(b) + tan(a) + asin(b / 9) + acos(b / 9) + atan(a) + sinh(a) + cosh(b) + tanh(a)" },
    { name = "r", expression = "exp(b) + ln(c) + log10(c) + log2(c) + sqrt(c) + cbrt(b) + abs(b) + degrees(a) + radians(b)" },
    { name = "s", expression = "atan2(a, b) + hypot(a, b, c) + min(a, b, c) + max(a, b, c) + if(a < b, a, if(b <= c, b, c))" },
    { name = "z", expression = "complex(a, b)^2 / polar(c, a) + 2j" },
]
output = [
    { name = "y", unit = "1", expression = "p + q - r * s" },
    { name = "w", unit = "1", expression = "sqrt(z)" },
    { name = "line", unit = "1", expression = "y1 + y2 * x" },
    { name = "constant", unit = "1", expression = "3" },
]
solve = [{ unknown = ["x"], start = [1.0], equations = ["x^3 = c"] }]
fit = [{ name = "line", x = "t", y = "f", parameters = ["y1", "y2"] }]
"#;

/// Several trials at once give the same bits as one after the other, whatever their number.
#[test]
fn law_columns_are_trials() {
    let model: UncertaintyModel = toml::from_str(EVERYTHING).unwrap();
    let (joint, equations) = model.prepared().unwrap();
    let (n, m) = (joint.draws().len(), Model::outputs(&equations).len());
    for trials in [1, 7, 8, 100, 300] {
        let columns: Vec<Vec<f64>> = joint
            .draws()
            .iter()
            .enumerate()
            .map(|(k, draw)| {
                let at = |t: usize| ((17 * k + 31 * t) % 41) as f64 / 20.0 - 1.0;
                (0..trials)
                    .map(|t| draw.estimate + at(t) * draw.standard_uncertainty)
                    .collect()
            })
            .collect();
        let x: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut together = vec![vec![0.0; trials]; m];
        let mut y: Vec<&mut [f64]> = together.iter_mut().map(Vec::as_mut_slice).collect();
        equations.evaluate_columns(&x, &mut y);
        let mut alone = vec![0.0; m];
        for t in 0..trials {
            let row: Vec<f64> = (0..n).map(|k| columns[k][t]).collect();
            equations.evaluate(&row, &mut alone);
            for (k, alone) in alone.iter().enumerate() {
                assert!(alone.is_finite(), "output {k}");
                assert_eq!(
                    together[k][t].to_bits(),
                    alone.to_bits(),
                    "output {k} trial {t} of {trials}"
                );
            }
        }
    }
}

/// A rectangular quantity times a power of ten that its square cannot hold.
struct Scaled(f64);

impl Model for Scaled {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![("y".into(), "1".into())]
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        y[0] = x[0] * T::from(self.0);
    }
}

#[test]
fn regress_spreads_whose_square_is_no_number() {
    let rectangular = Distribution::Rectangular {
        lower: -1.0,
        upper: 1.0,
    };
    let joint = Inputs::new()
        .add(Input::new("x", "1", rectangular))
        .single()
        .unwrap();
    let run = MonteCarlo::new(1).trials(Trials::Fixed(20_000));
    let u = |scale: f64| run.run(&Scaled(scale), &joint).unwrap().outputs[0].standard_uncertainty;
    let one = u(1.0).unwrap();
    // 2⁻⁶⁰⁰ is exact: the same digits.
    let small = u(2f64.powi(-600)).unwrap() / 2f64.powi(-600);
    assert!((small / one - 1.0).abs() < 1e-12, "{small} {one}");
    assert_eq!(u(2f64.powi(600)), None);
}

/// 10⁹ in about one of ten thousand trials.
struct Rare;

impl Trial for Rare {
    fn names(&self) -> Vec<(String, String)> {
        vec![("y".into(), "1".into())]
    }
    fn trial(&self, x: &[f64], y: &mut [f64]) {
        y[0] = if x[0] < 1e-4 { 1e9 } else { x[0] };
    }
}

/// A standard deviation that one trial makes is none: the next run has another.
#[test]
fn regress_one_trial_is_no_standard_deviation() {
    let rectangular = Distribution::Rectangular {
        lower: 0.0,
        upper: 1.0,
    };
    let joint = Inputs::new()
        .add(Input::new("x", "1", rectangular))
        .single()
        .unwrap();
    let mut alone = 0;
    for seed in 0..20 {
        let run = MonteCarlo::new(seed).trials(Trials::Fixed(10_000));
        let sampled = run.run(&Rare, &joint).unwrap();
        let hits = (sampled.outputs[0].mean / 1e5).round();
        let u = sampled.outputs[0].standard_uncertainty;
        if hits == 1.0 {
            alone += 1;
            assert_eq!(u, None, "seed {seed}");
        } else if hits == 0.0 {
            assert!((u.unwrap() - 1.0 / 12f64.sqrt()).abs() < 0.01);
        }
    }
    // One event in 10 000 trials at a mean of one: with probability 0.37 each.
    assert!((2..=14).contains(&alone), "{alone}");
}

/// Events so rare that no trial has one leave the law of propagation its result.
#[test]
fn regress_events_that_no_trial_has() {
    let result = evaluate(
        "input = [{ name = \"x\", unit = \"1\", distribution = { kind = \"poisson\", mean = 1e-9 } }]\n\
         output = [{ name = \"y\", unit = \"1\", expression = \"x\" }]\n",
    )
    .unwrap();
    let stated = &result.outputs[0].stated;
    assert_eq!(stated.method, StatementMethod::LawOfPropagation);
    assert!((stated.standard_uncertainty.unwrap() / 1e-9f64.sqrt() - 1.0).abs() < 1e-12);
}

#[test]
fn refuses_negative_limits_by_their_name() {
    for (statement, words) in [
        ("half_width = -1", "`half_width` must not be negative"),
        ("resolution = -1", "`resolution` must not be negative"),
        ("U = -1, k = 2", "`U` must not be negative"),
        (
            "accuracy = { reading_percent = 1, constant = -2 }",
            "`accuracy` must not be negative",
        ),
    ] {
        let said = evaluate(&format!(
            "input = [{{ name = \"x\", unit = \"1\", value = 10, {statement} }}]\n\
             output = [{{ name = \"y\", unit = \"1\", expression = \"x\" }}]\n"
        ))
        .unwrap_err()
        .to_string();
        assert!(said.contains(words), "{said}");
    }
    let said = evaluate(
        "input = [{ name = \"x\", unit = \"1\", distribution = { kind = \"discrete\", values = [1, 2], weights = [0, 0] } }]\n\
         output = [{ name = \"y\", unit = \"1\", expression = \"x\" }]\n",
    )
    .unwrap_err()
    .to_string();
    assert!(
        said.contains("sum of the weights = 0 is not positive"),
        "{said}"
    );
}
