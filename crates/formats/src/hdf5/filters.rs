//! Chunks unpacked: the filters in reverse order, with their check sums.

use super::layout::Filter;
use crate::bytes::{Bytes, Order};
use flate2::{Decompress, FlushDecompress, Status};

/// The bytes of a chunk as they were before the filters, of which those with their bit set were left off; nothing where a check
/// sum does not hold or another number of bytes comes out.
pub(super) fn unpacked(
    filters: &[Filter],
    left_off: u32,
    stored: Vec<u8>,
    wanted: usize,
) -> Option<Vec<u8>> {
    let mut bytes = stored;
    for (i, filter) in filters.iter().enumerate().rev() {
        if applied(left_off, i) {
            bytes = match filter {
                Filter::Deflate => inflated(&bytes, wanted.checked_add(4)?)?,
                Filter::Lzf => unlzf(&bytes, wanted)?,
                Filter::Shuffle(width) => unshuffled(bytes, *width),
                Filter::Fletcher32 => summed(bytes)?,
            };
        }
    }
    (bytes.len() == wanted).then_some(bytes)
}

fn applied(left_off: u32, i: usize) -> bool {
    1_u32
        .checked_shl(i as u32)
        .is_none_or(|bit| left_off & bit == 0)
}

/// At most so many bytes; memory beyond a few MiB is asked for as they come out.
fn inflated(packed: &[u8], most: usize) -> Option<Vec<u8>> {
    const AT_ONCE: usize = 4 << 20;
    let usual = packed.len().saturating_mul(8).max(AT_ONCE);
    let mut out = Vec::with_capacity(most.min(usual));
    // With room for everything it comes out without a detour.
    let flush = match most <= usual {
        true => FlushDecompress::Finish,
        false => FlushDecompress::None,
    };
    let mut state = Decompress::new(true);
    loop {
        let before = (state.total_in(), out.len());
        let rest = packed.get(usize::try_from(before.0).ok()?..)?;
        let status = state.decompress_vec(rest, &mut out, flush).ok()?;
        let stuck = before == (state.total_in(), out.len());
        match status {
            Status::StreamEnd => return Some(out),
            _ if out.len() < out.capacity() && stuck => return None,
            _ if out.len() == out.capacity() && out.len() < most => {
                let more = out.len().min(most - out.len());
                out.reserve_exact(more);
            }
            _ if stuck => return None,
            _ => {}
        }
    }
}

/// Bytes packed by liblzf: as they are, or once more from further before.
///
/// **Source** `[LZF]`.
fn unlzf(packed: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut out: Vec<u8> = Vec::new();
    let mut b = Bytes::new(packed, Order::Little);
    while let Some(control) = b.u8() {
        let (high, low) = (usize::from(control >> 5), usize::from(control & 31));
        if high == 0 {
            out.extend(b.take(low + 1)?);
        } else {
            let length = if high == 7 {
                7 + usize::from(b.u8()?)
            } else {
                high
            } + 2;
            let back = (low << 8 | usize::from(b.u8()?)) + 1;
            let from = out.len().checked_sub(back)?;
            for i in from..from + length {
                out.push(out[i]);
            }
        }
        if out.len() > most {
            return None;
        }
    }
    Some(out)
}

fn unshuffled(bytes: Vec<u8>, width: usize) -> Vec<u8> {
    fn each<const N: usize>(bytes: &[u8], count: usize) -> Vec<u8> {
        let planes: [&[u8]; N] = std::array::from_fn(|j| &bytes[j * count..(j + 1) * count]);
        let mut out = vec![0; N * count];
        for (i, element) in out.as_chunks_mut::<N>().0.iter_mut().enumerate() {
            for (to, plane) in element.iter_mut().zip(&planes) {
                *to = plane[i];
            }
        }
        out
    }
    let count = bytes.len() / width.max(1);
    if width < 2 || count < 2 {
        return bytes;
    }
    let mut out = match width {
        2 => each::<2>(&bytes, count),
        4 => each::<4>(&bytes, count),
        8 => each::<8>(&bytes, count),
        _ => {
            let mut out = vec![0; width * count];
            for (j, plane) in bytes.chunks_exact(count).take(width).enumerate() {
                for (to, from) in out[j..].iter_mut().step_by(width).zip(plane) {
                    *to = *from;
                }
            }
            out
        }
    };
    // What is left over was not moved.
    out.extend(&bytes[width * count..]);
    out
}

/// The bytes before the check sum, where it holds.
fn summed(mut bytes: Vec<u8>) -> Option<Vec<u8>> {
    let content = bytes.len().checked_sub(4)?;
    let stated = u32::from_le_bytes(*bytes.last_chunk()?);
    let sum = fletcher32(&bytes[..content]);
    // Files of before version 1.6.3 have the bytes of each half the other way round.
    let older = (sum & 0x00FF_00FF) << 8 | (sum >> 8 & 0x00FF_00FF);
    bytes.truncate(content);
    (stated == sum || stated == older).then_some(bytes)
}

/// Fletcher's sum of words of two bytes, the more significant first.
fn fletcher32(bytes: &[u8]) -> u32 {
    let (mut one, mut two) = (0_u32, 0_u32);
    let fold = |sum: u32| (sum & 0xFFFF) + (sum >> 16);
    let (words, odd) = bytes.as_chunks::<2>();
    // As many additions as cannot overflow.
    for part in words.chunks(360) {
        for word in part {
            one += u32::from(u16::from_be_bytes(*word));
            two += one;
        }
        (one, two) = (fold(one), fold(two));
    }
    if let [last] = odd {
        one += u32::from(*last) << 8;
        two += one;
        (one, two) = (fold(one), fold(two));
    }
    fold(two) << 16 | fold(one)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_fletcher_sums() {
        // F04FC729 and 56502D2A for words with the less significant byte first.
        assert_eq!(fletcher32(b"abcde"), 0x4FF0_29C7);
        assert_eq!(fletcher32(b"abcdef"), 0x5056_2A2D);
    }

    #[test]
    fn known_bytes_in_their_places() {
        for width in [2, 3, 4, 8] {
            let bytes: Vec<u8> = (0..width as u8 * 5 + 1).collect();
            let sorted: Vec<u8> = (0..width)
                .flat_map(|j| (0..5).map(move |i| i * width + j))
                .chain([width * 5])
                .map(|i| bytes[i])
                .collect();
            assert_eq!(unshuffled(sorted, width), bytes);
        }
    }
}
