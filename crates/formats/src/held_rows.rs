//! Rows of bytes that are held in memory, and one number out of each of them.

use crate::bytes::Order;
use crate::raw::{Kind, numbers};
use std::sync::Arc;

/// One number of each row, at the same place of all of them.
#[derive(Clone, Debug)]
pub(crate) struct HeldRows {
    rows: Arc<Vec<u8>>,
    /// Bytes of a row.
    width: usize,
    /// Byte of the number in its row.
    at: usize,
    kind: Kind,
    /// How far reading has come.
    next: usize,
}

impl HeldRows {
    /// The number must lie in a row.
    pub(crate) fn new(rows: &Arc<Vec<u8>>, width: usize, at: usize, kind: Kind) -> Self {
        debug_assert!(at + kind.size() as usize <= width);
        Self {
            rows: Arc::clone(rows),
            width,
            at,
            kind,
            next: 0,
        }
    }

    pub(crate) fn rows(&self) -> u64 {
        (self.rows.len() / self.width) as u64
    }

    pub(crate) fn rewind(&mut self) {
        self.next = 0;
    }

    /// Appends the next numbers, at most so many.
    pub(crate) fn read(&mut self, most: usize, to: &mut Vec<f64>) {
        let n = most.min(self.rows.len() / self.width - self.next);
        if n == 0 {
            return;
        }
        let from = self.next * self.width + self.at;
        let length = (n - 1) * self.width + self.kind.size() as usize;
        let bytes = &self.rows[from..from + length];
        numbers(self.kind, Order::Little, bytes, self.width, to);
        self.next += n;
    }
}
