//! Samples of one sensor before they share a clock with another.

use crate::{MotionRecord, ReadingSource, interval, leave_out_threshold, speed_increment, thin};
use proofmass_core::Error;
use proofmass_uncertainty::Finding;
use std::ops::Range;

/// Values with their times, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Times, s.
    pub time: Vec<f64>,
    /// Values.
    pub value: Vec<f64>,
}

impl Samples {
    /// The rows in which no column lacks its value.
    pub fn present(clock: &[f64], value: &[f64], missing: &[&[usize]]) -> Self {
        let mut there = vec![true; value.len()];
        for &k in missing.iter().copied().flatten() {
            there[k] = false;
        }
        let kept = |v: &[f64]| -> Vec<f64> {
            let pairs = v.iter().zip(&there).filter(|(_, there)| **there);
            pairs.map(|(v, _)| *v).collect()
        };
        Self {
            time: kept(clock),
            value: kept(value),
        }
    }

    /// Keeps the samples at these times.
    pub fn keep(&mut self, wanted: impl Fn(f64) -> bool) {
        let pairs = self.time.iter().zip(&self.value);
        (self.time, self.value) = pairs.filter(|(t, _)| wanted(**t)).unzip();
    }

    /// Values at times between two, both included.
    pub fn within(&self, from: f64, to: f64) -> Vec<f64> {
        let pairs = self.time.iter().zip(&self.value);
        let inside = pairs.filter(|(t, _)| **t >= from && **t <= to);
        inside.map(|p| *p.1).collect()
    }

    /// Sampling interval; 0 of a single sample.
    pub fn interval(&self) -> f64 {
        interval(&self.time).unwrap_or(0.0)
    }

    /// Of a speed, keeps one of the rows in which a slower sensor stands several times, and leaves out the zeros below its
    /// threshold; gives back the step of its digits.
    ///
    /// # Errors
    /// Readings that make no record.
    pub fn speed_digits(&mut self, findings: &mut Vec<Finding>) -> Result<Option<f64>, Error> {
        let step = self.interval();
        if self.time.len() > 3 && step > 0.0 {
            let values = self.value.iter().copied().map(Some).collect();
            let nothing = vec![0.0; self.value.len()];
            let mut rows = MotionRecord::new(step, ReadingSource::Speed, values, nothing)?;
            if let Some(finding) = thin(&mut rows) {
                findings.push(finding);
                let (time, value) = self
                    .time
                    .iter()
                    .zip(&rows.reading)
                    .filter_map(|(t, r)| r.map(|r| (*t, r)))
                    .unzip();
                (self.time, self.value) = (time, value);
            }
        }
        let increment = speed_increment(&self.value);
        findings.extend(leave_out_threshold(&mut self.time, &mut self.value));
        Ok(increment)
    }

    /// The values at every sample of an even clock, on straight lines between these, as far as they reach. `None` where that is less
    /// than eight samples, or these are fewer than two.
    pub fn on_lines(&self, start: f64, dt: f64, n: usize) -> Option<OnLines> {
        let time = |k: usize| start + dt * k as f64;
        let (first, last) = (self.time.first()?, self.time.last()?);
        if self.time.len() < 2 {
            return None;
        }
        let slack = 1e-6 * dt;
        let from = (0..n).find(|&k| time(k) >= first - slack).unwrap_or(n);
        let to = (0..n)
            .rev()
            .find(|&k| time(k) <= last + slack)
            .map_or(0, |k| k + 1);
        if from + 8 > to {
            return None;
        }
        let step = self.interval();
        let mut bridged = 0usize;
        let value = (from..to)
            .map(|k| {
                let t = time(k);
                let after = self.time.partition_point(|s| *s < t - slack);
                let after = after.min(self.time.len() - 1);
                if after == 0 || (self.time[after] - t).abs() <= slack {
                    return self.value[after];
                }
                let (a, b) = (self.time[after - 1], self.time[after]);
                bridged += usize::from(b - a > 3.0 * step);
                let share = ((t - a) / (b - a)).clamp(0.0, 1.0);
                self.value[after - 1] * (1.0 - share) + self.value[after] * share
            })
            .collect();
        Some(OnLines {
            used: from..to,
            value,
            step,
            bridged,
        })
    }
}

/// Samples brought to another clock.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OnLines {
    /// Samples of the other clock that are covered.
    pub used: Range<usize>,
    /// The values there.
    pub value: Vec<f64>,
    /// Median distance of the samples they are from, s.
    pub step: f64,
    /// How many lie in a gap of more than three of these distances.
    pub bridged: usize,
}

/// Mean of some of the columns, row by row.
pub fn mean_of(columns: &[Vec<f64>], used: &[usize], rows: usize) -> Vec<f64> {
    let mut mean = vec![0.0; rows];
    for &i in used {
        for (m, v) in mean.iter_mut().zip(&columns[i]) {
            *m += v / used.len() as f64;
        }
    }
    mean
}

/// The first of some times that departs by a fifth of a step from an even clock through the first and the last; the step, where
/// all of them fit. `None` without times.
pub fn even_step(clock: &[f64]) -> Option<Result<f64, usize>> {
    let (first, last) = (clock.first()?, clock.last()?);
    let step = (last - first) / (clock.len().max(2) - 1) as f64;
    let off = |(k, t): (usize, &f64)| (t - first - step * k as f64).abs() > 0.2 * step;
    let uneven = clock.iter().enumerate().find(|x| off(*x));
    Some(uneven.map_or(Ok(step), |(k, _)| Err(k)))
}
