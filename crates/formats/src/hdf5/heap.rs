//! Trees of records (B-tree version 2) and the heap of objects that large groups are kept in.

use super::file::{File, Found, Trouble, UNDEFINED, damaged, little, number};

/// Levels of a tree or of a heap at most.
const DEEPEST: u16 = 16;

/// Form of the nodes of a tree.
struct Tree {
    node: u64,
    record: usize,
    /// Bytes of the number of records in a node.
    count_width: usize,
    /// Bytes of the number of records below a node, by its level.
    below_width: Vec<usize>,
}

/// Bytes that numbers up to this one take.
fn width(most: u64) -> usize {
    (most.checked_ilog2().unwrap_or(0) / 8 + 1) as usize
}

impl File<'_> {
    /// Hands out the records of a tree in their order, as many as can be read.
    pub(super) fn records(&mut self, at: u64, each: &mut dyn FnMut(&[u8])) -> Found<()> {
        let wrong = || damaged("an index of chunks or links", at);
        let length = 22 + self.offsets as u64 + self.lengths as u64;
        let head = self.checked(at, length, b"BTHD")?;
        let mut b = little(&head);
        b.take(2);
        let head = (|| {
            let (node, record, depth) = (b.u32()?, b.u16()?, b.u16()?);
            b.take(2)?;
            Some((node, record, depth, self.offset(&mut b)?, b.u16()?))
        })();
        let (node, record, depth, root, count) = head.ok_or_else(wrong)?;
        if root == UNDEFINED {
            return Ok(());
        }
        let (node, record) = (u64::from(node), usize::from(record));
        let room = node.saturating_sub(10);
        if record == 0 || room < record as u64 || depth > DEEPEST {
            return Err(wrong());
        }
        let mut most = room / record as u64;
        let count_width = width(most);
        let mut tree = Tree {
            node,
            record,
            count_width,
            below_width: vec![0],
        };
        for level in 0..depth {
            let pointer =
                (self.offsets + count_width + tree.below_width[usize::from(level)]) as u64;
            let own = room.saturating_sub(pointer) / (record as u64 + pointer);
            most = (own + 1).saturating_mul(most).saturating_add(own);
            tree.below_width.push(width(most).min(8));
        }
        self.node(&tree, root, count.into(), depth.into(), each)
    }

    fn node(
        &mut self,
        tree: &Tree,
        at: u64,
        count: usize,
        level: usize,
        each: &mut dyn FnMut(&[u8]),
    ) -> Found<()> {
        let wrong = || damaged("an index of chunks or links", at);
        if count as u64 > tree.node {
            return Err(wrong());
        }
        let pointer = match level {
            0 => 0,
            level => self.offsets + tree.count_width + tree.below_width[level - 1],
        };
        // The check sum stands behind what is used.
        let used = 10 + count * tree.record + if level > 0 { (count + 1) * pointer } else { 0 };
        if used as u64 > tree.node {
            return Err(wrong());
        }
        let mark = if level > 0 { b"BTIN" } else { b"BTLF" };
        let bytes = self.checked(at, used as u64, mark)?;
        let mut b = little(&bytes);
        b.take(2);
        let records = b.take(count * tree.record).ok_or_else(wrong)?;
        let mut records = records.chunks_exact(tree.record);
        if level == 0 {
            records.for_each(each);
            return Ok(());
        }
        for _ in 0..=count {
            let child = self.offset(&mut b).zip(number(&mut b, tree.count_width));
            let (child, below) = child.ok_or_else(wrong)?;
            b.take(tree.below_width[level - 1]);
            self.node(tree, child, below as usize, level - 1, each)?;
            if let Some(record) = records.next() {
                each(record);
            }
        }
        Ok(())
    }
}

/// A heap of objects: where its blocks are.
pub(super) struct Heap {
    offset_width: usize,
    length_width: usize,
    /// First place in the heap, size and address of each block.
    blocks: Vec<(u64, u64, u64)>,
}

/// Form of the blocks of a heap.
struct Form {
    columns: u64,
    smallest: u64,
    direct_rows: u64,
    offset_width: usize,
}

impl Form {
    fn size(&self, row: u64) -> u64 {
        let doubled = row.saturating_sub(1).min(63);
        self.smallest.saturating_mul(1 << doubled)
    }
}

impl File<'_> {
    pub(super) fn fractal_heap(&mut self, at: u64) -> Found<Heap> {
        let wrong = || damaged("the heap of a group", at);
        let (o, l) = (self.offsets as u64, self.lengths as u64);
        let head = self.checked(at, 26 + 3 * o + 12 * l, b"FRHP")?;
        let mut b = little(&head);
        let head = (|| {
            b.take(3)?;
            let filters = b.u16()?;
            b.u8()?;
            let most_object = b.u32()?;
            b.take(2 * self.offsets + 10 * self.lengths)?;
            let columns = b.u16()?;
            let (smallest, largest) = (self.length(&mut b)?, self.length(&mut b)?);
            let bits = b.u16()?;
            b.u16()?;
            let (root, rows) = (self.offset(&mut b)?, b.u16()?);
            Some((
                filters,
                most_object,
                columns,
                smallest,
                largest,
                bits,
                root,
                rows,
            ))
        })();
        let (filters, most_object, columns, smallest, largest, bits, root, rows) =
            head.ok_or_else(wrong)?;
        if filters > 0 {
            let what = "whose list of names is compressed";
            return Err(Trouble::Foreign(what.to_owned()));
        }
        if columns == 0 || !smallest.is_power_of_two() || largest < smallest || bits > 64 {
            return Err(wrong());
        }
        let form = Form {
            columns: columns.into(),
            smallest,
            direct_rows: u64::from((largest / smallest).ilog2()) + 2,
            offset_width: usize::from(bits).div_ceil(8),
        };
        let mut heap = Heap {
            offset_width: form.offset_width,
            length_width: (largest.ilog2() as usize)
                .div_ceil(8)
                .min(width(most_object.into())),
            blocks: Vec::new(),
        };
        match (root, rows) {
            (UNDEFINED, _) => {}
            (root, 0) => heap.blocks.push((0, smallest, root)),
            (root, rows) => self.indirect(&form, root, 0, rows.into(), 0, &mut heap)?,
        }
        Ok(heap)
    }

    /// The blocks under a block of addresses.
    fn indirect(
        &mut self,
        form: &Form,
        at: u64,
        start: u64,
        rows: u64,
        depth: u16,
        heap: &mut Heap,
    ) -> Found<()> {
        let wrong = || damaged("the heap of a group", at);
        let children = rows.saturating_mul(form.columns);
        let before = self.offsets + form.offset_width + 1;
        let length = children.saturating_mul(self.offsets as u64);
        let bytes = self.checked(at, length.saturating_add(before as u64 + 8), b"FHIB")?;
        if depth > DEEPEST {
            return Err(wrong());
        }
        let mut b = little(&bytes);
        b.take(before);
        let mut place = start;
        for row in 0..rows {
            let size = form.size(row);
            for _ in 0..form.columns {
                let child = self.offset(&mut b).ok_or_else(wrong)?;
                if child != UNDEFINED && row < form.direct_rows {
                    heap.blocks.push((place, size, child));
                } else if child != UNDEFINED {
                    let first_row = form.smallest.saturating_mul(form.columns);
                    let rows = (size / first_row).checked_ilog2().unwrap_or(0) + 1;
                    self.indirect(form, child, place, rows.into(), depth + 1, heap)?;
                }
                place = place.saturating_add(size);
            }
        }
        Ok(())
    }

    /// What an identifier in a heap stands for.
    pub(super) fn object(&mut self, heap: &Heap, id: &[u8]) -> Found<Vec<u8>> {
        let wrong = || Trouble::Damaged("a place in the heap of a group is damaged".to_owned());
        let mut b = little(id);
        match b.u8().map(|flags| flags >> 4 & 3) {
            Some(0) => {}
            Some(2) => {
                // So short that the identifier is the object.
                let length = usize::from(id[0] & 15) + 1;
                return Ok(b.take(length).ok_or_else(wrong)?.to_vec());
            }
            _ => return Err(Trouble::Foreign("whose names are very long".to_owned())),
        }
        let place = number(&mut b, heap.offset_width).ok_or_else(wrong)?;
        let length = number(&mut b, heap.length_width).ok_or_else(wrong)?;
        let holds = |(start, size, _): &&(u64, u64, u64)| {
            place >= *start && place - start < *size && length <= size - (place - start)
        };
        let (start, _, at) = *heap.blocks.iter().find(holds).ok_or_else(wrong)?;
        self.at(at.saturating_add(place - start), length)
    }
}
