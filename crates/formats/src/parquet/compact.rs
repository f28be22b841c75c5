//! The compact protocol of Thrift, in which the index and the heads of pages are written: as much of it as is needed to see that
//! sizes hold before anybody asks for memory by them.
//!
//! **Source** `[THRIFT]`.

use crate::bytes::{Bytes, Order};

/// Structures within structures.
const DEEPEST: usize = 32;
/// Groups within groups of a schema.
const DEEPEST_SCHEMA: usize = 64;

const TRUE: u8 = 1;
const FALSE: u8 = 2;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A place in bytes; every reading is `None` where they are damaged.
pub(super) struct Compact<'a> {
    bytes: Bytes<'a>,
}

impl<'a> Compact<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes: Bytes::new(bytes, Order::Little),
        }
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.rest().len()
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.bytes.u8()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    pub(super) fn int(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// Number and kind of the next field of a structure; an inner `None` at its end.
    pub(super) fn field(&mut self, last: &mut i64) -> Option<Option<(i64, u8)>> {
        let head = self.bytes.u8()?;
        if head == 0 {
            return Some(None);
        }
        *last = match head >> 4 {
            0 => self.int()?,
            step => last.checked_add(i64::from(step))?,
        };
        Some(Some((*last, head & 0xF)))
    }

    /// Length of a list, of which each element takes a byte at least, and the kind of its elements.
    fn list(&mut self) -> Option<(usize, u8)> {
        let head = self.bytes.u8()?;
        let size = match head >> 4 {
            15 => usize::try_from(self.varint()?).ok()?,
            size => usize::from(size),
        };
        (size <= self.left()).then_some((size, head & 0xF))
    }

    /// Passes over a value.
    pub(super) fn skip(&mut self, kind: u8) -> Option<()> {
        self.skip_within(kind, DEEPEST)
    }

    fn skip_within(&mut self, kind: u8, depth: usize) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            TRUE | FALSE => {}
            3 => drop(self.bytes.u8()?),
            4..=6 => drop(self.varint()?),
            7 => drop(self.bytes.take(8)?),
            8 => {
                let length = usize::try_from(self.varint()?).ok()?;
                self.bytes.take(length)?;
            }
            LIST | 10 => {
                let (size, kind) = self.list()?;
                for _ in 0..size {
                    match kind {
                        TRUE | FALSE => drop(self.bytes.u8()?),
                        _ => self.skip_within(kind, depth)?,
                    }
                }
            }
            11 => {
                let size = usize::try_from(self.varint()?).ok()?;
                if size > self.left() {
                    return None;
                }
                let kinds = if size > 0 { self.bytes.u8()? } else { 0 };
                for _ in 0..size {
                    for kind in [kinds >> 4, kinds & 0xF] {
                        match kind {
                            TRUE | FALSE => drop(self.bytes.u8()?),
                            _ => self.skip_within(kind, depth)?,
                        }
                    }
                }
            }
            STRUCT => {
                let mut last = 0;
                while let Some((_, kind)) = self.field(&mut last)? {
                    self.skip_within(kind, depth)?;
                }
            }
            13 => drop(self.bytes.take(16)?),
            _ => return None,
        }
        Some(())
    }

    /// The whole numbers of a structure by the number of their field, below `N`; other fields are passed over.
    pub(super) fn numbers<const N: usize>(&mut self) -> Option<[Option<i64>; N]> {
        let mut numbers = [None; N];
        let mut last = 0;
        while let Some((id, kind)) = self.field(&mut last)? {
            let value = match kind {
                TRUE => Some(1),
                FALSE => Some(0),
                4..=6 => Some(self.int()?),
                _ => {
                    self.skip(kind)?;
                    None
                }
            };
            let place = usize::try_from(id).ok().and_then(|id| numbers.get_mut(id));
            if let Some(place) = place {
                *place = value;
            }
        }
        Some(numbers)
    }
}

/// Whether an index is whole: every list is as long as it says, and the schema is a tree that is not too deep.
pub(super) fn is_whole(index: &[u8]) -> bool {
    const SCHEMA: i64 = 2;
    const CHILDREN: usize = 5;
    let walk = || -> Option<()> {
        let mut at = Compact::new(index);
        let mut last = 0;
        while let Some((id, kind)) = at.field(&mut last)? {
            if (id, kind) != (SCHEMA, LIST) {
                at.skip(kind)?;
                continue;
            }
            let (size, kind) = at.list()?;
            // Children that are still to come, of each group that is open.
            let mut open: Vec<usize> = Vec::new();
            for element in 0..size {
                if kind != STRUCT || (element > 0 && open.is_empty()) {
                    return None;
                }
                let children = at.numbers::<6>()?[CHILDREN].unwrap_or(0);
                let children = usize::try_from(children).ok()?;
                if let Some(last) = open.last_mut() {
                    *last -= 1;
                }
                open.push(children);
                if children > size || open.len() > DEEPEST_SCHEMA {
                    return None;
                }
                while open.last() == Some(&0) {
                    open.pop();
                }
            }
            if !open.is_empty() {
                return None;
            }
        }
        Some(())
    };
    walk().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_fields_and_lists_that_claim_too_much() {
        // Field 1 is -3, field 3 true, field 20 a list of two texts.
        let bytes = b"\x15\x05\x21\x09\x28\x28\x01a\x00\x00rest";
        let mut at = Compact::new(bytes);
        assert_eq!(at.numbers::<4>(), Some([None, Some(-3), None, Some(1)]));
        assert_eq!(at.left(), 4);
        assert!(is_whole(bytes));
        for broken in [
            &b"\x19\xFC\xFF\xFF\xFF\xFF\x07\x00"[..],
            b"\x19\x5C\x00\x00\x00",
            &b"\x1C".repeat(1000),
            b"\x29\x1C\x55\x02\x00\x00",
            b"",
        ] {
            assert!(!is_whole(broken));
        }
    }
}
