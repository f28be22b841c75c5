//! The model files a person starts from.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn evaluate(text: &str) -> ModelResult {
    let options = Evaluate {
        trials: Trials::Fixed(400_000),
        ..Evaluate::default()
    };
    let model = toml::from_str::<UncertaintyModel>(text).unwrap();
    model
        .evaluate(&options, &mut |_| ControlFlow::Continue(()))
        .unwrap()
}

#[test]
fn published_examples_give_the_published_results() {
    let mass = evaluate(include_str!("models/mass.toml"));
    let m = &mass.outputs[0];
    let linear = m.linear.as_ref().unwrap();
    assert_eq!(linear.quantity.to_string(), "1.234(54) mg");
    let trials = m.monte_carlo.as_ref().unwrap();
    assert!((trials.standard_uncertainty.unwrap() - 0.0754).abs() < 0.0005);
    let verdict = m.validation.as_ref().unwrap().verdict;
    assert_eq!(verdict, Verdict::NotValidated);
    assert_eq!(m.stated.method, StatementMethod::MonteCarlo);
    assert!(
        mass.findings
            .iter()
            .any(|f| f.code() == "linear-result-not-validated")
    );

    let impedance = evaluate(include_str!("models/impedance.toml"));
    let linear = impedance.outputs[0].linear.as_ref().unwrap();
    assert_eq!(linear.quantity.to_string(), "127.732(71) Ω");
    let r = impedance
        .estimate
        .as_ref()
        .unwrap()
        .covariance()
        .correlation(0, 2)
        .unwrap();
    assert!((r + 0.485).abs() < 0.0005);

    let gauge = evaluate(include_str!("models/gauge-block.toml"));
    let linear = gauge.outputs[0].linear.as_ref().unwrap();
    assert_eq!(linear.quantity.value.round(), 838.0);
    let trials = gauge.outputs[0].monte_carlo.as_ref().unwrap();
    assert!((trials.standard_uncertainty.unwrap() - 36.0).abs() < 0.6);
}

#[test]
fn law_results_survive_json() {
    let result = evaluate(include_str!("models/mass.toml"));
    let text = serde_json::to_string(&result).unwrap();
    let back: ModelResult = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_string(&back).unwrap(), text);
    assert_eq!(back, result);
}
