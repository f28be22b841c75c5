//! Object headers: lists of messages that say what an object is.

use super::file::{File, Found, Trouble, damaged, little, number};
use crate::bytes::text;

/// Kinds of messages.
pub(super) mod kind {
    pub(crate) const DATASPACE: u16 = 1;
    pub(crate) const LINK_INFO: u16 = 2;
    pub(crate) const DATATYPE: u16 = 3;
    pub(crate) const LINK: u16 = 6;
    pub(crate) const EXTERNAL: u16 = 7;
    pub(crate) const LAYOUT: u16 = 8;
    pub(crate) const GROUP_INFO: u16 = 10;
    pub(crate) const FILTERS: u16 = 11;
    pub(crate) const ATTRIBUTE: u16 = 12;
    pub(crate) const CONTINUATION: u16 = 16;
    pub(crate) const SYMBOL_TABLE: u16 = 17;
}

pub(super) struct Message {
    pub(super) kind: u16,
    shared: bool,
    pub(super) data: Vec<u8>,
}

pub(super) struct Header(Vec<Message>);

impl Header {
    pub(super) fn all(&self, kind: u16) -> impl Iterator<Item = &Message> {
        self.0.iter().filter(move |m| m.kind == kind)
    }

    pub(super) fn has(&self, kind: u16) -> bool {
        self.all(kind).next().is_some()
    }
}

impl File<'_> {
    pub(super) fn header(&mut self, at: u64) -> Found<Header> {
        let mut messages = Vec::new();
        let start = self.up_to(at, 34)?;
        match start.starts_with(b"OHDR") {
            true => self.header_2(at, &start, &mut messages)?,
            false => self.header_1(at, &start, &mut messages)?,
        }
        Ok(Header(messages))
    }

    fn header_1(&mut self, at: u64, start: &[u8], messages: &mut Vec<Message>) -> Found<()> {
        let wrong = || damaged("the header of an object", at);
        let mut b = little(start);
        if b.u8() != Some(1) {
            return Err(wrong());
        }
        b.take(7);
        let size = b.u32().ok_or_else(wrong)?;
        let mut blocks = vec![(at.saturating_add(16), u64::from(size))];
        while let Some((at, size)) = blocks.pop() {
            let block = self.at(at, size)?;
            let mut b = little(&block);
            while b.rest().len() >= 8 {
                let message = (|| {
                    let (kind, size, flags) = (b.u16()?, b.u16()?, b.u8()?);
                    b.take(3)?;
                    Some((kind, flags, b.take(size.into())?))
                })();
                let (kind, flags, data) = message.ok_or_else(wrong)?;
                self.take_in(kind, flags, data, messages, &mut blocks)?;
            }
        }
        Ok(())
    }

    fn header_2(&mut self, at: u64, start: &[u8], messages: &mut Vec<Message>) -> Found<()> {
        let wrong = || damaged("the header of an object", at);
        let mut b = little(start);
        b.take(4);
        let (version, flags) = (b.u8(), b.u8().ok_or_else(wrong)?);
        if version != Some(2) {
            return Err(wrong());
        }
        b.take(if flags & 0x20 != 0 { 16 } else { 0 });
        b.take(if flags & 0x10 != 0 { 4 } else { 0 });
        let size = number(&mut b, 1 << (flags & 3)).ok_or_else(wrong)?;
        let before = (start.len() - b.rest().len()) as u64;
        let whole = size.checked_add(before + 4).ok_or_else(wrong)?;
        let mut blocks = Vec::new();
        let mut block = self.checked(at, whole, b"OHDR")?;
        block.drain(..before as usize - 4);
        loop {
            let mut b = little(&block);
            let head = if flags & 4 != 0 { 6 } else { 4 };
            while b.rest().len() >= head {
                let message = (|| {
                    let (kind, size, own) = (b.u8()?, b.u16()?, b.u8()?);
                    b.take(head - 4)?;
                    Some((kind.into(), own, b.take(size.into())?))
                })();
                let (kind, own, data) = message.ok_or_else(wrong)?;
                self.take_in(kind, own, data, messages, &mut blocks)?;
            }
            match blocks.pop() {
                Some((at, size)) => block = self.checked(at, size, b"OCHK")?,
                None => return Ok(()),
            }
        }
    }

    fn take_in(
        &mut self,
        kind: u16,
        flags: u8,
        data: &[u8],
        messages: &mut Vec<Message>,
        blocks: &mut Vec<(u64, u64)>,
    ) -> Found<()> {
        match kind {
            0 => {}
            kind::CONTINUATION => {
                let mut b = little(data);
                let block = self.offset(&mut b).zip(self.length(&mut b));
                let wrong = || Trouble::Damaged("the header of an object is damaged".to_owned());
                blocks.push(block.ok_or_else(wrong)?);
            }
            _ => messages.push(Message {
                kind,
                shared: flags & 2 != 0,
                data: data.to_vec(),
            }),
        }
        Ok(())
    }

    /// The one message of a kind, which may stand in another header.
    pub(super) fn message(&mut self, header: &Header, kind: u16) -> Found<Option<Vec<u8>>> {
        let Some(message) = header.all(kind).next() else {
            return Ok(None);
        };
        if !message.shared {
            return Ok(Some(message.data.clone()));
        }
        let mut b = little(&message.data);
        let place = (|| {
            let (version, place) = (b.u8()?, b.u8()?);
            b.take(if version == 1 { 6 } else { 0 })?;
            Some((version >= 3 && place == 1, self.offset(&mut b)))
        })();
        let foreign = || Trouble::Foreign("whose description stands in a common heap".to_owned());
        match place {
            Some((false, Some(at))) => {
                let other = self.header(at)?;
                let found = other.all(kind).find(|m| !m.shared);
                Ok(found.map(|m| m.data.clone()))
            }
            _ => Err(foreign()),
        }
    }

    /// The text of an attribute, by one of its names in small letters; nothing where it is no text.
    pub(super) fn text_of(&mut self, header: &Header, names: &[&str]) -> Found<Option<String>> {
        for message in header.all(kind::ATTRIBUTE).filter(|m| !m.shared) {
            let Some((name, form, value)) = attribute(&message.data) else {
                continue;
            };
            if !names.contains(&name.to_lowercase().as_str()) {
                continue;
            }
            let of = |bytes: &[u8]| {
                let before = bytes.split(|b| *b == 0).next().unwrap_or_default();
                text(before).trim().to_owned()
            };
            let mut b = little(form);
            match b.u32().unwrap_or(0) & 0xF0F {
                // A text, and a text of any length, which stands in a heap.
                0x003 | 0x103 | 0x203 => return Ok(Some(of(value))),
                0x109 => return Ok(self.in_heap(value)?.map(|bytes| of(&bytes))),
                _ => {}
            }
        }
        Ok(None)
    }

    /// What a reference into a global heap stands for.
    fn in_heap(&mut self, reference: &[u8]) -> Found<Option<Vec<u8>>> {
        let mut b = little(reference);
        b.u32();
        let Some((at, wanted)) = self.offset(&mut b).zip(b.u32()) else {
            return Ok(None);
        };
        let head = self.at(at, 8 + self.lengths as u64)?;
        let mut b = little(&head);
        let mark = b.take(8).is_some_and(|m| m.starts_with(b"GCOL"));
        let Some(size) = self.length(&mut b).filter(|_| mark) else {
            return Ok(None);
        };
        let heap = self.at(at, size)?;
        let mut b = little(&heap);
        b.take(head.len());
        let found = || -> Option<Vec<u8>> {
            loop {
                let index = b.u16()?;
                b.take(6)?;
                let size = usize::try_from(self.length(&mut b)?).ok()?;
                let content = b.take(size)?;
                if u32::from(index) == wanted {
                    return Some(content.to_vec());
                }
                b.take(size.checked_next_multiple_of(8)? - size)?;
            }
        };
        let mut found = found;
        Ok(found())
    }
}

/// Name, datatype and value of an attribute.
fn attribute(data: &[u8]) -> Option<(String, &[u8], &[u8])> {
    let mut b = little(data);
    let version = b.u8()?;
    b.u8()?;
    let sizes = [b.u16()?, b.u16()?, b.u16()?];
    b.take(if version == 3 { 1 } else { 0 })?;
    let mut part = |size: u16| {
        let size = usize::from(size);
        let content = b.take(size)?;
        let behind = size.next_multiple_of(8) - size;
        b.take(if version == 1 { behind } else { 0 })?;
        Some(content)
    };
    let (name, form, _) = (part(sizes[0])?, part(sizes[1])?, part(sizes[2])?);
    let name = name.split(|b| *b == 0).next()?;
    Some((text(name), form, b.rest()))
}

/// Whether an attribute of this name is there.
pub(super) fn has_attribute(header: &Header, name: &str) -> bool {
    let mut all = header.all(kind::ATTRIBUTE);
    all.any(|m| attribute(&m.data).is_some_and(|(own, ..)| own == name))
}
