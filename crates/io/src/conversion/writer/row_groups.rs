//! Rows of a file of columns, gathered into row groups.

use super::super::survey::Surveyed;
use super::ConversionPlan;
use super::csv::TIME;
use proofmass_formats::Result;
use proofmass_formats::write::{ParquetColumn, ParquetKind, ParquetWriter};

/// Numbers of a row group: the memory that a file takes while it is written.
const NUMBERS: usize = 1 << 21;

/// Rows on their way into row groups.
pub(super) struct RowGroups {
    writer: ParquetWriter,
    /// Words of every row of the recording.
    words: Vec<String>,
    /// Names of the recordings and how many row groups each has.
    recordings: Vec<(String, usize)>,
    /// Numbers of the rows that wait, a column each.
    waiting: Vec<Vec<f64>>,
    /// Rows of a full group.
    full: usize,
}

impl RowGroups {
    pub(super) fn of(plan: &ConversionPlan, surveyed: &Surveyed, timed: bool) -> Result<Self> {
        let words = plan.words.iter().map(|(name, _)| ParquetColumn {
            name: name.clone(),
            unit: None,
            kind: ParquetKind::Word,
        });
        let time = timed.then(|| ParquetColumn {
            name: TIME.to_owned(),
            unit: Some("s".to_owned()),
            kind: ParquetKind::Time,
        });
        let layout = &surveyed.layout;
        let signals = layout.names.iter().zip(&layout.units);
        let signals = signals.map(|(name, unit)| ParquetColumn {
            name: name.clone(),
            unit: unit.map(|u| u.ascii().to_owned()),
            kind: ParquetKind::Signal,
        });
        let columns: Vec<ParquetColumn> = words.chain(time).chain(signals).collect();
        let numbers = layout.names.len() + usize::from(timed);
        Ok(Self {
            writer: ParquetWriter::new(columns)?,
            words: words_of(plan),
            recordings: vec![(name_of(plan), 0)],
            waiting: vec![Vec::new(); numbers],
            full: (NUMBERS / numbers.max(1)).max(1),
        })
    }

    /// Takes rows; the bytes of the groups that they fill.
    pub(super) fn rows(&mut self, times: &[f64], columns: &[&[f64]]) -> Result<Vec<u8>> {
        let times = (self.waiting.len() > columns.len()).then_some(times);
        let all: Vec<&[f64]> = times.into_iter().chain(columns.iter().copied()).collect();
        let rows = columns.first().map_or(0, |c| c.len());
        let (mut bytes, mut from) = (Vec::new(), 0);
        while from < rows {
            let n = (self.full - self.waiting[0].len()).min(rows - from);
            for (waiting, column) in self.waiting.iter_mut().zip(&all) {
                waiting.extend(&column[from..from + n]);
            }
            from += n;
            if self.waiting[0].len() == self.full {
                bytes.extend(self.group()?);
            }
        }
        Ok(bytes)
    }

    /// The rows that wait.
    fn group(&mut self) -> Result<Vec<u8>> {
        if self.waiting[0].is_empty() {
            return Ok(Vec::new());
        }
        let bytes = self.writer.rows(&self.words, &self.waiting)?;
        if let Some((_, groups)) = self.recordings.last_mut() {
            *groups += 1;
        }
        self.waiting.iter_mut().for_each(Vec::clear);
        Ok(bytes)
    }

    /// Begins another recording; the bytes of the rows that waited.
    pub(super) fn next_recording(&mut self, plan: &ConversionPlan) -> Result<Vec<u8>> {
        let bytes = self.group()?;
        self.words = words_of(plan);
        self.recordings.push((name_of(plan), 0));
        Ok(bytes)
    }

    /// The rows that wait, and the index.
    pub(super) fn end(mut self) -> Result<Vec<u8>> {
        let mut bytes = self.group()?;
        bytes.extend(self.writer.end(&self.recordings)?);
        Ok(bytes)
    }
}

/// What a recording is chosen by when the table is read: its words, the first and the last.
fn name_of(plan: &ConversionPlan) -> String {
    let words: Vec<&str> = plan.words.iter().map(|(_, word)| word.as_str()).collect();
    match words[..] {
        [first, .., last] => format!("{first} {last}"),
        [one] => one.to_owned(),
        [] => String::new(),
    }
}

fn words_of(plan: &ConversionPlan) -> Vec<String> {
    plan.words.iter().map(|(_, word)| word.clone()).collect()
}
