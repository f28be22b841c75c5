//! Lines of a file, each with a bound, and numbers in fields.

use crate::stream::SeekRead;
use crate::{Error, Result};
use std::io::{Read, SeekFrom};

/// A line longer than this is none.
const LONGEST_LINE: usize = 1 << 20;
/// Bytes that are fetched at once.
const PIECE: u64 = 1 << 16;

/// Reads line after line.
pub(crate) struct Lines<'a> {
    file: &'a mut dyn SeekRead,
    held: Vec<u8>,
    /// Where the next line begins in what is held.
    at: usize,
    /// Where what is held begins in the file.
    start: u64,
    ended: bool,
    /// Whether the line that came last has no end: it may be cut, and its last number too.
    pub(crate) is_open: bool,
}

impl<'a> Lines<'a> {
    pub(crate) fn from(file: &'a mut dyn SeekRead, start: u64) -> Result<Self> {
        file.seek(SeekFrom::Start(start))?;
        Ok(Self {
            file,
            held: Vec::new(),
            at: 0,
            start,
            ended: false,
            is_open: false,
        })
    }

    /// Byte of the file at which the next line begins.
    pub(crate) fn place(&self) -> u64 {
        self.start + self.at as u64
    }

    /// Goes on from another byte.
    pub(crate) fn go_to(&mut self, place: u64) -> Result<()> {
        self.file.seek(SeekFrom::Start(place))?;
        self.held.clear();
        (self.at, self.start, self.ended) = (0, place, false);
        Ok(())
    }

    /// The next line without its end; `None` at the end of the file.
    pub(crate) fn next_line(&mut self) -> Result<Option<&[u8]>> {
        let mut looked = self.at;
        let end = loop {
            let rest = &self.held[looked..];
            if let Some(end) = rest.iter().position(|b| *b == b'\n') {
                break looked + end;
            }
            looked = self.held.len();
            if self.ended {
                break looked;
            }
            if looked - self.at > LONGEST_LINE {
                return Err(Error::new(format!(
                    "the line at byte {} is longer than 1 MiB",
                    self.place()
                )));
            }
            if self.at > LONGEST_LINE {
                self.held.drain(..self.at);
                self.start += self.at as u64;
                looked -= self.at;
                self.at = 0;
            }
            let mut piece = (&mut *self.file).take(PIECE);
            self.ended = piece.read_to_end(&mut self.held)? == 0;
        };
        if self.at >= self.held.len() {
            return Ok(None);
        }
        self.is_open = end == self.held.len();
        let line = &self.held[self.at..end];
        self.at = (end + 1).min(self.held.len());
        Ok(Some(line.strip_suffix(b"\r").unwrap_or(line)))
    }
}

/// A number, also with the exponent mark D of Fortran.
pub(crate) fn number(field: &[u8]) -> Option<f64> {
    let field = std::str::from_utf8(field.trim_ascii()).ok()?;
    if let Ok(number) = field.parse() {
        return Some(number);
    }
    field.replace(['D', 'd'], "E").parse().ok()
}

/// The part of a line between two columns, as far as it is there.
pub(crate) fn columns(line: &[u8], from: usize, to: usize) -> &[u8] {
    let from = from.min(line.len());
    line[from..to.clamp(from, line.len())].trim_ascii()
}
