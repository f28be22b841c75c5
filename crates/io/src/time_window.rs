//! A stretch of a recording: the rows whose times lie in it.

use crate::ClockUnit;
use crate::rows::RowBlock;
use crate::stamp::Stamp;

/// From which time on a recording counts from its first stamp.
pub(crate) const FAR: f64 = 1e5;

/// From where the times of a recording count whose first stamp is this, s: from the zero of its column, or from the stamp where that is
/// far from zero.
pub fn zero_of_times(first: f64) -> f64 {
    match first.abs() >= FAR {
        true => first,
        false => 0.0,
    }
}

/// Rows from one time on and before another; times count as those of the recording do.
///
/// Times are in seconds from the zero of the time column, from its first stamp where that lies beyond 10⁵ s, and from the first row
/// where a rate is stated.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeWindow {
    /// From and to, s.
    between: [f64; 2],
    clock: WindowClock,
    /// Rows that went by.
    rows: usize,
    origin: Option<f64>,
    origin_stamp: Option<Stamp>,
    last: Option<f64>,
}

/// What tells the times of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum WindowClock {
    /// A selected column, and its units in a second.
    Column(usize, f64),
    /// Samples per second.
    Rate(f64),
}

impl TimeWindow {
    /// By the clock of a recording, whose column stands behind so many others, or by its rate, Hz; `None` where it has neither.
    pub fn of(
        between: [f64; 2],
        selected: usize,
        clock: Option<&ClockUnit>,
        rate: Option<f64>,
    ) -> Option<Self> {
        let by_column = |clock: &ClockUnit| Self::by_column(between, selected, clock.per_second);
        let by_rate = || rate.map(|rate| Self::by_rate(between, rate));
        clock.map(by_column).or_else(by_rate)
    }

    /// By one of the selected columns, with so many units in a second.
    pub fn by_column(between: [f64; 2], selected: usize, per_second: f64) -> Self {
        Self::new(between, WindowClock::Column(selected, per_second))
    }

    /// By the number of the row and a rate, Hz.
    pub fn by_rate(between: [f64; 2], rate: f64) -> Self {
        Self::new(between, WindowClock::Rate(rate))
    }

    fn new(between: [f64; 2], clock: WindowClock) -> Self {
        Self {
            between,
            clock,
            rows: 0,
            origin: None,
            origin_stamp: None,
            last: None,
        }
    }

    /// The stamp of which time zero is, where it is not the zero of the column.
    pub(crate) fn origin(&self) -> Option<Stamp> {
        self.origin_stamp
    }

    /// The time of the column that counts as zero, s; `None` before the first row, and where a rate tells the times.
    pub fn zero(&self) -> Option<f64> {
        self.origin
    }

    /// Which rows of a block lie in the window.
    pub(crate) fn inside(&mut self, block: &RowBlock) -> Vec<bool> {
        let [from, to] = self.between;
        let mut inside = Vec::with_capacity(block.rows());
        for row in 0..block.rows() {
            let at = match self.clock {
                WindowClock::Rate(rate) => Some((self.rows + row) as f64 / rate),
                WindowClock::Column(slot, per_second) => self.seconds(block, row, slot, per_second),
            };
            self.last = at.or(self.last);
            // A row whose time is damaged belongs to the one before it.
            inside.push(self.last.is_some_and(|t| (from..to).contains(&t)));
        }
        self.rows += block.rows();
        inside
    }

    fn seconds(&mut self, block: &RowBlock, row: usize, slot: usize, scale: f64) -> Option<f64> {
        let stamp = block.stamps().get(row).copied().flatten();
        let value = stamp.map_or(block.column(slot)[row], Stamp::value) / scale;
        if !value.is_finite() {
            return None;
        }
        if self.origin.is_none() {
            let zero = zero_of_times(value);
            self.origin = Some(zero);
            self.origin_stamp = stamp.filter(|_| zero != 0.0);
        }
        match (stamp, self.origin_stamp) {
            (Some(stamp), Some(origin)) => Some(stamp.since(origin) / scale),
            _ => self.origin.map(|origin| value - origin),
        }
    }

    /// What to say where no row lies in it.
    pub fn nothing(&self) -> String {
        let [from, to] = self.between;
        let until = self
            .last
            .map_or(String::new(), |last| format!("; the last time is {last} s"));
        format!("no row lies between {from} s and {to} s{until}")
    }
}
