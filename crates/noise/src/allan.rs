//! Allan variances: plain, overlapping and modified.
//!
//! Phase arguments are in units of U·τ0 (running sums of the rate), so that a variance comes out in U².

use rayon::prelude::*;

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

/// AVAR with every start: σ² = 1/(2 m² (N − 2m)) Σ_i (x_{i+2m} − 2 x_{i+m} + x_i)².
///
/// **Source** `[SP1065] eq. 14`.
pub(crate) fn overlapping(x: &[f64], m: usize) -> MeanSquare {
    overlapping_family(x, &[m])[0]
}

/// All averaging factors of an octave family in one pass over the phase.
///
/// A block of starts is visited for every m before the next block is fetched: x_{i+2m} of one octave is x_{i+m} of
/// the next, so each octave costs one new stream instead of three, and the short ones none.
///
/// Blocks have a fixed size and are summed in order: the result does not depend on the number of threads.
pub(crate) fn overlapping_family(x: &[f64], factors: &[usize]) -> Vec<MeanSquare> {
    let blocks = x.len().div_ceil(BLOCK);
    // The widest vectors the machine has; the eight sums of `squares` are the same whatever their width.
    let arch = pulp::Arch::new();
    let partial: Vec<Vec<f64>> = (0..blocks)
        .into_par_iter()
        .map(|block| {
            let start = block * BLOCK;
            arch.dispatch(
                #[inline(always)]
                || {
                    factors
                        .iter()
                        .map(|&m| {
                            let end = (start + BLOCK).min(x.len() - 2 * m);
                            if start >= end {
                                0.0
                            } else {
                                squares(x, m, start, end)
                            }
                        })
                        .collect()
                },
            )
        })
        .collect();
    let mut sums = vec![0.0; factors.len()];
    for row in &partial {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value;
        }
    }
    factors
        .iter()
        .zip(sums)
        .map(|(&m, sum)| {
            let terms = x.len() - 2 * m;
            (scaled(sum, terms, m), terms)
        })
        .collect()
}

/// Starts per block: 32 kB of phase, which a first-level cache holds.
const BLOCK: usize = 4096;

/// Σ (x_{i+2m} − 2 x_{i+m} + x_i)² over start ≤ i < end, in eight interleaved sums.
#[inline(always)]
fn squares(x: &[f64], m: usize, start: usize, end: usize) -> f64 {
    let a = &x[start..end];
    let b = &x[start + m..end + m];
    let c = &x[start + 2 * m..end + 2 * m];
    let mut lanes = [0.0; 8];
    let (a8, ar) = a.as_chunks::<8>();
    let (b8, br) = b.as_chunks::<8>();
    let (c8, cr) = c.as_chunks::<8>();
    for ((a, b), c) in a8.iter().zip(b8).zip(c8) {
        for k in 0..8 {
            let d = (c[k] - b[k]) - (b[k] - a[k]);
            lanes[k] += d * d;
        }
    }
    let mut sum: f64 = lanes.iter().sum();
    for ((a, b), c) in ar.iter().zip(br).zip(cr) {
        let d = c - 2.0 * b + a;
        sum += d * d;
    }
    sum
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

fn scaled(sum: f64, terms: usize, m: usize) -> f64 {
    let m = m as f64;
    sum / (2.0 * m * m * terms as f64)
}
