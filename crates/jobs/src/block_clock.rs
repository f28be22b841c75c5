//! The clock of a recording that goes by block by block.

use proofmass_noise::clock_line;

/// Stamps of a block kept for the next, against which its first stamps are compared.
const REMEMBERED: usize = 128;

/// What is known of the times while the recording goes by.
pub(crate) struct BlockClock {
    /// Units of the time column in a second; none for a stated rate.
    pub(crate) per_second: Option<f64>,
    unit_is_known: bool,
    /// Samples per second: as stated, or by the line of the first block.
    pub(crate) nominal: f64,
    /// Last stamps of the block before, s.
    tail: Vec<f64>,
    first: Option<f64>,
    last: f64,
    /// Rows so far, and samples missing among them.
    rows: u64,
    missing: i64,
    pub(crate) gaps: u64,
}

impl BlockClock {
    pub(crate) fn steady(rate: f64) -> Self {
        Self {
            per_second: None,
            unit_is_known: true,
            nominal: rate,
            tail: Vec::new(),
            first: None,
            last: 0.0,
            rows: 0,
            missing: 0,
            gaps: 0,
        }
    }

    pub(crate) fn stamped(per_second: f64, rate: Option<f64>, unit_is_known: bool) -> Self {
        Self {
            per_second: Some(per_second),
            unit_is_known,
            nominal: rate.unwrap_or(f64::NAN),
            ..Self::steady(0.0)
        }
    }

    /// Units in a second: as known, or by the size of a stamp that counts from 1970.
    fn units_per_second(&mut self, column: &[f64]) -> f64 {
        if let (false, Some(first)) = (self.unit_is_known, column.first()) {
            self.unit_is_known = true;
            self.per_second = Some(match first.abs() {
                s if s > 1e17 => 1e9,
                s if s > 1e14 => 1e6,
                s if s > 1e11 => 1e3,
                _ => 1.0,
            });
        }
        self.per_second.unwrap_or(1.0)
    }

    /// Rows of a block before which samples are missing, by the line of its stamps and the last ones before it.
    pub(crate) fn breaks(
        &mut self,
        column: &[f64],
    ) -> std::result::Result<Vec<usize>, (usize, String)> {
        let per_second = self.units_per_second(column);
        let stamps: Vec<f64> = column.iter().map(|t| t / per_second).collect();
        let before = self.tail.len();
        let mut all = std::mem::take(&mut self.tail);
        all.extend_from_slice(&stamps);
        let known = Some(self.nominal).filter(|r| r.is_finite());
        let line = clock_line(&all, known).ok().filter(|_| all.len() > 2);
        // Stamps that jitter may cross their neighbours.
        let most = line.as_ref().map_or(0.0, |l| 2.0 / l.rate);
        if let Some(row) = (before.max(1)..all.len())
            .find(|i| all[*i] < all[i - 1] && all[*i] <= all[i - 1] - most)
        {
            return Err((
                row - before,
                format!(
                    "the time does not advance, from {} s to {} s",
                    all[row - 1],
                    all[row]
                ),
            ));
        }
        let mut breaks = Vec::new();
        if let Some(line) = line {
            if !self.nominal.is_finite() {
                self.nominal = line.rate;
            }
            for slip in line.slips.iter().filter(|s| s.row >= before && s.row > 0) {
                breaks.push(slip.row - before);
                self.missing += slip.samples;
                self.gaps += 1;
            }
        }
        self.rows += stamps.len() as u64;
        self.first = self.first.or(stamps.first().copied());
        self.last = stamps.last().copied().unwrap_or(self.last);
        let from = all.len().saturating_sub(REMEMBERED);
        // A gap ends the memory: its far side belongs to another line.
        let from = breaks.last().map_or(from, |b| from.max(b + before));
        self.tail = all.split_off(from);
        Ok(breaks)
    }

    /// Samples per second over the whole recording, missing ones counted.
    pub(crate) fn rate(&self) -> Option<f64> {
        let Some(first) = self.first.filter(|_| self.per_second.is_some()) else {
            return Some(self.nominal).filter(|r| r.is_finite());
        };
        let steps = self.rows as i64 - 1 + self.missing;
        let rate = steps as f64 / (self.last - first);
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }
}
