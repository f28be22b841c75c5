use super::*;
use crate::DegreesOfFreedom;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

const Y_MEAN: [f64; 4] = [10.1, 9.8, 10.4, 10.3];
const X_LINE: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
const Y_LINE: [f64; 6] = [-1.9, -1.2, 0.3, 0.9, 1.7, 3.4];
const V_LINE: [f64; 6] = [0.04, 0.1, 0.02, 0.2, 0.04, 0.1];

fn mean(y: &[f64], variances: &[f64]) -> (f64, BetweenScatter) {
    let ones = vec![1.0; y.len()];
    let (x, s) = BetweenScatter::linear(&ones, y, variances, NoiseDof::Known, 0.95).unwrap();
    (x[0], s)
}

fn line(dof: NoiseDof) -> (Vec<f64>, BetweenScatter) {
    let jacobian: Vec<f64> = X_LINE.iter().flat_map(|x| [1.0, *x]).collect();
    BetweenScatter::linear(&jacobian, &Y_LINE, &V_LINE, dof, 0.95).unwrap()
}

/// Six significant digits, as the reference values (an independent calculation in another language) are given.
fn near(got: f64, expected: f64, what: &str) {
    assert!(
        (got - expected).abs() <= 1e-5 * expected.abs(),
        "{what}: {got} instead of {expected}"
    );
}

#[test]
fn known_mean_with_excess() {
    let (x, s) = mean(&Y_MEAN, &[0.04; 4]);
    near(x, 10.15, "mean");
    near(s.chi_squared, 5.25, "Q(0)");
    near(s.birge_ratio, 1.32288, "R");
    near(s.excess_variance, 0.03, "τ²");
    near(s.information, 612.245, "T");
    assert_eq!(s.residual_factor, 1.0);
    near(s.scatter_dof, 3.0, "ν_s");
    near(s.coverage_factor, 3.18245, "k");
    near(s.dof.get(), 3.0, "ν*");
    near(s.standard_uncertainty(0), 0.132288, "u");
    near(s.noise[0].sqrt(), 0.1, "noise");
    near(s.between[0].sqrt(), 0.0866025, "between");
    near(s.expanded(0), 0.420998, "U");
    assert_eq!(s.excess_interval[0], 0.0);
    near(s.excess_interval[1], 0.965994, "τ, upper end");
}

#[test]
fn known_mean_with_unequal_variances() {
    let (x, s) = mean(&Y_MEAN, &[0.01, 0.04, 0.09, 0.04]);
    near(x, 10.1138, "mean");
    near(s.chi_squared, 4.24569, "Q(0)");
    near(s.birge_ratio, 1.18963, "R");
    near(s.excess_variance, 0.0193249, "τ²");
    near(s.information, 1071.53, "T");
    near(s.component_dof[0], 1.92700, "m");
    near(s.scatter_dof, 2.0, "ν_s");
    near(s.coverage_factor, 4.30265, "k");
    near(s.standard_uncertainty(0), 0.113990, "u");
    near(s.noise[0].sqrt(), 0.0840980, "noise");
    near(s.between[0].sqrt(), 0.0769494, "between");
    near(s.expanded(0), 0.490459, "U");
}

#[test]
fn known_mean_without_excess() {
    let (x, s) = mean(&[10.1, 9.8, 10.25, 10.1], &[0.04; 4]);
    near(x, 10.0625, "mean");
    near(s.chi_squared, 2.67187, "Q(0)");
    near(s.birge_ratio, 0.943729, "R");
    assert_eq!(s.excess_variance, 0.0);
    near(s.residual_factor, 0.890625, "q");
    near(s.information, 1875.0, "T");
    near(s.coverage_factor, 3.00337, "k");
    near(s.dof.get(), 3.34774, "ν*");
    near(s.expanded(0), 0.300337, "U");
    near(s.excess_interval[1], 0.674730, "τ, upper end");

    let (x, s) = mean(&[10.1, 10.0, 10.15, 10.05], &[0.04; 4]);
    near(x, 10.075, "mean");
    near(s.chi_squared, 0.3125, "Q(0)");
    near(s.birge_ratio, 0.322749, "R");
    near(s.residual_factor, 0.104167, "q");
    near(s.coverage_factor, 1.95996, "k");
    assert!(s.dof.is_infinite());
    near(s.expanded(0), 0.195996, "U");
    assert!(s.finding().is_none());
}

#[test]
fn known_straight_line() {
    let (x, s) = line(NoiseDof::Known);
    near(s.chi_squared, 7.73387, "Q(0)");
    near(s.birge_ratio, 1.39049, "R");
    near(s.excess_variance, 0.0400429, "τ²");
    near(s.information, 416.292, "T");
    near(s.component_dof[0], 2.84495, "m");
    near(s.component_dof[1], 3.83603, "m");
    near(s.scatter_dof, 3.26698, "ν_s");
    near(s.coverage_factor, 3.04026, "k");
    near(s.dof.get(), 3.26698, "ν*");
    for (c, expected) in [
        [0.0610983, 0.131137, 0.0941652, 0.0912682, 0.398691],
        [0.991218, 0.0767291, 0.0585790, 0.0495566, 0.233276],
    ]
    .iter()
    .enumerate()
    {
        let diagonal = c * 3;
        let got = [
            x[c],
            s.standard_uncertainty(c),
            s.noise[diagonal].sqrt(),
            s.between[diagonal].sqrt(),
            s.expanded(c),
        ];
        for (got, expected) in got.iter().zip(expected) {
            near(*got, *expected, "line");
        }
    }
    near(s.excess_interval[1], 0.853749, "τ, upper end");

    let twenty = DegreesOfFreedom::new(20.0).unwrap();
    let (_, s) = line(NoiseDof::Each(vec![twenty; 6]));
    near(s.component_dof[0], 2.83768, "m");
    near(s.component_dof[1], 3.79700, "m");
    near(s.scatter_dof, 3.24798, "ν_s");
    near(s.coverage_factor, 3.04931, "k");
    near(s.expanded(0), 0.399878, "U");
    near(s.expanded(1), 0.233970, "U");
}

#[test]
fn known_combination_with_common_errors() {
    let common = CommonErrors::new().with(0.05, DegreesOfFreedom::INFINITE);
    let own = DegreesOfFreedom::new(3.0).unwrap();
    let few = common.with_scatter(0.1, own, 3.0, 0.95);
    near(few.expanded_uncertainty, 0.332991, "U, quadrature");
    near(few.standard_uncertainty, 0.111803, "u");
    // The same contributions with residuals enough for Welch–Satterthwaite.
    let many = common.with_scatter(0.1, own, 4.0, 0.95);
    near(many.dof.get(), 4.6875, "ν_eff");
    near(many.coverage_factor, 2.62299, "k");
    near(
        many.expanded_uncertainty,
        0.293259,
        "U, Welch–Satterthwaite",
    );
}

/// Noise and between part add to S; S is the inverse of JᵀWJ; a shift common to all moves the mean by itself.
#[test]
fn law_parts_add_and_gain_is_unbiased() {
    let (_, s) = line(NoiseDof::Known);
    let w: Vec<f64> = V_LINE
        .iter()
        .map(|v| 1.0 / (v + s.excess_variance))
        .collect();
    let sum = |power: i32| {
        w.iter()
            .zip(X_LINE)
            .map(|(w, x)| w * x.powi(power))
            .sum::<f64>()
    };
    let (a, b, c) = (sum(0), sum(1), sum(2));
    let det = a * c - b * b;
    for (got, expected) in s
        .covariance
        .iter()
        .zip([c / det, -b / det, -b / det, a / det])
    {
        assert!((got - expected).abs() < 1e-12);
    }
    let moved = s.sensitivity(&[-1.0; 6]).unwrap();
    assert!((moved[0] - 1.0).abs() < 1e-12 && moved[1].abs() < 1e-12);
    // Equal weights: the joint limit is p F(p, ν).
    let (_, s) = mean(&Y_MEAN, &[0.04; 4]);
    assert!((s.joint_limit() - s.coverage_factor.powi(2)).abs() < 1e-6);
}

#[test]
fn refuses_what_determines_nothing() {
    let known = || NoiseDof::Known;
    assert!(BetweenScatter::linear(&[1.0], &[1.0], &[1.0], known(), 0.95).is_err());
    assert!(BetweenScatter::linear(&[], &[], &[], known(), 0.95).is_err());
    assert!(BetweenScatter::linear(&[1.0; 3], &[1.0; 3], &[0.0; 3], known(), 0.95).is_err());
    assert!(BetweenScatter::linear(&[1.0; 3], &[1.0; 3], &[1.0; 3], known(), 1.0).is_err());
    assert!(BetweenScatter::linear(&[1.0; 8], &[1.0; 4], &[1.0; 4], known(), 0.95).is_err());
    assert!(
        BetweenScatter::linear(&[1.0; 3], &[1.0, f64::NAN, 1.0], &[1.0; 3], known(), 0.95).is_err()
    );
    assert!(Repeats::pool(&[&[1.0], &[2.0]]).is_err());
}

/// Coverage through the whole rule at the three most telling τ/σ; four standard deviations of the binomial count.
#[test]
fn coverage_of_a_line_with_few_points() {
    let trials = 2000;
    for (n, variances) in [(5usize, [0.04, 0.04]), (12, [0.04, 0.008])] {
        let jacobian: Vec<f64> = (0..n)
            .flat_map(|i| [1.0, i as f64 / n as f64 - 0.5])
            .collect();
        let v: Vec<f64> = (0..n).map(|i| variances[i % 2]).collect();
        for excess in [0.0, 0.1, 0.2, 0.6f64] {
            let mut rng =
                Xoshiro256PlusPlus::seed_from_u64(n as u64 * 1000 + (excess * 100.0) as u64);
            let mut hits = [0usize; 2];
            for _ in 0..trials {
                let y: Vec<f64> = v
                    .iter()
                    .map(|v| (v + excess * excess).sqrt() * rng.sample::<f64, _>(StandardNormal))
                    .collect();
                let (x, s) =
                    BetweenScatter::linear(&jacobian, &y, &v, NoiseDof::Known, 0.95).unwrap();
                for c in 0..2 {
                    hits[c] += usize::from(x[c].abs() <= s.expanded(c));
                }
            }
            let floor = 0.945 * trials as f64 - 4.0 * (trials as f64 * 0.95 * 0.05).sqrt();
            for c in 0..2 {
                assert!(
                    hits[c] as f64 >= floor,
                    "n {n} τ {excess} parameter {c}: {} of {trials}",
                    hits[c]
                );
            }
        }
    }
}

/// U of a mean of two or three readings with declared noise, over the unknown scatter between them.
#[test]
fn coverage_of_two_or_three_repeats() {
    let trials = 20_000;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for n in [2usize, 3] {
        for excess in [0.0, 1.0, 4.0f64] {
            let sd = 1f64.hypot(excess);
            let hits = (0..trials)
                .filter(|_| {
                    let y: Vec<f64> = (0..n)
                        .map(|_| sd * rng.sample::<f64, _>(StandardNormal))
                        .collect();
                    let mean = y.iter().sum::<f64>() / n as f64;
                    let u = Repeats::pool(&[&y]).unwrap().mean_of(
                        n,
                        Some((1.0, DegreesOfFreedom::INFINITE)),
                        0.95,
                    );
                    mean.abs() <= u.expanded_uncertainty
                })
                .count();
            let share = hits as f64 / trials as f64;
            assert!(
                share > 0.95 - 4.0 * (0.95 * 0.05 / trials as f64).sqrt(),
                "{n} {excess}: {share}"
            );
        }
    }
}
