//! The content of a chunk: as it stands, or packed by zstd or LZ4.

use super::lz4::Lz4;
use crate::bytes::{Bytes, Order};
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};
use std::io::{self, Read};

/// A frame may ask for so many bytes to look back on; more only where the packed bytes are a sixteenth of it.
const WINDOW: u64 = 32 << 20;

/// Unpacks what a writer called `zstd`, and compares its check sum at the end.
pub(super) struct Zstd<R: Read> {
    decoder: StreamingDecoder<R, FrameDecoder>,
    compare: bool,
}

/// Reads packed bytes as what they were.
pub(super) enum Unpacked<'a> {
    Zstd(Box<Zstd<io::Chain<&'a [u8], &'static [u8]>>>),
    Lz4(Lz4<'a>),
}

impl<'a> Unpacked<'a> {
    /// Nothing where the word is not known. Of a frame that is cut, the blocks that are whole are given.
    pub(super) fn new(word: &str, packed: &'a [u8]) -> Option<io::Result<Self>> {
        match word {
            "lz4" => Some(Lz4::new(packed).map(Self::Lz4)),
            "zstd" => Some(zstd(packed).map(|zstd| Self::Zstd(Box::new(zstd)))),
            _ => None,
        }
    }
}

impl Read for Unpacked<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Lz4(lz4) => lz4.read(to),
            Self::Zstd(zstd) => {
                let n = zstd.decoder.read(to)?;
                let decoder = &zstd.decoder.decoder;
                if n == 0 && zstd.compare && !to.is_empty() {
                    let stated = decoder.get_checksum_from_data();
                    if stated.is_some() && stated != decoder.get_calculated_checksum() {
                        return Err(io::Error::other(
                            "the check sum of a zstd frame does not hold",
                        ));
                    }
                }
                Ok(n)
            }
        }
    }
}

fn zstd(packed: &[u8]) -> io::Result<Zstd<io::Chain<&[u8], &'static [u8]>>> {
    let bad = || io::Error::other("no zstd frame");
    let frame = Frame::of(packed).ok_or_else(bad)?;
    if frame.window > WINDOW.max(16 * packed.len() as u64) {
        return Err(io::Error::other(
            "a zstd frame asks for more memory than its content can need",
        ));
    }
    // An empty last block, and room for a check sum, end a frame that is cut.
    let (bytes, end): (&[u8], &[u8]) = match frame.whole {
        true => (packed, &[]),
        false => (&packed[..frame.end], &[1, 0, 0, 0, 0, 0, 0]),
    };
    let decoder = StreamingDecoder::new(bytes.chain(end)).map_err(io::Error::other)?;
    Ok(Zstd {
        decoder,
        compare: frame.whole,
    })
}

/// What the heads of a zstd frame say (RFC 8878, 3.1.1).
struct Frame {
    window: u64,
    /// Behind the last block that is there.
    end: usize,
    whole: bool,
}

impl Frame {
    fn of(packed: &[u8]) -> Option<Self> {
        let mut b = Bytes::new(packed, Order::Little);
        if b.u32()? != 0xFD2F_B528 {
            return None;
        }
        let descriptor = b.u8()?;
        let single = descriptor & 32 != 0;
        let mut window = 0;
        if !single {
            let size = b.u8()?;
            let base = 1_u64 << (10 + (size >> 3));
            window = base + base / 8 * u64::from(size & 7);
        }
        b.take([0, 1, 2, 4][usize::from(descriptor & 3)])?;
        let content = match (descriptor >> 6, single) {
            (0, false) => 0,
            (0, true) => u64::from(b.u8()?),
            (1, _) => u64::from(b.u16()?) + 256,
            (2, _) => u64::from(b.u32()?),
            _ => b.u64()?,
        };
        if single {
            window = content;
        }
        loop {
            let end = packed.len() - b.rest().len();
            let block = |b: &mut Bytes<'_>| {
                let head = b.take(3)?;
                let head = u32::from_le_bytes([head[0], head[1], head[2], 0]);
                let length = match head >> 1 & 3 {
                    1 => 1,
                    _ => head as usize >> 3,
                };
                b.take(length)?;
                Some(head & 1 == 1)
            };
            let sum = if descriptor & 4 != 0 { 4 } else { 0 };
            match block(&mut b) {
                Some(false) => {}
                Some(true) => {
                    let whole = b.rest().len() >= sum;
                    return Some(Self { window, end, whole });
                }
                None => {
                    let whole = false;
                    return Some(Self { window, end, whole });
                }
            }
        }
    }
}
