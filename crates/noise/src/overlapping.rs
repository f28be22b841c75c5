//! The overlapping Allan variance at many averaging times, read block by block.

use crate::allan::{MeanSquare, scaled};
use crate::phase::Phase;
use rayon::prelude::*;

/// Starts visited for every averaging time before the next: 8 kB of phase stay in the first-level cache.
const SUB_BLOCK: usize = 1024;

/// Points beyond a sub-block that a block reaches: the largest factor of a block, twice, fits the second-level cache.
const NEAR: usize = 1 << 15;

/// Starts that one task walks through.
const TASK: usize = 1 << 18;

/// Columns of a tall block.
const COLUMNS: usize = 256;

/// Shortest row of a tall block that is worth its passes.
const SHORTEST_ROW: usize = 1 << 12;

/// σ²(m) = 1/(2 m² (N − 2m)) Σ_i (x_{i+2m} − 2 x_{i+m} + x_i)² for every factor m.
///
/// The record is read twice whatever the number of factors. Factors up to 8192 are taken from a window that slides
/// over the record. Longer ones, as multiples of a common row length L, from tall blocks: the record
/// written in rows of L points, x_{i+m} stands m/L rows below x_i, so that a few columns hold everything that their
/// differences need, whatever m. Factors without a useful common row length are read from the whole phase.
///
/// Blocks have a fixed size and are summed in order: the result does not depend on the number of threads.
///
/// **Source** `[SP1065] eq. 14`.
pub(crate) fn overlapping_family(phase: &Phase<'_>, factors: &[usize]) -> Vec<MeanSquare> {
    let near: Vec<usize> = factors.iter().copied().filter(|m| *m <= NEAR).collect();
    let far: Vec<usize> = factors.iter().copied().filter(|m| *m > NEAR).collect();
    let row = far.iter().fold(0, |a, m| greatest_common_divisor(a, *m));
    let (near_sums, far_sums) = (
        sliding(phase, &near),
        if far.is_empty() {
            Vec::new()
        } else if row >= SHORTEST_ROW {
            tall(phase, &far, row)
        } else {
            whole(&phase.to_vec(), &far)
        },
    );
    let (mut near_sums, mut far_sums) = (near_sums.into_iter(), far_sums.into_iter());
    factors
        .iter()
        .map(|&m| {
            let sums = if m <= NEAR {
                &mut near_sums
            } else {
                &mut far_sums
            };
            let terms = phase.len() - 2 * m;
            (scaled(sums.next().unwrap_or(0.0), terms, m), terms)
        })
        .collect()
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

/// Sums of squares from a window of the phase that slides over the record.
fn sliding(phase: &Phase<'_>, factors: &[usize]) -> Vec<f64> {
    let Some(&longest) = factors.iter().max() else {
        return Vec::new();
    };
    let n = phase.len();
    // The last start is that of the shortest factor.
    let starts = n - 2 * factors.iter().min().unwrap_or(&longest);
    let step = SUB_BLOCK.max(longest);
    let tasks = starts.div_ceil(TASK);
    let partial = (0..tasks)
        .into_par_iter()
        .map(|task| {
            let mut sums = vec![0.0; factors.len()];
            let (begin, end) = (task * TASK, ((task + 1) * TASK).min(starts));
            // The window holds `step` starts and, behind them, the 2m points the longest differences reach.
            let mut window = vec![0.0; (step + 2 * longest).min(n - begin)];
            phase.fill(begin, &mut window);
            let mut at = begin;
            loop {
                let last = (at + step).min(end);
                for sub in (at..last).step_by(SUB_BLOCK) {
                    let starts = SUB_BLOCK.min(last - sub);
                    accumulate(&mut sums, &window[sub - at..], factors, starts);
                }
                if last == end {
                    break sums;
                }
                let kept = window.len() - step;
                window.copy_within(step.., 0);
                let room = (step + 2 * longest).min(n - last);
                window.truncate(room);
                phase.fill(last + kept, &mut window[kept..]);
                at = last;
            }
        })
        .collect::<Vec<_>>();
    in_order(&partial, factors.len())
}

/// Sums of squares from a few columns at a time of the record in rows; every factor is a multiple of `row`.
fn tall(phase: &Phase<'_>, factors: &[usize], row: usize) -> Vec<f64> {
    let n = phase.len();
    let partial = (0..row.div_ceil(COLUMNS))
        .into_par_iter()
        .map(|part| {
            let (first, end) = (part * COLUMNS, ((part + 1) * COLUMNS).min(row));
            let width = end - first;
            let rows = (n - first).div_ceil(row);
            let mut block = vec![0.0; rows * width];
            for (r, line) in block.chunks_exact_mut(width).enumerate() {
                let start = r * row + first;
                phase.fill(start, &mut line[..width.min(n - start)]);
            }
            // Points of the block that exist: all, but for the columns missing in the last row.
            let points = (rows - 1) * width + width.min(n - ((rows - 1) * row + first));
            let shifts: Vec<usize> = factors.iter().map(|m| m / row * width).collect();
            let mut sums = vec![0.0; factors.len()];
            for sub in (0..points).step_by(SUB_BLOCK) {
                accumulate(&mut sums, &block[sub..points], &shifts, SUB_BLOCK);
            }
            sums
        })
        .collect::<Vec<_>>();
    in_order(&partial, factors.len())
}

/// Sums of squares from the phase as a whole.
fn whole(x: &[f64], factors: &[usize]) -> Vec<f64> {
    let partial = (0..x.len().div_ceil(SUB_BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut sums = vec![0.0; factors.len()];
            accumulate(&mut sums, &x[block * SUB_BLOCK..], factors, SUB_BLOCK);
            sums
        })
        .collect::<Vec<_>>();
    in_order(&partial, factors.len())
}

fn in_order(partial: &[Vec<f64>], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for row in partial {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value;
        }
    }
    sums
}

/// Adds to each sum the squares of the differences that start within the first `starts` points of `x`.
///
/// The longest difference reaches twice its shift, at most to the end of `x`. One shift after the other: shifts that double could share
/// their points, but then their sums are not kept side by side in vector registers.
fn accumulate(sums: &mut [f64], x: &[f64], shifts: &[usize], starts: usize) {
    // The widest vectors the machine has; the eight partial sums are the same whatever their width.
    pulp::Arch::new().dispatch(Accumulate {
        sums,
        x,
        shifts,
        starts,
    });
}

struct Accumulate<'a> {
    sums: &'a mut [f64],
    x: &'a [f64],
    shifts: &'a [usize],
    starts: usize,
}

impl pulp::WithSimd for Accumulate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self {
            sums,
            x,
            shifts,
            starts,
        } = self;
        for (sum, &m) in sums.iter_mut().zip(shifts) {
            *sum += squares(x, m, 0, x.len().saturating_sub(2 * m).min(starts));
        }
    }
}

/// Σ (x_{i+2m} − 2 x_{i+m} + x_i)² over start ≤ i < end, in eight interleaved sums.
#[inline(always)]
fn squares(x: &[f64], m: usize, start: usize, end: usize) -> f64 {
    if start >= end {
        return 0.0;
    }
    let (a8, ar) = x[start..end].as_chunks::<8>();
    let (b8, br) = x[start + m..end + m].as_chunks::<8>();
    let (c8, cr) = x[start + 2 * m..end + 2 * m].as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for ((a, b), c) in a8.iter().zip(b8).zip(c8) {
        for k in 0..8 {
            add_square(&mut lanes[k], a[k], b[k], c[k]);
        }
    }
    let mut sum = lanes.iter().sum();
    for ((a, b), c) in ar.iter().zip(br).zip(cr) {
        add_square(&mut sum, *a, *b, *c);
    }
    sum
}

/// Adds (c − 2 b + a)²; the fused forms round once.
#[inline(always)]
fn add_square(sum: &mut f64, a: f64, b: f64, c: f64) {
    let d = b.mul_add(-2.0, a + c);
    *sum = d.mul_add(d, *sum);
}

/// One factor of a phase that is at hand.
pub(crate) fn overlapping(x: &[f64], m: usize) -> MeanSquare {
    let terms = x.len() - 2 * m;
    (scaled(whole(x, &[m])[0], terms, m), terms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoiseRecord;

    /// Every way of reading gives the sum of the definition, to the rounding of the running sums.
    #[test]
    fn law_every_reading_is_the_definition() {
        // 70 001 points: several windows, an unfinished tall block, an unfinished row.
        let rate: Vec<f64> = (0..70_000_u64)
            .map(|k| (k * k % 1013) as f64 * 1e-3 - 3.0 + 1e-6 * k as f64)
            .collect();
        let phase = Phase::new(NoiseRecord::Rate(&rate), 1.0).unwrap();
        let x = phase.to_vec();
        let octaves: Vec<usize> = (0..15).map(|k| 1 << k).chain([24_576]).collect();
        let decades = vec![1, 7, 1000, 9000, 20_000, 35_000];
        let odd = vec![3, 8191, 8193, 34_999];
        for factors in [octaves, decades, odd, vec![16_384], vec![8192]] {
            for (&m, (found, terms)) in factors.iter().zip(overlapping_family(&phase, &factors)) {
                let sum: f64 = (0..x.len() - 2 * m)
                    .map(|i| (x[i + 2 * m] - 2.0 * x[i + m] + x[i]).powi(2))
                    .sum();
                let expected = sum / (2.0 * (m * m) as f64 * (x.len() - 2 * m) as f64);
                assert_eq!(terms, x.len() - 2 * m);
                assert!(
                    (found / expected - 1.0).abs() < 1e-9,
                    "m = {m}: {found:e}, {expected:e}"
                );
            }
        }
    }
}
