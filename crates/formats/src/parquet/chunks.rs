//! The numbers of one column, page by page.

use super::numbers::{Decoder, Hatch, Meaning, decoder, width};
use super::page::{Head, Kind};
use crate::stream::{ABSENT, Remark, SeekRead};
use crate::{Error, Result};
use ::parquet::basic::{Compression, Encoding};
use ::parquet::errors::ParquetError;
use ::parquet::schema::types::ColumnDescPtr;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The numbers of a column in one row group.
#[derive(Debug)]
pub(super) struct Chunk {
    /// Which row group, from one.
    pub(super) group: usize,
    /// First byte.
    pub(super) at: u64,
    /// Byte behind the last.
    pub(super) end: u64,
    /// Numbers, absent ones included.
    pub(super) rows: u64,
    pub(super) codec: Compression,
    /// Pages whose check sum does not hold.
    damaged: Vec<u64>,
    /// From where on nothing is found.
    lost: Option<u64>,
}

impl Chunk {
    pub(super) fn new(group: usize, at: u64, end: u64, rows: u64, codec: Compression) -> Self {
        Self {
            group,
            at,
            end,
            rows,
            codec,
            damaged: Vec::new(),
            lost: None,
        }
    }

    /// Goes through the heads of the pages and those check sums that are there.
    ///
    /// # Errors
    /// The pages hold another number of rows than the index says.
    pub(super) fn check(
        &mut self,
        file: &mut dyn SeekRead,
        name: &str,
        remarks: &mut Vec<Remark>,
    ) -> Result<()> {
        let (mut at, mut rows) = (self.at, 0);
        let place = format!("column {name}, row group {}", self.group);
        while rows < self.rows {
            if at >= self.end {
                return Err(Error::new(format!(
                    "the pages of {place} hold {rows} of the {} numbers that the index says",
                    self.rows
                ))
                .with_hint("columns of different length tell no rows: write the file again"));
            }
            let left = self.rows - rows;
            let head = Head::read(file, at, self.end)?;
            let Some(head) = head.filter(|h| h.rows() <= left) else {
                let what = format!(
                    "{place}: the page at byte {at} has no head that can be read, {left} numbers are missing"
                );
                remarks.push(Remark::damaged(what));
                self.lost = Some(at);
                return Ok(());
            };
            if !head.is_sound(file, at)? {
                let is_dictionary = matches!(head.kind, Kind::Dictionary { .. });
                let missing = match is_dictionary {
                    true => left,
                    false => head.rows(),
                };
                let what = format!(
                    "{place}: the page at byte {at} fails its check sum, {missing} numbers are missing"
                );
                remarks.push(Remark::damaged(what));
                if is_dictionary {
                    self.lost = Some(at);
                    return Ok(());
                }
                self.damaged.push(at);
            }
            rows += head.rows();
            at += head.length + head.packed;
        }
        Ok(())
    }
}

impl Head {
    /// Rows that the page holds.
    fn rows(&self) -> u64 {
        match self.kind {
            Kind::Data { values, .. } | Kind::Second { values, .. } => values.into(),
            Kind::Dictionary { .. } | Kind::Other => 0,
        }
    }

    /// Whether its numbers are places in a dictionary.
    fn points(&self) -> bool {
        let (Kind::Data { encoding, .. } | Kind::Second { encoding, .. }) = self.kind else {
            return false;
        };
        matches!(
            encoding,
            Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY
        )
    }
}

/// All chunks of a column, and how far reading has come.
pub(crate) struct Chunks {
    name: String,
    column: ColumnDescPtr,
    meaning: Meaning,
    chunks: Vec<Chunk>,
    chunk: usize,
    /// Byte of the next page.
    at: u64,
    /// Rows of the chunk that no page has given yet.
    left: u64,
    /// Rows of the page that are still to come.
    page: u64,
    /// Numbers of the page that are not absent and still to come, where that is known.
    there: Option<u64>,
    /// What decodes the page.
    decoder: Option<Box<dyn Decoder>>,
    hatch: Hatch,
    has_dictionary: bool,
    is_gap: bool,
}

impl fmt::Debug for Chunks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Chunks")
            .field("name", &self.name)
            .field("chunks", &self.chunks)
            .finish_non_exhaustive()
    }
}

impl Chunks {
    pub(super) fn new(
        name: String,
        column: ColumnDescPtr,
        meaning: Meaning,
        chunks: Vec<Chunk>,
    ) -> Self {
        let mut all = Self {
            name,
            column,
            meaning,
            chunks,
            chunk: 0,
            at: 0,
            left: 0,
            page: 0,
            there: None,
            decoder: None,
            hatch: Hatch::default(),
            has_dictionary: false,
            is_gap: false,
        };
        all.rewind();
        all
    }

    pub(crate) fn rows(&self) -> u64 {
        self.chunks.iter().map(|c| c.rows).sum()
    }

    pub(crate) fn rewind(&mut self) {
        self.enter(0);
    }

    /// Stands before the first page of a chunk.
    fn enter(&mut self, chunk: usize) {
        self.chunk = chunk;
        let first = self.chunks.get(chunk);
        (self.at, self.left) = first.map_or((0, 0), |c| (c.at, c.rows));
        (self.page, self.there) = (0, None);
        (self.is_gap, self.has_dictionary) = (false, false);
        self.hatch = Hatch::default();
        self.decoder = None;
    }

    /// Appends the next numbers, at most so many; fewer at the end only.
    pub(crate) fn read(
        &mut self,
        file: &mut dyn SeekRead,
        most: usize,
        to: &mut Vec<f64>,
    ) -> Result<()> {
        let mut wanted = most as u64;
        while wanted > 0 {
            if self.page == 0 {
                if self.left == 0 {
                    if self.chunk + 1 >= self.chunks.len() {
                        break;
                    }
                    self.enter(self.chunk + 1);
                } else {
                    self.next_page(file)?;
                }
                continue;
            }
            let n = wanted.min(self.page) as usize;
            match (&mut self.decoder, self.is_gap) {
                (Some(decoder), false) => {
                    let done = guarded(|| decoder.numbers(n, to));
                    let count = done.map_err(|why| self.refusal(&why))?;
                    self.page -= n as u64;
                    if let Some(there) = self.there {
                        self.there = there.checked_sub(count);
                        if self.there.is_none() || (self.page == 0 && self.there != Some(0)) {
                            return Err(
                                self.refusal("a page holds another number of numbers than it says")
                            );
                        }
                    }
                }
                _ => {
                    to.extend(std::iter::repeat_n(ABSENT, n));
                    self.page -= n as u64;
                }
            }
            wanted -= n as u64;
        }
        Ok(())
    }

    fn next_page(&mut self, file: &mut dyn SeekRead) -> Result<()> {
        let chunk = &self.chunks[self.chunk];
        let (at, codec) = (self.at, chunk.codec);
        if chunk.lost.is_some_and(|lost| at >= lost) {
            (self.page, self.left, self.is_gap) = (self.left, 0, true);
            return Ok(());
        }
        let head = Head::read(file, at, chunk.end)?;
        let head = head.filter(|h| h.rows() <= self.left);
        let head = head.ok_or_else(|| self.refusal("the file changed while it was read"))?;
        self.is_gap = chunk.damaged.binary_search(&at).is_ok();
        self.at += head.length + head.packed;
        self.page = head.rows();
        self.left -= self.page;
        let is_dictionary = matches!(head.kind, Kind::Dictionary { .. });
        if self.is_gap || (self.page == 0 && !is_dictionary) {
            return Ok(());
        }
        if head.points() && !self.has_dictionary {
            return Err(self.refusal("its dictionary is missing"));
        }
        let column = &self.column;
        let page = head.page(file, at, codec, width(column), column.max_def_level() > 0)?;
        let page = page.map_err(|why| self.refusal(&format!("the page at byte {at} {why}")))?;
        self.hatch.put(page.page);
        self.there = page.there;
        let decoder = match &mut self.decoder {
            Some(decoder) => decoder,
            none => {
                let new = decoder(column, self.meaning, self.hatch.clone());
                none.insert(new.ok_or_else(|| Error::new("no numbers"))?)
            }
        };
        if is_dictionary {
            let done = guarded(|| decoder.dictionary());
            done.map_err(|why| self.refusal(&why))?;
            self.has_dictionary = true;
        }
        Ok(())
    }

    fn refusal(&self, why: &str) -> Error {
        let group = self.chunks.get(self.chunk).map_or(0, |c| c.group);
        Error::new(format!(
            "column {}, row group {group} cannot be read: {why}",
            self.name
        ))
        .with_hint(
            "the file is damaged there: read other columns, or write it again from its source",
        )
    }
}

/// What a decoder says; it may panic over damaged pages.
fn guarded(decode: impl FnOnce() -> Result<u64, ParquetError>) -> Result<u64, String> {
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(done) => done.map_err(words),
        Err(_) => Err("the page is damaged".to_owned()),
    }
}

/// What the crate says, without its own name.
pub(crate) fn words(error: ParquetError) -> String {
    match error {
        ParquetError::General(why) | ParquetError::EOF(why) => why,
        other => other.to_string(),
    }
}
