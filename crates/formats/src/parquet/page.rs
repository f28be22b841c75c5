//! Pages, the pieces in which the numbers of a column lie: their heads, check sums and packing.
//!
//! **Source** `[PARQUET]`.

use super::compact::Compact;
use crate::Result;
use crate::names::unpacked_bytes;
use crate::raw::bytes_at;
use crate::stream::SeekRead;
use ::parquet::basic::{Compression, Encoding};
use ::parquet::column::page::Page;
use flate2::Crc;
use flate2::read::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;
use std::io::Read;

/// Bytes in which most heads lie, and in which every head must.
const HEADS: [u64; 2] = [256, 1 << 16];

/// What stands before the bytes of a page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    /// Bytes of the head itself.
    pub(super) length: u64,
    /// Bytes of the page in the file.
    pub(super) packed: u64,
    unpacked: u64,
    crc: Option<u32>,
    pub(super) kind: Kind,
}

/// What a page holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// The numbers that others point to.
    Dictionary { values: u32, encoding: Encoding },
    /// Numbers behind the levels that say which are there.
    Data {
        values: u32,
        encoding: Encoding,
        levels: Option<Encoding>,
    },
    /// The same with levels that are not packed.
    Second {
        values: u32,
        nulls: u32,
        encoding: Encoding,
        levels: [u32; 2],
        packed: bool,
    },
    /// None of them.
    Other,
}

impl Head {
    /// Reads the head at a place of a column that ends at another; `None` where it is damaged.
    pub(super) fn read(file: &mut dyn SeekRead, at: u64, end: u64) -> Result<Option<Self>> {
        for most in HEADS {
            let bytes = bytes_at(file, at, most.min(end.saturating_sub(at)))?;
            let head = Self::of(&bytes).filter(|h| h.packed <= end - at - h.length);
            if head.is_some() {
                return Ok(head);
            }
        }
        Ok(None)
    }

    fn of(bytes: &[u8]) -> Option<Self> {
        let mut at = Compact::new(bytes);
        let [mut kind, mut unpacked, mut packed, mut crc] = [None; 4];
        let (mut data, mut dictionary, mut second) = (None, None, None);
        let mut last = 0;
        while let Some((id, form)) = at.field(&mut last)? {
            let number = |at: &mut Compact<'_>| match form {
                5 => at.int().map(Some),
                _ => at.skip(form).map(|()| None),
            };
            match (id, form) {
                (1, _) => kind = number(&mut at)?,
                (2, _) => unpacked = number(&mut at)?,
                (3, _) => packed = number(&mut at)?,
                (4, _) => crc = number(&mut at)?,
                (5, 12) => data = Some(at.numbers::<5>()?),
                (7, 12) => dictionary = Some(at.numbers::<3>()?),
                (8, 12) => second = Some(at.numbers::<8>()?),
                _ => at.skip(form)?,
            }
        }
        let size = |n: Option<i64>| u32::try_from(n?).ok().filter(|n| *n <= i32::MAX as u32);
        let kind = match kind? {
            0 => {
                let [_, values, encoding, levels, _] = data?;
                Kind::Data {
                    values: size(values)?,
                    encoding: encoding_of(encoding)?,
                    levels: encoding_of(levels),
                }
            }
            2 => {
                let [_, values, encoding] = dictionary?;
                Kind::Dictionary {
                    values: size(values)?,
                    encoding: encoding_of(encoding)?,
                }
            }
            3 => {
                let [
                    _,
                    values,
                    nulls,
                    rows,
                    encoding,
                    definition,
                    repetition,
                    packed,
                ] = second?;
                let (values, nulls) = (size(values)?, size(nulls)?);
                if nulls > values || rows != Some(i64::from(values)) {
                    return None;
                }
                Kind::Second {
                    values,
                    nulls,
                    encoding: encoding_of(encoding)?,
                    levels: [size(repetition)?, size(definition)?],
                    packed: packed != Some(0),
                }
            }
            1 => Kind::Other,
            _ => return None,
        };
        Some(Self {
            length: (bytes.len() - at.left()) as u64,
            packed: u64::from(size(packed)?),
            unpacked: u64::from(size(unpacked)?),
            crc: crc.map(|crc| crc as u32),
            kind,
        })
    }

    /// Whether the check sum holds, where the page has one.
    pub(super) fn is_sound(&self, file: &mut dyn SeekRead, at: u64) -> Result<bool> {
        let Some(stated) = self.crc else {
            return Ok(true);
        };
        let mut crc = Crc::new();
        crc.update(&self.bytes(file, at)?);
        Ok(crc.sum() == stated)
    }

    fn bytes(&self, file: &mut dyn SeekRead, at: u64) -> Result<Vec<u8>> {
        bytes_at(file, at + self.length, self.packed)
    }

    /// The page unpacked, for a decoder of numbers of so many bytes, or why it cannot be read. `leveled` says whether levels
    /// tell which numbers are there.
    pub(super) fn page(
        &self,
        file: &mut dyn SeekRead,
        at: u64,
        codec: Compression,
        width: u64,
        leveled: bool,
    ) -> Result<Result<Unpacked, String>> {
        let bytes = self.bytes(file, at)?;
        if (bytes.len() as u64) < self.packed {
            return Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof).into());
        }
        Ok(match self.kind {
            Kind::Dictionary { values, encoding } => {
                self.dictionary(values, encoding, &bytes, codec, width)
            }
            Kind::Data { .. } => self.data(&bytes, codec, width, leveled),
            Kind::Second { .. } => self.second(&bytes, codec, width),
            Kind::Other => Err("is of no kind that holds numbers".to_owned()),
        })
    }

    fn dictionary(
        &self,
        values: u32,
        encoding: Encoding,
        bytes: &[u8],
        codec: Compression,
        width: u64,
    ) -> Result<Unpacked, String> {
        let buf = unpack(codec, bytes, self.unpacked)?;
        // What is missing in a dictionary would be zeros.
        if u64::from(values) * width != buf.len() as u64 {
            return Err("is a dictionary of another length than it says".to_owned());
        }
        let page = Page::DictionaryPage {
            buf: buf.into(),
            num_values: values,
            encoding,
            is_sorted: false,
        };
        Ok(Unpacked { page, there: None })
    }

    fn data(
        &self,
        bytes: &[u8],
        codec: Compression,
        width: u64,
        leveled: bool,
    ) -> Result<Unpacked, String> {
        let Kind::Data {
            values,
            encoding,
            levels,
        } = self.kind
        else {
            return Err("is of no kind that holds numbers".to_owned());
        };
        if leveled && levels != Some(Encoding::RLE) {
            return Err("says in a way that was given up which numbers are there".to_owned());
        }
        let buf = unpack(codec, bytes, self.unpacked)?;
        let levels = match (leveled, buf.first_chunk()) {
            (false, _) => 0,
            (true, Some(length)) => 4 + u64::from(u32::from_le_bytes(*length)),
            (true, None) => return Err("has no levels".to_owned()),
        };
        let numbers = (buf.len() as u64).checked_sub(levels);
        let numbers = numbers.ok_or_else(|| "is shorter than its levels".to_owned())?;
        let page = Page::DataPage {
            buf: buf.into(),
            num_values: values,
            encoding,
            def_level_encoding: Encoding::RLE,
            rep_level_encoding: Encoding::RLE,
            statistics: None,
        };
        Ok(Unpacked {
            page,
            there: there(encoding, numbers, width)?,
        })
    }

    fn second(&self, bytes: &[u8], codec: Compression, width: u64) -> Result<Unpacked, String> {
        let Kind::Second {
            values,
            nulls,
            encoding,
            levels: [repetition, definition],
            packed,
        } = self.kind
        else {
            return Err("is of no kind that holds numbers".to_owned());
        };
        let length = u64::from(repetition) + u64::from(definition);
        let parts = bytes.split_at_checked(length as usize);
        let (levels, stored) = parts
            .filter(|_| length <= self.unpacked)
            .ok_or_else(|| "is shorter than its levels".to_owned())?;
        let codec = match packed {
            true => codec,
            false => Compression::UNCOMPRESSED,
        };
        let numbers = match stored.is_empty() {
            true => Vec::new(),
            false => unpack(codec, stored, self.unpacked - length)?,
        };
        let said = u64::from(values - nulls);
        if there(encoding, numbers.len() as u64, width)?.is_some_and(|there| there != said) {
            return Err(format!("has no room for the {said} numbers that it says"));
        }
        let page = Page::DataPageV2 {
            buf: [levels, &numbers].concat().into(),
            num_values: values,
            encoding,
            num_nulls: nulls,
            num_rows: values,
            def_levels_byte_len: definition,
            rep_levels_byte_len: repetition,
            is_compressed: false,
            statistics: None,
        };
        Ok(Unpacked {
            page,
            there: Some(said),
        })
    }
}

/// A page as the decoder takes it.
pub(super) struct Unpacked {
    pub(super) page: Page,
    /// Numbers in it that are not absent, where that is known without decoding it.
    pub(super) there: Option<u64>,
}

/// Numbers in so many bytes, where each takes as many of them.
fn there(encoding: Encoding, bytes: u64, width: u64) -> Result<Option<u64>, String> {
    match encoding {
        Encoding::PLAIN | Encoding::BYTE_STREAM_SPLIT if width > 0 => {
            match bytes.is_multiple_of(width) {
                true => Ok(Some(bytes / width)),
                false => Err("ends within a number".to_owned()),
            }
        }
        _ => Ok(None),
    }
}

fn encoding_of(number: Option<i64>) -> Option<Encoding> {
    Some(match number? {
        0 => Encoding::PLAIN,
        2 => Encoding::PLAIN_DICTIONARY,
        3 => Encoding::RLE,
        5 => Encoding::DELTA_BINARY_PACKED,
        7 => Encoding::DELTA_BYTE_ARRAY,
        8 => Encoding::RLE_DICTIONARY,
        9 => Encoding::BYTE_STREAM_SPLIT,
        // For texts, given up, or not known.
        _ => return None,
    })
}

/// Whether a packing can be undone.
pub(super) fn is_known(codec: Compression) -> bool {
    use Compression::{GZIP, SNAPPY, UNCOMPRESSED, ZSTD};
    matches!(codec, UNCOMPRESSED | SNAPPY | GZIP(_) | ZSTD(_))
}

/// Undoes the packing of bytes that must give so many. No memory is asked for beyond what the packed bytes can give.
fn unpack(codec: Compression, bytes: &[u8], size: u64) -> Result<Vec<u8>, String> {
    // A copy of 64 bytes takes 3; a block of 128 KiB takes 4.
    let most = match codec {
        Compression::SNAPPY => 32 * bytes.len() as u64 + 64,
        Compression::ZSTD(_) => (bytes.len() as u64 / 4 + 1) << 17,
        _ => u64::MAX,
    };
    if size > most.min(unpacked_bytes(bytes.len() as u64)) {
        return Err(format!("claims to unpack to {size} bytes"));
    }
    let read = |reader: &mut dyn Read| {
        let mut unpacked = Vec::new();
        let done = reader.take(size + 1).read_to_end(&mut unpacked);
        done.map(|_| unpacked).map_err(|e| e.to_string())
    };
    let unpacked = match codec {
        Compression::UNCOMPRESSED => bytes.to_vec(),
        Compression::SNAPPY => {
            let stated = snap::raw::decompress_len(bytes).map_err(|e| e.to_string())?;
            if stated as u64 != size {
                return Err("states two sizes".to_owned());
            }
            let mut unpacked = vec![0; stated];
            let done = snap::raw::Decoder::new().decompress(bytes, &mut unpacked);
            done.map_err(|e| e.to_string())?;
            unpacked
        }
        Compression::GZIP(_) => read(&mut MultiGzDecoder::new(bytes))?,
        Compression::ZSTD(_) => {
            let window = zstd_window(bytes).ok_or("is no zstd frame")?;
            if window > size.max(1 << 23) {
                return Err("claims a window beyond its size".to_owned());
            }
            let decoder = StreamingDecoder::new(bytes).map_err(|e| e.to_string())?;
            read(&mut { decoder })?
        }
        other => return Err(format!("is packed by {other}")),
    };
    match unpacked.len() as u64 == size {
        true => Ok(unpacked),
        false => Err("does not unpack to the size that it states".to_owned()),
    }
}

/// Bytes that a decoder holds for a frame of zstd (RFC 8878, 3.1.1.1).
fn zstd_window(frame: &[u8]) -> Option<u64> {
    let head = frame.strip_prefix(b"\x28\xB5\x2F\xFD")?;
    let (flags, rest) = head.split_first()?;
    if flags & 0x20 == 0 {
        let (exponent, mantissa) = (rest.first()? >> 3, rest.first()? & 7);
        return Some((1_u64 << (10 + exponent)) / 8 * (8 + u64::from(mantissa)));
    }
    let identity = [0, 1, 2, 4][usize::from(flags & 3)];
    let size = [1, 2, 4, 8][usize::from(flags >> 6)];
    let bytes = rest.get(identity..identity + size)?;
    let number = bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b));
    Some(number + if size == 2 { 256 } else { 0 })
}
