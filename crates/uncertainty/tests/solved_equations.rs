//! `[[solve]]`: which solution is found from a start, and how exactly.

use proofmass_uncertainty::{Evaluate, ModelResult, Refusal, Trials, UncertaintyModel};

/// y³ − 3y = x: for |x| < 2 three branches, which meet at the folds y = ±1.
fn cubic(x: f64, start: f64) -> Result<ModelResult, Refusal> {
    solved(x, 0.01, start, "y^3 - 3*y = x")
}

fn solved(x: f64, u: f64, start: f64, equation: &str) -> Result<ModelResult, Refusal> {
    let text = format!(
        "[[input]]\nname = \"x\"\nunit = \"1\"\nvalue = {x:?}\nu = {u:?}\n\
         [[solve]]\nunknown = [\"y\"]\nstart = [{start:?}]\nequations = [\"{equation}\"]\n\
         [[output]]\nname = \"z\"\nunit = \"1\"\nexpression = \"y\"\n"
    );
    let model: UncertaintyModel = toml::from_str(&text).unwrap();
    let options = Evaluate {
        trials: Trials::Fixed(10_000),
        ..Evaluate::default()
    };
    model.evaluate(&options, &mut |_| std::ops::ControlFlow::Continue(()))
}

fn value(result: &ModelResult) -> f64 {
    result
        .get("z")
        .unwrap()
        .linear
        .as_ref()
        .unwrap()
        .quantity
        .value
}

#[test]
fn refuses_to_start_at_a_stationary_point() {
    let refusal = cubic(0.3, 1.0).unwrap_err().to_string();
    assert!(refusal.contains("stationary point"), "{refusal}");
}

/// From beside a fold a whole step of Newton's iteration leads 10⁶ away; the solution is that of the side of the start.
#[test]
fn known_a_start_beside_a_fold_finds_the_branch_of_its_side() {
    let root = |k: f64| 2.0 * ((0.15f64.acos() + k * std::f64::consts::TAU) / 3.0).cos();
    let (high, middle, low) = (root(0.0), root(2.0), root(1.0));
    for (start, expected) in [
        (1.0 + 1e-7, high),
        (1.01, high),
        (1e6, high),
        (1.0 - 1e-7, middle),
        (0.0, middle),
        (-0.999, middle),
        (-1.0 - 1e-7, low),
        (-40.0, low),
    ] {
        let found = value(&cubic(0.3, start).unwrap());
        assert!(
            (found - expected).abs() < 1e-12,
            "{start}: {found} {expected}"
        );
    }
}

/// For x = 2.5 there is one solution, beyond the fold as seen from 0: it is not taken for the branch that ended.
#[test]
fn refuses_to_cross_a_fold() {
    let refusal = cubic(2.5, 0.0).unwrap_err().to_string();
    assert!(refusal.contains("without crossing a fold"), "{refusal}");
    // 2 cosh(arcosh(1.25)/3), and arcosh 1.25 = ln 2.
    let beyond = 2f64.cbrt() + 0.5f64.cbrt();
    assert!((value(&cubic(2.5, 1.5).unwrap()) - beyond).abs() < 1e-12);
}

/// What counts as solved is a matter of the solution, wherever the search starts.
#[test]
fn law_the_start_is_no_measure_of_the_solution() {
    for start in [1e-9, 1.0, 1e9] {
        let result = solved(1e-3, 1e-6, start, "y^3 + y = x").unwrap();
        // y = x − x³ + 3x⁵ − 12x⁷
        assert!(
            (value(&result) - (1e-3 - 1e-9 + 3e-15)).abs() < 1e-17,
            "{start}"
        );
        let trials = result.get("z").unwrap().monte_carlo.as_ref().unwrap();
        assert_eq!(trials.invalid, 0);
        let u = trials.standard_uncertainty.unwrap();
        assert!((u / 1e-6 - 1.0).abs() < 0.03, "{start}: {u}");
    }
    // A solution at zero.
    for start in [1e-9, 1.0, 1e9] {
        let result = solved(0.0, 1e-6, start, "y^3 + y = x").unwrap();
        assert!(value(&result).abs() < 1e-15, "{start}");
    }
}
