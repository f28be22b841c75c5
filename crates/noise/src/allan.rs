//! Allan variances: plain and modified.
//!
//! Phase arguments are in units of U·τ0 (running sums of the rate), so that a variance comes out in U².

/// Mean square and the number of terms it was taken over.
pub(crate) type MeanSquare = (f64, usize);

/// AVAR without overlap: σ² = 1/(2 m² M) Σ_j (x_{(j+2)m} − 2 x_{(j+1)m} + x_{jm})².
///
/// **Source** `[SP1065] eq. 10`.
pub(crate) fn allan(x: &[f64], m: usize) -> MeanSquare {
    let mut sum = 0.0;
    let mut terms = 0;
    let mut i = 0;
    while i + 2 * m < x.len() {
        let d = x[i + 2 * m] - 2.0 * x[i + m] + x[i];
        sum += d * d;
        terms += 1;
        i += m;
    }
    (scaled(sum, terms, m), terms)
}

/// MVAR: σ² = 1/(2 m⁴ (N − 3m + 1)) Σ_j (Σ_{i=j}^{j+m−1} x_{i+2m} − 2 x_{i+m} + x_i)².
///
/// The inner sum slides: one addition and one subtraction per start, O(N) for any m.
///
/// **Source** `[SP1065] eq. 18`.
pub(crate) fn modified(x: &[f64], m: usize) -> MeanSquare {
    let terms = x.len() + 1 - 3 * m;
    let mut inner: f64 = (0..m).map(|i| x[i + 2 * m] - 2.0 * x[i + m] + x[i]).sum();
    let mut sum = inner * inner;
    for j in 1..terms {
        inner += x[j + 3 * m - 1] - 3.0 * x[j + 2 * m - 1] + 3.0 * x[j + m - 1] - x[j - 1];
        sum += inner * inner;
    }
    let m2 = (m * m) as f64;
    (scaled(sum, terms, m) / m2, terms)
}

pub(crate) fn scaled(sum: f64, terms: usize, m: usize) -> f64 {
    let m = m as f64;
    sum / (2.0 * m * m * terms as f64)
}
