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

/// Rows that follow one another without a gap, of which every so many have values.
#[non_exhaustive]
pub struct ReadyRows {
    /// Where they stand.
    pub block: Rc<RowBlock>,
    /// From which one on, and to which.
    pub rows: Range<usize>,
    /// Every so many of them, the first included, has a value.
    pub every: usize,
    /// Values of those, column by column.
    pub values: Vec<Vec<f64>>,
}

/// Rows that wait for the values which a filter gives later than it takes their samples.
#[derive(Debug, Default)]
pub struct WaitingRows {
    waiting: VecDeque<(Rc<RowBlock>, Range<usize>)>,
    ready: Vec<VecDeque<f64>>,
    skip: usize,
    every: usize,
}

impl WaitingRows {
    /// None yet, with so many columns of values.
    pub fn new(columns: usize) -> Self {
        Self {
            ready: vec![VecDeque::new(); columns],
            every: 1,
            ..Self::default()
        }
    }

    /// Of the rows from now on every so many have values; all where this is not said.
    pub fn keep_every(&mut self, every: usize) {
        self.every = every.max(1);
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
            if self.skip > 0 {
                self.waiting.pop_front();
                continue;
            }
            let every = self.every.max(1);
            let n = rows.len().div_ceil(every).min(self.ready[0].len());
            let these = rows.start..rows.end.min(rows.start + n * every);
            let block = Rc::clone(block);
            rows.start += n * every;
            let done = rows.start >= rows.end;
            if done {
                // The next row that has a value stands so many rows further on.
                self.skip = rows.start - rows.end;
                self.waiting.pop_front();
            }
            if n > 0 {
                let drained = self.ready.iter_mut().map(|r| r.drain(..n).collect());
                return Some(ReadyRows {
                    block,
                    rows: these,
                    every,
                    values: drained.collect(),
                });
            }
            if !done {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(rows: usize) -> Rc<RowBlock> {
        Rc::new(RowBlock {
            columns: Vec::new(),
            lines: Vec::new(),
            rows,
            text: Vec::new(),
            ranges: Vec::new(),
            stamps: Vec::new(),
            bad: Vec::new(),
            bad_rows: Vec::new(),
        })
    }

    /// However the rows come in blocks and the values in portions, a value meets the row it was computed for.
    #[test]
    fn law_every_nth_row_behind_the_first_gets_its_value() {
        for (every, skip, sizes) in [
            (1, 0, [5, 7, 3]),
            (3, 4, [5, 7, 9]),
            (7, 2, [1, 2, 30]),
            (4, 9, [3, 3, 20]),
        ] {
            let mut waiting = WaitingRows::new(1);
            waiting.keep_every(every);
            waiting.begin(skip);
            let (mut blocks, mut rows, mut next, mut met) = (Vec::new(), 0, skip, Vec::new());
            for size in sizes {
                let one = block(size);
                waiting.wait(&one, 0..size);
                blocks.push((one, rows));
                rows += size;
                // The values of the last two rows are not there yet.
                while next + 2 < rows {
                    waiting.accept(vec![vec![next as f64]]);
                    next += every;
                    while let Some(ready) = waiting.take() {
                        let of = |(b, _): &&(Rc<RowBlock>, usize)| Rc::ptr_eq(b, &ready.block);
                        let before = blocks.iter().find(of).map_or(0, |(_, start)| *start);
                        let kept = ready.rows.clone().step_by(ready.every);
                        assert_eq!(kept.len(), ready.values[0].len());
                        met.extend(kept.zip(&ready.values[0]).map(|(r, v)| (before + r, *v)));
                    }
                }
            }
            let expected: Vec<(usize, f64)> = (0..met.len())
                .map(|i| skip + i * every)
                .map(|row| (row, row as f64))
                .collect();
            assert!(
                !met.is_empty() && met == expected,
                "{every} {skip}: {met:?}"
            );
        }
    }
}
