//! The quantile of Student's t for any real ν, the number behind every coverage factor.

use statrs::distribution::{ContinuousCDF, Normal};
use statrs::function::beta::beta_reg;

/// t > 0 with P(|T| ≤ t) = `probability`; 0 at probability 0 and ∞ at 1.
///
/// Below ν = 1000 the tail ½ I_{ν/(ν+t²)}(ν/2, ½) is inverted by bracketed Newton steps in ln t; above, the
/// expansion of `[AS] 26.7.5` in 1/ν leaves less than 1e-13. (The general inverse of the incomplete beta
/// function needs unbounded time as ν grows.)
pub(crate) fn two_sided_quantile(probability: f64, nu: f64) -> f64 {
    if !(probability < 1.0) {
        return f64::INFINITY;
    }
    if probability <= 0.0 {
        return 0.0;
    }
    let z = standard_normal_quantile(0.5 * (1.0 + probability));
    if nu >= 1000.0 {
        return z
            + (1..=4)
                .map(|order| expansion(z, order) * nu.recip().powi(order))
                .sum::<f64>();
    }
    let outside = 1.0 - probability;
    let tail = |t: f64| beta_reg(0.5 * nu, 0.5, nu / (nu + t * t));
    // t lies between the normal quantile (ν → ∞) and a power law that grows without bound as ν → 0; the expansion is near it
    // unless ν is small.
    let near = (z
        + (1..=2)
            .map(|o| expansion(z, o) * nu.recip().powi(o))
            .sum::<f64>())
    .ln();
    let (mut low, mut high) = (z.ln(), near + 0.1);
    while tail(high.exp()) > outside && high < 700.0 {
        (low, high) = (high, high + 1.0 + 0.5 * (high - low));
    }
    let log_norm = ln_pdf_factor(nu);
    let mut x = if near > low { near } else { 0.5 * (low + high) };
    for _ in 0..200 {
        let t = x.exp();
        let q = tail(t);
        if q > outside {
            low = x;
        } else {
            high = x;
        }
        // d ln q / d ln t = −2 t f(t) / q
        let slope = -2.0 * t * (log_norm - 0.5 * (nu + 1.0) * (t * t / nu).ln_1p()).exp() / q;
        let newton = x - (q / outside).ln() / slope;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        // The error after a step of Newton's is of the order of its square.
        if inside && (next - x).abs() < 1e-9 || high - low < 1e-15 {
            return next.exp();
        }
        x = next;
    }
    x.exp()
}

/// P(|T| ≤ k).
pub(crate) fn two_sided_probability(k: f64, nu: f64) -> f64 {
    if nu > 1e6 {
        statrs::function::erf::erf(k / std::f64::consts::SQRT_2)
    } else {
        1.0 - beta_reg(0.5 * nu, 0.5, nu / (nu + k * k))
    }
}

/// x with P(T ≤ x) = p for Student's t.
pub(crate) fn quantile(p: f64, nu: f64) -> f64 {
    if p >= 0.5 {
        two_sided_quantile(2.0 * p - 1.0, nu)
    } else {
        -two_sided_quantile(1.0 - 2.0 * p, nu)
    }
}

/// z with Φ(z) = p.
pub(crate) fn standard_normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// ln of the density of t at its centre.
pub(crate) fn ln_pdf_factor(nu: f64) -> f64 {
    use statrs::function::gamma::ln_gamma;
    ln_gamma(0.5 * (nu + 1.0)) - ln_gamma(0.5 * nu) - 0.5 * (nu * std::f64::consts::PI).ln()
}

fn expansion(z: f64, order: i32) -> f64 {
    let z2 = z * z;
    let polynomial = |c: &[f64]| z * c.iter().fold(0.0, |sum, c| sum * z2 + c);
    match order {
        1 => polynomial(&[1.0, 1.0]) / 4.0,
        2 => polynomial(&[5.0, 16.0, 3.0]) / 96.0,
        3 => polynomial(&[3.0, 19.0, 17.0, -15.0]) / 384.0,
        _ => polynomial(&[79.0, 776.0, 1482.0, -1920.0, -945.0]) / 92160.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `[GUM]` table G.2, two decimals.
    #[test]
    fn published_coverage_factors() {
        for (nu, p, k) in [
            (1.0, 0.6827, 1.84),
            (1.0, 0.95, 12.71),
            (1.0, 0.9973, 235.80),
            (2.0, 0.95, 4.30),
            (4.0, 0.9545, 2.87),
            (10.0, 0.99, 3.17),
            (16.0, 0.99, 2.92),
            (50.0, 0.95, 2.01),
            (100.0, 0.99, 2.626),
            (f64::INFINITY, 0.95, 1.960),
            (f64::INFINITY, 0.9973, 3.000),
        ] {
            let digits = if nu >= 100.0 { 0.0006 } else { 0.0051 };
            let t = two_sided_quantile(p, nu);
            // The GUM's own 68.27, 95.45 and 99.73 % carry four digits; at ν = 1 the last matters.
            let tolerance = if p == 0.9973 && nu == 1.0 {
                0.05
            } else {
                digits
            };
            assert!((t - k).abs() < tolerance, "ν {nu} p {p}: {t} {k}");
        }
    }

    /// ν = 1 is Cauchy, ν = 2 algebraic: t = tan(πp/2), t = p√(2/(1−p²)).
    #[test]
    fn law_closed_forms_and_continuity() {
        for p in [1e-3, 0.1, 0.5, 0.9, 0.99, 0.999, 0.999_999] {
            let cauchy = (std::f64::consts::FRAC_PI_2 * p).tan();
            assert!(
                (two_sided_quantile(p, 1.0) / cauchy - 1.0).abs() < 1e-9,
                "{p}"
            );
            let two = p * (2.0 / (1.0 - p * p)).sqrt();
            assert!((two_sided_quantile(p, 2.0) / two - 1.0).abs() < 1e-9, "{p}");
            let (below, above) = (
                two_sided_quantile(p, 999.999_999),
                two_sided_quantile(p, 1000.0),
            );
            assert!(
                (below - above).abs() < 1e-9 * (1.0 + above),
                "{p} {below} {above}"
            );
        }
        assert!(two_sided_quantile(0.95, 0.05).is_finite());
        assert_eq!(two_sided_quantile(1.0, 3.0), f64::INFINITY);
    }
}
