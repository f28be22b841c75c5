//! How the elements of a dataset lie in the file: sides, layout, filters.

use super::file::{File, Found, Trouble, UNDEFINED, little, number};
use crate::bytes::{Bytes, text};

/// The sides of a dataset, now and at most.
pub(super) struct Space {
    pub(super) sides: Vec<u64>,
    pub(super) most: Vec<u64>,
}

pub(super) enum Layout {
    /// In the header.
    Compact(Vec<u8>),
    /// In one piece, from an address on.
    Contiguous(u64),
    Chunked(Grid),
}

/// Chunks of one size.
pub(super) struct Grid {
    /// Sides of a chunk; the last number is that of the bytes of an element.
    pub(super) sides: Vec<u64>,
    pub(super) index: Index,
    /// Address of the index, or of the only chunk.
    pub(super) at: u64,
    /// Chunks over the edge are stored without filters.
    pub(super) plain_edges: bool,
}

/// What tells the addresses of chunks.
pub(super) enum Index {
    Tree,
    /// The one chunk, its bytes and the filters that were left off.
    Single(Option<(u64, u32)>),
    Implicit,
    FixedArray,
    ExtensibleArray,
    Tree2,
}

/// A filter with its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    Deflate,
    Lzf,
    /// Bytes of elements of so many bytes, sorted by their place in the element.
    Shuffle(usize),
    Fletcher32,
}

impl File<'_> {
    pub(super) fn space(&self, data: &[u8]) -> Option<Space> {
        let mut b = little(data);
        let (version, rank, flags, kind) = (b.u8()?, b.u8()?, b.u8()?, b.u8()?);
        b.take(if version == 1 { 4 } else { 0 })?;
        // Nothing at all.
        if version == 2 && kind == 2 {
            return Some(Space {
                sides: vec![0],
                most: vec![0],
            });
        }
        let mut read = || {
            (0..rank)
                .map(|_| self.length(&mut b))
                .collect::<Option<Vec<u64>>>()
        };
        let sides = read()?;
        let most = if flags & 1 != 0 {
            read()?
        } else {
            sides.clone()
        };
        Some(Space { sides, most })
    }

    pub(super) fn layout(&self, data: &[u8]) -> Found<Layout> {
        let mut b = little(data);
        let version = b.u8();
        let found = match version {
            Some(1 | 2) => self.old_layout(&mut b),
            Some(3..=5) => self.new_layout(&mut b, version != Some(3)),
            _ => None,
        };
        let foreign = || {
            Trouble::Foreign(match (version, data.get(1)) {
                (Some(4 | 5), Some(3)) => "which is put together from other datasets".to_owned(),
                _ => "whose layout is of a kind that is not known".to_owned(),
            })
        };
        found.ok_or_else(foreign)
    }

    fn old_layout(&self, b: &mut Bytes<'_>) -> Option<Layout> {
        let (rank, class) = (b.u8()?, b.u8()?);
        b.take(5)?;
        let at = if class > 0 {
            self.offset(b)?
        } else {
            UNDEFINED
        };
        let mut sides = Vec::new();
        for _ in 0..rank {
            sides.push(u64::from(b.u32()?));
        }
        match class {
            0 => {
                let size = b.u32()?;
                Some(Layout::Compact(b.take(size as usize)?.to_vec()))
            }
            1 => Some(Layout::Contiguous(at)),
            // The bytes of an element are the last side here too.
            2 => Some(Layout::Chunked(Grid {
                sides,
                index: Index::Tree,
                at,
                plain_edges: false,
            })),
            _ => None,
        }
    }

    fn new_layout(&self, b: &mut Bytes<'_>, indexed: bool) -> Option<Layout> {
        match b.u8()? {
            0 => {
                let size = b.u16()?;
                Some(Layout::Compact(b.take(size.into())?.to_vec()))
            }
            1 => Some(Layout::Contiguous(self.offset(b)?)),
            2 if indexed => self.indexed(b),
            2 => {
                let rank = b.u8()?;
                let at = self.offset(b)?;
                let sides: Option<Vec<u64>> = (0..rank).map(|_| b.u32().map(u64::from)).collect();
                Some(Layout::Chunked(Grid {
                    sides: sides?,
                    index: Index::Tree,
                    at,
                    plain_edges: false,
                }))
            }
            _ => None,
        }
    }

    fn indexed(&self, b: &mut Bytes<'_>) -> Option<Layout> {
        let (flags, rank, width) = (b.u8()?, b.u8()?, b.u8()?);
        let sides: Option<Vec<u64>> = (0..rank).map(|_| number(b, width.into())).collect();
        let index = match b.u8()? {
            1 if flags & 2 != 0 => Index::Single(Some((self.length(b)?, b.u32()?))),
            1 => Index::Single(None),
            2 => Index::Implicit,
            3 => {
                b.take(1)?;
                Index::FixedArray
            }
            4 => {
                b.take(5)?;
                Index::ExtensibleArray
            }
            5 => {
                b.take(6)?;
                Index::Tree2
            }
            _ => return None,
        };
        let at = self.offset(b)?;
        Some(Layout::Chunked(Grid {
            sides: sides?,
            index,
            at,
            plain_edges: flags & 1 != 0,
        }))
    }
}

/// The filters in the order in which they were applied; a filter that is not known here is named.
pub(super) fn filters(data: &[u8]) -> Found<Vec<Filter>> {
    let damaged = || Trouble::Damaged("the list of filters is damaged".to_owned());
    let mut b = little(data);
    let (version, count) = b.u8().zip(b.u8()).ok_or_else(damaged)?;
    b.take(if version == 1 { 6 } else { 0 });
    let mut filters = Vec::new();
    for _ in 0..count {
        let filter = (|| {
            let id = b.u16()?;
            let named = version == 1 || id >= 256;
            let length = if named { usize::from(b.u16()?) } else { 0 };
            b.take(2)?;
            let values = usize::from(b.u16()?);
            let name = b.take(if version == 1 {
                length.next_multiple_of(8)
            } else {
                length
            })?;
            let numbers = b.take(4 * values)?;
            b.take(if version == 1 && values % 2 == 1 {
                4
            } else {
                0
            })?;
            let name = text(name.split(|c| *c == 0).next().unwrap_or_default());
            Some((id, name, little(numbers).u32()))
        })();
        let (id, name, first) = filter.ok_or_else(damaged)?;
        filters.push(match id {
            1 => Filter::Deflate,
            2 => Filter::Shuffle(first.unwrap_or(1) as usize),
            3 => Filter::Fletcher32,
            32_000 => Filter::Lzf,
            id => {
                let name = match (id, name.as_str()) {
                    (4, _) => "szip",
                    (5, _) => "nbit",
                    (6, _) => "scaleoffset",
                    (32_001, _) => "blosc",
                    (32_004, _) => "lz4",
                    (32_008, _) => "bitshuffle",
                    (32_013, _) => "zfp",
                    (32_015, _) => "zstd",
                    (32_026, _) => "blosc2",
                    (_, "") => "of no name",
                    (_, name) => name,
                };
                return Err(Trouble::Foreign(format!(
                    "packed with the filter {name} ({id}), which is not read here: `h5repack -f GZIP=6 IN OUT` writes it with deflate"
                )));
            }
        });
    }
    Ok(filters)
}
