//! MCAP logs: records one after the other, many of them in packed chunks, each with the check sum of its content.
//!
//! The data are walked from the beginning; the summary at the end is used where what it repeats was lost.
//!
//! **Source** `[MCAP]`.

use crate::bytes::{Bytes, Order, text};
use crate::input::{Input, Part};
use crate::names::unpacked_bytes;
use crate::raw::bytes_at;
use crate::stream::{Contents, Remark, SeekRead};
use crate::{Error, Result};
use std::io::{Read, SeekFrom};
use topics::Topics;
use unpack::Unpacked;

mod lz4;
mod message;
mod topics;
mod unpack;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Bytes of the footer and of the mark behind it.
const TAIL: u64 = 37;
/// A summary longer than this is not used.
const LONGEST_SUMMARY: u64 = 16 << 20;

/// Kinds of records.
mod kind {
    pub(super) const FOOTER: u8 = 2;
    pub(super) const SCHEMA: u8 = 3;
    pub(super) const CHANNEL: u8 = 4;
    pub(super) const MESSAGE: u8 = 5;
    pub(super) const CHUNK: u8 = 6;
    pub(super) const CHUNK_INDEX: u8 = 8;
    pub(super) const DATA_END: u8 = 15;
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut walk = Walk {
        topics: Topics::new(size),
        remarks: Vec::new(),
        chunks: Vec::new(),
        ended: false,
        damaged: 0,
        first_damaged: None,
        packed_otherwise: None,
        left_out: false,
    };
    walk.summary(file, size)?;
    let mut from = 0;
    loop {
        file.seek(SeekFrom::Start(from))?;
        let mut input = Input::new(file, from);
        let stopped = walk.data(&mut input)?;
        if let Some(error) = input.failed {
            return Err(error.into());
        }
        let Some(at) = stopped else { break };
        // Where the end is there, something before it is damaged: the summary knows where the next chunk begins.
        if !walk.ended {
            walk.remarks.push(Remark::cut(match at == size {
                true => format!("the log ends at byte {size}, without the end of its data"),
                false => format!(
                    "the log ends at byte {size}, inside the record that begins at byte {at}"
                ),
            }));
            break;
        }
        walk.left_out = true;
        let next = walk.chunks.iter().find(|c| **c > at).copied();
        let to = next.unwrap_or(size - TAIL);
        let what =
            format!("the records from byte {at} to byte {to}, which do not follow one another");
        walk.remarks.push(Remark::damaged(what));
        match next {
            Some(next) => from = next,
            None => break,
        }
    }
    walk.contents()
}

struct Walk {
    topics: Topics,
    remarks: Vec<Remark>,
    /// Where the summary says that chunks begin, rising.
    chunks: Vec<u64>,
    /// The end of the file is as it should be.
    ended: bool,
    damaged: u64,
    first_damaged: Option<(u64, String)>,
    /// Chunks packed by something else, and by what.
    packed_otherwise: Option<(u64, String)>,
    left_out: bool,
}

impl Walk {
    /// Walks records up to the end of the data; the place of a record that is not whole, or of which there is no such kind.
    fn data(&mut self, input: &mut Input<'_>) -> Result<Option<u64>> {
        let whole = input.place() == 0;
        if whole && input.bytes(MAGIC.len()).is_none_or(|mark| mark != MAGIC) {
            return Err(Error::new("the signature of the MCAP log is damaged")
                .with_hint("fetch the file again, as bytes and not as text"));
        }
        loop {
            let at = input.place();
            if input.peek() == Some(kind::DATA_END) {
                let sum = input.sum();
                let stated = input.bytes(13).and_then(|b| b.last_chunk::<4>());
                let Some(stated) = stated.map(|b| u32::from_le_bytes(*b)) else {
                    return Ok(Some(at));
                };
                let explained = self.damaged > 0 || self.left_out;
                if whole && stated != 0 && stated != sum && !explained {
                    self.remarks.push(Remark::damaged(format!(
                        "checksum error outside the chunks, before byte {at}: something there is not what was written, and the numbers may be wrong"
                    )));
                }
                return Ok(None);
            }
            let Some((op, length)) = head(input) else {
                return Ok(Some(at));
            };
            let whole = match op {
                0 => None,
                kind::FOOTER => return Ok(None),
                kind::CHUNK => self.chunk(input, at, length)?,
                _ => self.topics.record(op, length, input)?,
            };
            if whole.is_none() {
                return Ok(Some(at));
            }
        }
    }

    /// Takes in a chunk that begins here; nothing where it is not all there.
    fn chunk(&mut self, input: &mut Input<'_>, at: u64, length: u64) -> Result<Option<()>> {
        let end = input.place().saturating_add(length);
        let Some(chunk) = ChunkHead::of(input, length) else {
            self.chunk_is_damaged(at, "its head does not fit its length".to_owned());
            let left = end.checked_sub(input.place());
            return Ok(left.and_then(|left| input.skip(left)));
        };
        let mark = self.topics.mark();
        let mut part = Part {
            of: input,
            left: chunk.packed,
        };
        let content = match chunk.word.as_str() {
            "" => self.records(&mut part, &chunk)?,
            word => {
                let mut packed = Vec::new();
                part.read_to_end(&mut packed)?;
                let most = unpacked_bytes(packed.len() as u64);
                match Unpacked::new(word, &packed) {
                    None => {
                        let other = &mut self.packed_otherwise;
                        other.get_or_insert_with(|| (0, word.to_owned())).0 += 1;
                        Ok(())
                    }
                    Some(_) if chunk.unpacked > most => Err(format!(
                        "its {} bytes claim to unpack to {}",
                        packed.len(),
                        chunk.unpacked
                    )),
                    Some(Err(e)) => Err(e.to_string()),
                    Some(Ok(unpacked)) => {
                        self.records(&mut unpacked.take(chunk.unpacked + 1), &chunk)?
                    }
                }
            }
        };
        // Of a chunk that is cut, what stands before the cut counts.
        if part.left > 0 {
            return Ok(None);
        }
        if let Err(why) = content {
            self.topics.back_to(mark);
            self.chunk_is_damaged(at, why);
        }
        let left = end.checked_sub(input.place());
        Ok(left.and_then(|left| input.skip(left)))
    }

    /// Takes in the records of a chunk; what is wrong with them.
    fn records(&mut self, from: &mut dyn Read, chunk: &ChunkHead) -> Result<Result<(), String>> {
        let mut input = Input::new(from, 0);
        let mut whole = true;
        while whole && input.peek().is_some() {
            whole = match head(&mut input) {
                Some((op, length)) if op != 0 => {
                    self.topics.record(op, length, &mut input)?.is_some()
                }
                _ => false,
            };
        }
        let (sum, length) = (input.sum(), input.place());
        Ok(match input.failed {
            Some(error) => Err(error.to_string()),
            None if !whole => Err("a record in it is not whole".to_owned()),
            None if chunk.sum != 0 && chunk.sum != sum => {
                Err("its check sum does not hold".to_owned())
            }
            None if chunk.sum == 0 && chunk.unpacked != length => {
                Err("it has another length than it says".to_owned())
            }
            None => Ok(()),
        })
    }

    fn chunk_is_damaged(&mut self, at: u64, why: String) {
        self.damaged += 1;
        self.first_damaged.get_or_insert((at, why));
    }

    /// Reads what the summary repeats, where it is there and whole.
    fn summary(&mut self, file: &mut dyn SeekRead, size: u64) -> Result<()> {
        let tail = bytes_at(file, size.saturating_sub(TAIL), TAIL)?;
        let mut b = Bytes::new(&tail, Order::Little);
        let footer = (b.u8(), b.u64(), b.u64(), b.u64(), b.u32());
        let (Some(kind::FOOTER), Some(20), Some(start), _, Some(stated)) = footer else {
            return Ok(());
        };
        self.ended = b.rest() == MAGIC;
        let length = (size - TAIL).saturating_sub(start);
        if !self.ended || start == 0 || length == 0 || length > LONGEST_SUMMARY {
            return Ok(());
        }
        // The check sum goes on to itself in the footer.
        let bytes = bytes_at(file, start, length + 25)?;
        let mut all = &bytes[..];
        let mut input = Input::new(&mut all, 0);
        input.skip(bytes.len() as u64);
        if stated != 0 && input.sum() != stated {
            let what = format!("the summary at byte {start}, which was not used");
            self.remarks.push(Remark::damaged(what));
            return Ok(());
        }
        let mut all = &bytes[..length as usize];
        let mut input = Input::new(&mut all, 0);
        while let Some((op, length)) = head(&mut input) {
            let whole = match (op, usize::try_from(length)) {
                (kind::CHUNK_INDEX, Ok(n)) => input.bytes(n).map(|content| {
                    let at = content.get(16..24).and_then(|b| b.first_chunk::<8>());
                    self.chunks.extend(at.map(|b| u64::from_le_bytes(*b)));
                }),
                _ => self.topics.record(op, length, &mut input)?,
            };
            if whole.is_none() {
                break;
            }
        }
        self.topics.set_aside();
        self.chunks.sort_unstable();
        Ok(())
    }

    fn contents(mut self) -> Result<Contents> {
        if let Some((at, why)) = &self.first_damaged {
            let what = match self.damaged {
                1 => format!("one chunk, at byte {at}: {why}"),
                n => format!("{n} chunks, the first at byte {at}: {why}"),
            };
            self.remarks.push(Remark::damaged(what));
        }
        if let Some((count, word)) = &self.packed_otherwise {
            let what =
                format!("{count} chunks that are packed by \"{word}\"; zstd and lz4 are read");
            self.remarks.push(Remark::passed_over(what));
        }
        self.topics.contents(self.remarks)
    }
}

/// Kind and length of the record that begins here.
fn head(input: &mut Input<'_>) -> Option<(u8, u64)> {
    let mut b = Bytes::new(input.bytes(9)?, Order::Little);
    Some((b.u8()?, b.u64()?))
}

/// What a chunk says of its content.
struct ChunkHead {
    unpacked: u64,
    /// CRC-32, or nothing.
    sum: u32,
    /// How it is packed.
    word: String,
    packed: u64,
}

impl ChunkHead {
    fn of(input: &mut Input<'_>, length: u64) -> Option<Self> {
        const FIXED: u64 = 40;
        let mut b = Bytes::new((length >= FIXED).then(|| input.bytes(32))??, Order::Little);
        b.take(16)?;
        let (unpacked, sum, word) = (b.u64()?, b.u32()?, b.u32()?);
        let left = (length - FIXED).checked_sub(u64::from(word))?;
        let word = text(input.bytes((word <= 64).then_some(word as usize)?)?);
        let packed = Bytes::new(input.bytes(8)?, Order::Little).u64()?;
        (packed <= left).then_some(Self {
            unpacked,
            sum,
            word,
            packed,
        })
    }
}

#[cfg(test)]
mod tests;
