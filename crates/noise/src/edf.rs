//! Equivalent degrees of freedom of the variances, and the χ² interval they give.

use crate::{NoiseType, Statistic};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Which formulas are used for the total family, where programs differ.
///
/// ADEV, OADEV, MDEV, TDEV, HDEV and OHDEV follow Greenhall and Riley in either case; TOTDEV follows
/// `[SP1065] table 7`, THEO1 `[SP1065] eq. 32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EdfFormula {
    /// `[SP1065]` tables 8 and 9 for MTOTDEV and HTOTDEV; for averaging factors below 8 (16 for HTOTDEV), where
    /// those fits do not hold, Greenhall–Riley for the parent variance.
    #[default]
    Published,
    /// As the program Stable32 1.6 prints: MTOTDEV with b = 1.333, c = 1.90 (white) and b = 1.734, c = 2.99
    /// (flicker phase), read back from its tables; HTOTDEV at m < 16 and for α > 0 from the simple formulas of
    /// `[SP1065] table 5`.
    Stable32,
}

/// Equivalent degrees of freedom of `statistic` at factor m for `phase_points` phase samples.
///
/// `None` where no formula is published (too few terms, or a noise for which the variance does not converge).
pub fn equivalent_dof(
    statistic: Statistic,
    noise: NoiseType,
    m: usize,
    phase_points: usize,
    formula: EdfFormula,
) -> Option<f64> {
    let alpha = noise.alpha();
    let n = phase_points;
    let ratio = (n as f64 - 1.0) / m as f64;
    let edf = match statistic {
        Statistic::Allan => greenhall_riley(alpha, 2, m, n, Stride::Tau, Filter::Plain),
        // Of THEOH what lies beyond a fifth of the record has those of THEO1.
        Statistic::OverlappingAllan | Statistic::TheoHybrid => {
            greenhall_riley(alpha, 2, m, n, Stride::Sample, Filter::Plain)
        }
        Statistic::ModifiedAllan | Statistic::Time => {
            greenhall_riley(alpha, 2, m, n, Stride::Sample, Filter::Modified)
        }
        Statistic::Hadamard => greenhall_riley(alpha, 3, m, n, Stride::Tau, Filter::Plain),
        Statistic::OverlappingHadamard => {
            greenhall_riley(alpha, 3, m, n, Stride::Sample, Filter::Plain)
        }
        Statistic::Total => match alpha {
            0 => Some(1.5 * ratio),
            -1 => Some(1.168 * ratio - 0.222),
            -2 => Some(0.927 * ratio - 0.358),
            // The extension adds nothing for phase noise.
            _ => greenhall_riley(alpha, 2, m, n, Stride::Sample, Filter::Plain),
        },
        Statistic::ModifiedTotal | Statistic::TimeTotal => modified_total(alpha, m, n, formula),
        Statistic::HadamardTotal => hadamard_total(alpha, m, n, formula),
        Statistic::Theo1 => theo1(alpha, m, n),
        // Nothing simple is published.
        Statistic::Parabolic => None,
    };
    edf.filter(|edf| edf.is_finite() && *edf > 0.0)
}

fn modified_total(alpha: i32, m: usize, n: usize, formula: EdfFormula) -> Option<f64> {
    let ratio = (n as f64 - 1.0) / m as f64;
    if m <= 8 {
        return greenhall_riley(alpha, 2, m, n, Stride::Sample, Filter::Modified);
    }
    let (b, c) = match (alpha, formula) {
        (0, EdfFormula::Stable32) => (1.333, 1.90),
        (1, EdfFormula::Stable32) => (1.734, 2.994),
        (2, _) => (1.90, 2.1),
        (1, _) => (1.20, 1.40),
        (0, _) => (1.10, 1.2),
        (-1, _) => (0.85, 0.50),
        (-2, _) => (0.75, 0.31),
        _ => return None,
    };
    Some(b * ratio - c)
}

fn hadamard_total(alpha: i32, m: usize, n: usize, formula: EdfFormula) -> Option<f64> {
    let fit = match alpha {
        0 => Some((0.559, 1.004)),
        -1 => Some((0.868, 1.140)),
        -2 => Some((0.938, 1.696)),
        -3 => Some((0.974, 2.554)),
        -4 => Some((1.276, 3.149)),
        _ => None,
    };
    match (fit, formula) {
        (Some((b0, b1)), _) if m >= 16 => {
            let ratio = (n as f64 - 1.0) / m as f64;
            Some(ratio / (b0 + b1 / ratio))
        }
        (_, EdfFormula::Stable32) => simple(alpha, m, n - 1),
        (_, EdfFormula::Published) => {
            greenhall_riley(alpha, 3, m, n, Stride::Sample, Filter::Plain)
        }
    }
}

/// Simple formulas for the overlapping Allan variance. **Source** `[SP1065] table 5`.
fn simple(alpha: i32, m: usize, n: usize) -> Option<f64> {
    let (n, m) = (n as f64, m as f64);
    Some(match alpha {
        2 => (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m)),
        1 => (((n - 1.0) / (2.0 * m)).ln() * ((2.0 * m + 1.0) * (n - 1.0) / 4.0).ln())
            .sqrt()
            .exp(),
        0 => (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * (4.0 * m * m / (4.0 * m * m + 5.0)),
        -1 if m == 1.0 => 2.0 * (n - 2.0) / (2.3 * n - 4.9),
        -1 => 5.0 * n * n / (4.0 * m * (n + 3.0 * m)),
        -2 => {
            (n - 2.0) / m * ((n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m)
                / (n - 3.0).powi(2)
        }
        _ => return None,
    })
}

/// THEO1. **Source** `[SP1065] eq. 32` and table 10; N counts phase points, τ_s = 0.75 m.
fn theo1(alpha: i32, m: usize, points: usize) -> Option<f64> {
    let n = points as f64;
    let t = 0.75 * m as f64;
    Some(match alpha {
        2 => 0.86 * (n + 1.0) * (n - 4.0 / 3.0 * t) / (n - t) * (t / (t + 1.14)),
        1 => {
            (4.798 * n * n - 6.374 * n * t + 12.387 * t) / ((t + 36.6).sqrt() * (n - t))
                * (t / (t + 0.3))
        }
        0 => ((4.1 * n + 0.8) / t - (3.1 * n + 6.5) / n) * (t.powf(1.5) / (t.powf(1.5) + 5.2)),
        -1 => (2.0 * n * n - 1.3 * n * t - 3.5 * t) / (n * t) * (t.powi(3) / (t.powi(3) + 2.3)),
        -2 => {
            (4.4 * n - 2.0) / (2.9 * t)
                * ((4.4 * n - 1.0).powi(2) - 8.6 * t * (4.4 * n - 1.0) + 11.4 * t * t)
                / (4.4 * n - 3.0).powi(2)
        }
        _ => return None,
    })
}

/// Degrees of freedom of the Allan variance with `per_tau` starts in every τ.
pub(crate) fn partly_overlapping(
    noise: NoiseType,
    m: usize,
    phase_points: usize,
    per_tau: usize,
) -> Option<f64> {
    greenhall_riley(
        noise.alpha(),
        2,
        m,
        phase_points,
        Stride::Share(per_tau.min(m)),
        Filter::Plain,
    )
    .filter(|edf| edf.is_finite() && *edf > 0.0)
}

/// Distance between the starts of neighbouring terms.
#[derive(Clone, Copy, PartialEq)]
enum Stride {
    Sample,
    Tau,
    /// So many starts in every τ.
    Share(usize),
}

/// Whether phases are averaged over τ before differencing.
#[derive(Clone, Copy, PartialEq)]
enum Filter {
    Plain,
    Modified,
}

/// Sums longer than this are replaced by their asymptotic fits. **Source** `[GR2003] sec. 5`.
const LONGEST_SUM: f64 = 100.0;

/// Combined degrees of freedom of d-th difference variances (d = 2 Allan, 3 Hadamard).
///
/// **Source** `[GR2003]` sec. 5, the four cases in its order; `[SP1065] 5.4`.
fn greenhall_riley(
    alpha: i32,
    d: i32,
    m: usize,
    points: usize,
    stride: Stride,
    filter: Filter,
) -> Option<f64> {
    if alpha + 2 * d <= 1 || !(-4..=2).contains(&alpha) {
        return None;
    }
    let mf = m as f64;
    let s = match stride {
        Stride::Sample => mf,
        Stride::Tau => 1.0,
        Stride::Share(per_tau) => per_tau as f64,
    };
    let f = if filter == Filter::Modified { 1.0 } else { mf };
    let df = f64::from(d);
    let span = mf / f + mf * df;
    let terms = 1.0 + (s * (points as f64 - span) / mf).floor();
    if terms < 1.0 {
        return None;
    }
    let r = terms / s;
    let j = terms.min((df + 1.0) * s);
    let inverse = |f: Width, j: f64, terms: f64, s: f64| {
        let zero = sz(0.0, f, alpha, d);
        basic_sum(j, terms, s, f, alpha, d) / (zero * zero * terms)
    };
    let short = j <= LONGEST_SUM;
    let inverse_edf = if filter == Filter::Modified {
        if short {
            inverse(Width::Finite(1.0), j, terms, s)
        } else if r > df + 1.0 {
            let (a0, a1) = table(&MODIFIED, alpha, d)?;
            (a0 - a1 / r) / r
        } else {
            inverse(
                Width::Finite(1.0),
                LONGEST_SUM,
                LONGEST_SUM,
                LONGEST_SUM / r,
            )
        }
    } else if alpha <= 0 {
        if short {
            let width = if mf * (df + 1.0) <= LONGEST_SUM {
                Width::Finite(mf)
            } else {
                Width::Infinite
            };
            inverse(width, j, terms, s)
        } else if r > df + 1.0 {
            let (a0, a1) = table(&PLAIN, alpha, d)?;
            (a0 - a1 / r) / r
        } else {
            inverse(Width::Infinite, LONGEST_SUM, LONGEST_SUM, LONGEST_SUM / r)
        }
    } else if alpha == 1 {
        let (b0, b1) = [(6.0, 4.0), (15.23, 12.0), (47.8, 40.0)][d as usize - 1];
        let zero = b0 + b1 * mf.ln();
        if short {
            // The finite width cancels to fewer digits as m grows; the loss stays below 1e-4 for m < 10⁶.
            inverse(Width::Finite(mf), j, terms, s)
        } else if r > df + 1.0 {
            let (a0, a1) = table(&PLAIN, alpha, d)?;
            (a0 - a1 / r) / (zero * zero * r)
        } else {
            let s = LONGEST_SUM / r;
            basic_sum(LONGEST_SUM, LONGEST_SUM, s, Width::Finite(s), 1, d)
                / (zero * zero * LONGEST_SUM)
        }
    } else {
        white_phase(terms, r, d)
    };
    Some(1.0 / inverse_edf)
}

/// White phase noise: differences correlate only at whole multiples k of τ, with ρ_k = C(2d, d−k)/C(2d, d).
fn white_phase(terms: f64, r: f64, d: i32) -> f64 {
    let central = binomial(2 * d, d);
    let mut sum = 1.0;
    for k in 1..=d {
        let weight = 1.0 - f64::from(k) / r;
        if weight <= 0.0 {
            break;
        }
        let rho = binomial(2 * d, d - k) / central;
        sum += 2.0 * weight * rho * rho;
    }
    sum / terms
}

fn binomial(n: i32, k: i32) -> f64 {
    (1..=k).fold(1.0, |c, i| c * f64::from(n - k + i) / f64::from(i))
}

/// Width of the averaging filter in samples, or its limit.
#[derive(Clone, Copy)]
enum Width {
    Finite(f64),
    Infinite,
}

/// Σ over lags of the squared autocovariance with triangular weights. **Source** `[GR2003] eq. 10`.
fn basic_sum(j: f64, terms: f64, s: f64, f: Width, alpha: i32, d: i32) -> f64 {
    let square = |t: f64| sz(t, f, alpha, d).powi(2);
    let inner: f64 = (1..j as usize)
        .map(|k| 2.0 * (1.0 - k as f64 / terms) * square(k as f64 / s))
        .sum();
    square(0.0) + (1.0 - j / terms) * square(j / s) + inner
}

/// Autocovariance of the d-th differences. **Source** `[GR2003] eq. 9`.
fn sz(t: f64, f: Width, alpha: i32, d: i32) -> f64 {
    let centre = binomial(2 * d, d) * sx(t, f, alpha);
    (1..=d).fold(centre, |sum, k| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let shift = f64::from(k);
        sum + sign * binomial(2 * d, d - k) * (sx(t - shift, f, alpha) + sx(t + shift, f, alpha))
    })
}

/// Generalised autocovariance of the filtered phase. **Source** `[GR2003] eq. 8`.
fn sx(t: f64, f: Width, alpha: i32) -> f64 {
    match f {
        Width::Infinite => sw(t, alpha + 2),
        Width::Finite(f) => {
            f * f * (2.0 * sw(t, alpha) - sw(t - 1.0 / f, alpha) - sw(t + 1.0 / f, alpha))
        }
    }
}

/// Generalised autocovariance of the phase noise. **Source** `[GR2003] eq. 7`.
fn sw(t: f64, alpha: i32) -> f64 {
    let t = t.abs();
    let power = t.powi(3 - alpha);
    if alpha % 2 == 0 {
        if alpha == 2 { -t } else { power }
    } else if t == 0.0 {
        0.0
    } else {
        power * t.ln()
    }
}

type Fits = [[Option<(f64, f64)>; 3]; 7];

/// Rows α = 2 … −4, columns d = 1, 2, 3.
fn table(fits: &Fits, alpha: i32, d: i32) -> Option<(f64, f64)> {
    fits[(2 - alpha) as usize][d as usize - 1]
}

/// Modified variances. **Source** `[GR2003] table 1`.
const MODIFIED: Fits = [
    [
        Some((2.0 / 3.0, 1.0 / 3.0)),
        Some((7.0 / 9.0, 0.5)),
        Some((22.0 / 25.0, 2.0 / 3.0)),
    ],
    [
        Some((0.840, 0.345)),
        Some((0.997, 0.616)),
        Some((1.141, 0.843)),
    ],
    [
        Some((1.079, 0.368)),
        Some((1.033, 0.607)),
        Some((1.184, 0.848)),
    ],
    [None, Some((1.048, 0.534)), Some((1.180, 0.816))],
    [None, Some((1.302, 0.535)), Some((1.175, 0.777))],
    [None, None, Some((1.194, 0.703))],
    [None, None, Some((1.489, 0.702))],
];

/// Unmodified variances. **Source** `[GR2003] table 2`.
const PLAIN: Fits = [
    [
        Some((1.5, 0.5)),
        Some((35.0 / 18.0, 1.0)),
        Some((2.31, 1.5)),
    ],
    [
        Some((78.6, 25.2)),
        Some((790.0, 410.0)),
        Some((9950.0, 6520.0)),
    ],
    [
        Some((2.0 / 3.0, 1.0 / 6.0)),
        Some((2.0 / 3.0, 1.0 / 3.0)),
        Some((7.0 / 9.0, 0.5)),
    ],
    [None, Some((0.852, 0.375)), Some((0.997, 0.617))],
    [None, Some((1.079, 0.368)), Some((1.033, 0.607))],
    [None, None, Some((1.053, 0.553))],
    [None, None, Some((1.302, 0.535))],
];

/// Interval of a deviation at `probability`: σ √(ν/χ²_{(1±p)/2}(ν)).
///
/// **Source** `[SP1065] eq. 45`.
///
/// ```
/// let (lower, upper) = proofmass_noise::chi_square_interval(1.0, 10.0, 0.95).unwrap();
/// assert!((lower - 0.6987).abs() < 1e-4 && (upper - 1.7550).abs() < 1e-4);
/// ```
pub fn chi_square_interval(deviation: f64, edf: f64, probability: f64) -> Option<(f64, f64)> {
    if !(probability > 0.0 && probability < 1.0 && edf > 0.0 && edf.is_finite()) {
        return None;
    }
    let limit = |p: f64| {
        let quantile = chi_square_quantile(p, edf)?;
        Some(deviation * (edf / quantile).sqrt())
    };
    Some((
        limit(0.5 * (1.0 + probability))?,
        limit(0.5 * (1.0 - probability))?,
    ))
}

/// Quantile of χ² with ν degrees of freedom.
pub(crate) fn chi_square_quantile(p: f64, nu: f64) -> Option<f64> {
    if nu > 1e5 {
        // Wilson and Hilferty: relative error below 1e-7 here, where the exact inversion becomes slow.
        let z = proofmass_uncertainty::normal_quantile(p);
        let a = 2.0 / (9.0 * nu);
        return Some(nu * (1.0 - a + z * a.sqrt()).powi(3));
    }
    let quantile = ChiSquared::new(nu).ok()?.inverse_cdf(p);
    (quantile.is_finite() && quantile > 0.0).then_some(quantile)
}
