//! When the samples were taken: a checked time column or a stated rate.

use crate::clock::{Backward, Clock, ClockEstimator, Gap};
use crate::stamp::Stamp;
use crate::{Error, ErrorKind, Result, clock_findings};
use proofmass_uncertainty::DecimalMark;
use proofmass_uncertainty::Finding;

/// Beyond so many seconds a recording counts its times from its first stamp: a double then tells less than
/// 2·10⁻¹¹ s, which stamps since 1970 would not leave it.
const FAR: f64 = crate::time_window::FAR;

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
/// Times count from the zero of the time column, unless its first stamp lies beyond 10⁵ s, as stamps since 1970 do:
/// then they count from that stamp, and [`TimeBase::origin`] is it. Differences are exact in either case.
///
/// **Units** seconds and hertz.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeBase {
    source: TimeSource,
    samples: usize,
    rate: f64,
    clock: Option<Clock>,
    gaps: Vec<Gap>,
    origin: Stamp,
    per_second: f64,
    findings: Vec<Finding>,
}

const ZERO: Stamp = Stamp {
    parts: 0,
    decimals: 0,
    dated: false,
};

impl TimeBase {
    /// Equal steps at a stated rate.
    ///
    /// # Errors
    /// A rate that is not positive and finite.
    pub fn uniform(rate_hz: f64, samples: usize) -> Result<Self> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(Error::new(
                ErrorKind::Time,
                format!("a sampling rate of {rate_hz} Hz is out of range: it must be positive"),
            )
            .with_hint("give the number of samples per second with --rate (`sampling_rate_Hz` in a campaign)"));
        }
        Ok(Self {
            source: TimeSource::Uniform,
            samples,
            rate: rate_hz,
            clock: None,
            gaps: Vec::new(),
            origin: ZERO,
            per_second: 1.0,
            findings: Vec::new(),
        })
    }

    /// From times in seconds; `line` tells the line of a sample for messages.
    ///
    /// # Errors
    /// Fewer than two times; one that is not finite, repeats or runs backwards.
    pub fn from_seconds(seconds: &[f64], line: impl Fn(usize) -> u64) -> Result<Self> {
        let stamps = seconds
            .iter()
            .enumerate()
            .map(|(i, t)| {
                Stamp::of(*t).ok_or_else(|| {
                    Error::new(ErrorKind::Time, format!("{t} s is no time")).line(line(i))
                })
            })
            .collect::<Result<Vec<Stamp>>>()?;
        Self::from_stamps(&stamps, 1.0, line)
    }

    /// From stamps in units of which `per_second` make a second; `line` tells the line of a sample for messages.
    ///
    /// The rate is that of the straight line through the stamps, gaps left out ([`Clock`]). A counter that began
    /// again is undone. Where stamps repeat because they are coarser than the sampling or come in bursts, the times
    /// are those of the line; otherwise they are the stamps. Gaps are reported, not refused.
    ///
    /// # Errors
    /// Fewer than two stamps; one that runs backwards, or repeats as a doubled row does.
    pub fn from_stamps(
        stamps: &[Stamp],
        per_second: f64,
        line: impl Fn(usize) -> u64,
    ) -> Result<Self> {
        let mut builder = TimeBaseBuilder::new(per_second, false);
        for (i, stamp) in stamps.iter().enumerate() {
            builder.push(*stamp, line(i));
        }
        builder.finish()
    }

    /// Where the times come from.
    pub fn source(&self) -> &TimeSource {
        &self.source
    }

    /// Sampling rate, Hz: stated, or that of the clock line.
    pub fn rate_hz(&self) -> f64 {
        self.rate
    }

    /// What the stamps tell about their clock; `None` for a stated rate.
    pub fn clock(&self) -> Option<&Clock> {
        self.clock.as_ref()
    }

    /// Standard deviation of the steps, gaps left out, s; `None` for a stated rate.
    pub fn jitter_s(&self) -> Option<f64> {
        self.clock.and_then(|c| c.jitter_s)
    }

    /// Places where samples are missing.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// What is doubtful about the times: gaps, coarse stamps, bursts, counters that began again.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The stamp that is time zero, in units of the time column: 0, or the first stamp where it lies far from 0.
    pub fn origin(&self) -> Stamp {
        self.origin
    }

    /// Seconds from the zero of another recording by the same clock to the zero of this one, exactly.
    pub fn offset_s(&self, other: &Self) -> f64 {
        if self.per_second == other.per_second {
            self.origin.since(other.origin) / self.per_second
        } else {
            self.origin.value() / self.per_second - other.origin.value() / other.per_second
        }
    }

    /// The time of this recording at a stamp written in seconds in the scale of its time column, exactly.
    pub fn at(&self, field: &str, decimal: DecimalMark) -> Option<f64> {
        let stamp = Stamp::parse(field.as_bytes(), decimal)?;
        if self.per_second == 1.0 {
            return Some(stamp.since(self.origin));
        }
        if self.per_second < 1.0 {
            return Some(stamp.value() - self.origin.value() / self.per_second);
        }
        let scale = self.per_second.round() as i128;
        let scaled = Stamp {
            parts: stamp.parts.checked_mul(scale)?,
            ..stamp
        };
        Some(scaled.since(self.origin) / self.per_second)
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

    /// From the first to the last sample, one step added: n/f for a recording without gaps, s.
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

/// Takes the stamps of a recording one by one.
pub(crate) struct TimeBaseBuilder {
    estimator: ClockEstimator,
    per_second: f64,
    events: bool,
    origin: Stamp,
    seconds: Vec<f64>,
    repeated: Option<(u64, f64)>,
}

impl TimeBaseBuilder {
    /// For stamps in units of which so many make a second; `events` come when they come and have no rate.
    pub(crate) fn new(per_second: f64, events: bool) -> Self {
        Self {
            estimator: ClockEstimator::new(per_second).keep_all_gaps(),
            per_second,
            events,
            origin: ZERO,
            seconds: Vec::new(),
            repeated: None,
        }
    }

    /// Whether stamps that cross their neighbours are jitter.
    pub(crate) fn with_late_stamps(self, late_stamps: bool) -> Self {
        Self {
            estimator: self.estimator.with_late_stamps(late_stamps),
            ..self
        }
    }

    /// The stamp that is time zero, where rows before the first one were left out.
    pub(crate) fn with_origin(self, origin: Option<Stamp>) -> Self {
        Self {
            origin: origin.unwrap_or(self.origin),
            ..self
        }
    }

    pub(crate) fn push(&mut self, stamp: Stamp, line: u64) {
        if self.seconds.is_empty()
            && self.origin == ZERO
            && (stamp.value() / self.per_second).abs() >= FAR
        {
            self.origin = stamp;
        }
        let stamp = self.estimator.add(self.seconds.len(), line, stamp);
        let t = stamp.since(self.origin) / self.per_second;
        if self.repeated.is_none() && self.seconds.last() == Some(&t) {
            self.repeated = Some((line, stamp.value() / self.per_second));
        }
        self.seconds.push(t);
    }

    pub(crate) fn finish(mut self) -> Result<TimeBase> {
        let samples = self.seconds.len();
        if samples < 2 {
            return Err(Error::new(
                ErrorKind::Time,
                format!("{samples} samples give no time step"),
            )
            .with_hint("a recording needs at least two rows"));
        }
        let repeats = self.estimator.may_repeat();
        let clock = self.estimator.finish();
        if let Some((line, what)) = self.estimator.backward.first() {
            return Err(backward(*what).line(*line));
        }
        let (clock, events) = match (clock, self.repeated) {
            (Some(clock), None) => (clock, self.events),
            // The line through stamps that repeat is that of samples, not of events.
            // Without repeats two stamps differ by less than seconds so far from zero can tell.
            (Some(clock), Some(_)) if !self.events && (repeats || self.estimator.crossed()) => {
                (clock, false)
            }
            (None, _) if samples > 2 && self.seconds.iter().all(|t| *t == self.seconds[0]) => {
                return Err(Error::new(
                    ErrorKind::Time,
                    format!("the clock stands still: all {samples} times are the same"),
                )
                .with_hint("name another column with --time, or give --rate HZ (`sampling_rate_Hz` in a campaign) in place of the times"));
            }
            (_, at) => {
                let (line, at_s) = at.unwrap_or((0, self.seconds[0]));
                return Err(backward(Backward::Repeats { at_s }).line(line));
            }
        };
        let mut base = TimeBase {
            samples,
            source: TimeSource::Uniform,
            rate: clock.rate_hz,
            clock: None,
            gaps: Vec::new(),
            origin: self.origin,
            per_second: self.per_second,
            findings: Vec::new(),
        };
        if events {
            base.rate = (samples - 1) as f64 / (self.seconds[samples - 1] - self.seconds[0]);
            base.findings = clock_findings::of(&clock, self.estimator.wraps(), &[], false);
            base.findings
                .retain(|f| f.code() == clock_findings::WRAPPED);
        } else {
            base.gaps = std::mem::take(&mut self.estimator.gaps);
            for gap in &mut base.gaps {
                gap.at_s = self.seconds[gap.after_sample];
            }
            if repeats {
                along_the_line(&mut self.seconds, &base.gaps, 1.0 / clock.rate_hz);
            }
            base.findings = clock_findings::of(&clock, self.estimator.wraps(), &base.gaps, repeats);
            base.clock = Some(clock);
        }
        base.source = TimeSource::Column(self.seconds);
        Ok(base)
    }
}

/// Puts the samples of every stretch without a gap on their line: mean of the stamps, slope of the clock.
fn along_the_line(seconds: &mut [f64], gaps: &[Gap], period: f64) {
    let mut start = 0;
    let ends = gaps.iter().map(|g| g.after_sample + 1);
    for end in ends.chain([seconds.len()]) {
        let stretch = &mut seconds[start..end];
        let n = stretch.len() as f64;
        let first = stretch.first().copied().unwrap_or(0.0);
        let mean = stretch.iter().map(|t| t - first).sum::<f64>() / n;
        let begin = first + mean - 0.5 * (n - 1.0) * period;
        for (k, t) in stretch.iter_mut().enumerate() {
            *t = begin + k as f64 * period;
        }
        start = end;
    }
    // Two lines that meet in a gap may cross by less than their scatter.
    for i in 1..seconds.len() {
        if seconds[i] <= seconds[i - 1] {
            seconds[i] = seconds[i - 1].next_up();
        }
    }
}

/// What is wrong with a clock that shows an earlier time than before.
pub fn backwards(from_s: f64, to_s: f64) -> String {
    match to_s - from_s {
        // A clock that is put back for the winter leaves an hour less a sample.
        step if (step + 3600.0).abs() < 5.0 => format!(
            "the clock was put back by an hour, from {from_s} s to {to_s} s: the end of summer time"
        ),
        step if (step + 86_400.0).abs() < 60.0 => format!(
            "the times of day pass midnight, from {from_s} s to {to_s} s, and no date tells the day"
        ),
        _ => format!("the time runs backwards, from {from_s} s to {to_s} s"),
    }
}

/// Why a stamp is refused.
pub(crate) fn backward(what: Backward) -> Error {
    let (what, hint) = match what {
        Backward::Repeats { at_s } => (
            format!("the time {at_s} s repeats the one before"),
            "remove the doubled row, export the time with more digits, or give --rate HZ (`sampling_rate_Hz` in a campaign) instead of a time column",
        ),
        Backward::Runs { from_s, to_s } => (
            backwards(from_s, to_s),
            "look for a restart or a correction of the clock, or two recordings in one file, and read one part with --between FROM TO; or give --rate HZ (`sampling_rate_Hz` in a campaign) instead of a time column",
        ),
    };
    Error::new(ErrorKind::Time, what).with_hint(hint)
}
