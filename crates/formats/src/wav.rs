//! WAV: RIFF, its big-endian and its long form, by a walk over the chunks.
//!
//! Whole numbers come as they are stored, those of 8 bits less 128, so that zero is silence; a container that is wider than its
//! numbers holds them at its upper end. What full scale means in volts the file does not say.

use crate::bytes::{Bytes, Order};
use crate::raw::{Kind, Raw, bytes_at};
use crate::scaling::Scaling;
use crate::stream::{Clock, Column, Contents, Remark, SeekRead, Stream};
use crate::{Error, Result};

pub(crate) fn is_wav(head: &[u8]) -> bool {
    matches!(
        head,
        [b'R', b'I', b'F', b'F' | b'X', ..] | [b'R', b'F', b'6', b'4', ..]
    ) && head.get(8..12) == Some(b"WAVE")
}

/// Chunks before the samples that are walked over.
const MOST_CHUNKS: usize = 10_000;

/// What the format chunk says.
struct Samples {
    channels: u16,
    rate: u32,
    kind: Kind,
    /// Size of full scale of whole numbers.
    full_scale: Option<f64>,
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let head = bytes_at(file, 0, 12)?;
    let order = match head.get(3) {
        Some(b'X') => Order::Big,
        _ => Order::Little,
    };
    let long = head.starts_with(b"RF64");
    let mut remarks = Vec::new();
    let (mut samples, mut long_data, mut at) = (None, None, 12);
    for _ in 0..MOST_CHUNKS {
        // Enough for every chunk that is looked into.
        let chunk = bytes_at(file, at, 8 + 40)?;
        let (Some(name), Some(length)) = (chunk.get(..4), chunk.get(4..8)) else {
            return Err(Error::new("the WAV file ends before its samples")
                .with_hint("the recorder was stopped before it wrote any; measure again"));
        };
        let length = Bytes::new(length, order).u32().unwrap_or(0);
        let body = &chunk[8..];
        match name {
            b"ds64" if long => {
                let mut sizes = Bytes::new(body, order);
                sizes.u64();
                long_data = sizes.u64();
            }
            b"fmt " => samples = Some(format(body, length, order)?),
            b"data" => {
                let Some(samples) = samples else {
                    return Err(Error::new(
                        "the WAV file does not say the form of its samples",
                    ));
                };
                let claimed = match length {
                    u32::MAX if long => long_data,
                    // A recorder that was killed, or writes to a pipe, did not fill the size in.
                    0 | u32::MAX => None,
                    length => Some(u64::from(length)),
                };
                let there = size.saturating_sub(at + 8);
                if let Some(claimed) = claimed.filter(|c| *c > there) {
                    remarks.push(Remark::cut(format!(
                        "the samples end at byte {size}, {} bytes before the size that the file states",
                        claimed - there
                    )));
                } else if claimed.is_none() {
                    remarks.push(Remark::cut(format!(
                        "the file does not state the size of its samples: they are read up to its end at byte {size}"
                    )));
                }
                let bytes = claimed.unwrap_or(there).min(there);
                return Ok(Contents {
                    streams: vec![stream(&samples, order, at + 8, bytes)],
                    remarks,
                });
            }
            _ => {}
        }
        // Chunks begin at even bytes.
        at += 8 + u64::from(length) + u64::from(length & 1);
    }
    Err(Error::new(format!(
        "the first {MOST_CHUNKS} chunks of the WAV file hold no samples"
    )))
}

fn format(body: &[u8], length: u32, order: Order) -> Result<Samples> {
    let short = || Error::new("the WAV file says the form of its samples in too few bytes");
    let body = &body[..body.len().min(length as usize)];
    let mut b = Bytes::new(body, order);
    let mut form = b.u16().ok_or_else(short)?;
    let channels = b.u16().ok_or_else(short)?;
    let rate = b.u32().ok_or_else(short)?;
    b.u32();
    let frame = b.u16().ok_or_else(short)?;
    let bits = b.u16().ok_or_else(short)?;
    let mut valid = bits;
    if form == 0xFFFE {
        b.u16();
        valid = b.u16().ok_or_else(short)?;
        b.u32();
        form = b.u32().ok_or_else(short)? as u16;
        if valid == 0 || valid > bits {
            valid = bits;
        }
    }
    if channels == 0 || rate == 0 || frame == 0 || !frame.is_multiple_of(channels) {
        return Err(Error::new(format!(
            "the WAV file states {channels} channels at {rate} Hz in frames of {frame} bytes, which cannot be"
        )));
    }
    let width = frame / channels;
    let whole = match (form, width) {
        (1, 1) => Some(Kind::U8),
        (1, 2) => Some(Kind::I16),
        (1, 3) => Some(Kind::I24),
        (1, 4) => Some(Kind::I32),
        _ => None,
    };
    if let Some(kind) = whole
        && valid <= 8 * width
        && valid > 0
    {
        return Ok(Samples {
            channels,
            rate,
            kind,
            // Numbers lie at the upper end of what holds them.
            full_scale: Some(2_f64.powi(i32::from(8 * width) - 1)),
        });
    }
    let kind = match (form, width) {
        (3, 4) => Kind::F32,
        (3, 8) => Kind::F64,
        _ => {
            let name = match form {
                1 => "whole numbers of an unusual width",
                2 | 0x11 => "ADPCM",
                3 => "floats of an unusual width",
                6 => "A-law",
                7 => "µ-law",
                _ => "a compressed form",
            };
            return Err(Error::new(format!(
                "the samples of the WAV file are {name} (form {form}, {bits} bits), which is not read here"
            ))
            .with_hint("record linear samples (PCM) or floats: compressed ones are not those of the converter"));
        }
    };
    Ok(Samples {
        channels,
        rate,
        kind,
        full_scale: None,
    })
}

fn stream(samples: &Samples, order: Order, at: u64, bytes: u64) -> Stream {
    let width = samples.kind.size();
    let frame = width * u64::from(samples.channels);
    let rows = bytes / frame;
    let clock = Clock::Rate {
        hz: f64::from(samples.rate),
        start_s: 0.0,
    };
    let mut stream = Stream::new("samples", clock, rows);
    stream.full_scale = samples.full_scale;
    for i in 0..u64::from(samples.channels) {
        let mut column = Column::raw(Raw::at(samples.kind, order, at + i * width, frame, rows));
        if samples.kind == Kind::U8 {
            column.scaling = Scaling::linear(1.0, -128.0);
        }
        let unit = samples.full_scale.map(|_| "count".to_owned());
        stream.push(format!("channel {}", i + 1), unit, column);
    }
    // Nothing is declared: it is how 8 bits are stored.
    let channels = stream.channels.iter_mut();
    channels.for_each(|channel| channel.scaling = None);
    stream
}

#[cfg(test)]
mod tests;
