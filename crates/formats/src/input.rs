//! Bytes one after the other, with their place and their check sum.

use flate2::Crc;
use std::io::{self, Read};

/// Bytes that are read at once.
const PIECE: usize = 1 << 18;

/// Reads ahead, and holds what was read and not yet taken.
pub(crate) struct Input<'a> {
    from: &'a mut dyn Read,
    held: Vec<u8>,
    /// What of it was taken, and what of that is in the check sum.
    taken: usize,
    summed: usize,
    /// Place of the first byte that is held.
    start: u64,
    crc: Crc,
    /// Why there is no more, where it is not the end.
    pub(crate) failed: Option<io::Error>,
}

impl<'a> Input<'a> {
    pub(crate) fn new(from: &'a mut dyn Read, place: u64) -> Self {
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
    pub(crate) fn place(&self) -> u64 {
        self.start + self.taken as u64
    }

    /// CRC-32 of all that was taken.
    pub(crate) fn sum(&mut self) -> u32 {
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
    pub(crate) fn peek(&mut self) -> Option<u8> {
        if self.rest().is_empty() {
            self.fill(1);
        }
        self.rest().first().copied()
    }

    /// The next bytes; nothing where there are fewer.
    pub(crate) fn bytes(&mut self, n: usize) -> Option<&[u8]> {
        if self.rest().len() < n && !self.fill(n) {
            return None;
        }
        let at = self.taken;
        self.taken += n;
        Some(&self.held[at..at + n])
    }

    /// The next bytes, which are not taken; fewer at the end.
    pub(crate) fn ahead(&mut self, n: usize) -> &[u8] {
        if self.rest().len() < n {
            self.fill(n);
        }
        let there = self.rest();
        &there[..n.min(there.len())]
    }

    /// Passes over all before the next place where these bytes stand, or over the rest; whether they do.
    pub(crate) fn find(&mut self, bytes: &[u8]) -> bool {
        loop {
            if self.ahead(bytes.len()).len() < bytes.len() {
                self.taken = self.held.len();
                return false;
            }
            let mut places = self.rest().windows(bytes.len());
            if let Some(at) = places.position(|w| w == bytes) {
                self.taken += at;
                return true;
            }
            self.taken = self.held.len() - (bytes.len() - 1);
        }
    }

    /// Passes over so many bytes; nothing where there are fewer.
    pub(crate) fn skip(&mut self, mut n: u64) -> Option<()> {
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
pub(crate) struct Part<'i, 'a> {
    pub(crate) of: &'i mut Input<'a>,
    pub(crate) left: u64,
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
