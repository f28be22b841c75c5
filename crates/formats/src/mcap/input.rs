//! Bytes one after the other, with their place and their check sum.

use flate2::Crc;
use std::io::{self, Read};

/// Bytes that are read at once.
const PIECE: usize = 1 << 18;

/// Reads ahead, and holds what was read and not yet taken.
pub(super) struct Input<'a> {
    from: &'a mut dyn Read,
    held: Vec<u8>,
    /// What of it was taken, and what of that is in the check sum.
    taken: usize,
    summed: usize,
    /// Place of the first byte that is held.
    start: u64,
    crc: Crc,
    /// Why there is no more, where it is not the end.
    pub(super) failed: Option<io::Error>,
}

impl<'a> Input<'a> {
    pub(super) fn new(from: &'a mut dyn Read, place: u64) -> Self {
        Self {
            from,
            held: Vec::new(),
            taken: 0,
            summed: 0,
            start: place,
            crc: Crc::new(),
            failed: None,
        }
    }

    /// Where the next byte stands.
    pub(super) fn place(&self) -> u64 {
        self.start + self.taken as u64
    }

    /// CRC-32 of all that was taken.
    pub(super) fn sum(&mut self) -> u32 {
        self.crc.update(&self.held[self.summed..self.taken]);
        self.summed = self.taken;
        self.crc.sum()
    }

    /// Lets go of what was taken, and reads until so many bytes are held; `false` where there are fewer.
    fn fill(&mut self, n: usize) -> bool {
        self.sum();
        self.held.drain(..self.taken);
        self.start += self.taken as u64;
        (self.taken, self.summed) = (0, 0);
        if self.failed.is_none() {
            let wanted = n.max(PIECE) - self.held.len();
            let mut more = (&mut *self.from).take(wanted as u64);
            self.failed = more.read_to_end(&mut self.held).err();
        }
        self.held.len() >= n
    }

    fn rest(&self) -> &[u8] {
        &self.held[self.taken..]
    }

    /// The next byte, which is not taken; nothing at the end.
    pub(super) fn peek(&mut self) -> Option<u8> {
        if self.rest().is_empty() {
            self.fill(1);
        }
        self.rest().first().copied()
    }

    /// The next bytes; nothing where there are fewer.
    pub(super) fn bytes(&mut self, n: usize) -> Option<&[u8]> {
        if self.rest().len() < n && !self.fill(n) {
            return None;
        }
        let at = self.taken;
        self.taken += n;
        Some(&self.held[at..at + n])
    }

    /// Passes over so many bytes; nothing where there are fewer.
    pub(super) fn skip(&mut self, mut n: u64) -> Option<()> {
        loop {
            let here = n.min(self.rest().len() as u64);
            self.taken += here as usize;
            n -= here;
            if n == 0 {
                return Some(());
            }
            if !self.fill(1) {
                return None;
            }
        }
    }
}

/// The next so many bytes of another input.
pub(super) struct Part<'i, 'a> {
    pub(super) of: &'i mut Input<'a>,
    pub(super) left: u64,
}

impl Read for Part<'_, '_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 || to.is_empty() || self.of.peek().is_none() {
            return Ok(0);
        }
        let n = self.left.min(self.of.rest().len() as u64);
        let n = n.min(to.len() as u64) as usize;
        to[..n].copy_from_slice(&self.of.rest()[..n]);
        self.of.taken += n;
        self.left -= n as u64;
        Ok(n)
    }
}
