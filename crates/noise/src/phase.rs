//! The phase of a record: running sums of its rate, computed where they are needed.

use crate::record::{NoiseRecord, check_count, check_finite, check_sample_rate};
use proofmass_core::Error;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Rate samples from one kept value of the phase to the next.
pub(crate) const STEP: usize = 64;

/// Kept steps that one task sums up; fixed, so that the order of summation does not depend on the threads.
const TASK: usize = 1024;

/// Samples whose mean serves where any near the mean of all does.
const SOME: usize = 1 << 14;

/// Phase of a record in units of U·τ0, one point more than there are rate samples.
///
/// x_0 = 0, x_{k+1} = x_k + (y_k − ȳ): the mean rate is removed, and the phase stays small, so that the second differences of 10⁷
/// samples keep some ten digits.
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
        kept: OnceLock<Kept>,
    },
    Phase {
        phase: &'a [f64],
        scale: f64,
    },
}

/// What is remembered of a phase.
pub(crate) struct Kept {
    /// Every 64th point.
    pub(crate) points: Vec<f64>,
    /// The last point, which is finite where all are.
    pub(crate) last: f64,
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
                let first = rate[0];
                let sums = step_sums(rate, first);
                // Sums are beyond the first sample, points beyond the level: what rounds it is the same in both.
                let level = first + sums.iter().sum::<f64>() / rate.len() as f64;
                let phase = Self::beyond(rate, level);
                phase.keep(Kept::of(sums, level - first, rate.len()));
                phase.check_finite()?;
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

    /// Phase of a record that is not yet read, for statistics that see second differences alone and read it anyway.
    ///
    /// The mean that is taken off is that of some samples. Whoever asks for it says afterwards that the record is finite:
    /// [`Phase::check_finite`].
    ///
    /// # Errors
    /// Those of [`Phase::new`], but for samples of a rate that are not finite.
    pub(crate) fn unread(record: NoiseRecord<'a>, sample_rate: f64) -> Result<Self, Error> {
        check_sample_rate(sample_rate)?;
        let NoiseRecord::Rate(rate) = record else {
            return Self::new(record, sample_rate);
        };
        check_count("rate samples", rate.len(), 2)?;
        let some = || rate.iter().step_by(rate.len().div_ceil(SOME));
        let sum: f64 = some().map(|y| y - rate[0]).sum();
        Ok(Self::beyond(rate, rate[0] + sum / some().count() as f64))
    }

    fn beyond(rate: &'a [f64], level: f64) -> Self {
        Self {
            points: rate.len() + 1,
            source: Source::Rate {
                rate,
                level,
                kept: OnceLock::new(),
            },
        }
    }

    /// Whether every sample is finite.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the index of the first that is not.
    pub(crate) fn check_finite(&self) -> Result<(), Error> {
        match &self.source {
            Source::Rate { rate, .. } if !self.kept().is_some_and(|k| k.last.is_finite()) => {
                check_finite("rate", rate)
            }
            _ => Ok(()),
        }
    }

    /// Remembers the points, if they are not yet known.
    pub(crate) fn keep(&self, found: Kept) {
        if let Source::Rate { kept, .. } = &self.source {
            // Whoever was first found the same.
            let _ = kept.set(found);
        }
    }

    /// Whether the record is yet to be read.
    pub(crate) fn is_unread(&self) -> bool {
        matches!(&self.source, Source::Rate { kept, .. } if kept.get().is_none())
    }

    /// Every 64th point of rate data, read for it if nobody has.
    pub(crate) fn kept(&self) -> Option<&Kept> {
        match &self.source {
            Source::Rate { rate, level, kept } => kept.get().or_else(|| {
                // Before it is locked: a thread that waits for a part of the sums may be given work that asks for them.
                let found = Kept::of(step_sums(rate, *level), 0.0, rate.len());
                Some(kept.get_or_init(|| found))
            }),
            Source::Phase { .. } => None,
        }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.points
    }

    /// The points from `start` on, as many as there is room for.
    pub(crate) fn fill(&self, start: usize, out: &mut [f64]) {
        if out.is_empty() {
            return;
        }
        match &self.source {
            Source::Phase { phase, scale } => {
                let origin = phase[0];
                for (x, p) in out.iter_mut().zip(&phase[start..]) {
                    *x = (p - origin) * scale;
                }
            }
            Source::Rate { rate, level, .. } => {
                let kept = self.kept().map_or(0.0, |k| k.points[start / STEP]);
                let from = start / STEP * STEP;
                let x = rate[from..start].iter().fold(kept, |x, y| x + (y - level));
                self.continue_from(x, start, out);
            }
        }
    }

    /// The points from `start` on, whose value is `x`; returns that of the point behind them, or of the last. Phase data have their own values.
    pub(crate) fn continue_from(&self, x: f64, start: usize, out: &mut [f64]) -> f64 {
        if out.is_empty() {
            return x;
        }
        match &self.source {
            Source::Phase { .. } => {
                self.fill(start, out);
                x
            }
            Source::Rate { rate, level, .. } => pulp::Arch::new().dispatch(RunningSum {
                x,
                rate: &rate[start..],
                level: *level,
                out,
            }),
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

impl Kept {
    /// From the sums of all steps beyond a level that lies this far below the mean.
    fn of(mut sums: Vec<f64>, mean: f64, samples: usize) -> Self {
        let mut x = 0.0;
        for point in &mut sums {
            let sum = *point;
            *point = x;
            x += sum - STEP as f64 * mean;
        }
        // The last step has fewer samples than the others, or none.
        let missing = sums.len() * STEP - samples;
        Self {
            points: sums,
            last: x + missing as f64 * mean,
        }
    }
}

/// Sums of the samples of every step beyond a level, and of what is left behind the last whole one.
fn step_sums(rate: &[f64], level: f64) -> Vec<f64> {
    let mut sums = vec![0.0; rate.len() / STEP + 1];
    sums.par_chunks_mut(TASK)
        .zip(rate.par_chunks(TASK * STEP))
        .for_each(|(sums, samples)| {
            for (sum, step) in sums.iter_mut().zip(samples.chunks(STEP)) {
                *sum = sum_beyond(step, level);
            }
        });
    sums
}

/// Points one after the other, from the first on; there may be one point more than samples.
struct RunningSum<'a> {
    x: f64,
    rate: &'a [f64],
    level: f64,
    out: &'a mut [f64],
}

impl pulp::WithSimd for RunningSum<'_> {
    /// The point behind, or the last where no sample leads to one behind.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> f64 {
        let whole = self.out.len().min(self.rate.len()) / S::F64_LANES * S::F64_LANES;
        let level = simd.splat_f64s(self.level);
        let behind = behind(simd);
        let mut x = simd.splat_f64s(self.x);
        let (points, rest) = self.out.split_at_mut(whole);
        let (samples, rate) = self.rate.split_at(whole);
        let (points, samples) = (S::as_mut_simd_f64s(points).0, S::as_simd_f64s(samples).0);
        // Eight registers in one turn of the loop: more samples are on their way from memory.
        let (groups, points) = points.as_chunks_mut::<8>();
        let (taken, samples) = samples.as_chunks::<8>();
        for (points, samples) in groups.iter_mut().zip(taken) {
            for k in 0..8 {
                let beyond = simd.sub_f64s(samples[k], level);
                (points[k], x) = running_sums(simd, x, beyond, behind);
            }
        }
        for (point, sample) in points.iter_mut().zip(samples) {
            let beyond = simd.sub_f64s(*sample, level);
            (*point, x) = running_sums(simd, x, beyond, behind);
        }
        let mut x = first(x);
        for (k, point) in rest.iter_mut().enumerate() {
            *point = x;
            x += rate.get(k).map_or(0.0, |y| y - self.level);
        }
        x
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

/// Points of these steps from the first, `x`, on, and the one behind them in all places.
#[inline(always)]
fn running_sums<S: pulp::Simd>(
    simd: S,
    x: S::f64s,
    steps: S::f64s,
    behind: [S::m64s; DOUBLINGS],
) -> (S::f64s, S::f64s) {
    let before = sums_before(simd, steps, behind);
    let all = simd.add_f64s(before, steps);
    (simd.add_f64s(x, before), simd.add_f64s(x, last(simd, all)))
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

#[inline(always)]
fn first<T: pulp::bytemuck::Pod>(values: T) -> f64 {
    pulp::bytemuck::cast_slice(std::slice::from_ref(&values))[0]
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

    /// Registers of one, four and eight places give the same points, to the rounding of a sum, and the same point behind them.
    #[test]
    fn law_any_register_gives_the_running_sum() {
        use pulp::WithSimd;
        let rate: Vec<f64> = (0..83).map(|k| f64::from(k * 31 % 17) - 7.9).collect();
        for (samples, points) in [(83, 84), (83, 80), (8, 9), (3, 4), (64, 64)] {
            let rate = &rate[..samples];
            let run = |how: &dyn Fn(RunningSum<'_>) -> f64| {
                let mut out = vec![f64::NAN; points];
                let behind = how(RunningSum {
                    x: 0.25,
                    rate,
                    level: 0.1,
                    out: &mut out,
                });
                out.push(behind);
                out
            };
            let mut plain = vec![0.25];
            for k in 0..points {
                plain.push(plain[k] + rate.get(k).map_or(0.0, |y| y - 0.1));
            }
            let mut found = vec![
                run(&|sum| sum.with_simd(pulp::Scalar::new())),
                run(&|sum| pulp::Arch::new().dispatch(sum)),
            ];
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = pulp::x86::V3::try_new() {
                found.push(run(&|sum| pulp::Simd::vectorize(simd, sum)));
            }
            for (one, plain) in found.iter().flat_map(|f| f.iter().zip(&plain)) {
                assert!((one - plain).abs() < 1e-12, "{one}, {plain}");
            }
        }
    }

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
