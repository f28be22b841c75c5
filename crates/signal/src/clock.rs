//! The sampling clock behind time stamps: rate, missing rows, jitter, resolution.
//!
//! Samples are taken evenly; their stamps are rounded, put on late by a computer that is busy, handed over in packets, and rows
//! are lost. Stamp i is t_i = a + T (i + m_i) + e_i with one interval T, the samples m_i that are missing before it, and an error e_i
//! of whatever kind that does not last. In intervals, t_i/T − i is a staircase of whole steps under noise: a *slip* is a step that
//! lasts, and nothing else interrupts a record.
//!
//! The first 65 536 stamps settle how the clock is read:
//!
//! 1. **Nothing is missing.** All stamps lie in a band of 0.45 T about one line, or within their resolution of it. Rounding may make a step of
//!    two units among steps of one; where the unit is the interval itself, four such steps must lie as a line has them.
//! 2. **A grid.** Steps are whole multiples of the one in the middle, to a standard deviation of 0.13 T per stamp (the resultant of
//!    their phases is 0.5 or more): rows are numbered one by one, however many are lost.
//! 3. **Scatter.** The levels of windows on either side of a place are compared, the mean of the middle fifth of their departures; windows
//!    grow, from 63 stamps, until the differences of neighbouring levels have a standard deviation of a fourteenth of an interval. A slip
//!    is half an interval and eight standard deviations, and the early edge (the tenth that is earliest) goes with it.
//!
//! Where the steps tell no grid, the stamps as points in time may: their spectrum stands out at 1/T (`comb.rs`) by exp(−2π²σ²) however
//! many are lost, to σ = 0.35 T in 4000 stamps. T and its uncertainty are those of that line where rows are missing and stamps scatter
//! by more than 0.07 T. Where it does not stand out, the stamps are those of a line only if their departures do not wander: means of
//! blocks of 128 rows that differ more than those of 16 are what lost rows make, a random walk whose variance per row is
//! the share that is lost (`Line::wander`). It is then part of u(T), [`Clock::untested`] says so.
//!
//! On a grid a stamp that is half an interval late is a slip when none of the next 2 k + 20 stamps comes back to the line, k being the
//! intervals it is late: whoever catches up has come back by then. A stamp that is early lasts after three.
//!
//! T is the slope of the straight line through the numbered stamps by least squares, with one intercept for each stretch between pauses of a
//! hundred samples or more. The line goes through the *mean* of the stamps: late stamps shift it, and do not turn it. u(T) takes the errors for a
//! first-order autoregression: u² = s²/Σ(x − x̄)² · (1 + ρ)/(1 − ρ). Stamps rounded alike (every step the same) hold T within ± q over
//! the whole time, a triangular distribution: q²/(6 N²) is added.
//!
//! **False alarms** none in 10⁷ stamps with Gaussian jitter of 5 % to 30 % (`law_jitter_is_no_loss`); by the normal distribution
//! of levels 10⁻¹² per window at seven standard deviations.

mod comb;
mod line;
mod settle;
mod unit;

use line::{Line, Steps};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use settle::{Mode, Settled, median, middle_and_edge};
use std::collections::VecDeque;
use unit::CommonUnit;

/// Stamps that settle how the clock is read.
const FIRST: usize = 1 << 16;
/// Missing samples from which on the two sides of a pause have each its own intercept.
const PAUSE: u64 = 100;
/// Stamps that are waited for to come back to a grid.
const MOST: f64 = 4096.0;
/// Interval in units of the last digit below which steps of whole units may be rounded ones.
const COARSE: f64 = 3.5;
/// Share and number of repeated stamps from which on they are the nature of the clock and not doubled rows.
const REPEATS: (f64, u64) = (0.1, 10);

/// Samples that are missing, or a clock that was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slip {
    /// First row behind it.
    pub row: usize,
    /// Samples missing before that row; negative when the stamps went back or a row repeats.
    pub samples: i64,
}

/// Two rates in one record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RateChange {
    /// Row near which the rate changes, to a hundredth of the record.
    pub row: usize,
    /// Rate before it, Hz.
    pub before_hz: f64,
    /// Rate from it on, Hz.
    pub after_hz: f64,
}

/// What time stamps tell about the clock they came from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Clock {
    /// Sampling rate by the line through the stamps, Hz.
    pub rate_hz: f64,
    /// Standard uncertainty of the rate, Hz: from scatter and resolution of the stamps, not from the error of the clock itself.
    pub rate_u_hz: f64,
    /// Standard deviation of the steps about the intervals they span, s; `None` below two.
    pub jitter_s: Option<f64>,
    /// Standard deviation of the stamps about the line, s.
    pub scatter_s: f64,
    /// Resolution of the stamps, s: the largest unit of which all steps are multiples; where these are whole intervals, the last
    /// digit.
    pub resolution_s: f64,
    /// Whether stamps come in bursts, so that a step says little about the sampling.
    pub bursts: bool,
    /// Whether stamps repeat by the nature of the clock.
    pub repeats: bool,
    /// Rows stamped before the row ahead of them.
    pub crossing: u64,
    /// Places where samples are missing.
    pub gaps: u64,
    /// Samples missing there; more than in the slips where stamps scatter too much to tell between which rows.
    pub missing: u64,
    /// Whether rows may be missing without a trace, because stamps wander as those of such a record do: the uncertainty of the
    /// rate holds it.
    pub untested: bool,
    /// Places where the stamps went back for good.
    pub set_back: u64,
    /// Steps between neighbouring samples.
    pub steps: u64,
    /// A rate that changes within the record.
    pub change: Option<RateChange>,
}

/// The clock behind stamps in memory, and where samples are missing.
///
/// **Units** s; a nominal rate in Hz helps where most of the record is missing.
///
/// **Errors** [`Error::TooFew`] below three stamps, [`Error::NotFinite`] with the row, [`Error::OutOfRange`] when the stamps do not
/// advance.
///
/// **Accuracy** rows lost at random, up to a third of them: every one found and the rate within 1e-5
/// (`law_lost_rows_are_gaps_of_the_right_length`); Gaussian jitter of 30 %: none found (`law_jitter_is_no_loss`).
///
/// ```
/// // A hundredth of a second apart, but for one stamp that is late and three samples that are missing.
/// let mut stamps: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k + if k > 600 { 3 } else { 0 })).collect();
/// stamps[200] += 0.008;
/// let (clock, slips) = proofmass_signal::clock::read(&stamps, None).unwrap();
/// assert!((clock.rate_hz - 100.0).abs() < 1e-2);
/// assert_eq!(slips.len(), 1);
/// assert_eq!((slips[0].row, slips[0].samples), (601, 3));
/// ```
pub fn read(stamps: &[f64], nominal: Option<f64>) -> Result<(Clock, Vec<Slip>), Error> {
    proofmass_core::check::finite("time stamps", stamps)?;
    let n = stamps.len();
    if n < 3 {
        return Err(Error::TooFew {
            name: "time stamps",
            needed: 3,
            got: n,
        });
    }
    let mut estimator = ClockEstimator::new().with_nominal(nominal);
    stamps.iter().for_each(|t| estimator.push(*t));
    let clock = estimator.finish().ok_or(Error::OutOfRange {
        name: "duration of the time stamps in s",
        value: stamps[n - 1] - stamps[0],
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    })?;
    Ok((clock, estimator.take_slips()))
}

/// Rows of the queue that are off the line.
#[derive(Clone, Copy, Debug, Default)]
struct Looked {
    /// How many were looked at, and how many are wanted.
    at: usize,
    want: usize,
    /// How near one came, and how near one of the first two.
    nearest: f64,
    first: f64,
    /// Steps that caught up.
    short: usize,
}

/// Takes stamps one by one in bounded memory, tells slips as soon as they are certain and the clock at the end.
///
/// The first 65 536 stamps are kept, afterwards those not yet decided: 4096 on a grid, at most 16 382 under scatter.
#[derive(Debug, Default)]
pub struct ClockEstimator {
    nominal: Option<f64>,
    unit: CommonUnit,
    /// Stamps until it is settled how to read them.
    waiting: Vec<f64>,
    settled: Option<Settled>,
    rows: usize,
    first: f64,
    last: f64,
    crossing: u64,
    zeros: u64,
    /// Departure of the latest stamp from its number, intervals.
    departure: f64,
    /// Departures of rows that are not decided.
    queue: VecDeque<f64>,
    /// Rows of the queue that were looked at and did not come back, and the one nearest to the line.
    looked: Looked,
    /// Departures of the last decided rows, for the medians.
    past: VecDeque<f64>,
    /// Mean departure now, and stamps in it.
    level: (f64, f64),
    /// Samples missing since the last decided row.
    slipped: i64,
    line: Line,
    steps: Steps,
    slips: Vec<Slip>,
    last_slip: Option<usize>,
    gaps: u64,
    /// Of these, with one sample missing.
    single: u64,
    missing: u64,
    set_back: u64,
}

impl ClockEstimator {
    /// Before the first stamp.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// With a rate, Hz, to fall back on where the stamps tell none.
    #[must_use]
    pub fn with_nominal(self, rate: Option<f64>) -> Self {
        Self {
            nominal: rate,
            ..self
        }
    }

    /// Size of the last digit that was written so far, s. Without it, it is read from the numbers.
    pub fn set_digit(&mut self, digit_s: f64) {
        self.unit.state(digit_s);
    }

    /// Takes the stamp of the next row, s, which must be finite.
    pub fn push(&mut self, stamp: f64) {
        if self.rows == 0 {
            self.first = stamp;
        } else {
            let step = stamp - self.last;
            self.crossing += u64::from(step < 0.0);
            self.zeros += u64::from(step == 0.0);
            self.unit.add(stamp - self.first, step, stamp.abs());
        }
        if let Some(settled) = &self.settled {
            let step = (stamp - self.last) / settled.interval;
            self.take(step);
        } else {
            self.waiting.push(stamp);
            if self.waiting.len() == FIRST {
                self.settle();
            }
        }
        self.rows += 1;
        self.last = stamp;
    }

    /// Slips found since the last call.
    pub fn take_slips(&mut self) -> Vec<Slip> {
        std::mem::take(&mut self.slips)
    }

    /// Latest rows of which it is not yet decided what is missing before them.
    pub fn undecided(&self) -> usize {
        self.queue.len() + self.waiting.len()
    }

    /// Decides on all rows so far with what is known: for a stream that must be passed on. A stamp that is late now and caught up
    /// later is told as two slips that cancel.
    pub fn decide_all(&mut self) {
        if self.settled.is_none() {
            self.settle();
        }
        if self.settled.is_some() {
            self.decide(true);
        }
    }

    /// Sampling interval as far as it is known, s.
    pub fn interval(&self) -> Option<f64> {
        if let Some(settled) = &self.settled {
            return Some(settled.interval);
        }
        let from = self.waiting.len().saturating_sub(100);
        let mut steps: Vec<f64> = self.waiting[from..]
            .windows(2)
            .map(|w| w[1] - w[0])
            .collect();
        (steps.len() > 2).then(|| median(&mut steps))
    }

    /// Whether stamps repeat by the nature of the clock.
    pub fn repeats(&self) -> bool {
        let grid = self.settled.as_ref().is_some_and(|s| s.mode.is_grid());
        !grid && self.zeros >= REPEATS.1 && self.zeros as f64 >= REPEATS.0 * self.rows as f64
    }

    /// The clock over all rows so far; `None` where it does not advance.
    pub fn finish(&mut self) -> Option<Clock> {
        self.decide_all();
        self.clock()
    }

    /// The clock over the rows that are decided; `None` where it does not advance.
    pub fn clock(&self) -> Option<Clock> {
        let settled = self.settled.as_ref()?;
        let fit = self.line.fit()?;
        let mut interval = settled.interval * (1.0 + fit.slope);
        if !(interval > 0.0 && interval.is_finite()) {
            return None;
        }
        let q = self.unit.of(interval, settled.mode.is_grid());
        let n = fit.steps;
        // Rounding that is spread over the resolution has the standard deviation q/√12.
        let spread = fit.scatter * settled.interval >= 0.8 * q / 12_f64.sqrt();
        let rounded = if spread { 0.0 } else { q * q / (6.0 * n * n) };
        let mut u = ((fit.slope_u * settled.interval).powi(2) + rounded).sqrt();
        let mut missing = self.missing;
        let mut lost = 0.0;
        match (settled.mode, settled.comb) {
            // Rows of a grid under much scatter are numbered a few too late.
            (Mode::Grid, Some(comb)) => (interval, u) = (comb.interval, comb.u * comb.interval),
            // Steps of whole units are those of a grid, or of other samples rounded to them.
            (Mode::Grid, None) => {
                let whole = interval / q;
                if whole < COARSE && (whole - whole.round()).abs() < 0.02 {
                    lost = self.single as f64 / (n + missing as f64);
                }
            }
            (Mode::Scatter { .. }, Some(comb)) => {
                // Samples by which the numbers of the rows fall short of the grid behind them.
                let short = (interval / comb.interval - 1.0) * (n + missing as f64);
                if short > 1.0 {
                    (interval, u) = (comb.interval, comb.u * comb.interval);
                    missing = missing.saturating_add(short.round() as u64);
                }
            }
            // Nothing tells a line of stamps that wander from one of which rows are missing.
            (Mode::Scatter { .. }, None) => {
                let share = self.line.wander();
                lost = share / (1.0 - share).max(0.1);
            }
        }
        u = u.hypot(interval * lost);
        Some(Clock {
            rate_hz: 1.0 / interval,
            rate_u_hz: u / (interval * interval),
            jitter_s: fit.jitter.map(|j| j * settled.interval),
            scatter_s: fit.scatter * settled.interval,
            resolution_s: q,
            bursts: settled.bursts,
            repeats: self.repeats(),
            crossing: self.crossing,
            gaps: self.gaps,
            missing,
            untested: lost > 0.0,
            set_back: self.set_back,
            steps: n as u64,
            change: self
                .steps
                .change()
                .or_else(|| self.line.bend())
                .map(|(row, before, after)| RateChange {
                    row,
                    before_hz: 1.0 / (settled.interval * before),
                    after_hz: 1.0 / (settled.interval * after),
                }),
        })
    }

    fn settle(&mut self) {
        let q = self.unit.common();
        let Some(settled) = Settled::of(&self.waiting, q, self.nominal) else {
            return;
        };
        let stamps = std::mem::take(&mut self.waiting);
        self.level = (0.0, 0.0);
        let mut last = stamps[0];
        let interval = settled.interval;
        self.settled = Some(settled);
        self.queue.push_back(0.0);
        for stamp in stamps.into_iter().skip(1) {
            self.take((stamp - last) / interval);
            last = stamp;
        }
    }

    /// The next row, so many intervals after the one before.
    fn take(&mut self, step: f64) {
        self.departure += step - 1.0;
        self.steps.add(step);
        self.queue.push_back(self.departure);
        self.decide(false);
    }

    fn decide(&mut self, end: bool) {
        match self.settled.as_ref().map(|s| s.mode) {
            Some(Mode::Grid) => self.decide_on_grid(end),
            Some(Mode::Scatter { window, threshold }) => {
                self.decide_by_medians(window, threshold, end);
            }
            None => {}
        }
    }

    /// The first row of the queue is decided.
    fn accept(&mut self) {
        if let Some(departure) = self.queue.pop_front() {
            self.line.add(self.slipped.saturating_add(1), departure);
            self.slipped = 0;
        }
    }

    /// Samples are missing before the first row of the queue.
    fn slip(&mut self, row: usize, samples: i64, apart: bool) {
        self.slips.push(Slip { row, samples });
        self.last_slip = Some(row);
        if samples > 0 {
            self.gaps += 1;
            self.single += u64::from(samples == 1);
            self.missing = self.missing.saturating_add(samples.unsigned_abs());
        } else {
            self.set_back += 1;
        }
        self.slipped = self.slipped.saturating_add(samples);
        self.departure -= samples as f64;
        for d in &mut self.queue {
            *d -= samples as f64;
        }
        if apart {
            self.line.close();
            self.slipped = 0;
        }
    }

    fn decide_on_grid(&mut self, end: bool) {
        while let Some(&first) = self.queue.front() {
            let (level, count) = self.level;
            let off = first - level;
            // One slip for a row.
            let told = self.last_slip == Some(self.line.rows);
            if off.abs() <= 0.5 || told {
                let off = off.clamp(-0.5, 0.5);
                let count = (count + 1.0).min(64.0);
                self.level = (level + off / count, count);
                self.accept();
                self.looked = Looked::default();
                continue;
            }
            let side = off.signum();
            let mut seen = self.looked;
            if seen.at == 0 {
                let want = if off > 0.0 { 2.0 * off + 20.0 } else { 3.0 };
                seen = Looked {
                    at: 1,
                    want: want.min(MOST) as usize,
                    nearest: off.abs(),
                    first: off.abs(),
                    short: 0,
                };
            }
            let (mut back, mut cut) = (false, false);
            while seen.at < self.queue.len().min(seen.want) {
                let now = side * (self.queue[seen.at] - level);
                if now < 0.5 {
                    back = now > -0.5;
                    cut = !back;
                    break;
                }
                // Whoever catches up is not done.
                if off > 0.0 && now < side * (self.queue[seen.at - 1] - level) - 0.4 {
                    seen.want = seen.want.max(seen.at + 20).min(MOST as usize);
                    seen.short += 1;
                }
                seen.nearest = seen.nearest.min(now);
                if seen.at == 1 {
                    seen.first = seen.nearest;
                }
                seen.at += 1;
            }
            let open = seen.at < seen.want;
            if !back && !cut && open && !end {
                self.looked = seen;
                return;
            }
            self.looked = Looked::default();
            // The record may end while it comes back.
            if back || open && seen.at > 1 && 2 * seen.short + 1 >= seen.at {
                (0..seen.at).for_each(|_| self.accept());
                continue;
            }
            let nearest = if seen.short > 1 {
                seen.nearest
            } else {
                seen.first
            };
            // Where the next rows lie between samples, whatever more is lost among them.
            let beside = beside(self.queue.iter().take(15).map(|d| d - level));
            let samples = (side * nearest - beside).round() as i64;
            let apart = samples.unsigned_abs() >= PAUSE || beside.abs() > 0.25;
            if samples == 0 && !apart {
                self.accept();
                continue;
            }
            self.slip(self.line.rows, samples, apart);
            if apart {
                self.level = (level + beside, 1.0);
            }
        }
    }

    fn decide_by_medians(&mut self, window: usize, threshold: f64, end: bool) {
        let hop = (window / 4).max(1);
        while self.queue.len() >= 2 * window + hop || end && !self.queue.is_empty() {
            let n = self.queue.len();
            let ahead = n.min(2 * window);
            let known = self.past.iter().chain(&self.queue);
            let (before, _) = levels(known.take(window));
            let (after, _) = levels(self.queue.range(ahead.saturating_sub(window)..ahead));
            let found = ((after - before).abs() >= threshold)
                .then(|| self.split(ahead, before, after, (window, threshold)))
                .flatten();
            let Some((split, samples)) = found else {
                self.commit(if end && n <= 2 * window { n } else { hop }, window);
                continue;
            };
            self.commit(split, window);
            let apart = samples.unsigned_abs() >= PAUSE;
            self.slip(self.line.rows, samples, apart);
            if apart {
                self.past.clear();
            }
        }
    }

    /// Where the departures of the next rows go over from one level to the other, and by how many samples.
    fn split(
        &self,
        ahead: usize,
        before: f64,
        after: f64,
        (window, threshold): (usize, f64),
    ) -> Option<(usize, i64)> {
        let (mut before, mut after) = ((before, 0.0), (after, 0.0));
        let (mut split, mut shorter) = (0, 0);
        // The levels that told of it may hold rows of either side; those about the place tell it again.
        for _ in 0..2 {
            let limit = (after.0 - before.0).abs();
            let cost = |d: f64, level: f64| (d - level).abs().min(limit);
            let (mut sum, mut best) = (0.0, f64::NEG_INFINITY);
            for (k, d) in self.queue.iter().take(ahead).enumerate() {
                if sum > best {
                    (best, split) = (sum, k);
                }
                sum += cost(*d, after.0) - cost(*d, before.0);
            }
            let to = (split + window).min(self.queue.len());
            shorter = (to - split).min(split + self.past.len()).min(window);
            if shorter < (window / 4).max(2) {
                return None;
            }
            after = levels(self.queue.range(split..to));
            let earlier = self.queue.range(..split).rev();
            before = levels(earlier.chain(self.past.iter().rev()).take(window));
        }
        // One slip for a row.
        if self.last_slip == Some(self.line.rows + split) {
            return None;
        }
        let ((before, edge_before), (after, edge_after)) = (before, after);
        let shift = after - before;
        let samples = shift.round();
        // Shorter windows are less steady. The early edge goes with the middle, or stamps were late for a while.
        let threshold = threshold * (window as f64 / shorter as f64).sqrt();
        let lasts = (edge_after - edge_before) * shift.signum() >= 0.5 * shift.abs();
        (shift.abs() >= threshold && samples != 0.0 && lasts).then_some((split, samples as i64))
    }

    fn commit(&mut self, rows: usize, window: usize) {
        for _ in 0..rows {
            if let Some(d) = self.queue.front() {
                self.past.push_back(*d);
            }
            self.accept();
        }
        let excess = self.past.len().saturating_sub(window);
        self.past.drain(..excess);
    }
}

/// Mean departure from the nearest whole intervals, by the direction of the sum of the phases.
fn beside(departures: impl Iterator<Item = f64>) -> f64 {
    let (sin, cos) = departures.fold((0.0, 0.0), |(sin, cos), d| {
        let (s, c) = (std::f64::consts::TAU * d).sin_cos();
        (sin + s, cos + c)
    });
    sin.atan2(cos) / std::f64::consts::TAU
}

fn levels<'a>(values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    middle_and_edge(&mut values.copied().collect::<Vec<_>>())
}
