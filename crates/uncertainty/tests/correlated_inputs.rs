//! The coefficient that is stated is the one that the draws have, whatever their distributions.

use proofmass_uncertainty::{Evaluate, ModelResult, Refusal, Trials, UncertaintyModel};
use std::ops::ControlFlow;

const TRIALS: usize = 400_000;

const SHAPES: [(&str, &str); 6] = [
    ("rectangular", "value = 1\nhalf_width = 1"),
    ("arcsine", "value = 1\nhalf_width = 1\nshape = \"arcsine\""),
    (
        "exponential",
        "distribution = { kind = \"exponential\", mean = 2 }",
    ),
    (
        "lognormal",
        "distribution = { kind = \"lognormal\", median = 1, sigma = 0.8 }",
    ),
    (
        "discrete",
        "distribution = { kind = \"discrete\", values = [0, 1, 4], weights = [5, 3, 1] }",
    ),
    ("normal", "value = 1\nu = 0.5"),
];

fn pair(first: &str, second: &str, r: f64) -> Result<ModelResult, Refusal> {
    let text = format!(
        "[[input]]\nname = \"a\"\nunit = \"1\"\n{first}\n[[input]]\nname = \"b\"\nunit = \"1\"\n{second}\n\
         [[correlation]]\nbetween = [\"a\", \"b\"]\ncoefficient = {r:?}\n\
         [[output]]\nname = \"x\"\nunit = \"1\"\nexpression = \"a\"\n[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"b\"\n"
    );
    let model: UncertaintyModel = toml::from_str(&text).unwrap();
    let options = Evaluate {
        trials: Trials::Fixed(TRIALS),
        ..Evaluate::default()
    };
    model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn law_draws_have_the_stated_coefficient() {
    for (k, (first, a)) in SHAPES.iter().enumerate() {
        for (second, b) in &SHAPES[..=k] {
            for r in [0.7, -0.3] {
                let result = pair(a, b, r).unwrap();
                let covariance = result.monte_carlo_covariance.as_ref().unwrap();
                let drawn = covariance.correlation(0, 1).unwrap();
                // (1 − r²)/√N for normal draws; up to five times as much where the tails are those of a lognormal.
                assert!(
                    (drawn - r).abs() < 0.008,
                    "{first}, {second}: {drawn} for {r}"
                );
                let linear = result.estimate.as_ref().unwrap().covariance();
                assert!((linear.correlation(0, 1).unwrap() - r).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn refuses_a_coefficient_that_two_distributions_cannot_have() {
    let (lognormal, rectangular, normal) = (SHAPES[3].1, SHAPES[0].1, SHAPES[5].1);
    // (exp(−σ²) − 1)/(exp(σ²) − 1) = −0.527 for σ = 0.8; √(3/π) = 0.977.
    let said = pair(lognormal, lognormal, -0.6).unwrap_err().to_string();
    assert!(said.contains("allow -0.527 to 1.000"), "{said}");
    let said = pair(rectangular, normal, 0.99).unwrap_err().to_string();
    assert!(said.contains("allow -0.977 to 0.977"), "{said}");
    assert!(pair(rectangular, rectangular, 1.0).is_ok());
    assert!(pair(rectangular, rectangular, -1.0).is_ok());
}
