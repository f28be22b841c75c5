//! An LZ4 frame, block by block: a decoder of its own, since the format is a page long and a crate for it is twenty times this file.
//!
//! **Source** `[LZ4]`.

use crate::bytes::{Bytes, Order};
use std::hash::Hasher;
use std::io::{self, Read};
use twox_hash::XxHash32;

const MAGIC: u32 = 0x184D_2204;
/// How far back a match may lie.
const BACK: usize = 1 << 16;

/// Reads the content of a frame.
pub(crate) struct Lz4<'a> {
    packed: Bytes<'a>,
    /// The end of what was given, and what is to be given.
    held: Vec<u8>,
    given: usize,
    largest: usize,
    block_sums: bool,
    content_sum: Option<XxHash32>,
    ended: bool,
}

fn bad(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

impl<'a> Lz4<'a> {
    pub(crate) fn new(packed: &'a [u8]) -> io::Result<Self> {
        let short = || bad("the head of the LZ4 frame is not whole");
        let mut b = Bytes::new(packed, Order::Little);
        if b.u32() != Some(MAGIC) {
            return Err(bad("no LZ4 frame"));
        }
        let before = b.rest();
        let (flags, size) = (b.u8().ok_or_else(short)?, b.u8().ok_or_else(short)?);
        if flags >> 6 != 1 || flags & 1 != 0 {
            return Err(bad("an LZ4 frame of another version, or with a dictionary"));
        }
        if flags & 8 != 0 {
            b.u64().ok_or_else(short)?;
        }
        let described = &before[..before.len() - b.rest().len()];
        let sum = XxHash32::oneshot(0, described) >> 8 & 0xFF;
        if u32::from(b.u8().ok_or_else(short)?) != sum {
            return Err(bad(
                "the check sum of the head of the LZ4 frame does not hold",
            ));
        }
        Ok(Self {
            packed: b,
            held: Vec::new(),
            given: 0,
            largest: 1 << (8 + 2 * (size >> 4 & 7)).max(16),
            block_sums: flags & 16 != 0,
            content_sum: (flags & 4 != 0).then(|| XxHash32::with_seed(0)),
            ended: false,
        })
    }

    /// Unpacks the next block behind what is held; `false` at the end of the frame.
    fn next_block(&mut self) -> io::Result<bool> {
        let cut = || io::Error::from(io::ErrorKind::UnexpectedEof);
        let head = self.packed.u32().ok_or_else(cut)?;
        if head == 0 {
            if let Some(sum) = &self.content_sum
                && u64::from(self.packed.u32().ok_or_else(cut)?) != sum.finish()
            {
                return Err(bad("the check sum of the LZ4 frame does not hold"));
            }
            return Ok(false);
        }
        let length = (head & 0x7FFF_FFFF) as usize;
        if length > self.largest {
            return Err(bad("an LZ4 block is larger than its frame says"));
        }
        let block = self.packed.take(length).ok_or_else(cut)?;
        if self.block_sums && self.packed.u32().ok_or_else(cut)? != XxHash32::oneshot(0, block) {
            return Err(bad("the check sum of an LZ4 block does not hold"));
        }
        let old = self.held.len().saturating_sub(BACK);
        self.held.drain(..old);
        self.given = self.held.len();
        match head >> 31 {
            1 => self.held.extend_from_slice(block),
            _ => {
                let most = self.given + self.largest;
                unpack(block, &mut self.held, most)
                    .ok_or_else(|| bad("an LZ4 block is damaged"))?;
            }
        }
        if let Some(sum) = &mut self.content_sum {
            sum.write(&self.held[self.given..]);
        }
        Ok(true)
    }
}

impl Read for Lz4<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        while self.given == self.held.len() {
            if self.ended || !self.next_block()? {
                self.ended = true;
                return Ok(0);
            }
        }
        let n = to.len().min(self.held.len() - self.given);
        to[..n].copy_from_slice(&self.held[self.given..self.given + n]);
        self.given += n;
        Ok(n)
    }
}

/// Appends the content of a block, up to a length in all; nothing where it is damaged.
fn unpack(block: &[u8], to: &mut Vec<u8>, most: usize) -> Option<()> {
    let mut b = Bytes::new(block, Order::Little);
    loop {
        let token = b.u8()?;
        let literals = length(&mut b, token >> 4)?;
        to.extend_from_slice(b.take(literals)?);
        if to.len() > most {
            return None;
        }
        if b.rest().is_empty() {
            return Some(());
        }
        let back = usize::from(b.u16()?);
        let count = length(&mut b, token & 15)? + 4;
        let from = to.len().checked_sub(back).filter(|_| back > 0)?;
        if to.len() + count > most {
            return None;
        }
        // A match may overlap what it makes: each turn copies what is there by then.
        let end = to.len() + count;
        while to.len() < end {
            let n = (to.len() - from).min(end - to.len());
            to.extend_from_within(from..from + n);
        }
    }
}

/// A length of four bits, and bytes behind it where they are full.
fn length(b: &mut Bytes<'_>, bits: u8) -> Option<usize> {
    let mut length = usize::from(bits);
    if bits == 15 {
        loop {
            let more = b.u8()?;
            length += usize::from(more);
            if more < 255 {
                break;
            }
        }
    }
    Some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_frame_with_an_overlapping_match_and_bad_sums() {
        // Descriptor of independent blocks of 64 KiB; "abc" once, six bytes from three back, then "z": abcabcabcz.
        let descriptor = [0x60, 0x40];
        let block = [0x32, b'a', b'b', b'c', 3, 0, 0x10, b'z'];
        let mut frame = MAGIC.to_le_bytes().to_vec();
        frame.extend(descriptor);
        frame.push((XxHash32::oneshot(0, &descriptor) >> 8) as u8);
        frame.extend((block.len() as u32).to_le_bytes());
        frame.extend(block);
        frame.extend((0x8000_0002_u32).to_le_bytes());
        frame.extend(b"!?");
        frame.extend([0; 4]);
        let read = |frame: &[u8]| {
            let mut content = Vec::new();
            Lz4::new(frame)?.read_to_end(&mut content)?;
            io::Result::Ok(content)
        };
        assert_eq!(read(&frame).unwrap(), b"abcabcabcz!?");
        assert!(read(&frame[..frame.len() - 1]).is_err());
        for at in 0..frame.len() {
            let mut damaged = frame.clone();
            damaged[at] ^= 0xFF;
            let _ = read(&damaged);
        }
        frame[6] ^= 1;
        assert!(read(&frame).is_err_and(|e| e.to_string().contains("check sum of the head")));
    }
}
