//! The samples of a recording that is compensated while it goes by.

use crate::RowBlock;
use std::collections::VecDeque;
use std::ops::Range;
use std::rc::Rc;

/// The first row that has a value outside a range, and how many have one.
pub fn rows_outside(columns: &[&[f64]], [low, high]: [f64; 2]) -> (Option<usize>, u64) {
    let outside = |i: &usize| columns.iter().any(|v| v[*i] < low || v[*i] > high);
    let mut rows = (0..columns[0].len()).filter(outside);
    match rows.next() {
        Some(first) => (Some(first), 1 + rows.count() as u64),
        None => (None, 0),
    }
}

/// Rows that follow one another without a gap, all with their values.
#[non_exhaustive]
pub struct ReadyRows {
    /// Where they stand.
    pub block: Rc<RowBlock>,
    /// Which they are.
    pub rows: Range<usize>,
    /// Their values, column by column.
    pub values: Vec<Vec<f64>>,
}

/// Rows that wait for the values which a filter gives later than it takes their samples.
#[derive(Debug, Default)]
pub struct WaitingRows {
    waiting: VecDeque<(Rc<RowBlock>, Range<usize>)>,
    ready: Vec<VecDeque<f64>>,
    skip: usize,
}

impl WaitingRows {
    /// None yet, with so many columns of values.
    pub fn new(columns: usize) -> Self {
        Self {
            ready: vec![VecDeque::new(); columns],
            ..Self::default()
        }
    }

    /// A stretch begins, whose first rows have no value; what still waits has none either.
    pub fn begin(&mut self, skip: usize) {
        self.waiting.clear();
        self.skip = skip;
    }

    /// More rows.
    pub fn wait(&mut self, block: &Rc<RowBlock>, rows: Range<usize>) {
        self.waiting.push_back((Rc::clone(block), rows));
    }

    /// Values of the rows that have waited longest.
    pub fn accept(&mut self, values: Vec<Vec<f64>>) {
        for (ready, values) in self.ready.iter_mut().zip(values) {
            ready.extend(values);
        }
    }

    /// The next rows that have their values.
    pub fn take(&mut self) -> Option<ReadyRows> {
        loop {
            let (block, rows) = self.waiting.front_mut()?;
            let skipped = self.skip.min(rows.len());
            self.skip -= skipped;
            rows.start += skipped;
            let n = rows.len().min(self.ready[0].len());
            let these = rows.start..rows.start + n;
            let block = Rc::clone(block);
            rows.start += n;
            let done = rows.start == rows.end;
            if done {
                self.waiting.pop_front();
            }
            if n > 0 {
                let drained = self.ready.iter_mut().map(|r| r.drain(..n).collect());
                return Some(ReadyRows {
                    block,
                    rows: these,
                    values: drained.collect(),
                });
            }
            if !done {
                return None;
            }
        }
    }
}
