//! A text in UTF-16 as one in UTF-8.

use std::io::{self, Read};

/// Bytes that are read at a time.
const PIECE: usize = 1 << 15;

/// Turns the code units of a text that begins with a byte order mark; the mark itself is left out. What is no character becomes U+FFFD.
pub(super) struct Utf16Reader<R> {
    reader: R,
    big_endian: bool,
    /// Whether the mark has gone by.
    begun: bool,
    raw: Vec<u8>,
    /// Half of a unit that the next bytes complete.
    odd: Option<u8>,
    /// First half of a pair of surrogates.
    high: Option<u16>,
    out: Vec<u8>,
    at: usize,
}

impl<R: Read> Utf16Reader<R> {
    pub(super) fn new(reader: R, big_endian: bool) -> Self {
        Self {
            reader,
            big_endian,
            begun: false,
            raw: vec![0; PIECE],
            odd: None,
            high: None,
            out: Vec::new(),
            at: 0,
        }
    }

    pub(super) fn get_ref(&self) -> &R {
        &self.reader
    }

    pub(super) fn into_inner(self) -> R {
        self.reader
    }

    /// Decodes another piece; false at the end.
    fn fill(&mut self) -> io::Result<bool> {
        self.out.clear();
        self.at = 0;
        let read = self.reader.read(&mut self.raw)?;
        let mut bytes = Vec::with_capacity(read + 1);
        bytes.extend(self.odd.take());
        bytes.extend_from_slice(&self.raw[..read]);
        let pairs = bytes.chunks_exact(2);
        self.odd = pairs.remainder().first().copied();
        let mut units: Vec<u16> = self.high.take().into_iter().collect();
        units.extend(pairs.map(|p| match self.big_endian {
            true => u16::from_be_bytes([p[0], p[1]]),
            false => u16::from_le_bytes([p[0], p[1]]),
        }));
        if read > 0 && units.last().is_some_and(|u| (0xD800..0xDC00).contains(u)) {
            self.high = units.pop();
        }
        let mut buffer = [0; 4];
        for character in char::decode_utf16(units) {
            let character = character.unwrap_or(char::REPLACEMENT_CHARACTER);
            if !self.begun {
                self.begun = true;
                if character == '\u{FEFF}' {
                    continue;
                }
            }
            self.out
                .extend_from_slice(character.encode_utf8(&mut buffer).as_bytes());
        }
        if read == 0 && self.odd.take().is_some() {
            self.out.extend_from_slice(
                char::REPLACEMENT_CHARACTER
                    .encode_utf8(&mut buffer)
                    .as_bytes(),
            );
        }
        Ok(read > 0)
    }
}

impl<R: Read> Read for Utf16Reader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        while self.at == self.out.len() {
            if !self.fill()? && self.out.is_empty() {
                return Ok(0);
            }
        }
        let n = buffer.len().min(self.out.len() - self.at);
        buffer[..n].copy_from_slice(&self.out[self.at..self.at + n]);
        self.at += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte at a time.
    struct Dripping(io::Cursor<Vec<u8>>);

    impl Read for Dripping {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let one = buffer.len().min(1);
            self.0.read(&mut buffer[..one])
        }
    }

    fn coded(text: &str, big_endian: bool) -> Vec<u8> {
        let units = std::iter::once(0xFEFF).chain(text.encode_utf16());
        units
            .flat_map(|u: u16| match big_endian {
                true => u.to_be_bytes(),
                false => u.to_le_bytes(),
            })
            .collect()
    }

    #[test]
    fn law_a_text_comes_out_as_it_was_whatever_the_pieces() {
        let long: String = "Zeit [s]\tBeschl. [m/s²]\n".repeat(3000);
        for text in ["", "t,µ\n1,2\n", "a\u{1F600}b", &long] {
            for big_endian in [false, true] {
                let bytes = coded(text, big_endian);
                let mut whole = String::new();
                let mut reader = Utf16Reader::new(io::Cursor::new(bytes.clone()), big_endian);
                reader.read_to_string(&mut whole).expect("memory");
                assert_eq!(whole, text);
                let mut dripped = String::new();
                let mut reader = Utf16Reader::new(Dripping(io::Cursor::new(bytes)), big_endian);
                reader.read_to_string(&mut dripped).expect("memory");
                assert_eq!(dripped, text);
            }
        }
    }

    #[test]
    fn law_what_is_no_character_is_marked_and_nothing_is_lost_behind_it() {
        // A lone surrogate, then a letter, then half a unit.
        let bytes = [0xFF, 0xFE, 0x00, 0xD8, b'a', 0, b'b'];
        let mut text = String::new();
        let mut reader = Utf16Reader::new(io::Cursor::new(bytes), false);
        reader.read_to_string(&mut text).expect("memory");
        assert_eq!(text, "\u{FFFD}a\u{FFFD}");
    }
}
