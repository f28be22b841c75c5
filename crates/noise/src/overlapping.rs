//! The overlapping Allan variance at many averaging times, read block by block.

use crate::allan::{MeanSquare, scaled};
use crate::phase::{Kept, Phase, STEP};
use crate::steps::Steps;
use rayon::prelude::*;

/// Starts visited for every averaging time before the next: 8 kB of phase stay in the first-level cache.
const SUB_BLOCK: usize = 1024;

/// Longest factor that is taken from a window: four times as many points fit the second-level cache.
const NEAR: usize = 1 << 14;

/// Starts that one task walks through.
const TASK: usize = 1 << 18;

/// Factors beyond which an onlooker is asked at every block.
const MANY: usize = 64;

/// Factors that are taken from the whole phase before an onlooker is asked again.
const TOGETHER: usize = 1 << 14;

/// Columns of a tall block.
const COLUMNS: usize = 256;

/// Shortest row of a tall block that is worth its passes.
const SHORTEST_ROW: usize = 1 << 12;

/// σ²(m) = 1/(2 m² (N − 2m)) Σ_i (x_{i+2m} − 2 x_{i+m} + x_i)² for every factor m.
///
/// The record is read twice whatever the number of factors; a phase that is not yet read becomes known with the first reading. Factors up
/// to 16 384 are taken from a window that slides over the record. Longer ones, as multiples of a common row length L, from tall blocks: the
/// record written in rows of L points, x_{i+m} stands m/L rows below x_i, so that a few columns hold everything that their differences need,
/// whatever m. Factors without a useful common row length are read from the whole phase.
///
/// Blocks have a fixed size and are summed in order: the result does not depend on the number of threads.
///
/// **Source** `[SP1065] eq. 14`.
pub(crate) fn overlapping_family(
    phase: &Phase<'_>,
    factors: &[usize],
    steps: &Steps<'_>,
) -> Vec<MeanSquare> {
    let near: Vec<usize> = factors.iter().copied().filter(|m| *m <= NEAR).collect();
    let far: Vec<usize> = factors.iter().copied().filter(|m| *m > NEAR).collect();
    let row = far.iter().fold(0, |a, m| greatest_common_divisor(a, *m));
    if near.is_empty() {
        // Read before many threads ask for it.
        phase.kept();
    }
    let (near_sums, far_sums) = (
        sliding(phase, &near, steps),
        if far.is_empty() {
            Vec::new()
        } else if row >= SHORTEST_ROW {
            tall(phase, &far, row, steps)
        } else {
            whole(&phase.to_vec(), &far, steps)
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
fn sliding(phase: &Phase<'_>, factors: &[usize], steps: &Steps<'_>) -> Vec<f64> {
    let Some(&longest) = factors.iter().max() else {
        return Vec::new();
    };
    let n = phase.len();
    // The last start is that of the shortest factor.
    let starts = n - 2 * factors.iter().min().unwrap_or(&longest);
    let step = SUB_BLOCK.max(2 * longest);
    let tasks = starts.div_ceil(TASK);
    let unread = phase.is_unread();
    let walk = |task: usize| {
        let mut sums = vec![0.0; factors.len()];
        let (begin, end) = (task * TASK, ((task + 1) * TASK).min(starts));
        // A phase that is not yet known begins at zero in every task: second differences do not see it.
        let mut points = Points {
            phase,
            at: begin,
            x: unread.then_some(0.0),
            kept: Vec::with_capacity(if unread { TASK / STEP + 1 } else { 0 }),
        };
        // The window holds `step` starts and, behind them, the 2m points the longest differences reach.
        let mut room = Aligned::new((step + 2 * longest).min(n - begin));
        let mut window = room.points();
        points.next(window);
        let mut at = begin;
        loop {
            let last = (at + step).min(end);
            if !steps.goes_on() {
                break (sums, points.kept, points.x);
            }
            for sub in (at..last).step_by(SUB_BLOCK) {
                if factors.len() > MANY && !steps.goes_on() {
                    break;
                }
                let starts = SUB_BLOCK.min(last - sub);
                accumulate(&mut sums, &window[sub - at..], factors, starts);
            }
            if last == end {
                break (sums, points.kept, points.x);
            }
            let kept = window.len() - step;
            window.copy_within(step.., 0);
            window = &mut window[..(step + 2 * longest).min(n - last)];
            points.next(&mut window[kept..]);
            at = last;
        }
    };
    let partial: Vec<_> = (0..tasks).into_par_iter().map(walk).collect();
    if unread && steps.goes_on() {
        keep(phase, &partial);
    }
    in_order(partial.iter().map(|(sums, ..)| sums), factors.len())
}

/// The points of a phase one after the other.
struct Points<'a> {
    phase: &'a Phase<'a>,
    at: usize,
    /// Of a phase that is not yet known: the next point.
    x: Option<f64>,
    /// Of such a phase: every 64th point.
    kept: Vec<f64>,
}

impl Points<'_> {
    fn next(&mut self, out: &mut [f64]) {
        match self.x {
            None => self.phase.fill(self.at, out),
            Some(x) => {
                self.x = Some(self.phase.continue_from(x, self.at, out));
                let first = self.at.next_multiple_of(STEP) - self.at;
                self.kept.extend(out.iter().skip(first).step_by(STEP));
            }
        }
        self.at += out.len();
    }
}

/// Sums of a task, every 64th of its points, and its last; the points as if the first of the task were zero.
type Walked = (Vec<f64>, Vec<f64>, Option<f64>);

/// Joins the points of all tasks.
fn keep(phase: &Phase<'_>, tasks: &[Walked]) {
    let own = TASK / STEP;
    let (mut origin, mut last) = (0.0, 0.0);
    let mut points = Vec::with_capacity(phase.len() / STEP + 1);
    for (index, (_, kept, end)) in tasks.iter().enumerate() {
        // A task sees the first points of the next as well.
        let seen = if index + 1 < tasks.len() {
            own
        } else {
            kept.len()
        };
        points.extend(kept[..seen].iter().map(|x| origin + x));
        last = origin + end.unwrap_or(0.0);
        origin += kept.get(own).copied().unwrap_or(0.0);
    }
    phase.keep(Kept { points, last });
}

/// Sums of squares from a few columns at a time of the record in rows; every factor is a multiple of `row`.
fn tall(phase: &Phase<'_>, factors: &[usize], row: usize, steps: &Steps<'_>) -> Vec<f64> {
    let n = phase.len();
    let partial = (0..row.div_ceil(COLUMNS))
        .into_par_iter()
        .map(|part| {
            let (first, end) = (part * COLUMNS, ((part + 1) * COLUMNS).min(row));
            let width = end - first;
            let rows = (n - first).div_ceil(row);
            let mut room = Aligned::new(rows * width);
            let block = room.points();
            for (r, line) in block.chunks_exact_mut(width).enumerate() {
                let start = r * row + first;
                phase.fill(start, &mut line[..width.min(n - start)]);
            }
            // Points of the block that exist: all, but for the columns missing in the last row.
            let points = (rows - 1) * width + width.min(n - ((rows - 1) * row + first));
            let shifts: Vec<usize> = factors.iter().map(|m| m / row * width).collect();
            let mut sums = vec![0.0; factors.len()];
            for sub in (0..points).step_by(SUB_BLOCK) {
                if (factors.len() > MANY || sub % (64 * SUB_BLOCK) == 0) && !steps.goes_on() {
                    break;
                }
                accumulate(&mut sums, &block[sub..points], &shifts, SUB_BLOCK);
            }
            sums
        })
        .collect::<Vec<_>>();
    in_order(&partial, factors.len())
}

/// Points that begin with a line of the cache: reading a register full of them touches one line, not two.
struct Aligned {
    points: Vec<f64>,
    begin: usize,
    count: usize,
}

impl Aligned {
    const LINE: usize = 64;

    fn new(count: usize) -> Self {
        let points = vec![0.0_f64; count + Self::LINE / size_of::<f64>()];
        // Where the address cannot be told any place serves.
        let begin = points.as_ptr().align_offset(Self::LINE);
        Self {
            begin: begin.min(points.len() - count),
            points,
            count,
        }
    }

    fn points(&mut self) -> &mut [f64] {
        &mut self.points[self.begin..self.begin + self.count]
    }
}

/// Sums of squares from the phase as a whole.
fn whole(x: &[f64], factors: &[usize], steps: &Steps<'_>) -> Vec<f64> {
    let partial = (0..x.len().div_ceil(SUB_BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut sums = vec![0.0; factors.len()];
            for (sums, factors) in sums.chunks_mut(TOGETHER).zip(factors.chunks(TOGETHER)) {
                if !steps.goes_on() {
                    break;
                }
                accumulate(sums, &x[block * SUB_BLOCK..], factors, SUB_BLOCK);
            }
            sums
        })
        .collect::<Vec<_>>();
    in_order(&partial, factors.len())
}

fn in_order<'a>(partial: impl IntoIterator<Item = &'a Vec<f64>>, count: usize) -> Vec<f64> {
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
/// The longest difference reaches twice its shift, at most to the end of `x`. Shifts that double share their points: five of them
/// read seven where each by itself reads three.
fn accumulate(sums: &mut [f64], x: &[f64], shifts: &[usize], starts: usize) {
    // In the widest registers the machine has, with one sum for each place: the last digits depend on it.
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

/// Shifts that double and share their points, at most: their sums and points have room in the registers.
const OCTAVES: usize = 5;

impl pulp::WithSimd for Accumulate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self {
            mut sums,
            x,
            mut shifts,
            starts,
        } = self;
        let within = |shift: usize| x.len().saturating_sub(2 * shift).min(starts);
        while let [m, others @ ..] = shifts {
            let shared = others
                .iter()
                .take(OCTAVES - 1)
                .zip(1..)
                .take_while(|(shift, k)| **shift == m << k && within(**shift) == starts)
                .count();
            let (now, later) = sums.split_at_mut(1 + shared);
            match shared {
                4 => add_octaves::<S, 5>(simd, now, x, *m, starts),
                3 => add_octaves::<S, 4>(simd, now, x, *m, starts),
                2 => add_octaves::<S, 3>(simd, now, x, *m, starts),
                1 => add_octaves::<S, 2>(simd, now, x, *m, starts),
                _ => add_octaves::<S, 1>(simd, now, x, *m, within(*m)),
            }
            sums = later;
            shifts = &others[shared..];
        }
    }
}

/// Adds Σ (x_{i+2s} − 2 x_{i+s} + x_i)² over i < `starts` for the shifts s = m, 2m, … of so many octaves.
#[inline(always)]
fn add_octaves<S: pulp::Simd, const N: usize>(
    simd: S,
    sums: &mut [f64],
    x: &[f64],
    m: usize,
    starts: usize,
) {
    if starts == 0 {
        return;
    }
    let (here, rest) = S::as_simd_f64s(&x[..starts]);
    let mut shifted = [here; OCTAVES + 1];
    for (k, points) in shifted.iter_mut().take(N + 1).enumerate() {
        *points = &S::as_simd_f64s(&x[m << k..(m << k) + starts]).0[..here.len()];
    }
    let minus_two = simd.splat_f64s(-2.0);
    let mut squares = [simd.splat_f64s(0.0); N];
    for i in 0..here.len() {
        let first = here[i];
        let mut points = [first; OCTAVES + 1];
        for (point, points) in points.iter_mut().zip(shifted) {
            *point = points[i];
        }
        for k in 0..N {
            let outer = simd.add_f64s(first, points[k + 1]);
            let d = simd.mul_add_e_f64s(minus_two, points[k], outer);
            squares[k] = simd.mul_add_e_f64s(d, d, squares[k]);
        }
    }
    for k in 0..N {
        sums[k] += simd.reduce_sum_f64s(squares[k]);
        let shift = m << k;
        for i in starts - rest.len()..starts {
            add_square(&mut sums[k], x[i], x[i + shift], x[i + 2 * shift]);
        }
    }
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
    (
        scaled(whole(x, &[m], &Steps::unwatched())[0], terms, m),
        terms,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoiseRecord;

    /// Every way of reading gives the sum of the definition, to the rounding of the running sums.
    #[test]
    fn law_every_reading_is_the_definition() {
        // Several tasks and windows, an unfinished tall block, an unfinished row, an unfinished step.
        let rate: Vec<f64> = (0..600_005_u64)
            .map(|k| (k * k % 1013) as f64 * 1e-3 - 3.0 + 1e-6 * k as f64)
            .collect();
        let record = NoiseRecord::Rate(&rate);
        let known = Phase::new(record, 1.0).unwrap();
        let x = known.to_vec();
        let octaves: Vec<usize> = (0..17).map(|k| 1 << k).chain([245_760]).collect();
        let decades = vec![1, 7, 1000, 9000, 20_000, 300_002];
        let odd = vec![3, 8191, 8193, 34_999];
        for factors in [
            octaves,
            decades,
            odd,
            vec![16_384],
            vec![8192],
            vec![32_768],
        ] {
            let expected: Vec<f64> = factors
                .iter()
                .map(|&m| {
                    let sum: f64 = (0..x.len() - 2 * m)
                        .map(|i| (x[i + 2 * m] - 2.0 * x[i + m] + x[i]).powi(2))
                        .sum();
                    sum / (2.0 * (m * m) as f64 * (x.len() - 2 * m) as f64)
                })
                .collect();
            let unread = Phase::unread(record, 1.0).unwrap();
            for phase in [&known, &unread] {
                let family = overlapping_family(phase, &factors, &Steps::unwatched());
                for ((&m, (found, terms)), expected) in factors.iter().zip(family).zip(&expected) {
                    assert_eq!(terms, x.len() - 2 * m);
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "m = {m}: {found:e}, {expected:e}"
                    );
                }
            }
            // The points that were met on the way are those of the record, but for the mean.
            assert!(unread.check_finite().is_ok());
            let met = unread.to_vec();
            let slope = (met[x.len() - 1] - x[x.len() - 1]) / rate.len() as f64;
            for (i, (a, b)) in met.iter().zip(&x).enumerate() {
                assert!((a - b - slope * i as f64).abs() < 1e-6, "{i}: {a}, {b}");
            }
        }
    }

    /// A sample that is not finite is told wherever it lies.
    #[test]
    fn error_a_sample_that_is_not_finite() {
        for place in [0, 1, 63, 64, 262_144, 262_207, 299_999, 300_030] {
            let mut rate = vec![1.0; 300_031];
            rate[place] = f64::NAN;
            let phase = Phase::unread(NoiseRecord::Rate(&rate), 1.0).unwrap();
            overlapping_family(&phase, &[1, 2, 4, 65_536], &Steps::unwatched());
            let refused = phase.check_finite().unwrap_err();
            assert!(matches!(
                refused,
                proofmass_core::Error::NotFinite { index, .. } if index == place
            ));
        }
    }
}
