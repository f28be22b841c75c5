//! Quantiles.

use super::{Distribution, positive};
use crate::student;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::PI;

impl Distribution {
    /// The value that is exceeded with probability 1 − `p`; for the curvilinear trapezoid by its own integral.
    pub fn quantile(&self, p: f64) -> f64 {
        match self {
            Self::Normal { mean, u } => mean + u * student::standard_normal_quantile(p),
            Self::StudentT {
                location,
                scale,
                dof,
            } => location + scale * student::quantile(p, *dof),
            Self::Rectangular { lower, upper } => lower + (upper - lower) * p,
            Self::Triangular { lower, upper } => trapezoid_quantile(*lower, *upper, 0.0, p),
            Self::Trapezoidal { lower, upper, beta } => {
                trapezoid_quantile(*lower, *upper, *beta, p)
            }
            Self::CurvilinearTrapezoid {
                lower,
                upper,
                inexactness,
            } => curvilinear_quantile(*lower, *upper, *inexactness, p),
            Self::Arcsine { lower, upper } => {
                0.5 * (lower + upper) - 0.5 * (upper - lower) * (PI * p).cos()
            }
            Self::TruncatedNormal {
                mean,
                sd,
                lower,
                upper,
            } => {
                let normal = Normal::standard();
                let (a, b) = ((lower - mean) / sd, (upper - mean) / sd);
                // In the upper half the complement keeps the digits that 1 − small would lose.
                let z = if a > 0.0 {
                    let (qa, qb) = (normal.sf(a), normal.sf(b));
                    -normal.inverse_cdf(qa + (qb - qa) * p)
                } else {
                    let (pa, pb) = (normal.cdf(a), normal.cdf(b));
                    normal.inverse_cdf(pa + (pb - pa) * p)
                };
                (mean + sd * z).clamp(*lower, *upper)
            }
            other @ (Self::Exponential { .. }
            | Self::Gamma { .. }
            | Self::Lognormal { .. }
            | Self::Beta { .. }
            | Self::Poisson { .. }
            | Self::Discrete { .. }) => positive::quantile(other, p),
            Self::Samples { values } => {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                let place =
                    ((p * sorted.len() as f64) as usize).min(sorted.len().saturating_sub(1));
                sorted.get(place).copied().unwrap_or(0.0)
            }
        }
    }
}

/// Inverse of the distribution function of a symmetric trapezoid.
fn trapezoid_quantile(lower: f64, upper: f64, beta: f64, p: f64) -> f64 {
    let width = upper - lower;
    let slope = 0.5 * (1.0 - beta) * width; // horizontal extent of one flank
    let height = 2.0 / (width * (1.0 + beta));
    let flank = 0.5 * height * slope;
    if width == 0.0 {
        lower
    } else if p < flank {
        lower + (2.0 * p * slope / height).sqrt()
    } else if p > 1.0 - flank {
        upper - (2.0 * (1.0 - p) * slope / height).sqrt()
    } else {
        lower + slope + (p - flank) / height
    }
}

/// Bisection of P(X ≤ x) = mean over the half-width w of clamp((x − m + w)/2w), w uniform in a ± d.
fn curvilinear_quantile(lower: f64, upper: f64, d: f64, p: f64) -> f64 {
    let (m, a) = (0.5 * (lower + upper), 0.5 * (upper - lower));
    if d == 0.0 {
        return lower + (upper - lower) * p;
    }
    let above = |y: f64| -> f64 {
        // P(X > m + y), y ≥ 0: ∫ max(0, w − y)/(2w) dw / 2d from a − d to a + d.
        let low = y.max(a - d);
        let high = a + d;
        if low >= high {
            0.0
        } else {
            (high - low - y * (high / low).ln()) / (4.0 * d)
        }
    };
    let q = p.min(1.0 - p);
    let (mut low, mut high) = (0.0, a + d);
    for _ in 0..80 {
        let y = 0.5 * (low + high);
        if above(y) > q { low = y } else { high = y }
    }
    let y = 0.5 * (low + high);
    if p < 0.5 { m - y } else { m + y }
}
