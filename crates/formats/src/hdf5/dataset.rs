//! A dataset as channels.

use super::chunked::{Chunk, Chunked, Table};
use super::datatype::{Element, Part, element};
use super::file::{File, Found, Trouble, UNDEFINED};
use super::filters::unpacked;
use super::header::{Header, kind};
use super::index::{Chunks, Entry};
use super::layout::{self, Filter, Grid, Layout, Space};
use crate::arrays::{Arrays, MOST_COLUMNS};
use crate::raw::{Raw, bytes_at, numbers};
use crate::stream::{Column, Remark, Source};
use std::sync::Arc;

/// Bytes that a packed chunk may unpack to.
const MOST_UNPACKED: u64 = 1 << 28;
/// Bytes that deflate makes of one at most.
const MOST_INFLATED: u64 = 1032;
/// Sides that a dataset without bounds states.
const UNBOUNDED: u64 = u64::MAX;

/// What is known of a dataset before its data are looked for.
struct Dataset<'a> {
    name: &'a str,
    unit: Option<String>,
    sides: [u64; 2],
    /// Side along which time goes.
    time: usize,
    /// Whether its sides are named the other way round, as MATLAB does.
    turned: bool,
    parts: Vec<Part>,
    /// Bytes of an element.
    element: u64,
}

impl Dataset<'_> {
    /// What a signal is called, by its number across time.
    fn signal(&self, which: u64, part: &Part) -> String {
        let place = match (self.sides[1 - self.time], (self.time == 0) != self.turned) {
            (1, _) => String::new(),
            (_, true) => format!("(:,{})", which + 1),
            (_, false) => format!("({},:)", which + 1),
        };
        format!("{}{place}{}", self.name, part.name)
    }

    /// Makes a channel of every number of every signal.
    fn channels(
        &self,
        signals: u64,
        rows: u64,
        arrays: &mut Arrays,
        source: impl Fn(u64, &Part) -> Source,
    ) {
        for which in 0..signals {
            for part in &self.parts {
                let column = Column::of(source(which, part));
                arrays.column(self.signal(which, part), self.unit.clone(), rows, column);
            }
        }
    }
}

impl File<'_> {
    /// Takes in a dataset; what is not read of it is remarked.
    pub(super) fn dataset(
        &mut self,
        header: &Header,
        name: &str,
        turned: bool,
        arrays: &mut Arrays,
    ) -> Found<()> {
        let space = self.message(header, kind::DATASPACE)?;
        let space = space.and_then(|s| self.space(&s));
        let space = space.ok_or_else(|| damaged_part("list of sides"))?;
        let Some(dataset) = self.described(header, name, turned, &space, arrays)? else {
            return Ok(());
        };
        let layout = self.message(header, kind::LAYOUT)?;
        let layout = layout.ok_or_else(|| damaged_part("layout"))?;
        match self.layout(&layout)? {
            Layout::Compact(bytes) => compact(&dataset, &bytes, arrays),
            Layout::Contiguous(UNDEFINED) => {
                Err(Trouble::Foreign("which was never written".to_owned()))
            }
            Layout::Contiguous(at) => self.contiguous(&dataset, at, arrays),
            Layout::Chunked(grid) => {
                let filters = self.message(header, kind::FILTERS)?;
                let filters = filters.map_or(Ok(Vec::new()), |f| layout::filters(&f))?;
                self.chunked(&dataset, &space, &grid, filters, arrays)
            }
        }
    }

    /// What a dataset with signals of numbers is; nothing where there are none.
    fn described<'n>(
        &mut self,
        header: &Header,
        name: &'n str,
        turned: bool,
        space: &Space,
        arrays: &mut Arrays,
    ) -> Found<Option<Dataset<'n>>> {
        let foreign = |what: String| Err(Trouble::Foreign(what));
        let sides = match space.sides[..] {
            [] => [1, 1],
            [n] => [n, 1],
            [rows, columns] => [rows, columns],
            _ => return foreign(format!("an array of {} dimensions", space.sides.len())),
        };
        let time = match turned {
            true => usize::from(sides[1] >= sides[0] && space.sides.len() == 2),
            false => usize::from(sides[1] > sides[0]),
        };
        // A single number is no signal.
        if sides[time] < 2 || sides[1 - time] == 0 {
            return Ok(None);
        }
        let form = self.message(header, kind::DATATYPE)?;
        let form = form.and_then(|f| element(&f));
        let Element {
            bytes,
            parts,
            others,
        } = form.ok_or_else(|| damaged_part("datatype"))?;
        let others = others.into_iter();
        arrays
            .remarks
            .extend(others.map(|other| Remark::passed_over(format!("{name}{other}"))));
        if parts.is_empty() {
            return Ok(None);
        }
        if sides[1 - time].saturating_mul(parts.len() as u64) > MOST_COLUMNS as u64 {
            return foreign(format!(
                "a matrix of {} times {} numbers",
                sides[0], sides[1]
            ));
        }
        if header.has(kind::EXTERNAL) {
            return foreign("whose numbers stand in another file".to_owned());
        }
        let unit = self.text_of(header, &["unit", "units"])?;
        Ok(Some(Dataset {
            name,
            unit: unit.filter(|u| !u.is_empty()),
            sides,
            time,
            turned,
            parts,
            element: bytes,
        }))
    }

    fn contiguous(&mut self, dataset: &Dataset<'_>, at: u64, arrays: &mut Arrays) -> Found<()> {
        let (sides, element) = (dataset.sides, dataset.element);
        let place = self.place(at);
        let there = self.size.saturating_sub(place);
        let all = sides[0].saturating_mul(sides[1]).saturating_mul(element);
        if all > there {
            let (n, of) = (there / element, all / element);
            arrays.remarks.push(Remark::cut(format!(
                "{n} of {of} elements of {} are there",
                dataset.name
            )));
        }
        // What is whole along the side that goes slower.
        let line = sides[1].saturating_mul(element);
        let lines = sides[0].min(there / line);
        if !self.claim(lines * line) {
            return Err(Trouble::Damaged(
                "its numbers lie where others do".to_owned(),
            ));
        }
        let (signals, rows, stride, step) = match dataset.time {
            0 => (sides[1], lines, line, element),
            _ => (lines, sides[1], element, line),
        };
        dataset.channels(signals, rows, arrays, |which, part| {
            let at = place + which * step + part.at;
            Source::Raw(Raw::at(part.kind, part.order, at, stride, rows))
        });
        Ok(())
    }

    fn chunked(
        &mut self,
        dataset: &Dataset<'_>,
        space: &Space,
        grid: &Grid,
        filters: Vec<Filter>,
        arrays: &mut Arrays,
    ) -> Found<()> {
        let wrong = || Trouble::Damaged("its chunks are not of its form".to_owned());
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
            let filtered = packed && !(grid.plain_edges && !whole(entry.place));
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
        let behind = |stored: u64| at.checked_add(stored).is_none_or(|end| end > self.size);
        let stored = if filtered { entry.stored } else { wanted };
        if behind(stored) {
            bad.cut.put(at);
            return Ok(());
        }
        if !self.claim(stored) {
            return Err(Trouble::Damaged(
                "its chunks lie where others do".to_owned(),
            ));
        }
        if filtered {
            // The check sums are checked here, so that a gap is known before the first sample is read.
            let possible = wanted <= stored.saturating_mul(MOST_INFLATED);
            let stored = bytes_at(self.raw(), at, stored)?;
            let sound = |stored| {
                unpacked(&table.filters, entry.left_off, stored, wanted as usize).is_some()
            };
            if !possible || !sound(stored) {
                bad.damaged.put(at);
                return Ok(());
            }
        }
        table.chunks.push(Chunk {
            number: entry.place[0] * table.across + entry.place[1],
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

fn damaged_part(what: &str) -> Trouble {
    Trouble::Damaged(format!("its {what} is damaged"))
}

fn compact(dataset: &Dataset<'_>, bytes: &[u8], arrays: &mut Arrays) -> Found<()> {
    let [rows, columns] = dataset.sides;
    let element = dataset.element;
    let all = rows
        .checked_mul(columns)
        .and_then(|n| n.checked_mul(element));
    if all.is_none_or(|all| all > bytes.len() as u64) {
        return Err(damaged_part("piece in the header"));
    }
    let line = columns * element;
    let (signals, rows, stride, step) = match dataset.time {
        0 => (columns, rows, line, element),
        _ => (rows, columns, element, line),
    };
    dataset.channels(signals, rows, arrays, |which, part| {
        let from = (which * step + part.at) as usize;
        let to = from + ((rows - 1) * stride + part.kind.size()) as usize;
        let mut values = Vec::new();
        numbers(
            part.kind,
            part.order,
            &bytes[from..to],
            stride as usize,
            &mut values,
        );
        Source::held(values)
    });
    Ok(())
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
                "{} chunks of {name} lie behind the end of the file at byte {size}, the first at byte {}",
                self.cut.count, self.cut.first
            )));
        }
        if self.damaged.count > 0 {
            to.push(Remark::damaged(format!(
                "{} chunks of {name} whose check sum does not hold or that cannot be unpacked, the first at byte {}",
                self.damaged.count, self.damaged.first
            )));
        }
    }
}
