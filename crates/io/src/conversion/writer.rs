//! The rows on their way into the file.

mod csv;
mod row_groups;
mod times;

use super::survey::Surveyed;
use super::target::TargetForm;
use super::timed_rows::RowClock;
use crate::written::Written;
use crate::{Result, RowBlock};
use proofmass_formats::write::{UFF_END, UffSignal, npy_head, put_doubles, uff_head, wav_head};
use row_groups::RowGroups;
use std::ops::Range;
use times::{Times, Timing};

#[cfg(test)]
pub(super) use csv::heading;

/// Numbers of the signals of a universal file that wait in memory for the one that is written, in bytes.
const HELD: u64 = 16 << 20;
/// Rows that are filled in at once.
const FILLED: u64 = 1 << 15;

/// What stands where samples are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Filling {
    /// The number before.
    Hold,
    /// None: NaN, or an empty field.
    Absent,
}

/// How a recording that was surveyed is written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConversionPlan {
    form: TargetForm,
    filling: Option<Filling>,
    rows: u64,
    rate_hz: Option<f64>,
    start_s: f64,
    parts: Vec<Range<usize>>,
    words: Vec<(String, String)>,
}

impl ConversionPlan {
    /// Missing samples are filled in where `filling` says so; a file with one rate states `rate_hz` and begins at `start_s`.
    pub fn new(
        form: TargetForm,
        surveyed: &Surveyed,
        filling: Option<Filling>,
        rate_hz: Option<f64>,
        start_s: f64,
    ) -> Self {
        let filled = filling.map_or(0, |_| surveyed.missing());
        let rows = surveyed.rows.saturating_add(filled);
        let signals = surveyed.layout.names.len();
        let at_once = match form {
            TargetForm::Uff => 1 + (HELD / (8 * rows).max(1)).min(1 << 20) as usize,
            _ => signals,
        };
        let parts = (0..signals).step_by(at_once.max(1));
        Self {
            form,
            filling,
            rows,
            rate_hz,
            start_s,
            parts: parts.map(|i| i..(i + at_once).min(signals)).collect(),
            words: Vec::new(),
        }
    }

    /// With columns that hold the same word in every row of the recording, before the others: in Parquet alone.
    pub fn with_words(self, words: Vec<(String, String)>) -> Self {
        Self { words, ..self }
    }

    /// Rows that will be written.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Signals of each pass over the recordings.
    pub fn parts(&self) -> &[Range<usize>] {
        &self.parts
    }

    /// Whether the times of the rows are read.
    pub fn is_timed(&self) -> bool {
        self.form.holds_times()
    }
}

/// A recording that is being written.
pub struct Conversion<'a> {
    to: Written,
    plan: &'a ConversionPlan,
    surveyed: &'a Surveyed,
    part: Range<usize>,
    timing: Timing,
    /// Next of the gaps.
    gap: usize,
    read: u64,
    written: u64,
    /// Numbers of the last row.
    last: Vec<f64>,
    held: Vec<Vec<u8>>,
    /// Rows of a file of columns.
    groups: Option<RowGroups>,
}

impl<'a> Conversion<'a> {
    /// Writes the head.
    ///
    /// # Errors
    /// More channels than the form can state, a disk that refuses.
    pub fn begin(
        mut to: Written,
        plan: &'a ConversionPlan,
        surveyed: &'a Surveyed,
    ) -> Result<Self> {
        let timing = Timing::of(plan, surveyed);
        let signals = surveyed.layout.names.len();
        let head = match plan.form {
            TargetForm::Csv => csv::head(&surveyed.layout, timing.is_told()),
            TargetForm::Npy => npy_head(plan.rows, signals + usize::from(timing.is_told())),
            TargetForm::Wav(form) => {
                let rate = plan.rate_hz.unwrap_or_default() as u32;
                wav_head(form, signals, rate, plan.rows).map_err(|e| refused(&to, &e))?
            }
            TargetForm::Uff | TargetForm::Parquet => Vec::new(),
        };
        to.write_all(&head)?;
        let groups = match plan.form {
            TargetForm::Parquet => {
                let groups = RowGroups::of(plan, surveyed, timing.is_told());
                Some(groups.map_err(|e| refused(&to, &e))?)
            }
            _ => None,
        };
        Ok(Self {
            to,
            plan,
            surveyed,
            part: 0..0,
            timing,
            gap: 0,
            read: 0,
            written: 0,
            last: Vec::new(),
            held: Vec::new(),
            groups,
        })
    }

    /// Begins a pass over the recordings with some of the signals.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn begin_pass(&mut self, part: &Range<usize>) -> Result<()> {
        self.part = part.clone();
        self.timing = Timing::of(self.plan, self.surveyed);
        (self.gap, self.read, self.written) = (0, 0, 0);
        self.last = vec![f64::NAN; part.len()];
        if self.plan.form == TargetForm::Uff {
            self.held = vec![Vec::new(); part.len().saturating_sub(1)];
            let head = self.uff_head(part.start);
            self.to.write_all(&head)?;
        }
        Ok(())
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// A disk that refuses, a recording that is not what was surveyed.
    pub fn block(&mut self, block: &RowBlock) -> Result<()> {
        let times = self.timing.of_block(block);
        let rows = block.rows();
        let mut from = 0;
        while from < rows {
            let gap = self.surveyed.gaps.get(self.gap).copied();
            let gap = gap.filter(|_| self.plan.filling.is_some());
            let ahead = gap.map_or(u64::MAX, |(row, _)| row.saturating_sub(self.read));
            if let (0, Some((_, samples))) = (ahead, gap) {
                self.gap += 1;
                self.fill(samples, &times, from)?;
                continue;
            }
            let n = usize::try_from(ahead).map_or(rows - from, |a| a.min(rows - from));
            self.rows(block, from..from + n, &times)?;
            from += n;
        }
        Ok(())
    }

    /// Rows as they stand in a block.
    fn rows(&mut self, block: &RowBlock, rows: Range<usize>, times: &Times) -> Result<()> {
        let columns = (0..self.part.len()).map(|i| &block.column(i)[rows.clone()]);
        let columns: Vec<&[f64]> = columns.collect();
        let times = times.part(rows.clone());
        let hold = self.plan.filling == Some(Filling::Hold) && !block.bad.is_empty();
        if hold {
            let mut held: Vec<Vec<f64>> = columns.iter().map(|c| c.to_vec()).collect();
            for (column, last) in held.iter_mut().zip(&self.last) {
                let mut last = *last;
                for number in column.iter_mut() {
                    if number.is_nan() {
                        *number = last;
                    }
                    last = *number;
                }
            }
            if held.iter().flatten().any(|v| v.is_nan()) {
                return Err(self
                    .to
                    .refusal(
                        "the first sample of a signal is absent, and no number stands before it",
                    )
                    .with_hint("leave out its beginning with --between FROM TO"));
            }
            let columns: Vec<&[f64]> = held.iter().map(Vec::as_slice).collect();
            self.write(&times, &columns)?;
        } else {
            self.write(&times, &columns)?;
        }
        self.read += rows.len() as u64;
        self.timing.passed(&times);
        Ok(())
    }

    /// Rows that are missing before a row of a block.
    fn fill(&mut self, samples: u64, times: &Times, row: usize) -> Result<()> {
        let number = |last: &f64| match self.plan.filling {
            Some(Filling::Hold) => *last,
            _ => f64::NAN,
        };
        let filled: Vec<f64> = self.last.iter().map(number).collect();
        let mut done = 0;
        while done < samples {
            let n = (samples - done).min(FILLED);
            let times = self.timing.between(times, row, done..done + n, samples);
            let columns: Vec<Vec<f64>> = filled.iter().map(|v| vec![*v; n as usize]).collect();
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            self.write(&times, &columns)?;
            done += n;
        }
        Ok(())
    }

    fn write(&mut self, times: &Times, columns: &[&[f64]]) -> Result<()> {
        let rows = columns.first().map_or(0, |c| c.len());
        self.written += rows as u64;
        if self.written > self.plan.rows {
            return Err(self.changed());
        }
        for (last, column) in self.last.iter_mut().zip(columns) {
            *last = column.last().copied().unwrap_or(*last);
        }
        match self.plan.form {
            TargetForm::Csv => {
                let pieces = csv::rows(times, columns);
                pieces.iter().try_for_each(|p| self.to.write_all(p))
            }
            TargetForm::Npy => {
                let mut bytes = Vec::with_capacity(8 * rows * (columns.len() + 1));
                let times = times.seconds();
                for row in 0..rows {
                    put_doubles(times.get(row).copied(), &mut bytes);
                    put_doubles(columns.iter().map(|c| c[row]), &mut bytes);
                }
                self.to.write_all(&bytes)
            }
            TargetForm::Wav(form) => {
                let mut bytes = Vec::with_capacity(form.size() as usize * rows * columns.len());
                for row in 0..rows {
                    columns.iter().for_each(|c| form.put(c[row], &mut bytes));
                }
                self.to.write_all(&bytes)
            }
            TargetForm::Uff => {
                for (column, held) in columns.iter().skip(1).zip(&mut self.held) {
                    put_doubles(column.iter().copied(), held);
                }
                let mut bytes = Vec::with_capacity(8 * rows);
                put_doubles(
                    columns.iter().take(1).flat_map(|c| c.iter().copied()),
                    &mut bytes,
                );
                self.to.write_all(&bytes)
            }
            TargetForm::Parquet => {
                let Some(groups) = &mut self.groups else {
                    return Ok(());
                };
                let bytes = groups.rows(&times.seconds(), columns);
                self.put(bytes)
            }
        }
    }

    /// Ends a pass.
    ///
    /// # Errors
    /// The disk refuses, a recording that is not what was surveyed.
    pub fn end_pass(&mut self) -> Result<()> {
        if self.written != self.plan.rows {
            return Err(self.changed());
        }
        if let TargetForm::Wav(form) = self.plan.form {
            let bytes = form.size() * self.plan.rows * self.surveyed.layout.names.len() as u64;
            // Chunks begin at even places.
            let padding: &[u8] = if bytes & 1 == 1 { &[0] } else { &[] };
            return self.to.write_all(padding);
        }
        if self.plan.form != TargetForm::Uff {
            return Ok(());
        }
        self.to.write_all(UFF_END)?;
        for (i, numbers) in std::mem::take(&mut self.held).into_iter().enumerate() {
            let head = self.uff_head(self.part.start + 1 + i);
            self.to.write_all(&head)?;
            self.to.write_all(&numbers)?;
            self.to.write_all(UFF_END)?;
        }
        Ok(())
    }

    /// Goes on to another recording, whose rows stand behind those before: in a file of columns.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn next_recording(
        &mut self,
        plan: &'a ConversionPlan,
        surveyed: &'a Surveyed,
    ) -> Result<()> {
        if let Some(groups) = &mut self.groups {
            let bytes = groups.next_recording(plan);
            self.put(bytes)?;
        }
        (self.plan, self.surveyed) = (plan, surveyed);
        Ok(())
    }

    /// What was written, when every pass was made.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn end(mut self) -> Result<Written> {
        if let Some(groups) = self.groups.take() {
            self.put(groups.end())?;
        }
        Ok(self.to)
    }

    fn put(&mut self, bytes: proofmass_formats::Result<Vec<u8>>) -> Result<()> {
        let bytes = bytes.map_err(|e| refused(&self.to, &e))?;
        self.to.write_all(&bytes)
    }

    fn uff_head(&self, signal: usize) -> Vec<u8> {
        let unit = self.surveyed.layout.units[signal];
        uff_head(&UffSignal {
            name: self.surveyed.layout.names[signal].clone(),
            unit: unit.map(|u| u.ascii().to_owned()),
            acceleration: unit.is_some_and(|u| u.is_acceleration()),
            start_s: self.plan.start_s,
            step_s: 1.0 / self.plan.rate_hz.unwrap_or(1.0),
            rows: self.plan.rows,
        })
    }

    fn changed(&self) -> crate::Error {
        self.to
            .refusal("a recording became another while it was read")
            .with_hint("wait until it is complete, then run again")
    }
}

/// What the writer of a format refuses.
fn refused(to: &Written, error: &proofmass_formats::Error) -> crate::Error {
    let refusal = to.refusal(error.to_string());
    match error.hint() {
        Some(hint) => refusal.with_hint(hint),
        None => refusal,
    }
}

impl ConversionPlan {
    /// Where the times of the rows come from, for those that hold them.
    fn clock(&self, surveyed: &Surveyed) -> RowClock {
        match self.form.holds_times() {
            true => surveyed.layout.clock,
            false => RowClock::Order,
        }
    }
}
