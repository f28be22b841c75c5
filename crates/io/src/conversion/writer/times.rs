//! The times of rows on their way.

use super::super::survey::Surveyed;
use super::super::timed_rows::RowClock;
use super::ConversionPlan;
use crate::RowBlock;
use crate::clock::ClockEstimator;
use crate::stamp::Stamp;
use std::ops::Range;

/// Parts of a unit to which times between stamps are rounded: 10⁻⁹ of it.
const FINE: i128 = 1_000_000;

/// Times of consecutive rows.
pub(super) enum Times {
    /// None are told.
    None,
    /// Seconds.
    Seconds(Vec<f64>),
    /// Stamps, in units of which so many make a second, and what is time zero for doubles.
    Stamps {
        stamps: Vec<Stamp>,
        per_second: f64,
        zero: Stamp,
    },
}

impl Times {
    pub(super) fn part(&self, rows: Range<usize>) -> Self {
        match self {
            Self::None => Self::None,
            Self::Seconds(seconds) => Self::Seconds(seconds[rows].to_vec()),
            Self::Stamps {
                stamps,
                per_second,
                zero,
            } => Self::Stamps {
                stamps: stamps[rows].to_vec(),
                per_second: *per_second,
                zero: *zero,
            },
        }
    }

    /// As doubles.
    pub(super) fn seconds(&self) -> Vec<f64> {
        match self {
            Self::None => Vec::new(),
            Self::Seconds(seconds) => seconds.clone(),
            Self::Stamps {
                stamps,
                per_second,
                zero,
            } => stamps.iter().map(|s| s.since(*zero) / per_second).collect(),
        }
    }
}

/// Tells the times of rows as they go by.
pub(super) struct Timing {
    clock: RowClock,
    /// Undoes counters that began again.
    unwrap: Option<ClockEstimator>,
    zero: Stamp,
    last: Option<Stamp>,
    rows: u64,
}

impl Timing {
    pub(super) fn of(plan: &ConversionPlan, surveyed: &Surveyed) -> Self {
        let clock = plan.clock(surveyed);
        let far = surveyed.start_s().1;
        let zero = Stamp {
            parts: 0,
            decimals: 0,
            dated: false,
        };
        Self {
            clock,
            unwrap: match clock {
                RowClock::Stamps(_, per_second) if surveyed.wraps => {
                    Some(ClockEstimator::new(per_second))
                }
                _ => None,
            },
            zero: surveyed.start.filter(|_| far).unwrap_or(zero),
            last: None,
            rows: 0,
        }
    }

    /// Whether rows have times.
    pub(super) fn is_told(&self) -> bool {
        self.clock != RowClock::Order
    }

    pub(super) fn of_block(&mut self, block: &RowBlock) -> Times {
        let rows = block.rows();
        match self.clock {
            RowClock::Order => Times::None,
            RowClock::Rate(rate) => {
                let all = self.rows..self.rows + rows as u64;
                self.rows = all.end;
                Times::Seconds(all.map(|i| i as f64 / rate).collect())
            }
            RowClock::Stamps(_, per_second) => {
                let mut stamps: Vec<Stamp> = block.stamps().iter().copied().flatten().collect();
                if let Some(unwrap) = &mut self.unwrap {
                    for stamp in &mut stamps {
                        *stamp = unwrap.add(0, 0, *stamp);
                    }
                }
                Times::Stamps {
                    stamps,
                    per_second,
                    zero: self.zero,
                }
            }
        }
    }

    /// Rows were written.
    pub(super) fn passed(&mut self, times: &Times) {
        if let Times::Stamps { stamps, .. } = times {
            self.last = stamps.last().copied().or(self.last);
        }
    }

    /// Times of some of the samples that are missing before a row: evenly between those on either side.
    pub(super) fn between(
        &self,
        times: &Times,
        row: usize,
        missing: Range<u64>,
        samples: u64,
    ) -> Times {
        let Times::Stamps {
            stamps,
            per_second,
            zero,
        } = times
        else {
            return Times::None;
        };
        let to = stamps[row];
        let from = self.last.unwrap_or(to);
        let step = |k: u64| (to.parts - from.parts) * i128::from(k + 1) / i128::from(samples + 1);
        let rounded = |parts: i128| (parts + FINE / 2).div_euclid(FINE) * FINE;
        let stamp = |k: u64| Stamp {
            parts: rounded(from.parts + step(k)),
            decimals: from.decimals.max(9),
            dated: from.dated,
        };
        Times::Stamps {
            stamps: missing.map(stamp).collect(),
            per_second: *per_second,
            zero: *zero,
        }
    }
}
