//! Total variances: the record, or each piece of it, extended by reflection.

use crate::allan::MeanSquare;
use crate::steps::Steps;
use rayon::prelude::*;

/// TOTVAR: σ² = 1/(2 m² (N − 2)) Σ_{i=2}^{N−1} (x*_{i−m} − 2 x*_i + x*_{i+m})², x* the record extended on
/// either side by odd reflection, x*_{1−j} = 2 x_1 − x_{1+j} and x*_{N+j} = 2 x_N − x_{N−j}.
///
/// **Source** `[SP1065] eq. 25`.
pub(crate) fn total(x: &[f64], m: usize) -> MeanSquare {
    let n = x.len();
    let last = n - 1;
    let at = |i: isize| -> f64 {
        if i < 0 {
            2.0 * x[0] - x[i.unsigned_abs()]
        } else if i as usize > last {
            2.0 * x[last] - x[2 * last - i as usize]
        } else {
            x[i as usize]
        }
    };
    let m_signed = m as isize;
    let sum: f64 = (1..last as isize)
        .map(|i| {
            let d = at(i - m_signed) - 2.0 * at(i) + at(i + m_signed);
            d * d
        })
        .sum();
    let m = m as f64;
    (sum / (2.0 * m * m * (n - 2) as f64), n - 2)
}

/// MTOTVAR: mean over all 3m-point pieces of the phase of the modified variance of the piece, freed from its
/// slope and extended to 9m points by even reflection.
///
/// **Source** `[SP1065] eq. 27`, with the slope from the means of the two halves.
pub(crate) fn modified_total(x: &[f64], m: usize, steps: &Steps<'_>) -> MeanSquare {
    let (mean, terms) = mean_over_pieces(x, m, steps);
    let m = m as f64;
    (mean / (2.0 * m * m), terms)
}

/// HTOTVAR: the same construction on the rate, scaled as a Hadamard variance.
///
/// At m = 1 it is the Hadamard variance by definition. **Source** `[SP1065] eq. 29`.
pub(crate) fn hadamard_total(x: &[f64], m: usize, steps: &Steps<'_>) -> MeanSquare {
    if m == 1 {
        return crate::hadamard::overlapping(x, 1);
    }
    let rate: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let (mean, terms) = mean_over_pieces(&rate, m, steps);
    (mean / 6.0, terms)
}

/// Mean over all pieces of 3m points, and over the 6m positions in each extended piece, of the squared second
/// difference of m-point averages.
///
/// With P the running sum of the extended piece, a second difference of neighbouring m-sums is the third
/// difference P_{j+3m} − 3 P_{j+2m} + 3 P_{j+m} − P_j: four loads instead of 3m. The extension is symmetric about
/// either end of the piece, so the squares at j and 3m − j agree, and those at 3m + i and 6m − i; the 3m
/// positions from ⌈3m/2⌉ on stand for all. Work is O(m) per piece; a direct evaluation takes O(m²).
fn mean_over_pieces(x: &[f64], m: usize, steps: &Steps<'_>) -> MeanSquare {
    let pieces = x.len() + 1 - 3 * m;
    // Batches large enough to be worth a task and independent of the number of threads.
    let batch = (200_000 / (6 * m)).max(1);
    let batches = pieces.div_ceil(batch);
    let partial: Vec<f64> = (0..batches)
        .into_par_iter()
        .with_min_len(1)
        .map(|b| {
            if !steps.goes_on() {
                return f64::NAN;
            }
            let mut running = vec![0.0; 6 * m + 1];
            (b * batch..((b + 1) * batch).min(pieces))
                .map(|i| piece(&x[i..i + 3 * m], m, &mut running))
                .sum()
        })
        .collect();
    let sum: f64 = partial.iter().sum();
    let m = m as f64;
    (sum / (6.0 * m * m * m * pieces as f64), pieces)
}

/// Σ over the 6m positions of the squared second difference of m-sums for one piece.
fn piece(z: &[f64], m: usize, running: &mut [f64]) -> f64 {
    let l = 3 * m;
    let half = l / 2;
    let first: f64 = z[..half].iter().sum();
    let second: f64 = z[l - half..].iter().sum();
    // Distance between the centres of the halves: half + 1 when a middle point is left out, half otherwise.
    let distance = (l - half) as f64;
    let slope = (second - first) / (half as f64 * distance);
    // Running sum of the extended piece from position l − half on: half of the piece reflected, the piece, and
    // l − half points reflected. Values are taken from the middle of the piece, which keeps the sums small.
    let centre = z[half];
    let detrended = |k: usize| z[k] - centre - slope * (k as f64 - half as f64);
    let mut sum = 0.0;
    running[0] = 0.0;
    let positions = (0..half).rev().chain(0..l).chain((half..l).rev());
    for (p, k) in running[1..].iter_mut().zip(positions) {
        sum += detrended(k);
        *p = sum;
    }
    let count = l + 1;
    let a = &running[..count];
    let b = &running[m..m + count];
    let c = &running[2 * m..2 * m + count];
    let d = &running[3 * m..3 * m + count];
    let square = |j: usize| (d[j] - 3.0 * c[j] + 3.0 * b[j] - a[j]).powi(2);
    let mut lanes = [0.0; 4];
    let whole = l - l % 4;
    for j in (0..whole).step_by(4) {
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane += square(j + k);
        }
    }
    let sum: f64 = lanes.iter().sum::<f64>() + (whole..l).map(square).sum::<f64>();
    if l % 2 == 1 {
        2.0 * sum
    } else {
        // The first and the last position are their own mirror images.
        2.0 * sum - square(0) + square(l)
    }
}
