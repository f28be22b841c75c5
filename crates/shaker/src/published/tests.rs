use super::super::geometry::published_plan;
use super::*;

/// One published case of one frequency: A, U(A), S, U(S) in the order xx … zz; S in mV/(m/s²).
struct Case {
    frequency: f64,
    a: [f64; 9],
    u_a: [f64; 9],
    s: [f64; 9],
    u_s: [f64; 9],
}

/// Rows of a case of `reference/inrim-pcb356a15/matrices.csv`.
fn cases(case: &str) -> Vec<Case> {
    let text = include_str!("../../tests/inrim-pcb356a15/matrices.csv");
    let mut cases: Vec<Case> = Vec::new();
    let rows = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect::<Vec<_>>());
    for (index, fields) in rows.filter(|f| f[0] == case).enumerate() {
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        if index % 9 == 0 {
            cases.push(Case {
                frequency: number(1),
                a: [0.0; 9],
                u_a: [0.0; 9],
                s: [0.0; 9],
                u_s: [0.0; 9],
            });
        }
        let (c, k) = (cases.last_mut().unwrap(), index % 9);
        (c.a[k], c.u_a[k], c.s[k], c.u_s[k]) = (number(3), number(4), number(5), number(6));
    }
    cases
}

/// Noise-free magnitudes o = |a| S on the published plan.
fn regenerated(case: &Case) -> Vec<MagnitudeRow> {
    let reference = if case.frequency == 5.0 { 3.0 } else { 10.0 };
    published_plan()
        .into_iter()
        .map(|configuration| {
            let d = configuration.direction().map(f64::abs);
            MagnitudeRow {
                reference,
                configuration,
                outputs: std::array::from_fn(|j| {
                    (0..3)
                        .map(|i| reference * d[i] * 1e-3 * case.s[3 * i + j])
                        .sum()
                }),
                spurious: None,
            }
        })
        .collect()
}

/// Largest difference of the printed A from the inverse of the printed S, over A_xx.
fn contradiction(case: &Case) -> f64 {
    let matrix = |values: &[f64; 9], unit: f64| {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| Complex64::new(unit * values[3 * i + j], 0.0))
        })
    };
    crate::derived::inconsistency(&matrix(&case.s, 1e-3), &matrix(&case.a, 1.0)).unwrap()
}

#[test]
fn published_uncertainties_of_two_cases() {
    let cases: Vec<Case> = ["uncorrected", "corrected-first"]
        .iter()
        .flat_map(|case| cases(case))
        .collect();
    assert_eq!(cases.len(), 18);
    for case in &cases {
        // The tables print U(A) of about 2 to 0.01 (0.25 % of rounding) and A itself from S of four digits; 1.5 % covers both. U(A) goes with
        // A and with 1/S, so what these contradict each other by counts twice, which matters from 630 Hz on. U(S) is printed to
        // 0.01 mV/(m/s²): half a digit and the same.
        let apart = contradiction(case);
        let within = 0.015 + if apart < 0.006 { 0.0 } else { 2.0 * apart };
        let fit = fit(&regenerated(case), &MagnitudeBudget::published(0.041)).unwrap();
        // Relative: magnitudes move the terms themselves where cross terms are not small.
        for k in 0..3 {
            let (a, s) = (fit.exploitation[k][k], 1e3 * fit.sensitivity[k][k]);
            let u_a = fit.exploitation_expanded[k][k].unwrap() / a;
            let expected = case.u_a[4 * k] / case.a[4 * k];
            assert!(
                (u_a / expected - 1.0).abs() < within,
                "{} Hz, A_{k}{k}: U = {u_a:.5}, published {expected:.5}",
                case.frequency
            );
            let u_s = 1e3 * fit.sensitivity_expanded[k][k].unwrap() / s;
            let expected = case.u_s[4 * k] / case.s[4 * k];
            assert!(
                (u_s - expected).abs() <= 0.005 / case.s[4 * k] + within * expected,
                "{} Hz, S_{k}{k}: U = {u_s:.5}, published {expected:.5}",
                case.frequency
            );
        }
    }
}

#[test]
fn published_contributions_do_not_give_the_published_tables() {
    // √(0.1² + 0.3² + (0.15² + 0.1² + 0.1² + 0.15²)/3) = 0.349 %; the tables need 4.1 %.
    let printed: f64 = [0.1f64, 0.3].iter().map(|u| u * u).sum::<f64>()
        + [0.15f64, 0.1, 0.1, 0.15]
            .iter()
            .map(|u| u * u / 3.0)
            .sum::<f64>();
    let u_s = printed.sqrt() / 100.0;
    assert!((u_s - 0.0034).abs() < 2e-4);
    let case = &cases("uncorrected")[0];
    let fit = fit(&regenerated(case), &MagnitudeBudget::published(0.0041)).unwrap();
    let u = fit.exploitation_expanded[0][0].unwrap();
    assert!(
        (0.30..0.42).contains(&u),
        "U(A_xx) = {u}, published {}",
        case.u_a[0]
    );
}

/// The worked entry of the published spreadsheet.
fn spreadsheet(modulus_y: f64, modulus_z: f64) -> Applied {
    let spurious = SpuriousMagnitude {
        modulus: [0.014, modulus_y, modulus_z],
        modulus_uncertainty: [0.0001, 0.0003, 0.0046],
        phase: [-124.1f64, -68.3, -69.3].map(f64::to_radians),
        phase_uncertainty: [44.0f64, 151.5, 173.6].map(f64::to_radians),
    };
    let configuration = Configuration::degrees(90.0, 315.0);
    let budget = MagnitudeBudget::published(0.041);
    applied(2.99573, &configuration, Some(&spurious), &budget)[0].clone()
}

#[test]
fn published_spreadsheet_entry() {
    // Printed: y′ 0.9 %, z′ 0.6 % (from 99.4 %). Digits behind the rounding follow from the printed products
    // c_φ² u²: 4.3e-8·100 = u_φy⁴ gives 0.88 %, and the printed sum 3.6624e-3 then gives 0.55 %.
    let a = spreadsheet(0.00883, 0.00554);
    assert!((a.value - 2.130).abs() < 5e-4, "{}", a.value);
    assert!(
        (a.standard_uncertainty.powi(2) - 3.66e-3).abs() < 2e-5,
        "{a:?}"
    );
    assert!((a.standard_uncertainty - 0.061).abs() < 5e-4);
    // Within the rounding of the inputs as printed, the value stands and u is 0.062 ± 0.002.
    let rounded = spreadsheet(0.009, 0.006);
    assert!((rounded.value - 2.130).abs() < 5e-4);
    assert!((rounded.standard_uncertainty - 0.061).abs() < 0.002);

    // The printed ν = 295 is what Welch–Satterthwaite gives when the last row (φ_z′) is left out of Σ u⁴/ν.
    let u2 = a.standard_uncertainty.powi(2);
    let without: f64 = a.budget[..8]
        .iter()
        .map(|l| l.contribution.powi(4) / 100.0)
        .sum();
    assert!(
        (u2 * u2 / without - 295.0).abs() < 3.0,
        "{}",
        u2 * u2 / without
    );
    assert!((a.dof - 235.0).abs() < 5.0, "{}", a.dof);
}

#[test]
fn law_the_signs_that_are_lost_bias_the_matrices() {
    // Cross terms of ±1 %: signed data would return the truth, magnitudes do not.
    let s: [[f64; 3]; 3] = [[10.0, 0.1, -0.1], [-0.1, 10.0, 0.1], [0.1, -0.1, 10.0]];
    let rows: Vec<MagnitudeRow> = published_plan()
        .into_iter()
        .map(|configuration| {
            let d = configuration.direction();
            MagnitudeRow {
                reference: 10.0,
                configuration,
                outputs: std::array::from_fn(|j| (0..3).map(|i| 0.01 * d[i] * s[i][j]).sum()),
                spurious: None,
            }
        })
        .collect();
    let fit = fit(&rows, &MagnitudeBudget::published(0.0041)).unwrap();
    let worst = (0..3)
        .map(|k| 1.0 - 1e3 * fit.sensitivity[k][k] / 10.0)
        .fold(0.0, f64::max);
    assert!(
        (0.002..0.01).contains(&worst),
        "main sensitivities low by {worst}"
    );
}

#[test]
fn refuses_configurations_that_do_not_span() {
    let row = MagnitudeRow {
        reference: 10.0,
        configuration: Configuration::degrees(0.0, 0.0),
        outputs: [0.0, 0.0, 0.1],
        spurious: None,
    };
    let budget = MagnitudeBudget::published(0.04);
    assert!(matches!(fit(&[row; 2], &budget), Err(Error::TooFew { .. })));
    assert!(matches!(
        fit(&[row; 9], &budget),
        Err(Error::Unobservable { .. })
    ));
}
