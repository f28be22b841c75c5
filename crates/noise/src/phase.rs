//! The phase of a record: running sums of its rate, computed where they are needed.

use crate::record::{NoiseRecord, check_count, check_finite, check_sample_rate};
use proofmass_core::Error;
use rayon::prelude::*;

/// Rate samples from one kept value of the phase to the next.
const STEP: usize = 64;

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
        /// The first sample, taken off every other before anything is summed.
        first: f64,
        /// Mean of what is left.
        mean: f64,
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
                if let Source::Rate { mean, .. } = phase.source
                    && !mean.is_finite()
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
        let sums: Vec<f64> = rate
            .par_chunks(TASK * STEP)
            .flat_map_iter(|part| part.chunks(STEP).map(|step| sum_beyond(step, first)))
            .collect();
        let mean = sums.iter().sum::<f64>() / rate.len() as f64;
        let mut x = 0.0;
        let kept = std::iter::once(0.0)
            .chain(sums.iter().map(|sum| {
                x += sum - STEP as f64 * mean;
                x
            }))
            // The last sum may be one of fewer samples; no point lies behind it.
            .take(rate.len() / STEP + 1)
            .collect();
        Self {
            points: rate.len() + 1,
            source: Source::Rate {
                rate,
                first,
                mean,
                kept,
            },
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
            Source::Rate {
                rate,
                first,
                mean,
                kept,
            } => {
                let level = |y: f64| (y - first) - mean;
                let mut at = start;
                let mut rest = out;
                // Up to the next kept point, from the one before.
                if !at.is_multiple_of(STEP) && !rest.is_empty() {
                    let from = at / STEP * STEP;
                    let mut x = kept[at / STEP];
                    for y in &rate[from..at] {
                        x += level(*y);
                    }
                    let count = (STEP - at % STEP).min(rest.len());
                    let (part, tail) = rest.split_at_mut(count);
                    for (k, point) in part.iter_mut().enumerate() {
                        *point = x;
                        x += rate.get(at + k).map_or(0.0, |y| level(*y));
                    }
                    at += count;
                    rest = tail;
                }
                // Four steps side by side: each sum waits for itself only.
                while rest.len() >= 4 * STEP && at + 4 * STEP <= rate.len() {
                    let (part, tail) = rest.split_at_mut(4 * STEP);
                    let samples = &rate[at..at + 4 * STEP];
                    let mut x: [f64; 4] = std::array::from_fn(|s| kept[at / STEP + s]);
                    let (a, b) = part.split_at_mut(2 * STEP);
                    let (p, q) = a.split_at_mut(STEP);
                    let (r, s) = b.split_at_mut(STEP);
                    for k in 0..STEP {
                        p[k] = x[0];
                        q[k] = x[1];
                        r[k] = x[2];
                        s[k] = x[3];
                        x[0] += level(samples[k]);
                        x[1] += level(samples[STEP + k]);
                        x[2] += level(samples[2 * STEP + k]);
                        x[3] += level(samples[3 * STEP + k]);
                    }
                    at += 4 * STEP;
                    rest = tail;
                }
                while !rest.is_empty() {
                    let count = STEP.min(rest.len());
                    let (part, tail) = rest.split_at_mut(count);
                    let mut x = kept[at / STEP];
                    for (k, point) in part.iter_mut().enumerate() {
                        *point = x;
                        x += rate.get(at + k).map_or(0.0, |y| level(*y));
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
            let mut all = vec![0.0; (count.max(1) - 1) * stride + 1];
            self.fill(first, &mut all);
            return all.into_iter().step_by(stride).collect();
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
