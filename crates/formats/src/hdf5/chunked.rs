//! Numbers of a channel that lies in chunks.

use super::filters::unpacked;
use super::layout::Filter;
use crate::bytes::Order;
use crate::raw::{Kind, Window, bytes_at, numbers};
use crate::stream::SeekRead;
use crate::{Error, Result};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A chunk that is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chunk {
    /// Number of the chunk, the first side going slowest.
    pub(super) number: u64,
    /// Byte of the file.
    pub(super) at: u64,
    pub(super) stored: u64,
    /// Filters that were left off; nothing where none was applied.
    pub(super) left_off: Option<u32>,
}

/// The chunks of a dataset.
#[derive(Debug)]
pub(crate) struct Table {
    pub(super) name: String,
    /// Sides of a chunk.
    pub(super) sides: [u64; 2],
    /// Chunks along the second side.
    pub(super) across: u64,
    /// Bytes of an element.
    pub(super) element: u64,
    pub(super) filters: Vec<Filter>,
    /// In the order of their numbers; those that are missing or damaged are not in it.
    pub(super) chunks: Vec<Chunk>,
    /// Some of them as they came out when they were checked, until they are asked for.
    pub(super) checked: Mutex<HashMap<u64, Vec<u8>>>,
}

impl Table {
    /// Bytes of a chunk.
    pub(super) fn bytes(&self) -> u64 {
        self.sides[0]
            .saturating_mul(self.sides[1])
            .saturating_mul(self.element)
    }

    fn chunk(&self, number: u64) -> Option<&Chunk> {
        let found = self.chunks.binary_search_by_key(&number, |c| c.number);
        found.ok().map(|i| &self.chunks[i])
    }
}

/// One channel of a dataset in chunks, and how far reading has come.
#[derive(Debug)]
pub(crate) struct Chunked {
    pub(super) table: Arc<Table>,
    pub(super) kind: Kind,
    pub(super) order: Order,
    /// Bytes of an element before the number.
    pub(super) offset: u64,
    /// Side along which time goes.
    pub(super) time: usize,
    /// Place along the other side.
    pub(super) which: u64,
    pub(super) rows: u64,
    pub(super) done: u64,
}

impl Chunked {
    pub(crate) fn rows(&self) -> u64 {
        self.rows
    }

    pub(crate) fn rewind(&mut self) {
        self.done = 0;
    }

    /// Bytes from one number to the next.
    pub(crate) fn stride(&self) -> u64 {
        match self.time {
            0 => self.table.sides[1].saturating_mul(self.table.element),
            _ => self.table.element,
        }
    }

    /// Appends the next numbers, at most so many; what is missing is no number.
    pub(crate) fn read(
        &mut self,
        window: &mut Window,
        file: &mut dyn SeekRead,
        most: usize,
        to: &mut Vec<f64>,
    ) -> Result<()> {
        let table = &*self.table;
        let (time, other) = (self.time, 1 - self.time);
        let stride = self.stride();
        let end = self.rows.min(self.done.saturating_add(most as u64));
        while self.done < end {
            let mut place = [0; 2];
            (place[time], place[other]) = (
                self.done / table.sides[time],
                self.which / table.sides[other],
            );
            let inside = self.done % table.sides[time];
            let n = (end - self.done).min(table.sides[time] - inside);
            self.done += n;
            let Some(chunk) = table.chunk(place[0] * table.across + place[1]) else {
                to.extend(std::iter::repeat_n(f64::NAN, n as usize));
                continue;
            };
            let mut within = [0; 2];
            (within[time], within[other]) = (inside, self.which % table.sides[other]);
            let from = (within[0] * table.sides[1] + within[1]) * table.element + self.offset;
            let length = (n - 1) * stride + self.kind.size();
            let bytes = match chunk.left_off {
                None => window.get(file, chunk.at + from, length, stride)?,
                Some(left_off) => {
                    let key = (Arc::as_ptr(&self.table) as usize, chunk.number);
                    let whole = window.unpacked.get(key, || {
                        let checked = table.checked.lock();
                        let mut checked = checked.unwrap_or_else(PoisonError::into_inner);
                        if let Some(whole) = checked.remove(&chunk.number) {
                            return Ok(whole);
                        }
                        let stored = bytes_at(file, chunk.at, chunk.stored)?;
                        let whole =
                            unpacked(&table.filters, left_off, stored, table.bytes() as usize);
                        whole.ok_or_else(|| {
                            Error::new(format!(
                                "the chunk of {} at byte {} cannot be unpacked",
                                table.name, chunk.at
                            ))
                        })
                    })?;
                    &whole[from as usize..(from + length) as usize]
                }
            };
            numbers(self.kind, self.order, bytes, stride as usize, to);
        }
        Ok(())
    }
}

/// Unpacked chunks that are held, because channels side by side and the next block may need them again.
#[derive(Debug, Default)]
pub(crate) struct Unpacked {
    fresh: HashMap<(usize, u64), Vec<u8>>,
    older: HashMap<(usize, u64), Vec<u8>>,
    /// Bytes of the fresh ones.
    bytes: usize,
}

/// Bytes of unpacked chunks after which the older ones are let go.
pub(super) const HELD: usize = 24 << 20;

impl Unpacked {
    fn get(
        &mut self,
        key: (usize, u64),
        unpack: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<&[u8]> {
        if !self.fresh.contains_key(&key) {
            let chunk = match self.older.remove(&key) {
                Some(chunk) => chunk,
                None => unpack()?,
            };
            if self.bytes > HELD {
                self.older = std::mem::take(&mut self.fresh);
                self.bytes = 0;
            }
            self.bytes += chunk.len();
            self.fresh.insert(key, chunk);
        }
        Ok(&self.fresh[&key])
    }
}
