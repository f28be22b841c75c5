//! Quantiles behind coverage factors and regions: normal, Student t, χ² and F, for any real degrees of freedom.

use crate::student;
use statrs::function::beta::beta_reg;
use statrs::function::gamma::{gamma_lr, gamma_ur, ln_gamma};

/// z with Φ(z) = `p`; −∞ at 0 and ∞ at 1.
///
/// ```
/// assert!((proofmass_uncertainty::normal_quantile(0.975) - 1.959_963_985).abs() < 1e-9);
/// ```
pub fn normal_quantile(p: f64) -> f64 {
    if p <= 0.0 {
        f64::NEG_INFINITY
    } else if p >= 1.0 {
        f64::INFINITY
    } else {
        student::standard_normal_quantile(p)
    }
}

/// t with P(T ≤ t) = `p` for Student's t with any ν > 0, also infinite.
///
/// ```
/// assert!((proofmass_uncertainty::student_quantile(0.975, 4.0) - 2.776_445).abs() < 1e-6);
/// ```
pub fn student_quantile(p: f64, nu: f64) -> f64 {
    student::quantile(p, nu)
}

/// x with P(χ²_ν ≤ x) = `p`.
///
/// **Accuracy** 1e-10 relative for ν from 0.1 to 1e6 (bracketed root of the regularised incomplete gamma function in
/// ln x; above 1e6 the cube-root approximation, whose error falls below 1e-9). **Source** `[AS] 26.4`.
///
/// ```
/// assert!((proofmass_uncertainty::chi_squared_quantile(0.95, 3.0) - 7.814_727_903).abs() < 1e-8);
/// ```
pub fn chi_squared_quantile(p: f64, nu: f64) -> f64 {
    if !(p > 0.0) {
        return 0.0;
    }
    if !(p < 1.0) {
        return f64::INFINITY;
    }
    let z = student::standard_normal_quantile(p);
    let h = 2.0 / (9.0 * nu);
    let guess = nu * (1.0 - h + z * h.sqrt()).max(1e-3).powi(3);
    if nu > 1e6 {
        return guess;
    }
    let a = 0.5 * nu;
    let norm = ln_gamma(a);
    root_in_ln(guess, |x| {
        let y = 0.5 * x;
        (gamma_lr(a, y) - p, (a * y.ln() - y - norm).exp())
    })
}

/// P(χ²_ν > x): the chance of a χ² as large or larger.
///
/// **Source** `[AS] 26.4`.
///
/// ```
/// assert!((proofmass_uncertainty::chi_squared_chance(7.814_727_903, 3.0) - 0.05).abs() < 1e-9);
/// ```
pub fn chi_squared_chance(x: f64, nu: f64) -> f64 {
    if x == f64::INFINITY {
        return 0.0;
    }
    match x > 0.0 && nu > 0.0 {
        true => gamma_ur(0.5 * nu, 0.5 * x),
        false => 1.0,
    }
}

/// x with P(F ≤ x) = `p` for the ratio of mean squares with ν₁ and ν₂ degrees of freedom; ν₂ may be infinite.
///
/// **Accuracy** 1e-8 relative for `p` from 0.001 to 1 − 1e-6. **Source** `[AS] 26.6`.
///
/// ```
/// assert!((proofmass_uncertainty::f_quantile(0.95, 2.0, 3.0) - 9.552_094_496).abs() < 1e-7);
/// ```
pub fn f_quantile(p: f64, nu_1: f64, nu_2: f64) -> f64 {
    if nu_2 > 1e8 {
        return chi_squared_quantile(p, nu_1) / nu_1;
    }
    if !(p > 0.0) {
        return 0.0;
    }
    if !(p < 1.0) {
        return f64::INFINITY;
    }
    let (a, b) = (0.5 * nu_1, 0.5 * nu_2);
    let norm = ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    root_in_ln(1.0, |x| {
        let (above, below) = (nu_2 / (nu_1 * x + nu_2), nu_1 * x / (nu_1 * x + nu_2));
        // The share of the larger mean square keeps its digits in both tails.
        let value = if below < 0.5 {
            beta_reg(a, b, below) - p
        } else {
            (1.0 - p) - beta_reg(b, a, above)
        };
        (value, (a * below.ln() + b * above.ln() - norm).exp())
    })
}

/// Degrees of freedom ν at which Student's t has this two-sided coverage factor: the inverse of
/// [`DegreesOfFreedom::coverage_factor`](crate::DegreesOfFreedom::coverage_factor). ∞ for a factor at or below the
/// normal's, 0.05 for one beyond any use.
///
/// ```
/// let nu = proofmass_uncertainty::dof_of_coverage_factor(3.00337, 0.95);
/// assert!((nu - 3.34774).abs() < 1e-4);
/// ```
pub fn dof_of_coverage_factor(k: f64, probability: f64) -> f64 {
    let t = |nu: f64| student::two_sided_quantile(probability, nu);
    if !(k > t(f64::INFINITY) * (1.0 + 1e-14)) {
        return f64::INFINITY;
    }
    let f = |inverse: f64| (t(inverse.recip()) / k).ln();
    if let Some(nu) = from_the_expansion(k, t(f64::INFINITY), f) {
        return nu;
    }
    // False position in 1/ν, in which ln t is nearly straight; the end that stays is halved (Illinois).
    let (mut low, mut high) = (0.0, 20.0);
    let (mut f_low, mut f_high) = (f(low), f(high));
    if f_high <= 0.0 {
        return 0.05;
    }
    let mut side = 0;
    for _ in 0..200 {
        let x = (low * f_high - high * f_low) / (f_high - f_low);
        let y = f(x);
        if y.abs() < 1e-13 || high - low < 1e-15 * high {
            return x.recip();
        }
        if y < 0.0 {
            (low, f_low) = (x, y);
            if side < 0 {
                f_high *= 0.5;
            }
            side = -1;
        } else {
            (high, f_high) = (x, y);
            if side > 0 {
                f_low *= 0.5;
            }
            side = 1;
        }
    }
    (0.5 * (low + high)).recip()
}

/// 1/ν from the first two terms of the expansion of t in 1/ν about the normal's z, then by secants; `None` where ν is so
/// small that they lead astray. **Source** `[AS] 26.7.5`.
fn from_the_expansion(k: f64, z: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let linear = z * (z * z + 1.0) / 4.0;
    let square = z * ((5.0 * z * z + 16.0) * z * z + 3.0) / 96.0;
    let mut x = 2.0 * (k - z) / (linear + (linear * linear + 4.0 * square * (k - z)).sqrt());
    let mut y = f(x);
    let mut slope = (linear + 2.0 * square * x) / k;
    for _ in 0..12 {
        if y.abs() < 1e-13 {
            return Some(x.recip());
        }
        let next = x - y / slope;
        if !(next > 0.0 && next < 1.0) || next == x {
            return None;
        }
        let (before, there) = (y, f(next));
        slope = (there - before) / (next - x);
        (x, y) = (next, there);
    }
    None
}

/// Root of a function that rises with x > 0, given with its derivative by ln x: Newton's steps in ln x, held within
/// the bracket that the signs leave.
fn root_in_ln(start: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut low, mut high) = (-740.0, 700.0);
    let mut x = start.ln();
    for _ in 0..200 {
        let (value, slope) = f(x.exp());
        if value == 0.0 {
            break;
        }
        if value < 0.0 {
            low = x;
        } else {
            high = x;
        }
        // A step of Newton's from far out may be any length.
        let newton = x - (value / slope).clamp(-2.0, 2.0);
        if (newton - x).abs() < 1e-14 * (1.0 + x.abs()) {
            x = newton;
            break;
        }
        x = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
    }
    x.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ²₂ is exponential, χ²₁ the square of a normal, F(1, ν) the square of t.
    #[test]
    fn law_closed_forms() {
        for p in [1e-6, 0.01, 0.025, 0.5, 0.95, 0.975, 0.999_999] {
            let two = -2.0 * f64::ln_1p(-p);
            assert!(
                (chi_squared_quantile(p, 2.0) / two - 1.0).abs() < 1e-9,
                "{p}"
            );
            let one = normal_quantile(0.5 * (1.0 + p)).powi(2);
            assert!(
                (chi_squared_quantile(p, 1.0) / one - 1.0).abs() < 1e-8,
                "{p}"
            );
            for nu in [1.0, 3.5, 40.0].into_iter().filter(|_| p > 1e-3) {
                let t = student::two_sided_quantile(p, nu).powi(2);
                let tolerance = 1e-8;
                assert!(
                    (f_quantile(p, 1.0, nu) / t - 1.0).abs() < tolerance,
                    "{p} {nu}"
                );
            }
            let far = f_quantile(p, 3.0, 1e7) * 3.0;
            assert!(
                (far / chi_squared_quantile(p, 3.0) - 1.0).abs() < 1e-5,
                "{p}"
            );
        }
        assert!((chi_squared_quantile(0.025, 7.0) - 1.689_869_18).abs() < 1e-7);
        assert!((chi_squared_quantile(0.975, 31.0) - 48.231_889_7).abs() < 1e-6);
        for nu in [1.0, 2.5, 30.0, 1e4] {
            let k = student::two_sided_quantile(0.95, nu);
            assert!(
                (dof_of_coverage_factor(k, 0.95) / nu - 1.0).abs() < 1e-6,
                "{nu}"
            );
        }
        assert!(dof_of_coverage_factor(1.9, 0.95).is_infinite());
    }
}
