//! Numbers that lie in a file at a steady distance.

use crate::Result;
use crate::bytes::Order;
use crate::hdf5::Unpacked;
use crate::stream::SeekRead;
use std::io::{Read, SeekFrom};
use std::sync::Arc;

/// Form of one stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    U8,
    I8,
    U16,
    I16,
    I24,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
    /// One bit of a byte.
    Bit(u8),
    /// Three hexadecimal digits: 12 bits with a sign.
    Hex,
    /// Of three hexadecimal digits so many bits from one on, without a sign.
    HexBits(u8, u8),
    /// One of three numbers of 10 bits that are shifted left by the two bits above them.
    Packed(u8),
}

impl Kind {
    pub(crate) fn size(self) -> u64 {
        match self {
            Self::U8 | Self::I8 | Self::Bit(_) => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::I24 | Self::Hex | Self::HexBits(..) => 3,
            Self::U32 | Self::I32 | Self::F32 | Self::Packed(_) => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// Numbers at a steady distance, and the same again some bytes further on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    /// Byte of the first number.
    pub(crate) at: u64,
    /// Bytes from one number to the next.
    pub(crate) stride: u64,
    /// Numbers in a chunk.
    pub(crate) count: u64,
    /// Chunks.
    pub(crate) chunks: u64,
    /// Bytes from one chunk to the next.
    pub(crate) step: u64,
}

/// Stored numbers of one channel.
#[derive(Clone, Debug)]
pub(crate) struct Raw {
    pub(crate) kind: Kind,
    pub(crate) order: Order,
    /// Shared by channels that stand side by side.
    pub(crate) extents: Arc<Vec<Extent>>,
    /// Bytes from there on.
    shift: u64,
    place: Place,
}

/// How far reading has come.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    extent: usize,
    chunk: u64,
    number: u64,
}

impl Raw {
    pub(crate) fn new(kind: Kind, order: Order) -> Self {
        Self {
            kind,
            order,
            extents: Arc::default(),
            shift: 0,
            place: Place::default(),
        }
    }

    /// Numbers side by side from a byte on.
    pub(crate) fn at(kind: Kind, order: Order, at: u64, stride: u64, count: u64) -> Self {
        let mut raw = Self::new(kind, order);
        raw.push(Extent {
            at,
            stride,
            count,
            chunks: 1,
            step: 0,
        });
        raw
    }

    /// Numbers so many bytes behind these places, which are shared.
    pub(crate) fn behind(extents: &Arc<Vec<Extent>>, kind: Kind, order: Order, shift: u64) -> Self {
        Self {
            extents: extents.clone(),
            shift,
            ..Self::new(kind, order)
        }
    }

    pub(crate) fn push(&mut self, extent: Extent) {
        if extent.count > 0 && extent.chunks > 0 {
            Arc::make_mut(&mut self.extents).push(extent);
        }
    }

    /// As many numbers in a block of so many bytes, at the same place as in the block before where there is one.
    pub(crate) fn push_block(&mut self, at: u64, stride: u64, count: u64, step: u64) {
        if let Some(last) = Arc::make_mut(&mut self.extents).last_mut()
            && (last.count, last.stride, last.step) == (count, stride, step)
            && last.at + last.chunks * step == at
        {
            last.chunks += 1;
            return;
        }
        self.push(Extent {
            at,
            stride,
            count,
            chunks: 1,
            step,
        });
    }

    pub(crate) fn rows(&self) -> u64 {
        let each = self.extents.iter();
        each.fold(0, |sum, e| {
            sum.saturating_add(e.count.saturating_mul(e.chunks))
        })
    }

    /// Back to the first number.
    pub(crate) fn rewind(&mut self) {
        self.place = Place::default();
    }

    /// Longest distance between two numbers.
    pub(crate) fn stride(&self) -> u64 {
        self.extents.iter().map(|e| e.stride).max().unwrap_or(1)
    }

    /// Bytes around the next `n` numbers that their neighbours, and those that are wanted behind them, may need.
    fn around(&self, extent: &Extent, n: u64, wanted: u64) -> (u64, u64) {
        let stride = extent.stride;
        if extent.chunks == 1 || extent.step > SHORT {
            return (stride, stride);
        }
        let more = (extent.chunks - self.place.chunk - 1).min((wanted - n).div_ceil(extent.count));
        let ahead = (more * extent.step).min(AT_ONCE / 2);
        // A neighbour begins again with the rest of the chunk before.
        (stride + extent.step, stride + ahead)
    }

    /// Appends the next numbers, at most so many; fewer at the end only.
    pub(crate) fn read(
        &mut self,
        window: &mut Window,
        file: &mut dyn SeekRead,
        most: usize,
        to: &mut Vec<f64>,
    ) -> Result<()> {
        let mut wanted = most as u64;
        while wanted > 0 {
            let Some(extent) = self.extents.get(self.place.extent).copied() else {
                break;
            };
            let n = wanted.min(extent.count - self.place.number);
            let at = self.shift
                + extent.at
                + self.place.chunk * extent.step
                + self.place.number * extent.stride;
            let length = (n - 1) * extent.stride + self.kind.size();
            let around = self.around(&extent, n, wanted);
            let bytes = window.get_around(file, at, length, around)?;
            numbers(self.kind, self.order, bytes, extent.stride as usize, to);
            wanted -= n;
            self.place.number += n;
            if self.place.number == extent.count {
                self.place.number = 0;
                self.place.chunk += 1;
            }
            if self.place.chunk == extent.chunks {
                self.place.chunk = 0;
                self.place.extent += 1;
            }
        }
        Ok(())
    }
}

/// Appends the numbers that stand in bytes at a steady distance.
pub(crate) fn numbers(kind: Kind, order: Order, bytes: &[u8], stride: usize, to: &mut Vec<f64>) {
    fn each<const N: usize>(
        bytes: &[u8],
        stride: usize,
        to: &mut Vec<f64>,
        of: impl Fn([u8; N]) -> f64,
    ) {
        let side_by_side = bytes.as_chunks::<N>().0;
        match (stride / N, stride % N) {
            (1, 0) => to.extend(side_by_side.iter().map(|b| of(*b))),
            (2, 0) => every::<N, 2>(side_by_side, to, of),
            (3, 0) => every::<N, 3>(side_by_side, to, of),
            (4, 0) => every::<N, 4>(side_by_side, to, of),
            (6, 0) => every::<N, 6>(side_by_side, to, of),
            _ => {
                // A length that is known beforehand: the room is looked for once.
                let frames = bytes.chunks(stride.max(1));
                to.extend(frames.map(|f| f.first_chunk::<N>().map_or(0.0, |b| of(*b))));
            }
        }
    }
    /// The first of each so many numbers.
    fn every<const N: usize, const M: usize>(
        bytes: &[[u8; N]],
        to: &mut Vec<f64>,
        of: impl Fn([u8; N]) -> f64,
    ) {
        let (frames, last) = bytes.as_chunks::<M>();
        to.extend(frames.iter().map(|f| of(f[0])));
        to.extend(last.first().map(|b| of(*b)));
    }
    macro_rules! of {
        ($type:ty) => {
            match order {
                Order::Little => each(bytes, stride, to, |b| <$type>::from_le_bytes(b) as f64),
                Order::Big => each(bytes, stride, to, |b| <$type>::from_be_bytes(b) as f64),
            }
        };
    }
    match kind {
        Kind::U8 => of!(u8),
        Kind::I8 => of!(i8),
        Kind::U16 => of!(u16),
        Kind::I16 => of!(i16),
        Kind::U32 => of!(u32),
        Kind::I32 => of!(i32),
        Kind::U64 => of!(u64),
        Kind::I64 => of!(i64),
        Kind::F16 => each(bytes, stride, to, |b: [u8; 2]| match order {
            Order::Little => half(u16::from_le_bytes(b)),
            Order::Big => half(u16::from_be_bytes(b)),
        }),
        Kind::F32 => of!(f32),
        Kind::F64 => of!(f64),
        Kind::Bit(bit) => each(bytes, stride, to, |[b]: [u8; 1]| {
            f64::from(b >> (bit & 7) & 1)
        }),
        Kind::Packed(axis) => each(bytes, stride, to, |b: [u8; 4]| {
            let word = u32::from_le_bytes(b);
            let ten = (word >> (10 * u32::from(axis.min(2)))) << 22;
            f64::from((ten as i32 >> 22) << (word >> 30))
        }),
        Kind::Hex => each(bytes, stride, to, |b: [u8; 3]| {
            f64::from((i32::from(digits(b)) << 20) >> 20)
        }),
        Kind::HexBits(from, count) => each(bytes, stride, to, |b: [u8; 3]| {
            f64::from(digits(b) >> from & ((1 << count) - 1))
        }),
        Kind::I24 => each(bytes, stride, to, |b: [u8; 3]| {
            f64::from((three(b, order) << 8) as i32 >> 8)
        }),
    }
}

/// A float of 16 bits.
fn half(bits: u16) -> f64 {
    let (exponent, mantissa) = (u64::from(bits >> 10 & 31), u64::from(bits & 1023));
    let size = match exponent {
        0 => mantissa as f64 / f64::from(1 << 24),
        31 => f64::from_bits(2047 << 52 | mantissa << 42),
        exponent => f64::from_bits((exponent + 1008) << 52 | mantissa << 42),
    };
    size.copysign(if bits >> 15 == 1 { -1.0 } else { 1.0 })
}

/// The number of hexadecimal digits; the reader has looked that they are some.
fn digits(b: [u8; 3]) -> u16 {
    let digit = |b: u8| char::from(b).to_digit(16).unwrap_or(0) as u16;
    digit(b[0]) << 8 | digit(b[1]) << 4 | digit(b[2])
}

fn three(b: [u8; 3], order: Order) -> u32 {
    match order {
        Order::Little => u32::from_le_bytes([b[0], b[1], b[2], 0]),
        Order::Big => u32::from_be_bytes([0, b[0], b[1], b[2]]),
    }
}

/// A stretch of the file that is held, so that channels side by side are fetched once.
#[derive(Debug, Default)]
pub(crate) struct Window {
    start: u64,
    bytes: Vec<u8>,
    /// Beside it the chunks that had to be unpacked.
    pub(crate) unpacked: Unpacked,
}

impl Window {
    /// So many bytes from a place on, with as much around them as a neighbour may need.
    pub(crate) fn get(
        &mut self,
        file: &mut dyn SeekRead,
        at: u64,
        length: u64,
        around: u64,
    ) -> Result<&[u8]> {
        self.get_around(file, at, length, (around, around))
    }

    /// The same with so many bytes before and behind them.
    fn get_around(
        &mut self,
        file: &mut dyn SeekRead,
        at: u64,
        length: u64,
        (before, behind): (u64, u64),
    ) -> Result<&[u8]> {
        let held = |w: &Self| at >= w.start && at + length <= w.start + w.bytes.len() as u64;
        if !held(self) {
            self.start = at.saturating_sub(before);
            let wanted = at - self.start + length + behind;
            file.seek(SeekFrom::Start(self.start))?;
            match wanted {
                0..=AT_ONCE => {
                    self.bytes.resize(wanted as usize, 0);
                    let there = filled(file, &mut self.bytes)?;
                    self.bytes.truncate(there);
                }
                _ => {
                    self.bytes.clear();
                    file.take(wanted).read_to_end(&mut self.bytes)?;
                }
            }
            if !held(self) {
                return Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof).into());
            }
        }
        let from = (at - self.start) as usize;
        Ok(&self.bytes[from..from + length as usize])
    }
}

/// Bytes from one chunk to the next, so few that what lies between is read as well.
const SHORT: u64 = 1 << 14;
/// Bytes for which room is made before it is known whether they are there.
const AT_ONCE: u64 = 2 << 20;

/// Fills as much as is there, and says how much that is.
pub(crate) fn filled(file: &mut dyn SeekRead, to: &mut [u8]) -> Result<usize> {
    let mut there = 0;
    while there < to.len() {
        match file.read(&mut to[there..]) {
            Ok(0) => break,
            Ok(n) => there += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e.into()),
        }
    }
    Ok(there)
}

/// Bytes of a file from a place on, at most so many.
pub(crate) fn bytes_at(file: &mut dyn SeekRead, at: u64, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(at))?;
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn known_numbers_at_every_distance() {
        let bytes: Vec<u8> = (0..100).collect();
        let at = |i: usize| f64::from(i16::from_le_bytes([bytes[i], bytes[i + 1]]));
        for stride in 2..=14 {
            for count in 1..=7 {
                let mut found = Vec::new();
                let held = &bytes[..(count - 1) * stride + 2];
                numbers(Kind::I16, Order::Little, held, stride, &mut found);
                let wanted: Vec<f64> = (0..count).map(|i| at(i * stride)).collect();
                assert_eq!(found, wanted, "{stride} {count}");
            }
        }
    }

    /// Two neighbours in chunks of three, the last of which ends with the file, in blocks of every length.
    #[test]
    fn known_numbers_of_short_chunks() {
        let bytes: Vec<u8> = (0..57).collect();
        let raw = |at: u64| {
            let mut raw = Raw::new(Kind::U8, Order::Little);
            raw.push(Extent {
                at,
                stride: 2,
                count: 3,
                chunks: 6,
                step: 10,
            });
            raw
        };
        let wanted = |at: usize| -> Vec<f64> {
            let places = (0..6).flat_map(|chunk| (0..3).map(move |i| at + 10 * chunk + 2 * i));
            places.map(|i| f64::from(bytes[i])).collect()
        };
        for most in 1..=19 {
            let mut file = Cursor::new(bytes.clone());
            let (mut window, mut raws) = (Window::default(), [raw(1), raw(2)]);
            let mut found = [Vec::new(), Vec::new()];
            for _ in 0..18_usize.div_ceil(most) {
                for (raw, to) in raws.iter_mut().zip(&mut found) {
                    raw.read(&mut window, &mut file, most, to).unwrap();
                }
            }
            assert_eq!(found, [wanted(1), wanted(2)], "{most}");
        }
    }
}
