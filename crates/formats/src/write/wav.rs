//! WAV: RIFF, or its long form (RF64) beyond four gibibytes.

use crate::{Error, Result};

/// How the samples of a WAV file are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WavForm {
    /// Whole numbers of 16 bits.
    Int16,
    /// Whole numbers of 24 bits.
    Int24,
    /// Whole numbers of 32 bits.
    Int32,
    /// Single precision.
    Float32,
    /// Double precision.
    Float64,
}

impl WavForm {
    /// Bytes of a sample.
    pub fn size(self) -> u64 {
        match self {
            Self::Int16 => 2,
            Self::Int24 => 3,
            Self::Int32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    /// Whether it holds whole numbers alone.
    pub fn is_whole(self) -> bool {
        matches!(self, Self::Int16 | Self::Int24 | Self::Int32)
    }

    /// The number as it is read again; `None` where a form of whole numbers cannot hold it.
    pub fn stored(self, number: f64) -> Option<f64> {
        let most = 2_f64.powi(8 * self.size() as i32 - 1);
        match self {
            Self::Float32 => Some(f64::from(number as f32)),
            Self::Float64 => Some(number),
            _ => (number.fract() == 0.0 && (-most..most).contains(&number)).then_some(number),
        }
    }

    /// Appends a sample that the form can hold.
    pub fn put(self, number: f64, to: &mut Vec<u8>) {
        match self {
            Self::Float32 => to.extend((number as f32).to_le_bytes()),
            Self::Float64 => to.extend(number.to_le_bytes()),
            _ => to.extend(&(number as i32).to_le_bytes()[..self.size() as usize]),
        }
    }
}

/// What stands before `rows` samples of each of so many channels, side by side.
///
/// # Errors
/// No channel, or more than a WAV file can state.
pub fn wav_head(form: WavForm, channels: usize, rate: u32, rows: u64) -> Result<Vec<u8>> {
    let frame = form.size() * channels as u64;
    let (Ok(channels), Ok(frame)) = (u16::try_from(channels), u16::try_from(frame)) else {
        return Err(Error::new(format!(
            "a WAV file cannot state {channels} channels"
        )));
    };
    let bytes = rows.saturating_mul(u64::from(frame));
    let whole = form.is_whole();
    let mut format = Vec::new();
    format.extend(if whole { 1_u16 } else { 3 }.to_le_bytes());
    format.extend(channels.to_le_bytes());
    format.extend(rate.to_le_bytes());
    format.extend(rate.saturating_mul(u32::from(frame)).to_le_bytes());
    format.extend(frame.to_le_bytes());
    format.extend((8 * form.size() as u16).to_le_bytes());
    if !whole {
        format.extend(0_u16.to_le_bytes());
    }
    let mut chunks = Vec::new();
    chunk(&mut chunks, b"fmt ", &format);
    if !whole {
        let count = u32::try_from(rows).unwrap_or(u32::MAX);
        chunk(&mut chunks, b"fact", &count.to_le_bytes());
    }
    let after = bytes + (bytes & 1);
    let size = 4 + chunks.len() as u64 + 8 + after;
    let short = u32::try_from(size).ok().zip(u32::try_from(bytes).ok());
    let mut head = Vec::new();
    match short {
        Some((size, _)) => {
            head.extend(b"RIFF");
            head.extend(size.to_le_bytes());
            head.extend(b"WAVE");
        }
        None => {
            head.extend(b"RF64\xFF\xFF\xFF\xFFWAVE");
            let sizes = [size + 36, bytes, rows].map(u64::to_le_bytes).concat();
            chunk(&mut head, b"ds64", &[&sizes[..], &[0; 4]].concat());
        }
    }
    head.extend(chunks);
    head.extend(b"data");
    head.extend(short.map_or(u32::MAX, |(_, bytes)| bytes).to_le_bytes());
    Ok(head)
}

fn chunk(to: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    to.extend(name);
    to.extend((content.len() as u32).to_le_bytes());
    to.extend(content);
}
