//! Time stamps exactly as they stand, for the clock behind them: counters that begin again, stamps that repeat or run backwards, lines of gaps.
//!
//! The clock itself, its rate and what is missing, is read by [`proofmass_signal::clock`].

use crate::stamp::{PARTS, Stamp};
use proofmass_signal::clock::{self, RateChange};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Gaps that are kept by a bounded estimator; all are counted.
pub(crate) const LISTED: usize = 100;

/// A place where samples are missing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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

/// What time stamps tell about the clock they came from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Clock {
    /// Sampling rate by the clock line, Hz.
    pub rate_hz: f64,
    /// Standard uncertainty of the rate, Hz: from scatter and resolution of the stamps, not from the error of the
    /// clock itself.
    pub rate_u_hz: f64,
    /// Standard deviation of the steps about the intervals they span, s; `None` below two.
    pub jitter_s: Option<f64>,
    /// Standard deviation of the stamps about the clock line, s.
    pub(crate) scatter_s: f64,
    /// Resolution of the stamps, s: the largest unit of which all steps are multiples; where these are whole sampling
    /// intervals, the last digit written.
    pub resolution_s: f64,
    /// Whether the stamps come in bursts, so that a step says little about the sampling.
    pub(crate) bursts: bool,
    /// How often the counter behind the stamps began again from its lowest value.
    pub(crate) wraps: u64,
    /// Number of gaps.
    pub gaps: u64,
    /// Samples missing in them; more where stamps scatter too much to tell between which rows.
    #[serde(default)]
    pub missing: u64,
    /// Whether rows may be missing without a trace, because stamps wander as those of such a record do: the uncertainty of
    /// the rate holds it.
    #[serde(default)]
    pub untested: bool,
    /// Stamps that lie before the one before.
    #[serde(default)]
    pub crossing: u64,
    /// Steps between neighbouring samples.
    pub steps: u64,
    /// A rate that changes within the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<RateChange>,
}

/// Why a stamp was not accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Backward {
    /// It repeats the one before.
    Repeats { at_s: f64 },
    /// It lies before the one before.
    Runs { from_s: f64, to_s: f64 },
}

/// A wrap of the counter, for the finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wrap {
    pub(crate) line: u64,
    /// Length of one turn, s.
    pub(crate) turn_s: f64,
}

/// Takes stamps one by one and tells the clock at the end.
pub(crate) struct ClockEstimator {
    per_second: f64,
    estimator: clock::ClockEstimator,
    first: Option<Stamp>,
    last: Option<Stamp>,
    rows: usize,
    /// Turns that the counter has made, in parts.
    turned: i128,
    wraps: Vec<Wrap>,
    wrap_count: u64,
    decimals: u8,
    /// Sample, line and time of the rows of which it is open what is missing before them, and of the one before these.
    open: VecDeque<(usize, u64, f64)>,
    pub(crate) gaps: Vec<Gap>,
    all_gaps: bool,
    /// Rows before which samples are missing, and how many, where they are kept.
    pub(crate) missing: Option<Vec<(u64, u64)>>,
    /// Stamps that repeat, which may be the nature of the clock.
    repeated: Vec<(u64, Backward)>,
    pub(crate) backward: Vec<(u64, Backward)>,
    /// Whether a stamp may lie before the one before it by less than two intervals.
    late_stamps: bool,
    /// Whether one did.
    crossed: bool,
}

impl ClockEstimator {
    /// For stamps in units of which so many make a second.
    pub(crate) fn new(per_second: f64) -> Self {
        Self {
            per_second,
            estimator: clock::ClockEstimator::new(),
            first: None,
            last: None,
            rows: 0,
            turned: 0,
            wraps: Vec::new(),
            wrap_count: 0,
            decimals: 0,
            open: VecDeque::new(),
            gaps: Vec::new(),
            all_gaps: false,
            missing: None,
            repeated: Vec::new(),
            backward: Vec::new(),
            late_stamps: false,
            crossed: false,
        }
    }

    /// Whether stamps that cross their neighbours are jitter.
    pub(crate) fn with_late_stamps(self, late_stamps: bool) -> Self {
        Self {
            late_stamps,
            ..self
        }
    }

    /// Keeps every gap, for a recording that is in memory anyway.
    pub(crate) fn keep_all_gaps(mut self) -> Self {
        self.all_gaps = true;
        self
    }

    /// Keeps where every missing sample belongs, sixteen bytes for each gap.
    pub(crate) fn keep_missing(mut self) -> Self {
        self.missing = Some(Vec::new());
        self
    }

    /// Parts to seconds.
    fn seconds(&self, parts: i128) -> f64 {
        let stamp = Stamp {
            parts,
            decimals: self.decimals,
            dated: false,
        };
        stamp.value() / self.per_second
    }

    /// Takes the stamp of a sample and returns it with wraps undone.
    pub(crate) fn add(&mut self, sample: usize, line: u64, stamp: Stamp) -> Stamp {
        if stamp.decimals > self.decimals || self.rows == 0 {
            self.decimals = self.decimals.max(stamp.decimals);
            let digit = 10_i128.pow(15 - u32::from(self.decimals.min(15)));
            self.estimator.set_digit(self.seconds(digit));
        }
        let mut stamp = Stamp {
            parts: stamp.parts + self.turned,
            ..stamp
        };
        if let Some(last) = self.last {
            if stamp.parts < last.parts
                && let Some(turn) = self.turn(stamp, last)
            {
                self.turned += turn;
                stamp.parts += turn;
                self.wrap_count += 1;
                if self.wraps.len() < LISTED {
                    let turn_s = self.seconds(turn);
                    self.wraps.push(Wrap { line, turn_s });
                }
            }
            self.look_back(line, stamp, last);
        }
        self.last = Some(stamp);
        let first = *self.first.get_or_insert(stamp);
        let at = self.seconds(stamp.parts - first.parts);
        self.open.push_back((sample, line, at));
        self.rows += 1;
        self.estimator.push(at);
        self.list_gaps();
        stamp
    }

    /// Tells of a stamp that is not later than the one before.
    fn look_back(&mut self, line: u64, stamp: Stamp, last: Stamp) {
        let parts = stamp.parts - last.parts;
        if parts > 0 {
            return;
        }
        let to_s = stamp.value() / self.per_second;
        if parts == 0 {
            if self.repeated.len() < LISTED {
                self.repeated.push((line, Backward::Repeats { at_s: to_s }));
            }
            return;
        }
        if self.late_stamps {
            let typical = self.estimator.interval();
            if typical.is_some_and(|t| -self.seconds(parts) < 2.0 * t) {
                self.crossed = true;
                return;
            }
        }
        if self.backward.len() < LISTED {
            let from_s = last.value() / self.per_second;
            self.backward.push((line, Backward::Runs { from_s, to_s }));
        }
    }

    /// Lists the gaps that are certain now.
    fn list_gaps(&mut self) {
        // Row of the first that is open.
        let first = self.rows - self.open.len();
        for slip in self.estimator.take_slips() {
            if let (Some(missing), Ok(samples @ 1..)) =
                (&mut self.missing, u64::try_from(slip.samples))
            {
                missing.push((slip.row as u64, samples));
            }
            let rows = (slip.row.wrapping_sub(first + 1), slip.row - first);
            let (Some(before), Some(after)) = (self.open.get(rows.0), self.open.get(rows.1)) else {
                continue;
            };
            if slip.samples > 0 && (self.all_gaps || self.gaps.len() < LISTED) {
                self.gaps.push(Gap {
                    after_sample: before.0,
                    line: before.1,
                    at_s: before.2,
                    step_s: after.2 - before.2,
                });
            }
        }
        let open = self.estimator.undecided() + 1;
        while self.open.len() > open {
            self.open.pop_front();
        }
    }

    /// The turn of a counter that explains a step backwards: the stamp follows the one before as usual once it is
    /// added.
    fn turn(&self, stamp: Stamp, last: Stamp) -> Option<i128> {
        let typical = self.estimator.interval()?;
        let whole = self.decimals == 0;
        let bits = [8, 16, 24, 31, 32].map(|b| (whole, (1_i128 << b) * PARTS));
        // Microseconds and milliseconds of 32 bits that were written in another unit.
        let micro = (PARTS as f64 * self.per_second * 4_294.967_296).round() as i128;
        let others = [(true, micro), (true, micro * 1000)];
        bits.into_iter()
            .chain(others)
            .filter(|&(possible, turn)| {
                let length = self.seconds(turn);
                let step = self.seconds(stamp.parts + turn - last.parts);
                // A short counter says little, so that only the very next count is believed.
                let most = if length > 1e4 * typical { 16.0 } else { 1.5 };
                possible && length > 64.0 * typical && step > 0.0 && step <= most * typical
            })
            .map(|(_, turn)| turn)
            .min()
    }

    /// First stamp.
    pub(crate) fn first(&self) -> Option<Stamp> {
        self.first
    }

    /// Last stamp, wraps undone.
    pub(crate) fn last(&self) -> Option<Stamp> {
        self.last
    }

    /// Wraps that were undone, the first hundred.
    pub(crate) fn wraps(&self) -> &[Wrap] {
        &self.wraps
    }

    /// Whether stamps may repeat, because the clock is coarse or tells bursts.
    pub(crate) fn may_repeat(&self) -> bool {
        self.estimator.repeats()
    }

    /// Whether stamps crossed their neighbours by jitter. They may be equal by it then.
    pub(crate) fn crossed(&self) -> bool {
        self.crossed
    }

    /// The clock, where two stamps tell one.
    pub(crate) fn finish(&mut self) -> Option<Clock> {
        if !self.crossed && !self.may_repeat() {
            self.backward.append(&mut self.repeated);
            self.backward.sort_by_key(|b| b.0);
        }
        let clock = self.estimator.finish()?;
        self.list_gaps();
        Some(Clock {
            wraps: self.wrap_count,
            ..clock.into()
        })
    }
}

impl From<clock::Clock> for Clock {
    fn from(clock: clock::Clock) -> Self {
        Self {
            rate_hz: clock.rate_hz,
            rate_u_hz: clock.rate_u_hz,
            jitter_s: clock.jitter_s,
            scatter_s: clock.scatter_s,
            resolution_s: clock.resolution_s,
            bursts: clock.bursts,
            wraps: 0,
            gaps: clock.gaps,
            missing: clock.missing,
            untested: clock.untested,
            crossing: clock.crossing,
            steps: clock.steps,
            change: clock.change,
        }
    }
}
