//! Statistics of the time error of clocks, and the parabolic variance: TIE rms, MTIE, PDEV; three clocks against each other.
//!
//! Phase arguments are in units of U·τ0, as in `allan.rs`.

use crate::allan::MeanSquare;
use crate::phase::Phase;
use crate::record::NoiseRecord;
use proofmass_core::Error;
use std::collections::VecDeque;

/// Mean square of x_{i+m} − x_i. **Source** `[SP1065] 5.2.16`.
pub(crate) fn interval_error(x: &[f64], m: usize) -> MeanSquare {
    let terms = x.len() - m;
    let sum: f64 = x.windows(m + 1).map(|w| (w[m] - w[0]).powi(2)).sum();
    (sum / terms as f64, terms)
}

/// Square of the largest range of the phase within any m + 1 neighbouring points.
///
/// The extremes of the sliding window are kept in two queues: O(N) for any m. **Source** `[SP1065] 5.2.17`.
pub(crate) fn maximum_interval_error(x: &[f64], m: usize) -> MeanSquare {
    let (mut high, mut low): (VecDeque<usize>, VecDeque<usize>) = Default::default();
    let mut widest = 0.0_f64;
    for (i, v) in x.iter().enumerate() {
        while high.back().is_some_and(|k| x[*k] <= *v) {
            high.pop_back();
        }
        while low.back().is_some_and(|k| x[*k] >= *v) {
            low.pop_back();
        }
        high.push_back(i);
        low.push_back(i);
        for queue in [&mut high, &mut low] {
            while queue.front().is_some_and(|k| k + m < i) {
                queue.pop_front();
            }
        }
        if i >= m
            && let (Some(h), Some(l)) = (high.front(), low.front())
        {
            widest = widest.max(x[*h] - x[*l]);
        }
    }
    (widest * widest, x.len() - m)
}

/// PVAR: 72/(M m⁶) Σ_i (Σ_{k<m} ((m−1)/2 − k)(x_{i+k} − x_{i+k+m}))² in units of τ0; the Allan variance at m = 1.
///
/// **Source** `[Vernotte2016]`.
pub(crate) fn parabolic(x: &[f64], m: usize) -> MeanSquare {
    if m == 1 {
        return crate::overlapping::overlapping(x, 1);
    }
    let terms = x.len() - 2 * m;
    let weight = |k: usize| 0.5 * (m as f64 - 1.0) - k as f64;
    let d = |i: usize| x[i] - x[i + m];
    let mut plain: f64 = (0..m).map(d).sum();
    let mut weighed: f64 = (0..m).map(|k| weight(k) * d(k)).sum();
    let mut sum = 0.0;
    for i in 0..terms {
        sum += weighed * weighed;
        // One step on every weight grows by one: the sum of all but the first, then the new last one.
        plain -= d(i);
        weighed += plain - weight(0) * d(i) + weight(m - 1) * d(i + m);
        plain += d(i + m);
    }
    let m6 = (m as f64).powi(6);
    (72.0 * sum / (terms as f64 * m6), terms)
}

/// Groslambert covariance of two phases measured together: ⟨D_a D_b⟩/2τ² at factor m, the Allan variance of what they share.
///
/// With a = clock 1 − clock 3 and b = clock 2 − clock 3 it is the Allan variance of clock 3, with the noise of the two others and
/// of the counters averaged out. It may come out negative.
///
/// **Units** those of the phase over s, squared; `sample_rate` in Hz.
///
/// **Errors** [`Error::Length`] for phases of different length, [`Error::NotFinite`], [`Error::TooFew`] for fewer than 2m + 1
/// points.
///
/// **Source** `[Groslambert1981]`.
///
/// ```
/// let x: Vec<f64> = (0..50).map(|k| f64::from(k * k * 7 % 11)).collect();
/// // With itself it is the Allan variance.
/// let shared = proofmass_noise::groslambert_covariance(&x, &x, 4, 1.0).unwrap();
/// let direct = proofmass_noise::groslambert_covariance(&x, &x.iter().map(|v| v + 3.0).collect::<Vec<_>>(), 4, 1.0).unwrap();
/// assert!((shared - direct).abs() < 1e-12 && shared > 0.0);
/// ```
pub fn groslambert_covariance(
    a: &[f64],
    b: &[f64],
    m: usize,
    sample_rate: f64,
) -> Result<f64, Error> {
    if a.len() != b.len() {
        return Err(Error::Length {
            name: "phase",
            expected: a.len(),
            got: b.len(),
        });
    }
    crate::record::check_count("phase samples", a.len(), 2 * m.max(1) + 1)?;
    let (a, b) = (
        Phase::new(NoiseRecord::Phase(a), sample_rate)?.to_vec(),
        Phase::new(NoiseRecord::Phase(b), sample_rate)?.to_vec(),
    );
    let m = m.max(1);
    let terms = a.len() - 2 * m;
    let second = |x: &[f64], i: usize| x[i + 2 * m] - 2.0 * x[i + m] + x[i];
    let sum: f64 = (0..terms).map(|i| second(&a, i) * second(&b, i)).sum();
    Ok(crate::allan::scaled(sum, terms, m))
}

/// Variances of three independent clocks from those of their differences: σ₁² = ½(σ₁₂² + σ₁₃² − σ₂₃²) and so on.
///
/// A clock much steadier than the others may come out negative: then only a limit is known.
///
/// ```
/// let [a, b, c] = proofmass_noise::three_cornered_hat([5.0, 10.0, 13.0]);
/// assert_eq!([a, b, c], [1.0, 4.0, 9.0]);
/// ```
pub fn three_cornered_hat([v12, v13, v23]: [f64; 3]) -> [f64; 3] {
    [
        0.5 * (v12 + v13 - v23),
        0.5 * (v12 + v23 - v13),
        0.5 * (v13 + v23 - v12),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sliding forms are the definitions.
    #[test]
    fn law_sliding_sums_are_the_definitions() {
        let x: Vec<f64> = (0..60_u32)
            .map(|k| f64::from(k * k * 31 % 47) + 0.1 * f64::from(k))
            .collect();
        for m in [2, 3, 7, 16] {
            let terms = x.len() - 2 * m;
            let sum: f64 = (0..terms)
                .map(|i| {
                    (0..m)
                        .map(|k| (0.5 * (m as f64 - 1.0) - k as f64) * (x[i + k] - x[i + k + m]))
                        .sum::<f64>()
                        .powi(2)
                })
                .sum();
            let expected = 72.0 * sum / (terms as f64 * (m as f64).powi(6));
            assert!((parabolic(&x, m).0 / expected - 1.0).abs() < 1e-10, "{m}");
            let widest = x
                .windows(m + 1)
                .map(|w| {
                    w.iter().copied().fold(f64::MIN, f64::max)
                        - w.iter().copied().fold(f64::MAX, f64::min)
                })
                .fold(0.0, f64::max);
            assert_eq!(maximum_interval_error(&x, m).0, widest * widest);
        }
    }

    /// By definition.
    #[test]
    fn law_parabolic_joins_allan() {
        let x: Vec<f64> = (0..40_u32).map(|k| f64::from(k * k * 13 % 29)).collect();
        assert_eq!(parabolic(&x, 1), crate::overlapping::overlapping(&x, 1));
    }
}
