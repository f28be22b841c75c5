//! The parabolic variance, PDEV.
//!
//! Phase arguments are in units of U·τ0, as in `allan.rs`.

use crate::allan::MeanSquare;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// The sliding form is the definition.
    #[test]
    fn law_the_sliding_sum_is_the_definition() {
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
        }
    }

    /// By definition.
    #[test]
    fn law_parabolic_joins_allan() {
        let x: Vec<f64> = (0..40_u32).map(|k| f64::from(k * k * 13 % 29)).collect();
        assert_eq!(parabolic(&x, 1), crate::overlapping::overlapping(&x, 1));
    }
}
