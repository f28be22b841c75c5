//! The model files a person starts from, and what a wrong one is told.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn evaluate(text: &str) -> ModelResult {
    let options = Evaluate {
        trials: Trials::Fixed(400_000),
        ..Evaluate::default()
    };
    let model = UncertaintyModel::parse(text).unwrap();
    model
        .evaluate(&options, &mut |_| ControlFlow::Continue(()))
        .unwrap()
}

#[test]
fn published_examples_give_the_published_results() {
    let mass = evaluate(include_str!("../../../examples/uncertainty/mass.toml"));
    let m = &mass.outputs[0];
    assert_eq!(m.quantity.to_string(), "1.234(54) mg");
    assert!((m.monte_carlo.standard_uncertainty - 0.0754).abs() < 0.0005);
    assert_eq!(m.validation.verdict, Verdict::NotValidated);
    assert!(
        mass.findings
            .iter()
            .any(|f| f.code() == "linear-result-not-validated")
    );

    let impedance = evaluate(include_str!("../../../examples/uncertainty/impedance.toml"));
    assert_eq!(impedance.outputs[0].quantity.to_string(), "127.732(71) Ω");
    let r = impedance.estimate.covariance().correlation(0, 2).unwrap();
    assert!((r + 0.485).abs() < 0.0005);

    let gauge = evaluate(include_str!(
        "../../../examples/uncertainty/gauge-block.toml"
    ));
    assert_eq!(gauge.outputs[0].quantity.value.round(), 838.0);
    assert!((gauge.outputs[0].monte_carlo.standard_uncertainty - 36.0).abs() < 0.6);
}

#[test]
fn law_results_survive_json() {
    let result = evaluate(include_str!("../../../examples/uncertainty/mass.toml"));
    let text = serde_json::to_string(&result).unwrap();
    let back: ModelResult = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_string(&back).unwrap(), text);
    assert_eq!(back.outputs[0].quantity, result.outputs[0].quantity);
}

#[test]
fn refuses_wrong_files_with_line_and_field() {
    let good = include_str!("../../../examples/uncertainty/mass.toml");
    for (from, to, line, word) in [
        ("u = 0.020", "u = \"much\"", 15, "much"),
        ("u = 0.020", "v = 0.020", 15, "`v`"),
        (
            "kind = \"rectangular\", lower = 1.10",
            "kind = \"square\", lower = 1.10",
            21,
            "square",
        ),
        ("lower = 1.10", "lower = 1.50", 21, "rho_a: upper = 1.3"),
        ("1 / rho_W", "1 / rho_V", 38, "rho_V"),
        (
            "unit = \"mg\"\ndescription = \"small",
            "units = \"mg\"\ndescription = \"small",
            13,
            "units",
        ),
        ("name = \"dm_R\"", "name = \"sin\"", 12, "means a function"),
        ("name = \"dm_R\"", "name = \"d-m\"", 12, "must be a letter"),
        (
            "name = \"dm_R\"",
            "name = \"m_R\"",
            12,
            "m_R is defined twice",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        match UncertaintyModel::parse(&good.replacen(from, to, 1)) {
            Err(Refusal::File { line: got, reason }) => {
                assert!(reason.contains(word), "{to}: {reason}");
                assert_eq!(got, Some(line), "{to}: {reason}");
            }
            other => panic!("{to}: {other:?}"),
        }
    }
}
