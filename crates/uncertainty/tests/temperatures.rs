//! °C counts from another zero than K: what takes one for the other is told.

use proofmass_uncertainty::{Severity, UncertaintyModel};

/// What the units of one formula say.
fn said(inputs: &[(&str, &str)], unit: &str, expression: &str) -> Vec<(Severity, String)> {
    let input = |(name, unit): &(&str, &str)| {
        format!("[[input]]\nname = \"{name}\"\nunit = \"{unit}\"\nvalue = 3\nu = 0.1\n")
    };
    let output =
        format!("[[output]]\nname = \"y\"\nunit = \"{unit}\"\nexpression = \"{expression}\"\n");
    let text: String = inputs.iter().map(input).chain([output]).collect();
    let model: UncertaintyModel = toml::from_str(&text).unwrap();
    let told = model.doubtful_units().into_iter();
    told.map(|f| (f.severity(), f.what().to_owned())).collect()
}

const T: (&str, &str) = ("t", "°C");
const S: (&str, &str) = ("s", "°C");
const KELVIN: (&str, &str) = ("T", "K");
const GAS: (&str, &str) = ("R", "J/(mol·K)");
const SIGMA: (&str, &str) = ("sigma", "W/(m²·K⁴)");
const HEAT: (&str, &str) = ("c", "J/(kg·K)");
const RELATIVE: (&str, &str) = ("alpha", "1/K");
const PER_CELSIUS: (&str, &str) = ("beta", "1/°C");
const SEEBECK: (&str, &str) = ("a", "µV/°C");
const PRESSURE: (&str, &str) = ("p", "Pa");

#[test]
fn known_a_temperature_in_celsius_is_no_absolute_one() {
    let by_kelvin = "multiplies t in °C by a unit with K";
    type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a str, &'a str);
    let cases: &[Case] = &[
        (&[T, GAS], "J/mol", "R * t", by_kelvin),
        (&[T, GAS], "J/mol", "2 * t * R", by_kelvin),
        (&[T, GAS], "J/mol", "R * (t + 0.5)", by_kelvin),
        (&[T, GAS], "J/mol", "R * max(t, 20)", by_kelvin),
        (&[T, SIGMA], "W/m²", "sigma * t^4", by_kelvin),
        (&[T, SIGMA], "W/m²", "sigma * t * t * t * t", by_kelvin),
        (
            &[T, S, SIGMA],
            "W/m²",
            "sigma * (t^4 - s^4)",
            "multiplies t, s in °C by a unit with K",
        ),
        // The mean of two temperatures is one.
        (
            &[T, S, GAS],
            "J/mol",
            "R * mean(t, s)",
            "multiplies t, s in °C by a unit with K",
        ),
        (
            &[T],
            "W/m²",
            "5.67e-8 * t^4",
            "multiplies a power of t in °C by a number without a unit",
        ),
        (&[T, S], "1", "1 - t / s", "divides by s in °C"),
        (
            &[T, GAS, PRESSURE],
            "mol/m³",
            "p / R / t",
            "divides by t in °C",
        ),
        (
            &[T, KELVIN],
            "1",
            "exp(T * (1 / t - 1 / 300))",
            "divides by t in °C",
        ),
        (&[T, S], "1", "sqrt(t) / 20", "raises t in °C to a power"),
        (&[T], "K", "t", "is computed from t in °C, its unit is K"),
        (&[KELVIN], "°C", "T", "is computed in K, its unit is °C"),
        (
            &[KELVIN, GAS],
            "J/mol",
            "R * (T - 273.15)",
            "multiplies a temperature in °C by a unit with K",
        ),
    ];
    for (inputs, unit, expression, expected) in cases {
        let told = said(inputs, unit, expression);
        let first = told.first().map(|(_, what)| what.as_str());
        let expected = format!("the formula of y {expected}");
        assert_eq!(first, Some(expected.as_str()), "{expression}: {told:?}");
        let power = expected.contains("number without a unit");
        let decides = told.iter().any(|(s, _)| *s == Severity::Decision);
        assert_eq!(decides, !power, "{expression}: {told:?}");
    }
}

#[test]
fn known_differences_and_coefficients_per_degree_are_fine() {
    type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a str);
    let cases: &[Case] = &[
        // Differences of two temperatures, or from a reference.
        (&[T, S, HEAT], "J/kg", "c * (t - s)"),
        (&[T, HEAT], "J/kg", "c * (t - 20)"),
        (&[T, HEAT], "J/kg", "c * (t - 20 [°C])"),
        (&[T, S], "K", "t - s"),
        (&[T, S, HEAT, PRESSURE], "J/(kg·Pa)", "c * abs(t - s) / p"),
        (&[T, S, PRESSURE], "Pa/K", "p / (t - s)"),
        // Kelvin, and what is brought there.
        (&[KELVIN, GAS], "J/mol", "R * T"),
        (&[T, GAS], "J/mol", "R * (t + 273.15)"),
        (&[T, GAS], "J/mol", "R * (273.15 + t)"),
        (&[T, GAS], "J/mol", "R * (t + 273.15 [K])"),
        (&[T, SIGMA], "W/m²", "sigma * (t + 273.15)^4"),
        (&[KELVIN], "°C", "T - 273.15"),
        (&[T, S, KELVIN], "1", "(t - s) / T"),
        // Coefficients per degree, and relative ones.
        (&[T, RELATIVE], "1", "alpha * (t - 20)"),
        (&[T, RELATIVE], "1", "1 + alpha * t"),
        (
            &[T, PER_CELSIUS],
            "1",
            "1 + beta * t - 5.775e-7 [1/°C^2] * t^2",
        ),
        (&[T, SEEBECK], "µV", "a * t"),
        (&[T], "1", "1 + 3.9083e-3 * t"),
        (&[T, S], "°C", "mean(t, s) + 0.1"),
        (&[T], "1", "t / 100 [°C]"),
        (
            &[T, S, PER_CELSIUS, HEAT],
            "J/kg",
            "c * (t - s) * (1 + beta * (t - 20))",
        ),
    ];
    for (inputs, unit, expression) in cases {
        let told = said(inputs, unit, expression);
        assert!(told.is_empty(), "{expression}: {told:?}");
    }
}

/// A difference keeps being one where it is an output with a unit of its own.
#[test]
fn known_an_output_may_be_a_difference() {
    let text = |expression: &str| {
        format!(
            "[[input]]\nname = \"t\"\nunit = \"°C\"\nvalue = 25\nu = 0.1\n[[input]]\nname = \"s\"\nunit = \"°C\"\nvalue = 20\nu = 0.1\n\
             [[input]]\nname = \"c\"\nunit = \"J/(kg·K)\"\nvalue = 4180\nu = 1\n\
             [[output]]\nname = \"rise\"\nunit = \"°C\"\nexpression = \"{expression}\"\n\
             [[output]]\nname = \"q\"\nunit = \"J/kg\"\nexpression = \"c * rise\"\n"
        )
    };
    let told = |expression: &str| {
        let model: UncertaintyModel = toml::from_str(&text(expression)).unwrap();
        model.doubtful_units().len()
    };
    assert_eq!((told("t - s"), told("t")), (0, 1));
}
