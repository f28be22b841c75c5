//! A dataset in chunks: which are there and sound, and how far they go.

use super::Dataset;
use crate::arrays::Arrays;
use crate::hdf5::chunked::{Chunk, Chunked, Table};
use crate::hdf5::file::{File, Found, Trouble};
use crate::hdf5::filters::unpacked;
use crate::hdf5::index::{Chunks, Entry};
use crate::hdf5::layout::{Filter, Grid, Space};
use crate::names::unpacked_bytes;
use crate::raw::bytes_at;
use crate::stream::{Remark, Source};
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes that a packed chunk may unpack to.
const MOST_UNPACKED: u64 = 1 << 28;
/// Sides that a dataset without bounds states.
const UNBOUNDED: u64 = u64::MAX;

impl File<'_> {
    pub(super) fn chunked(
        &mut self,
        dataset: &Dataset<'_>,
        space: &Space,
        grid: &Grid,
        filters: Vec<Filter>,
        arrays: &mut Arrays,
    ) -> Found<()> {
        let wrong = || Trouble::Damaged("the chunk size contradicts the dataset".to_owned());
        let (rank, name) = (space.sides.len(), dataset.name);
        let (element, across) = grid.sides.split_last().ok_or_else(wrong)?;
        if across.len() != rank || across.contains(&0) || *element != dataset.element {
            return Err(wrong());
        }
        let sides = [across[0], across.get(1).copied().unwrap_or(1)];
        let mut table = Table {
            name: name.to_owned(),
            sides,
            across: dataset.sides[1].div_ceil(sides[1]),
            element: *element,
            filters,
            chunks: Vec::new(),
            checked: Mutex::default(),
        };
        let counts = [dataset.sides[0].div_ceil(sides[0]), table.across];
        counts[0].checked_mul(counts[1]).ok_or_else(wrong)?;
        let bytes = table.bytes();
        let packed = !table.filters.is_empty();
        if packed && bytes > MOST_UNPACKED {
            return Err(Trouble::Foreign(format!(
                "packed in chunks of {bytes} bytes, more than are unpacked here"
            )));
        }
        let most: Vec<Option<u64>> = (space.most.iter().zip(across))
            .map(|(most, side)| (*most != UNBOUNDED).then(|| most.div_ceil(*side)))
            .collect();
        let chunks = Chunks {
            grid,
            most: &most,
            bytes,
            filtered: packed,
        };
        let mut entries = Vec::new();
        if let Err(trouble) = self.chunks(&chunks, &mut entries) {
            arrays.remarks.push(trouble.remark(name, self.size)?);
        }
        entries.retain(|e| e.place[0] < counts[0] && e.place[1] < counts[1]);
        entries.sort_by_key(|e| e.place);
        entries.dedup_by_key(|e| e.place);
        let whole = |place: [u64; 2]| {
            (0..2).all(|i| (place[i] + 1).saturating_mul(sides[i]) <= dataset.sides[i])
        };
        let mut bad = Bad::default();
        for entry in &entries {
            let filtered = packed && (whole(entry.place) || !grid.plain_edges);
            self.take_chunk(entry, filtered, &mut table, &mut bad)?;
        }
        bad.remark(name, self.size, &mut arrays.remarks);
        self.whole_rows(dataset, table, counts, entries.len() as u64, arrays)
    }

    /// Puts a chunk into the table where it is there and sound.
    fn take_chunk(
        &mut self,
        entry: &Entry,
        filtered: bool,
        table: &mut Table,
        bad: &mut Bad,
    ) -> Found<()> {
        let (at, wanted) = (self.place(entry.at), table.bytes());
        let number = entry.place[0] * table.across + entry.place[1];
        let behind = |stored: u64| at.checked_add(stored).is_none_or(|end| end > self.size);
        let stored = if filtered { entry.stored } else { wanted };
        if behind(stored) {
            bad.cut.put(at);
            return Ok(());
        }
        if !self.claim(stored) {
            return Err(Trouble::Damaged("its chunks overlap other data".to_owned()));
        }
        if filtered {
            // The check sums are checked here, so that a gap is known before the first sample is read.
            let possible = wanted <= unpacked_bytes(stored);
            let stored = bytes_at(self.raw(), at, stored)?;
            let whole = || unpacked(&table.filters, entry.left_off, stored, wanted as usize);
            let Some(whole) = possible.then(whole).flatten() else {
                bad.damaged.put(at);
                return Ok(());
            };
            if self.keep(wanted) {
                let checked = table.checked.get_mut();
                let checked = checked.unwrap_or_else(PoisonError::into_inner);
                checked.insert(number, whole);
            }
        }
        table.chunks.push(Chunk {
            number,
            at,
            stored,
            left_off: filtered.then_some(entry.left_off),
        });
        Ok(())
    }

    /// Makes channels as far as there are chunks; what is missing between them is a gap.
    fn whole_rows(
        &mut self,
        dataset: &Dataset<'_>,
        table: Table,
        counts: [u64; 2],
        named: u64,
        arrays: &mut Arrays,
    ) -> Found<()> {
        let time = dataset.time;
        let along = |c: &Chunk| [c.number / table.across, c.number % table.across][time];
        let Some(last) = table.chunks.iter().map(along).max() else {
            return match named {
                0 => Err(Trouble::Foreign("which was never written".to_owned())),
                _ => Ok(()),
            };
        };
        let rows = dataset.sides[time].min((last + 1).saturating_mul(table.sides[time]));
        let there = table.chunks.len() as u64;
        let due = (last + 1).saturating_mul(counts[1 - time]);
        if due - there > there {
            return Err(Trouble::Foreign(format!(
                "of which {there} of {due} chunks are there"
            )));
        }
        if rows < dataset.sides[time] {
            arrays.remarks.push(Remark::cut(format!(
                "{rows} of {} samples of {} were written",
                dataset.sides[time], dataset.name
            )));
        }
        if due > there {
            arrays.remarks.push(Remark::damaged(format!(
                "{} of {due} chunks of {} are missing, and their samples are no numbers",
                due - there,
                dataset.name
            )));
        }
        let table = Arc::new(table);
        dataset.channels(dataset.sides[1 - time], rows, arrays, |which, part| {
            Source::Chunked(Box::new(Chunked {
                table: Arc::clone(&table),
                kind: part.kind,
                order: part.order,
                offset: part.at,
                time,
                which,
                rows,
                done: 0,
            }))
        });
        Ok(())
    }
}

/// Chunks that are not read: how many, and the byte of the first.
#[derive(Default)]
struct Places {
    count: u64,
    first: u64,
}

impl Places {
    fn put(&mut self, at: u64) {
        self.first = if self.count == 0 {
            at
        } else {
            self.first.min(at)
        };
        self.count += 1;
    }
}

#[derive(Default)]
struct Bad {
    cut: Places,
    damaged: Places,
}

impl Bad {
    fn remark(&self, name: &str, size: u64, to: &mut Vec<Remark>) {
        if self.cut.count > 0 {
            to.push(Remark::cut(format!(
                "{} of the chunks of {name} lie behind the end of the file at byte {size}, the first at byte {}",
                self.cut.count, self.cut.first
            )));
        }
        if self.damaged.count > 0 {
            to.push(Remark::damaged(format!(
                "{} of the chunks of {name}: the check sum does not hold or it cannot be unpacked, the first at byte {}",
                self.damaged.count, self.damaged.first
            )));
        }
    }
}
