//! Arrays of chunks: of a fixed length, and such that grow along one side.

use super::{Chunks, Entry};
use crate::bytes::Bytes;
use crate::hdf5::file::{File, Found, UNDEFINED, check_sum, damaged, little};

impl File<'_> {
    /// Elements side by side, from a number on.
    fn elements(
        &self,
        chunks: &Chunks<'_>,
        b: &mut Bytes<'_>,
        array: &Array,
        count: u64,
        to: &mut Vec<Entry>,
    ) -> Option<()> {
        for number in array.next..array.next.checked_add(count)? {
            let place = chunks.place(number, array.slowest);
            let mut element = little(b.take(array.width)?);
            to.extend(chunks.put(self, &mut element, array.width, place)?);
        }
        Some(())
    }

    pub(super) fn fixed_array(
        &mut self,
        chunks: &Chunks<'_>,
        at: u64,
        to: &mut Vec<Entry>,
    ) -> Found<()> {
        let wrong = || damaged("the index of chunks", at);
        let (o, l) = (self.offsets, self.lengths);
        let head = self.checked(at, 12 + (o + l) as u64, b"FAHD")?;
        let mut b = little(&head);
        b.take(2);
        let head = (|| Some((b.u8()?, b.u8()?, self.length(&mut b)?, self.offset(&mut b)?)))();
        let (width, page_bits, count, block) = head.ok_or_else(wrong)?;
        if block == UNDEFINED {
            return Ok(());
        }
        let mut array = Array {
            width: width.into(),
            slowest: 0,
            next: 0,
        };
        let paging = Paging::of(count, page_bits).ok_or_else(wrong)?;
        // Mark, version, kind, address of the head.
        self.block(
            chunks,
            block,
            b"FADB",
            6 + o as u64,
            count,
            &paging,
            &mut array,
            None,
            to,
        )
    }

    /// A block of elements, whole or in pages, of which only those that were written exist.
    #[expect(clippy::too_many_arguments)]
    fn block(
        &mut self,
        chunks: &Chunks<'_>,
        at: u64,
        mark: &[u8; 4],
        before: u64,
        count: u64,
        paging: &Paging,
        array: &mut Array,
        written: Option<&[u8]>,
        to: &mut Vec<Entry>,
    ) -> Found<()> {
        let wrong = || damaged("the index of chunks", at);
        let width = array.width as u64;
        let bytes = |count: u64| count.checked_mul(width).ok_or_else(wrong);
        let Some(pages) = paging.pages else {
            let content = self.checked(at, bytes(count)?.saturating_add(before + 4), mark)?;
            let mut b = little(&content);
            b.take(before as usize - 4);
            let found = self.elements(chunks, &mut b, array, count, to);
            array.next = array.next.saturating_add(count);
            return found.ok_or_else(wrong);
        };
        // In a fixed array the bits of the pages stand in the block itself.
        let own_bits = if written.is_none() {
            pages.div_ceil(8)
        } else {
            0
        };
        let content = self.checked(at, before.saturating_add(own_bits + 4), mark)?;
        let bits = written.unwrap_or(content.get(before as usize - 4..).unwrap_or_default());
        let mut place = at.saturating_add(before + own_bits + 4);
        let mut left = count;
        for page in 0..pages {
            let here = left.min(paging.elements);
            let is_written = bits
                .get((page / 8) as usize)
                .is_some_and(|b| b & (0x80 >> (page % 8)) != 0);
            if is_written {
                let length = bytes(here)?.saturating_add(4);
                let content = self.at(place, length)?;
                let (elements, sum) = content.split_at(content.len() - 4);
                if little(sum).u32() != Some(check_sum(elements)) {
                    return Err(damaged("a page of the index of chunks", place));
                }
                self.elements(chunks, &mut little(elements), array, here, to)
                    .ok_or_else(wrong)?;
            }
            self.spend(8)?;
            array.next = array.next.saturating_add(here);
            place = place.saturating_add(bytes(paging.elements)?.saturating_add(4));
            left -= here;
        }
        Ok(())
    }

    pub(super) fn extensible_array(
        &mut self,
        chunks: &Chunks<'_>,
        at: u64,
        to: &mut Vec<Entry>,
    ) -> Found<()> {
        let wrong = || damaged("the index of chunks", at);
        let (o, l) = (self.offsets, self.lengths);
        let head = self.checked(at, 16 + o as u64 + 6 * l as u64, b"EAHD")?;
        let mut b = little(&head);
        b.take(2);
        let head = (|| {
            let numbers = [b.u8()?, b.u8()?, b.u8()?, b.u8()?, b.u8()?, b.u8()?];
            b.take(4 * l)?;
            let used = self.length(&mut b)?;
            b.take(l)?;
            Some((numbers, used, self.offset(&mut b)?))
        })();
        let ([width, bits, in_index, smallest, pointers, page_bits], used, index) =
            head.ok_or_else(wrong)?;
        let power = |n: u8| n.is_power_of_two();
        if bits > 64 || !power(smallest) || !power(pointers) {
            return Err(wrong());
        }
        if index == UNDEFINED {
            return Ok(());
        }
        let slowest = usize::from(chunks.most.len() == 2 && chunks.most[1].is_none());
        let mut array = Array {
            width: width.into(),
            slowest,
            next: 0,
        };
        let levels = u64::from(bits).saturating_sub(smallest.ilog2().into()) + 1;
        let direct_levels = 2 * u64::from(pointers.ilog2());
        let direct = 2 * (u64::from(pointers) - 1);
        let blocks = levels.saturating_sub(direct_levels);
        let before = 2 + o;
        let length = before as u64
            + 8
            + u64::from(in_index) * u64::from(width)
            + (direct + blocks) * o as u64;
        let bytes = self.checked(index, length, b"EAIB")?;
        let mut b = little(&bytes);
        b.take(before);
        self.elements(chunks, &mut b, &array, in_index.into(), to)
            .ok_or_else(wrong)?;
        array.next = in_index.into();
        let level_of = Levels {
            smallest: smallest.into(),
            offset: usize::from(bits).div_ceil(8),
        };
        for level in 0..levels {
            if array.next >= used {
                break;
            }
            let (count, elements) = level_of.blocks(level).ok_or_else(wrong)?;
            let paging = Paging::of(elements, page_bits).ok_or_else(wrong)?;
            let before = 6 + o as u64 + level_of.offset as u64;
            let bits = paging.pages.map_or(0, |pages| pages.div_ceil(8));
            let (addresses, written) = if level < direct_levels {
                let addresses = b
                    .take(usize::try_from(count).unwrap_or(0) * o)
                    .ok_or_else(wrong)?;
                (addresses.to_vec(), Vec::new())
            } else {
                let block = self.offset(&mut b).ok_or_else(wrong)?;
                if block == UNDEFINED {
                    array.next = array.next.saturating_add(count.saturating_mul(elements));
                    continue;
                }
                let length = count
                    .saturating_mul(bits.saturating_add(o as u64))
                    .saturating_add(before + 4);
                let mut content = self.checked(block, length, b"EASB")?;
                content.drain(..before as usize - 4);
                let addresses = content.split_off((count * bits) as usize);
                (addresses, content)
            };
            for (i, address) in addresses.chunks_exact(o).enumerate() {
                let from = i * bits as usize;
                let written = written.get(from..from + bits as usize);
                match self.offset(&mut little(address)) {
                    Some(UNDEFINED) | None => array.next = array.next.saturating_add(elements),
                    Some(at) => self.block(
                        chunks,
                        at,
                        b"EADB",
                        before,
                        elements,
                        &paging,
                        &mut array,
                        Some(written.unwrap_or_default()),
                        to,
                    )?,
                }
            }
        }
        Ok(())
    }
}

/// How far an array of elements was read.
struct Array {
    /// Bytes of an element.
    width: usize,
    slowest: usize,
    /// Number of the next element.
    next: u64,
}

/// Pages of a block of elements.
struct Paging {
    /// Elements of a page.
    elements: u64,
    /// Pages; nothing where the block is whole.
    pages: Option<u64>,
}

impl Paging {
    fn of(count: u64, bits: u8) -> Option<Self> {
        let elements = 1_u64.checked_shl(bits.into())?;
        let pages = (count > elements).then(|| count.div_ceil(elements));
        Some(Self { elements, pages })
    }
}

/// The blocks of an extensible array, level by level.
struct Levels {
    smallest: u64,
    /// Bytes of a place in the array.
    offset: usize,
}

impl Levels {
    /// Blocks of a level, and elements of each.
    fn blocks(&self, level: u64) -> Option<(u64, u64)> {
        let count = 1_u64.checked_shl(u32::try_from(level / 2).ok()?)?;
        let elements = 1_u64.checked_shl(u32::try_from(level.div_ceil(2)).ok()?)?;
        Some((count, elements.checked_mul(self.smallest)?))
    }
}
