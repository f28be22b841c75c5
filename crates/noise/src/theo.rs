//! THEO1, the theoretical variance that reaches three quarters of the record.

use crate::allan::MeanSquare;
use crate::overlapping::overlapping;
use crate::steps::Steps;
use rayon::prelude::*;

/// Terms of one distance beyond which an onlooker is asked at each, else at every so many.
const LONG: usize = 1 << 12;
const ASKED: usize = 64;

/// Ratios of THEO1 and the Allan variance that are averaged: all of them up to 1200 phase points.
const MOST_RATIOS: usize = 200;

/// THEO1: σ²(0.75 m τ0) = 1/(0.75 (N − m) m²) Σ_i Σ_{δ=0}^{m/2−1} 1/(m/2 − δ)
/// ((x_i − x_{i−δ+m/2}) + (x_{i+m} − x_{i+δ+m/2}))², m even.
///
/// **Source** `[SP1065] eq. 30`.
pub(crate) fn theo1(x: &[f64], m: usize, steps: &Steps<'_>) -> MeanSquare {
    let half = m / 2;
    let starts = x.len() - m;
    let sum: f64 = (0..half)
        .into_par_iter()
        .map(|delta| {
            if (starts > LONG || delta % ASKED == 0) && !steps.goes_on() {
                return f64::NAN;
            }
            let near = &x[half - delta..half - delta + starts];
            let far = &x[half + delta..half + delta + starts];
            let sum: f64 = x[..starts]
                .iter()
                .zip(&x[m..])
                .zip(near.iter().zip(far))
                .map(|((first, last), (near, far))| {
                    let d = (first - near) + (last - far);
                    d * d
                })
                .sum();
            sum / (half - delta) as f64
        })
        .collect::<Vec<_>>()
        .iter()
        .sum();
    let m = m as f64;
    (sum / (0.75 * starts as f64 * m * m), starts * half)
}

/// Ratio by which THEO1 of this record must be multiplied to join its Allan variance: the mean over
/// k = 0 … n of AVAR(9 + 3k)/THEO1(12 + 4k), n = ⌊N/6 − 3⌋ (ThêoBR).
///
/// Of a long record no more than 200 of the k, evenly spaced.
///
/// `None` for records too short for one ratio. **Source** `[SP1065] eq. 33`.
pub(crate) fn record_bias(x: &[f64], steps: &Steps<'_>) -> Option<f64> {
    let last = (x.len() / 6).checked_sub(3)?;
    if x.len() < 30 {
        return None;
    }
    let stride = (last + 1).div_ceil(MOST_RATIOS);
    let ratios = last / stride + 1;
    let sum: f64 = (0..=last)
        .step_by(stride)
        .map(|k| match steps.goes_on() {
            true => overlapping(x, 9 + 3 * k).0 / theo1(x, 12 + 4 * k, steps).0,
            false => f64::NAN,
        })
        .sum();
    let ratio = sum / ratios as f64;
    ratio.is_finite().then_some(ratio)
}
