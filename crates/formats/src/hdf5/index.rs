//! The indices of chunks: which chunk lies where.

mod arrays;

use super::file::{File, Found, Trouble, UNDEFINED, damaged, little, number};
use super::layout::{Grid, Index};
use crate::bytes::Bytes;

/// A chunk in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Number of the chunk along each side.
    pub(super) place: [u64; 2],
    pub(super) at: u64,
    pub(super) stored: u64,
    /// Filters that were left off, a bit for each.
    pub(super) left_off: u32,
}

/// What an index says its numbers by.
pub(super) struct Chunks<'a> {
    pub(super) grid: &'a Grid,
    /// Sides of the dataset, at most, in chunks; a side without bounds is none.
    pub(super) most: &'a [Option<u64>],
    /// Bytes of a chunk.
    pub(super) bytes: u64,
    pub(super) filtered: bool,
}

impl Chunks<'_> {
    /// The place of the chunk of a number, where the first side that counts goes slowest.
    fn place(&self, number: u64, slowest: usize) -> [u64; 2] {
        match (self.most.len(), slowest) {
            (1, _) => [number, 0],
            (_, 0) => {
                let across = self.most[1].unwrap_or(1).max(1);
                [number / across, number % across]
            }
            _ => {
                let along = self.most[0].unwrap_or(1).max(1);
                [number % along, number / along]
            }
        }
    }

    fn put(
        &self,
        file: &File<'_>,
        b: &mut Bytes<'_>,
        width: usize,
        place: [u64; 2],
    ) -> Option<Option<Entry>> {
        let at = file.offset(b)?;
        let (stored, left_off) = match self.filtered {
            true => (number(b, width.checked_sub(file.offsets + 4)?)?, b.u32()?),
            false => (self.bytes, 0),
        };
        Some((at != UNDEFINED).then_some(Entry {
            place,
            at,
            stored,
            left_off,
        }))
    }
}

impl File<'_> {
    /// Appends the chunks that an index names, as many as can be read.
    pub(super) fn chunks(&mut self, chunks: &Chunks<'_>, to: &mut Vec<Entry>) -> Found<()> {
        let at = chunks.grid.at;
        match chunks.grid.index {
            _ if at == UNDEFINED => Ok(()),
            Index::Tree => self.tree(chunks, at, None, to),
            Index::Single(filtered) => {
                let (stored, left_off) = filtered.unwrap_or((chunks.bytes, 0));
                to.push(Entry {
                    place: [0, 0],
                    at,
                    stored,
                    left_off,
                });
                Ok(())
            }
            Index::Implicit => {
                let all = chunks
                    .most
                    .iter()
                    .try_fold(1_u64, |n, side| n.checked_mul((*side)?));
                for number in 0..all.unwrap_or(u64::MAX) {
                    let at = at.saturating_add(number.saturating_mul(chunks.bytes));
                    if self.place(at) >= self.size {
                        return Err(Trouble::Cut(self.place(at)));
                    }
                    self.spend(8)?;
                    to.push(Entry {
                        place: chunks.place(number, 0),
                        at,
                        stored: chunks.bytes,
                        left_off: 0,
                    });
                }
                Ok(())
            }
            Index::FixedArray => self.fixed_array(chunks, at, to),
            Index::ExtensibleArray => self.extensible_array(chunks, at, to),
            Index::Tree2 => self.tree_2(chunks, at, to),
        }
    }

    fn tree(
        &mut self,
        chunks: &Chunks<'_>,
        at: u64,
        level: Option<u8>,
        to: &mut Vec<Entry>,
    ) -> Found<()> {
        let wrong = || damaged("the index of chunks", at);
        let head = self.at(at, 8)?;
        let (own, count) = (head[5], u16::from_le_bytes([head[6], head[7]]));
        if !head.starts_with(b"TREE\x01") || level.is_some_and(|l| own >= l) {
            return Err(wrong());
        }
        let rank = chunks.grid.sides.len();
        let (key, child) = (8 + 8 * rank, self.offsets);
        let length = usize::from(count) * (key + child);
        let body = self.at(at.saturating_add(8 + 2 * child as u64), length as u64)?;
        let mut first = Ok(());
        for pair in body.chunks_exact(key + child) {
            let mut b = little(pair);
            let (stored, left_off) = b.u32().zip(b.u32()).ok_or_else(wrong)?;
            let mut place = [0; 2];
            for (i, side) in chunks.grid.sides.iter().enumerate() {
                let start = b.u64().ok_or_else(wrong)?;
                if i + 1 < rank && i < 2 {
                    place[i] = start / side;
                }
            }
            let at = self.offset(&mut b).ok_or_else(wrong)?;
            if own == 0 {
                to.push(Entry {
                    place,
                    at,
                    stored: stored.into(),
                    left_off,
                });
            } else if let Err(trouble) = self.tree(chunks, at, Some(own), to) {
                // What stands beside it may be there.
                if matches!(trouble, Trouble::Refused(_)) {
                    return Err(trouble);
                }
                first = first.and(Err(trouble));
            }
        }
        first
    }

    fn tree_2(&mut self, chunks: &Chunks<'_>, at: u64, to: &mut Vec<Entry>) -> Found<()> {
        let rank = chunks.most.len();
        let mut sound = true;
        let mut records: Vec<Vec<u8>> = Vec::new();
        let found = self.records(at, &mut |record| records.push(record.to_vec()));
        for record in records {
            let entry = (|| {
                let width = record.len().checked_sub(8 * rank)?;
                let (mut b, mut scaled) = (little(&record), little(record.get(width..)?));
                let mut place = [0; 2];
                for side in place.iter_mut().take(rank) {
                    *side = scaled.u64()?;
                }
                chunks.put(self, &mut b, width, place)
            })();
            sound &= entry.is_some();
            to.extend(entry.flatten());
        }
        found?;
        match sound {
            true => Ok(()),
            false => Err(damaged("the index of chunks", at)),
        }
    }
}
