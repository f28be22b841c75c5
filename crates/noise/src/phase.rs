//! The phase of a record: running sums of its rate, computed where they are needed.

use crate::record::{NoiseRecord, check_count, check_finite, check_sample_rate};
use proofmass_core::Error;
use rayon::prelude::*;

/// Rate samples from one kept value of the phase to the next.
pub(crate) const STEP: usize = 64;

/// Kept steps that one task sums up; fixed, so that the order of summation does not depend on the threads.
const TASK: usize = 1024;

/// Phase of a record in units of U·τ0, one point more than there are rate samples.
///
/// x_0 = 0, x_{k+1} = x_k + (y_k − ȳ): the mean rate is removed, which no statistic of this crate sees, and the phase
/// stays small, so that the second differences of 10⁷ samples keep some ten digits.
///
/// Of rate data every 64th point is kept and the others are summed up again at each use: memory for 10⁷ points
/// takes longer to get than to fill, and a statistic that reads a record block by block needs no more than a block.
pub(crate) struct Phase<'a> {
    points: usize,
    source: Source<'a>,
}

enum Source<'a> {
    Rate {
        rate: &'a [f64],
        /// The mean, as taken off every sample.
        level: f64,
        /// Phase at every 64th point.
        kept: Vec<f64>,
    },
    Phase {
        phase: &'a [f64],
        scale: f64,
    },
}

impl<'a> Phase<'a> {
    /// Phase of a record.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the index of the first sample that is NaN or infinite, [`Error::TooFew`] for
    /// fewer than two rate samples (three phase samples), [`Error::OutOfRange`] for a rate that is not positive.
    pub(crate) fn new(record: NoiseRecord<'a>, sample_rate: f64) -> Result<Self, Error> {
        check_sample_rate(sample_rate)?;
        match record {
            NoiseRecord::Rate(rate) => {
                check_count("rate samples", rate.len(), 2)?;
                let phase = Self::of_rate(rate);
                // What is not finite anywhere shows in the sum of all.
                if let Source::Rate { level, .. } = phase.source
                    && !level.is_finite()
                {
                    check_finite("rate", rate)?;
                }
                Ok(phase)
            }
            NoiseRecord::Phase(phase) => {
                check_finite("phase", phase)?;
                check_count("phase samples", phase.len(), 3)?;
                Ok(Self {
                    points: phase.len(),
                    source: Source::Phase {
                        phase,
                        scale: sample_rate,
                    },
                })
            }
        }
    }

    fn of_rate(rate: &'a [f64]) -> Self {
        let first = rate[0];
        // The sum of every step, then the phase before it.
        let mut kept = vec![0.0; rate.len() / STEP + 1];
        kept.par_chunks_mut(TASK)
            .zip(rate.par_chunks(TASK * STEP))
            .for_each(|(sums, samples)| {
                for (sum, step) in sums.iter_mut().zip(samples.chunks(STEP)) {
                    *sum = sum_beyond(step, first);
                }
            });
        // Sums are beyond the first sample, points beyond the level: what rounds it is the same in both.
        let level = first + kept.iter().sum::<f64>() / rate.len() as f64;
        let mean = level - first;
        let mut x = 0.0;
        for point in &mut kept {
            let sum = *point;
            *point = x;
            x += sum - STEP as f64 * mean;
        }
        Self {
            points: rate.len() + 1,
            source: Source::Rate { rate, level, kept },
        }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.points
    }

    /// The points from `start` on, as many as there is room for.
    pub(crate) fn fill(&self, start: usize, out: &mut [f64]) {
        match &self.source {
            Source::Phase { phase, scale } => {
                let origin = phase[0];
                for (x, p) in out.iter_mut().zip(&phase[start..]) {
                    *x = (p - origin) * scale;
                }
            }
            Source::Rate { rate, level, kept } => {
                let beyond = |y: f64| y - level;
                let mut at = start;
                let mut rest = out;
                // Up to the next kept point, from the one before.
                if !at.is_multiple_of(STEP) && !rest.is_empty() {
                    let from = at / STEP * STEP;
                    let mut x = kept[at / STEP];
                    for y in &rate[from..at] {
                        x += beyond(*y);
                    }
                    let count = (STEP - at % STEP).min(rest.len());
                    let (part, tail) = rest.split_at_mut(count);
                    for (k, point) in part.iter_mut().enumerate() {
                        *point = x;
                        x += rate.get(at + k).map_or(0.0, |y| beyond(*y));
                    }
                    at += count;
                    rest = tail;
                }
                let steps = (rest.len() / STEP).min((rate.len() - at.min(rate.len())) / STEP);
                let (part, tail) = rest.split_at_mut(steps * STEP);
                pulp::Arch::new().dispatch(FillSteps {
                    kept: &kept[at / STEP..],
                    rate: &rate[at.min(rate.len())..],
                    level: *level,
                    out: part,
                });
                at += steps * STEP;
                rest = tail;
                while !rest.is_empty() {
                    let count = STEP.min(rest.len());
                    let (part, tail) = rest.split_at_mut(count);
                    let mut x = kept[at / STEP];
                    for (k, point) in part.iter_mut().enumerate() {
                        *point = x;
                        x += rate.get(at + k).map_or(0.0, |y| beyond(*y));
                    }
                    at += count;
                    rest = tail;
                }
            }
        }
    }

    /// Every `stride`-th point from `first` on.
    pub(crate) fn thinned(&self, first: usize, stride: usize, count: usize) -> Vec<f64> {
        if stride < STEP {
            let mut points = Vec::with_capacity(count);
            let mut block = [0.0; 64 * STEP];
            while points.len() < count {
                let start = first + points.len() * stride;
                let needed = (count - points.len() - 1) * stride + 1;
                let block = &mut block[..needed.min(64 * STEP)];
                self.fill(start, block);
                points.extend(block.iter().step_by(stride));
            }
            return points;
        }
        let mut point = [0.0];
        (0..count)
            .map(|k| {
                self.fill(first + k * stride, &mut point);
                point[0]
            })
            .collect()
    }

    /// All points.
    pub(crate) fn to_vec(&self) -> Vec<f64> {
        let mut all = vec![0.0; self.points];
        all.par_chunks_mut(TASK * STEP)
            .enumerate()
            .for_each(|(task, part)| self.fill(task * TASK * STEP, part));
        all
    }
}

/// Whole steps of the phase, each from its kept value on.
struct FillSteps<'a> {
    kept: &'a [f64],
    rate: &'a [f64],
    level: f64,
    out: &'a mut [f64],
}

impl pulp::WithSimd for FillSteps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let level = simd.splat_f64s(self.level);
        let behind = behind(simd);
        let (out, _) = self.out.as_chunks_mut::<STEP>();
        let (rate, _) = self.rate.as_chunks::<STEP>();
        for ((points, samples), kept) in out.iter_mut().zip(rate).zip(self.kept) {
            let mut x = simd.splat_f64s(*kept);
            let (points, _) = S::as_mut_simd_f64s(points);
            let (samples, _) = S::as_simd_f64s(samples);
            for (point, sample) in points.iter_mut().zip(samples) {
                let beyond = simd.sub_f64s(*sample, level);
                let before = sums_before(simd, beyond, behind);
                *point = simd.add_f64s(x, before);
                let all = simd.add_f64s(before, beyond);
                x = simd.add_f64s(x, last(simd, all));
            }
        }
    }
}

/// Places of the widest register, halved until one is left.
const DOUBLINGS: usize = 3;

/// Which places lie behind the first, the first two and the first four.
#[inline(always)]
fn behind<S: pulp::Simd>(simd: S) -> [S::m64s; DOUBLINGS] {
    let from = |place| simd.mask_between_m64s(place, S::F64_LANES as u64).mask();
    [from(1), from(2), from(4)]
}

/// In every place of a register the sum of all places before it.
#[inline(always)]
fn sums_before<S: pulp::Simd>(simd: S, values: S::f64s, behind: [S::m64s; DOUBLINGS]) -> S::f64s {
    let zero = simd.splat_f64s(0.0);
    if S::F64_LANES == 1 {
        return zero;
    }
    let mut sums = simd.select_f64s(behind[0], simd.rotate_right_f64s(values, 1), zero);
    for doubling in 0..DOUBLINGS {
        let places = 1 << doubling;
        if places < S::F64_LANES {
            let rotated = simd.rotate_right_f64s(sums, places);
            sums = simd.add_f64s(sums, simd.select_f64s(behind[doubling], rotated, zero));
        }
    }
    sums
}

/// The last place of a register in all places.
#[inline(always)]
fn last<S: pulp::Simd>(simd: S, values: S::f64s) -> S::f64s {
    let places: &[f64] = pulp::bytemuck::cast_slice(std::slice::from_ref(&values));
    simd.splat_f64s(places[S::F64_LANES - 1])
}

/// Sum of the samples beyond a level, in eight interleaved sums: one running sum would wait for every addition.
fn sum_beyond(samples: &[f64], level: f64) -> f64 {
    let (chunks, rest) = samples.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for chunk in chunks {
        for (lane, v) in lanes.iter_mut().zip(chunk) {
            *lane += v - level;
        }
    }
    lanes.iter().sum::<f64>() + rest.iter().map(|v| v - level).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any stretch is the same as that part of the plain running sum, to the rounding of a sum of 64 samples.
    #[test]
    fn law_any_stretch_is_the_running_sum() {
        let rate: Vec<f64> = (0..1000)
            .map(|k| 9.8 + f64::from(k * 7919 % 1009) * 1e-3)
            .collect();
        let mean = rate.iter().sum::<f64>() / 1000.0;
        let mut plain = vec![0.0];
        for y in &rate {
            plain.push(plain[plain.len() - 1] + (y - mean));
        }
        let phase = Phase::new(NoiseRecord::Rate(&rate), 1.0).unwrap();
        assert_eq!(phase.len(), 1001);
        for (start, count) in [
            (0, 1001),
            (1, 1000),
            (63, 70),
            (64, 300),
            (130, 871),
            (1000, 1),
        ] {
            let mut out = vec![f64::NAN; count];
            phase.fill(start, &mut out);
            for (k, x) in out.iter().enumerate() {
                assert!((x - plain[start + k]).abs() < 1e-11, "{start} + {k}");
            }
        }
        assert_eq!(phase.to_vec().len(), 1001);
        let thin = phase.thinned(5, 70, 14);
        assert!((thin[13] - plain[5 + 13 * 70]).abs() < 1e-11);
    }
}
