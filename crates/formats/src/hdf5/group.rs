//! Groups: the links from names to objects, in tables or in messages.

use super::file::{File, Found, Trouble, UNDEFINED, damaged, little, number};
use super::header::{Header, kind};
use crate::bytes::text;

/// A name in a group, and the address of its object; none where it leads elsewhere.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) at: Option<u64>,
    /// Whether it leads into another file.
    pub(super) outside: bool,
    /// When it was made, where the group keeps account of that.
    order: u64,
}

pub(super) fn is_group(header: &Header) -> bool {
    [
        kind::SYMBOL_TABLE,
        kind::LINK_INFO,
        kind::LINK,
        kind::GROUP_INFO,
    ]
    .into_iter()
    .any(|k| header.has(k))
}

impl File<'_> {
    /// Appends the links of a group, as many as can be read: as they were made, else by their names.
    pub(super) fn links(&mut self, header: &Header, to: &mut Vec<Link>) -> Found<()> {
        let messages = header.all(kind::LINK);
        to.extend(messages.filter_map(|m| self.link(&m.data)));
        let found = self.tables_of_links(header, to);
        to.sort_by(|a, b| (a.order, &a.name).cmp(&(b.order, &b.name)));
        found
    }

    fn tables_of_links(&mut self, header: &Header, to: &mut Vec<Link>) -> Found<()> {
        if let Some(table) = header.all(kind::SYMBOL_TABLE).next() {
            let mut b = little(&table.data);
            let places = self.offset(&mut b).zip(self.offset(&mut b));
            let wrong = || Trouble::Damaged("the table of a group is damaged".to_owned());
            let (tree, heap) = places.ok_or_else(wrong)?;
            let names = self.local_heap(heap)?;
            self.symbols(tree, None, &names, to)?;
        }
        let Some(info) = header.all(kind::LINK_INFO).next() else {
            return Ok(());
        };
        let mut b = little(&info.data);
        b.u8();
        let flags = b.u8().unwrap_or(0);
        b.take(if flags & 1 != 0 { 8 } else { 0 });
        let places = self.offset(&mut b).zip(self.offset(&mut b));
        let Some((heap, tree)) = places.filter(|p| p.0 != UNDEFINED && p.1 != UNDEFINED) else {
            return Ok(());
        };
        let heap = self.fractal_heap(heap)?;
        let mut ids = Vec::new();
        let found = self.records(tree, &mut |record| {
            ids.push(record.get(4..).unwrap_or_default().to_vec());
        });
        for id in ids {
            let object = self.object(&heap, &id)?;
            to.extend(self.link(&object));
        }
        found
    }

    /// The segment of names of a group.
    fn local_heap(&mut self, at: u64) -> Found<Vec<u8>> {
        let head = self.at(at, 8 + 2 * self.lengths as u64 + self.offsets as u64)?;
        let mut b = little(&head);
        let mark = b.take(8).is_some_and(|m| m.starts_with(b"HEAP"));
        let place = (|| {
            let size = self.length(&mut b)?;
            self.length(&mut b)?;
            Some((self.offset(&mut b)?, size))
        })();
        let (at, size) = place
            .filter(|_| mark)
            .ok_or_else(|| damaged("the list of names", at))?;
        self.at(at, size)
    }

    /// The names under a node of the tree of a group.
    fn symbols(
        &mut self,
        at: u64,
        level: Option<u8>,
        names: &[u8],
        to: &mut Vec<Link>,
    ) -> Found<()> {
        let wrong = || damaged("the index of a group", at);
        let head = self.at(at, 8)?;
        let count = u16::from_le_bytes([head[6], head[7]]);
        if head.starts_with(b"SNOD") {
            let entry = 2 * self.offsets as u64 + 24;
            let entries = self.at(at.saturating_add(8), u64::from(count) * entry)?;
            for entry in entries.chunks_exact(entry as usize) {
                let mut b = little(entry);
                let (name, object) = self
                    .offset(&mut b)
                    .zip(self.offset(&mut b))
                    .ok_or_else(wrong)?;
                let soft = b.u32() == Some(2);
                let name = usize::try_from(name).ok().and_then(|n| names.get(n..));
                let name = name.and_then(|n| n.split(|b| *b == 0).next());
                to.push(Link {
                    name: text(name.ok_or_else(wrong)?),
                    at: (!soft && object != UNDEFINED).then_some(object),
                    outside: false,
                    order: 0,
                });
            }
            return Ok(());
        }
        let own = head[5];
        // A node stands one level below the one that leads to it.
        if !head.starts_with(b"TREE\0") || level.is_some_and(|l| own >= l) {
            return Err(wrong());
        }
        let (key, child) = (self.lengths, self.offsets);
        let length = usize::from(count) * (key + child);
        let body = self.at(at.saturating_add(8 + 2 * child as u64), length as u64)?;
        for pair in body.chunks_exact(key + child) {
            let node = number(&mut little(&pair[key..]), child).ok_or_else(wrong)?;
            self.symbols(node, Some(own), names, to)?;
        }
        Ok(())
    }

    /// A link in a message.
    fn link(&self, data: &[u8]) -> Option<Link> {
        let mut b = little(data);
        b.u8().filter(|version| *version == 1)?;
        let flags = b.u8()?;
        let form = if flags & 8 != 0 { b.u8()? } else { 0 };
        let order = if flags & 4 != 0 { b.u64()? } else { 0 };
        b.take(if flags & 16 != 0 { 1 } else { 0 })?;
        let length = number(&mut b, 1 << (flags & 3))?;
        let name = text(b.take(usize::try_from(length).ok()?)?);
        let at = match form {
            0 => Some(self.offset(&mut b)?),
            _ => None,
        };
        Some(Link {
            name,
            at,
            outside: form == 64,
            order,
        })
    }
}
