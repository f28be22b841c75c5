//! When the samples were taken: a checked time column or a stated rate.

use crate::{Error, ErrorKind, Result};
use serde::{Deserialize, Serialize};

/// A step longer than this many median steps is a gap.
const GAP: f64 = 1.5;

/// A place where samples are missing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Index of the last sample before the gap.
    pub after_sample: usize,
    /// Line of that sample.
    pub line: u64,
    /// Time of that sample, s.
    pub at_s: f64,
    /// Length of the step, s.
    pub step_s: f64,
}

/// Where the times come from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TimeSource {
    /// One time per sample, s, strictly increasing.
    Column(Vec<f64>),
    /// A stated sampling rate; the first sample is at zero.
    Uniform,
}

/// The times of a recording.
///
/// **Units** seconds and hertz.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeBase {
    source: TimeSource,
    samples: usize,
    rate: f64,
    jitter: Option<f64>,
    gaps: Vec<Gap>,
}

impl TimeBase {
    /// Equal steps at a stated rate.
    ///
    /// # Errors
    /// A rate that is not positive and finite.
    pub fn uniform(rate_hz: f64, samples: usize) -> Result<Self> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(Error::new(
                ErrorKind::Time,
                format!("a sampling rate of {rate_hz} Hz is impossible"),
            )
            .with_hint("give the number of samples per second as `sampling_rate_Hz`"));
        }
        Ok(Self {
            source: TimeSource::Uniform,
            samples,
            rate: rate_hz,
            jitter: None,
            gaps: Vec::new(),
        })
    }

    /// From times in seconds; `line` tells the line of a sample for messages.
    ///
    /// The nominal rate is the inverse of the median step, the jitter the standard deviation of the steps that
    /// are not gaps about it. Gaps are steps of more than 1.5 median steps; they are reported, not refused.
    ///
    /// # Errors
    /// Fewer than two times; a time that repeats or runs backwards.
    pub fn from_seconds(seconds: Vec<f64>, line: impl Fn(usize) -> u64) -> Result<Self> {
        if seconds.len() < 2 {
            return Err(Error::new(
                ErrorKind::Time,
                format!("{} samples give no time step", seconds.len()),
            )
            .with_hint("a recording needs at least two rows"));
        }
        for (i, pair) in seconds.windows(2).enumerate() {
            check_step(pair[0], pair[1]).map_err(|e| e.line(line(i + 1)))?;
        }
        let mut steps: Vec<f64> = seconds.windows(2).map(|w| w[1] - w[0]).collect();
        let median = median(&mut steps);
        let mut jitter = Steps::new(median);
        let mut gaps = Vec::new();
        for (i, pair) in seconds.windows(2).enumerate() {
            if jitter.is_gap(pair[1] - pair[0]) {
                gaps.push(Gap {
                    after_sample: i,
                    line: line(i),
                    at_s: pair[0],
                    step_s: pair[1] - pair[0],
                });
            }
        }
        Ok(Self {
            samples: seconds.len(),
            source: TimeSource::Column(seconds),
            rate: 1.0 / median,
            jitter: jitter.deviation(),
            gaps,
        })
    }

    /// Where the times come from.
    pub fn source(&self) -> &TimeSource {
        &self.source
    }

    /// Nominal sampling rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate
    }

    /// Standard deviation of the steps about their median, gaps left out, s; `None` for a stated rate.
    pub fn jitter_s(&self) -> Option<f64> {
        self.jitter
    }

    /// Places where samples are missing.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// Time of a sample, s.
    ///
    /// # Panics
    /// When a time column has no such sample.
    pub fn seconds(&self, sample: usize) -> f64 {
        match &self.source {
            TimeSource::Column(t) => t[sample],
            TimeSource::Uniform => sample as f64 / self.rate,
        }
    }

    /// From the first to the last sample, one nominal step added: n/f for a recording without gaps, s.
    pub fn duration_s(&self) -> f64 {
        match &self.source {
            TimeSource::Column(t) => t[t.len() - 1] - t[0] + 1.0 / self.rate,
            TimeSource::Uniform => self.samples as f64 / self.rate,
        }
    }

    /// Index of the first sample at or after a time in seconds; the number of samples when there is none.
    pub fn index_at(&self, seconds: f64) -> usize {
        match &self.source {
            TimeSource::Column(t) => t.partition_point(|&x| x < seconds),
            // A billionth of a step: so that 0.3 s at 10 Hz is sample 3 in spite of rounding.
            TimeSource::Uniform => {
                ((seconds * self.rate - 1e-9).ceil().max(0.0) as usize).min(self.samples)
            }
        }
    }
}

/// Refuses a time that does not come after the one before.
pub(crate) fn check_step(before: f64, after: f64) -> Result<()> {
    if after > before {
        return Ok(());
    }
    let same = after == before;
    Err(Error::new(
        ErrorKind::Time,
        if same {
            format!("the time {after} s repeats the one before")
        } else {
            format!("the time runs backwards, from {before} s to {after} s")
        },
    )
    .with_hint(if same {
        "remove the doubled row, export the time with more digits, or give `sampling_rate_Hz` instead of a time column"
    } else {
        "look for a restart of the clock or two recordings in one file, and split it there"
    }))
}

/// Median of a non-empty slice, which it reorders.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    let (below, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        upper
    } else {
        let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (lower + upper)
    }
}

/// Running statistics of time steps about their median.
pub(crate) struct Steps {
    median: f64,
    sum: f64,
    sum2: f64,
    count: u64,
}

impl Steps {
    pub(crate) fn new(median: f64) -> Self {
        Self {
            median,
            sum: 0.0,
            sum2: 0.0,
            count: 0,
        }
    }

    /// Whether the step is a gap; other steps count for the jitter.
    pub(crate) fn is_gap(&mut self, step: f64) -> bool {
        let gap = step > GAP * self.median;
        if !gap {
            let d = step - self.median;
            self.sum += d;
            self.sum2 += d * d;
            self.count += 1;
        }
        gap
    }

    pub(crate) fn deviation(&self) -> Option<f64> {
        let n = self.count as f64;
        (self.count > 1)
            .then(|| ((self.sum2 - self.sum * self.sum / n).max(0.0) / (n - 1.0)).sqrt())
    }
}
