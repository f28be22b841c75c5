//! The fields of one line, and the number in a field.

use crate::layout::{Separator, sniff};
use proofmass_uncertainty::DecimalMark;

/// Walks over the fields of one line.
pub(crate) struct Fields<'a> {
    line: &'a [u8],
    at: usize,
    separator: Separator,
    byte: Option<u8>,
    done: bool,
}

impl<'a> Fields<'a> {
    pub(crate) fn new(line: &'a [u8], separator: Separator) -> Self {
        let line = if separator == Separator::Whitespace {
            line.trim_ascii()
        } else {
            line
        };
        Self {
            line,
            at: 0,
            separator,
            byte: separator.byte(),
            done: false,
        }
    }

    /// The finite number at the present place when it fills its field; nothing is consumed otherwise.
    pub(crate) fn number(&mut self) -> Option<f64> {
        if self.done {
            return None;
        }
        let mut at = self.at;
        // A tabulator may be the separator itself.
        while at < self.line.len() && self.line[at] == b' ' {
            at += 1;
        }
        if self.line.get(at) == Some(&b'+')
            && self
                .line
                .get(at + 1)
                .is_some_and(|b| b.is_ascii_digit() || *b == b'.')
        {
            at += 1;
        }
        let (value, used) = fast_float2::parse_partial::<f64, _>(&self.line[at..]).ok()?;
        if !is_reading(value) || used == 0 {
            return None;
        }
        at += used;
        match self.byte {
            Some(separator) => {
                while at < self.line.len() && self.line[at] == b' ' {
                    at += 1;
                }
                match self.line.get(at) {
                    None => self.done = true,
                    Some(&b) if b == separator => at += 1,
                    Some(_) => return None,
                }
            }
            None => {
                if at == self.line.len() {
                    self.done = true;
                } else {
                    let blank = |b: &u8| matches!(b, b' ' | b'\t');
                    if !blank(&self.line[at]) {
                        return None;
                    }
                    while self.line.get(at).is_some_and(blank) {
                        at += 1;
                    }
                }
            }
        }
        self.at = at;
        Some(value)
    }

    /// The next field, trimmed, quotes kept. Separators inside quotes do not split.
    pub(crate) fn next_field(&mut self) -> Option<&'a [u8]> {
        if self.done {
            return None;
        }
        let rest = &self.line[self.at..];
        let quoted = rest.trim_ascii_start().first() == Some(&b'"');
        let end = if quoted {
            let mut inside = false;
            rest.iter().position(|&b| {
                if b == b'"' {
                    inside = !inside;
                }
                !inside && self.separates(b)
            })
        } else {
            match self.byte {
                Some(separator) => memchr::memchr(separator, rest),
                None => memchr::memchr2(b' ', b'\t', rest),
            }
        };
        match end {
            Some(end) => {
                self.at += end + 1;
                if self.separator == Separator::Whitespace {
                    while self.line.get(self.at).is_some_and(|&b| self.separates(b)) {
                        self.at += 1;
                    }
                }
                Some(rest[..end].trim_ascii())
            }
            None => {
                self.done = true;
                Some(rest.trim_ascii())
            }
        }
    }

    fn separates(&self, b: u8) -> bool {
        match self.byte {
            Some(separator) => b == separator,
            None => b == b' ' || b == b'\t',
        }
    }
}

/// Reads a whole field as a number; NaN and infinities are returned as such, text as `None`.
///
/// Understood beside the usual forms: a leading plus sign, quotes around the number, `D` as the mark of the
/// exponent.
pub fn parse_number(field: &[u8], decimal: DecimalMark) -> Option<f64> {
    let field = field.trim_ascii();
    let field = field
        .strip_prefix(b"\"")
        .and_then(|f| f.strip_suffix(b"\""))
        .unwrap_or(field)
        .trim_ascii();
    let field = match field.strip_prefix(b"+") {
        Some(rest) if rest.first().is_some_and(|b| *b != b'-' && *b != b'+') => rest,
        Some(_) => return None,
        None => field,
    };
    if decimal == DecimalMark::Point
        && let Ok(value) = fast_float2::parse::<f64, _>(field)
    {
        return Some(value);
    }
    // Rare forms are rewritten into the usual one.
    if field.len() > 64 || field.is_empty() {
        return None;
    }
    let mut buffer = [0_u8; 64];
    for (to, &from) in buffer.iter_mut().zip(field) {
        *to = match from {
            b',' if decimal == DecimalMark::Comma => b'.',
            // Beside decimal commas a point may group thousands: refused.
            b'.' if decimal == DecimalMark::Comma => return None,
            b'D' | b'd' => b'e',
            other => other,
        };
    }
    fast_float2::parse(&buffer[..field.len()]).ok()
}

/// The field as a message shows it: decoded, on one line, not longer than forty characters.
pub fn shown(field: &[u8]) -> String {
    let text = sniff::decode(field);
    let short: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if short.chars().count() < text.chars().count() {
        format!("{short}…")
    } else {
        short
    }
}

/// The mark that a file does not have.
pub(crate) fn other_mark(decimal: DecimalMark) -> DecimalMark {
    match decimal {
        DecimalMark::Point => DecimalMark::Comma,
        DecimalMark::Comma => DecimalMark::Point,
    }
}

/// Whether a number can be a reading: finite, and so far from the largest double that squares and sums stay finite.
pub fn is_reading(value: f64) -> bool {
    value.abs() < 1e100
}
