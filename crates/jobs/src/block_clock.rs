//! The clock of a recording that goes by block by block.

use crate::trouble::Trouble;
use proofmass_io::{TimeWindow, doubtful_times};
use proofmass_signal::clock::ClockEstimator;
use proofmass_uncertainty::Finding;

/// Times that all are the same.
pub(crate) fn stands_still(name: &str) -> Trouble {
    Trouble::data("the clock stands still: its times do not advance")
        .detail(name)
        .with_hint("name another column with --time, or give --rate HZ (`sampling_rate_Hz` in a campaign) in place of the times")
}

/// What is known of the times while the recording goes by.
pub(crate) struct BlockClock {
    /// Units of the time column in a second; none for a stated rate.
    pub(crate) per_second: Option<f64>,
    /// Samples per second: as stated, or by the line of the first block.
    pub(crate) nominal: f64,
    estimator: ClockEstimator,
    /// Whether a stamp before the one ahead of it is refused, by however little.
    in_order: bool,
    last: Option<f64>,
    rows: usize,
    pub(crate) gaps: u64,
}

impl BlockClock {
    pub(crate) fn steady(rate: f64) -> Self {
        Self {
            per_second: None,
            nominal: rate,
            estimator: ClockEstimator::new(),
            in_order: false,
            last: None,
            rows: 0,
            gaps: 0,
        }
    }

    pub(crate) fn stamped(per_second: f64, rate: Option<f64>) -> Self {
        Self {
            per_second: Some(per_second),
            nominal: rate.unwrap_or(f64::NAN),
            estimator: ClockEstimator::new().with_nominal(rate),
            ..Self::steady(0.0)
        }
    }

    /// The stretch that is read; the times are those of one of the selected columns.
    pub(crate) fn window(&self, between: Option<[f64; 2]>, selected: usize) -> Option<TimeWindow> {
        between.map(|between| match self.per_second {
            Some(scale) => TimeWindow::by_column(between, selected, scale),
            None => TimeWindow::by_rate(between, self.nominal),
        })
    }

    /// Refuses stamps that cross.
    pub(crate) fn in_order(self) -> Self {
        Self {
            in_order: true,
            ..self
        }
    }

    /// Rows of a block before which samples are missing, decided at its end.
    pub(crate) fn breaks(
        &mut self,
        column: &[f64],
    ) -> std::result::Result<Vec<usize>, (usize, String)> {
        let per_second = self.per_second.unwrap_or(1.0);
        for stamp in column {
            self.estimator.push(stamp / per_second);
        }
        self.estimator.decide_all();
        // Stamps that jitter may cross their neighbours.
        let most = self.estimator.interval().filter(|_| !self.in_order);
        let most = most.map_or(0.0, |t| 2.0 * t);
        for (row, stamp) in column.iter().enumerate() {
            let to = stamp / per_second;
            let from = self.last.replace(to).unwrap_or(to);
            if to < from && to <= from - most {
                return Err((row, proofmass_io::backwards(from, to)));
            }
        }
        if !self.nominal.is_finite() {
            self.nominal = self.rate().unwrap_or(f64::NAN);
        }
        let slips = self.estimator.take_slips();
        self.gaps += slips.len() as u64;
        let breaks = slips.iter().filter_map(|s| s.row.checked_sub(self.rows));
        let breaks = breaks.collect();
        self.rows += column.len();
        Ok(breaks)
    }

    /// As [`breaks`](Self::breaks), those alone over which the time is longer than the shortest pause at the rate.
    pub(crate) fn pauses(
        &mut self,
        column: &[f64],
        shortest: impl Fn(f64) -> f64,
    ) -> std::result::Result<Vec<usize>, (usize, String)> {
        let before = self.last;
        let mut breaks = self.breaks(column)?;
        let (scale, shortest) = (self.per_second.unwrap_or(1.0), shortest(self.nominal));
        breaks.retain(|&row| {
            let from = row.checked_sub(1).map(|r| column[r] / scale).or(before);
            from.is_some_and(|from| column[row] / scale - from > shortest)
        });
        Ok(breaks)
    }

    /// What is to be doubted about the stamps that went by.
    pub(crate) fn doubts(&self) -> Vec<Finding> {
        let stamped = self.per_second.and_then(|_| self.estimator.clock());
        stamped.as_ref().map(doubtful_times).unwrap_or_default()
    }

    /// Samples per second by the line through all stamps.
    pub(crate) fn rate(&self) -> Option<f64> {
        if self.per_second.is_none() {
            return Some(self.nominal).filter(|r| r.is_finite());
        }
        self.estimator.clock().map(|c| c.rate_hz)
    }
}
