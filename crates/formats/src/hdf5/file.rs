//! The bytes of an HDF5 file by its own addresses, and what can be wrong with them.

use super::chunked::HELD;
use crate::bytes::{Bytes, Order};
use crate::raw::bytes_at;
use crate::stream::{Remark, SeekRead};
use crate::{Error, Result};

/// An address that stands for nothing.
pub(super) const UNDEFINED: u64 = u64::MAX;
const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Where a file may begin behind bytes of somebody else, as far as the head of a file goes.
const BEGINNINGS: [usize; 4] = [0, 512, 1024, 2048];

/// Why a part of a file is not read.
#[derive(Debug)]
pub(super) enum Trouble {
    /// It lies behind the end: at this byte.
    Cut(u64),
    /// It is not what it should be.
    Damaged(String),
    /// It is of a kind that is not read.
    Foreign(String),
    /// The operating system refuses.
    Refused(Error),
}

pub(super) type Found<T> = std::result::Result<T, Trouble>;

pub(super) fn damaged(what: &str, at: u64) -> Trouble {
    Trouble::Damaged(format!("{what} at byte {at} is damaged"))
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}

impl Trouble {
    /// What is said of the part; an error only where the operating system refuses.
    pub(super) fn remark(self, part: &str, size: u64) -> Result<Remark> {
        Ok(match self {
            Self::Cut(at) => Remark::cut(format!(
                "{part} is cut off: it needs byte {at}, and the file has {size} bytes"
            )),
            Self::Damaged(what) => Remark::damaged(format!("{part}: {what}")),
            Self::Foreign(what) => Remark::passed_over(format!("{part}, {what}")),
            Self::Refused(error) => return Err(error),
        })
    }

    /// What it means where nothing can be found without the part.
    pub(super) fn error(self, part: &str, size: u64) -> Error {
        match self {
            Self::Cut(at) => Error::new(format!(
                "{part} should stand at byte {at}, and the file ends at byte {size}"
            ))
            .with_hint("the file was cut short: fetch it again; nothing in it can be found without this part"),
            Self::Damaged(what) => Error::new(format!("{part}: {what}"))
                .with_hint("the file is damaged: fetch it again; nothing in it can be found without this part"),
            Self::Foreign(what) => Error::new(format!("{part}: {what}, which is not read here"))
                .with_hint("write it again with another program, such as h5repack or h5py"),
            Self::Refused(error) => error,
        }
    }
}

/// A file whose addresses count from its signature.
pub(super) struct File<'a> {
    file: &'a mut dyn SeekRead,
    pub(super) size: u64,
    /// Byte of the signature.
    base: u64,
    /// Bytes of an address.
    pub(super) offsets: usize,
    /// Bytes of a length.
    pub(super) lengths: usize,
    /// Bytes of descriptions that may still be read: a sound file is read once, a circle without end.
    allowance: u64,
    /// Bytes of samples that may still be laid claim to: parts of a sound file do not overlap.
    unclaimed: u64,
    /// Bytes of unpacked chunks that may still be kept.
    room: u64,
}

/// Whether a file begins so, behind 512, 1024 or 2048 bytes of somebody else too.
pub(crate) fn is_hdf5(head: &[u8]) -> bool {
    beginning(head).is_some()
}

/// Whether MATLAB says so before; older releases say 7.0 there.
pub(crate) fn is_mat73(head: &[u8]) -> bool {
    head.starts_with(b"MATLAB 7.3")
        || (head.starts_with(b"MATLAB ") && beginning(head) == Some(512))
}

fn beginning(head: &[u8]) -> Option<usize> {
    let begins = |at: &usize| head.get(*at..).is_some_and(|b| b.starts_with(SIGNATURE));
    BEGINNINGS.into_iter().find(begins)
}

/// A number of so many bytes, the least significant first.
pub(super) fn number(b: &mut Bytes<'_>, width: usize) -> Option<u64> {
    let bytes = b.take(width).filter(|_| width <= 8)?;
    let each = bytes.iter().rev();
    Some(each.fold(0, |sum, b| sum << 8 | u64::from(*b)))
}

pub(super) fn little(bytes: &[u8]) -> Bytes<'_> {
    Bytes::new(bytes, Order::Little)
}

impl<'a> File<'a> {
    /// Reads the superblock: the file, the address of the root group, and the size that it states.
    pub(super) fn of(file: &'a mut dyn SeekRead, size: u64) -> Found<(Self, u64, u64)> {
        let head = bytes_at(file, 0, BEGINNINGS[3] as u64 + 128)?;
        let base = beginning(&head)
            .ok_or_else(|| Trouble::Damaged("the signature of HDF5 is missing".to_owned()))?;
        let whole = &head[base..];
        let mut opened = Self {
            file,
            size,
            base: base as u64,
            offsets: 8,
            lengths: 8,
            allowance: size.saturating_mul(4).saturating_add(1 << 16),
            unclaimed: size,
            room: HELD as u64,
        };
        match opened.superblock(whole) {
            Some(Ok((root, end))) => Ok((opened, root, end)),
            Some(Err(trouble)) => Err(trouble),
            None if whole.len() < 96 => Err(Trouble::Cut(size)),
            None => Err(damaged("the superblock", base as u64)),
        }
    }

    /// Address of the root group, and size of the file.
    fn superblock(&mut self, whole: &[u8]) -> Option<Found<(u64, u64)>> {
        let mut b = little(whole);
        b.take(SIGNATURE.len())?;
        let version = b.u8()?;
        if version > 3 {
            let what = format!("a superblock of version {version}");
            return Some(Err(Trouble::Foreign(what)));
        }
        if version < 2 {
            b.take(4)?;
        }
        (self.offsets, self.lengths) = (b.u8()?.into(), b.u8()?.into());
        if ![2, 4, 8].contains(&self.offsets) || ![2, 4, 8].contains(&self.lengths) {
            return None;
        }
        match version {
            0 => b.take(9)?,
            1 => b.take(13)?,
            _ => b.take(1)?,
        };
        let stated = self.offset(&mut b)?;
        self.offset(&mut b)?;
        let end = self.offset(&mut b)?;
        if version < 2 {
            self.offset(&mut b)?;
            self.offset(&mut b)?;
        }
        let root = self.offset(&mut b)?;
        if version >= 2 {
            let counted = whole.len() - b.rest().len();
            if b.u32()? != check_sum(&whole[..counted]) {
                return None;
            }
        }
        // Where the user block was put before it later, the addresses moved with it.
        let end = end.saturating_sub(stated).saturating_add(self.base);
        Some(Ok((root, end)))
    }

    pub(super) fn offset(&self, b: &mut Bytes<'_>) -> Option<u64> {
        let value = number(b, self.offsets)?;
        let undefined = UNDEFINED >> (64 - 8 * self.offsets);
        Some(if value == undefined { UNDEFINED } else { value })
    }

    pub(super) fn length(&self, b: &mut Bytes<'_>) -> Option<u64> {
        number(b, self.lengths)
    }

    /// The byte of the file that an address stands for.
    pub(super) fn place(&self, at: u64) -> u64 {
        self.base.saturating_add(at)
    }

    /// Counts what is read of the descriptions.
    pub(super) fn spend(&mut self, bytes: u64) -> Found<()> {
        let rest = self.allowance.checked_sub(bytes.max(8));
        self.allowance = rest.ok_or_else(|| {
            Trouble::Damaged("the descriptions of its parts lead in a circle".to_owned())
        })?;
        Ok(())
    }

    /// Counts bytes of samples; whether they can all be there.
    pub(super) fn claim(&mut self, bytes: u64) -> bool {
        let rest = self.unclaimed.checked_sub(bytes);
        self.unclaimed = rest.unwrap_or(self.unclaimed);
        rest.is_some()
    }

    /// Counts bytes of unpacked chunks that are kept; whether there is room for them.
    pub(super) fn keep(&mut self, bytes: u64) -> bool {
        let rest = self.room.checked_sub(bytes);
        self.room = rest.unwrap_or(0);
        rest.is_some()
    }

    /// So many bytes from an address on.
    pub(super) fn at(&mut self, at: u64, length: u64) -> Found<Vec<u8>> {
        let place = self.place(at);
        if place.checked_add(length).is_none_or(|end| end > self.size) {
            return Err(Trouble::Cut(place));
        }
        self.spend(length)?;
        let bytes = bytes_at(self.file, place, length)?;
        match bytes.len() as u64 == length {
            true => Ok(bytes),
            false => Err(Trouble::Cut(place)),
        }
    }

    /// As many of so many bytes as are there.
    pub(super) fn up_to(&mut self, at: u64, most: u64) -> Found<Vec<u8>> {
        let there = self.size.saturating_sub(self.place(at));
        match there {
            0 => Err(Trouble::Cut(self.place(at))),
            there => self.at(at, most.min(there)),
        }
    }

    /// A block with a mark before and a check sum behind, of so many bytes in all; gives what is between them.
    pub(super) fn checked(&mut self, at: u64, length: u64, mark: &[u8; 4]) -> Found<Vec<u8>> {
        let mut bytes = self.at(at, length)?;
        let what = || damaged(&format!("the block {}", String::from_utf8_lossy(mark)), at);
        let content = bytes.len().checked_sub(4).filter(|n| *n >= 4);
        let content = content.ok_or_else(what)?;
        let sum = little(&bytes[content..]).u32();
        if !bytes.starts_with(mark) || sum != Some(check_sum(&bytes[..content])) {
            return Err(what());
        }
        bytes.truncate(content);
        bytes.drain(..4);
        Ok(bytes)
    }

    /// The file for reading samples.
    pub(super) fn raw(&mut self) -> &mut dyn SeekRead {
        self.file
    }
}

/// The check sum of descriptions: Bob Jenkins' lookup3.
pub(super) fn check_sum(bytes: &[u8]) -> u32 {
    let start = 0xDEAD_BEEF_u32.wrapping_add(bytes.len() as u32);
    let [mut a, mut b, mut c] = [start; 3];
    let mut rest = bytes;
    while !rest.is_empty() {
        let (taken, behind) = rest.split_at(rest.len().min(12));
        let mut twelve = [0; 12];
        twelve[..taken.len()].copy_from_slice(taken);
        let mut words = little(&twelve);
        a = a.wrapping_add(words.u32().unwrap_or(0));
        b = b.wrapping_add(words.u32().unwrap_or(0));
        c = c.wrapping_add(words.u32().unwrap_or(0));
        rest = behind;
        if rest.is_empty() {
            for (x, y, turn) in [(2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16)]
                .into_iter()
                .chain([(0, 2, 4), (1, 0, 14), (2, 1, 24)])
            {
                let mut v = [a, b, c];
                v[x] = (v[x] ^ v[y]).wrapping_sub(v[y].rotate_left(turn));
                [a, b, c] = v;
            }
        } else {
            for (x, y, z, turn) in [(0, 2, 1, 4), (1, 0, 2, 6), (2, 1, 0, 8)]
                .into_iter()
                .chain([(0, 2, 1, 16), (1, 0, 2, 19), (2, 1, 0, 4)])
            {
                let mut v = [a, b, c];
                v[x] = v[x].wrapping_sub(v[y]) ^ v[y].rotate_left(turn);
                v[y] = v[y].wrapping_add(v[z]);
                [a, b, c] = v;
            }
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values that stand at the end of lookup3.c for a start of zero.
    #[test]
    fn published_check_sums() {
        assert_eq!(check_sum(b""), 0xDEAD_BEEF);
        assert_eq!(check_sum(b"Four score and seven years ago"), 0x1777_0551);
    }
}
