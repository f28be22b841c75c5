//! Files one behind the other as one.

use crate::stream::SeekRead;
use std::io::{self, Read, Seek, SeekFrom};

/// Files one behind the other.
pub(super) struct Joined {
    /// Where each of them ends.
    parts: Vec<(u64, Box<dyn SeekRead>)>,
    at: u64,
}

impl Joined {
    pub(super) fn new(first: Box<dyn SeekRead>, size: u64) -> Self {
        Self {
            parts: vec![(size, first)],
            at: 0,
        }
    }

    /// One more behind the others: where it begins, and its size.
    pub(super) fn push(&mut self, mut file: Box<dyn SeekRead>) -> io::Result<(u64, u64)> {
        let start = self.size();
        let size = file.seek(SeekFrom::End(0))?;
        self.parts.push((start.saturating_add(size), file));
        Ok((start, size))
    }

    fn size(&self) -> u64 {
        self.parts.last().map_or(0, |p| p.0)
    }
}

impl Read for Joined {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut start = 0;
        for (end, file) in &mut self.parts {
            if self.at < *end {
                let most = (*end - self.at).min(buffer.len() as u64) as usize;
                file.seek(SeekFrom::Start(self.at - start))?;
                let n = file.read(&mut buffer[..most])?;
                self.at += n as u64;
                return Ok(n);
            }
            start = *end;
        }
        Ok(0)
    }
}

impl Seek for Joined {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.size().checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
