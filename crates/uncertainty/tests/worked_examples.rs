//! Every worked example of `reference/gum` as a model file, against the published figures, and the page that states them.
//!
//! The run fails when a figure is farther off than its last digit and the noise of the trials allow, or when
//! docs/worked-examples.md says otherwise; `-- --nocapture` prints the table of that page.
use proofmass_uncertainty::*;
use std::ops::ControlFlow;

/// Which figure of an output.
#[derive(Clone, Copy)]
enum Figure {
    Value,
    U,
    Dof,
    Mean,
    TrialsU,
    Lower,
    Upper,
    ShortLower,
    ShortUpper,
    /// Correlation with another output.
    With(&'static str),
}
use self::Figure::*;

/// File, output, figure, published, allowed: half of its last digit, plus what 10⁶ trials leave open where they are meant.
type Row = (&'static str, &'static str, Figure, f64, f64);

const ROWS: &[Row] = &[
    ("gum-h1", "l", Value, 50_000_838.0, 0.5),
    ("gum-h1", "l", U, 31.664, 0.005),
    ("gum-h1", "l", Dof, 16.752, 0.01),
    ("gum-h2", "R", Value, 127.732, 5e-4),
    ("gum-h2", "R", U, 0.071, 5e-4),
    ("gum-h2", "X", Value, 219.847, 6e-4),
    ("gum-h2", "X", U, 0.295, 6e-4),
    ("gum-h2", "Z", Value, 254.260, 5e-4),
    ("gum-h2", "Z", U, 0.236, 5e-4),
    ("gum-h2", "R", Dof, 4.0, 1e-9),
    ("gum-h3", "y1", Value, -0.1712, 5e-5),
    ("gum-h3", "y1", U, 0.0029, 5e-5),
    ("gum-h3", "y2", Value, 0.00218, 5e-6),
    ("gum-h3", "y2", U, 0.00067, 5e-6),
    ("gum-h3", "b30", Value, -0.1494, 5e-5),
    ("gum-h3", "b30", U, 0.0041, 5e-5),
    ("gum-h3", "b30", Dof, 9.0, 1e-6),
    // The GUM rounds the ratio of the count rates to 3.167 on the way.
    ("gum-h4-1", "A_x", Value, 0.4300, 6e-5),
    ("gum-h4-1", "A_x", U, 0.0083, 5e-5),
    ("gum-h4-2", "A_x", Value, 0.4304, 5e-5),
    ("gum-h4-2", "A_x", U, 0.0084, 5e-5),
    ("gum-h5", "V_S", Value, 10.000_097, 5e-7),
    ("gum-h5", "V_S", U, 18e-6, 5e-7),
    ("gum-h5", "V_S", Dof, 9.0, 1e-9),
    ("gum-h6", "h", Value, 64.0, 1e-9),
    ("gum-h6", "h", U, 0.55, 5e-3),
    ("s1-9-2-normal", "y", Upper, 3.92, 0.02),
    ("s1-9-2-rectangular", "y", Upper, 3.88, 0.02),
    ("s1-9-2-dominant", "y", TrialsU, 10.15, 0.02),
    ("s1-9-2-dominant", "y", Upper, 17.0, 0.06),
    ("s1-9-3", "deviation", U, 0.0539, 5e-5),
    ("s1-9-3", "deviation", TrialsU, 0.0754, 3e-4),
    ("s1-9-3", "deviation", ShortLower, 1.0834, 0.003),
    ("s1-9-3", "deviation", ShortUpper, 1.3825, 0.003),
    ("s1-9-4-a", "y", TrialsU, 50e-6, 0.6e-6),
    ("s1-9-4-a", "y", ShortUpper, 150e-6, 1.5e-6),
    ("s1-9-4-b", "y", TrialsU, 112e-6, 0.9e-6),
    ("s1-9-4-b", "y", ShortUpper, 367e-6, 4e-6),
    ("s1-9-4-c", "y", TrialsU, 502e-6, 2e-6),
    ("s1-9-4-d", "y", TrialsU, 67e-6, 0.9e-6),
    ("s1-9-4-e", "y", TrialsU, 121e-6, 0.9e-6),
    ("s1-9-4-f", "y", TrialsU, 504e-6, 2e-6),
    ("s1-9-5", "deviation", TrialsU, 36.0, 0.5),
    ("s1-9-5", "deviation", Value, 838.0, 0.5),
    ("s2-9-2-2", "Y1", U, 1.414, 5e-4),
    ("s2-9-2-2", "Y1", With("Y2"), 0.5, 1e-12),
    ("s2-9-2-4", "Y1", U, 3.162, 5e-4),
    ("s2-9-2-4", "Y1", With("Y2"), 0.9, 1e-12),
    ("s2-9-3-a", "r", Mean, 0.013, 5e-4),
    ("s2-9-3-a", "r", TrialsU, 0.007, 5e-4),
    ("s2-9-3-a", "theta", Mean, 0.0, 0.007),
    ("s2-9-3-a", "theta", TrialsU, 1.744, 0.004),
    ("s2-9-3-b", "r", Mean, 0.015, 6e-4),
    ("s2-9-3-b", "r", TrialsU, 0.00776, 3e-5),
    ("s2-9-3-b", "theta", TrialsU, 1.117, 0.004),
    ("s2-9-3-c", "r", Mean, 0.1005, 5e-5),
    ("s2-9-3-c", "r", TrialsU, 0.00997, 4e-5),
    ("s2-9-3-c", "theta", TrialsU, 0.1005, 4e-4),
    ("s2-9-3-d", "r", Mean, 0.012, 5e-4),
    ("s2-9-3-d", "r", TrialsU, 0.008, 5e-4),
    ("s2-9-3-d", "theta", Mean, -0.556, 0.006),
    ("s2-9-3-d", "theta", TrialsU, 1.599, 0.004),
    ("s2-9-3-e", "r", Mean, 0.015, 5e-4),
    ("s2-9-3-e", "r", TrialsU, 0.008, 5e-4),
    ("s2-9-3-e", "theta", Mean, -0.343, 0.004),
    ("s2-9-3-e", "theta", TrialsU, 0.903, 0.003),
    ("s2-9-3-f", "r", Mean, 0.1005, 6e-5),
    ("s2-9-3-f", "r", TrialsU, 0.00990, 4e-5),
    ("s2-9-3-f", "theta", TrialsU, 0.1024, 4e-4),
    ("s2-9-4-gum", "R", U, 0.058, 5e-4),
    ("s2-9-4-gum", "X", U, 0.241, 5e-4),
    ("s2-9-4-gum", "Z", U, 0.193, 5e-4),
    ("s2-9-4-jcgm-102", "R", TrialsU, 0.130, 0.006),
    ("s2-9-4-jcgm-102", "X", TrialsU, 0.540, 0.025),
    ("s2-9-4-jcgm-102", "Z", TrialsU, 0.431, 0.02),
    ("ea-s2-weight", "m_X", Value, 10_000.025, 5e-4),
    ("ea-s2-weight", "m_X", U, 0.0293, 5e-5),
    ("ea-s3-resistor", "R_X", Value, 10_000.178, 1e-3),
    ("ea-s3-resistor", "R_X", U, 8.33e-3, 2e-5),
    ("ea-s4-gauge-block", "l_X", Value, 49_999_926.0, 0.5),
    ("ea-s4-gauge-block", "l_X", U, 36.4, 0.05),
    ("ea-s5-thermocouple", "t_X", U, 0.641, 5e-4),
    ("ea-s6-power-sensor", "K_X", Value, 0.933, 5e-4),
    ("ea-s6-power-sensor", "K_X", U, 0.0162, 5e-5),
    // The document's budget lists rounded contributions.
    ("ea-s7-attenuator", "L_X", Value, 30.043, 5e-4),
    ("ea-s7-attenuator", "L_X", U, 0.0224, 1e-4),
    ("ea-multimeter", "E_X", Value, 0.10, 1e-9),
    ("ea-multimeter", "E_X", U, 0.030, 5e-4),
    ("ea-multimeter", "E_X", Upper, 0.15, 2e-3),
    ("ea-calliper", "E_X", Value, 0.10, 1e-9),
    ("ea-calliper", "E_X", U, 0.033, 8e-4),
    ("ea-s11-block-calibrator", "t_X", Value, 180.10, 1e-9),
    ("ea-s11-block-calibrator", "t_X", U, 0.164, 5e-4),
    ("ea-s11-block-calibrator", "t_X", Upper, 180.4, 0.02),
    ("ea-s12-water-meter", "e_X", U, 9.1e-4, 5e-6),
    // Cut down to 10 for the factor 2.28.
    ("ea-s12-water-meter", "e_X", Dof, 10.0, 1.0),
    ("tn1900-e2-surface-temperature", "tau", Value, 25.6, 0.05),
    ("tn1900-e2-surface-temperature", "tau", U, 0.872, 6e-4),
    ("tn1900-e2-surface-temperature", "tau", Dof, 21.0, 1e-9),
    ("tn1900-e2-surface-temperature", "tau", Lower, 23.8, 0.05),
    ("tn1900-e2-surface-temperature", "tau", Upper, 27.4, 0.05),
    ("tn1900-e3-viscosity", "mu_M", TrialsU, 1.11, 0.01),
    ("tn1900-e3-viscosity", "mu_M", Mean, 5.82, 0.01),
    ("tn1900-e3-viscosity", "mu_M", Lower, 4.05, 0.015),
    ("tn1900-e3-viscosity", "mu_M", Upper, 8.39, 0.03),
    ("tn1900-e11-attenuator", "L_x", Mean, 30.043, 5e-4),
    ("tn1900-e11-attenuator", "L_x", TrialsU, 0.0224, 3e-4),
    ("tn1900-e11-attenuator", "L_x", Lower, 30.006, 1e-3),
    ("tn1900-e11-attenuator", "L_x", Upper, 30.081, 1e-3),
    ("tn1900-e13-expansion", "alpha", Value, 1.7266e-5, 5e-10),
    ("tn1900-e13-expansion", "alpha", TrialsU, 1.74e-6, 4e-8),
    ("tn1900-e15-reflection", "re(Gamma)", Value, 0.0074, 5e-5),
    ("tn1900-e15-reflection", "im(Gamma)", Value, 0.0031, 5e-5),
    ("tn1900-e15-reflection", "re(Gamma)", U, 0.0050, 5e-5),
    ("tn1900-e15-reflection", "im(Gamma)", U, 0.0045, 5e-5),
    (
        "nist-um-10-stefan-boltzmann",
        "sigma",
        Value,
        5.67037e-8,
        5e-14,
    ),
    (
        "nist-um-10-stefan-boltzmann",
        "sigma",
        TrialsU,
        2.05e-13,
        1e-15,
    ),
    ("citac-a1", "c_Cd", Value, 1002.7, 0.05),
    ("citac-a1", "c_Cd", U, 0.835199, 5e-7),
    ("citac-a2", "c_NaOH", Value, 0.102_136_159_706, 1e-12),
    ("citac-a2", "c_NaOH", U, 0.000_100_500_722_124, 1e-15),
    ("citac-a3", "c_HCl", Value, 0.10139, 5e-6),
    ("citac-a3", "c_HCl", U, 0.000_184_3, 1e-7),
    ("citac-a5", "B1", Value, 0.2410, 5e-5),
    ("citac-a5", "B1", U, 0.0050, 5e-5),
    ("citac-a5", "c_0", Value, 0.260, 5e-4),
    ("citac-a5", "c_0", U, 0.018, 5e-4),
    ("citac-a5", "r", Value, 0.0150, 5e-5),
    ("citac-a5", "r", U, 0.0014, 5e-5),
    ("pearson-york", "a", Value, 5.479_910_224, 1e-8),
    ("pearson-york", "b", Value, -0.480_533_407, 1e-9),
    ("npl-ln", "y", Mean, -0.665, 0.003),
    ("npl-ln", "y", TrialsU, 0.606, 0.003),
    ("npl-ln", "y", ShortLower, -1.895, 0.012),
    ("npl-ln", "y", ShortUpper, 0.095, 0.002),
];

fn run(name: &str) -> ModelResult {
    let path = format!("{}/tests/gum/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let model: UncertaintyModel = toml::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
    let options = Evaluate {
        // The line with errors in both variables is solved anew in each trial, and has no figure of the trials here.
        trials: Trials::Fixed(if name == "pearson-york" {
            20_000
        } else {
            1_000_000
        }),
        ..Evaluate::default()
    };
    let result = model.evaluate(&options, &mut |_| ControlFlow::Continue(()));
    result.unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn figure(result: &ModelResult, output: &OutputResult, figure: Figure) -> (&'static str, f64) {
    let linear = || output.linear.as_ref().expect("a linear result");
    let trials = || output.monte_carlo.as_ref().expect("a Monte Carlo result");
    match figure {
        Value => ("value", linear().quantity.value),
        U => ("u", linear().quantity.standard_uncertainty),
        Dof => ("ν", linear().quantity.dof.get()),
        Mean => ("mean of the trials", trials().mean),
        TrialsU => (
            "u of the trials",
            trials().standard_uncertainty.expect("a u"),
        ),
        Lower => ("lower end", trials().symmetric.lower),
        Upper => ("upper end", trials().symmetric.upper),
        ShortLower => ("lower end, shortest", trials().shortest.lower),
        ShortUpper => ("upper end, shortest", trials().shortest.upper),
        With(other) => {
            let estimate = result.estimate.as_ref().expect("an estimate");
            let place = |name: &str| estimate.index_of(name).expect("the output");
            let r = estimate
                .covariance()
                .correlation(place(&output.name), place(other));
            ("correlation", r.expect("two that vary"))
        }
    }
}

/// The same figure as it is stated; the shortest interval never is.
fn stated(stated: &Statement, figure: Figure) -> Option<f64> {
    match figure {
        Value | Mean => Some(stated.value),
        U | TrialsU => stated.standard_uncertainty,
        Dof => stated.dof.map(DegreesOfFreedom::get),
        Lower => Some(stated.interval.lower),
        Upper => Some(stated.interval.upper),
        ShortLower | ShortUpper | With(_) => None,
    }
}

/// Files whose figures were not taken from a copy of the document at hand.
const HEARSAY: &[&str] = &["gum-h4", "s2-", "ea-", "tn1900-", "nist-um-", "npl-"];

/// Eight digits of a number.
fn digits(x: f64) -> String {
    let text = format!("{x:.7e}");
    text.parse::<f64>().map_or(text, |x| format!("{x:?}"))
}

#[test]
fn published_worked_examples() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/worked-examples.md");
    let page = std::fs::read_to_string(page).unwrap_or_else(|e| panic!("{page}: {e}"));
    let mut file = "";
    let mut result = None;
    let mut wrong = Vec::new();
    for &(name, output, which, published, allowed) in ROWS {
        if name != file {
            (file, result) = (name, Some(run(name)));
        }
        let Some(result) = &result else { continue };
        let output = result.get(output).expect("the output");
        let (word, got) = figure(result, output, which);
        let told = stated(&output.stated, which);
        let hearsay = if HEARSAY.iter().any(|h| name.starts_with(h)) {
            "†"
        } else {
            ""
        };
        let head = format!(
            "| `{name}` | {word} of {} | {published}{hearsay} |",
            output.name
        );
        println!(
            "{head} {} | {} | {:+.1e} |",
            digits(got),
            told.map_or("–".to_owned(), digits),
            got - published
        );
        let what = format!("{name}: {word} of {}: {got}", output.name);
        if !((got - published).abs() <= allowed) {
            wrong.push(format!("{what}, published {published} ± {allowed}"));
        }
        // The page has the same, to the digits that another processor may round otherwise.
        let near = |cell: &str, x: Option<f64>| match (cell.parse::<f64>(), x) {
            (Ok(printed), Some(x)) => (printed - x).abs() <= 1e-6 * x.abs() + 1e-3 * allowed,
            (Err(_), None) => true,
            _ => false,
        };
        let line = page.lines().find(|line| line.starts_with(&head));
        let cells: Vec<&str> = line.unwrap_or_default().split(" | ").collect();
        if !(cells.len() == 6 && near(cells[3], Some(got)) && near(cells[4], told)) {
            wrong.push(format!("{what}: docs/worked-examples.md says {line:?}"));
        }
        // Healthy models with units hear nothing of them.
        let units = result
            .findings
            .iter()
            .any(|f| f.code() == "units-do-not-fit");
        assert!(!units, "{name}: {:?}", result.findings);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// No model file stands there without a figure, or with one only here.
#[test]
fn every_model_file_is_compared() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gum");
    let curves = include_str!("curves.rs");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let compared = ROWS.iter().any(|row| row.0 == name);
            assert!(
                compared || curves.contains(&format!("\"{name}\"")),
                "{name}"
            );
        }
    }
}
