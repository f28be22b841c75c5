//! Members of a ZIP archive, by its directory at the end: stored or deflated, with their check sums.
//!
//! **Source** `[ZIP]`.

use crate::bytes::{Bytes, Order, text};
use crate::names::shown;
use crate::raw::bytes_at;
use crate::stream::SeekRead;
use crate::{Error, Result};
use flate2::Crc;
use flate2::read::DeflateDecoder;
use std::io::Read;

/// Bytes in which the end of the directory may lie.
const TAIL: u64 = 66_000;

/// A file in an archive.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) name: String,
    method: u16,
    crc: u32,
    packed: u64,
    at: u64,
}

/// The members in the order of the directory.
pub(crate) fn members(file: &mut dyn SeekRead, size: u64) -> Result<Vec<Member>> {
    let none = || {
        Error::new("the directory at the end of the ZIP archive is missing or damaged")
            .with_hint("the file was cut short: fetch it again; nothing in it can be found without the directory")
    };
    let start = size.saturating_sub(TAIL);
    let tail = bytes_at(file, start, TAIL)?;
    let mark = tail
        .windows(4)
        .rposition(|w| w == b"PK\x05\x06")
        .ok_or_else(none)?;
    let mut end = Bytes::new(&tail[mark..], Order::Little);
    end.take(10);
    let (count, length, at) = (end.u16(), end.u32(), end.u32());
    let (count, length, at) = (
        count.ok_or_else(none)?,
        length.ok_or_else(none)?,
        at.ok_or_else(none)?,
    );
    let directory = bytes_at(file, u64::from(at), u64::from(length))?;
    let mut b = Bytes::new(&directory, Order::Little);
    let mut members = Vec::new();
    for _ in 0..count {
        members.push(member(&mut b).ok_or_else(none)?);
    }
    Ok(members)
}

fn member(b: &mut Bytes<'_>) -> Option<Member> {
    if b.take(4)? != b"PK\x01\x02" {
        return None;
    }
    b.take(6)?;
    let method = b.u16()?;
    b.take(4)?;
    let (crc, packed) = (b.u32()?, b.u32()?);
    b.u32()?;
    let (name, extra, comment) = (b.u16()?, b.u16()?, b.u16()?);
    b.take(8)?;
    let at = b.u32()?;
    let name = shown(&text(b.take(usize::from(name))?));
    b.take(usize::from(extra) + usize::from(comment))?;
    Some(Member {
        name,
        method,
        crc,
        packed: u64::from(packed),
        at: u64::from(at),
    })
}

impl Member {
    /// Its content, and whether its check sum holds; `left` is what the archive may still unpack to.
    pub(crate) fn content(
        &self,
        file: &mut dyn SeekRead,
        left: &mut u64,
    ) -> Result<(Vec<u8>, bool)> {
        let damaged = || Error::new(format!("{} in the ZIP archive is damaged", self.name));
        let head = bytes_at(file, self.at, 30)?;
        let mut b = Bytes::new(&head, Order::Little);
        if b.take(4) != Some(b"PK\x03\x04") {
            return Err(damaged());
        }
        b.take(22);
        let (Some(name), Some(extra)) = (b.u16(), b.u16()) else {
            return Err(damaged());
        };
        let at = self.at + 30 + u64::from(name) + u64::from(extra);
        let packed = bytes_at(file, at, self.packed)?;
        let mut whole = packed.len() as u64 == self.packed;
        let content = match self.method {
            0 => packed,
            8 => {
                let mut content = Vec::new();
                let mut reader = DeflateDecoder::new(&packed[..]).take(*left + 1);
                whole &= reader.read_to_end(&mut content).is_ok();
                content
            }
            method => {
                return Err(Error::new(format!(
                    "{} in the ZIP archive is packed by method {method}, which is not read here",
                    self.name
                ))
                .with_hint("pack it again with deflate"));
            }
        };
        // Members may lie on top of each other, stored or packed.
        *left = left.checked_sub(content.len() as u64).ok_or_else(|| {
            Error::new(format!(
                "{} in the ZIP archive unpacks to more than a file of this size may",
                self.name
            ))
            .with_hint("unpack the archive, and name the file inside")
        })?;
        let mut crc = Crc::new();
        crc.update(&content);
        Ok((content, whole && crc.sum() == self.crc))
    }
}
