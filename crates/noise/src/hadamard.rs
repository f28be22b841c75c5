//! Hadamard variances: third differences of the phase, blind to a linear drift of the rate.

use crate::allan::MeanSquare;

/// HVAR without overlap: σ² = 1/(6 m² M) Σ_j (x_{(j+3)m} − 3 x_{(j+2)m} + 3 x_{(j+1)m} − x_{jm})².
///
/// **Source** `[SP1065] eq. 20`.
pub(crate) fn hadamard(x: &[f64], m: usize) -> MeanSquare {
    differences(x, m, m)
}

/// HVAR with every start, N − 3m terms. **Source** `[SP1065] eq. 22`.
pub(crate) fn overlapping(x: &[f64], m: usize) -> MeanSquare {
    differences(x, m, 1)
}

fn differences(x: &[f64], m: usize, stride: usize) -> MeanSquare {
    let mut sum = 0.0;
    let mut terms = 0;
    for i in (0..x.len() - 3 * m).step_by(stride) {
        let d = x[i + 3 * m] - 3.0 * x[i + 2 * m] + 3.0 * x[i + m] - x[i];
        sum += d * d;
        terms += 1;
    }
    let m = m as f64;
    (sum / (6.0 * m * m * terms as f64), terms)
}
