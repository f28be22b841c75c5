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
    count: usize,
    /// Byte of the number in its row.
    at: usize,
    kind: Kind,
    order: Order,
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
            count: rows.len() / width,
            at,
            kind,
            order: Order::Little,
            next: 0,
        }
    }

    /// So many numbers from a byte on, so many bytes apart; nothing where they are not all there.
    pub(crate) fn apart(
        bytes: &Arc<Vec<u8>>,
        at: usize,
        width: usize,
        count: usize,
        (kind, order): (Kind, Order),
    ) -> Option<Self> {
        let before = count.checked_sub(1)?.checked_mul(width)?;
        let end = before.checked_add(at)?.checked_add(kind.size() as usize)?;
        (width > 0 && end <= bytes.len()).then(|| Self {
            rows: Arc::clone(bytes),
            width,
            count,
            at,
            kind,
            order,
            next: 0,
        })
    }

    pub(crate) fn rows(&self) -> u64 {
        self.count as u64
    }

    pub(crate) fn rewind(&mut self) {
        self.next = 0;
    }

    /// Appends the next numbers, at most so many.
    pub(crate) fn read(&mut self, most: usize, to: &mut Vec<f64>) {
        let n = most.min(self.count - self.next);
        if n == 0 {
            return;
        }
        let from = self.next * self.width + self.at;
        let length = (n - 1) * self.width + self.kind.size() as usize;
        let bytes = &self.rows[from..from + length];
        numbers(self.kind, self.order, bytes, self.width, to);
        self.next += n;
    }
}
