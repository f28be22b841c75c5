//! Findings of this room: a model with one fault each, and its sound twin.

use proofmass_uncertainty::*;
use std::ops::ControlFlow;

fn found(text: &str) -> Vec<Finding> {
    let options = Evaluate {
        trials: Trials::Fixed(50_000),
        ..Evaluate::default()
    };
    let model: UncertaintyModel = toml::from_str(text).unwrap();
    let result = model.evaluate(&options, &mut |_| ControlFlow::Continue(()));
    result.unwrap().findings
}

fn insist(code: &str, found: &[Finding]) {
    assert!(found.iter().any(|f| f.code() == code), "{code}: {found:#?}");
}

fn spare(code: &str, found: &[Finding]) {
    assert!(
        !found.iter().any(|f| f.code() == code),
        "{code}: {found:#?}"
    );
}

fn one(input: &str, expression: &str) -> Vec<Finding> {
    found(&format!(
        "[[input]]\nname = \"x\"\nunit = \"1\"\n{input}\n\
         [[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"{expression}\"\n"
    ))
}

#[test]
fn known_observations_without_scatter() {
    insist(
        "no-scatter",
        &one("observations = [1.5, 1.5, 1.5, 1.5]", "x + 1"),
    );
    spare(
        "no-scatter",
        &one("observations = [1.5, 1.4, 1.5, 1.6]", "x + 1"),
    );
}

#[test]
fn known_models_that_one_road_cannot_take() {
    // √x² has no derivative at zero; of the logarithm almost no trial has a value.
    insist("no-linear-result", &one("value = 0\nu = 1", "sqrt(x^2)"));
    spare("no-linear-result", &one("value = 5\nu = 1", "sqrt(x^2)"));
    let steep = "ln(1 - 1e12 * (x - 1)^2) + x";
    insist("no-monte-carlo-result", &one("value = 1\nu = 1", steep));
    spare("no-monte-carlo-result", &one("value = 1\nu = 1e-9", steep));
}

/// Doubles near 10¹⁷ lie 16 apart: 10¹⁷ ± 0.1 cannot be drawn, nor can an output be 10¹⁷ + x with u(x) = 0.1.
#[test]
fn known_uncertainties_that_rounding_takes_away() {
    insist("finer-than-doubles", &one("value = 1e17\nu = 0.1", "2 * x"));
    insist("finer-than-doubles", &one("value = 1\nu = 1e-17", "x - 1"));
    insist(
        "finer-than-doubles",
        &one("value = 0.3\nu = 0.1", "1e17 + x"),
    );
    spare("finer-than-doubles", &one("value = 1e17\nu = 200", "2 * x"));
    spare("finer-than-doubles", &one("value = 0\nu = 1e-17", "2 * x"));
    spare(
        "finer-than-doubles",
        &one("value = 1e17\nu = 1e15", "x / x"),
    );
}

#[test]
fn known_one_flat_input_that_dominates() {
    insist(
        "dominant-non-normal-input",
        &one("value = 1\nhalf_width = 1", "2 * x"),
    );
    spare(
        "dominant-non-normal-input",
        &one("value = 1\nu = 1", "2 * x"),
    );
}

#[test]
fn known_correlated_inputs_that_are_not_normal() {
    let pair = |known: &str| {
        found(&format!(
            "[[input]]\nname = \"a\"\nunit = \"1\"\n{known}\n\
             [[input]]\nname = \"b\"\nunit = \"1\"\n{known}\n\
             [[correlation]]\nbetween = [\"a\", \"b\"]\ncoefficient = 0.3\n\
             [[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"a + b\"\n"
        ))
    };
    insist("normal-copula", &pair("value = 1\nhalf_width = 1"));
    spare("normal-copula", &pair("value = 1\nu = 1"));
}

/// A straight line through points that lie 10 u beside it, in turn above and below.
#[test]
fn known_points_that_scatter_beyond_their_uncertainty() {
    let weighted = |off: f64, u: f64, weights: &str| {
        let points = (0..8).map(|k| {
            let y = 0.5 * f64::from(k) + if k % 2 == 0 { off } else { -off };
            let u = match u > 0.0 {
                true => format!("u = {u:?}\n"),
                false => String::new(),
            };
            format!("[[input]]\nname = \"y{k}\"\nunit = \"1\"\nvalue = {y:.4}\n{u}")
        });
        let names: Vec<String> = (0..8).map(|k| format!("y{k}")).collect();
        found(&format!(
            "{}[[input]]\nname = \"x\"\nunit = \"1\"\nvalues = [0, 1, 2, 3, 4, 5, 6, 7]\n\
             [[fit]]\nname = \"line\"\nx = \"x\"\ny = \"[{}]\"\nparameters = [\"a\", \"b\"]\nweights = \"{weights}\"\n\
             [[output]]\nname = \"b\"\nunit = \"1\"\n",
            points.collect::<String>(),
            names.join(", ")
        ))
    };
    for weights in ["y", "equal"] {
        insist(
            "residuals-exceed-uncertainty",
            &weighted(0.1, 0.01, weights),
        );
        spare(
            "residuals-exceed-uncertainty",
            &weighted(0.005, 0.01, weights),
        );
    }
    // Points without any uncertainty that no line goes through, and those that one does.
    insist("residuals-exceed-uncertainty", &weighted(0.1, 0.0, "equal"));
    spare("residuals-exceed-uncertainty", &weighted(0.0, 0.0, "equal"));
}

#[test]
fn known_uncertainty_from_two_degrees_of_freedom() {
    insist(
        "few-degrees-of-freedom",
        &one("observations = [1.5, 1.4, 1.6]", "2 * x"),
    );
    spare(
        "few-degrees-of-freedom",
        &one(
            "observations = [1.5, 1.4, 1.6, 1.5, 1.7, 1.4, 1.5]",
            "2 * x",
        ),
    );
}
