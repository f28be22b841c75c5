//! Parquet, the files of columns of the data tools: their index at the end says where the pages of each column lie.
//!
//! The index and the coding of numbers are read by the crate `parquet`. Heads, check sums and packing of the pages are read here: the
//! crate asks for memory by what they claim, and gives up at the first page that is damaged.
//!
//! **Source** `[PARQUET]`.

mod chunks;
mod compact;
mod numbers;
mod page;

use crate::raw::bytes_at;
use crate::stream::{Clock, Column, Contents, Remark, SeekRead, Source, Stream};
use crate::{Error, Result};
use ::parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};
use ::parquet::schema::types::ColumnDescriptor;
use chunks::Chunk;
use numbers::Meaning;
use std::ops::Range;
use std::panic::catch_unwind;

pub(crate) use chunks::{Chunks, words};

/// Bytes of the mark at the beginning, and of length and mark at the end.
const MARK: u64 = 4;
const TAIL: u64 = 8;
/// Rows that a file may have for each of its bytes, and without: columns that never change take next to none.
const ROWS_PER_BYTE: u64 = 1 << 12;
const ROWS_ANYHOW: u64 = 1 << 22;
/// Columns that a remark names.
const NAMED: usize = 5;
/// Key of the unit of a column, before its name.
const UNIT_KEY: &str = "unit.";
/// Key of the recordings of a table that `convert` wrote: a line for each, its row groups and its name.
pub(crate) const RECORDINGS: &str = "recordings";

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let (index, data_end) = index(file, size)?;
    check_rows(&index, size)?;
    let about = index.file_metadata();
    let parts = recordings(&index);
    let stream = |(name, groups): &(String, Range<usize>)| {
        let groups = &index.row_groups()[groups.clone()];
        let rows = groups.iter().map(|g| g.num_rows() as u64).sum();
        Stream::new(name.as_str(), Clock::Unsaid, rows)
    };
    let mut streams: Vec<Stream> = parts.iter().map(stream).collect();
    let mut remarks = Vec::new();
    let (mut passed_over, mut times) = (Vec::new(), None);
    for (number, column) in about.schema_descr().columns().iter().enumerate() {
        let name = column.path().parts().join(".");
        let flat = column.max_rep_level() == 0;
        let Some(meaning) = Meaning::of(column).filter(|_| flat) else {
            let name = column.path().parts().first().cloned().unwrap_or(name);
            if passed_over.last() != Some(&name) {
                passed_over.push(name);
            }
            continue;
        };
        let mut chunks = Vec::new();
        for (group, row_group) in index.row_groups().iter().enumerate() {
            let rows = row_group.num_rows() as u64;
            let chunk = row_group.column(number);
            let mut chunk = place(chunk, group + 1, rows, data_end, column)?;
            chunk.check(file, &name, &mut remarks)?;
            chunks.push(chunk);
        }
        let pairs = about.key_value_metadata().into_iter().flatten();
        let mut units = pairs.filter(|p| p.key.strip_prefix(UNIT_KEY) == Some(&name));
        let unit = units.next().and_then(|p| p.value.clone());
        let mut chunks = chunks.into_iter();
        let sources = parts.iter().map(|(_, groups)| {
            let chunks = chunks.by_ref().take(groups.len()).collect();
            let chunks = Chunks::new(name.clone(), column.clone(), meaning, chunks);
            Source::Parquet(Box::new(chunks))
        });
        let sources: Vec<Source> = sources.collect();
        let unit = match meaning {
            Meaning::Time { is_stamp: true, .. } if times.is_none() => {
                times = Some((name, sources));
                continue;
            }
            Meaning::Time { .. } => Some("s".to_owned()),
            _ => unit,
        };
        for (stream, source) in streams.iter_mut().zip(sources) {
            stream.push(name.clone(), unit.clone(), Column::of(source));
        }
    }
    if let Some((name, times)) = times {
        for (stream, times) in streams.iter_mut().zip(times) {
            stream.clock = Clock::Times;
            stream.push(name.clone(), Some("s".to_owned()), Column::of(times));
        }
    }
    if let Some(remark) = remark(&passed_over) {
        remarks.push(remark);
    }
    Ok(Contents { streams, remarks })
}

/// Names of the recordings of a table, and their row groups: one where nothing says that there are several.
fn recordings(index: &ParquetMetaData) -> Vec<(String, Range<usize>)> {
    let groups = index.num_row_groups();
    let pairs = index.file_metadata().key_value_metadata();
    let said = pairs.into_iter().flatten().find(|p| p.key == RECORDINGS);
    let said = said.and_then(|p| p.value.as_deref()).unwrap_or_default();
    let (mut all, mut begin) = (Vec::new(), 0_usize);
    for line in said.lines() {
        let Some((count, name)) = line.split_once('\t') else {
            break;
        };
        let Some(end) = count.parse().ok().and_then(|n: usize| begin.checked_add(n)) else {
            break;
        };
        all.push((name.to_owned(), begin..end));
        begin = end;
    }
    // Another program may have copied the words and changed the groups.
    match begin == groups && all.len() > 1 {
        true => all,
        false => vec![("table".to_owned(), 0..groups)],
    }
}

/// The index, and where it begins.
fn index(file: &mut dyn SeekRead, size: u64) -> Result<(ParquetMetaData, u64)> {
    let tail = bytes_at(file, size.saturating_sub(TAIL), TAIL)?;
    let missing = || {
        Error::new("is a Parquet file whose index at the end is missing: it was cut short, or is still being written")
            .with_hint("fetch it again, or let the recorder finish: nothing in it can be found without the index")
    };
    let damaged = |why: &str| {
        Error::new(format!(
            "is a Parquet file whose index at the end is damaged{why}"
        ))
        .with_hint("fetch it again: nothing in it can be found without the index")
    };
    let (length, mark) = tail.split_first_chunk().ok_or_else(missing)?;
    match mark {
        b"PAR1" => {}
        b"PARE" => {
            return Err(Error::new("is an encrypted Parquet file")
                .with_hint("decrypt it, with the keys of its writer"));
        }
        _ => return Err(missing()),
    }
    let length = u64::from(u32::from_le_bytes(*length));
    let start = size.checked_sub(TAIL + length).filter(|s| *s >= MARK);
    let start = start.ok_or_else(|| damaged(""))?;
    let bytes = bytes_at(file, start, length)?;
    if !compact::is_whole(&bytes) {
        return Err(damaged(""));
    }
    // Groups and columns that do not fit together make the crate panic.
    match catch_unwind(|| ParquetMetaDataReader::decode_metadata(&bytes)) {
        Ok(Ok(index)) => Ok((index, start)),
        Ok(Err(e)) => Err(damaged(&format!(": {}", words(e)))),
        Err(_) => Err(damaged("")),
    }
}

/// Refuses a file whose columns and row groups do not have as many rows as it says.
fn check_rows(index: &ParquetMetaData, size: u64) -> Result<()> {
    let different = |what: &str| {
        Error::new(format!("is a Parquet file {what}"))
            .with_hint("it was written wrongly: write it again, with another writer")
    };
    let columns = index.file_metadata().schema_descr().columns();
    let mut sum = 0_u64;
    for (group, row_group) in index.row_groups().iter().enumerate() {
        let rows = u64::try_from(row_group.num_rows()).ok();
        let rows = rows.filter(|_| row_group.columns().len() == columns.len());
        let rows =
            rows.ok_or_else(|| different(&format!("whose row group {} is damaged", group + 1)))?;
        for (column, chunk) in columns.iter().zip(row_group.columns()) {
            if column.max_rep_level() == 0 && u64::try_from(chunk.num_values()) != Ok(rows) {
                return Err(different(&format!(
                    "in which column {} has {} numbers in row group {} of {rows} rows",
                    column.path().string(),
                    chunk.num_values(),
                    group + 1
                )));
            }
        }
        sum = sum.saturating_add(rows);
    }
    let stated = index.file_metadata().num_rows();
    if u64::try_from(stated) != Ok(sum) {
        return Err(different(&format!(
            "that says {stated} rows and has {sum} in its row groups"
        )));
    }
    match sum <= ROWS_ANYHOW.saturating_add(size.saturating_mul(ROWS_PER_BYTE)) {
        true => Ok(()),
        false => Err(different(&format!("of {size} bytes that says {sum} rows"))),
    }
}

/// Where the numbers of a column in a row group lie.
fn place(
    chunk: &ColumnChunkMetaData,
    group: usize,
    rows: u64,
    data_end: u64,
    column: &ColumnDescriptor,
) -> Result<Chunk> {
    let name = column.path().string();
    if rows == 0 {
        return Ok(Chunk::new(group, MARK, MARK, 0, chunk.compression()));
    }
    if chunk.file_path().is_some_and(|path| !path.is_empty()) {
        return Err(Error::new(format!("has its column {name} in another file"))
            .with_hint("name that file, or write all columns into one"));
    }
    let codec = chunk.compression();
    if !page::is_known(codec) {
        return Err(Error::new(format!(
            "has its column {name} packed by {codec}, which is not read here"
        ))
        .with_hint("write it again, packed by snappy, zstd, gzip or not at all"));
    }
    // Some writers say 0 where there is no dictionary.
    let dictionary = chunk.dictionary_page_offset().filter(|d| *d > 0);
    let first = chunk.data_page_offset();
    let at = u64::try_from(dictionary.map_or(first, |d| d.min(first))).ok();
    let length = u64::try_from(chunk.compressed_size()).ok();
    let end = at
        .zip(length)
        .and_then(|(at, length)| at.checked_add(length));
    match at.zip(end) {
        Some((at, end)) if at >= MARK && end <= data_end => {
            Ok(Chunk::new(group, at, end, rows, codec))
        }
        _ => Err(Error::new(format!(
            "is a Parquet file whose index says that column {name} of row group {group} lies outside it"
        ))
        .with_hint("the index is damaged, or belongs to another file: fetch it again")),
    }
}

fn remark(passed_over: &[String]) -> Option<Remark> {
    let named = passed_over.iter().take(NAMED);
    let named: Vec<&str> = named.map(String::as_str).collect();
    let more = match passed_over.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!named.is_empty()).then(|| {
        let named = named.join(", ");
        Remark::passed_over(format!("{named}{more}, which hold texts, lists or dates"))
    })
}

#[cfg(test)]
mod tests;
